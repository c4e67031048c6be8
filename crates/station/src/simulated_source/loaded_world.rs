//! A world of a scenario, loaded.

use anyhow::{Result, anyhow};
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::world_url::WorldUrl;
use barrelman_sim::{Scenario, World};

/// A world of a scenario at its start.
#[derive(Debug)]
pub struct LoadedWorld {
    pub(super) scenario: Scenario,
    pub(super) world: World,
    pub(super) seed: u64,
}

impl LoadedWorld {
    /// Loads a world, which has no end ([`World::without_end`]).
    ///
    /// # Errors
    /// If the scenario does not exist or has a mistake.
    pub(super) fn load(url: &WorldUrl) -> Result<Self> {
        let changes = ScenarioOverrides { size: url.size, ..ScenarioOverrides::default() };
        let scenario = scenario::load(&url.scenario, &changes)?.scenario;
        let world = World::new(&scenario, url.seed).map_err(|_| {
            anyhow!("the way-points of {} make no path with seed {}", scenario.name, url.seed)
        })?;
        Ok(Self { scenario, world: world.without_end(), seed: url.seed })
    }
}
