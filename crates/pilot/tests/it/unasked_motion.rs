//! A camera that turns, and a boat that moves, although nothing of the kind is commanded: what is found, how
//! soon, and what is no fault.

use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_pilot::{CommandPath, Input, Outcome, Pilot, PilotSettings, VesselSettings};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::profile::MotionReports;
use barrelman_vocab::telemetry::{ControlState, EulerAxis, FlightState, LinkState, Quaternion, Report};
use barrelman_vocab::{
    Angle, CameraRequest, Nudge, OperatorRequest, StopCause, Telemetry, VehicleProfile, VesselCommand,
    VesselProfile, VesselRequest, VesselStopper, ZoomAbility,
};

use crate::scenes::SceneInput::{Engage, Seen};
use crate::scenes::{INSIDE, RIGHT, Scripted, at, settings};

/// A pilot with a vehicle that reports ten times a second.
struct Bench {
    pilot: Pilot,
    ms: u64,
    profile: VehicleProfile,
    pan: f64,
    tilt: f64,
}

impl Bench {
    fn new(profile: VehicleProfile) -> Self {
        let settings = PilotSettings { profile: profile.clone(), ..settings() };
        let pilot = Pilot::new(settings, Box::new(Scripted::default())).commanding(CommandPath::Link);
        let mut bench = Self { pilot, ms: 0, profile, pan: 0.0, tilt: -0.4 };
        bench.tell(Report::Link(LinkState::Up));
        bench
    }

    fn tell(&mut self, report: Report) -> Outcome {
        let now = at(self.ms);
        self.pilot.step(Input::Telemetry(Telemetry { at: now, report }), now)
    }

    fn report(&mut self) -> Outcome {
        let (pan, tilt) = (Angle::from_radians(self.pan), Angle::from_radians(self.tilt));
        if self.profile.name == "fotokite-pro" {
            self.tell(Report::VehicleAttitude(Quaternion::about(EulerAxis::Z, pan)));
            self.tell(Report::GimbalAttitude(Quaternion::about(EulerAxis::Y, tilt)))
        } else {
            self.tell(Report::CameraPan(pan));
            self.tell(Report::CameraTilt(tilt))
        }
    }

    /// Lets time pass with these rates. Returns after how many milliseconds the motion was found first.
    fn turn(&mut self, lasts_ms: u64, mut rates: impl FnMut(f64) -> (f64, f64)) -> Option<u64> {
        let began = self.ms;
        let mut found = None;
        for _ in 0..lasts_ms / 100 {
            self.ms += 100;
            let (pan, tilt) = rates((self.ms - began) as f64 * 1e-3);
            self.pan += 0.1 * pan;
            self.tilt += 0.1 * tilt;
            if self.report().unasked_motion.is_some() {
                found = found.or(Some(self.ms - began));
            }
        }
        found
    }

    /// The camera follows a boat to the right at full rate for a second.
    fn follow(&mut self) {
        self.pilot.step(Seen(RIGHT).input(at(self.ms)), at(self.ms));
        self.pilot.step(Engage.input(at(self.ms)), at(self.ms));
        for _ in 0..10 {
            self.ms += 100;
            let outcome = self.pilot.step(Seen(RIGHT).input(at(self.ms)), at(self.ms));
            assert!(!outcome.command.is_rest());
            self.pan += 0.03;
            assert_eq!(self.report().unasked_motion, None, "the camera is commanded to turn");
        }
    }

    fn stop(&mut self) {
        let request = OperatorRequest::Stop(StopCause::Operator);
        self.pilot.step(Input::Request(request), at(self.ms));
    }
}

fn all() -> [VehicleProfile; 4] {
    VehicleProfile::NAMES.map(|name| VehicleProfile::named(name).unwrap())
}

#[test]
fn a_camera_that_begins_to_turn_by_itself_is_found_within_half_a_second() {
    for profile in all() {
        for rates in [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.25)] {
            let mut bench = Bench::new(profile.clone());
            assert_eq!(bench.turn(3_000, |_| (0.0, 0.0)), None);
            let found = bench.turn(2_000, |_| rates).expect("found");
            assert!(found <= 500, "{} {rates:?}: {found} ms", profile.name);
            let turning = bench.report().unasked_motion.unwrap().radians_per_second();
            assert!((turning - 0.3).abs() < 0.06, "{turning}");
        }
    }
}

#[test]
fn a_stop_that_does_not_arrive_is_found_half_a_second_after_the_camera_should_have_slowed_down() {
    for profile in all() {
        let mut bench = Bench::new(profile.clone());
        bench.follow();
        bench.stop();
        let found = bench.turn(4_000, |_| (0.3, 0.0)).expect("found");
        let reaction_ms = profile.camera.pan.stop_dead_time.as_millis() as u64 + 100;
        assert!(found <= reaction_ms + 600, "{}: {found} ms", profile.name);
        // Until the motion ends, and no longer.
        assert!(bench.report().unasked_motion.is_some());
        bench.turn(700, |_| (0.0, 0.0));
        assert_eq!(bench.report().unasked_motion, None, "{}", profile.name);
    }
}

#[test]
fn a_camera_that_stops_as_its_profile_says_is_no_fault() {
    for profile in all() {
        let mut bench = Bench::new(profile.clone());
        bench.follow();
        bench.stop();
        let (dead, lag) =
            (profile.camera.pan.stop_dead_time.as_secs_f64(), profile.camera.pan.lag.as_secs_f64());
        let found =
            bench.turn(4_000, |s| (if s < dead { 0.3 } else { 0.3 * libm::exp(-(s - dead) / lag) }, 0.0));
        assert_eq!(found, None, "{}", profile.name);
    }
}

#[test]
fn a_kite_that_sways_is_no_fault_but_a_slow_turn_in_one_direction_is() {
    for profile in all() {
        let is_held = profile.protocol.motion_reports() == MotionReports::Held;
        let mut bench = Bench::new(profile.clone());
        // Eight degrees to and fro in six seconds.
        let sway = |s: f64| 0.14 * libm::cos(core::f64::consts::TAU / 6.0 * s);
        if !is_held {
            assert_eq!(bench.turn(60_000, |s| (sway(s), 0.5 * sway(s + 1.0))), None, "{}", profile.name);
        }
        let found = bench.turn(20_000, |_| (0.07, 0.0)).expect("found");
        assert!(found <= if is_held { 600 } else { 7_000 }, "{}: {found} ms", profile.name);
    }
}

#[test]
fn what_another_client_or_a_carried_vehicle_does_is_no_fault() {
    let flight = |state| Report::FlightState { state, is_battery_low: false };
    for profile in all() {
        let is_held = profile.protocol.motion_reports() == MotionReports::Held;
        for (report, is_excused) in [
            (Report::Control { control: ControlState::Elsewhere, uptime_s: 9.0 }, true),
            (Report::Control { control: ControlState::Unclaimed, uptime_s: 9.0 }, false),
            (Report::Control { control: ControlState::Ours, uptime_s: 9.0 }, false),
            (Report::Acceptance(Acceptance::OtherClient), true),
            (Report::Acceptance(Acceptance::FlightState), true),
            (Report::Acceptance(Acceptance::Unanswered), false),
            (flight(FlightState::Flying), false),
            (flight(FlightState::Idle), !is_held),
            (flight(FlightState::Landing), !is_held),
        ] {
            let mut bench = Bench::new(profile.clone());
            bench.tell(report);
            let found = bench.turn(2_000, |_| (0.3, 0.0));
            assert_eq!(found.is_none(), is_excused, "{} {report:?}", profile.name);
        }
    }
}

#[test]
fn motion_is_found_whatever_the_link_says_and_a_leap_of_the_attitude_is_none() {
    for state in [LinkState::Starting, LinkState::Silent, LinkState::Up] {
        let mut bench = Bench::new(VehicleProfile::mavlink_gimbal());
        bench.tell(Report::Link(state));
        assert!(bench.turn(2_000, |_| (0.3, 0.0)).is_some(), "{state:?}");
    }
    let mut bench = Bench::new(VehicleProfile::mavlink_gimbal());
    bench.turn(2_000, |_| (0.0, 0.0));
    bench.pan += 1.5;
    assert_eq!(bench.turn(2_000, |_| (0.0, 0.0)), None);
    // A port that is opened anew does not end what is known.
    bench.turn(2_000, |_| (0.3, 0.0));
    bench.tell(Report::Link(LinkState::Opening));
    assert!(bench.report().unasked_motion.is_some());
}

#[test]
fn a_nudge_ends_what_was_found_and_is_no_fault() {
    let mut bench = Bench::new(VehicleProfile::mavlink_gimbal());
    assert!(bench.turn(1_000, |_| (0.3, 0.0)).is_some());
    bench.pilot.step(Seen(INSIDE).input(at(bench.ms)), at(bench.ms));
    let nudge = OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan: 1.0, tilt: 0.0, zoom: 0.0 }));
    let outcome = bench.pilot.step(Input::Request(nudge), at(bench.ms));
    assert!(!outcome.command.is_rest() && outcome.unasked_motion.is_none(), "{:?}", outcome.mode);
}

#[test]
fn a_camera_that_zooms_and_turns_although_nobody_commands_it_is_found() {
    let mut bench = Bench::new(VehicleProfile::fotokite_sigma());
    bench.tell(Report::Zoom(ZoomAbility::Present));
    let zoom = OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan: 0.0, tilt: 0.0, zoom: 1.0 }));
    let found = (0..40_u64).find(|step| {
        bench.ms += 100;
        bench.pan += if *step < 20 { 0.0 } else { 0.03 };
        bench.pilot.step(Seen(INSIDE).input(at(bench.ms)), at(bench.ms));
        let outcome = bench.pilot.step(Input::Request(zoom), at(bench.ms));
        assert!(outcome.command.pan.is_zero() && !outcome.command.zoom.is_zero());
        bench.report().unasked_motion.is_some()
    });
    assert!(found.is_some_and(|step| (20..26).contains(&step)), "{found:?}");
}

/// How many milliseconds after neutral a boat is found to move that has this speed; it was at 3 m/s.
fn boat_found(speed: impl Fn(f64) -> f64, said: Acceptance, command: Option<OperatorRequest>) -> Option<u64> {
    let vessel = VesselSettings {
        profile: VesselProfile::SIMULATOR,
        guidance: GuidanceLaw::ByHand,
        path: CommandPath::Link,
    };
    let mut pilot = Pilot::new(settings(), Box::new(Scripted::default())).with_vessel(vessel);
    let mut tell = |ms: u64, report| {
        let input = Input::VesselTelemetry(Telemetry { at: at(ms), report });
        pilot.step(input, at(ms)).vessel.unasked_speed_m_per_s
    };
    tell(0, Report::Link(LinkState::Up));
    tell(0, Report::Acceptance(said));
    for ms in (0..1_000).step_by(200) {
        tell(ms, Report::Speed(3.0));
    }
    if let Some(command) = command {
        pilot.step(Input::Request(command), at(1_000));
    }
    (1_000_u64..16_000).step_by(200).find_map(|ms| {
        let report = Report::Speed(speed((ms - 1_000) as f64 * 1e-3));
        let input = Input::VesselTelemetry(Telemetry { at: at(ms), report });
        let found = pilot.step(input, at(ms)).vessel.unasked_speed_m_per_s;
        found.map(|_| ms - 1_000)
    })
}

#[test]
fn a_boat_whose_drive_goes_on_is_found_and_one_that_runs_out_or_drifts_is_not() {
    let stop = Some(OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator }));
    let steered =
        Some(OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand { throttle: 1.0, rudder: 0.0 })));
    let goes_on: fn(f64) -> f64 = |_| 3.0;
    let gets_faster: fn(f64) -> f64 = |s| 1.0 + s;
    for (speed, said, command, is_found) in [
        (goes_on, Acceptance::Accepted, stop, true),
        (gets_faster, Acceptance::Accepted, stop, true),
        (|s| 3.0 * libm::exp(-s / 5.0) + 0.4, Acceptance::Accepted, stop, false),
        (|s| 0.9 + 0.5 * libm::sin(1.5 * s), Acceptance::Accepted, stop, false),
        (goes_on, Acceptance::OtherClient, stop, false),
        (goes_on, Acceptance::Accepted, None, false),
        (goes_on, Acceptance::Accepted, steered, false),
    ] {
        let found = boat_found(speed, said, command);
        assert_eq!(found.is_some(), is_found, "{said:?} {command:?} {}", speed(1.0));
        assert!(found.is_none_or(|ms| ms <= 3_000), "{found:?}");
    }
}
