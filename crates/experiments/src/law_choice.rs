//! The choice of a camera law: on the command line, in a configuration, in a campaign's settings.

use anyhow::{Result, bail};
use barrelman_control::optimal::{OptimalMode, OptimalSettings};
use barrelman_control::{CentringGains, LawSettings, behaviour};
use barrelman_trial::behaviour::BehaviourVersions;
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tracker_choice::TrackerName;

/// The camera laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// The paper's motor schema.
    Schema,
    /// Both axes at once, by prediction, with the least energy.
    Optimal,
    /// A PID on the picture's centre, to compare with.
    Centre,
}

/// What the optimal law spares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ModeName {
    /// The integral of the squared rate: gentle movements.
    #[default]
    MinimumEnergy,
    /// The time in motion, too: short movements at a cruising speed.
    TimeFuel,
    /// Rests most: less energy and time in motion than the schema, in about as many movements.
    Eco,
}

/// A law, and of the optimal one how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawChoice {
    /// Which law.
    pub name: LawName,
    /// What the optimal law spares; `None` where another law is chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<ModeName>,
    /// The optimal law's horizon, seconds; `None`: the mode's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
}

impl LawChoice {
    /// The paper's: the default wherever its figures are reproduced.
    pub const SCHEMA: Self = Self::of(LawName::Schema);
    /// The default wherever a camera follows a boat.
    pub const OPTIMAL: Self = Self::of(LawName::Optimal);

    /// A law as it is by itself.
    pub const fn of(name: LawName) -> Self {
        let mode = match name {
            LawName::Optimal => Some(ModeName::MinimumEnergy),
            LawName::Schema | LawName::Centre => None,
        };
        Self { name, mode, horizon_s: None }
    }

    /// The law's behaviour version in this program.
    pub const fn behaviour_version(&self) -> u32 {
        match self.name {
            LawName::Schema => behaviour::MOTOR_SCHEMA,
            LawName::Optimal => behaviour::OPTIMAL,
            LawName::Centre => behaviour::CENTRE,
        }
    }

    /// The behaviour versions that a file of this program states.
    pub const fn behaviour_with(&self, tracker: TrackerName) -> BehaviourVersions {
        BehaviourVersions { tracker: tracker.behaviour_version(), law: self.behaviour_version() }
    }

    /// Itself, if it makes sense, with the optimal law's default mode where none is given; `prefix` stands before the
    /// names of what is wrong.
    ///
    /// # Errors
    /// If a mode or horizon is given to another law than the optimal one, or the horizon is out of its range.
    pub fn validated(self, prefix: &str) -> Result<Self> {
        if self.name != LawName::Optimal {
            for (given, key) in [(self.mode.is_some(), "mode"), (self.horizon_s.is_some(), "horizon")] {
                if given {
                    bail!(
                        "{prefix}{key} is for the law \"optimal\" alone: leave it out, or choose that law instead of {:?}",
                        self.word()
                    );
                }
            }
        }
        let range = OptimalSettings::HORIZONS_S;
        if let Some(horizon) = self.horizon_s.filter(|horizon| !range.contains(horizon)) {
            bail!("{prefix}horizon {horizon}: use seconds from {} to {}", range.start(), range.end());
        }
        Ok(Self { mode: self.mode.or(Self::of(self.name).mode), ..self })
    }

    /// The law's name as it is written on the command line and in a configuration.
    pub const fn word(&self) -> &'static str {
        match self.name {
            LawName::Schema => "schema",
            LawName::Optimal => "optimal",
            LawName::Centre => "centre",
        }
    }

    /// The mode's name, where the law has modes.
    pub fn mode_word(&self) -> Option<&'static str> {
        (self.name == LawName::Optimal).then(|| match self.mode.unwrap_or_default() {
            ModeName::MinimumEnergy => "minimum-energy",
            ModeName::TimeFuel => "time-fuel",
            ModeName::Eco => "eco",
        })
    }

    /// The law's settings.
    pub fn settings(&self) -> LawSettings {
        let mode = match self.mode.unwrap_or_default() {
            ModeName::MinimumEnergy => OptimalMode::MinimumEnergy,
            ModeName::TimeFuel => OptimalMode::TimeFuel,
            ModeName::Eco => OptimalMode::Eco,
        };
        match self.name {
            LawName::Schema => LawSettings::MotorSchema,
            LawName::Optimal => LawSettings::Optimal(OptimalSettings { mode, horizon_s: self.horizon_s }),
            LawName::Centre => LawSettings::Centring(CentringGains::HAND_TUNED),
        }
    }
}
