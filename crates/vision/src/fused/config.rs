//! Settings of the fused tracker.

use thiserror::Error;

/// Settings of [`FusedTracker`](crate::FusedTracker). No default was chosen for a single recording: the leave-one-out
/// table of the tracker's evaluation shows the result of each clip with settings chosen without it.
///
/// A *size* is the root of the area of the target's box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FusedConfig {
    /// Side of the search window, in sizes; 2.5 to 6, default 4. A wider window covers faster targets at a lower
    /// resolution.
    pub padding: f64,
    /// Support of the correlation filter, in multiples of the target's box; 1 to 2.5, default 1.5. Nothing outside it
    /// is learned, so that the background cannot attract the filter.
    pub mask: f64,
    /// Standard deviation of the desired response, in sizes; 0.02 to 0.5, default 0.1.
    pub response_deviation: f64,
    /// Learning rate of the filter's model per frame; 0.001 to 0.5, default 0.025.
    pub learning_rate: f64,
    /// Learning rate of the colour histograms per count, which is every fourth frame; 0 to 0.5, default 0.02.
    pub colour_rate: f64,
    /// Weight of the target probability relative to the gradients; 0 to 4, default 0.8.
    pub colour_gain: f64,
    /// Weight of the brightness relative to the gradients; 0 to 4, default 1.
    pub brightness_gain: f64,
    /// Step of the scale search, a factor above 1; 1.005 to 1.1, default 1.02.
    pub scale_step: f64,
    /// Step of the rotation search, degrees; 1 to 15, default 4.
    pub turn_step_deg: f64,
    /// Factor on the response at another scale or rotation before it is compared with the present one; 0.9 to 1,
    /// default 0.99.
    pub change_gain: f64,
    /// Minimum evidence of a visible target; 5 to 30, default 9. Evidence is the peak-to-sidelobe ratio of the
    /// response, corrected by the colour and by the height of the peak.
    pub seen: f64,
    /// Minimum evidence of a frame that filter and histograms learn from; 5 to 40, default 11.
    pub learn: f64,
    /// Minimum evidence of a candidate for a lost target; 5 to 40, default 10.5.
    pub again: f64,
    /// Weight of the colour in the evidence: evidence per unit of relative contrast; 0 to 20, default 6.
    pub colour_evidence: f64,
    /// Number of consecutive frames in which a re-detected target must be confirmed; 0 to 20, default 3.
    pub confirm: u32,
    /// Maximum duration of coasting, seconds; 0 to 2, default 0.4.
    pub coast_s: f64,
    /// Root of the spectral density of the target's acceleration, in sizes per second squared and root of Hz; 0.1 to
    /// 100, default 4.
    pub agility: f64,
}

impl Default for FusedConfig {
    fn default() -> Self {
        Self {
            padding: 4.0,
            mask: 1.5,
            response_deviation: 0.1,
            learning_rate: 0.025,
            colour_rate: 0.02,
            colour_gain: 0.8,
            brightness_gain: 1.0,
            scale_step: 1.02,
            turn_step_deg: 4.0,
            change_gain: 0.99,
            seen: 9.0,
            learn: 11.0,
            again: 10.5,
            colour_evidence: 6.0,
            confirm: 3,
            coast_s: 0.4,
            agility: 4.0,
        }
    }
}

impl FusedConfig {
    /// Returns the same settings if all are in range.
    ///
    /// # Errors
    /// Names the first setting that is out of range, its value and the range.
    pub fn validated(self) -> Result<Self, FusedConfigError> {
        let ranges = [
            ("padding", self.padding, 2.5, 6.0),
            ("mask", self.mask, 1.0, 2.5),
            ("response_deviation", self.response_deviation, 0.02, 0.5),
            ("learning_rate", self.learning_rate, 0.001, 0.5),
            ("colour_rate", self.colour_rate, 0.0, 0.5),
            ("colour_gain", self.colour_gain, 0.0, 4.0),
            ("brightness_gain", self.brightness_gain, 0.0, 4.0),
            ("scale_step", self.scale_step, 1.005, 1.1),
            ("turn_step_deg", self.turn_step_deg, 1.0, 15.0),
            ("change_gain", self.change_gain, 0.9, 1.0),
            ("seen", self.seen, 5.0, 30.0),
            ("learn", self.learn, 5.0, 40.0),
            ("again", self.again, 5.0, 40.0),
            ("colour_evidence", self.colour_evidence, 0.0, 20.0),
            ("confirm", f64::from(self.confirm), 0.0, 20.0),
            ("coast_s", self.coast_s, 0.0, 2.0),
            ("agility", self.agility, 0.1, 100.0),
        ];
        for (name, value, min, max) in ranges {
            // Also refuses NaN.
            if !(value >= min && value <= max) {
                return Err(FusedConfigError { name, value, min, max });
            }
        }
        Ok(self)
    }
}

/// A setting that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{name} = {value}: use {min} to {max}")]
pub struct FusedConfigError {
    /// Name of the setting.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Minimum, inclusive.
    pub min: f64,
    /// Maximum, inclusive.
    pub max: f64,
}
