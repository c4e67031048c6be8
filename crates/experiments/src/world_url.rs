//! The address of a simulated world: `sim:arena1`, `sim:mine.toml?seed=7&size=640x360`.

use std::fmt;

use barrelman_vocab::PictureSize;

/// A simulated world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorldUrl {
    /// The name of a built-in scenario, or the path of a scenario file, which ends in `.toml`.
    pub scenario: String,
    /// The seed of all random numbers of the world.
    pub seed: u64,
    /// Size of the picture, which shows the same view; `None` for the scenario's size.
    pub size: Option<PictureSize>,
}

/// An invalid address of a simulated world.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WorldUrlError {
    /// The address names no scenario.
    #[error("`sim:` names no scenario: write e.g. sim:arena1 (`barrelman scenarios` lists them)")]
    NoScenario,
    /// An option is unknown, or its value is invalid.
    #[error(
        "the simulated world's option {0:?} cannot be used: write e.g. seed=7, size=640x360 or fault=stall@12.5"
    )]
    Option(String),
}

impl WorldUrl {
    /// The world of a scenario with seed 1.
    pub fn new(scenario: impl Into<String>) -> Self {
        Self { scenario: scenario.into(), seed: 1, size: None }
    }

    /// Reads the part of an address after `sim:`. Returns the text of the option `fault` unread.
    ///
    /// # Errors
    /// An address without a scenario, or an invalid option.
    pub fn parse(text: &str) -> Result<(Self, Option<String>), WorldUrlError> {
        let (scenario, options) = text.split_once('?').unwrap_or((text, ""));
        if scenario.is_empty() {
            return Err(WorldUrlError::NoScenario);
        }
        let (mut url, mut faults) = (Self::new(scenario), None);
        for option in options.split('&').filter(|option| !option.is_empty()) {
            let invalid = || WorldUrlError::Option(option.to_owned());
            match option.split_once('=') {
                Some(("seed", seed)) => url.seed = seed.parse().map_err(|_| invalid())?,
                Some(("size", size)) => url.size = Some(parse_size(size).ok_or_else(invalid)?),
                Some(("fault", plan)) => faults = Some(plan.to_owned()),
                _ => return Err(invalid()),
            }
        }
        Ok((url, faults))
    }
}

fn parse_size(text: &str) -> Option<PictureSize> {
    let (width, height) = text.split_once('x')?;
    Some(PictureSize::new(width.parse().ok()?, height.parse().ok()?))
}

impl fmt::Display for WorldUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sim:{}?seed={}", self.scenario, self.seed)?;
        match self.size {
            Some(size) => write!(f, "&size={}x{}", size.width, size.height),
            None => Ok(()),
        }
    }
}
