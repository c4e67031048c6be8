//! The world that takes the place of the running one.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::Result;
use barrelman_experiments::scenario::{self, ScenarioChoice};
use barrelman_experiments::world_url::WorldUrl;
use barrelman_vocab::NewDrive;

use super::loaded_world::LoadedWorld;

/// Where the thread `world` looks for the next world at each tick.
#[derive(Debug, Clone, Default)]
pub(super) struct NextWorld(Arc<Mutex<Option<LoadedWorld>>>);

impl NextWorld {
    /// Puts the next world in. The running world ends at its next tick.
    fn put(&self, world: LoadedWorld) {
        *self.slot() = Some(world);
    }

    pub(super) fn is_waiting(&self) -> bool {
        self.slot().is_some()
    }

    pub(super) fn take(&self) -> Option<LoadedWorld> {
        self.slot().take()
    }

    fn slot(&self) -> MutexGuard<'_, Option<LoadedWorld>> {
        // Each change is one assignment: a panic elsewhere leaves the slot whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Begins worlds in the place of the running one, with pictures of the same size where the address gives a
/// size.
#[derive(Debug, Clone)]
pub struct WorldSwitch {
    pub(super) url: WorldUrl,
    pub(super) choices: Vec<ScenarioChoice>,
    pub(super) next: NextWorld,
}

impl WorldSwitch {
    /// The scenarios that a new world can have.
    pub fn choices(&self) -> &[ScenarioChoice] {
        &self.choices
    }

    /// The first world.
    pub const fn first(&self) -> &WorldUrl {
        &self.url
    }

    /// Loads a world.
    ///
    /// # Errors
    /// There is no such scenario, or it makes no world with this seed.
    pub fn load(&self, wanted: &NewDrive) -> Result<LoadedWorld> {
        scenario::require_choice(&wanted.scenario, &self.choices)?;
        let NewDrive { scenario, seed } = wanted.clone();
        LoadedWorld::load(&WorldUrl { scenario, seed, size: self.url.size })
    }

    /// Lets a world take the place of the running one.
    pub fn begin(&self, world: LoadedWorld) {
        self.next.put(world);
    }
}
