//! The camera's work, on the scenes of a session.

use barrelman_control::{Percept, Region};
use barrelman_pilot::{Mode, Outcome};
use barrelman_trial::camera_work::{CameraWorkMeter, WorkFigures};
use barrelman_vocab::{CameraCommand, HoldCause, ImagePoint, LawId, StopCause, Track, VehicleProfile};

use crate::test_scenes::{at, command, idle, localisation};

/// A command that comes into force in this mode at this time, ms.
type Step = (u64, Mode, CameraCommand);

const SERVOING: Mode = Mode::Servoing;
const HOLDING: Mode = Mode::Holding(HoldCause::Coasting);
const REST: CameraCommand = CameraCommand::REST;

fn metered(steps: &[Step]) -> WorkFigures {
    let mut meter = CameraWorkMeter::new(&VehicleProfile::fotokite_pro());
    for (ms, mode, command) in steps {
        meter.on_step(&Outcome { mode: *mode, command: *command, ..idle(at(*ms)) });
    }
    meter.work(None).camera
}

/// Steps lead to these moves, radians, seconds at rest, and seconds. The tolerance is that of a sum of ten
/// roundings.
#[track_caller]
fn check(steps: &[Step], moves: u64, travel_rad: f64, rest_s: f64, seconds: f64) {
    let got = metered(steps);
    assert_eq!(got.moves, moves, "{steps:?}");
    for (name, got, expected) in
        [("rad", got.travel_rad, travel_rad), ("s at rest", got.rest_s, rest_s), ("s", got.seconds, seconds)]
    {
        assert!((got - expected).abs() < 1e-12, "{got} {name}, not {expected}: {steps:?}");
    }
}

#[test]
fn a_move_begins_at_rest() {
    let (right, left, up) = (command(0.25, 0.0), command(-0.25, 0.0), command(0.0, 0.5));
    check(&[], 0, 0.0, 0.0, 0.0);
    check(&[(0, SERVOING, REST)], 0, 0.0, 0.0, 0.0);
    check(&[(0, SERVOING, right)], 1, 0.0, 0.0, 0.0);
    check(&[(0, SERVOING, right), (1000, SERVOING, right)], 1, 0.25, 0.0, 1.0);
    check(&[(0, SERVOING, right), (1000, SERVOING, left), (2000, SERVOING, up)], 1, 0.5, 0.0, 2.0);
    check(
        &[(0, SERVOING, right), (1000, SERVOING, REST), (1500, SERVOING, right), (2000, HOLDING, REST)],
        2,
        0.375,
        0.5,
        2.0,
    );
}

#[test]
fn both_axes_add_up_whatever_their_signs() {
    check(&[(0, SERVOING, command(-0.25, 0.5)), (2000, SERVOING, REST)], 1, 1.5, 0.0, 2.0);
    check(&[(0, SERVOING, command(0.25, -0.5)), (2000, SERVOING, REST)], 1, 1.5, 0.0, 2.0);
}

#[test]
fn the_time_counts_while_the_pilot_is_engaged_only() {
    let right = command(0.25, 0.0);
    let stopped = Mode::Stopped(StopCause::Operator);
    check(&[(0, Mode::Idle, REST), (9000, SERVOING, REST), (10_000, HOLDING, REST)], 0, 0.0, 1.0, 1.0);
    check(&[(0, Mode::Nudging, right), (1000, Mode::Nudging, right)], 0, 0.0, 0.0, 0.0);
    check(&[(0, Mode::Nudging, right), (1000, SERVOING, right), (2000, SERVOING, right)], 1, 0.25, 0.0, 1.0);
    check(
        &[(0, SERVOING, right), (1000, SERVOING, REST), (1000, stopped, REST), (9000, SERVOING, REST)],
        1,
        0.25,
        0.0,
        1.0,
    );
}

#[test]
fn the_last_command_counts_until_the_pilot_is_disengaged() {
    let right = command(0.25, 0.0);
    let stopped = Mode::Stopped(StopCause::Operator);
    check(&[(0, SERVOING, right), (1000, Mode::Idle, REST)], 1, 0.25, 0.0, 1.0);
    check(&[(0, SERVOING, right), (1000, stopped, REST), (9000, stopped, REST)], 1, 0.25, 0.0, 1.0);
    check(&[(0, HOLDING, REST), (1000, Mode::Idle, REST), (9000, Mode::Idle, REST)], 0, 0.0, 1.0, 1.0);
}

#[test]
fn a_clock_that_starts_again_adds_nothing() {
    let right = command(0.25, 0.0);
    check(&[(9000, SERVOING, right), (0, SERVOING, right), (1000, SERVOING, right)], 1, 0.25, 0.0, 1.0);
}

#[test]
fn the_schema_is_measured_beside_every_other_law() {
    let mut meter = CameraWorkMeter::new(&VehicleProfile::fotokite_pro());
    let region = Region { a_px: 192.0, b_px: 120.0 };
    for ms in [0, 100, 200] {
        let percept = Percept::new(ImagePoint { x: 300.0, y: 0.0 }, region);
        let track = Track::Tracking(localisation(at(ms)));
        meter.on_step(&Outcome {
            mode: SERVOING,
            track,
            region: Some(region),
            percept: Some(percept),
            ..idle(at(ms))
        });
    }
    let beside = meter.work(Some(LawId::Eco));
    let schema = beside.schema.unwrap();
    assert_eq!((beside.camera.moves, beside.camera.rest_s), (0, 0.2), "the camera has rested");
    assert_eq!((schema.moves, schema.rest_s), (1, 0.0), "the schema would have panned");
    assert!(beside.schema_p.is_some_and(|p| p > 1.0) && meter.work(None).schema.is_some());
    let own = meter.work(Some(LawId::Schema));
    assert_eq!((own.schema, own.schema_p), (None, None));
    assert_eq!(own.camera, beside.camera);
}
