//! The step observers of a drive: hash, recording, pictures for the page, and the motor schema's shadow.

use barrelman_experiments::campaign::recording::TrialRecorder;
use barrelman_experiments::drive::motor_schema_shadow::MotorSchemaShadow;
use barrelman_experiments::drive::{DriveHasher, DriveObserver, DriveSetup};
use barrelman_experiments::law_choice::LawName;
use barrelman_host::latest::Latest;
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::Truth;
use barrelman_trial::campaign::StepObserver;
use barrelman_vocab::{EncodedUnit, Timestamp, VehicleRates};

use super::page_pictures::AnnotatedFrame;

/// The step observers of a drive.
#[derive(Default)]
pub(super) struct DriveObservers<'a> {
    /// The hash of all steps and of the truth.
    pub(super) hash: DriveHasher,
    /// The recording, if the drive is recorded.
    pub(super) recorder: Option<TrialRecorder>,
    /// The slot of the page's pictures.
    pub(super) frames: Option<&'a Latest<AnnotatedFrame>>,
    /// What the motor schema would have done, where another law moves the camera.
    pub(super) shadow: Option<MotorSchemaShadow>,
    /// The outcome of the newest step, and the rates that were sent.
    pub(super) newest: Option<(Outcome, VehicleRates)>,
    /// Whether the target is in the newest picture.
    pub(super) is_in_picture: Option<bool>,
}

/// The motor schema's shadow of a drive; `None` where the motor schema is the drive's law.
pub(super) fn shadow_of(setup: &DriveSetup) -> Option<MotorSchemaShadow> {
    (setup.law.name != LawName::MotorSchema).then(|| MotorSchemaShadow::new(&setup.profile))
}

impl StepObserver for DriveObservers<'_> {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.hash.on_step(now, input, outcome, rates);
        if let Some(recorder) = &mut self.recorder {
            recorder.on_step(now, input, outcome, rates);
        }
        if let (Some(frames), Input::Frame(frame)) = (self.frames, input) {
            frames.put(AnnotatedFrame { frame: (*frame).clone(), outcome: outcome.clone(), rates });
        }
        if let Some(shadow) = &mut self.shadow {
            shadow.step(now, outcome);
        }
        self.newest = Some((outcome.clone(), rates));
    }

    fn on_truth(&mut self, truth: &Truth) {
        self.hash.on_truth(truth);
        self.is_in_picture = Some(truth.in_picture);
    }
}

impl DriveObserver for DriveObservers<'_> {
    fn on_unit(&mut self, unit: EncodedUnit) {
        if let Some(recorder) = &mut self.recorder {
            recorder.add_unit(unit);
        }
    }
}
