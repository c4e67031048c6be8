//! Converts a scenario file to the simulator's [`Scenario`] and checks that every value lies in its range.

mod axes;
mod camera;
mod objects;
mod target;

use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_sim::scenario::{BeyondBorder, Platform, Scenario, SensorModel, Water};
use barrelman_sim::sea::{SeaState, Wind};
use barrelman_sim::snapshot::Light;
use barrelman_sim::sway::Sway;

use super::error::ScenarioError;
use super::file::{LightSection, ScenarioFile, SensingSection, SwaySection, WaterSection};
use super::loaded::{LoadedScenario, ScenarioOverrides};
use super::range::{angle_within, within};
use crate::toml_message::message_of;

/// Reads a scenario from the text of its file.
///
/// # Errors
/// If the text is not a scenario, or a value lies outside its range.
pub fn read(text: &str, overrides: &ScenarioOverrides) -> Result<LoadedScenario, ScenarioError> {
    let file: ScenarioFile =
        toml::from_str(text).map_err(|error| ScenarioError::Syntax(message_of(&error)))?;
    let (scenario, setting) = resolve(&file, overrides)?;
    let hash = xxhash_rust::xxh3::xxh3_64(text.as_bytes());
    Ok(LoadedScenario { scenario, setting, text: text.to_owned(), hash })
}

fn resolve(file: &ScenarioFile, overrides: &ScenarioOverrides) -> Result<(Scenario, String), ScenarioError> {
    if file.name.is_empty() || !file.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
        return Err(ScenarioError::invalid(
            "name",
            "use letters, digits, - and _ only: it becomes part of file names",
        ));
    }
    let camera = camera::camera(&file.camera, overrides)?;
    let latency_s = camera.video.latency_s;
    let (setting, platform) = platform(file, overrides)?;
    let water = water(file.water.as_ref(), overrides)?;
    let target = target::target(file, overrides)?;
    let scenario = Scenario {
        name: file.name.clone(),
        mount: axes::mount(file, latency_s)?,
        ranges: axes::ranges(&file.drawn, latency_s)?,
        camera,
        platform,
        water,
        light: light(&file.light)?,
        objects: objects::objects(file, &target)?,
        target,
        sensing: sensing(&file.sensing)?,
        max_s: within("longest_s", file.longest_s, 1.0, 3600.0, "seconds")?,
    };
    Ok((scenario, setting))
}

/// The carrier of the camera, chosen by the name of a setting: that of `overrides`, else the file's own.
/// Returns the name too.
fn platform(file: &ScenarioFile, overrides: &ScenarioOverrides) -> Result<(String, Platform), ScenarioError> {
    let name = overrides.setting.as_ref().unwrap_or(&file.setting);
    let platform = match (file.sway.get(name), file.kite.get(name)) {
        (Some(section), None) => Platform::Swaying(sway(name, section)?),
        (None, Some(section)) if file.water.is_some() => Platform::Kite {
            gustiness: within(&format!("kite.{name}.gustiness"), section.gustiness, 0.0, 10.0, "a factor")?,
        },
        (None, Some(_)) => return Err(ScenarioError::invalid("kite", "a kite in the wind needs [water]")),
        (Some(_), Some(_)) => {
            return Err(ScenarioError::invalid(format!("kite.{name}"), "there is a sway of that name too"));
        }
        (None, None) => {
            let names: Vec<&str> = file.sway.keys().chain(file.kite.keys()).map(String::as_str).collect();
            return Err(ScenarioError::invalid(
                "setting",
                format!("{} has no setting {name:?}: use one of {}", file.name, names.join(", ")),
            ));
        }
    };
    Ok((name.clone(), platform))
}

fn sway(name: &str, section: &SwaySection) -> Result<Sway, ScenarioError> {
    let process = |what: &str, unit: &str, std_dev: f64, max: f64, time_s: f64| {
        let std_dev = within(&format!("sway.{name}.{what}_{unit}"), std_dev, 0.0, max, unit)?;
        let time_constant_s = within(&format!("sway.{name}.{what}_time_s"), time_s, 0.01, 1000.0, "seconds")?;
        Ok::<_, ScenarioError>(OrnsteinUhlenbeck { std_dev, time_constant_s })
    };
    let rotation = |what: &str, std_dev_deg: f64, time_s: f64| {
        let process = process(what, "deg", std_dev_deg, 45.0, time_s)?;
        Ok::<_, ScenarioError>(OrnsteinUhlenbeck { std_dev: process.std_dev.to_radians(), ..process })
    };
    Ok(Sway {
        yaw: rotation("yaw", section.yaw_deg, section.yaw_time_s)?,
        pitch: rotation("pitch", section.pitch_deg, section.pitch_time_s)?,
        roll: rotation("roll", section.roll_deg, section.roll_time_s)?,
        position: process("place", "m", section.place_m, 50.0, section.place_time_s)?,
    })
}

fn water(
    section: Option<&WaterSection>,
    overrides: &ScenarioOverrides,
) -> Result<Option<Water>, ScenarioError> {
    let Some(section) = section else {
        if overrides.sea_state.is_some()
            || overrides.wind_m_per_s.is_some()
            || overrides.current_m_per_s.is_some()
        {
            return Err(ScenarioError::invalid(
                "water",
                "there is no water in this scenario: it has no sea, no wind and no current",
            ));
        }
        return Ok(None);
    };
    let number = overrides.sea_state.unwrap_or(section.sea_state);
    let Some(state) = SeaState::new(number) else {
        return Err(ScenarioError::invalid(
            "water.sea_state",
            format!("{number}: use 0 (glassy) to 4 (moderate); rougher seas are not simulated"),
        ));
    };
    let current = |value: f64| within("water.current_m_per_s", value, -5.0, 5.0, "m/s");
    let wind = overrides.wind_m_per_s.or(section.wind_m_per_s).unwrap_or_else(|| state.wind_mps());
    Ok(Some(Water {
        state,
        wind: Wind {
            speed_mps: within("water.wind_m_per_s", wind, 0.0, 30.0, "m/s")?,
            towards: angle_within("water.wind_towards_deg", section.wind_towards_deg, -360.0, 360.0)?,
        },
        current_m_per_s: match overrides.current_m_per_s {
            Some(across) => (current(across)?, 0.0),
            None => (current(section.current_m_per_s[0])?, current(section.current_m_per_s[1])?),
        },
    }))
}

fn light(section: &LightSection) -> Result<Light, ScenarioError> {
    Ok(Light {
        sun_bearing: angle_within("light.sun_bearing_deg", section.sun_bearing_deg, -360.0, 360.0)?,
        sun_elevation: angle_within("light.sun_elevation_deg", section.sun_elevation_deg, 2.0, 90.0)?,
        overcast: within("light.overcast", section.overcast, 0.0, 1.0, "a share")?,
    })
}

fn sensing(section: &SensingSection) -> Result<SensorModel, ScenarioError> {
    let [length, breadth] = section.target_size_m;
    let size = |value: f64| within("sensing.target_size_m", value, 0.01, 100.0, "metres");
    Ok(SensorModel {
        noise: OrnsteinUhlenbeck {
            std_dev: within("sensing.noise_px", section.noise_px, 0.0, 100.0, "pixels")?,
            time_constant_s: within("sensing.noise_time_s", section.noise_time_s, 0.0, 3600.0, "seconds")?,
        },
        is_rounded: section.rounded,
        beyond_border: match section.clamped_at_px {
            None => BeyondBorder::Absent,
            Some([x_px, y_px]) => BeyondBorder::Clamped {
                x_px: within("sensing.clamped_at_px", x_px, 1.0, 8192.0, "pixels")?,
                y_px: within("sensing.clamped_at_px", y_px, 1.0, 8192.0, "pixels")?,
            },
        },
        target_size_m: (size(length)?, size(breadth)?),
        heading_std_dev: section
            .heading_noise_deg
            .map(|degrees| angle_within("sensing.heading_noise_deg", degrees, 0.0, 90.0))
            .transpose()?,
    })
}
