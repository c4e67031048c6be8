//! The choice of a camera law on the command line, in a configuration and in the settings of a campaign.

use anyhow::{Result, bail};
use barrelman_control::optimal::{OptimalMode, OptimalSettings};
use barrelman_control::{CentringGains, LawSettings};
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The camera laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// The paper's motor schema.
    #[value(name = "schema")]
    #[serde(rename = "schema")]
    MotorSchema,
    /// Both axes at once, by prediction.
    Optimal,
    /// A PID on the picture's centre, to compare with.
    #[value(name = "centre")]
    #[serde(rename = "centre")]
    Centring,
}

/// The cost that the optimal law minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ModeName {
    /// The integral of the squared rate: gentle movements, nearly all the time.
    MinimumEnergy,
    /// The time in motion, too: short movements at a cruising speed.
    TimeFuel,
    /// Rests most: less energy and time in motion than the schema, in about as many movements.
    Eco,
    /// One smooth movement for each excursion, with a rest after it.
    #[default]
    Intermittent,
}

impl ModeName {
    /// The mode's name on the command line and in a configuration.
    pub const fn name_str(self) -> &'static str {
        match self {
            Self::MinimumEnergy => "minimum-energy",
            Self::TimeFuel => "time-fuel",
            Self::Eco => "eco",
            Self::Intermittent => "intermittent",
        }
    }

    /// The mode of the optimal law.
    pub const fn optimal_mode(self) -> OptimalMode {
        match self {
            Self::MinimumEnergy => OptimalMode::MinimumEnergy,
            Self::TimeFuel => OptimalMode::TimeFuel,
            Self::Eco => OptimalMode::Eco,
            Self::Intermittent => OptimalMode::Intermittent,
        }
    }
}

/// A camera law with its mode and its horizon, which only the optimal law has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawChoice {
    /// The law.
    pub name: LawName,
    /// The optimal law's mode; `None` for another law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<ModeName>,
    /// The optimal law's horizon, seconds; `None` for the mode's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
}

impl LawChoice {
    /// The paper's motor schema: the default of what reproduces the paper's figures.
    pub const MOTOR_SCHEMA: Self = Self::new(LawName::MotorSchema);
    /// The optimal law: the default of live runs and drives.
    pub const OPTIMAL: Self = Self::new(LawName::Optimal);

    /// The law with its default mode and horizon.
    pub const fn new(name: LawName) -> Self {
        let mode = match name {
            LawName::Optimal => Some(ModeName::Intermittent),
            LawName::MotorSchema | LawName::Centring => None,
        };
        Self { name, mode, horizon_s: None }
    }

    /// The choice, if its parts fit together; without a mode, the optimal law gets its default mode. `prefix` is put
    /// before the key in an error.
    ///
    /// # Errors
    /// A mode or a horizon for another law than the optimal law, or a horizon out of its range.
    pub fn validated(self, prefix: &str) -> Result<Self> {
        if self.name != LawName::Optimal {
            for (given, key) in [(self.mode.is_some(), "mode"), (self.horizon_s.is_some(), "horizon")] {
                if given {
                    bail!(
                        "{prefix}{key} is for the law \"optimal\" alone: leave it out, or choose that law instead of {:?}",
                        self.name_str()
                    );
                }
            }
        }
        let range = OptimalSettings::HORIZONS_S;
        if let Some(horizon) = self.horizon_s.filter(|horizon| !range.contains(horizon)) {
            bail!("{prefix}horizon {horizon}: use seconds from {} to {}", range.start(), range.end());
        }
        Ok(Self { mode: self.mode.or(Self::new(self.name).mode), ..self })
    }

    /// The law's name on the command line and in a configuration.
    pub const fn name_str(&self) -> &'static str {
        match self.name {
            LawName::MotorSchema => "schema",
            LawName::Optimal => "optimal",
            LawName::Centring => "centre",
        }
    }

    /// The mode's name on the command line and in a configuration; `None` for a law without modes.
    pub fn mode_str(&self) -> Option<&'static str> {
        (self.name == LawName::Optimal).then(|| self.mode.unwrap_or_default().name_str())
    }

    /// The law's settings.
    pub fn settings(&self) -> LawSettings {
        let mode = self.mode.unwrap_or_default().optimal_mode();
        match self.name {
            LawName::MotorSchema => LawSettings::MotorSchema,
            LawName::Optimal => LawSettings::Optimal(OptimalSettings { mode, horizon_s: self.horizon_s }),
            LawName::Centring => LawSettings::Centring(CentringGains::HAND_TUNED),
        }
    }
}
