//! The newest frame, for the model.

use std::sync::Arc;

use barrelman_host::latest::Latest;
use barrelman_pilot::Input;
use barrelman_vocab::VideoFrame;

use crate::live::run_loop::{LiveStep, LiveStepObserver};

/// Passes the frames of a run on. Never waits.
#[derive(Debug)]
pub struct DetectorInput(pub(super) Arc<Latest<VideoFrame>>);

impl LiveStepObserver for DetectorInput {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        if let Input::Frame(frame) = step.input {
            self.0.put(frame.clone());
        }
    }
}
