//! The camera's part of a configuration file: how it answers.

use core::time::Duration;

use anyhow::{Result, bail};
use barrelman_vocab::profile::{AxisDynamics, CameraDynamics};
use barrelman_vocab::{Angle, AngularRate};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::range::within;

/// How the camera answers a command and what it sees. A law that predicts goes by it,
/// and under every law the tracker is told by it how far the camera's turning shifted the picture.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CameraSection {
    /// Focal length as a share of the picture's width, 0.1 to 20.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_share: Option<f64>,
    /// The camera's elevation at the start, radians, where no telemetry tells; negative looks down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_tilt_rad: Option<f64>,
    /// The lower end stop of that elevation, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lowest_tilt_rad: Option<f64>,
    /// The upper one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub highest_tilt_rad: Option<f64>,
    /// The axis that pans.
    pub pan: AxisSection,
    /// The axis that tilts.
    pub tilt: AxisSection,
}

/// How an axis answers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AxisSection {
    /// From a command that moves to the start of its effect, without the video's latency, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_dead_time_s: Option<f64>,
    /// From a zero to the start of its effect, seconds; not less than that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_dead_time_s: Option<f64>,
    /// Time constant of the rate after that, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<f64>,
    /// The least rate other than zero that it turns at, rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_rad_per_s: Option<f64>,
}

impl CameraSection {
    /// The section with nothing left out.
    pub fn of(camera: &CameraDynamics) -> Self {
        let axis = |axis: &AxisDynamics| AxisSection {
            start_dead_time_s: Some(axis.start_dead_time.as_secs_f64()),
            stop_dead_time_s: Some(axis.stop_dead_time.as_secs_f64()),
            lag_s: Some(axis.lag.as_secs_f64()),
            least_rad_per_s: Some(axis.min_rate.radians_per_second()),
        };
        Self {
            focal_share: Some(camera.focal_share),
            first_tilt_rad: Some(camera.initial_tilt.radians()),
            lowest_tilt_rad: Some(camera.tilt_stops.0.radians()),
            highest_tilt_rad: Some(camera.tilt_stops.1.radians()),
            pan: axis(&camera.pan),
            tilt: axis(&camera.tilt),
        }
    }

    /// A vehicle's camera with what the section says otherwise.
    ///
    /// # Errors
    /// If a value lies outside of its range; the message names the key and the range.
    pub fn over(&self, base: &CameraDynamics) -> Result<CameraDynamics> {
        let tilt = |key: &str, value: Option<f64>, base: Angle| {
            within(key, value, base.radians(), -1.571, 1.571, "radians").map(Angle::from_radians)
        };
        let stops = (
            tilt("camera.lowest_tilt_rad", self.lowest_tilt_rad, base.tilt_stops.0)?,
            tilt("camera.highest_tilt_rad", self.highest_tilt_rad, base.tilt_stops.1)?,
        );
        if stops.0.radians() >= stops.1.radians() {
            bail!("camera.lowest_tilt_rad is not below camera.highest_tilt_rad: exchange or correct them");
        }
        Ok(CameraDynamics {
            focal_share: within(
                "camera.focal_share",
                self.focal_share,
                base.focal_share,
                0.1,
                20.0,
                "a share of the picture's width",
            )?,
            initial_tilt: tilt("camera.first_tilt_rad", self.first_tilt_rad, base.initial_tilt)?,
            tilt_stops: stops,
            pan: self.pan.over("camera.pan", &base.pan)?,
            tilt: self.tilt.over("camera.tilt", &base.tilt)?,
        })
    }
}

impl AxisSection {
    fn over(&self, section: &str, base: &AxisDynamics) -> Result<AxisDynamics> {
        let span = |key: &str, value: Option<f64>, base: Duration| {
            let key = format!("{section}.{key}");
            within(&key, value, base.as_secs_f64(), 0.0, 2.0, "seconds").map(Duration::from_secs_f64)
        };
        let least = self.least_rad_per_s;
        let base_least = base.min_rate.radians_per_second();
        let axis = AxisDynamics {
            start_dead_time: span("start_dead_time_s", self.start_dead_time_s, base.start_dead_time)?,
            stop_dead_time: span("stop_dead_time_s", self.stop_dead_time_s, base.stop_dead_time)?,
            lag: span("lag_s", self.lag_s, base.lag)?,
            min_rate: AngularRate::from_radians_per_second(within(
                &format!("{section}.least_rad_per_s"),
                least,
                base_least,
                0.0,
                1.0,
                "rad/s",
            )?),
        };
        if axis.stop_dead_time < axis.start_dead_time {
            bail!("{section}.stop_dead_time_s is less than {section}.start_dead_time_s: correct one of them");
        }
        Ok(axis)
    }
}
