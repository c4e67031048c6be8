//! The stage that computes the confidence of the answer: of an accepted box over several frames, of a
//! prediction, and of a rejected observation.
//!
//! The network judges each frame independently. Part of its error changes from frame to frame, while a track
//! is right or wrong over many frames. A moving mean of the log-odds therefore has less error than a single
//! frame. The answer combines the mean with the last frame, so that the confidence falls at once when the
//! target is hidden.
//!
//! Input: the network's probability, or an observation. Output: a confidence, 0 to 1.

use barrelman_vocab::Timestamp;

use super::observation::Observation;
use super::target::Target;
use super::time_constant::share_in;

/// Lower bound of a probability and of its complement before the log-odds are computed.
const MIN_PROBABILITY: f64 = 1.0e-3;

/// Settings of the confidence. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct ConfidenceSettings {
    /// Time constant of the mean, seconds. Chosen by the confidences of left-out clips (decision 22).
    mean_s: f64,
    /// Share of the mean in the answer, 0 to 1. Chosen likewise.
    mean_share: f64,
    /// Factor on the answer's log-odds. The network's log-odds were calibrated for one frame; the mean has
    /// less error. Chosen likewise.
    gain: f64,
    /// Confidence of a predicted box relative to that of the last accepted box, 0 to 1. On 39 labelled
    /// recordings, 0.20, 0.20, 0.20 and 0.10 of the predicted boxes were right in the first four frames. With
    /// this share and the next setting, the confidences are 0.20, 0.19, 0.16 and 0.10.
    predicted_share: f64,
    /// Time constant with which the confidence of a predicted box falls, seconds.
    prediction_s: f64,
    /// Minimum confidence of a predicted box, 0 to 1.
    min_prediction: f64,
    /// Confidence of a box onto which the track was moved, before the network has evaluated it, 0 to 1.
    pub(super) unjudged: f64,
    /// Factor after a contact with an object of the target's colour, while it is not known which of the two
    /// is followed. The target was followed in four of five such frames.
    pub(super) contact_share: f64,
    /// Factor on the confidence of a rejected observation, and maximum confidence of a target that is lost,
    /// or not confirmed yet.
    rejected_factor: f64,
    /// Weights of a rejected observation's confidence, a logistic function. Fitted to the labelled recordings
    /// of the tracker's evaluation, each weighted with the root of its number of frames, and rounded: the
    /// constant, ...
    log_odds: f64,
    /// ... the weight of the logarithm of the peak-to-sidelobe ratio, ...
    log_odds_sidelobes: f64,
    /// ... that of the relative height, ...
    log_odds_height: f64,
    /// ... that of the relative contrast, less the neutral one, ...
    log_odds_colour: f64,
    /// ... that neutral contrast, 0 to 1, ...
    neutral_colour: f32,
    /// ... and the weight of the sine of the rotation since the selection, of a target without a silhouette.
    log_odds_turned: f64,
}

impl Default for ConfidenceSettings {
    fn default() -> Self {
        Self {
            mean_s: 0.4,
            mean_share: 0.5,
            gain: 1.1,
            predicted_share: 0.6,
            prediction_s: 0.13,
            min_prediction: 0.05,
            unjudged: 0.5,
            contact_share: 0.8,
            rejected_factor: 0.3,
            log_odds: 0.5,
            log_odds_sidelobes: 0.4,
            log_odds_height: 1.4,
            log_odds_colour: 0.5,
            neutral_colour: 0.6,
            log_odds_turned: -2.0,
        }
    }
}

/// The confidences of the followed box so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Confidence {
    pub(super) settings: ConfidenceSettings,
    /// Mean of the log-odds; `None` before the first frame since a selection or a jump.
    mean: Option<f64>,
    /// Time of capture of the last frame in which the target was seen, and the probability of the box in it,
    /// 0 to 1.
    seen: Timestamp,
    last: f64,
}

impl Confidence {
    pub(super) fn new() -> Self {
        Self { settings: ConfidenceSettings::default(), mean: None, seen: Timestamp::ZERO, last: 1.0 }
    }

    /// Begins with the box of a selection on the frame that was captured `now`.
    pub(super) fn select(&mut self, now: Timestamp) {
        (self.mean, self.seen, self.last) = (None, now, 1.0);
    }

    /// Adds the network's probability for the frame that was captured `now`. Returns the confidence of the
    /// box, 0 to 1.
    pub(super) fn add(&mut self, probability: f32, now: Timestamp) -> f64 {
        let settings = &self.settings;
        let probability = f64::from(probability).clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY);
        let log_odds = libm::log(probability / (1.0 - probability));
        let share = share_in(self.seconds_since_seen(now), settings.mean_s);
        let mean = self.mean.map_or(log_odds, |mean| mean + share * (log_odds - mean));
        let combined = settings.gain * (log_odds + settings.mean_share * (mean - log_odds));
        (self.mean, self.seen) = (Some(mean), now);
        self.last = from_log_odds(combined);
        self.last
    }

    /// Confidence of a box that is predicted for the frame that was captured `now`, 0 to 1.
    pub(super) fn of_prediction(&self, now: Timestamp) -> f64 {
        let settings = &self.settings;
        (settings.predicted_share
            * self.last
            * libm::exp(-self.seconds_since_seen(now) / settings.prediction_s))
        .max(settings.min_prediction)
    }

    /// Confidence of a rejected observation, by pattern and colour alone, 0 to 1.
    pub(super) fn of_rejected(&self, observation: &Observation, target: &Target) -> f64 {
        let settings = &self.settings;
        let sidelobes = libm::log(f64::from(observation.peak.peak_to_sidelobe_ratio.max(1.0)));
        let height = f64::from(observation.relative_height.clamp(0.0, 1.5));
        let colour =
            f64::from(observation.relative_contrast.map_or(0.0, |share| share - settings.neutral_colour));
        let turned = if target.reference.is_some() {
            0.0
        } else {
            f64::from(libm::sinf(target.geometry.patch_angle).abs())
        };
        let log_odds = settings.log_odds
            + settings.log_odds_sidelobes * sidelobes
            + settings.log_odds_height * height
            + settings.log_odds_colour * colour
            + settings.log_odds_turned * turned;
        settings.rejected_factor * from_log_odds(log_odds)
    }

    /// Confidence of a target that is lost, or not confirmed yet.
    pub(super) fn of_lost(&self, confidence: f64) -> f64 {
        confidence.min(self.settings.rejected_factor)
    }

    fn seconds_since_seen(&self, now: Timestamp) -> f64 {
        now.since(self.seen).as_secs_f64()
    }

    /// Drops the mean, since the track continues at another place.
    pub(super) fn restart(&mut self) {
        self.mean = None;
    }
}

/// The probability with these log-odds.
fn from_log_odds(log_odds: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-log_odds))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_NS: u64 = 33_333_333;

    fn selected() -> Confidence {
        let mut confidence = Confidence::new();
        confidence.select(Timestamp::from_nanos(0));
        confidence
    }

    /// The answer to the last of these probabilities, in consecutive frames.
    fn after(probabilities: &[f32]) -> f64 {
        let mut probability = selected();
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
        let mut probability = selected();
        probability.add(0.9, Timestamp::from_nanos(0));
        probability.restart();
        assert!((probability.add(0.5, Timestamp::from_nanos(FRAME_NS)) - 0.5).abs() < 1.0e-6);
        let later = probability.add(0.5, Timestamp::from_nanos(FRAME_NS + 10_000_000_000));
        assert!((later - 0.5).abs() < 1.0e-6, "{later}");
    }

    #[test]
    fn a_prediction_is_worth_less_with_each_frame() {
        let mut probability = selected();
        probability.add(0.9, Timestamp::from_nanos(FRAME_NS));
        let after = |frames: u64| probability.of_prediction(Timestamp::from_nanos((1 + frames) * FRAME_NS));
        assert!(after(1) > 0.36 && after(1) < 0.45, "{}", after(1));
        assert!(after(4) > 0.15 && after(4) < 0.24, "{}", after(4));
        assert!((after(60) - ConfidenceSettings::default().min_prediction).abs() < 1.0e-9);
    }

    #[test]
    fn certain_answers_stay_finite() {
        assert!(after(&[1.0, 0.0, 1.0]).is_finite());
    }
}
