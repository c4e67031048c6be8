//! The choice of a camera law on the command line, in a configuration and in the settings of a campaign.

use anyhow::{Result, bail};
use barrelman_control::LawSettings;
use barrelman_control::optimal::OptimalSettings;
use barrelman_vocab::{Framed, LawId, LawName, Named, OptimalMode};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::{Deserialize, Serialize};

/// A camera law with the settings of the optimal law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawChoice {
    /// The law.
    pub law: LawId,
    /// The optimal law's horizon, seconds; `None` for the mode's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
    /// What the optimal law shows.
    #[serde(default, skip_serializing_if = "is_boat")]
    pub framed: Framed,
}

/// What a command line or a configuration says about the law; what it leaves open is a default's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GivenLaw {
    /// The law.
    pub name: Option<LawName>,
    /// The optimal law's mode.
    pub mode: Option<OptimalMode>,
    /// The optimal law's horizon, seconds.
    pub horizon_s: Option<f64>,
    /// What the optimal law shows.
    pub framed: Option<Framed>,
}

/// What the settings of the optimal law are called where they are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LawKeys {
    mode: &'static str,
    horizon: &'static str,
    framed: &'static str,
}

impl LawKeys {
    /// On the command line.
    pub const OPTIONS: Self = Self { mode: "--mode", horizon: "--horizon", framed: "--frame" };
    /// In a file.
    pub const FILE: Self = Self { mode: "law.mode", horizon: "law.horizon_s", framed: "law.frame" };
}

impl GivenLaw {
    /// The law that is given; what is left open is `base`'s. `keys` names the settings in an error.
    ///
    /// # Errors
    /// A setting of the optimal law for another law, or a horizon out of its range.
    pub fn or(self, base: LawChoice, keys: LawKeys) -> Result<LawChoice> {
        let name = self.name.unwrap_or(base.law.name());
        if name != LawName::Optimal && self.mode.is_some() {
            bail!("{}", for_optimal_alone(keys.mode, name));
        }
        let kept = if name == base.law.name() { base } else { LawChoice::new(name) };
        let law = LawId::new(name, self.mode.or(kept.law.mode()).unwrap_or_default());
        LawChoice {
            law,
            horizon_s: self.horizon_s.or(kept.horizon_s),
            framed: self.framed.unwrap_or(kept.framed),
        }
        .validated(keys)
    }
}

impl LawChoice {
    /// The paper's motor schema: the default of what reproduces the paper's figures.
    pub const MOTOR_SCHEMA: Self = Self::of(LawId::Schema);
    /// The optimal law in its default mode: the default of live runs and drives.
    pub const OPTIMAL: Self = Self::of(LawId::Intermittent);

    /// A law with its own horizon, which shows the boat alone.
    pub const fn of(law: LawId) -> Self {
        Self { law, horizon_s: None, framed: Framed::Boat }
    }

    fn new(name: LawName) -> Self {
        Self::of(LawId::new(name, OptimalMode::default()))
    }

    /// The choice, if its horizon is in its range and the law has these settings.
    ///
    /// # Errors
    /// A setting of the optimal law for another law, or a horizon out of its range.
    pub fn validated(self, keys: LawKeys) -> Result<Self> {
        if self.horizon_s.is_some() && self.law.name() != LawName::Optimal {
            bail!("{}", for_optimal_alone(keys.horizon, self.law.name()));
        }
        if self.framed != Framed::Boat && self.law.name() != LawName::Optimal {
            bail!("{}", for_optimal_alone(keys.framed, self.law.name()));
        }
        let range = OptimalSettings::HORIZONS_S;
        if let Some(horizon) = self.horizon_s.filter(|horizon| !range.contains(horizon)) {
            bail!("{} = {horizon}: use seconds from {} to {}", keys.horizon, range.start(), range.end());
        }
        Ok(self)
    }

    /// The law's settings.
    pub fn settings(&self) -> LawSettings {
        match LawSettings::new(self.law) {
            LawSettings::Optimal(optimal) => LawSettings::Optimal(OptimalSettings {
                horizon_s: self.horizon_s,
                framed: self.framed,
                ..optimal
            }),
            other => other,
        }
    }
}

fn is_boat(framed: &Framed) -> bool {
    *framed == Framed::Boat
}

fn for_optimal_alone(key: &str, name: LawName) -> String {
    format!(
        "{key} is for the law \"optimal\" alone: leave it out, or choose that law instead of {:?}",
        name.key()
    )
}

/// Reads one of a closed list of names on the command line; the help lists them with their words.
pub fn named_values<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|name| PossibleValue::new(name.key()).help(name.text()));
    PossibleValuesParser::new(values)
        .try_map(|key| T::ALL.iter().copied().find(|name| name.key() == key).ok_or("no such name"))
}
