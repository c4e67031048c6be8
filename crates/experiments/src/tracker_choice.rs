//! The choice of a tracker and its settings. All trackers of the program are made here.

use anyhow::{Result, anyhow};
use barrelman_vision::{CamShift, CamShiftConfig, FusedConfig, FusedTracker, Tracker};
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
    /// The name on the command line and in a configuration.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Fused => "fused",
            Self::Camshift => "camshift",
        }
    }
}

/// The selected tracker, and the settings of all trackers, so that a change of the selection loses no
/// setting.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrackerSettings {
    /// The selected tracker.
    pub name: TrackerName,
    /// Settings of the fused tracker.
    pub fused: FusedConfig,
    /// Settings of CamShift.
    pub camshift: CamShiftConfig,
}

impl TrackerSettings {
    /// A tracker with default settings.
    pub fn new(name: TrackerName) -> Self {
        Self { name, ..Self::default() }
    }

    /// The settings, if each lies in its range, also those of the trackers that are not selected.
    ///
    /// # Errors
    /// A setting out of its range; the message names its key, its value and the range.
    pub fn validated(self) -> Result<Self> {
        let fused = self.fused.validated().map_err(|error| anyhow!("tracker.fused.{error}"))?;
        let camshift = self.camshift.validated().map_err(|error| anyhow!("tracker.{error}"))?;
        Ok(Self { fused, camshift, ..self })
    }

    /// Makes the selected tracker, without a selected target.
    ///
    /// # Errors
    /// A setting of the tracker lies outside its range.
    pub fn build(&self) -> Result<Box<dyn Tracker>> {
        Ok(match self.name {
            TrackerName::Fused => Box::new(FusedTracker::new(self.fused)?),
            TrackerName::Camshift => Box::new(CamShift::new(self.camshift)?),
        })
    }
}
