//! Detections among the candidates, on drawn pictures.

use core::time::Duration;

use barrelman_pilot::{
    Candidate, ClassName, Classification, Detection, Detections, Input, MAX_CANDIDATES, MAX_DETECTIONS, Mode,
    Notice, Outcome, Refusal,
};
use barrelman_vocab::{
    CameraCommand, CameraRequest, DrawnMark, MarkKind, OperatorRequest, PictureSize, PixelBox, PixelPoint,
    Timestamp, Track, VesselRequest,
};

use crate::held_marks::{FIRST, SECOND, Scene};
use crate::scenes::{Answer, INSIDE, LATENCY_MS, PICTURE, at};

/// Frames of some seconds: longer than a classification lasts.
const SOME_SECONDS: usize = 120;

fn around(centre: PixelPoint) -> PixelBox {
    PixelBox { u: centre.u - 10.0, v: centre.v - 10.0, w: 20.0, h: 20.0 }
}

fn person(score: f64) -> Classification {
    classified("person", score)
}

fn classified(class: &str, score: f64) -> Classification {
    Classification { class: ClassName::new(class).unwrap(), score }
}

fn captured(scene: &Scene) -> Timestamp {
    at(scene.ms).minus(Duration::from_millis(LATENCY_MS))
}

fn give(scene: &mut Scene, captured: Timestamp, picture: PictureSize, found: Vec<Detection>) -> Outcome {
    let detections = Detections { captured, picture, found };
    scene.pilot.step(Input::Detections(&detections), at(scene.ms))
}

/// A detection in the newest frame.
fn detect(scene: &mut Scene, bounds: PixelBox, score: f64) -> Outcome {
    let captured = captured(scene);
    give(scene, captured, PICTURE, vec![Detection { bounds, classification: person(score) }])
}

fn shown(outcome: &Outcome) -> Vec<Candidate> {
    outcome.candidates.into_iter().flatten().collect()
}

#[test]
fn a_detection_names_the_candidate_of_its_place_until_it_is_not_renewed() {
    let mut scene = Scene::with(Answer::Unseeded);
    let both = [Some(FIRST), Some(SECOND)];
    let before = shown(&scene.see_for(SOME_SECONDS, &both));
    assert!(before.iter().all(|candidate| candidate.classification.is_none()), "{before:?}");
    detect(&mut scene, around(FIRST), 0.83);
    let named = shown(&scene.see(&both));
    assert_eq!(named.len(), before.len());
    for candidate in named {
        let is_first = candidate.bounds.contains(FIRST);
        assert_eq!(candidate.classification, is_first.then(|| person(0.83)), "{candidate:?}");
    }
    let later = shown(&scene.see_for(SOME_SECONDS, &both));
    assert!(later.iter().all(|candidate| candidate.classification.is_none()), "{later:?}");
}

#[test]
fn what_is_detected_twice_is_a_candidate_and_neither_selected_nor_marked_nor_moved() {
    let mut scene = Scene::with(Answer::Unseeded);
    scene.see(&[Some(FIRST)]);
    detect(&mut scene, around(FIRST), 0.7);
    assert_eq!(shown(&scene.see(&[Some(FIRST)])), [], "it was found once");
    // A round begins with the next look.
    scene.see_for(10, &[Some(FIRST)]);
    detect(&mut scene, around(FIRST), 0.9);
    let outcome = scene.see_for(2, &[Some(FIRST)]);
    let [candidate] = shown(&outcome)[..] else { panic!("{:?}", shown(&outcome)) };
    assert!(candidate.bounds.contains(FIRST), "{candidate:?}");
    assert_eq!((candidate.number, candidate.classification), (1, Some(person(0.9))));
    assert_eq!(
        (outcome.mode, outcome.track, outcome.command),
        (Mode::Idle, Track::Unseeded, CameraCommand::REST)
    );
    assert!(outcome.vessel.marks.iter().next().is_none(), "{:?}", outcome.vessel.marks);
}

#[test]
fn detections_of_another_picture_of_the_future_or_of_the_past_are_not_used() {
    let mut scene = Scene::with(Answer::Unseeded);
    scene.see_for(SOME_SECONDS, &[Some(FIRST)]);
    let now = captured(&scene);
    let later = now.plus(Duration::from_secs(5));
    let earlier = now.minus(Duration::from_millis(1_500));
    let other = PictureSize::new(PICTURE.width / 2, PICTURE.height);
    for (captured, picture) in [(now, other), (later, PICTURE), (earlier, PICTURE)] {
        let found = vec![Detection { bounds: around(FIRST), classification: person(0.9) }];
        give(&mut scene, captured, picture, found);
        let shown = shown(&scene.see(&[Some(FIRST)]));
        assert!(
            !shown.is_empty() && shown.iter().all(|candidate| candidate.classification.is_none()),
            "{shown:?}"
        );
    }
}

#[test]
fn the_boat_that_is_followed_is_no_candidate_and_detections_move_nothing() {
    let mut scene = Scene::with(Answer::Tracking(INSIDE));
    for _ in 0..4 {
        let outcome = scene.see_for(10, &[Some(FIRST)]);
        let command = outcome.command;
        assert_eq!(detect(&mut scene, around(INSIDE.in_pixels(PICTURE)), 0.9).command, command);
        assert_eq!(shown(&outcome), []);
    }
}

#[test]
fn persons_are_shown_beside_the_boat_without_a_number_that_could_be_taken() {
    let mut scene = Scene::with(Answer::Tracking(INSIDE));
    let both = [Some(FIRST), Some(SECOND)];
    let found = [(FIRST, "person"), (SECOND, "buoy")]
        .map(|(at, class)| Detection { bounds: around(at), classification: classified(class, 0.9) });
    let detect = |scene: &mut Scene| {
        let captured = captured(scene);
        give(scene, captured, PICTURE, found.to_vec());
        scene.see_for(5, &both)
    };
    scene.see(&both);
    assert_eq!(shown(&detect(&mut scene)), [], "found once");
    let outcome = detect(&mut scene);
    let [candidate] = shown(&outcome)[..] else { panic!("{:?}", shown(&outcome)) };
    assert!(candidate.bounds.contains(FIRST), "{candidate:?}");
    assert_eq!(candidate.classification, Some(person(0.9)));
    let take = OperatorRequest::Camera(CameraRequest::TakeCandidate { number: candidate.number });
    let taken = scene.pilot.step(Input::Request(take), at(scene.ms));
    assert_eq!(taken.notice, Some(Notice::RequestRefused(Refusal::NoSuchCandidate)));
    // A marked person is held, and not proposed any more.
    let bounds = candidate.bounds;
    let mark = DrawnMark { mark: MarkKind::Person, at: bounds.centre(), captured_ns: candidate.captured };
    scene.pilot.step(Input::Request(OperatorRequest::Vessel(VesselRequest::Mark(mark))), at(scene.ms));
    let outcome = detect(&mut scene);
    assert!(outcome.vessel.marks.iter().any(|mark| mark.is_held()), "{:?}", outcome.vessel.marks);
    assert_eq!(shown(&outcome), []);
}

#[test]
fn of_two_detections_of_one_object_the_better_one_counts() {
    let mut scene = Scene::with(Answer::Unseeded);
    scene.see_for(SOME_SECONDS, &[Some(FIRST)]);
    let captured = captured(&scene);
    let found = [("boat", 0.9), ("person", 0.4)]
        .map(|(class, score)| Detection { bounds: around(FIRST), classification: classified(class, score) });
    give(&mut scene, captured, PICTURE, found.to_vec());
    let outcome = scene.see(&[Some(FIRST)]);
    let [candidate] = shown(&outcome)[..] else { panic!("{:?}", shown(&outcome)) };
    assert_eq!(candidate.classification, Some(classified("boat", 0.9)));
}

#[test]
fn any_numbers_and_any_count_of_detections_are_bounded() {
    let mut scene = Scene::with(Answer::Unseeded);
    let values = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1.0, 0.0, 1e-300];
    let boxes = values.into_iter().flat_map(|u| values.map(|w| PixelBox { u, v: w, w: u, h: w }));
    let found: Vec<_> = boxes
        .cycle()
        .take(10 * MAX_DETECTIONS)
        .map(|bounds| Detection { bounds, classification: person(f64::NAN) })
        .collect();
    for _ in 0..SOME_SECONDS {
        let captured = captured(&scene);
        give(&mut scene, captured, PICTURE, found.clone());
        assert!(shown(&scene.see(&[])).len() <= MAX_CANDIDATES);
    }
}

#[test]
fn detections_cost_no_memory_in_a_frame() {
    let mut scene = Scene::with(Answer::Unseeded);
    let look = |scene: &mut Scene| {
        for _ in 0..2 * SOME_SECONDS {
            detect(scene, around(FIRST), 0.9);
            scene.see(&[Some(FIRST)]);
        }
    };
    look(&mut scene);
    let before = scene.allocations;
    look(&mut scene);
    // A candidate's tracker may learn another view of it.
    assert!(scene.allocations - before <= 2, "{}", scene.allocations - before);
}
