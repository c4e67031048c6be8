//! The camera's axes, and the intervals of the sampled plants.

use core::time::Duration;

use barrelman_sim::MountPlant;
use barrelman_sim::camera_axis::{AxisImperfections, AxisPlant};
use barrelman_sim::scenario::{AxisRanges, PlantRanges};
use barrelman_vocab::{Angle, AngularRate, ZoomDynamics, ZoomRate};

use crate::scenario::ScenarioError;
use crate::scenario::file::{AxisSection, SampledAxisSection, SampledSection, ScenarioFile, ZoomSection};
use crate::scenario::range::within;

/// The nominal axes.
pub(super) fn mount(file: &ScenarioFile, latency_s: f64) -> Result<MountPlant, ScenarioError> {
    Ok(MountPlant {
        pan: axis("pan", &file.pan, latency_s)?,
        tilt: axis("tilt", &file.tilt, latency_s)?,
        cross_talk: 0.0,
        droop_rad_per_s: 0.0,
        zoom: file.camera.zoom.as_ref().map(|zoom| zoom_of(zoom, latency_s)).transpose()?,
    })
}

fn zoom_of(section: &ZoomSection, latency_s: f64) -> Result<ZoomDynamics, ScenarioError> {
    let max_rate = within("camera.zoom.limit_per_s", section.limit_per_s, 0.01, 10.0, "per second")?;
    let dead_s = within("camera.zoom.dead_time_s", section.dead_time_s, 0.0, 5.0, "seconds")?;
    let dead_s = without_latency("camera.zoom.dead_time_s", dead_s, latency_s)?;
    Ok(ZoomDynamics {
        ratio: within("camera.zoom.ratio", section.ratio, 1.01, 100.0, "a ratio")?,
        max_rate: ZoomRate::from_per_second(max_rate),
        dead_time: Duration::from_secs_f64(dead_s),
    })
}

fn axis(name: &str, section: &AxisSection, latency_s: f64) -> Result<AxisPlant, ScenarioError> {
    let dead = |key: &str, value: f64| {
        let key = format!("{name}.{key}");
        let value = within(&key, value, 0.0, 5.0, "seconds")?;
        without_latency(&key, value, latency_s)
    };
    let stops = match section.stops_deg {
        None => None,
        Some([low, high]) if low < high && low >= -180.0 && high <= 180.0 => {
            Some((Angle::from_degrees(low), Angle::from_degrees(high)))
        }
        Some(_) => {
            return Err(ScenarioError::invalid(
                format!("{name}.stops_deg"),
                "use two angles from -180 to 180, the lower first",
            ));
        }
    };
    let limit = within(&format!("{name}.limit_rad_per_s"), section.limit_rad_per_s, 0.001, 10.0, "rad/s")?;
    Ok(AxisPlant {
        start_dead_time_s: dead("start_dead_time_s", section.start_dead_time_s)?,
        stop_dead_time_s: dead("stop_dead_time_s", section.stop_dead_time_s)?,
        lag_s: within(&format!("{name}.lag_s"), section.lag_s, 0.0, 5.0, "seconds")?,
        max_rate: AngularRate::from_radians_per_second(limit),
        end_stops: stops,
        imperfections: AxisImperfections {
            max_acceleration_rad_per_s2: section
                .acceleration_rad_per_s2
                .map(|limit| within(&format!("{name}.acceleration_rad_per_s2"), limit, 0.01, 100.0, "rad/s²"))
                .transpose()?,
            dead_band_rad_per_s: within(
                &format!("{name}.dead_band_rad_per_s"),
                section.dead_band_rad_per_s,
                0.0,
                1.0,
                "rad/s",
            )?,
            gain: 1.0,
        },
    })
}

/// The dead time of the axis: the dead time seen in the picture, without the latency of the camera.
fn without_latency(key: &str, value: f64, latency_s: f64) -> Result<f64, ScenarioError> {
    if value < latency_s {
        return Err(ScenarioError::invalid(
            key,
            format!("{value} s is less than camera.latency_s, {latency_s} s, which is part of it"),
        ));
    }
    Ok(value - latency_s)
}

/// The intervals from which the plant of a trial is sampled.
pub(super) fn ranges(section: &SampledSection, latency_s: f64) -> Result<PlantRanges, ScenarioError> {
    let interval = |key: String, [low, high]: [f64; 2], min: f64, max: f64| {
        if low <= high && low >= min && high <= max {
            Ok((low, high))
        } else {
            Err(ScenarioError::invalid(
                key,
                format!("{low} to {high}: use two numbers from {min} to {max}, the lower first"),
            ))
        }
    };
    let axis = |name: &str, section: &SampledAxisSection| {
        let dead = |key: &str, bounds: [f64; 2]| {
            let key = format!("drawn.{name}.{key}");
            let (low, high) = interval(key.clone(), bounds, 0.0, 5.0)?;
            Ok::<_, ScenarioError>((
                without_latency(&key, low, latency_s)?,
                without_latency(&key, high, latency_s)?,
            ))
        };
        Ok::<_, ScenarioError>(AxisRanges {
            start_dead_time_s: dead("start_dead_time_s", section.start_dead_time_s)?,
            stop_dead_time_s: dead("stop_dead_time_s", section.stop_dead_time_s)?,
            lag_s: interval(format!("drawn.{name}.lag_s"), section.lag_s, 0.0, 5.0)?,
            gain: section
                .gain
                .map_or(Ok((1.0, 1.0)), |gain| interval(format!("drawn.{name}.gain"), gain, 0.1, 10.0))?,
        })
    };
    Ok(PlantRanges {
        focal_px: interval("drawn.focal_px".to_owned(), section.focal_px, 10.0, 100_000.0)?,
        pan: axis("pan", &section.pan)?,
        tilt: axis("tilt", &section.tilt)?,
        cross_talk: section
            .cross_talk
            .map_or(Ok((0.0, 0.0)), |bounds| interval("drawn.cross_talk".to_owned(), bounds, -1.0, 1.0))?,
        droop_rad_per_s: section
            .droop_deg_per_s
            .map_or(Ok((0.0, 0.0)), |bounds| {
                interval("drawn.droop_deg_per_s".to_owned(), bounds, -10.0, 10.0)
            })
            .map(|(low, high)| (low.to_radians(), high.to_radians()))?,
    })
}
