//! Telemetry of the vehicle reaches the law.

use std::sync::{Arc, Mutex};

use barrelman_control::{CameraLaw, CameraModel, Law, LawInput};
use barrelman_pilot::{Input, Pilot};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Angle, CameraCommand, Telemetry};

use crate::scenes::SceneInput::{Engage, Seen};
use crate::scenes::{INSIDE, Scripted, at, settings};

/// A law that always rests and records the tilt of its camera model.
struct TiltRecorder(Arc<Mutex<f64>>);

impl Law for TiltRecorder {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        *self.0.lock().unwrap() = camera.angles_at(input.captured).1;
        CameraCommand::REST
    }
}

#[test]
fn the_first_tilt_that_the_gimbal_reports_takes_the_place_of_the_profiles() {
    let tilt_after = |reports: &[f64]| {
        let believed = Arc::new(Mutex::new(f64::NAN));
        let settings = settings();
        let law = CameraLaw::from_law(Box::new(TiltRecorder(Arc::clone(&believed))), &settings.profile);
        let mut pilot = Pilot::with_law(settings, law, Box::new(Scripted::default()));
        for (index, tilt) in reports.iter().enumerate() {
            let ms = 10 * (1 + index as u64);
            let report = Report::CameraTilt(Angle::from_degrees(*tilt));
            pilot.step(Input::Telemetry(Telemetry { at: at(ms), report }), at(ms));
        }
        pilot.step(Seen(INSIDE).input(at(100)), at(100));
        believed.lock().unwrap().to_degrees()
    };
    assert!((tilt_after(&[-60.0]) + 60.0).abs() < 1e-9);
    assert!((tilt_after(&[f64::NAN, -60.0]) + 60.0).abs() < 1e-9, "a report that is not finite is none");
    assert!((tilt_after(&[-60.0, -50.0]) + 58.0).abs() < 1e-9, "later ones correct by a fifth");
}

#[test]
fn a_law_believes_the_tilt_that_the_gimbal_reports() {
    let believed = Arc::new(Mutex::new(f64::NAN));
    let settings = settings();
    let first = settings.profile.camera.initial_tilt.degrees();
    let law = CameraLaw::from_law(Box::new(TiltRecorder(Arc::clone(&believed))), &settings.profile);
    let mut pilot = Pilot::with_law(settings, law, Box::new(Scripted::default()));
    let tilt_after_step = |pilot: &mut Pilot, ms| {
        pilot.step(Seen(INSIDE).input(at(ms)), at(ms));
        believed.lock().unwrap().to_degrees()
    };
    pilot.step(Engage.input(at(0)), at(0));
    assert!((tilt_after_step(&mut pilot, 10) - first).abs() < 1e-9);
    for ms in (100..4000).step_by(100) {
        let report = Report::CameraTilt(Angle::from_degrees(-60.0));
        let outcome = pilot.step(Input::Telemetry(Telemetry { at: at(ms), report }), at(ms));
        assert_eq!(outcome.command, CameraCommand::REST, "a report moves nothing");
    }
    assert!((tilt_after_step(&mut pilot, 4000) + 60.0).abs() < 0.1);
    // Invalid reports are ignored.
    let report = Report::CameraTilt(Angle::from_radians(f64::NAN));
    pilot.step(Input::Telemetry(Telemetry { at: at(4010), report }), at(4010));
    assert!((tilt_after_step(&mut pilot, 4020) + 60.0).abs() < 0.1);
}
