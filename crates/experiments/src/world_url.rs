//! Which world is simulated, as the user writes it: `sim:arena1`, `sim:mine.toml?seed=7&size=640x360`.

use std::fmt;

use barrelman_vocab::PictureSize;

/// A simulated world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorldUrl {
    /// The scenario: a built-in one's name, or the path of a file that ends in `.toml`.
    pub scenario: String,
    /// Everything that is left to chance comes from this.
    pub seed: u64,
    /// Size of the picture; the view stays the same. `None`: the scenario's.
    pub size: Option<PictureSize>,
}

/// A simulated world's address that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WorldUrlError {
    /// No scenario is named.
    #[error("`sim:` names no scenario: write e.g. sim:arena1 (`barrelman scenarios` lists them)")]
    Nothing,
    /// An option is unknown or has no value that can be used.
    #[error(
        "the simulated world's option {0:?} cannot be used: write e.g. seed=7, size=640x360 or fault=stall@12.5"
    )]
    Option(String),
}

impl WorldUrl {
    /// A scenario's world with the first seed.
    pub fn of(scenario: impl Into<String>) -> Self {
        Self { scenario: scenario.into(), seed: 1, size: None }
    }

    /// Reads what stands behind `sim:`; the faults come back as they were written.
    ///
    /// # Errors
    /// [`WorldUrlError`] says what cannot be read.
    pub fn parse(text: &str) -> Result<(Self, Option<String>), WorldUrlError> {
        let (scenario, options) = text.split_once('?').unwrap_or((text, ""));
        if scenario.is_empty() {
            return Err(WorldUrlError::Nothing);
        }
        let (mut url, mut faults) = (Self::of(scenario), None);
        for option in options.split('&').filter(|option| !option.is_empty()) {
            let unusable = || WorldUrlError::Option(option.to_owned());
            match option.split_once('=') {
                Some(("seed", seed)) => url.seed = seed.parse().map_err(|_| unusable())?,
                Some(("size", size)) => url.size = Some(parse_size(size).ok_or_else(unusable)?),
                Some(("fault", plan)) => faults = Some(plan.to_owned()),
                _ => return Err(unusable()),
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
