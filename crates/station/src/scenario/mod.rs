//! Scenarios: TOML at the edge, [`barrelman_sim::Scenario`] inside.
//!
//! The built-in ones lie in `config/scenarios`, documented; any file of the same form does too. A mistake in one
//! is shown with its line.

pub mod file;
pub mod mistake;
pub mod resolve;

use core::time::Duration;
use std::path::Path;

use anyhow::{Result, anyhow, bail};
use barrelman_sim::camera_axis::AxisPlant;
use barrelman_sim::{Scenario, World};
use barrelman_vocab::profile::{AxisDynamics, CameraDynamics};
use barrelman_vocab::{AngularRate, PictureSize, VehicleProfile};

pub use mistake::Mistake;

use crate::input;

/// A built-in scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// Its file.
    pub text: &'static str,
}

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        [$(BuiltIn {
            name: $name,
            text: include_str!(concat!("../../../../config/scenarios/", $name, ".toml")),
        }),*]
    };
}

/// The built-in scenarios, as they are listed.
pub const BUILT_IN: [BuiltIn; 15] = built_in![
    "lab1",
    "lab2",
    "arena1",
    "arena2",
    "field1",
    "field2",
    "steep1",
    "steep2",
    "open",
    "glint",
    "sea3",
    "distractors",
    "pier",
    "exit",
    "gusts",
];

/// The built-in paths that a scenario may name.
pub const PATHS: [(&str, &str); 2] = [
    ("arena1", include_str!("../../../../config/scenarios/paths/arena1.toml")),
    ("arena2", include_str!("../../../../config/scenarios/paths/arena2.toml")),
];

/// What differs from a scenario's file, by the command line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Changes {
    /// Which of its settings; without it the file's own.
    pub setting: Option<String>,
    /// Speed of the target, m/s.
    pub boat_speed_m_per_s: Option<f64>,
    /// Sea state.
    pub sea_state: Option<u8>,
    /// Mean wind, m/s.
    pub wind_m_per_s: Option<f64>,
    /// Size of the picture.
    pub size: Option<PictureSize>,
}

/// A scenario that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The scenario.
    pub scenario: Scenario,
    /// The setting that it has.
    pub setting: String,
    /// XXH3-64 of its file.
    pub hash: u64,
}

impl Loaded {
    /// The vehicle that flies in it: the laboratory's, with the scenario's video latency, and its camera as the scenario
    /// has it before anything is drawn by chance.
    ///
    /// # Errors
    /// If the target's way-points make no path.
    pub fn profile(&self) -> Result<VehicleProfile> {
        let camera = &self.scenario.camera;
        let mount = &self.scenario.mount;
        let base = VehicleProfile::fotokite_pro();
        let first_tilt = World::nominal_tilt(&self.scenario)
            .map_err(|_| anyhow!("the way-points of {} make no path", self.scenario.name))?;
        let axis = |plant: &AxisPlant| AxisDynamics {
            start_dead_time: Duration::from_secs_f64(plant.start_dead_time_s),
            stop_dead_time: Duration::from_secs_f64(plant.stop_dead_time_s),
            lag: Duration::from_secs_f64(plant.lag_s),
            least_rate: AngularRate::from_radians_per_second(plant.imperfections.dead_band_rad_per_s),
        };
        Ok(VehicleProfile {
            video_latency: camera.latency(),
            camera: CameraDynamics {
                focal_share: camera.optics.focal_px / f64::from(camera.frame.width),
                first_tilt,
                tilt_stops: mount.tilt.end_stops.unwrap_or(base.camera.tilt_stops),
                pan: axis(&mount.pan),
                tilt: axis(&mount.tilt),
            },
            ..base
        })
    }
}

/// The scenario of that name, or in the file at that path.
///
/// # Errors
/// If there is none, or it has a mistake; the message shows where.
pub fn load(name: &str, changes: &Changes) -> Result<Loaded> {
    if let Some(built_in) = BUILT_IN.iter().find(|built_in| built_in.name == name) {
        return Ok(resolve::read(built_in.text, changes)
            .map_err(|mistake| mistake.shown_in(&format!("the scenario {name}"), built_in.text))?);
    }
    if !name.ends_with(".toml") {
        let names: Vec<&str> = BUILT_IN.iter().map(|built_in| built_in.name).collect();
        bail!(
            "there is no scenario {name:?}: use one of {}, or the path of a file that ends in .toml \
             (`barrelman scenarios` lists them, `barrelman scenarios NAME` prints one)",
            names.join(", ")
        );
    }
    let bytes = input::read(Path::new(name))?;
    let Ok(text) = String::from_utf8(bytes) else { bail!("{name} is no scenario: it is not text") };
    Ok(resolve::read(&text, changes).map_err(|mistake| mistake.shown_in(name, &text))?)
}
