//! The settings of the fused tracker.

use thiserror::Error;

/// Settings of [`FusedTracker`](crate::FusedTracker). None of them was chosen for one recording: the table that
/// `xtask acceptance tracker --leave-one-out` prints says what each clip would get from settings chosen without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FusedConfig {
    /// Side of the search window, in roots of the target's area; 2.5 to 6, default 4. Wider finds faster targets and
    /// sees them coarser.
    pub padding: f64,
    /// How far around the target's box the correlation filter may reach, in sizes of the box; 1 to 2.5, default 1.5.
    /// What is outside is not learned, so that the background cannot carry the filter away.
    pub mask: f64,
    /// Deviation of the wanted response, in roots of the target's area; 0.02 to 0.5, default 0.1.
    pub response_deviation: f64,
    /// Share by which a frame enters the filter's model; 0.001 to 0.5, default 0.025.
    pub learning_rate: f64,
    /// Share by which a look at the colours (every fourth frame) enters the histograms; 0 to 0.5, default 0.02.
    pub colour_rate: f64,
    /// Weight of the colour's likeness beside the gradients; 0 to 4, default 0.8.
    pub colour_gain: f64,
    /// Weight of the brightness beside the gradients; 0 to 4, default 1.
    pub brightness_gain: f64,
    /// Steps in which sizes are tried, a factor above 1; 1.005 to 1.1, default 1.02.
    pub scale_step: f64,
    /// Steps in which turns are tried, degrees; 1 to 15, default 4.
    pub turn_step_deg: f64,
    /// What another size or turn must be better by: its response counts that much; 0.9 to 1, default 0.99.
    pub change_gain: f64,
    /// Evidence from which on the target counts as seen; 5 to 30, default 9. Evidence counts in deviations of the
    /// response's sidelobes, moved by what the colour says.
    pub seen: f64,
    /// Evidence from which on the filter and the histograms learn; 5 to 40, default 11.
    pub learn: f64,
    /// Evidence from which on a lost target counts as perhaps found again; 5 to 40, default 10.5.
    pub again: f64,
    /// Evidence that the right colour adds and a wrong one takes away; 0 to 20, default 6.
    pub colour_evidence: f64,
    /// Frames in a row that a target found again must be seen in before it is believed; 0 to 20, default 3.
    pub confirm: u32,
    /// How long a track is carried on by prediction alone, seconds; 0 to 2, default 0.4.
    pub coast_s: f64,
    /// How much targets speed up and turn, in roots of their area per second squared and root of Hz; 0.1 to 100,
    /// default 4.
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
    /// The same settings, if every one lies in its range.
    ///
    /// # Errors
    /// Names the first setting that does not, its value and the range.
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
        for (name, value, least, most) in ranges {
            // Written so that what is not a number is refused, too.
            if !(value >= least && value <= most) {
                return Err(FusedConfigError { name, value, least, most });
            }
        }
        Ok(self)
    }
}

/// A setting outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{name} = {value}: use {least} to {most}")]
pub struct FusedConfigError {
    /// Which setting.
    pub name: &'static str,
    /// What it was set to.
    pub value: f64,
    /// The least that it may be.
    pub least: f64,
    /// The most that it may be.
    pub most: f64,
}
