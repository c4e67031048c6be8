//! The section `[tracker]` of a configuration file.

use barrelman_vision::{CamShiftConfig, FusedConfig};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};

/// The tracker.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrackerSection {
    /// The tracker's name; default: `fused`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<TrackerName>,
    /// CamShift: lowest saturation at which a pixel's hue is used, 0 to 255.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saturation_floor: Option<u8>,
    /// CamShift: lowest value (brightness) at which a pixel's hue is used, 0 to 255.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value_floor: Option<u8>,
    /// The fused tracker.
    pub fused: FusedSection,
}

/// The fused tracker.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FusedSection {
    /// How long an unseen target is predicted before it counts as lost, seconds, 0 to 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coast_s: Option<f64>,
    /// Consecutive frames in which a re-detected target must be seen before it is accepted, 0 to 20.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confirm: Option<u32>,
    /// Side of the search window, in roots of the target's area, 2.5 to 6. A wider window finds faster targets at a lower
    /// resolution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub padding: Option<f64>,
    /// Root of the spectral density of the target's acceleration, in roots of its area per second squared and root of Hz,
    /// 0.1 to 100.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agility: Option<f64>,
    /// Learning rate of the correlation filter per frame, 0.001 to 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning_rate: Option<f64>,
    /// Learning rate of the colour histograms per count, which is every fourth frame, 0 to 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour_rate: Option<f64>,
    /// Weight of the target probability relative to the gradients, 0 to 4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour_gain: Option<f64>,
    /// Weight of the brightness relative to the gradients, 0 to 4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub brightness_gain: Option<f64>,
    /// Support of the correlation filter, in multiples of the target's box, 1 to 2.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<f64>,
    /// Standard deviation of the filter's desired response, in roots of the target's area, 0.02 to 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub response_deviation: Option<f64>,
    /// Step of the scale search, a factor, 1.005 to 1.1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale_step: Option<f64>,
    /// Step of the rotation search, degrees, 1 to 15.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn_step_deg: Option<f64>,
    /// Factor on the response at another scale or rotation before the responses are compared, 0.9 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change_gain: Option<f64>,
    /// Lowest evidence of a visible target, 5 to 30.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seen: Option<f64>,
    /// Lowest evidence of a frame that the tracker learns from, 5 to 40.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learn: Option<f64>,
    /// Lowest evidence of a candidate for a lost target, 5 to 40.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub again: Option<f64>,
    /// Evidence that matching colour adds and other colour subtracts, 0 to 20.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour_evidence: Option<f64>,
}

impl TrackerSection {
    /// The settings, with defaults for omitted keys; ranges are not checked.
    pub(super) fn settings(&self) -> TrackerSettings {
        let camshift = CamShiftConfig::default();
        TrackerSettings {
            name: self.name.unwrap_or_default(),
            fused: self.fused.settings(),
            camshift: CamShiftConfig {
                saturation_floor: self.saturation_floor.unwrap_or(camshift.saturation_floor),
                value_floor: self.value_floor.unwrap_or(camshift.value_floor),
                ..camshift
            },
        }
    }

    /// The complete section.
    pub(super) fn from_settings(settings: &TrackerSettings) -> Self {
        Self {
            name: Some(settings.name),
            saturation_floor: Some(settings.camshift.saturation_floor),
            value_floor: Some(settings.camshift.value_floor),
            fused: FusedSection::from_settings(&settings.fused),
        }
    }
}

impl FusedSection {
    fn settings(&self) -> FusedConfig {
        let defaults = FusedConfig::default();
        FusedConfig {
            coast_s: self.coast_s.unwrap_or(defaults.coast_s),
            confirm: self.confirm.unwrap_or(defaults.confirm),
            padding: self.padding.unwrap_or(defaults.padding),
            agility: self.agility.unwrap_or(defaults.agility),
            learning_rate: self.learning_rate.unwrap_or(defaults.learning_rate),
            colour_rate: self.colour_rate.unwrap_or(defaults.colour_rate),
            colour_gain: self.colour_gain.unwrap_or(defaults.colour_gain),
            brightness_gain: self.brightness_gain.unwrap_or(defaults.brightness_gain),
            mask: self.mask.unwrap_or(defaults.mask),
            response_deviation: self.response_deviation.unwrap_or(defaults.response_deviation),
            scale_step: self.scale_step.unwrap_or(defaults.scale_step),
            turn_step_deg: self.turn_step_deg.unwrap_or(defaults.turn_step_deg),
            change_gain: self.change_gain.unwrap_or(defaults.change_gain),
            seen: self.seen.unwrap_or(defaults.seen),
            learn: self.learn.unwrap_or(defaults.learn),
            again: self.again.unwrap_or(defaults.again),
            colour_evidence: self.colour_evidence.unwrap_or(defaults.colour_evidence),
        }
    }

    fn from_settings(settings: &FusedConfig) -> Self {
        Self {
            coast_s: Some(settings.coast_s),
            confirm: Some(settings.confirm),
            padding: Some(settings.padding),
            agility: Some(settings.agility),
            learning_rate: Some(settings.learning_rate),
            colour_rate: Some(settings.colour_rate),
            colour_gain: Some(settings.colour_gain),
            brightness_gain: Some(settings.brightness_gain),
            mask: Some(settings.mask),
            response_deviation: Some(settings.response_deviation),
            scale_step: Some(settings.scale_step),
            turn_step_deg: Some(settings.turn_step_deg),
            change_gain: Some(settings.change_gain),
            seen: Some(settings.seen),
            learn: Some(settings.learn),
            again: Some(settings.again),
            colour_evidence: Some(settings.colour_evidence),
        }
    }
}
