//! Where the bow points, told by how the boat answers to its thrust.
//!
//! The places that were seen in the last [`WINDOW_S`] are fitted by `place + current t + g way`, with complex
//! numbers for points, and the way of the vessel's model through the water. The current is small beforehand:
//! [`CURRENT_M_PER_S`]. The angle of g turns the axes of the model's way to those of the places, and its
//! size is 1 where the model is right.
//!
//! A bow that is estimated from courses, or seen as the wrong end of the boat, may be the stern. A boat that
//! goes astern to keep off a person then goes to the person. So a bow is corrected that was contradicted for
//! [`CONTRADICTED_S`] where the tracker sees no axis. Smaller errors are not: the fit is coarse
//! (`docs/decisions/0062-a-bow-that-is-contradicted.md`). Work: O(n) per fix for n stored places.

use barrelman_vocab::wrapped;

use crate::guidance::answer::{AnswerCheck, Place};

/// Time over which the ways are fitted, seconds.
const WINDOW_S: f64 = 5.0;
/// Least number of places that are fitted.
const MIN_PLACES: usize = 6;
/// Standard deviations of a current's components, m/s, and of a place, metres: waves and the camera's sway.
const CURRENT_M_PER_S: f64 = 0.4;
const PLACE_M: f64 = 0.3;
/// Sizes of g that the model's errors explain, and the least one in its standard deviations.
const GAINS: core::ops::Range<f64> = 0.3..3.0;
const MIN_SIGNIFICANCE: f64 = 4.0;
/// A bow that is farther off than this, radians, is contradicted.
const MAX_OFF_RAD: f64 = 1.6;
/// A bow is corrected that was contradicted for this time, seconds.
const CONTRADICTED_S: f64 = 0.5;

/// The check of the bow.
#[derive(Debug, Clone, Default)]
pub(super) struct AnsweredBow {
    contradicted_since_s: Option<f64>,
}

impl AnsweredBow {
    /// The angle from the model's axes to those of the places that contradicts a bow `bow_rad` to the right
    /// of the model's axes, once it has done so long enough, radians.
    pub(super) fn contradiction(&mut self, answer: &AnswerCheck, at_s: f64, bow_rad: f64) -> Option<f64> {
        let Some(angle) = axes(answer).filter(|angle| wrapped(angle - bow_rad).abs() > MAX_OFF_RAD) else {
            self.contradicted_since_s = None;
            return None;
        };
        let since_s = *self.contradicted_since_s.get_or_insert(at_s);
        (at_s - since_s >= CONTRADICTED_S).then_some(angle)
    }
}

/// The direction of the model's axes, radians to the right; `None` where the ways do not tell it.
fn axes(answer: &AnswerCheck) -> Option<f64> {
    let window = || answer.window(WINDOW_S);
    let count = window().count();
    if count < MIN_PLACES {
        return None;
    }
    let mean = |value: fn(&Place) -> (f64, f64)| {
        let (x, y) = window().map(value).fold((0.0, 0.0), |sum, at| (sum.0 + at.0, sum.1 + at.1));
        (x / count as f64, y / count as f64)
    };
    let (seen_mean, modelled_mean) = (mean(|place| place.seen), mean(|place| place.modelled));
    let (time_mean, _) = mean(|place| (place.at_s, 0.0));
    // Sums of products, each with the conjugate of the first factor.
    let mut times = PLACE_M * PLACE_M / (CURRENT_M_PER_S * CURRENT_M_PER_S);
    let (mut way, mut way_of_time, mut seen_of_time, mut seen_of_way) =
        (0.0, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0));
    for place in window() {
        let t = place.at_s - time_mean;
        let (x, y) = (place.modelled.0 - modelled_mean.0, place.modelled.1 - modelled_mean.1);
        let (u, v) = (place.seen.0 - seen_mean.0, place.seen.1 - seen_mean.1);
        times += t * t;
        way += x * x + y * y;
        way_of_time = (way_of_time.0 + t * x, way_of_time.1 + t * y);
        seen_of_time = (seen_of_time.0 + t * u, seen_of_time.1 + t * v);
        seen_of_way = (seen_of_way.0 + x * u + y * v, seen_of_way.1 + x * v - y * u);
    }
    // Without what the current explains.
    let ((a, b), (u, v)) = (way_of_time, seen_of_time);
    let way = way - (a * a + b * b) / times;
    let (re, im) = (seen_of_way.0 - (a * u + b * v) / times, seen_of_way.1 - (a * v - b * u) / times);
    let size = libm::hypot(re, im);
    let is_told =
        way > 0.0 && GAINS.contains(&(size / way)) && size > MIN_SIGNIFICANCE * PLACE_M * libm::sqrt(way);
    // An angle of complex numbers is one to the left.
    is_told.then(|| -libm::atan2(im, re))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guidance::estimate::turned;

    /// The first time at which a bow is contradicted, and the angle, of a boat that goes astern from 2 s on,
    /// in a current, with its bow `bow` radians to the right, for 10 s at 15 frames/s. The boat goes at this
    /// share of the speed of the model.
    fn contradicted(bow: f64, assumed: f64, share: f64) -> Option<(f64, f64)> {
        let (mut answer, mut check) = (AnswerCheck::new(), AnsweredBow::default());
        (0..150).find_map(|frame| {
            let at_s = f64::from(frame) / 15.0;
            let after_s = (at_s - 2.0).max(0.0);
            let astern = (0.0, -1.5 * (after_s - 1.5 * (1.0 - libm::exp(-after_s / 1.5))));
            let wave = (0.15 * libm::sin(2.1 * at_s), 0.1 * libm::cos(1.7 * at_s));
            let (x, y) = turned(astern, bow);
            let seen = (0.3 * at_s + share * x + wave.0, -0.1 * at_s + share * y + wave.1);
            answer.add(at_s, seen, astern);
            check.contradiction(&answer, at_s, assumed).map(|angle| (at_s, angle))
        })
    }

    #[test]
    fn a_boat_that_goes_to_its_supposed_bow_while_it_shall_go_astern_has_the_bow_elsewhere() {
        for bow in [0.0, 1.0, 2.5, -2.0] {
            let (at_s, angle) = contradicted(bow, wrapped(bow + core::f64::consts::PI), 1.0).expect("found");
            assert!((2.5..6.0).contains(&at_s), "{bow}: {at_s}");
            assert!(wrapped(angle - bow).abs() < 0.8, "{bow}: {angle}");
        }
    }

    #[test]
    fn a_right_bow_is_not_contradicted_nor_one_of_a_boat_that_does_not_answer() {
        for bow in [0.0, 1.0, 2.5, -2.0] {
            assert_eq!(contradicted(bow, wrapped(bow + 0.6), 1.0), None);
            assert_eq!(contradicted(bow, wrapped(bow + core::f64::consts::PI), 0.0), None);
        }
    }
}
