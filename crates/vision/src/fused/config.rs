//! Settings of the fused tracker. The list below states each setting once; documentation, default and check
//! follow from the list.

use thiserror::Error;

/// Defines a struct of settings, its defaults and its table `SETTINGS` from a list of settings, each with its
/// documentation, name, type, default and range.
macro_rules! settings {
    (
        $(#[$config_doc:meta])*
        pub struct $config:ident {
            $($(#[$doc:meta])* $name:ident: $type:ty = $default:literal, $min:literal to $max:literal;)*
        }
    ) => {
        $(#[$config_doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $config {
            $(
                $(#[$doc])*
                #[doc = concat!(
                    "\n\nFrom ", stringify!($min), " to ", stringify!($max), "; default: ", stringify!($default), "."
                )]
                pub $name: $type,
            )*
        }

        impl Default for $config {
            fn default() -> Self {
                Self { $($name: $default,)* }
            }
        }

        impl $config {
            /// All settings, in the order in which they are checked.
            pub const SETTINGS: &'static [FusedSetting] = &[$(
                FusedSetting {
                    name: stringify!($name),
                    min: $min,
                    max: $max,
                    get: |config| f64::from(config.$name),
                    set: |config, value| config.$name = value as $type,
                },
            )*];
        }
    };
}

settings! {
    /// Settings of [`FusedTracker`](crate::FusedTracker). No default was chosen for a single recording: the
    /// leave-one-out table of the tracker's evaluation shows the result of each clip with settings chosen
    /// without it.
    ///
    /// A *size* is the root of the area of the target's box.
    pub struct FusedConfig {
        /// Side of the search window, in sizes. A wider window covers faster targets at a lower resolution.
        padding: f64 = 4.0, 2.5 to 6.0;
        /// Support of the correlation filter, in multiples of the target's box. Nothing outside it is
        /// learned, so that the background cannot attract the filter.
        mask: f64 = 1.5, 1.0 to 2.5;
        /// Standard deviation of the desired response, in sizes.
        response_deviation: f64 = 0.1, 0.02 to 0.5;
        /// Learning rate of the filter's model per frame.
        learning_rate: f64 = 0.025, 0.001 to 0.5;
        /// Learning rate of the colour histograms per count, which is every fourth frame.
        colour_rate: f64 = 0.02, 0.0 to 0.5;
        /// Weight of the target probability relative to the gradients.
        colour_gain: f64 = 0.8, 0.0 to 4.0;
        /// Weight of the brightness relative to the gradients.
        brightness_gain: f64 = 1.0, 0.0 to 4.0;
        /// Step of the scale search, a factor above 1.
        scale_step: f64 = 1.02, 1.005 to 1.1;
        /// Step of the rotation search, degrees.
        turn_step_deg: f64 = 4.0, 1.0 to 15.0;
        /// Factor on the response at another scale or rotation before it is compared with the present one.
        change_gain: f64 = 0.99, 0.9 to 1.0;
        /// Minimum evidence of a visible target. Evidence is the peak-to-sidelobe ratio of the response,
        /// corrected by the colour and by the height of the peak.
        seen: f64 = 9.0, 5.0 to 30.0;
        /// Minimum evidence of a frame that filter and histograms learn from.
        learn: f64 = 11.0, 5.0 to 40.0;
        /// Minimum evidence of a candidate for a lost target.
        again: f64 = 10.5, 5.0 to 40.0;
        /// Weight of the colour in the evidence: evidence per unit of relative contrast.
        colour_evidence: f64 = 6.0, 0.0 to 20.0;
        /// Number of consecutive frames in which a re-detected target must be confirmed.
        confirm: u32 = 3, 0.0 to 20.0;
        /// Maximum duration of coasting, seconds.
        coast_s: f64 = 0.4, 0.0 to 2.0;
        /// Root of the spectral density of the target's acceleration, in sizes per second squared and root of
        /// Hz.
        agility: f64 = 4.0, 0.1 to 100.0;
    }
}

impl FusedConfig {
    /// Returns the same settings if all are in range.
    ///
    /// # Errors
    /// Names the first setting that is out of range, its value and the range.
    pub fn validated(self) -> Result<Self, FusedConfigError> {
        for &FusedSetting { name, min, max, get, .. } in Self::SETTINGS {
            let value = get(&self);
            // Also refuses NaN.
            if !(value >= min && value <= max) {
                return Err(FusedConfigError { name, value, min, max });
            }
        }
        Ok(self)
    }
}

/// A setting of the fused tracker: its name, range and field.
#[derive(Debug, Clone, Copy)]
pub struct FusedSetting {
    /// Name of the setting.
    pub name: &'static str,
    /// Minimum, inclusive.
    pub min: f64,
    /// Maximum, inclusive.
    pub max: f64,
    /// Reads the setting.
    pub get: fn(&FusedConfig) -> f64,
    /// Changes the setting, without a check of the range; a setting that is a whole number drops the
    /// fraction.
    pub set: fn(&mut FusedConfig, f64),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_takes_the_bounds_of_its_range_and_nothing_beyond() {
        for FusedSetting { name, min, max, get, set } in FusedConfig::SETTINGS {
            let mut config = FusedConfig::default();
            for bound in [min, max] {
                set(&mut config, *bound);
                assert_eq!(get(&config), *bound, "{name}");
                assert_eq!(config.validated(), Ok(config), "{name} = {bound}");
            }
            set(&mut config, max + 1.0);
            assert_eq!(config.validated().map_err(|error| error.name), Err(*name));
        }
    }
}
