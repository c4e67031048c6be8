//! Which tracker follows the boat, with its settings: the one place where a tracker is made.

use anyhow::{Result, anyhow};
use barrelman_vision::{CamShift, CamShiftConfig, FusedConfig, FusedTracker, Tracker, behaviour};
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The trackers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TrackerName {
    /// By what the target looks like and by its colour; says when it is lost, and finds it again.
    #[default]
    Fused,
    /// Hue-histogram back projection and CamShift, as the paper has it.
    Camshift,
}

impl TrackerName {
    /// As it is written on the command line and in a configuration.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Fused => "fused",
            Self::Camshift => "camshift",
        }
    }

    /// The tracker's behaviour version in this program.
    pub const fn behaviour_version(self) -> u32 {
        match self {
            Self::Fused => behaviour::FUSED,
            Self::Camshift => behaviour::CAMSHIFT,
        }
    }
}

/// The tracker that is used, and the settings of each, so that another can be chosen without losing any.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrackerSettings {
    /// The one that is used.
    pub name: TrackerName,
    /// Of the fused tracker.
    pub fused: FusedConfig,
    /// Of CamShift.
    pub camshift: CamShiftConfig,
}

impl TrackerSettings {
    /// The defaults of that tracker.
    pub fn of(name: TrackerName) -> Self {
        Self { name, ..Self::default() }
    }

    /// The same settings, if every one lies in its range, also those of the tracker that is not used.
    ///
    /// # Errors
    /// Names the first key that does not, its value and the range.
    pub fn validated(self) -> Result<Self> {
        let fused = self.fused.validated().map_err(|error| anyhow!("tracker.fused.{error}"))?;
        let camshift = self.camshift.validated().map_err(|error| anyhow!("tracker.{error}"))?;
        Ok(Self { fused, camshift, ..self })
    }

    /// The tracker, with nothing selected.
    ///
    /// # Errors
    /// If a setting of it lies outside its range.
    pub fn tracker(&self) -> Result<Box<dyn Tracker>> {
        Ok(match self.name {
            TrackerName::Fused => Box::new(FusedTracker::new(self.fused)?),
            TrackerName::Camshift => Box::new(CamShift::new(self.camshift)?),
        })
    }
}
