//! The options `--law`, `--mode`, `--horizon` and `--frame`, which several commands share.

use anyhow::Result;
use barrelman_experiments::law_choice::{GivenLaw, LawChoice, LawKeys, named_values};
use barrelman_vocab::{Framed, LawName, OptimalMode};
use clap::Args;

use super::usage_error::UsageError;

/// The options that choose the camera law.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct LawOptions {
    /// The camera law. (Each command's help names its own default.)
    #[arg(long, value_parser = named_values::<LawName>())]
    pub law: Option<LawName>,
    /// What the optimal law saves; default: intermittent.
    #[arg(long, value_parser = named_values::<OptimalMode>())]
    pub mode: Option<OptimalMode>,
    /// Horizon of the optimal law: the time within which it brings the target back, seconds, 0.5 to 5; a
    /// longer horizon moves the camera less. Default: the mode's.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub horizon: Option<f64>,
    /// What the optimal law shows; default: boat.
    #[arg(long, value_parser = named_values::<Framed>())]
    pub frame: Option<Framed>,
}

impl LawOptions {
    /// The law that the options choose; what they leave open is `base`'s.
    ///
    /// # Errors
    /// If the options contradict each other, or the horizon is out of range.
    pub fn resolve(self, base: LawChoice) -> Result<LawChoice> {
        GivenLaw { name: self.law, mode: self.mode, horizon_s: self.horizon, framed: self.frame }
            .or(base, LawKeys::OPTIONS)
            .map_err(|error| UsageError(error.to_string()).into())
    }
}

impl From<LawChoice> for LawOptions {
    fn from(choice: LawChoice) -> Self {
        Self {
            law: Some(choice.law.name()),
            mode: choice.law.mode(),
            horizon: choice.horizon_s,
            frame: Some(choice.framed).filter(|framed| *framed != Framed::Boat),
        }
    }
}
