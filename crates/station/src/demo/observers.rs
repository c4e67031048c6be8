//! The step observers of a drive: hash, recording, and what the console shows.

use super::first_selection::SelectionWatch;
use barrelman_console_server::operator::Answers;
use barrelman_console_server::snapshot::Publisher;
use barrelman_console_server::{PictureSlot, VideoRelay};
use barrelman_experiments::campaign::recording::TrialRecorder;
use barrelman_experiments::drive::{DriveHasher, DriveObserver};
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::Truth;
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{EncodedUnit, LawId, Timestamp, VehicleRates};

use crate::share::ShareInput;

/// The step observers of a drive.
#[derive(Default)]
pub(super) struct DriveObservers<'a> {
    /// The hash of all steps and of the truth.
    pub(super) hash: DriveHasher,
    /// The recording, if the drive is recorded.
    pub(super) recorder: Option<TrialRecorder>,
    /// What the console shows; `None`: there is no console.
    pub(super) console: Option<ConsoleObserver<'a>>,
    /// The annotated video for other programs.
    pub(super) share: Option<ShareInput>,
    /// Whether the target is in the newest picture.
    pub(super) is_in_picture: Option<bool>,
    /// What the person has to see before the first selection, and what became of a selection.
    pub(super) first_selection: SelectionWatch,
}

/// Passes the steps of a drive on to the console.
pub(super) struct ConsoleObserver<'a> {
    pub(super) publisher: &'a mut Publisher,
    pub(super) pictures: &'a PictureSlot,
    pub(super) relay: &'a VideoRelay,
    /// Answers that are still to be given.
    pub(super) answers: Answers,
    /// The law in force.
    pub(super) law: LawId,
}

impl StepObserver for DriveObservers<'_> {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.hash.on_step(now, input, outcome, rates);
        if let Some(recorder) = &mut self.recorder {
            recorder.on_step(now, input, outcome, rates);
        }
        self.first_selection.on_step(input, outcome);
        if let Some(share) = &self.share {
            share.put(input, outcome, rates);
        }
        if let Some(console) = &mut self.console {
            if let Input::Frame(frame) = input {
                console.pictures.put(frame, outcome, rates);
            }
            if !matches!(input, Input::Request(_)) {
                console.answers.on_step(outcome);
            }
            console.publisher.on_step(input, outcome, rates, console.law);
        }
    }

    fn on_truth(&mut self, truth: &Truth, target: Option<&TargetInPicture>) {
        self.hash.on_truth(truth, target);
        self.is_in_picture = Some(truth.in_picture);
        self.first_selection.on_truth(truth, target);
    }
}

impl DriveObserver for DriveObservers<'_> {
    fn on_unit(&mut self, unit: EncodedUnit) {
        if let Some(console) = &self.console {
            console.relay.add(&unit);
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.add_unit(unit);
        }
    }
}
