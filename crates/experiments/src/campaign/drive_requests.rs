//! Trials in which the boat is steered by the requests of a stored drive.

use barrelman_sim::World;
use barrelman_trial::campaign::{FrameSource, Simulation, StepObserver};
use barrelman_trial::logs::TrialLog;
use barrelman_vocab::OperatorRequest;
use xxhash_rust::xxh3::Xxh3;

use crate::drive::StoredDrive;

/// The requests of a drive, each with its tick, and the last tick.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveRequests {
    requests: Vec<(u64, OperatorRequest)>,
    last_tick: u64,
    hands_on: bool,
    /// Whether the pilot commands the boat.
    pub(super) commands_vessel: bool,
}

impl DriveRequests {
    /// The requests of a stored drive.
    pub fn from_drive(stored: &StoredDrive) -> Self {
        let setup = &stored.setup;
        Self {
            requests: stored.requests.clone(),
            last_tick: stored.last_tick(),
            hands_on: setup.hands_on,
            commands_vessel: setup.commands_vessel(),
        }
    }

    /// Duration of the drive, seconds.
    pub(super) fn duration_s(&self) -> f64 {
        World::time_of(self.last_tick).as_secs_f64()
    }

    /// Runs a trial from its start to the last tick of the drive.
    pub(super) fn run(
        &self,
        mut simulation: Simulation<'_>,
        mut camera: Option<&mut dyn FrameSource>,
        observer: &mut dyn StepObserver,
    ) -> TrialLog {
        if self.hands_on {
            simulation = simulation.without_selection();
        }
        simulation = simulation.with_tilt_reports(true).with_height_reports();
        let mut requests = self.requests.iter().peekable();
        loop {
            let tick = simulation.world().tick();
            while let Some((_, request)) = requests.next_if(|(at, _)| *at <= tick) {
                simulation.request(*request, observer);
            }
            if tick >= self.last_tick {
                return simulation.into_log();
            }
            simulation.tick(&mut camera, observer);
        }
    }

    /// XXH3-64 of the requests and the last tick, in hexadecimal digits.
    pub(super) fn hash(&self) -> String {
        let mut hash = Xxh3::new();
        hash.update(&self.last_tick.to_le_bytes());
        for (tick, request) in &self.requests {
            hash.update(format!("{tick} {request:?}\n").as_bytes());
        }
        format!("{:016x}", hash.digest())
    }
}
