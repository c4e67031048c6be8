//! What one look says about whether the target is there.

use super::config::FusedConfig;
use super::target::Target;
use crate::correlation::Peak;
use crate::features::Place;

/// One look with the filter, and the colour at the best place in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    /// What was looked at.
    pub(super) place: Place,
    /// The best place, pixels.
    pub(super) centre: (f32, f32),
    pub(super) peak: Peak,
    /// Mean likeness of the colour at the target's place, 0 to 1.
    pub(super) inside: f32,
    /// The same in the ring around it.
    pub(super) ring: f32,
}

/// Below this contrast at the selection the colour has no say.
pub(super) const TELLING_CONTRAST: f32 = 0.15;
/// From this contrast on the colour is clear, and its absence speaks for itself ...
const CLEAR_CONTRAST: f32 = 0.35;
/// ... below this share of it.
const GONE: f32 = 0.08;
/// A share of the usual contrast that speaks neither for nor against the target.
const NEUTRAL: f32 = 0.6;

/// The same for the height of the response, and what it may add or take away.
const NEUTRAL_HEIGHT: f32 = 0.5;
const HEIGHT_EVIDENCE: f32 = 8.0;
/// The usual height is not taken for less than this.
const LEAST_HEIGHT: f32 = 0.05;

impl Look {
    /// Contrast of the colour, in what is usual for the target; none where colour does not tell.
    pub(super) fn colour(&self, target: &Target) -> Option<f32> {
        (target.contrast > TELLING_CONTRAST)
            .then(|| ((self.inside - self.ring) / target.contrast).clamp(0.0, 1.0))
    }

    /// Height of the response, in what is usual for the target.
    pub(super) fn height(&self, target: &Target) -> f32 {
        self.peak.height / target.height.max(LEAST_HEIGHT)
    }

    /// Whether a colour that used to tell the target clearly from its surroundings is no longer there. Then what the
    /// filter sees is something else, be it what the target hid.
    pub(super) fn colour_gone(&self, target: &Target) -> bool {
        target.contrast > CLEAR_CONTRAST && self.colour(target).is_some_and(|share| share < GONE)
    }

    /// How much speaks for the target, in deviations of the response's sidelobes.
    pub(super) fn evidence(&self, config: &FusedConfig, target: &Target) -> f32 {
        let colour = self.colour(target).map_or(0.0, |share| share - NEUTRAL);
        let height = self.height(target).clamp(0.0, 1.0) - NEUTRAL_HEIGHT;
        self.peak.sidelobe_ratio + config.colour_evidence as f32 * colour + HEIGHT_EVIDENCE * height
    }
}

/// How likely it is that the box at the place of a look that was believed covers the target at least by half
/// (intersection over union), 0 to 1.
///
/// A logistic function of the peak over its sidelobes, of the peak's height and the colour's contrast in what is usual, and
/// of how far the target has turned since the selection where no outline shows how its box turned with it. A look
/// that is believed is seldom wrong: it is below 0.8 where the box is in doubt.
pub(super) fn confidence(look: &Look, target: &Target) -> f64 {
    let sidelobes = libm::log(f64::from(look.peak.sidelobe_ratio.max(1.0)));
    let height = f64::from(look.height(target).clamp(0.0, 1.5));
    let colour = f64::from(look.colour(target).map_or(0.0, |share| share - NEUTRAL));
    let turned = if target.outline.is_some() { 0.0 } else { f64::from(libm::sinf(target.angle).abs()) };
    let log_odds = LOG_ODDS.constant
        + LOG_ODDS.sidelobes * sidelobes
        + LOG_ODDS.height * height
        + LOG_ODDS.colour * colour
        + LOG_ODDS.turned * turned;
    1.0 / (1.0 + libm::exp(-log_odds))
}

/// The same for a box that was carried on by prediction, so many seconds after the target was last seen.
pub(super) fn confidence_unseen(seconds: f64) -> f64 {
    (UNSEEN_AT_FIRST - UNSEEN_PER_S * seconds).max(LEAST_CONFIDENCE)
}

/// The same for the best look at a lost target, which was not believed.
pub(super) fn confidence_disbelieved(look: &Look, target: &Target) -> f64 {
    DISBELIEVED * confidence(look, target)
}

struct LogOdds {
    constant: f64,
    sidelobes: f64,
    height: f64,
    colour: f64,
    turned: f64,
}

/// Fitted to the recordings that `xtask acceptance tracker` plays, each with the root of its count of frames, and
/// rounded.
const LOG_ODDS: LogOdds = LogOdds { constant: 0.5, sidelobes: 0.4, height: 1.4, colour: 0.5, turned: -2.0 };
/// Of the boxes that were carried on, nine of ten are right at first, half after a third of a second.
const UNSEEN_AT_FIRST: f64 = 0.9;
const UNSEEN_PER_S: f64 = 1.2;
const LEAST_CONFIDENCE: f64 = 0.05;
/// What becomes of the confidence of a look that was not believed.
const DISBELIEVED: f64 = 0.3;
