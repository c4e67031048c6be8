//! The newest frame for the model, while candidates are shown.

use std::sync::Arc;

use barrelman_host::latest::Latest;
use barrelman_pilot::{Input, Outcome};
use barrelman_vocab::{Track, VideoFrame};

use crate::live::run_loop::{LiveStep, LiveStepObserver};

/// Passes the frames of a run on. Never waits.
#[derive(Debug)]
pub struct DetectorInput(pub(super) Arc<Latest<VideoFrame>>);

impl LiveStepObserver for DetectorInput {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        if let Input::Frame(frame) = step.input
            && shows_candidates(step.outcome)
        {
            self.0.put(frame.clone());
        }
    }
}

/// Whether the pilot looks for candidates.
fn shows_candidates(outcome: &Outcome) -> bool {
    outcome.are_candidates_wanted || outcome.track == Track::Unseeded && !outcome.is_confirming
}
