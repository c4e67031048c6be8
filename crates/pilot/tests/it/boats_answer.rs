//! A guided boat that does not move as commanded is stopped.

use barrelman_pilot::vessel::VesselStop;
use barrelman_pilot::{Notice, VesselMode};
use barrelman_vocab::{ImagePoint, MarkKind, OperatorRequest, PixelPoint, VesselRequest};

use crate::scenes::INSIDE;
use crate::vessel::{AHEAD, Bench, TARGET};

/// The last mode within this time of a boat that is seen at these places, and when the mode began, seconds
/// after now.
fn mode_after(bench: &mut Bench, lasts_s: f64, place: impl Fn(f64) -> ImagePoint) -> (VesselMode, f64) {
    let (began, mut newest) = (bench.ms, (VesselMode::Absent, 0.0));
    for frame in 0.. {
        let seconds = (bench.ms - began) as f64 / 1e3;
        if seconds >= lasts_s {
            break;
        }
        if frame % 15 == 0 {
            bench.see_water();
        }
        let mode = bench.see(place(seconds)).vessel.mode;
        if mode != newest.0 {
            newest = (mode, seconds);
        }
    }
    newest
}

/// A place that moves from INSIDE along x and y, pixels a second.
fn moving(x: f64, y: f64) -> impl Fn(f64) -> ImagePoint {
    move |seconds| ImagePoint { x: INSIDE.x + x * seconds, y: INSIDE.y + y * seconds }
}

const NO_ANSWER: VesselMode = VesselMode::Stopped(VesselStop::NoAnswer);

#[test]
fn a_guided_boat_that_does_not_move_is_stopped_until_the_next_request() {
    let mut bench = Bench::going(MarkKind::Place);
    for _ in 0..2 {
        let (mode, since_s) = mode_after(&mut bench, 12.0, moving(0.0, 0.0));
        assert_eq!(mode, NO_ANSWER);
        assert!((7.0..10.0).contains(&since_s), "{since_s}");
        let outcome = bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
        assert_eq!((outcome.notice, outcome.vessel.mode), (Some(Notice::Going(None)), VesselMode::Guided));
    }
    assert_eq!(mode_after(&mut bench, 12.0, moving(8.0, 8.0)), (VesselMode::Guided, 0.0));
}

#[test]
fn a_guided_boat_that_drifts_off_is_stopped() {
    let mut bench = Bench::going(MarkKind::Place);
    let (mode, since_s) = mode_after(&mut bench, 35.0, moving(-8.0, 2.0));
    assert_eq!(mode, NO_ANSWER);
    assert!((18.0..32.0).contains(&since_s), "{since_s}");
}

#[test]
fn another_destination_far_away_is_no_fault_of_the_boat() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    bench.mark(MarkKind::Home, PixelPoint { u: 20.0, v: 200.0 });
    bench.mark(MarkKind::Place, TARGET);
    bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    assert_eq!(mode_after(&mut bench, 6.0, moving(10.0, -4.0)), (VesselMode::Guided, 0.0));
    assert_eq!(bench.ask(OperatorRequest::Vessel(VesselRequest::GoHome)).notice, Some(Notice::Going(None)));
    let turned = |seconds: f64| moving(60.0 - 10.0 * seconds, -24.0 + 4.0 * seconds)(1.0);
    assert_eq!(mode_after(&mut bench, 25.0, turned), (VesselMode::Guided, 0.0));
}

#[test]
fn a_boat_that_is_steered_by_hand_need_not_answer_and_the_guidance_asks_anew() {
    let mut bench = Bench::new();
    bench.see_water().see(INSIDE);
    bench.mark(MarkKind::Place, TARGET);
    for frame in 0..360 {
        if frame % 15 == 0 {
            bench.see_water();
        }
        bench.ask(OperatorRequest::Vessel(VesselRequest::Steer(AHEAD)));
        assert_eq!(bench.see(INSIDE).vessel.mode, VesselMode::ByHand);
    }
    bench.ask(OperatorRequest::Vessel(VesselRequest::Guide));
    assert_eq!(mode_after(&mut bench, 5.0, moving(0.0, 0.0)), (VesselMode::Guided, 0.0));
}
