//! Settings that are chosen by measuring, and the values worth trying: for `--set` and `--leave-one-out`.

use anyhow::{Context, Result, bail};

use super::under_test::{self, Config};

/// One setting.
pub(crate) struct Candidate {
    /// The setting's name.
    pub(crate) name: &'static str,
    /// What is tried.
    pub(crate) values: &'static [f64],
    /// Sets it.
    pub(crate) set: fn(&mut Config, f64),
}

/// The settings that are chosen, those with most effect first.
pub(crate) const CANDIDATES: &[Candidate] = &[
    Candidate {
        name: "learning_rate",
        values: &[0.015, 0.025, 0.035],
        set: |config, value| config.learning_rate = value,
    },
    Candidate { name: "seen", values: &[8.0, 9.0, 10.0], set: |config, value| config.seen = value },
    Candidate { name: "learn", values: &[10.0, 11.0, 13.0], set: |config, value| config.learn = value },
    Candidate { name: "again", values: &[9.5, 10.5, 12.0], set: |config, value| config.again = value },
    Candidate {
        name: "colour_evidence",
        values: &[4.0, 6.0, 8.0],
        set: |config, value| config.colour_evidence = value,
    },
    Candidate {
        name: "colour_gain",
        values: &[0.5, 0.8, 1.2],
        set: |config, value| config.colour_gain = value,
    },
    Candidate {
        name: "brightness_gain",
        values: &[0.5, 1.0, 1.5],
        set: |config, value| config.brightness_gain = value,
    },
    Candidate { name: "mask", values: &[1.3, 1.5, 1.7], set: |config, value| config.mask = value },
    Candidate { name: "padding", values: &[3.5, 4.0, 4.5], set: |config, value| config.padding = value },
    Candidate {
        name: "change_gain",
        values: &[0.985, 0.99, 0.995],
        set: |config, value| config.change_gain = value,
    },
];

/// The default settings with these changes, each NAME=VALUE.
///
/// # Errors
/// If there is no such setting, the value is no number, or the tracker refuses the settings.
pub(crate) fn changed(changes: &[String]) -> Result<Config> {
    let mut config = Config::default();
    for change in changes {
        let (name, value) = change.split_once('=').with_context(|| format!("{change}: write NAME=VALUE"))?;
        let Some(candidate) = CANDIDATES.iter().find(|candidate| candidate.name == name) else {
            let known: Vec<&str> = CANDIDATES.iter().map(|candidate| candidate.name).collect();
            bail!("there is no setting {name} to change; there are {}", known.join(", "));
        };
        (candidate.set)(&mut config, value.parse().with_context(|| format!("{change}: no number"))?);
    }
    under_test::make(&config)?;
    Ok(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_that_is_tried_is_accepted() {
        for candidate in CANDIDATES {
            for value in candidate.values {
                let change = format!("{}={value}", candidate.name);
                assert!(changed(std::slice::from_ref(&change)).is_ok(), "{change}");
            }
        }
    }

    #[test]
    fn names_differ() {
        let names: std::collections::BTreeSet<&str> =
            CANDIDATES.iter().map(|candidate| candidate.name).collect();
        assert_eq!(names.len(), CANDIDATES.len());
    }

    #[test]
    fn what_is_no_change_is_refused() {
        for change in ["", "nothing=1", "nothing"] {
            assert!(changed(&[change.to_owned()]).is_err(), "{change}");
        }
    }
}
