//! Trials in which the boat is steered as somebody steered it in a drive that was stored.

use barrelman_trial::campaign::{FrameSource, Simulation, StepObserver};
use barrelman_trial::logs::TrialLog;
use xxhash_rust::xxh3::Xxh3;

use crate::drive::{DriveInput, DriveReader};

/// What was done in a drive, each before a tick, and the tick at which it ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DriveInputs {
    inputs: Vec<(u64, DriveInput)>,
    last: u64,
}

impl DriveInputs {
    /// What was done in a stored drive.
    pub fn of(stored: &DriveReader) -> Self {
        Self { inputs: stored.inputs.clone(), last: stored.last_tick() }
    }

    /// Runs a trial that has not begun, to where the drive ended.
    pub(super) fn run(
        &self,
        mut simulation: Simulation<'_>,
        mut camera: Option<&mut dyn FrameSource>,
        observer: &mut dyn StepObserver,
    ) -> TrialLog {
        let mut inputs = self.inputs.iter().peekable();
        loop {
            let tick = simulation.world().tick();
            while let Some((_, input)) = inputs.next_if(|(at, _)| *at <= tick) {
                input.act(&mut simulation, observer);
            }
            if tick >= self.last || simulation.is_over() {
                return simulation.into_log();
            }
            simulation.tick(&mut camera, observer);
        }
    }

    /// XXH3-64 of all of it, in hexadecimal digits.
    pub(super) fn hash(&self) -> String {
        let mut hash = Xxh3::new();
        hash.update(&self.last.to_le_bytes());
        for (tick, input) in &self.inputs {
            hash.update(format!("{tick} {input:?}\n").as_bytes());
        }
        format!("{:016x}", hash.digest())
    }
}
