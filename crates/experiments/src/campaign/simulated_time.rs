//! How much time the running trials of a campaign have simulated, for the progress of the campaign.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use barrelman_pilot::{Input, Outcome};
use barrelman_sim::{Truth, World};
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{Timestamp, VehicleRates};

/// Simulated time of all trials together; its clones count into the same sum.
#[derive(Debug, Clone, Default)]
pub struct SimulatedTime(Arc<AtomicU64>);

impl SimulatedTime {
    /// The sum.
    pub fn total(&self) -> Duration {
        Duration::from_nanos(self.0.load(Ordering::Relaxed))
    }

    /// Passes on what an observer sees, and counts its time.
    pub(super) fn counting<'a>(&self, observer: &'a mut dyn StepObserver) -> CountingObserver<'a> {
        CountingObserver { observer, time: self.clone(), last: Timestamp::ZERO }
    }
}

/// An observer that counts the simulated time, picture by picture.
pub(super) struct CountingObserver<'a> {
    observer: &'a mut dyn StepObserver,
    time: SimulatedTime,
    last: Timestamp,
}

impl StepObserver for CountingObserver<'_> {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.observer.on_step(now, input, outcome, rates);
    }

    fn on_truth(&mut self, truth: &Truth, target: Option<&TargetInPicture>) {
        let step = truth.at.since(self.last);
        self.last = truth.at;
        let nanos = u64::try_from(step.as_nanos()).unwrap_or(u64::MAX);
        self.time.0.fetch_add(nanos, Ordering::Relaxed);
        self.observer.on_truth(truth, target);
    }

    fn on_world(&mut self, world: &World) {
        self.observer.on_world(world);
    }
}
