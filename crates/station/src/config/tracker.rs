//! The section `[tracker]` of a configuration file.

use barrelman_vision::{CamShiftConfig, FusedConfig};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};

/// The tracker.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrackerSection {
    /// The tracker's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<TrackerName>,
    /// CamShift: lowest saturation at which a pixel's hue is used.
    #[schemars(range(min = 0, max = 255))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saturation_floor: Option<u8>,
    /// CamShift: lowest value (brightness) at which a pixel's hue is used.
    #[schemars(range(min = 0, max = 255))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value_floor: Option<u8>,
    /// The fused tracker.
    pub fused: FusedSection,
}

/// Defines [`FusedSection`] from its keys in the order of the file. Each key is a setting of [`FusedConfig`]
/// with the words of the JSON schema; the compiler reports a setting without a key.
macro_rules! fused_section {
    ($($(#[$doc:meta])* $key:ident: $type:ty,)*) => {
        /// The fused tracker.
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct FusedSection {
            $(
                $(#[$doc])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $key: Option<$type>,
            )*
        }

        impl FusedSection {
            fn settings(&self) -> FusedConfig {
                let defaults = FusedConfig::default();
                FusedConfig { $($key: self.$key.unwrap_or(defaults.$key),)* }
            }

            fn from_settings(settings: &FusedConfig) -> Self {
                Self { $($key: Some(settings.$key),)* }
            }
        }
    };
}

fused_section! {
    /// How long an unseen target is predicted before it counts as lost, seconds.
    coast_s: f64,
    /// Consecutive frames in which a re-detected target must be seen before it is accepted.
    confirm: u32,
    /// Side of the search window, in roots of the target's area. A wider window finds faster targets at a
    /// lower resolution.
    padding: f64,
    /// Root of the spectral density of the target's acceleration, in roots of its area per second squared and
    /// root of Hz.
    agility: f64,
    /// Learning rate of the correlation filter per frame.
    learning_rate: f64,
    /// Learning rate of the colour histograms per count, which is every fourth frame.
    colour_rate: f64,
    /// Weight of the target probability relative to the gradients.
    colour_gain: f64,
    /// Weight of the brightness relative to the gradients.
    brightness_gain: f64,
    /// Support of the correlation filter, in multiples of the target's box.
    mask: f64,
    /// Standard deviation of the filter's desired response, in roots of the target's area.
    response_deviation: f64,
    /// Step of the scale search, a factor.
    scale_step: f64,
    /// Step of the rotation search, degrees.
    turn_step_deg: f64,
    /// Factor on the response at another scale or rotation before the responses are compared.
    change_gain: f64,
    /// Lowest evidence of a visible target.
    seen: f64,
    /// Lowest evidence of a frame that the tracker learns from.
    learn: f64,
    /// Lowest evidence of a candidate for a lost target.
    again: f64,
    /// Evidence that matching colour adds and other colour subtracts.
    colour_evidence: f64,
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
