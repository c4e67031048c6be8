//! A detector that contradicts what the tracker found again.

use core::time::Duration;

use barrelman_pilot::{ClassName, Classification, Detection, Detections, Input, Mode, Notice, Outcome};
use barrelman_vocab::{
    CameraCommand, CameraRequest, HoldCause, ImagePoint, OperatorRequest, PixelBox, Timestamp, Track,
};

use crate::held_marks::Scene;
use crate::scenes::{Answer, LATENCY_MS, LEFT, PICTURE, RIGHT, at, seen};

/// Where a detector sees a boat in a picture.
type Boat = Option<ImagePoint>;

fn captured(scene: &Scene) -> Timestamp {
    at(scene.ms).minus(Duration::from_millis(LATENCY_MS))
}

fn detect(scene: &mut Scene, class: &str, place: Boat) {
    let captured = captured(scene);
    let classification = Classification { class: ClassName::new(class).unwrap(), score: 0.8 };
    let found = place.map(|place| Detection { bounds: seen(place, captured).bounds, classification });
    let detections = Detections { captured, picture: PICTURE, found: found.into_iter().collect() };
    scene.pilot.step(Input::Detections(&detections), at(scene.ms));
}

/// Sees a picture, and what the detector says of it, so many times.
fn look(scene: &mut Scene, pictures: usize, boat: Boat) -> Outcome {
    let looks = (0..pictures).map(|_| {
        let outcome = scene.see(&[]);
        detect(scene, "boat", boat);
        outcome
    });
    looks.last().unwrap()
}

fn ask(scene: &mut Scene, request: CameraRequest) -> Outcome {
    scene.pilot.step(Input::Request(OperatorRequest::Camera(request)), at(scene.ms))
}

/// An engaged pilot whose target was right, seen by the detector in so many pictures of eight, is lost, and
/// is found again on the left.
fn found_again(detected: usize) -> Scene {
    let tracks = [(Answer::Tracking(RIGHT), 9), (Answer::Lost, 10), (Answer::Tracking(LEFT), 1_000)];
    let answers = tracks.into_iter().flat_map(|(answer, count)| core::iter::repeat_n(answer, count));
    let mut scene = Scene::answering(answers);
    scene.see(&[]);
    ask(&mut scene, CameraRequest::Engage);
    look(&mut scene, detected, Some(RIGHT));
    let moves = if detected < 8 { look(&mut scene, 8 - detected, None) } else { scene.see(&[]) };
    assert_eq!((moves.mode, moves.is_doubted), (Mode::Servoing, false));
    let more = if detected < 8 { 10 } else { 9 };
    let lost = look(&mut scene, more, None);
    assert_eq!(lost.mode, Mode::Holding(HoldCause::TrackLost));
    scene
}

#[track_caller]
fn assert_doubted(outcome: &Outcome) {
    assert!(outcome.is_doubted && matches!(outcome.track, Track::Tracking(_)), "{outcome:?}");
    assert_eq!((outcome.mode, outcome.command), (Mode::Holding(HoldCause::Doubted), CameraCommand::REST));
}

#[track_caller]
fn assert_follows(outcome: &Outcome) {
    assert_eq!((outcome.mode, outcome.is_doubted), (Mode::Servoing, false));
    assert!(!outcome.command.is_rest());
}

#[test]
fn the_camera_rests_where_the_detector_sees_no_boat() {
    for elsewhere in [None, Some(RIGHT)] {
        let mut scene = found_again(8);
        assert_follows(&look(&mut scene, 3, elsewhere));
        look(&mut scene, 10, elsewhere);
        assert_doubted(&scene.see(&[]));
        assert_doubted(&look(&mut scene, 60, elsewhere));
    }
}

#[test]
fn the_camera_follows_where_the_detector_sees_the_boat() {
    let mut scene = found_again(6);
    assert_follows(&look(&mut scene, 2, None));
    detect(&mut scene, "boat", Some(LEFT));
    // Once the detector has agreed, it may miss the boat.
    assert_follows(&look(&mut scene, 60, None));
}

#[test]
fn a_detector_that_does_not_know_this_boat_or_is_silent_doubts_nothing() {
    assert_follows(&look(&mut found_again(5), 60, None));
    assert_follows(&found_again(8).see_for(60, &[]));
}

#[test]
fn what_was_captured_before_is_no_contradiction() {
    let mut scene = found_again(8);
    scene.see(&[]);
    let found = Detections {
        captured: captured(&scene).minus(Duration::from_millis(1)),
        picture: PICTURE,
        found: Vec::new(),
    };
    for _ in 0..60 {
        scene.pilot.step(Input::Detections(&found), at(scene.ms));
    }
    assert_follows(&scene.see(&[]));
}

#[test]
fn a_doubt_ends_when_the_detector_or_the_operator_agrees() {
    let doubted = || {
        let mut scene = found_again(8);
        look(&mut scene, 20, None);
        assert_doubted(&scene.see(&[]));
        scene
    };
    let mut scene = doubted();
    detect(&mut scene, "person", Some(LEFT));
    assert_doubted(&scene.see(&[]));
    detect(&mut scene, "boat", Some(LEFT));
    assert_follows(&scene.see(&[]));
    let mut scene = doubted();
    assert_eq!(ask(&mut scene, CameraRequest::Engage).notice, None);
    assert_follows(&look(&mut scene, 60, None));
    let mut scene = doubted();
    let outcome = ask(&mut scene, CameraRequest::Reject);
    assert_eq!((outcome.notice, outcome.is_doubted), (Some(Notice::TargetRejected), false));
    let mut scene = doubted();
    assert!(!ask(&mut scene, CameraRequest::SelectNext(BOUNDS)).is_doubted);
}

const BOUNDS: PixelBox = PixelBox { u: 300.0, v: 200.0, w: 20.0, h: 10.0 };
