//! What an observation says about whether the target is there: evidence and confidence.

use super::appearance::relative_height;
use super::box_probability::from_log_odds;
use super::config::FusedConfig;
use super::observation::Observation;
use super::target::Target;

/// At a lower usual contrast the colour is not used.
pub(super) const MIN_CONTRAST: f32 = 0.15;
/// From this usual contrast on, the absence of the colour alone rejects an observation: a relative contrast below
/// `MAX_ABSENT_COLOUR`.
const CLEAR_CONTRAST: f32 = 0.35;
const MAX_ABSENT_COLOUR: f32 = 0.08;
/// From this relative height of the response on, the pattern is the target's whatever its colour: a change of the light
/// or of the camera's white balance moves all colours within a second, and the colour model with them.
const CLEAR_PATTERN: f32 = 0.9;
/// Relative contrast that is evidence neither for nor against the target.
const NEUTRAL_COLOUR: f32 = 0.6;
/// Relative height of the response that is evidence neither for nor against the target, and the evidence per unit of
/// relative height.
const NEUTRAL_HEIGHT: f32 = 0.5;
const HEIGHT_EVIDENCE: f32 = 8.0;

impl Observation {
    /// Contrast of the colour relative to its usual value, 0 to 1; `None` where the colour is not used.
    pub(super) fn relative_contrast(&self, target: &Target) -> Option<f32> {
        let usual = target.appearance.usual.contrast;
        (usual > MIN_CONTRAST).then(|| (self.contrast.difference() / usual).clamp(0.0, 1.0))
    }

    /// Height of the response relative to its usual value.
    pub(super) fn relative_height(&self, target: &Target) -> f32 {
        relative_height(self.peak.height, target.appearance.usual.peak_height)
    }

    /// Whether the response is about as high as the target's usually is.
    pub(super) fn is_pattern_clear(&self, target: &Target) -> bool {
        self.relative_height(target) >= CLEAR_PATTERN
    }

    /// Whether a colour that is usually distinct is absent, and the pattern is not clear. Then the filter responds to
    /// something else, such as what hides the target.
    pub(super) fn is_colour_absent(&self, target: &Target) -> bool {
        let contrast = self.relative_contrast(target);
        is_colour_missing(target.appearance.usual.contrast, contrast, self.is_pattern_clear(target))
    }

    /// Evidence for the target, in standard deviations of the response's sidelobes.
    pub(super) fn evidence(&self, config: &FusedConfig, target: &Target) -> f32 {
        let colour = self.relative_contrast(target).map_or(0.0, |share| share - NEUTRAL_COLOUR);
        let height = self.relative_height(target).clamp(0.0, 1.0) - NEUTRAL_HEIGHT;
        self.peak.peak_to_sidelobe_ratio + config.colour_evidence as f32 * colour + HEIGHT_EVIDENCE * height
    }
}

/// Whether a colour of this usual contrast is missing, given its relative contrast here.
fn is_colour_missing(usual_contrast: f32, relative_contrast: Option<f32>, is_pattern_clear: bool) -> bool {
    usual_contrast > CLEAR_CONTRAST
        && !is_pattern_clear
        && relative_contrast.is_some_and(|share| share < MAX_ABSENT_COLOUR)
}

/// Confidence in an observation by pattern and colour alone, 0 to 1: a logistic function of the logarithm of the
/// peak-to-sidelobe ratio, of the relative height and contrast, and, where there is no reference silhouette, of the
/// rotation since the selection.
fn pattern_confidence(observation: &Observation, target: &Target) -> f64 {
    let sidelobes = libm::log(f64::from(observation.peak.peak_to_sidelobe_ratio.max(1.0)));
    let height = f64::from(observation.relative_height(target).clamp(0.0, 1.5));
    let colour = f64::from(observation.relative_contrast(target).map_or(0.0, |share| share - NEUTRAL_COLOUR));
    let turned = if target.reference.is_some() {
        0.0
    } else {
        f64::from(libm::sinf(target.geometry.patch_angle).abs())
    };
    let log_odds = LOG_ODDS.constant
        + LOG_ODDS.sidelobes * sidelobes
        + LOG_ODDS.height * height
        + LOG_ODDS.colour * colour
        + LOG_ODDS.turned * turned;
    from_log_odds(log_odds)
}

/// Confidence of a rejected observation.
pub(super) fn rejected_confidence(observation: &Observation, target: &Target) -> f64 {
    REJECTED_FACTOR * pattern_confidence(observation, target)
}

/// Weights of the logistic function.
struct LogOdds {
    constant: f64,
    sidelobes: f64,
    height: f64,
    colour: f64,
    turned: f64,
}

/// Fitted to the labelled recordings of the tracker's evaluation, each weighted with the root of its number of frames,
/// and rounded.
const LOG_ODDS: LogOdds = LogOdds { constant: 0.5, sidelobes: 0.4, height: 1.4, colour: 0.5, turned: -2.0 };
/// Factor on the confidence of a rejected observation.
pub(super) const REJECTED_FACTOR: f64 = 0.3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distinct_colour_is_missing_only_where_the_pattern_is_not_clear() {
        let distinct = CLEAR_CONTRAST + 0.1;
        assert!(is_colour_missing(distinct, Some(0.0), false), "something else hides the target");
        assert!(!is_colour_missing(distinct, Some(0.0), true), "the target in another light");
        assert!(!is_colour_missing(distinct, Some(0.5), false), "the colour is there");
        assert!(!is_colour_missing(CLEAR_CONTRAST - 0.1, Some(0.0), false), "a colour like the water's");
        assert!(!is_colour_missing(distinct, None, false), "the colour is not used");
    }
}
