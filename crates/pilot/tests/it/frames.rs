//! Video frames through the pilot's own tracker.

use core::time::Duration;

use barrelman_pilot::{Input, Mode, Notice, Outcome, Pilot};
use barrelman_vocab::{HoldCause, ImagePoint, Track};

use crate::scenes::SceneInput::{Engage, Select};
use crate::scenes::{
    Answer, FRESH_MS, INSIDE, LATENCY_MS, PAN_LEFT, PAN_RIGHT, PICTURE, REST, RIGHT, Scripted, TILT_UP, TOP,
};
use crate::scenes::{LEFT, at, frame, refusal, report, seen, settings};

fn pilot(selections: &[Option<ImagePoint>], tracks: &[Answer]) -> Pilot {
    let tracker = Scripted {
        tracks: tracks.iter().copied().collect(),
        selections: selections.iter().copied().collect(),
        ..Scripted::default()
    };
    Pilot::new(settings(), Box::new(tracker))
}

/// Shows the pilot a frame that was captured `age_ms` before.
fn show(pilot: &mut Pilot, now_ms: u64, age_ms: u64) -> Outcome {
    let captured = at(now_ms).minus(Duration::from_millis(age_ms));
    pilot.step(Input::Frame(&frame(now_ms, captured)), at(now_ms))
}

#[test]
fn nothing_selected_is_nothing_to_follow() {
    let mut pilot = pilot(&[], &[]);
    pilot.step(Engage.input(at(0)), at(0));
    let outcome = show(&mut pilot, 10, LATENCY_MS);
    assert_eq!((outcome.mode, outcome.track), (Mode::Holding(HoldCause::NoSelection), Track::Unseeded));
    assert_eq!(outcome.age, Some(Duration::from_millis(LATENCY_MS)));
}

#[test]
fn a_selection_is_taken_on_the_next_frame_and_moves_the_camera() {
    let mut pilot = pilot(&[Some(RIGHT)], &[Answer::Tracking(TOP)]);
    pilot.step(Engage.input(at(0)), at(0));
    pilot.step(Select.input(at(1)), at(1));
    let selected = show(&mut pilot, 300, LATENCY_MS);
    let localisation = seen(RIGHT, at(100));
    assert_eq!(selected.notice, Some(Notice::Selected(report(localisation))));
    assert_eq!((selected.track, selected.command), (Track::Tracking(localisation), PAN_RIGHT));
    let tracked = show(&mut pilot, 333, LATENCY_MS);
    assert_eq!((tracked.notice, tracked.command), (None, TILT_UP));
}

#[test]
fn the_last_of_several_selections_counts() {
    let mut pilot = pilot(&[Some(LEFT), Some(RIGHT)], &[]);
    pilot.step(Engage.input(at(0)), at(0));
    pilot.step(Select.input(at(1)), at(1));
    pilot.step(Select.input(at(2)), at(2));
    assert_eq!(show(&mut pilot, 300, LATENCY_MS).command, PAN_LEFT);
}

#[test]
fn a_refused_selection_keeps_the_track() {
    let mut pilot = pilot(&[Some(RIGHT), None], &[Answer::Tracking(LEFT), Answer::Tracking(LEFT)]);
    pilot.step(Engage.input(at(0)), at(0));
    pilot.step(Select.input(at(1)), at(1));
    show(&mut pilot, 300, LATENCY_MS);
    let asked = pilot.step(Select.input(at(310)), at(310));
    assert_eq!(asked.command, REST);
    let refused = show(&mut pilot, 333, LATENCY_MS);
    assert_eq!(refused.notice, Some(Notice::SelectionRefused(refusal(PICTURE.bounds()))));
    assert_eq!(refused.track, Track::Tracking(seen(LEFT, at(133))));
    assert_eq!((refused.mode, refused.command), (Mode::Servoing, PAN_LEFT));
    assert_eq!(show(&mut pilot, 366, LATENCY_MS).notice, None);
}

#[test]
fn a_refused_selection_without_a_track_leaves_nothing_to_follow() {
    let mut pilot = pilot(&[None], &[]);
    pilot.step(Engage.input(at(0)), at(0));
    pilot.step(Select.input(at(1)), at(1));
    let refused = show(&mut pilot, 300, LATENCY_MS);
    assert_eq!((refused.mode, refused.track), (Mode::Holding(HoldCause::NoSelection), Track::Unseeded));
}

#[test]
fn stale_frames_are_tracked_but_move_nothing() {
    let mut pilot = pilot(&[], &[Answer::Tracking(RIGHT), Answer::Tracking(RIGHT)]);
    pilot.step(Engage.input(at(0)), at(0));
    let stale = show(&mut pilot, 600, FRESH_MS + 1);
    assert_eq!((stale.mode, stale.command), (Mode::Holding(HoldCause::VideoStale), REST));
    assert_eq!(stale.advice.map(|advice| advice.command), Some(PAN_RIGHT));
    let fresh = show(&mut pilot, 633, FRESH_MS);
    assert_eq!((fresh.mode, fresh.command), (Mode::Servoing, PAN_RIGHT));
}

#[test]
fn a_selection_on_a_stale_frame_moves_nothing() {
    let mut pilot = pilot(&[Some(RIGHT)], &[]);
    pilot.step(Engage.input(at(0)), at(0));
    pilot.step(Select.input(at(1)), at(1));
    let stale = show(&mut pilot, 900, FRESH_MS + 1);
    assert_eq!((stale.mode, stale.command), (Mode::Holding(HoldCause::VideoStale), REST));
    assert!(matches!(stale.notice, Some(Notice::Selected(_))));
}

#[test]
fn a_lost_and_a_coasting_target_start_nothing() {
    let mut pilot = pilot(
        &[],
        &[Answer::Lost, Answer::Coasting(RIGHT), Answer::Tracking(RIGHT), Answer::Coasting(INSIDE)],
    );
    pilot.step(Engage.input(at(0)), at(0));
    assert_eq!(show(&mut pilot, 300, LATENCY_MS).mode, Mode::Holding(HoldCause::TrackLost));
    assert_eq!(show(&mut pilot, 333, LATENCY_MS).mode, Mode::Holding(HoldCause::Coasting));
    assert_eq!(show(&mut pilot, 366, LATENCY_MS).command, PAN_RIGHT);
    assert_eq!(show(&mut pilot, 400, LATENCY_MS).command, REST);
}

#[test]
fn frames_whose_clock_runs_back_are_noticed_with_and_without_a_target() {
    let mut pilot = pilot(&[], &[Answer::Tracking(RIGHT), Answer::Lost, Answer::Lost, Answer::Unseeded]);
    assert_eq!(show(&mut pilot, 300, 100).notice, None);
    assert_eq!(show(&mut pilot, 310, 111).notice, Some(Notice::VideoClockWentBack));
    assert_eq!(show(&mut pilot, 320, 121).notice, None);
    assert_eq!(show(&mut pilot, 330, 132).notice, Some(Notice::VideoClockWentBack));
}

#[test]
fn the_tracker_is_told_how_the_camera_turns() {
    let tracker = Scripted {
        selections: [Some(RIGHT)].into(),
        tracks: [Answer::Tracking(RIGHT); 40].into(),
        ..Scripted::default()
    };
    let priors = tracker.priors.clone();
    let mut pilot = Pilot::new(settings(), Box::new(tracker));
    pilot.step(Engage.input(at(0)), at(0));
    pilot.step(Select.input(at(1)), at(1));
    for frame in 0..40 {
        show(&mut pilot, 300 + 40 * frame, LATENCY_MS);
    }
    let shifts: Vec<f64> = priors
        .lock()
        .unwrap()
        .iter()
        .map(|prior| prior.expect("a prior for each frame").shift_u_px)
        .collect();
    // A command at 300 ms takes effect after its dead time, not in the first frames.
    assert!(shifts[..4].iter().all(|shift| *shift == 0.0), "{shifts:?}");
    assert!(shifts[38] < 2.0 * shifts[12] && shifts[12] < 0.0, "{shifts:?}");
}
