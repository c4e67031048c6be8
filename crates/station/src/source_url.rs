//! Addresses of video sources: a video (`rtsp://...`, `file:...`, a path) or a simulated world
//! (`sim:arena1?seed=7&fault=stall@12`).

use std::fmt;

use barrelman_experiments::world_url::{WorldUrl, WorldUrlError};
use barrelman_host::fault::{FaultPlan, FaultPlanError};
use barrelman_video::{VideoUrl, VideoUrlError};

/// A video source.
#[derive(Debug, Clone, PartialEq)]
pub enum SourceUrl {
    /// A recording or a stream.
    Video(VideoUrl),
    /// The camera of a simulated world.
    Simulated(SimulatedUrl),
}

/// The address of a simulated world.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedUrl {
    /// The world.
    pub world: WorldUrl,
    /// The injected faults of the world's video.
    pub faults: FaultPlan,
}

/// An address that cannot be parsed, with a remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SourceUrlError {
    /// The address of a video cannot be parsed.
    #[error(transparent)]
    Video(#[from] VideoUrlError),
    /// The address of a simulated world cannot be parsed.
    #[error(transparent)]
    World(#[from] WorldUrlError),
    /// The faults cannot be parsed.
    #[error(transparent)]
    Fault(#[from] FaultPlanError),
}

impl SourceUrl {
    /// Parses an address. Checks whether a file of that name exists, but opens nothing.
    ///
    /// # Errors
    /// [`SourceUrlError`] names the unknown scheme or option, and what to write instead.
    pub fn parse(text: &str) -> Result<Self, SourceUrlError> {
        let Some(address) = text.strip_prefix("sim:") else {
            return Ok(Self::Video(VideoUrl::parse(text)?));
        };
        let (world, faults) = WorldUrl::parse(address)?;
        let faults = faults.unwrap_or_default();
        let decoded = percent_encoding::percent_decode_str(&faults).decode_utf8_lossy();
        Ok(Self::Simulated(SimulatedUrl { world, faults: FaultPlan::parse(&decoded)? }))
    }
}

impl SourceUrl {
    /// The injected faults of the source.
    pub fn faults_mut(&mut self) -> &mut FaultPlan {
        match self {
            Self::Video(url) => &mut url.faults,
            Self::Simulated(url) => &mut url.faults,
        }
    }
}

impl fmt::Display for SourceUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Video(url) => write!(f, "{url}"),
            Self::Simulated(url) => write!(f, "{url}"),
        }
    }
}

impl fmt::Display for SimulatedUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.world)?;
        if self.faults.is_empty() { Ok(()) } else { write!(f, "&fault={}", self.faults) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulated_world_prints_as_it_is_read() {
        for text in ["sim:open?seed=7", "sim:mine.toml?seed=1&size=640x360&fault=stall@1"] {
            let parsed = SourceUrl::parse(text).unwrap();
            assert!(matches!(parsed, SourceUrl::Simulated(_)), "{parsed:?}");
            assert_eq!(parsed.to_string(), text);
        }
        assert!(matches!(SourceUrl::parse("clip.mp4").unwrap(), SourceUrl::Video(_)));
    }

    #[test]
    fn the_error_of_an_address_says_what_to_write() {
        for (text, remedy) in
            [("sim:", "sim:arena1"), ("sim:arena1?seed=x", "seed=7"), ("sim:open?fault=melt@1", "stall")]
        {
            let error = SourceUrl::parse(text).unwrap_err().to_string();
            assert!(error.contains(remedy), "{text}: {error}");
        }
    }
}
