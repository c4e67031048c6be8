//! A search for a target that is lost: when it may begin, what ends it, and that every limit holds.

use core::time::Duration;

use barrelman_pilot::net_yaw::NetYawLevel;
use barrelman_pilot::{Input, Mode, Notice, Outcome, Pilot, Refusal};
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{
    Angle, CameraRequest, DrawnSelection, HoldCause, ImagePoint, Nudge, OperatorRequest, PixelBox, StopCause,
    Telemetry, Timestamp, Track,
};

use crate::scenes::{LEFT, RIGHT, at, localisation_pilot, seen};

/// Time of the last look at the target.
const LAST_MS: u64 = 1_000;

/// A pilot with its outcomes, and video at 20 Hz.
struct Scene {
    pilot: Pilot,
    now_ms: u64,
    outcomes: Vec<Outcome>,
}

impl Scene {
    /// The target was followed until [`LAST_MS`], at this image point, and then lost for `lost_ms`.
    fn lost(point: ImagePoint, is_engaged: bool, lost_ms: u64) -> Self {
        let mut scene = Self { pilot: localisation_pilot(), now_ms: 0, outcomes: Vec::new() };
        if is_engaged {
            scene.request(OperatorRequest::Camera(CameraRequest::Engage));
        }
        scene.run(LAST_MS, Some(point));
        scene.run(lost_ms, None);
        scene
    }

    fn step(&mut self, input: Input<'_>) -> &Outcome {
        let outcome = self.pilot.step(input, at(self.now_ms));
        self.outcomes.push(outcome);
        self.last()
    }

    fn last(&self) -> &Outcome {
        self.outcomes.last().unwrap()
    }

    fn request(&mut self, request: OperatorRequest) -> &Outcome {
        self.step(Input::Request(request))
    }

    /// Video for some milliseconds, with the target at a point, or without.
    fn run(&mut self, ms: u64, point: Option<ImagePoint>) -> &Outcome {
        for _ in (0..ms).step_by(50) {
            self.now_ms += 50;
            let captured = at(self.now_ms - 50);
            let track = match point {
                Some(point) => Track::Tracking(seen(point, captured)),
                None => Track::Lost { since: at(LAST_MS), confidence: 0.0 },
            };
            self.step(Input::Localisation(track));
        }
        self.last()
    }

    /// The pan rates since a time.
    fn pans_since(&self, since: Timestamp) -> Vec<f64> {
        let newer = self.outcomes.iter().filter(|outcome| outcome.at >= since);
        newer.map(|outcome| outcome.command.pan.radians_per_second()).collect()
    }
}

#[test]
fn a_search_is_offered_once_the_target_has_been_lost_for_three_seconds() {
    for is_engaged in [true, false] {
        let mut scene = Scene::lost(RIGHT, is_engaged, 0);
        assert_eq!(scene.last().search_refusal, Some(Refusal::NothingLost));
        assert_eq!(scene.run(2_900, None).search_refusal, Some(Refusal::LostTooBriefly));
        let refused = scene.request(OperatorRequest::Camera(CameraRequest::Search));
        assert_eq!(refused.notice, Some(Notice::RequestRefused(Refusal::LostTooBriefly)));
        assert_eq!(scene.run(100, None).search_refusal, None);
        let accepted = scene.request(OperatorRequest::Camera(CameraRequest::Search));
        assert_eq!((accepted.mode, &accepted.notice), (Mode::Searching, &None));
    }
}

#[test]
fn a_search_turns_slowly_to_the_last_bearing_first() {
    for (point, side) in [(RIGHT, 1.0), (LEFT, -1.0)] {
        let mut scene = Scene::lost(point, false, 3_000);
        scene.request(OperatorRequest::Camera(CameraRequest::Search));
        scene.run(4_000, None);
        let pans = scene.pans_since(at(4_050));
        assert!(pans.iter().all(|pan| *pan == 0.1 * side), "{point:?}: {pans:?}");
        scene.run(60_000, None);
        let fastest = scene.outcomes.iter().map(|outcome| {
            outcome
                .command
                .pan
                .abs()
                .radians_per_second()
                .max(outcome.command.tilt.abs().radians_per_second())
        });
        assert_eq!(fastest.fold(0.0, f64::max), 0.1);
    }
}

#[test]
fn a_search_that_finds_the_target_gives_the_camera_back() {
    for (is_engaged, mode) in [(true, Mode::Servoing), (false, Mode::Idle)] {
        let mut scene = Scene::lost(RIGHT, is_engaged, 3_000);
        scene.request(OperatorRequest::Camera(CameraRequest::Search));
        assert_eq!(scene.run(2_000, None).mode, Mode::Searching);
        let found = scene.run(50, Some(RIGHT));
        assert_eq!((found.mode, &found.notice), (mode, &Some(Notice::SearchFound)));
        assert_eq!(found.command.pan.is_zero(), !is_engaged);
    }
}

#[test]
fn a_search_that_finds_nothing_ends_by_itself_at_rest() {
    for (is_engaged, mode) in [(true, Mode::Holding(HoldCause::TrackLost)), (false, Mode::Idle)] {
        let mut scene = Scene::lost(RIGHT, is_engaged, 3_000);
        scene.request(OperatorRequest::Camera(CameraRequest::Search));
        scene.run(62_000, None);
        assert_eq!((scene.last().mode, scene.last().command.is_rest()), (mode, true));
        assert!(scene.outcomes.iter().any(|outcome| outcome.notice == Some(Notice::SearchGaveUp)));
        let searching = scene.outcomes.iter().filter(|outcome| outcome.mode == Mode::Searching);
        assert!(searching.count() < 59 * 20, "it ends before its consent does");
    }
}

#[test]
fn a_search_keeps_what_it_looks_for_in_a_narrow_picture() {
    // A quarter of the width of the configured picture: 15 by 11 degrees.
    let mut scene = Scene::lost(RIGHT, false, 0);
    let narrow = Report::FieldOfView(Angle::from_degrees(15.0));
    for _ in 0..20 {
        for report in [narrow, Report::CameraTilt(Angle::from_degrees(-40.0))] {
            scene.step(Input::Telemetry(Telemetry { at: at(scene.now_ms), report }));
        }
        scene.run(50, Some(RIGHT));
    }
    scene.run(3_000, None);
    scene.request(OperatorRequest::Camera(CameraRequest::Search));
    assert_eq!(scene.last().mode, Mode::Searching);
    let begun = scene.outcomes.len();
    // Until the end of the first four legs, the camera is raised by a quarter of the picture's height at
    // most.
    scene.run(10_000, None);
    let tilts =
        scene.outcomes[begun..].iter().map(|outcome| 0.05 * outcome.command.tilt.radians_per_second());
    let farthest_row =
        tilts.scan(0.0_f64, |tilt, step| Some(core::mem::replace(tilt, *tilt + step))).fold(0.0, f64::max);
    let height = 2.0 * libm::atan(0.75 * libm::tan(7.5_f64.to_radians()));
    assert!(farthest_row < 0.5 * height, "{farthest_row} {height}");
}

#[test]
fn a_search_does_not_begin_while_a_selection_is_not_confirmed() {
    let mut scene = Scene::lost(RIGHT, false, 4_000);
    let bounds = PixelBox { u: 100.0, v: 100.0, w: 30.0, h: 20.0 };
    scene.request(OperatorRequest::Camera(CameraRequest::Select(DrawnSelection {
        bounds,
        captured_ns: at(scene.now_ms - 50),
    })));
    assert_eq!(scene.last().search_refusal, Some(Refusal::NothingLost));
    let refused = scene.request(OperatorRequest::Camera(CameraRequest::Search));
    assert_eq!(refused.notice, Some(Notice::RequestRefused(Refusal::NothingLost)));
    assert!(refused.command.is_rest() && refused.mode != Mode::Searching);
}

#[test]
fn every_stop_and_every_silence_ends_a_search() {
    let searching = || {
        let mut scene = Scene::lost(RIGHT, true, 3_000);
        scene.request(OperatorRequest::Camera(CameraRequest::Search));
        assert!(!scene.run(1_000, None).command.is_rest());
        scene
    };
    for (request, mode) in [
        (OperatorRequest::Stop(StopCause::Operator), Mode::Stopped(StopCause::Operator)),
        (OperatorRequest::Camera(CameraRequest::Disengage), Mode::Idle),
        (OperatorRequest::Camera(CameraRequest::Engage), Mode::Holding(HoldCause::TrackLost)),
        (OperatorRequest::Camera(CameraRequest::Deselect), Mode::Idle),
    ] {
        let mut scene = searching();
        let outcome = scene.request(request);
        assert_eq!((outcome.mode, outcome.command.is_rest()), (mode, true), "{request:?}");
        let later = scene.run(1_000, None);
        assert!(later.command.is_rest(), "{request:?}: {later:?}");
    }
    let mut scene = searching();
    let wake_at = scene.last().wake_at.expect("a motion has an end");
    assert!(wake_at.since(at(scene.now_ms)) <= Duration::from_millis(250));
    scene.now_ms += 250;
    assert!(scene.step(Input::Tick).command.is_rest(), "no video, no motion");
}

#[test]
fn a_search_is_refused_where_no_command_may_move_the_camera() {
    let mut scene = Scene::lost(RIGHT, false, 3_000);
    scene.request(OperatorRequest::Stop(StopCause::Operator));
    let refused = scene.request(OperatorRequest::Camera(CameraRequest::Search));
    assert_eq!(refused.notice, Some(Notice::RequestRefused(Refusal::Stopped)));
    assert_eq!(refused.search_refusal, Some(Refusal::Stopped));
    let mut link = Scene::lost(RIGHT, false, 0);
    link.pilot = localisation_pilot().commanding(barrelman_pilot::CommandPath::Link);
    link.run(4_000, None);
    let down = Refusal::NoMotion(HoldCause::LinkDown);
    assert_eq!(link.last().search_refusal, Some(down));
    let report = Report::Link(LinkState::Up);
    link.step(Input::Telemetry(Telemetry { at: at(link.now_ms), report }));
    assert_eq!(link.request(OperatorRequest::Camera(CameraRequest::Search)).mode, Mode::Searching);
    link.run(500, None);
    assert!(!link.last().command.is_rest());
    let report = Report::Link(LinkState::Opening);
    let outcome = link.step(Input::Telemetry(Telemetry { at: at(link.now_ms), report }));
    assert_eq!((outcome.mode, outcome.command.is_rest()), (Mode::Idle, true));
}

#[test]
fn the_net_yaw_is_counted_warned_about_and_refused_with_the_way_back_open() {
    let mut scene = Scene::lost(RIGHT, false, 0);
    let nudge = |pan| OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan, tilt: 0.0, zoom: 0.0 }));
    let turn = |scene: &mut Scene, pan, ms: u64| {
        for _ in (0..ms).step_by(100) {
            scene.request(nudge(pan));
            scene.run(100, None);
        }
    };
    turn(&mut scene, 1.0, 10_000);
    let counted = scene.last().net_yaw.angle.radians();
    assert!((counted - 1.0).abs() < 0.1, "10 s at 0.1 rad/s: {counted}");
    for (degrees, level) in
        [(530.0, NetYawLevel::Free), (545.0, NetYawLevel::Warned), (1_081.0, NetYawLevel::Refused)]
    {
        let outcome = scene.request(OperatorRequest::Camera(CameraRequest::NetYaw { degrees }));
        assert_eq!(outcome.net_yaw.level, level, "{degrees}");
        assert!(matches!(outcome.notice, Some(Notice::NetYaw(_))), "{degrees}");
    }
    assert!(scene.request(nudge(1.0)).command.is_rest(), "further to the right is refused");
    assert!(!scene.request(nudge(-1.0)).command.is_rest(), "back to the left is free");
    turn(&mut scene, -1.0, 3_000);
    assert_eq!(scene.last().net_yaw.level, NetYawLevel::Warned);
    assert!(!scene.request(nudge(1.0)).command.is_rest());
    for degrees in [f64::NAN, f64::INFINITY, 3_601.0] {
        let refused = scene.request(OperatorRequest::Camera(CameraRequest::NetYaw { degrees }));
        assert_eq!(refused.notice, Some(Notice::RequestRefused(Refusal::NetYawOutOfRange)), "{degrees}");
    }
}

#[test]
fn an_engaged_camera_does_not_wind_up_the_tether() {
    let mut scene = Scene::lost(RIGHT, true, 0);
    assert!(!scene.run(500, Some(RIGHT)).command.is_rest());
    scene.request(OperatorRequest::Camera(CameraRequest::NetYaw { degrees: 1_080.0 }));
    let held = scene.run(200, Some(RIGHT));
    assert_eq!((held.mode, held.command.is_rest()), (Mode::Servoing, true));
    assert!(!scene.run(200, Some(LEFT)).command.is_rest());
}
