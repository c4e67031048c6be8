//! The setup of a drive: everything that determines a drive, except its inputs.

use anyhow::Result;
use barrelman_vocab::VehicleProfile;

use crate::law_choice::LawChoice;
use crate::scenario::{self, LoadedScenario, ScenarioOverrides};
use crate::tracker_choice::TrackerName;
use crate::world_url::WorldUrl;

/// A drive lasts an hour at most, whatever its scenario says of trials: somebody may steer.
pub const MAX_S: f64 = 3600.0;

/// What a drive is made of, but for its inputs.
#[derive(Debug, Clone)]
pub struct DriveSetup {
    /// The world.
    pub url: WorldUrl,
    /// The scenario that it was loaded from.
    pub loaded: LoadedScenario,
    /// The vehicle.
    pub profile: VehicleProfile,
    /// The tracker.
    pub tracker: TrackerName,
    /// The camera law.
    pub law: LawChoice,
    /// Whether pictures travel as H.264.
    pub coded: bool,
}

impl DriveSetup {
    /// The cast of a drive.
    ///
    /// # Errors
    /// If there is no such scenario, or it has a mistake.
    pub fn new(url: WorldUrl, tracker: TrackerName, law: LawChoice, coded: bool) -> Result<Self> {
        let changes = ScenarioOverrides { size: url.size, ..ScenarioOverrides::default() };
        let mut loaded = scenario::load(&url.scenario, &changes)?;
        loaded.scenario.max_s = MAX_S;
        let profile = loaded.profile()?;
        Ok(Self { url, loaded, profile, tracker, law, coded })
    }
}
