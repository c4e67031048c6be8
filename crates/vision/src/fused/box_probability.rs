//! The probability of the followed box, over frames.
//!
//! The network judges each frame by itself. A part of its error differs from frame to frame, while the track is right or wrong for
//! longer: a moving mean of the log-odds knows more than the last frame. The frame counts for the rest, so that the confidence
//! falls at once where the target is hidden.

use barrelman_vocab::Timestamp;

use super::shape_following::share_in;

/// Time constant of the mean, seconds, and its share in the answer.
const MEAN_S: f64 = 0.4;
const MEAN_SHARE: f64 = 0.5;
/// Factor on the answer's log-odds: the mean has less error than one frame, for which the network's own log-odds were calibrated.
const GAIN: f64 = 1.1;
/// Lower bound of a probability, and of its complement, of which log-odds are taken.
const MIN_PROBABILITY: f64 = 1.0e-3;

/// Share of the last box's probability that a predicted box has, and the time constant with which it falls,
/// seconds. On 39 labelled recordings 0.20, 0.20, 0.20 and 0.10 of the predicted boxes were right in the
/// first four frames; these give 0.20, 0.19, 0.16 and 0.10.
const PREDICTED_SHARE: f64 = 0.6;
const PREDICTION_S: f64 = 0.13;
const MIN_PREDICTION: f64 = 0.05;

/// What was said of the followed box until now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BoxProbability {
    /// Mean of the log-odds; `None` before the first frame of a place.
    mean: Option<f64>,
    /// Time of capture of the last frame in which the target was seen, and the probability of the box in it, 0 to 1.
    seen: Timestamp,
    last: f64,
}

impl BoxProbability {
    /// Nothing was said yet of the box of a selection on the frame that was captured `now`.
    pub(super) fn of_selection(now: Timestamp) -> Self {
        Self { mean: None, seen: now, last: 1.0 }
    }

    /// Adds the network's probability for the frame that was captured `now`. The probability of the box, 0 to 1.
    pub(super) fn add(&mut self, probability: f32, now: Timestamp) -> f64 {
        let probability = f64::from(probability).clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY);
        let log_odds = libm::log(probability / (1.0 - probability));
        let share = share_in(self.seconds_since_seen(now), MEAN_S);
        let mean = self.mean.map_or(log_odds, |mean| mean + share * (log_odds - mean));
        let combined = GAIN * (log_odds + MEAN_SHARE * (mean - log_odds));
        (self.mean, self.seen) = (Some(mean), now);
        self.last = from_log_odds(combined);
        self.last
    }

    /// Probability of a box that is predicted for the frame that was captured `now`, 0 to 1.
    pub(super) fn of_prediction(&self, now: Timestamp) -> f64 {
        (PREDICTED_SHARE * self.last * libm::exp(-self.seconds_since_seen(now) / PREDICTION_S))
            .max(MIN_PREDICTION)
    }

    fn seconds_since_seen(&self, now: Timestamp) -> f64 {
        now.since(self.seen).as_secs_f64()
    }

    /// Forgets the mean: the track goes on at another place.
    pub(super) fn restart(&mut self) {
        self.mean = None;
    }
}

/// The probability with these log-odds.
pub(super) fn from_log_odds(log_odds: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-log_odds))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_NS: u64 = 33_333_333;

    /// The answer to the last of these probabilities, in consecutive frames.
    fn after(probabilities: &[f32]) -> f64 {
        let mut probability = BoxProbability::of_selection(Timestamp::from_nanos(0));
        let frames = (0_u64..).map(|frame| Timestamp::from_nanos(frame * FRAME_NS));
        probabilities.iter().zip(frames).fold(0.0, |_, (&value, at)| probability.add(value, at))
    }

    #[test]
    fn equal_frames_give_about_their_own_probability() {
        assert!((after(&[0.5; 20]) - 0.5).abs() < 1.0e-6);
        let probable = after(&[0.7; 20]);
        assert!(probable > 0.7 && probable < 0.73, "{probable}");
    }

    #[test]
    fn one_bad_frame_counts_less_and_many_count_fully() {
        let mut probabilities = vec![0.95; 30];
        probabilities.push(0.3);
        let first = after(&probabilities);
        assert!(first > 0.5 && first < 0.75, "{first}");
        probabilities.extend([0.3; 30]);
        let later = after(&probabilities);
        assert!(later > 0.25 && later < 0.35, "{later}");
    }

    #[test]
    fn another_place_and_a_long_pause_begin_anew() {
        let mut probability = BoxProbability::of_selection(Timestamp::from_nanos(0));
        probability.add(0.9, Timestamp::from_nanos(0));
        probability.restart();
        assert!((probability.add(0.5, Timestamp::from_nanos(FRAME_NS)) - 0.5).abs() < 1.0e-6);
        let later = probability.add(0.5, Timestamp::from_nanos(FRAME_NS + 10_000_000_000));
        assert!((later - 0.5).abs() < 1.0e-6, "{later}");
    }

    #[test]
    fn a_prediction_is_worth_less_with_each_frame() {
        let mut probability = BoxProbability::of_selection(Timestamp::from_nanos(0));
        probability.add(0.9, Timestamp::from_nanos(FRAME_NS));
        let after = |frames: u64| probability.of_prediction(Timestamp::from_nanos((1 + frames) * FRAME_NS));
        assert!(after(1) > 0.36 && after(1) < 0.45, "{}", after(1));
        assert!(after(4) > 0.15 && after(4) < 0.24, "{}", after(4));
        assert!((after(60) - MIN_PREDICTION).abs() < 1.0e-9);
    }

    #[test]
    fn certain_answers_stay_finite() {
        assert!(after(&[1.0, 0.0, 1.0]).is_finite());
    }
}
