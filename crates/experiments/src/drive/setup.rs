//! The setup of a drive: everything that determines a drive, except its inputs.

use anyhow::Result;
use barrelman_sim::scenario::TargetScript;
use barrelman_vocab::VehicleProfile;

use crate::law_choice::LawChoice;
use crate::scenario::{self, LoadedScenario, ScenarioOverrides};
use crate::tracker_choice::TrackerName;
use crate::world_url::WorldUrl;

/// Everything that determines a drive, except its inputs.
#[derive(Debug, Clone)]
pub struct DriveSetup {
    /// The world.
    pub url: WorldUrl,
    /// The scenario.
    pub loaded: LoadedScenario,
    /// The vehicle.
    pub profile: VehicleProfile,
    /// The tracker.
    pub tracker: TrackerName,
    /// The camera law.
    pub law: LawChoice,
    /// Whether pictures are encoded as H.264.
    pub encoded: bool,
    /// Whether the person selects the boat and engages; otherwise the world selects the boat.
    pub hands_on: bool,
}

impl DriveSetup {
    /// Whether the pilot commands the boat: only where the target is one.
    pub const fn commands_vessel(&self) -> bool {
        matches!(self.loaded.scenario.target, TargetScript::Boat(_))
    }

    /// Loads the scenario of a drive.
    ///
    /// # Errors
    /// The scenario does not exist or has a mistake.
    pub fn new(url: WorldUrl, tracker: TrackerName, law: LawChoice, encoded: bool) -> Result<Self> {
        let overrides = ScenarioOverrides { size: url.size, ..ScenarioOverrides::default() };
        let loaded = scenario::load(&url.scenario, &overrides)?;
        let profile = loaded.profile()?;
        Ok(Self { url, loaded, profile, tracker, law, encoded, hands_on: false })
    }
}
