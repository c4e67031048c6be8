//! Whether what is followed moves as the boat that is commanded would move. Two checks:
//!
//! 1. [`AnswerCheck`]: the spread of the places in the last [`WINDOW_S`]. The spread is the root of the mean
//!    squared distance from the mean place. It depends neither on where a way begins nor on its direction, so
//!    places that are seen can be compared with those of the vessel's model under the commands that were in
//!    force.
//! 2. [`ApproachCheck`]: whether the boat comes nearer to the end of its leg while the model goes a way
//!    through the water.
//!
//! What hardly moves, or comes no nearer, is not the boat that is commanded (another object was selected or
//! is followed instead), or the boat's drive has failed, or something holds the boat: a net, a line, or a
//! current as fast as the boat.
//!
//! Not found: an object that goes to the boat's destination by itself. A model that turns in circles spreads
//! little: then only the second check finds an object at rest. Work: O(1) per fix; O(n) for n stored places
//! where the first check is asked.

use crate::ring::Ring;

/// Time over which the ways are compared, seconds.
const WINDOW_S: f64 = 8.0;
/// Interval of the stored places, seconds, and the gap after which a new window begins.
const INTERVAL_S: f64 = 0.25;
const MAX_GAP_S: f64 = 1.0;
/// Stored places; they cover the window.
const PLACES: usize = 36;
/// Least spread of the model's places, metres: that of a straight way of 10.4 m.
const MIN_MODELLED_M: f64 = 3.0;
/// What is seen does not answer if it spreads by less than this share of the model's spread: the model knows
/// the boat's speed roughly.
const MAX_SHARE: f64 = 0.15;

/// The boat has to come nearer to the end of its leg by this much, metres, in this time, seconds, if the
/// model goes this far through the water meanwhile, metres.
const LEAST_APPROACH_M: f64 = 1.0;
const APPROACH_S: f64 = 20.0;
const LEAST_WAY_M: f64 = 15.0;

/// Where the boat was seen, and where the model was, along x and y, metres. The model's places have an origin
/// and axes of their own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) at_s: f64,
    pub(super) seen: (f64, f64),
    pub(super) modelled: (f64, f64),
}

const NO_PLACE: Place = Place { at_s: f64::NEG_INFINITY, seen: (0.0, 0.0), modelled: (0.0, 0.0) };

/// The comparison with its places.
#[derive(Debug, Clone)]
pub(super) struct AnswerCheck {
    places: Ring<Place, PLACES>,
}

impl AnswerCheck {
    /// A comparison without places.
    pub(super) fn new() -> Self {
        Self { places: Ring::new(NO_PLACE) }
    }

    /// Begins a new window.
    pub(super) fn restart(&mut self) {
        self.places.for_each_mut(|place| *place = NO_PLACE);
    }

    /// Adds a place that was seen while the boat was commanded, and the model's at the same time.
    pub(super) fn add(&mut self, at_s: f64, seen: (f64, f64), modelled: (f64, f64)) {
        if at_s - self.places.newest().at_s > MAX_GAP_S {
            self.restart();
        }
        let place = Place { at_s, seen, modelled };
        self.places.push(place, |previous, newest| newest.at_s - previous.at_s >= INTERVAL_S);
    }

    /// The places of so many seconds before the newest one, newest first; none after a restart.
    pub(super) fn window(&self, duration_s: f64) -> impl Iterator<Item = &Place> {
        let newest = self.places.newest();
        core::iter::once(newest)
            .chain(self.places.earlier())
            .take_while(move |place| newest.at_s - place.at_s <= duration_s)
    }

    /// Whether the boat did not answer over the whole window before the newest place.
    pub(super) fn is_unanswered(&self) -> bool {
        let now_s = self.places.newest().at_s;
        let window = || self.window(WINDOW_S + INTERVAL_S);
        let is_whole = window().last().is_some_and(|oldest| now_s - oldest.at_s >= WINDOW_S);
        if !is_whole {
            return false;
        }
        let modelled_m = spread(window().map(|place| place.modelled));
        modelled_m >= MIN_MODELLED_M && spread(window().map(|place| place.seen)) < MAX_SHARE * modelled_m
    }
}

/// Whether the boat comes nearer to the end of its leg.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ApproachCheck {
    nearest: Option<Approach>,
    last_s: f64,
    has_moved: bool,
    is_unanswered: bool,
}

/// The nearest that the boat came to the end of a leg.
#[derive(Debug, Clone, Copy)]
struct Approach {
    leg: usize,
    at_s: f64,
    distance_m: f64,
    /// Length of the model's way until then, metres.
    way_m: f64,
}

impl ApproachCheck {
    /// Expects an approach from now on.
    pub(super) const fn restart(&mut self) {
        self.nearest = None;
        self.is_unanswered = false;
    }

    /// The end of the leg is elsewhere now. Time and way since the last approach go on: a boat that answers
    /// has just come nearer to the end that was.
    pub(super) const fn move_end(&mut self) {
        self.has_moved = true;
    }

    /// Adds the distance from the end of a leg that the boat goes to, and the length of the model's way so
    /// far, metres.
    pub(super) fn add(&mut self, leg: usize, at_s: f64, distance_m: f64, way_m: f64) {
        if at_s - self.last_s > MAX_GAP_S {
            self.restart();
        }
        self.last_s = at_s;
        if core::mem::take(&mut self.has_moved)
            && let Some(nearest) = &mut self.nearest
        {
            (nearest.leg, nearest.distance_m) = (leg, distance_m);
        }
        match self.nearest {
            Some(nearest) if nearest.leg == leg && distance_m > nearest.distance_m - LEAST_APPROACH_M => {
                self.is_unanswered =
                    at_s - nearest.at_s >= APPROACH_S && way_m - nearest.way_m >= LEAST_WAY_M;
            }
            _ => {
                self.nearest = Some(Approach { leg, at_s, distance_m, way_m });
                self.is_unanswered = false;
            }
        }
    }

    /// Whether the boat came no nearer.
    pub(super) const fn is_unanswered(&self) -> bool {
        self.is_unanswered
    }
}

/// Root of the mean squared distance from the mean place.
fn spread(places: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut count, mut mean_x, mut mean_y, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for (x, y) in places {
        count += 1.0;
        let (dx, dy) = (x - mean_x, y - mean_y);
        mean_x += dx / count;
        mean_y += dy / count;
        squares += dx * (x - mean_x) + dy * (y - mean_y);
    }
    libm::sqrt(squares / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first time at which a boat is unanswered that is seen and modelled at these places, at this rate
    /// for 20 s.
    fn unanswered_at_rate(
        rate_hz: f64,
        seen: impl Fn(f64) -> (f64, f64),
        modelled: impl Fn(f64) -> (f64, f64),
    ) -> Option<f64> {
        let mut check = AnswerCheck::new();
        (0..).map(|frame| f64::from(frame) / rate_hz).take_while(|at_s| *at_s < 20.0).find(|&at_s| {
            check.add(at_s, seen(at_s), modelled(at_s));
            check.is_unanswered()
        })
    }

    fn unanswered_at(seen: impl Fn(f64) -> (f64, f64), modelled: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
        unanswered_at_rate(30.0, seen, modelled)
    }

    fn sway(at_s: f64) -> (f64, f64) {
        (0.6 * libm::sin(0.7 * at_s), 0.4 * libm::cos(1.1 * at_s))
    }

    fn ahead(at_s: f64) -> (f64, f64) {
        (0.0, 2.0 * at_s)
    }

    #[test]
    fn an_object_at_rest_does_not_answer_although_the_camera_sways() {
        for rate_hz in [5.0, 8.0, 15.0, 30.0, 60.0] {
            let at_s = unanswered_at_rate(rate_hz, sway, ahead).expect("found");
            assert!((WINDOW_S..WINDOW_S + 2.0 * INTERVAL_S).contains(&at_s), "{rate_hz} Hz: {at_s}");
        }
    }

    #[test]
    fn a_boat_answers_in_any_direction_and_at_another_speed() {
        let slow = |at_s: f64| (1.0 - 0.5 * at_s, 0.3 * at_s);
        assert_eq!(unanswered_at(slow, ahead), None);
    }

    #[test]
    fn nothing_is_expected_of_a_boat_that_shall_rest_or_turns_on_the_spot() {
        let resting = |_| (3.0, 3.0);
        assert_eq!(unanswered_at(sway, resting), None);
        let turning = |at_s: f64| (1.6 * libm::sin(at_s), 1.6 * libm::cos(at_s));
        assert_eq!(unanswered_at(|_| (0.0, 0.0), turning), None);
    }

    #[test]
    fn a_gap_and_a_restart_begin_a_new_window() {
        let mut check = AnswerCheck::new();
        let add = |check: &mut AnswerCheck, from_s: f64, to_s: f64| {
            let mut at_s = from_s;
            while at_s < to_s {
                check.add(at_s, (0.0, 0.0), ahead(at_s));
                at_s += 0.1;
            }
            check.is_unanswered()
        };
        assert!(!add(&mut check, 0.0, 7.0));
        assert!(!add(&mut check, 9.0, 16.5), "a gap of 2 s");
        assert!(add(&mut check, 16.5, 18.0));
        check.restart();
        assert!(!check.is_unanswered());
        assert!(!add(&mut check, 18.0, 25.5));
    }

    /// The first time within 40 s at which a boat is unanswered that has this distance from the end of its
    /// leg, while the model goes at 2 m/s. The end moves at these times.
    fn far_at(
        leg: impl Fn(f64) -> usize,
        distance_m: impl Fn(f64) -> f64,
        moves_at: impl Fn(u32) -> bool,
    ) -> Option<f64> {
        let mut check = ApproachCheck::default();
        (0..1200).find_map(|frame| {
            let at_s = f64::from(frame) / 30.0;
            if moves_at(frame) {
                check.move_end();
            }
            check.add(leg(at_s), at_s, distance_m(at_s), 2.0 * at_s);
            check.is_unanswered().then_some(at_s)
        })
    }

    const NEVER: fn(u32) -> bool = |_| false;

    #[test]
    fn a_boat_that_comes_no_nearer_does_not_answer() {
        assert_eq!(far_at(|_| 0, |at_s| 15.0 + 0.7 * at_s, NEVER), Some(APPROACH_S), "it drifts off");
        let at_s = far_at(|_| 0, |at_s| (15.0 - at_s).max(10.0), NEVER).expect("found");
        assert!((APPROACH_S + 5.0..APPROACH_S + 6.0).contains(&at_s), "it stands since 5 s: {at_s}");
    }

    #[test]
    fn an_end_that_moves_is_no_excuse() {
        // The operator moves the mark away and back, every 5 s.
        let distance_m = |at_s: f64| if ((at_s / 5.0) as u32).is_multiple_of(2) { 15.0 } else { 18.0 };
        assert_eq!(far_at(|_| 0, distance_m, |frame| frame.is_multiple_of(150)), Some(APPROACH_S));
    }

    #[test]
    fn a_new_end_far_away_is_no_fault_of_the_boat() {
        // At 10 s the boat, 5 m from its goal, gets another one 90 m away.
        let distance_m = |at_s: f64| if at_s < 10.0 { 15.0 - at_s } else { 90.0 - 2.0 * (at_s - 10.0) };
        assert_eq!(far_at(|_| 0, distance_m, |frame| frame == 300), None);
    }

    #[test]
    fn the_approach_begins_anew_after_a_gap() {
        let mut check = ApproachCheck::default();
        check.add(0, 0.0, 15.0, 0.0);
        check.add(0, 60.0, 15.0, 120.0);
        assert!(!check.is_unanswered());
    }

    #[test]
    fn a_boat_that_comes_nearer_or_goes_to_the_next_leg_answers() {
        assert_eq!(far_at(|_| 0, |at_s| 15.0 - 0.1 * at_s, NEVER), None);
        assert_eq!(far_at(|at_s| (at_s / 15.0) as usize, |_| 15.0, NEVER), None);
        let mut check = ApproachCheck::default();
        for frame in 0..1200 {
            // The model rests.
            check.add(0, f64::from(frame) / 30.0, 15.0, 3.0);
        }
        assert!(!check.is_unanswered());
    }
}
