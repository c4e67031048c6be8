//! A simulated world before its start.

use anyhow::Result;
use barrelman_emulators::camera_link::CameraLink;
use barrelman_emulators::simulated_boat::SimulatedBoat;
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_experiments::scenario;
use barrelman_experiments::world_url::WorldUrl;
use barrelman_sim::Scenario;
use barrelman_vocab::VehicleProfile;

use super::loaded_world::LoadedWorld;
use super::next_world::{NextWorld, WorldSwitch};

/// A simulated world that has not started, with what outlasts it: the link and the boat's orders.
#[derive(Debug)]
pub struct LiveWorld {
    pub(super) url: WorldUrl,
    pub(super) first: LoadedWorld,
    pub(super) next: NextWorld,
    pub(super) link: CameraLink,
    pub(super) boat: SimulatedBoat,
    pub(super) profile: VehicleProfile,
    /// Whether pictures travel as H.264.
    pub(super) encoded: bool,
    pub(super) threads: RenderThreads,
}

impl LiveWorld {
    /// Loads a world.
    ///
    /// # Errors
    /// If the scenario does not exist or has a mistake.
    pub fn load(url: &WorldUrl) -> Result<Self> {
        Ok(Self {
            url: url.clone(),
            first: LoadedWorld::load(url)?,
            next: NextWorld::default(),
            link: CameraLink::default(),
            boat: SimulatedBoat::default(),
            profile: VehicleProfile::fotokite_pro(),
            encoded: false,
            threads: RenderThreads::new()?,
        })
    }

    /// The scenario.
    pub const fn scenario(&self) -> &Scenario {
        &self.first.scenario
    }

    /// What begins other worlds in the place of this one.
    ///
    /// # Errors
    /// The scenario can no longer be read.
    pub fn switch(&self) -> Result<WorldSwitch> {
        let choices = scenario::choices(&self.url.scenario)?;
        Ok(WorldSwitch { url: self.url.clone(), choices, next: self.next.clone() })
    }

    /// The link to the camera of the world.
    pub fn link(&self) -> CameraLink {
        self.link.clone()
    }

    /// The boat of the world, where a boat is the target: orders steer it instead of the scenario's helmsman.
    pub fn boat(&self) -> SimulatedBoat {
        self.boat.clone()
    }

    /// Sets the vehicle profile. The rates on the link have its signs.
    #[must_use]
    pub fn with_profile(self, profile: &VehicleProfile) -> Self {
        Self { profile: profile.clone(), ..self }
    }

    /// Sets whether pictures travel as H.264.
    #[must_use]
    pub fn with_encoding(self, encoded: bool) -> Self {
        Self { encoded, ..self }
    }
}
