//! The options `--law`, `--mode` and `--horizon`, which several commands share.

use anyhow::Result;
use barrelman_experiments::law_choice::{LawChoice, LawName, ModeName};
use clap::Args;

use super::wrong_use::WrongUse;

/// The law's options of a command.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct LawOptions {
    /// The camera law. Without it: optimal in `run` (or the configuration's) and `demo`; schema in `trials`, `law` and
    /// `demo --clip`; in `trials --drive` the drive's own.
    #[arg(long, value_enum)]
    pub law: Option<LawName>,
    /// What the optimal law spares; without it minimum-energy.
    #[arg(long, value_enum)]
    pub mode: Option<ModeName>,
    /// Within what time the optimal law brings the target back, seconds, 0.5 to 5: short is tight, long is lazy. Without
    /// it the mode's own.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub horizon: Option<f64>,
}

impl LawOptions {
    /// The choice that they make, where without them it would be `base`.
    ///
    /// # Errors
    /// If they contradict each other, or the horizon is out of its range.
    pub fn over(self, base: LawChoice) -> Result<LawChoice> {
        let base = self.law.filter(|name| *name != base.name).map_or(base, LawChoice::of);
        LawChoice { mode: self.mode.or(base.mode), horizon_s: self.horizon.or(base.horizon_s), ..base }
            .validated("--")
            .map_err(|error| WrongUse(error.to_string()).into())
    }
}

impl From<LawChoice> for LawOptions {
    fn from(choice: LawChoice) -> Self {
        Self { law: Some(choice.name), mode: choice.mode, horizon: choice.horizon_s }
    }
}
