//! Limits, least rates and end stops hold whatever the law says, and the law is told what holds.

use std::sync::{Arc, Mutex};

use barrelman_control::{CameraLaw, CameraModel, Law, LawInput};
use barrelman_pilot::{CommandPath, Input, Outcome, Pilot};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{
    Angle, AngularRate, CameraCommand, CameraRequest, Nudge, OperatorRequest, Telemetry, Timestamp,
};

use crate::scenes::SceneInput::{Engage, Seen, Tick};
use crate::scenes::{RIGHT, Scripted, at, settings};

fn command(pan: f64, tilt: f64) -> CameraCommand {
    let rate = AngularRate::from_radians_per_second;
    CameraCommand::turning(rate(pan), rate(tilt))
}

/// A law that always advises the same, and remembers what it was told of its last command.
struct Stubborn {
    advice: CameraCommand,
    told: Arc<Mutex<CameraCommand>>,
}

impl Law for Stubborn {
    fn command(&mut self, _: &LawInput<'_>, _: &CameraModel) -> CameraCommand {
        self.advice
    }

    fn on_command_applied(&mut self, command: CameraCommand, _: Timestamp) {
        *self.told.lock().unwrap() = command;
    }
}

/// An engaged pilot with least rates of 0.04 rad/s whose law advises this, and what the law is told.
fn stubborn(advice: CameraCommand, path: CommandPath) -> (Pilot, Arc<Mutex<CameraCommand>>) {
    let told = Arc::new(Mutex::new(CameraCommand::REST));
    let mut settings = settings();
    let min_rate = AngularRate::from_radians_per_second(0.04);
    (settings.profile.camera.pan.min_rate, settings.profile.camera.tilt.min_rate) = (min_rate, min_rate);
    let law = Stubborn { advice, told: Arc::clone(&told) };
    let law = CameraLaw::from_law(Box::new(law), &settings.profile);
    let mut pilot = Pilot::with_law(settings, law, Box::new(Scripted::default())).commanding(path);
    pilot.step(Engage.input(at(0)), at(0));
    (pilot, told)
}

fn report_tilt(pilot: &mut Pilot, degrees: f64, ms: u64) -> Outcome {
    let report = Report::CameraTilt(Angle::from_degrees(degrees));
    pilot.step(Input::Telemetry(Telemetry { at: at(ms), report }), at(ms))
}

#[track_caller]
fn check(advice: CameraCommand, expected: CameraCommand) {
    let (mut pilot, told) = stubborn(advice, CommandPath::Simulated);
    let outcome = pilot.step(Seen(RIGHT).input(at(10)), at(10));
    assert_eq!((outcome.command, *told.lock().unwrap()), (expected, expected), "{advice:?}");
}

#[test]
fn whatever_a_law_advises_the_vehicle_can_execute_what_is_commanded() {
    check(command(9.0, -9.0), command(0.4, -0.3));
    check(command(f64::INFINITY, f64::NEG_INFINITY), command(0.4, -0.3));
    check(command(f64::NAN, f64::NAN), CameraCommand::REST);
    check(command(0.03, -0.01), command(0.04, 0.0));
    check(command(-0.2, 0.1), command(-0.2, 0.1));
}

#[test]
fn a_reported_end_stop_ends_a_rate_at_once_and_the_other_axis_goes_on() {
    let (mut pilot, told) = stubborn(command(0.2, 0.1), CommandPath::Simulated);
    assert_eq!(pilot.step(Seen(RIGHT).input(at(10)), at(10)).command, command(0.2, 0.1));
    assert_eq!(report_tilt(&mut pilot, 9.0, 20).command, command(0.2, 0.1));
    assert_eq!(report_tilt(&mut pilot, 10.0, 30).command, command(0.2, 0.0));
    assert_eq!(*told.lock().unwrap(), command(0.2, 0.0));
    // Only a fresh localisation starts a rate again.
    assert_eq!(report_tilt(&mut pilot, 9.0, 40).command, command(0.2, 0.0));
    assert_eq!(pilot.step(Tick.input(at(50)), at(50)).command, command(0.2, 0.0));
    assert_eq!(pilot.step(Seen(RIGHT).input(at(60)), at(60)).command, command(0.2, 0.1));
}

#[test]
fn a_tilt_that_was_reported_long_ago_holds_nothing() {
    let (mut pilot, _) = stubborn(command(0.0, 0.1), CommandPath::Simulated);
    report_tilt(&mut pilot, 10.0, 10);
    assert_eq!(pilot.step(Seen(RIGHT).input(at(1_010)), at(1_010)).command, CameraCommand::REST);
    assert_eq!(pilot.step(Seen(RIGHT).input(at(1_011)), at(1_011)).command, command(0.0, 0.1));
}

#[test]
fn a_nudge_is_held_off_the_end_stops_too() {
    let (mut pilot, _) = stubborn(CameraCommand::REST, CommandPath::Simulated);
    pilot.step(Input::Request(OperatorRequest::Camera(CameraRequest::Disengage)), at(10));
    pilot.step(Seen(RIGHT).input(at(20)), at(20));
    let mut nudge = |tilt, ms| {
        let request = OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan: 0.3, tilt, zoom: 0.0 }));
        pilot.step(Input::Request(request), at(ms)).command
    };
    assert_eq!(nudge(1.0, 30), command(0.04, 0.1), "0.03 rad/s is below the least rate");
    report_tilt(&mut pilot, 10.0, 40);
    let mut nudge = |tilt, ms| {
        let request = OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan: 0.3, tilt, zoom: 0.0 }));
        pilot.step(Input::Request(request), at(ms)).command
    };
    assert_eq!(nudge(1.0, 50), command(0.04, 0.0));
    assert_eq!(nudge(-1.0, 60), command(0.04, -0.1));
}
