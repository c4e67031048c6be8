//! The tracker's settings that are tuned on clips, and the values that are tried: for `--set` and
//! `--leave-one-out`.

use anyhow::{Context, Result, bail};

use super::tracker_under_test::{TrackerConfig, build_tracker};

/// A setting of [`TrackerConfig`] that is tuned.
pub(crate) struct TunedSetting {
    /// The name for `--set` and in the table.
    pub(crate) name: &'static str,
    /// The values that are tried beside the default.
    pub(crate) values: &'static [f64],
}

/// The tuned settings, those with most effect first.
pub(crate) const TUNED_SETTINGS: &[TunedSetting] = &[
    TunedSetting { name: "learning_rate", values: &[0.015, 0.025, 0.035] },
    TunedSetting { name: "seen", values: &[8.0, 9.0, 10.0] },
    TunedSetting { name: "learn", values: &[10.0, 11.0, 13.0] },
    TunedSetting { name: "again", values: &[9.5, 10.5, 12.0] },
    TunedSetting { name: "colour_evidence", values: &[4.0, 6.0, 8.0] },
    TunedSetting { name: "colour_gain", values: &[0.5, 0.8, 1.2] },
    TunedSetting { name: "brightness_gain", values: &[0.5, 1.0, 1.5] },
    TunedSetting { name: "mask", values: &[1.3, 1.5, 1.7] },
    TunedSetting { name: "padding", values: &[3.5, 4.0, 4.5] },
    TunedSetting { name: "change_gain", values: &[0.985, 0.99, 0.995] },
];

impl TunedSetting {
    /// Changes the setting.
    pub(crate) fn set(&self, config: &mut TrackerConfig, value: f64) {
        let setting = TrackerConfig::SETTINGS.iter().find(|setting| setting.name == self.name);
        (setting.expect("a tuned setting is a setting of the tracker").set)(config, value);
    }
}

/// The default settings with these changes, each NAME=VALUE.
///
/// # Errors
/// If there is no setting of that name, the value is not a number, or the tracker refuses the settings.
pub(crate) fn config_with_changes(changes: &[String]) -> Result<TrackerConfig> {
    let mut config = TrackerConfig::default();
    for change in changes {
        let (name, value) = change.split_once('=').with_context(|| format!("{change}: write NAME=VALUE"))?;
        let Some(setting) = TUNED_SETTINGS.iter().find(|setting| setting.name == name) else {
            let known: Vec<&str> = TUNED_SETTINGS.iter().map(|setting| setting.name).collect();
            bail!("unknown setting {name}; known are {}", known.join(", "));
        };
        let value = value.parse().with_context(|| format!("{change}: {value} is not a number"))?;
        setting.set(&mut config, value);
    }
    build_tracker(&config)?;
    Ok(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_that_is_tried_is_accepted() {
        for setting in TUNED_SETTINGS {
            for value in setting.values {
                let change = format!("{}={value}", setting.name);
                assert!(config_with_changes(std::slice::from_ref(&change)).is_ok(), "{change}");
            }
        }
    }

    #[test]
    fn names_differ() {
        let names: std::collections::BTreeSet<&str> =
            TUNED_SETTINGS.iter().map(|setting| setting.name).collect();
        assert_eq!(names.len(), TUNED_SETTINGS.len());
    }

    #[test]
    fn what_is_no_change_is_refused() {
        for change in ["", "nothing=1", "nothing"] {
            assert!(config_with_changes(&[change.to_owned()]).is_err(), "{change}");
        }
    }
}
