//! What the vehicle and its link report: when the camera rests for it, and how it moves again.

use std::sync::{Arc, Mutex};

use barrelman_control::{CameraLaw, CameraModel, Law, LawInput};
use barrelman_pilot::{CommandPath, Input, Mode, Notice, Outcome, Pilot, Refusal};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Report};
use barrelman_vocab::{
    CameraCommand, CameraRequest, Equipment, EquipmentKind, HoldCause, Named as _, Nudge, OperatorRequest,
    StopCause, Telemetry,
};

use crate::scenes::SceneInput::{Disengage, Engage, Seen};
use crate::scenes::{
    COAST_MS, PAN_RIGHT, REST, RIGHT, SceneInput, Scripted, at, localisation_pilot, settings,
};

/// An input of a scene on a link.
#[derive(Debug, Clone, Copy)]
enum Do {
    Scene(SceneInput),
    Nudge,
    Link(LinkState),
    Control(ControlState, f64),
    Flight(FlightState),
    Battery(bool),
    Said(Acceptance),
    Uses(EquipmentKind, &'static str),
}

use Do::{Battery, Control, Flight, Link, Nudge as Nudges, Said, Scene, Uses};

const UP: Do = Link(LinkState::Up);
const SEEN: Do = Scene(Seen(RIGHT));
const ENGAGE: Do = Scene(Engage);
const OURS: Do = Control(ControlState::Ours, 100.0);
const NOT_OURS: Do = Control(ControlState::Elsewhere, 100.0);

impl Do {
    fn step(self, pilot: &mut Pilot, ms: u64) -> Outcome {
        let now = at(ms);
        let report = |report| Input::Telemetry(Telemetry { at: now, report });
        let flight = |state, is_battery_low| Report::Flight {
            state,
            on_time_s: 1.0,
            backup_battery_v: 12.0,
            warnings: 0,
            is_battery_low,
        };
        let input = match self {
            Scene(input) => input.input(now),
            Nudges => Input::Request(OperatorRequest::Camera(CameraRequest::Nudge(Nudge {
                pan: 1.0,
                tilt: 0.0,
                zoom: 0.0,
            }))),
            Link(state) => report(Report::Link(state)),
            Control(control, uptime_s) => {
                report(Report::Ground { control, uptime_s, battery_v: 12.0, tether_m: 1.0 })
            }
            Flight(state) => report(flight(state, false)),
            Said(said) => report(Report::Acceptance(said)),
            Uses(kind, name) => report(Report::Equipment(Equipment::new(kind, name))),
            Battery(is_low) => report(flight(FlightState::Flying, is_low)),
        };
        pilot.step(input, now)
    }
}

/// The last outcome of a scene with an input every 10 ms, on a pilot whose commands take this path.
fn last(path: CommandPath, scene: &[Do]) -> Outcome {
    let mut pilot = localisation_pilot().commanding(path);
    let outcomes = scene.iter().enumerate().map(|(index, input)| input.step(&mut pilot, 10 * index as u64));
    outcomes.last().unwrap()
}

/// The last step of a scene on a link leads to this mode and command.
#[track_caller]
fn check(scene: &[Do], mode: Mode, command: CameraCommand) {
    let outcome = last(CommandPath::Link, scene);
    assert_eq!((outcome.mode, outcome.command), (mode, command), "{scene:?}");
}

const DOWN: Mode = Mode::Holding(HoldCause::LinkDown);

#[test]
fn nothing_moves_before_the_link_is_up() {
    check(&[ENGAGE, SEEN], DOWN, REST);
    for state in [LinkState::Starting, LinkState::Closing, LinkState::Closed] {
        check(&[ENGAGE, Link(state), SEEN], DOWN, REST);
    }
    for state in [LinkState::Opening, LinkState::Starting, LinkState::Closing, LinkState::Closed] {
        check(&[UP, ENGAGE, SEEN, Link(state)], DOWN, REST);
        check(&[UP, ENGAGE, SEEN, Link(state), SEEN], DOWN, REST);
    }
    check(&[SEEN], Mode::Idle, REST);
    check(&[ENGAGE, UP, SEEN], Mode::Servoing, PAN_RIGHT);
}

#[test]
fn a_vehicle_that_was_never_there_cannot_be_engaged_and_ends_an_engagement() {
    let absent = Link(LinkState::Opening);
    let silent = Mode::Stopped(StopCause::VehicleSilent);
    check(&[ENGAGE, absent, UP, SEEN], silent, REST);
    check(&[absent, ENGAGE, UP, SEEN], Mode::Idle, REST);
    let refused = last(CommandPath::Link, &[absent, ENGAGE]).notice;
    assert_eq!(refused, Some(Notice::RequestRefused(Refusal::NoMotion(HoldCause::LinkDown))));
    check(&[absent, Link(LinkState::Starting), ENGAGE, UP, SEEN], Mode::Servoing, PAN_RIGHT);
    // A link that was lost is another matter: the operator knows the vehicle.
    check(&[UP, absent, ENGAGE, UP, SEEN], Mode::Servoing, PAN_RIGHT);
}

#[test]
fn another_gimbal_camera_or_stream_than_before_stops_until_the_next_engage() {
    let exchanged = Mode::Stopped(StopCause::Exchanged);
    for kind in [EquipmentKind::Gimbal, EquipmentKind::Camera, EquipmentKind::Stream] {
        let (old, new) = (Uses(kind, "old"), Uses(kind, "new"));
        let then = |more: &[Do]| [&[UP, old, ENGAGE, SEEN][..], more].concat();
        check(&then(&[old, SEEN]), Mode::Servoing, PAN_RIGHT);
        check(&then(&[new]), exchanged, REST);
        check(&then(&[new, SEEN, old, SEEN]), exchanged, REST);
        check(&then(&[new, ENGAGE, SEEN, new, SEEN]), Mode::Servoing, PAN_RIGHT);
        // After a lost link, before the camera is reached again.
        let lost = then(&[Link(LinkState::Opening), Link(LinkState::Starting), new, UP, SEEN]);
        check(&lost, exchanged, REST);
        check(&[UP, ENGAGE, SEEN, old, SEEN], Mode::Servoing, PAN_RIGHT);
        check(&[UP, old, SEEN, Nudges, new], Mode::Idle, REST);
    }
    let first = Uses(EquipmentKind::Gimbal, "a");
    check(&[UP, ENGAGE, SEEN, first, Uses(EquipmentKind::Camera, "b"), SEEN], Mode::Servoing, PAN_RIGHT);
}

#[test]
fn a_link_that_comes_back_moves_the_camera_with_the_next_look_only() {
    let lost = [UP, ENGAGE, SEEN, Link(LinkState::Opening)];
    let back = |then: &[Do]| [&lost[..], &[SEEN, UP], then].concat();
    check(&back(&[]), Mode::Servoing, REST);
    check(&back(&[SEEN]), Mode::Servoing, PAN_RIGHT);
}

#[test]
fn a_stopped_pilot_stays_stopped_whatever_the_link_does() {
    let stopped = [UP, ENGAGE, SEEN, Scene(SceneInput::Stop(StopCause::Operator))];
    let then = |more: &[Do]| [&stopped[..], more].concat();
    let mode = Mode::Stopped(StopCause::Operator);
    check(&then(&[Link(LinkState::Opening)]), mode, REST);
    check(&then(&[Link(LinkState::Opening), UP, SEEN]), mode, REST);
    check(&then(&[OURS, NOT_OURS]), mode, REST);
}

#[test]
fn a_simulated_camera_is_always_there_and_a_dry_run_moves_nothing() {
    let scene = [ENGAGE, Link(LinkState::Opening), NOT_OURS, Flight(FlightState::Emergency), SEEN];
    let outcome = last(CommandPath::Simulated, &scene);
    assert_eq!((outcome.mode, outcome.command), (Mode::Servoing, PAN_RIGHT));
    let dry = last(CommandPath::DryRun, &[UP, ENGAGE, SEEN]);
    assert_eq!((dry.mode, dry.command), (Mode::Holding(HoldCause::DryRun), REST));
    assert_eq!(dry.advice.unwrap().command, PAN_RIGHT, "a dry run shows advice");
}

#[test]
fn control_that_is_not_ours_rests_the_camera() {
    let mode = Mode::Holding(HoldCause::NoControl);
    check(&[UP, ENGAGE, NOT_OURS, SEEN], mode, REST);
    check(&[UP, ENGAGE, NOT_OURS, SEEN, OURS, SEEN], Mode::Servoing, PAN_RIGHT);
    let back = [UP, ENGAGE, OURS, SEEN, Link(LinkState::Opening), UP, NOT_OURS];
    check(&back, mode, REST);
    check(&[&back[..], &[OURS, SEEN]].concat(), Mode::Servoing, PAN_RIGHT);
    check(&[UP, ENGAGE, OURS, SEEN], Mode::Servoing, PAN_RIGHT);
}

#[test]
fn what_a_vehicle_says_to_commands_rests_the_camera_as_long_as_it_lasts() {
    let accepted = Said(Acceptance::Accepted);
    for said in Acceptance::ALL.iter().copied().filter(|said| *said != Acceptance::Accepted) {
        // Said before the link is up, too: a vehicle answers while it is still being looked at.
        let held = Mode::Holding(HoldCause::NoControl);
        check(&[Link(LinkState::Starting), Said(said), UP, ENGAGE, SEEN], held, REST);
        check(
            &[Link(LinkState::Starting), Said(said), UP, ENGAGE, accepted, SEEN],
            Mode::Servoing,
            PAN_RIGHT,
        );
        let lost = if said.is_elsewhere() { Mode::Stopped(StopCause::ControlLost) } else { held };
        check(&[UP, accepted, ENGAGE, SEEN, Said(said)], lost, REST);
        let after = if said.is_elsewhere() { lost } else { Mode::Servoing };
        let command = if said.is_elsewhere() { REST } else { PAN_RIGHT };
        check(&[UP, accepted, ENGAGE, SEEN, Said(said), accepted, SEEN], after, command);
    }
}

#[test]
fn another_client_that_takes_the_control_during_a_fault_ends_the_engagement() {
    let scene = [
        UP,
        Said(Acceptance::Accepted),
        ENGAGE,
        SEEN,
        Said(Acceptance::NotReady),
        Said(Acceptance::OtherClient),
        Said(Acceptance::Queued),
    ];
    check(&scene, Mode::Stopped(StopCause::ControlLost), REST);
}

#[test]
fn control_that_is_taken_away_takes_a_new_engage() {
    let taken = [UP, ENGAGE, OURS, SEEN, NOT_OURS];
    let then = |more: &[Do]| [&taken[..], more].concat();
    let stopped = Mode::Stopped(StopCause::ControlLost);
    check(&taken, stopped, REST);
    check(&then(&[OURS, SEEN]), stopped, REST);
    check(&then(&[Link(LinkState::Starting), UP, OURS, SEEN]), stopped, REST);
    check(&then(&[ENGAGE, SEEN]), Mode::Holding(HoldCause::NoControl), REST);
    check(&then(&[OURS, ENGAGE, SEEN]), Mode::Servoing, PAN_RIGHT);
    check(&[UP, OURS, NOT_OURS, ENGAGE, OURS, SEEN], Mode::Servoing, PAN_RIGHT);
    check(&[UP, OURS, NOT_OURS], Mode::Idle, REST);
    // The start-up sequence itself gives the control away and takes it.
    let starts = [UP, ENGAGE, OURS, SEEN, Link(LinkState::Starting), OURS, NOT_OURS];
    check(&starts, DOWN, REST);
    check(&[&starts[..], &[UP, SEEN]].concat(), Mode::Servoing, PAN_RIGHT);
    check(&[&starts[..], &[UP, NOT_OURS, SEEN]].concat(), Mode::Holding(HoldCause::NoControl), REST);
}

#[test]
fn a_vehicle_that_restarts_takes_a_new_engage() {
    let restarted = [UP, ENGAGE, OURS, SEEN, Control(ControlState::Ours, 98.9)];
    check(&restarted, Mode::Stopped(StopCause::VehicleRestarted), REST);
    let not_ours = [UP, ENGAGE, OURS, SEEN, Control(ControlState::Elsewhere, 2.0)];
    check(&not_ours, Mode::Stopped(StopCause::VehicleRestarted), REST);
    check(&[&restarted[..], &[ENGAGE, SEEN]].concat(), Mode::Servoing, PAN_RIGHT);
    check(&[UP, ENGAGE, OURS, Control(ControlState::Ours, 99.1), SEEN], Mode::Servoing, PAN_RIGHT);
    let silent = [UP, ENGAGE, OURS, Link(LinkState::Opening), UP, Control(ControlState::Ours, 2.0), SEEN];
    check(&silent, Mode::Stopped(StopCause::VehicleRestarted), REST);
}

#[test]
fn an_emergency_and_a_landing_rest_the_camera_as_long_as_they_last() {
    for (state, stop, hold) in [
        (FlightState::Emergency, StopCause::Emergency, HoldCause::Emergency),
        (FlightState::Landing, StopCause::Landing, HoldCause::Landing),
    ] {
        let begun = [UP, ENGAGE, SEEN, Flight(state)];
        let then = |more: &[Do]| [&begun[..], more].concat();
        check(&begun, Mode::Stopped(stop), REST);
        check(&then(&[Flight(FlightState::Flying), SEEN]), Mode::Stopped(stop), REST);
        check(&then(&[ENGAGE, SEEN]), Mode::Holding(hold), REST);
        check(&then(&[ENGAGE, Flight(state), SEEN]), Mode::Holding(hold), REST);
        check(&then(&[ENGAGE, Flight(FlightState::Flying), SEEN]), Mode::Servoing, PAN_RIGHT);
    }
}

#[test]
fn a_battery_that_becomes_low_ends_an_engagement_once() {
    let low = [UP, ENGAGE, SEEN, Battery(false), Battery(true)];
    let then = |more: &[Do]| [&low[..], more].concat();
    check(&low, Mode::Stopped(StopCause::BatteryLow), REST);
    check(&then(&[ENGAGE, Battery(true), SEEN]), Mode::Servoing, PAN_RIGHT);
    check(&then(&[ENGAGE, SEEN, Battery(false), Battery(true)]), Mode::Stopped(StopCause::BatteryLow), REST);
    check(&[UP, ENGAGE, SEEN, Battery(true)], Mode::Stopped(StopCause::BatteryLow), REST);
    check(&[UP, Battery(true)], Mode::Idle, REST);
}

#[test]
fn a_nudge_is_refused_while_no_command_reaches_the_camera() {
    let refusal = |path, scene: &[Do]| match last(path, scene) {
        Outcome { notice: Some(Notice::RequestRefused(why)), mode: Mode::Idle, command: REST, .. } => {
            Some(why)
        }
        _ => None,
    };
    let no_motion = |cause| Some(Refusal::NoMotion(cause));
    assert_eq!(refusal(CommandPath::Link, &[SEEN, Nudges]), no_motion(HoldCause::LinkDown));
    assert_eq!(refusal(CommandPath::Link, &[SEEN, UP, Nudges]), None);
    assert_eq!(refusal(CommandPath::Link, &[SEEN, UP, NOT_OURS, Nudges]), no_motion(HoldCause::NoControl));
    assert_eq!(refusal(CommandPath::DryRun, &[SEEN, Nudges]), no_motion(HoldCause::DryRun));
    let emergency = [SEEN, UP, Flight(FlightState::Emergency), Nudges];
    assert_eq!(refusal(CommandPath::Link, &emergency), no_motion(HoldCause::Emergency));
}

#[test]
fn a_nudge_ends_with_the_link_and_is_not_taken_up_again() {
    let nudged = [SEEN, UP, Nudges];
    let then = |more: &[Do]| [&nudged[..], more].concat();
    assert_eq!(last(CommandPath::Link, &nudged).mode, Mode::Nudging);
    check(&then(&[Link(LinkState::Opening)]), Mode::Idle, REST);
    check(&then(&[Link(LinkState::Opening), UP]), Mode::Idle, REST);
    check(&then(&[Battery(true)]), Mode::Idle, REST);
    check(&then(&[Scene(Disengage)]), Mode::Idle, REST);
}

/// A law that turns right, and records the pan of its camera model, rad.
struct PanRecorder(Arc<Mutex<f64>>);

impl Law for PanRecorder {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        *self.0.lock().unwrap() = camera.angles_at(input.now).0;
        PAN_RIGHT
    }
}

/// The pan that the law believes in after 4 s of fresh looks, with a report of the link at 1 s and a hang of
/// the pilot.
fn believed_pan(path: CommandPath, reported: LinkState, hang_ms: u64) -> f64 {
    let believed = Arc::new(Mutex::new(f64::NAN));
    let settings = settings();
    let law = CameraLaw::from_law(Box::new(PanRecorder(Arc::clone(&believed))), &settings.profile);
    let mut pilot = Pilot::with_law(settings, law, Box::new(Scripted::default())).commanding(path);
    UP.step(&mut pilot, 0);
    ENGAGE.step(&mut pilot, 0);
    for ms in (100..4000).step_by(100) {
        if ms == 1000 {
            Link(reported).step(&mut pilot, ms);
        }
        if !(1000..1000 + hang_ms).contains(&ms) {
            SEEN.step(&mut pilot, ms);
        }
    }
    *believed.lock().unwrap()
}

#[test]
fn the_law_is_told_what_left_and_not_what_was_asked() {
    let turned = believed_pan(CommandPath::Link, LinkState::Up, 0);
    assert!((turned - 0.3 * 3.7).abs() < 0.25, "it turns at 0.3 rad/s, with dead time and lag: {turned}");
    let lost = believed_pan(CommandPath::Link, LinkState::Opening, 0);
    assert!((0.1..0.4).contains(&lost), "the camera rests from 1 s on: {lost}");
    assert_eq!(believed_pan(CommandPath::DryRun, LinkState::Up, 0), 0.0, "nothing was sent");
}

#[test]
fn the_law_is_told_that_the_link_rested_the_camera_of_a_pilot_that_was_held_up() {
    let turned = believed_pan(CommandPath::Link, LinkState::Up, 0);
    let held_up = believed_pan(CommandPath::Link, LinkState::Up, 2_000);
    let rested_s = (2_000 - COAST_MS - 50) as f64 * 1e-3;
    assert!((turned - held_up - 0.3 * rested_s).abs() < 0.1, "{turned} and {held_up}");
}
