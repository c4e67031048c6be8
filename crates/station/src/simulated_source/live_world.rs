//! A simulated world before its start.

use anyhow::{Result, anyhow};
use barrelman_emulators::camera_link::CameraLink;
use barrelman_emulators::simulated_boat::SimulatedBoat;
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::world_url::WorldUrl;
use barrelman_sim::{Scenario, World};
use barrelman_vocab::VehicleProfile;

/// A simulated world that has not started.
#[derive(Debug)]
pub struct LiveWorld {
    pub(super) scenario: Scenario,
    pub(super) world: World,
    pub(super) seed: u64,
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
        let changes = ScenarioOverrides { size: url.size, ..ScenarioOverrides::default() };
        let scenario = scenario::load(&url.scenario, &changes)?.scenario;
        let world = World::new(&scenario, url.seed).map_err(|_| {
            anyhow!("the way-points of {} make no path with seed {}", scenario.name, url.seed)
        })?;
        Ok(Self {
            scenario,
            world,
            seed: url.seed,
            link: CameraLink::default(),
            boat: SimulatedBoat::default(),
            profile: VehicleProfile::fotokite_pro(),
            encoded: false,
            threads: RenderThreads::new()?,
        })
    }

    /// The scenario.
    pub const fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The link to the camera of the world.
    pub fn link(&self) -> CameraLink {
        self.link.clone()
    }

    /// The boat of the world, where a boat is the target: orders steer it instead of the scenario's helmsman.
    pub fn boat(&self) -> SimulatedBoat {
        self.boat.clone()
    }

    /// The same world without an end ([`World::without_end`]).
    #[must_use]
    pub fn without_end(self) -> Self {
        Self { world: self.world.without_end(), ..self }
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
