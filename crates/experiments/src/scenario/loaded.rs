//! A loaded scenario, and the values that replace those of its file.

use core::time::Duration;

use anyhow::{Result, anyhow};
use barrelman_sim::camera_axis::AxisPlant;
use barrelman_sim::{Scenario, World};
use barrelman_vocab::profile::{AxisDynamics, CameraDynamics};
use barrelman_vocab::{AngularRate, PictureSize, VehicleProfile};

/// Values from the command line that replace those of a scenario file; `None` keeps the file's value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScenarioOverrides {
    /// The name of a setting.
    pub setting: Option<String>,
    /// Speed of the target, m/s.
    pub boat_speed_m_per_s: Option<f64>,
    /// Sea state.
    pub sea_state: Option<u8>,
    /// Mean wind, m/s.
    pub wind_m_per_s: Option<f64>,
    /// Water current, m/s, across the first view: positive to the right.
    pub current_m_per_s: Option<f64>,
    /// Size of the picture.
    pub size: Option<PictureSize>,
}

/// A loaded scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedScenario {
    /// The scenario.
    pub scenario: Scenario,
    /// The name of its setting.
    pub setting: String,
    /// The text of its file.
    pub text: String,
    /// XXH3-64 of that text.
    pub hash: u64,
}

impl LoadedScenario {
    /// The vehicle profile for the scenario: the laboratory's vehicle with the scenario's video latency and
    /// nominal camera.
    ///
    /// # Errors
    /// The target's way-points make no path.
    pub fn profile(&self) -> Result<VehicleProfile> {
        let camera = &self.scenario.camera;
        let mount = &self.scenario.mount;
        let base = VehicleProfile::fotokite_pro();
        let initial_tilt = World::nominal_tilt(&self.scenario)
            .map_err(|_| anyhow!("the way-points of {} make no path", self.scenario.name))?;
        let axis = |plant: &AxisPlant| AxisDynamics {
            start_dead_time: Duration::from_secs_f64(plant.start_dead_time_s),
            stop_dead_time: Duration::from_secs_f64(plant.stop_dead_time_s),
            lag: Duration::from_secs_f64(plant.lag_s),
            min_rate: AngularRate::from_radians_per_second(plant.imperfections.dead_band_rad_per_s),
            gain: 1.0,
        };
        Ok(VehicleProfile {
            video_latency: camera.latency(),
            camera: CameraDynamics {
                focal_share: camera.optics.focal_px / f64::from(camera.frame.width),
                lens: None,
                initial_tilt,
                tilt_stops: mount.tilt.end_stops.unwrap_or(base.camera.tilt_stops),
                pan: axis(&mount.pan),
                tilt: axis(&mount.tilt),
            },
            zoom: mount.zoom,
            ..base
        })
    }
}
