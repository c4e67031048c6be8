//! The boat as the second actuator: marks that stay on the water, guidance, and what stops the boat.

use core::time::Duration;
use std::sync::Arc;

use barrelman_pilot::on_earth::NotOnEarth;
use barrelman_pilot::vessel::guiding::NoWater;
use barrelman_pilot::vessel::{GuidanceBasis, GuidanceLaw, Mark, VesselHold, VesselStop};
use barrelman_pilot::{CommandPath, Input, Notice, Outcome, Pilot, Refusal, VesselMode, VesselSettings};
use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{
    Angle, CameraRequest, DrawnMark, FailSafe, HoldCause, ImagePoint, KeepWay, MarkKind, MovedMark, Nudge,
    OperatorRequest, PixelPoint, StopCause, Telemetry, Timestamp, Track, VesselCommand, VesselProfile,
    VesselRequest, VesselStopper, WaterPoint,
};
use proptest::prelude::*;

use crate::scenes::{
    self, INSIDE, LATENCY_MS, PICTURE, SceneInput, Scripted, at, frame, localisation_pilot, seen,
};

/// A point of the water below the horizon, right of the boat.
pub(crate) const TARGET: PixelPoint = PixelPoint { u: 480.0, v: 330.0 };
pub(crate) const AHEAD: VesselCommand = VesselCommand { throttle: 1.0, rudder: 0.5 };

fn settings(guidance: GuidanceLaw) -> VesselSettings {
    VesselSettings { profile: VesselProfile::SIMULATOR, guidance, path: CommandPath::Simulated }
}

/// A pilot with a boat, and its time.
pub(crate) struct Bench {
    pub(crate) pilot: Pilot,
    pub(crate) ms: u64,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::with(GuidanceLaw::LineOfSight)
    }

    /// A boat that keeps way.
    fn keeping_way() -> Self {
        let fail_safe = FailSafe::KeepWay(KeepWay { throttle: 0.2, lasts: Duration::from_secs(2) });
        let profile = VesselProfile { fail_safe, ..VesselProfile::SIMULATOR };
        let settings = VesselSettings { profile, ..settings(GuidanceLaw::LineOfSight) };
        Self { pilot: localisation_pilot().with_vessel(settings), ms: 1_000 }
    }

    fn with(guidance: GuidanceLaw) -> Self {
        Self { pilot: localisation_pilot().with_vessel(settings(guidance)), ms: 1_000 }
    }

    fn step(&mut self, input: Input<'_>) -> Outcome {
        self.pilot.step(input, at(self.ms))
    }

    /// A boat that goes to a place in the picture: neither height nor tilt is reported.
    fn going_in_the_picture() -> Self {
        let mut bench = Self::new();
        bench.see(INSIDE);
        bench.mark(MarkKind::Place, TARGET);
        bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
        bench
    }

    pub(crate) fn ask(&mut self, request: OperatorRequest) -> Outcome {
        self.step(Input::Request(request))
    }

    fn tell(&mut self, report: Report) -> Outcome {
        let telemetry = Telemetry { at: at(self.ms), report };
        self.step(Input::Telemetry(telemetry))
    }

    /// Height and tilt are known.
    pub(crate) fn see_water(&mut self) -> &mut Self {
        self.tell(Report::CameraTilt(Angle::from_degrees(-40.0)));
        self.tell(Report::CameraHeight(15.0));
        self
    }

    /// The boat is seen there, a video frame later.
    pub(crate) fn see(&mut self, point: ImagePoint) -> Outcome {
        self.ms += 33;
        let captured = at(self.ms).minus(Duration::from_millis(LATENCY_MS));
        self.step(Input::Localisation(Track::Tracking(seen(point, captured))))
    }

    pub(crate) fn mark(&mut self, kind: MarkKind, pixel: PixelPoint) -> Outcome {
        let captured = at(self.ms).minus(Duration::from_millis(LATENCY_MS));
        self.ask(OperatorRequest::Vessel(VesselRequest::Mark(DrawnMark {
            mark: kind,
            at: pixel,
            captured_ns: captured,
        })))
    }

    fn move_mark(&mut self, id: u32, pixel: PixelPoint) -> Outcome {
        let captured = at(self.ms).minus(Duration::from_millis(LATENCY_MS));
        self.ask(OperatorRequest::Vessel(VesselRequest::MoveMark(MovedMark {
            id,
            at: pixel,
            captured_ns: captured,
        })))
    }

    /// The boat is seen and goes to a mark over the water.
    pub(crate) fn going(kind: MarkKind) -> Self {
        let mut bench = Self::new();
        bench.see_water().see(INSIDE);
        bench.mark(kind, TARGET);
        let outcome = bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
        assert_eq!(outcome.notice, Some(Notice::Going(None)));
        for _ in 0..10 {
            bench.see(INSIDE);
        }
        let outcome = bench.see(INSIDE);
        assert_eq!(outcome.vessel.mode, VesselMode::Guided);
        assert!(outcome.vessel.command.throttle > 0.1, "{:?}", outcome.vessel.command);
        bench
    }
}

/// What a boat that keeps way does half a second after its track was lost, on its way to a place far away;
/// with more marks, and what the operator asks for meanwhile.
fn after_loss(more: &[(MarkKind, PixelPoint)], meanwhile: Option<OperatorRequest>) -> Outcome {
    let mut bench = Bench::keeping_way();
    bench.see_water().see(INSIDE);
    bench.mark(MarkKind::Place, PixelPoint { u: 330.0, v: 90.0 });
    for (kind, pixel) in more {
        assert!(matches!(bench.mark(*kind, *pixel).notice, Some(Notice::Marked(..))));
    }
    bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    for step in 0..60 {
        // The boat goes away from the camera.
        let outcome = bench.see(ImagePoint { x: 0.0, y: -20.0 + f64::from(step) });
        assert_eq!(outcome.vessel.mode, VesselMode::Guided);
    }
    bench.ms += 300;
    let lost = bench.step(Input::Tick);
    if let Some(request) = meanwhile {
        assert!(matches!(lost.vessel.mode, VesselMode::KeepingWay(_)), "{:?}", lost.vessel.mode);
        bench.ask(request);
    }
    bench.ms += 200;
    bench.step(Input::Tick)
}

#[test]
fn a_boat_that_shall_keeps_way_far_from_all_marks() {
    let way = VesselCommand { throttle: 0.2, rudder: 0.0 };
    let outcome = after_loss(&[], None);
    assert!(matches!(outcome.vessel.mode, VesselMode::KeepingWay(_)), "{:?}", outcome.vessel.guidance);
    assert_eq!(outcome.vessel.command, way);
    // A person, or an area, near the boat: no way is kept. A way-point is nothing to keep away from.
    let beside = PixelPoint { u: 480.0, v: 240.0 };
    for kind in [MarkKind::Person, MarkKind::Forbidden] {
        assert_eq!(after_loss(&[(kind, beside)], None).vessel.command, VesselCommand::NEUTRAL, "{kind:?}");
    }
    assert_eq!(
        after_loss(&[(MarkKind::WayPoint, PixelPoint { u: 325.0, v: 120.0 })], None).vessel.command,
        way
    );
    for request in [
        OperatorRequest::Stop(StopCause::Operator),
        OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator }),
        OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::ConsoleLost }),
        OperatorRequest::Camera(CameraRequest::Deselect),
        OperatorRequest::Vessel(VesselRequest::UnmarkAll),
        OperatorRequest::Vessel(VesselRequest::NextMark),
        OperatorRequest::Vessel(VesselRequest::ReleaseVessel),
    ] {
        assert_eq!(after_loss(&[], Some(request)).vessel.command, VesselCommand::NEUTRAL, "{request:?}");
    }
}

#[test]
fn the_water_lies_on_earth_while_position_and_direction_are_reported() {
    let degrees = Angle::from_degrees;
    let position = |latitude| Report::Position {
        latitude: degrees(latitude),
        longitude: degrees(-10.0),
        altitude_m: 60.0,
        height_m: 15.0,
        heading: Some(degrees(12.0)),
    };
    let mut bench = Bench::new();
    assert_eq!(bench.see(INSIDE).earth, Err(NotOnEarth::NoPosition));
    let outcome = bench.tell(position(54.0));
    assert_eq!(outcome.earth, Err(NotOnEarth::NoHeading), "the vehicle's nose is not the camera's axis");
    let earth = bench.tell(Report::CameraHeading(degrees(100.0))).earth.unwrap();
    assert_eq!(earth.origin, GeoPoint { latitude: degrees(54.0), longitude: degrees(-10.0) });
    assert!((earth.ahead.degrees() - 100.0).abs() < 1e-9, "{earth:?}");
    assert_eq!(bench.tell(position(f64::NAN)).earth, Ok(earth), "no number is no report");
    // The camera turns right: what is ahead at pan 0 stays where it is.
    for _ in 0..20 {
        bench.see(INSIDE);
        bench.ask(OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan: 1.0, tilt: 0.0, zoom: 0.0 })));
    }
    let turned = bench.tell(Report::CameraHeading(degrees(110.0)));
    let pan = turned.net_yaw.angle.degrees();
    assert!(pan > 0.5, "{pan}");
    assert!((turned.earth.unwrap().ahead.degrees() - (110.0 - pan)).abs() < 1e-9, "{turned:?}");
    bench.ms += 3_100;
    assert!(bench.step(Input::Tick).earth.is_err(), "too long ago");
    let outcome = bench.tell(position(54.0));
    assert_eq!(outcome.earth, Err(NotOnEarth::NoHeading));
    assert!(bench.tell(Report::CameraHeading(degrees(120.0))).earth.is_ok());
    let outcome = bench.tell(Report::Link(LinkState::Opening));
    assert_eq!(outcome.earth, Err(NotOnEarth::NoPosition), "maybe another vehicle");
}

#[track_caller]
fn refused(outcome: &Outcome, refusal: Refusal) {
    assert_eq!(outcome.notice, Some(Notice::RequestRefused(refusal)));
}

#[test]
fn a_pilot_without_a_boat_refuses_what_is_about_one() {
    let mut pilot = localisation_pilot();
    for request in [
        OperatorRequest::Vessel(VesselRequest::Guide),
        OperatorRequest::Vessel(VesselRequest::Steer(AHEAD)),
        OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator }),
        OperatorRequest::Vessel(VesselRequest::UnmarkAll),
    ] {
        let outcome = pilot.step(Input::Request(request), at(0));
        refused(&outcome, Refusal::NoVessel);
        assert_eq!(outcome.vessel.mode, VesselMode::Absent);
    }
}

#[test]
fn guidance_needs_a_mark_and_a_boat_that_is_seen() {
    let mut bench = Bench::new();
    refused(&bench.ask(OperatorRequest::Vessel(VesselRequest::Guide)), Refusal::NothingMarked);
    refused(&bench.mark(MarkKind::Place, TARGET), Refusal::NoFreshVideo);
    bench.see_water().see(INSIDE);
    assert_eq!(bench.mark(MarkKind::Place, TARGET).notice, Some(Notice::Marked(1, MarkKind::Place)));
    bench.step(SceneInput::Lost.input(at(bench.ms)));
    refused(&bench.ask(OperatorRequest::Vessel(VesselRequest::Guide)), Refusal::BoatNotSeen);
    refused(&bench.ask(OperatorRequest::Vessel(VesselRequest::GoHome)), Refusal::NoHome);
    let mut by_hand = Bench::with(GuidanceLaw::ByHand);
    by_hand.see_water().see(INSIDE);
    by_hand.mark(MarkKind::Place, TARGET);
    refused(&by_hand.ask(OperatorRequest::Vessel(VesselRequest::Guide)), Refusal::ByHandOnly);
}

#[test]
fn guidance_needs_fresh_video() {
    let asked_after = |ms: u64, request: OperatorRequest| {
        let mut bench = Bench::new();
        bench.see_water().see(INSIDE);
        bench.mark(MarkKind::Home, TARGET);
        bench.mark(MarkKind::Place, TARGET);
        bench.ms += ms;
        let asked = bench.ask(request).notice;
        // The video is back.
        bench.see_water().see(INSIDE);
        (asked, bench.see(INSIDE).vessel.mode)
    };
    let refused = Some(Notice::RequestRefused(Refusal::NoFreshVideo));
    for request in
        [OperatorRequest::Vessel(VesselRequest::Guide), OperatorRequest::Vessel(VesselRequest::GoHome)]
    {
        assert_eq!(asked_after(249, request), (Some(Notice::Going(None)), VesselMode::Guided), "{request:?}");
        for ms in [250, 60_000] {
            assert_eq!(asked_after(ms, request), (refused.clone(), VesselMode::Released), "{request:?}");
        }
    }
}

#[test]
fn a_mark_stays_on_the_water_while_the_camera_turns() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    bench.mark(MarkKind::Place, TARGET);
    let pixel = |outcome: &Outcome| {
        let frame_view = outcome.vessel.frame_view.unwrap();
        outcome.vessel.marks.destination().unwrap().pixel(&frame_view, outcome.at).unwrap()
    };
    let before = bench.see(INSIDE);
    let first = pixel(&before);
    assert!((first.u - TARGET.u).abs() < 1e-6 && (first.v - TARGET.v).abs() < 1e-6);
    let water = before.vessel.marks.destination().unwrap().point(before.at).unwrap();
    for _ in 0..60 {
        bench.ask(OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan: 1.0, tilt: 0.0, zoom: 0.0 })));
        bench.see(INSIDE);
    }
    let after = bench.see(INSIDE);
    assert!(pixel(&after).u < TARGET.u - 20.0, "the view turned to the right: {:?}", pixel(&after));
    assert_eq!(after.vessel.marks.destination().unwrap().point(after.at), Some(water));
    let seen = after.vessel.frame_view.unwrap().view.sighting(pixel(&after)).point().unwrap();
    assert!(seen.distance_to(water) < 1e-6, "{seen:?} {water:?}");
}

#[test]
fn marks_at_the_horizon_too_many_and_too_old_ones_are_refused() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    refused(&bench.mark(MarkKind::Person, PixelPoint { u: 320.0, v: -400.0 }), Refusal::MarkNotOnWater);
    for id in 1..=16 {
        let kind = MarkKind::Forbidden;
        assert_eq!(bench.mark(kind, TARGET).notice, Some(Notice::Marked(id, kind)));
    }
    refused(&bench.mark(MarkKind::Place, TARGET), Refusal::TooManyMarks);
    refused(&bench.ask(OperatorRequest::Vessel(VesselRequest::Unmark { id: 99 })), Refusal::NoSuchMark);
    assert_eq!(bench.ask(OperatorRequest::Vessel(VesselRequest::Unmark { id: 3 })).notice, None);
    bench.ms += 1_600;
    let old = DrawnMark { mark: MarkKind::Place, at: TARGET, captured_ns: at(bench.ms - 1_501) };
    let outcome = bench.ask(OperatorRequest::Vessel(VesselRequest::Mark(old)));
    assert!(matches!(outcome.notice, Some(Notice::RequestRefused(Refusal::SelectionTooOld { .. }))));
    let early = DrawnMark { mark: MarkKind::Place, at: TARGET, captured_ns: at(bench.ms + 1) };
    refused(&bench.ask(OperatorRequest::Vessel(VesselRequest::Mark(early))), Refusal::NotYetCaptured);
}

#[test]
fn a_person_who_was_marked_before_the_height_was_known_has_a_circle_when_it_is() {
    let mut bench = Bench::new();
    bench.tell(Report::CameraTilt(Angle::from_degrees(-40.0)));
    bench.see(INSIDE);
    bench.mark(MarkKind::Person, PixelPoint { u: 400.0, v: 260.0 });
    bench.mark(MarkKind::Place, TARGET);
    bench.ask(OperatorRequest::Vessel(VesselRequest::NextMark));
    let marks = |outcome: &Outcome| outcome.vessel.marks.iter().copied().collect::<Vec<_>>();
    refused(
        &bench.ask(OperatorRequest::Vessel(VesselRequest::Guide)),
        Refusal::PictureOnly(NoWater::NoHeight),
    );
    let before = bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    assert_eq!(before.notice, Some(Notice::Going(Some(NoWater::NoHeight))));
    assert!(marks(&before).iter().all(|mark| mark.water.is_none()));
    bench.see_water();
    let after = bench.see(INSIDE);
    assert_eq!(after.vessel.mode, VesselMode::Guided);
    assert_eq!(after.vessel.guidance.map(|guidance| guidance.basis), Some(GuidanceBasis::Water));
    assert!(marks(&after).iter().all(|mark| mark.water.is_some()), "{:?}", marks(&after));
    assert!(marks(&after)[0].drift.is_some());
}

#[test]
fn a_mark_that_was_set_before_any_tilt_was_reported_gets_no_place_until_it_is_moved() {
    let distance_m = |outcome: &Outcome| {
        let point = outcome.vessel.marks.destination().unwrap().point(outcome.at)?;
        Some(point.distance_to(WaterPoint { x: 0.0, y: 0.0 }))
    };
    let mut bench = Bench::new();
    bench.see(INSIDE);
    bench.mark(MarkKind::Person, TARGET);
    bench.see_water().see(INSIDE);
    bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    let unplaced = bench.see(INSIDE);
    assert_eq!(distance_m(&unplaced), None);
    assert_eq!(unplaced.vessel.mode, VesselMode::Holding(VesselHold::UnplacedMark));
    assert_eq!(bench.move_mark(1, TARGET).notice, None);
    let placed = bench.see(INSIDE);
    assert_eq!(placed.vessel.mode, VesselMode::Guided);
}

#[test]
fn a_guided_boat_waits_while_a_person_has_no_place_on_the_water() {
    let mut bench = Bench::new();
    bench.see(INSIDE);
    // Below the horizon, but too near to it for a place.
    let far = (0..180)
        .map(|v| PixelPoint { u: 320.0, v: f64::from(v) })
        .find(|pixel| matches!(bench.mark(MarkKind::Person, *pixel).notice, Some(Notice::Marked(..))));
    assert!(far.is_some());
    bench.tell(Report::CameraTilt(Angle::from_degrees(-10.0)));
    bench.tell(Report::CameraHeight(15.0));
    bench.see(INSIDE);
    bench.mark(MarkKind::Place, TARGET);
    bench.ask(OperatorRequest::Vessel(VesselRequest::NextMark));
    bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    let outcome = bench.see(INSIDE);
    let mode = VesselMode::Holding(VesselHold::UnplacedMark);
    assert_eq!((outcome.vessel.mode, outcome.vessel.command), (mode, VesselCommand::NEUTRAL));
    bench.ask(OperatorRequest::Vessel(VesselRequest::Unmark { id: 1 }));
    assert_eq!(bench.see(INSIDE).vessel.mode, VesselMode::Guided);
}

#[test]
fn a_guided_boat_without_a_place_on_the_water_waits_and_does_not_start_again_by_itself() {
    let without_place_for = |bench: &mut Bench, ms: u64| {
        let until = bench.ms + ms;
        let mut modes = Vec::new();
        while bench.ms < until {
            // The camera is tilted up, and the boat seen above the horizon.
            bench.tell(Report::CameraTilt(Angle::from_degrees(20.0)));
            let outcome = bench.see(INSIDE);
            modes.push((outcome.vessel.mode, outcome.vessel.command.is_neutral()));
        }
        modes
    };
    let held = VesselMode::Holding(VesselHold::NoPlace);

    let mut bench = Bench::going(MarkKind::Place);
    let modes = without_place_for(&mut bench, 3_000);
    assert_eq!(modes.last(), Some(&(held, true)), "{modes:?}");
    for _ in 0..60 {
        bench.see_water().see(INSIDE);
    }
    assert_eq!(bench.see(INSIDE).vessel.mode, VesselMode::Guided, "after a short wait it goes on");

    let mut bench = Bench::going(MarkKind::Place);
    let modes = without_place_for(&mut bench, 8_000);
    let stopped = VesselMode::Stopped(VesselStop::HeldTooLong(VesselHold::NoPlace));
    assert_eq!(modes.last(), Some(&(stopped, true)));
    for _ in 0..60 {
        assert!(bench.see_water().see(INSIDE).vessel.command.is_neutral());
    }
}

#[test]
fn marks_that_change_no_way_point_do_not_send_the_boat_back_to_the_first() {
    type Change<'a> = &'a dyn Fn(&mut Bench) -> Outcome;
    let aside = PixelPoint { u: 560.0, v: 330.0 };
    let leg_after = |change: Change<'_>| {
        let mut bench = Bench::new();
        bench.see_water().see(INSIDE);
        // The boat lies at the first way-point.
        bench.mark(MarkKind::WayPoint, INSIDE.in_pixels(PICTURE));
        bench.mark(MarkKind::WayPoint, PixelPoint { u: 600.0, v: 200.0 });
        bench.mark(MarkKind::Person, TARGET);
        bench.mark(MarkKind::Forbidden, PixelPoint { u: 60.0, v: 200.0 });
        bench.mark(MarkKind::Person, PixelPoint { u: 80.0, v: 400.0 });
        bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
        let mut x = INSIDE.x;
        let mut leg = |bench: &mut Bench| {
            let mut leg = None;
            for _ in 0..60 {
                // Then it goes on to the right.
                x = (x + 2.0).min(140.0);
                let outcome = bench.see_water().see(ImagePoint { x, ..INSIDE });
                leg = outcome.vessel.guidance.and_then(|guidance| guidance.progress).map(|way| way.leg);
            }
            leg
        };
        assert_eq!(leg(&mut bench), Some(1));
        change(&mut bench);
        leg(&mut bench).unwrap()
    };
    let expected: [(&str, usize, Change<'_>); 9] = [
        ("the destination is moved", 1, &|bench| bench.move_mark(3, aside)),
        ("a person is marked", 1, &|bench| bench.mark(MarkKind::Person, aside)),
        ("an area is marked", 1, &|bench| bench.mark(MarkKind::Forbidden, aside)),
        ("home is marked", 1, &|bench| bench.mark(MarkKind::Home, aside)),
        ("an area is removed", 1, &|bench| {
            bench.ask(OperatorRequest::Vessel(VesselRequest::Unmark { id: 4 }))
        }),
        ("a person is removed", 1, &|bench| {
            bench.ask(OperatorRequest::Vessel(VesselRequest::Unmark { id: 5 }))
        }),
        ("a way-point is marked", 0, &|bench| bench.mark(MarkKind::WayPoint, aside)),
        ("a way-point is moved", 0, &|bench| bench.move_mark(2, aside)),
        ("another destination is chosen", 0, &|bench| {
            bench.ask(OperatorRequest::Vessel(VesselRequest::NextMark))
        }),
    ];
    for (what, leg, change) in expected {
        assert_eq!(leg_after(change), leg, "{what}");
    }
}

#[test]
fn a_boat_guided_in_the_picture_does_not_start_by_itself_long_after_its_destination_was_behind_the_camera() {
    let after = |frames: u32| {
        let mut bench = Bench::new();
        bench.tell(Report::CameraTilt(Angle::from_degrees(-80.0)));
        bench.see(INSIDE);
        bench.mark(MarkKind::Place, PixelPoint { u: 480.0, v: 470.0 });
        bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
        assert_eq!(bench.see(INSIDE).vessel.mode, VesselMode::Guided);
        let mut away = bench.see(INSIDE);
        for _ in 0..frames {
            // The camera looks up and back.
            bench.tell(Report::CameraTilt(Angle::from_degrees(20.0)));
            away = bench.see(INSIDE);
        }
        for _ in 0..90 {
            bench.tell(Report::CameraTilt(Angle::from_degrees(-80.0)));
            bench.see(INSIDE);
        }
        (away.vessel.mode, bench.see(INSIDE).vessel.mode)
    };
    let stopped = VesselMode::Stopped(VesselStop::HeldTooLong(VesselHold::NoPlace));
    assert_eq!(after(300), (stopped, stopped));
    let held = VesselMode::Holding(VesselHold::NoPlace);
    assert_eq!(after(90), (held, VesselMode::Guided), "after a short wait it goes on");
}

#[test]
fn the_place_of_a_person_gets_less_certain_and_that_of_everything_else_does_not() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    let kinds = [MarkKind::Person, MarkKind::Place, MarkKind::WayPoint, MarkKind::Forbidden, MarkKind::Home];
    for (kind, u) in kinds.into_iter().zip([260.0, 290.0, 320.0, 350.0, 380.0]) {
        bench.mark(kind, PixelPoint { u, v: 300.0 });
    }
    let marks = bench.see(INSIDE).vessel.marks;
    let grows = |mark: &Mark| mark.std_dev_m(at(60_000)) > mark.std_dev_m(at(1_000));
    let growing: Vec<_> = marks.iter().filter(|mark| grows(mark)).map(|mark| mark.kind).collect();
    assert_eq!((marks.iter().count(), growing), (kinds.len(), vec![MarkKind::Person]));
}

#[test]
fn a_person_stays_the_destination_and_a_place_gives_way() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    let destination = |outcome: &Outcome| outcome.vessel.marks.destination().map(|mark| mark.id);
    assert_eq!(destination(&bench.mark(MarkKind::Place, TARGET)), Some(1));
    assert_eq!(destination(&bench.mark(MarkKind::Place, TARGET)), Some(2));
    assert_eq!(destination(&bench.mark(MarkKind::Person, TARGET)), Some(3));
    assert_eq!(destination(&bench.mark(MarkKind::Person, TARGET)), Some(3));
    assert_eq!(destination(&bench.ask(OperatorRequest::Vessel(VesselRequest::NextMark))), Some(4));
    assert_eq!(destination(&bench.ask(OperatorRequest::Vessel(VesselRequest::NextMark))), Some(1));
    assert_eq!(destination(&bench.ask(OperatorRequest::Vessel(VesselRequest::Unmark { id: 1 }))), None);
    assert_eq!(destination(&bench.ask(OperatorRequest::Vessel(VesselRequest::NextMark))), Some(2));
}

#[test]
fn the_mark_of_a_person_that_is_moved_drifts_on() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    bench.mark(MarkKind::Person, TARGET);
    let person = |outcome: &Outcome| *outcome.vessel.marks.destination().unwrap();
    let first = person(&bench.see(INSIDE));
    let move_by =
        |bench: &mut Bench, id: u32, px: f64| bench.move_mark(id, PixelPoint { u: TARGET.u + px, ..TARGET });
    refused(&move_by(&mut bench, 7, 1.0), Refusal::NoSuchMark);
    for index in 1..=3 {
        for _ in 0..151 {
            bench.see_water().see(INSIDE);
        }
        assert_eq!(move_by(&mut bench, 1, 30.0 * f64::from(index)).notice, None);
    }
    let outcome = bench.see(INSIDE);
    assert_eq!(outcome.vessel.marks.iter().count(), 1);
    let (vx, vy) = person(&outcome).velocity_m_per_s();
    // The estimate lies between none and what the marks tell.
    let last = person(&outcome);
    let duration_s = last.marked.since(first.marked).as_secs_f64();
    let (x, y) = first.water.unwrap().point.vector_to(last.water.unwrap().point);
    let share = vx * duration_s / x;
    assert!((0.5..1.1).contains(&share), "{vx} {x} {share}");
    assert!(vy.abs() < 1e-9 && y.abs() < 1e-9, "it was moved to the right: {vy} {y}");
    let before = person(&outcome).point(outcome.at).unwrap();
    for _ in 0..30 {
        bench.see_water().see(INSIDE);
    }
    let later = bench.see_water().see(INSIDE);
    let after = person(&later).point(later.at).unwrap();
    let expected = vx * later.at.since(outcome.at).as_secs_f64();
    assert!((after.x - before.x - expected).abs() < 1e-9, "{after:?} {before:?}");
}

#[test]
fn a_corrected_mark_of_a_person_at_rest_tells_no_drift() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    bench.mark(MarkKind::Person, TARGET);
    // The hand missed: the mark is corrected a second later, and stays there.
    for (frames, px) in [(30, 60.0), (90, 60.0)] {
        for _ in 0..frames {
            bench.see_water().see(INSIDE);
        }
        let moved = bench.move_mark(1, PixelPoint { u: TARGET.u + px, ..TARGET });
        assert_eq!(moved.notice, None);
    }
    let (vx, vy) = bench.see(INSIDE).vessel.marks.destination().unwrap().velocity_m_per_s();
    let speed = libm::hypot(vx, vy);
    assert!(speed < 1e-6, "{speed}");
}

#[test]
fn the_large_stop_stops_both_and_stop_boat_the_boat_alone() {
    let mut bench = Bench::going(MarkKind::Place);
    bench.ask(OperatorRequest::Camera(CameraRequest::Engage));
    let outcome =
        bench.ask(OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator }));
    assert_eq!(outcome.vessel.mode, VesselMode::Stopped(VesselStop::Operator));
    assert!(outcome.vessel.command.is_neutral() && outcome.mode.to_string() != "stopped by the operator");

    let mut bench = Bench::going(MarkKind::Place);
    let outcome = bench.ask(OperatorRequest::Stop(StopCause::Operator));
    assert_eq!(outcome.vessel.mode, VesselMode::Stopped(VesselStop::Everything(StopCause::Operator)));
    assert_eq!(outcome.mode, barrelman_pilot::Mode::Stopped(StopCause::Operator));
    bench.ask(OperatorRequest::Camera(CameraRequest::Engage));
    assert!(bench.see(INSIDE).vessel.command.is_neutral(), "Engage is about the camera alone");
}

#[test]
fn another_selection_ends_the_guidance() {
    for request in [OperatorRequest::Camera(CameraRequest::Deselect), SceneInput::Select.request()] {
        let mut bench = Bench::going(MarkKind::Person);
        let outcome = bench.ask(request);
        assert_eq!(outcome.vessel.mode, VesselMode::Stopped(VesselStop::OtherBoat), "{request:?}");
        assert!(outcome.vessel.command.is_neutral());
    }
}

#[test]
fn a_boat_that_is_lost_is_neutral_within_a_quarter_of_a_second() {
    let mut bench = Bench::going(MarkKind::Place);
    let last_seen = bench.ms;
    loop {
        bench.ms += 33;
        let now = at(bench.ms);
        let outcome = bench.step(SceneInput::Lost.input(now));
        if outcome.vessel.command.is_neutral() {
            let hold = VesselHold::Cause(HoldCause::TrackLost);
            assert_eq!(outcome.vessel.mode, VesselMode::Holding(hold));
            break;
        }
        assert!(bench.ms - last_seen < 250);
    }
    assert!(bench.ms - last_seen <= 283);
}

#[test]
fn the_tracker_takes_the_path_for_the_bows_while_the_boat_goes_ahead_or_another_hand_steers() {
    let tracker = Scripted::default();
    let told = Arc::clone(&tracker.is_bow_first);
    let pilot = Pilot::new(scenes::settings(), Box::new(tracker));
    let mut bench = Bench { pilot: pilot.with_vessel(settings(GuidanceLaw::LineOfSight)), ms: 1_000 };
    let mut told_after = |throttle: Option<f64>| {
        for _ in 0..60 {
            if let Some(throttle) = throttle {
                let helm = VesselCommand { throttle, rudder: 0.0 };
                bench.ask(OperatorRequest::Vessel(VesselRequest::Steer(helm)));
            }
            bench.ms += 33;
            bench.step(Input::Frame(&frame(bench.ms, at(bench.ms - LATENCY_MS))));
        }
        told.lock().unwrap().unwrap()
    };
    let told = [None, Some(-0.5), Some(0.0), Some(0.5)].map(&mut told_after);
    assert_eq!(told, [true, false, false, true]);
}

#[test]
fn without_height_or_tilt_the_boat_is_guided_by_the_picture() {
    let mut bench = Bench::going_in_the_picture();
    for _ in 0..10 {
        bench.see(INSIDE);
    }
    let outcome = bench.see(INSIDE);
    let guidance = outcome.vessel.guidance.unwrap();
    assert_eq!((guidance.basis, guidance.progress), (GuidanceBasis::Picture, None));
    assert!(outcome.vessel.command.throttle > 0.0);
    // Near a person the boat stops, some of its lengths away.
    let mut bench = Bench::new();
    bench.see(INSIDE);
    let near = INSIDE.in_pixels(crate::scenes::PICTURE);
    bench.mark(MarkKind::Person, PixelPoint { u: near.u + 50.0, v: near.v });
    bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    assert_eq!(bench.see(INSIDE).vessel.mode, VesselMode::Guided);
    assert!(bench.see(INSIDE).vessel.command.is_neutral());
}

#[test]
fn with_people_marked_and_no_water_go_is_asked_for_twice_within_five_seconds() {
    let no_height = Refusal::PictureOnly(NoWater::NoHeight);
    let going = Some(Notice::Going(Some(NoWater::NoHeight)));
    for (marks, waits_ms, second) in [
        (&[MarkKind::Person][..], 0, None),
        (&[MarkKind::Person], 4_900, None),
        (&[MarkKind::Person], 5_100, Some(no_height)),
        (&[MarkKind::Place, MarkKind::Forbidden], 1_000, None),
        (&[MarkKind::Place, MarkKind::Person], 1_000, None),
    ] {
        let mut bench = Bench::new();
        bench.tell(Report::CameraTilt(Angle::from_degrees(-40.0)));
        bench.see(INSIDE);
        for kind in marks {
            bench.mark(*kind, TARGET);
        }
        let first = bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
        refused(&first, no_height);
        assert_eq!(first.vessel.mode, VesselMode::Released);
        bench.ms += waits_ms;
        bench.tell(Report::CameraTilt(Angle::from_degrees(-40.0)));
        bench.see(INSIDE);
        let notice = bench.ask(OperatorRequest::Vessel(VesselRequest::Guide)).notice;
        assert_eq!(notice, second.map_or(going.clone(), |refusal| Some(Notice::RequestRefused(refusal))));
    }
    // Without people and areas one press is enough, and the operator is told.
    let mut bench = Bench::new();
    bench.see(INSIDE);
    bench.mark(MarkKind::Place, TARGET);
    assert_eq!(
        bench.ask(OperatorRequest::Vessel(VesselRequest::Guide)).notice,
        Some(Notice::Going(Some(NoWater::NoTilt)))
    );
    // A refusal says what to do.
    let text = no_height.to_string();
    assert!(text.contains("press Go again within 5 s"), "{text}");
}

#[test]
fn a_boat_that_goes_around_people_stops_when_the_height_is_not_reported_any_more() {
    let mut bench = Bench::going(MarkKind::Person);
    let mut last = None;
    for frame in 0..400 {
        bench.tell(Report::CameraTilt(Angle::from_degrees(-40.0)));
        let underway = ImagePoint { x: f64::from(frame) - 150.0, ..INSIDE };
        last = Some(bench.see(underway).vessel.mode);
    }
    assert_eq!(last, Some(VesselMode::Stopped(VesselStop::WaterLost)));
}

#[test]
fn a_go_is_confirmed_by_a_go_alone() {
    let no_height = Refusal::PictureOnly(NoWater::NoHeight);
    let go = OperatorRequest::Vessel(VesselRequest::Guide);
    for between in [
        OperatorRequest::Stop(StopCause::Operator),
        OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator }),
        OperatorRequest::Vessel(VesselRequest::NextMark),
    ] {
        let mut bench = Bench::new();
        bench.tell(Report::CameraTilt(Angle::from_degrees(-40.0)));
        bench.see(INSIDE);
        bench.mark(MarkKind::Person, TARGET);
        refused(&bench.ask(go), no_height);
        assert!(!bench.pilot.is_at_rest_by_stop(), "a stop makes the next Go a first one");
        bench.ask(between);
        bench.see(INSIDE);
        refused(&bench.ask(go), no_height);
    }
}

#[test]
fn a_circle_that_is_marked_on_the_way_stops_a_boat_that_is_guided_in_the_picture() {
    let mut bench = Bench::going_in_the_picture();
    assert_eq!(bench.see(INSIDE).vessel.mode, VesselMode::Guided);
    bench.mark(MarkKind::Forbidden, PixelPoint { u: 200.0, v: 300.0 });
    assert_eq!(bench.see(INSIDE).vessel.mode, VesselMode::Stopped(VesselStop::WaterLost));
}

#[test]
fn a_person_marked_on_the_way_home_does_not_turn_the_boat_round() {
    let mut bench = Bench::going(MarkKind::Place);
    bench.mark(MarkKind::Home, TARGET);
    bench.ask(OperatorRequest::Vessel(VesselRequest::GoHome));
    bench.mark(MarkKind::Person, PixelPoint { u: 200.0, v: 300.0 });
    let destination = |outcome: &Outcome| outcome.vessel.marks.destination().map(|mark| mark.kind);
    assert_eq!(destination(&bench.see(INSIDE)), Some(MarkKind::Home));
    bench.ask(OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator }));
    bench.mark(MarkKind::Person, PixelPoint { u: 300.0, v: 300.0 });
    assert_eq!(destination(&bench.see(INSIDE)), Some(MarkKind::Person));
}

#[test]
fn a_step_with_a_boat_allocates_nothing() {
    let mut bench = Bench::going(MarkKind::Person);
    bench.mark(MarkKind::Forbidden, PixelPoint { u: 200.0, v: 300.0 });
    let allocations = allocation_counter::measure(|| {
        for _ in 0..50 {
            bench.see(INSIDE);
            bench.ask(OperatorRequest::Vessel(VesselRequest::Steer(AHEAD)));
            bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
        }
    });
    assert_eq!(allocations.count_total, 0);
}

#[derive(Debug, Clone, Copy)]
enum What {
    Seen,
    Lost,
    Tick,
    Ask(OperatorRequest),
}

fn any_what() -> impl Strategy<Value = What> {
    let asked = prop_oneof![
        4 => Just(OperatorRequest::Vessel(VesselRequest::Guide)),
        4 => (-1.2..1.2, -1.2..1.2)
            .prop_map(|(throttle, rudder)| OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand { throttle, rudder }))),
        1 => Just(OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand::NEUTRAL))),
        1 => Just(OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator })),
        1 => Just(OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::ConsoleLost })),
        1 => Just(OperatorRequest::Stop(StopCause::Operator)),
        1 => Just(OperatorRequest::Vessel(VesselRequest::ReleaseVessel)),
        1 => Just(OperatorRequest::Camera(CameraRequest::Deselect)),
        1 => Just(OperatorRequest::Vessel(VesselRequest::NextMark)),
    ];
    prop_oneof![
        8 => Just(What::Seen),
        2 => Just(What::Lost),
        3 => Just(What::Tick),
        6 => asked.prop_map(What::Ask),
    ]
}

proptest! {
    /// Whatever happens: the boat is under way only with a fresh look or a hand at the helm, each younger
    /// than its time to live, never beyond the limits, and never after a stop.
    #[test]
    fn the_boat_moves_only_with_a_reason(
        steps in prop::collection::vec((any_what(), prop_oneof![8 => 0_i64..60, 2 => 200_i64..600, 1 => -200_i64..0]), 1..150),
    ) {
        let mut bench = Bench::new();
        bench.see_water().see(INSIDE);
        bench.mark(MarkKind::Place, TARGET);
        let first = Some(at(bench.ms));
        let (mut seen_at, mut video_at, mut steered_at) = (first, first, None);
        for (what, after_ms) in steps {
            bench.ms = bench.ms.saturating_add_signed(after_ms).max(1);
            let now = at(bench.ms);
            let captured = now.minus(Duration::from_millis(LATENCY_MS));
            let input = match what {
                What::Seen => Input::Localisation(Track::Tracking(seen(INSIDE, captured))),
                What::Lost => SceneInput::Lost.input(now),
                What::Tick => Input::Tick,
                What::Ask(request) => Input::Request(request),
            };
            let outcome = bench.step(input);
            match what {
                What::Seen => (seen_at, video_at) = (Some(now), Some(now)),
                What::Lost => video_at = Some(now),
                What::Ask(OperatorRequest::Vessel(VesselRequest::Steer(_))) => steered_at = Some(now),
                _ => {}
            }
            let VesselCommand { throttle, rudder } = outcome.vessel.command;
            prop_assert!(throttle.abs() <= 1.0 && rudder.abs() <= 1.0);
            if outcome.vessel.command.is_neutral() {
                continue;
            }
            let is_young = |time: Option<Timestamp>, ms: u64| {
                time.is_some_and(|time| time <= now && now.since(time) < Duration::from_millis(ms))
            };
            match outcome.vessel.mode {
                VesselMode::Guided => {
                    prop_assert!(is_young(seen_at, 250), "{what:?}");
                    prop_assert!(throttle.abs() <= 0.6);
                }
                VesselMode::ByHand => prop_assert!(is_young(steered_at, 500) && is_young(video_at, 250)),
                mode => prop_assert!(false, "under way in {mode:?}"),
            }
            prop_assert!(outcome.next_step_at().is_some());
        }
    }
}

/// The request of a scene's input.
trait AsRequest {
    fn request(self) -> OperatorRequest;
}

impl AsRequest for SceneInput {
    fn request(self) -> OperatorRequest {
        match self.input(at(0)) {
            Input::Request(request) => request,
            input => panic!("{input:?} is no request"),
        }
    }
}

#[test]
fn points_on_the_water_are_those_of_the_camera_of_the_video_that_is_followed() {
    let mut bench = Bench::new();
    let metres = |bench: &mut Bench| {
        for _ in 0..60 {
            bench.see(INSIDE);
        }
        bench.see_water();
        let view = bench.see(INSIDE).vessel.frame_view.expect("a view of the water");
        let point = |at| view.fix(at).expect("water").point;
        point(INSIDE.in_pixels(PICTURE)).distance_to(point(TARGET))
    };
    bench.see_water();
    let of_first = metres(&mut bench);
    bench.tell(Report::OtherVideo(Some(Angle::from_degrees(40.0))));
    let of_second = metres(&mut bench);
    assert!((of_second / of_first - 1.0).abs() > 0.1, "{of_first} {of_second}");
    // What the vehicle reports is of its own camera, which somebody else zooms meanwhile.
    bench.tell(Report::FieldOfView(Angle::from_degrees(60.0)));
    assert!((metres(&mut bench) - of_second).abs() < 0.01);
    bench.tell(Report::OtherVideo(None));
    let after = metres(&mut bench);
    assert!((after / of_first - 1.0).abs() > 0.1 && (after / of_second - 1.0).abs() > 0.1, "{after}");
}
