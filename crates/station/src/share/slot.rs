//! The newest frame with what the pilot made of it, for the thread that draws.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use barrelman_host::latest::Latest;
use barrelman_pilot::{Input, Outcome};
use barrelman_vocab::{VehicleRates, VideoFrame};

use crate::live::run_loop::{LiveStep, LiveStepObserver};

/// A frame with what is drawn on it.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) frame: VideoFrame,
    pub(super) outcome: Outcome,
    pub(super) rates: VehicleRates,
}

/// The newest frame, while somebody reads.
#[derive(Debug, Default)]
pub(super) struct ShareSlot {
    pub(super) frames: Latest<Box<Shown>>,
    is_wanted: AtomicBool,
}

impl ShareSlot {
    pub(super) fn set_wanted(&self, is_wanted: bool) {
        self.is_wanted.store(is_wanted, Ordering::Relaxed);
    }
}

/// Passes the frames of a run on. Never waits.
#[derive(Debug)]
pub struct ShareInput(pub(super) Arc<ShareSlot>);

impl ShareInput {
    /// Passes the frame of a step on, if it has one.
    pub fn put(&self, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        let Input::Frame(frame) = *input else { return };
        if self.0.is_wanted.load(Ordering::Relaxed) {
            self.0.frames.put(Box::new(Shown { frame: frame.clone(), outcome: outcome.clone(), rates }));
        }
    }
}

impl LiveStepObserver for ShareInput {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        self.put(&step.input, step.outcome, step.rates);
    }
}
