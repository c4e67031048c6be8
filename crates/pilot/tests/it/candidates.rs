//! Candidates: what stands out from the water, with numbers, on drawn pictures.

use core::time::Duration;

use barrelman_pilot::{Candidate, Input, Notice, Outcome, Refusal};
use barrelman_vocab::{CameraRequest, OperatorRequest, PixelPoint, Tap};

use crate::held_marks::{FIRST, SECOND, Scene};
use crate::scenes::{Answer, INSIDE, LATENCY_MS, at};

/// Frames of some seconds: two rounds of looks and more.
const SOME_SECONDS: usize = 120;

fn shown(outcome: &Outcome) -> Vec<Candidate> {
    outcome.candidates.into_iter().flatten().collect()
}

/// The candidate at a point.
#[track_caller]
fn candidate_at(outcome: &Outcome, point: PixelPoint) -> Candidate {
    let distance = |candidate: &Candidate| {
        let centre = candidate.bounds.centre();
        libm::hypot(centre.u - point.u, centre.v - point.v)
    };
    let found = shown(outcome).into_iter().find(|candidate| distance(candidate) < 12.0);
    found.unwrap_or_else(|| panic!("{:?}", shown(outcome)))
}

fn ask(scene: &mut Scene, request: CameraRequest) -> Outcome {
    scene.pilot.step(Input::Request(OperatorRequest::Camera(request)), at(scene.ms))
}

#[test]
fn what_stands_out_is_shown_with_a_number_that_stays_until_it_is_gone() {
    let mut scene = Scene::with(Answer::Unseeded);
    let both = [Some(FIRST), Some(SECOND)];
    let outcome = scene.see_for(SOME_SECONDS, &both);
    let (first, second) = (candidate_at(&outcome, FIRST), candidate_at(&outcome, SECOND));
    assert_ne!(first.number, second.number);
    let outcome = scene.see_for(SOME_SECONDS, &both);
    assert_eq!(candidate_at(&outcome, FIRST).number, first.number);
    let outcome = scene.see_for(SOME_SECONDS, &[Some(FIRST), None]);
    candidate_at(&outcome, FIRST);
    assert!(
        shown(&outcome).iter().all(|candidate| candidate.number != second.number),
        "{:?}",
        shown(&outcome)
    );
}

#[test]
fn bare_water_has_no_candidates() {
    let mut scene = Scene::with(Answer::Unseeded);
    assert_eq!(shown(&scene.see_for(SOME_SECONDS, &[])), []);
}

#[test]
fn a_candidate_is_taken_by_its_number_and_by_a_tap() {
    for by_tap in [false, true] {
        let mut scene = Scene::with(Answer::Unseeded);
        let outcome = scene.see_for(SOME_SECONDS, &[Some(FIRST)]);
        let candidate = candidate_at(&outcome, FIRST);
        let captured_ns = at(scene.ms).minus(Duration::from_millis(LATENCY_MS));
        let outcome = if by_tap {
            ask(&mut scene, CameraRequest::Propose(Tap { at: FIRST, captured_ns, take: false }))
        } else {
            ask(&mut scene, CameraRequest::TakeCandidate { number: candidate.number })
        };
        assert!(outcome.is_confirming, "by tap {by_tap}: {:?}", outcome.notice);
    }
}

#[test]
fn a_number_without_a_candidate_is_refused() {
    let mut scene = Scene::with(Answer::Unseeded);
    scene.see_for(3, &[]);
    for number in [0, 1, 8, u32::MAX] {
        let outcome = ask(&mut scene, CameraRequest::TakeCandidate { number });
        assert_eq!(outcome.notice, Some(Notice::RequestRefused(Refusal::NoSuchCandidate)), "{number}");
    }
}

#[test]
fn candidates_are_shown_beside_what_is_followed_on_demand_alone() {
    let mut scene = Scene::with(Answer::Tracking(INSIDE));
    assert_eq!(shown(&scene.see_for(SOME_SECONDS, &[Some(FIRST)])), []);
    ask(&mut scene, CameraRequest::Candidates { shown: true });
    let outcome = scene.see_for(SOME_SECONDS, &[Some(FIRST)]);
    candidate_at(&outcome, FIRST);
    ask(&mut scene, CameraRequest::Candidates { shown: false });
    assert_eq!(shown(&scene.see_for(3, &[Some(FIRST)])), []);
}
