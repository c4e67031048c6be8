//! Why a camera cannot be used, and the reading of its answers at the start.

use core::time::Duration;

use barrelman_vocab::acceptance::Acceptance;

use super::refusal::Refusal;
use super::soap;

/// A camera whose least time-out is longer is not used.
pub(super) const LATEST_TIMEOUT: Duration = Duration::from_secs(2);

/// Why a camera cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum JoiningError {
    /// It refuses a question.
    Refused {
        /// The question.
        question: &'static str,
        /// What it says.
        refusal: Refusal,
    },
    /// Its answer to a question cannot be read.
    Unreadable(&'static str),
    /// It has no service of this name.
    NoService(&'static str),
    /// None of its media profiles pans and tilts.
    NoMotion,
    /// None of its media profiles that pan and tilt is called so.
    NoProfile {
        /// What the operator wrote.
        chosen: String,
        /// The profiles that pan and tilt.
        moving: Vec<String>,
    },
    /// It cannot be turned at a speed.
    NoVelocity,
    /// It ends a motion by itself only after this time at least.
    LateTimeout(Duration),
}

impl JoiningError {
    /// What it means for commands.
    pub const fn said(&self) -> Acceptance {
        match self {
            Self::Refused { refusal, .. } => refusal.said,
            Self::Unreadable(_) => Acceptance::Fault,
            Self::NoService(_)
            | Self::NoMotion
            | Self::NoProfile { .. }
            | Self::NoVelocity
            | Self::LateTimeout(_) => Acceptance::NoCamera,
        }
    }
}

impl core::fmt::Display for JoiningError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Refused { question, refusal } => {
                write!(f, "the camera refuses {question}: {}", refusal.words)
            }
            Self::Unreadable(question) => write!(f, "the camera's answer to {question} cannot be read"),
            Self::NoService(name) => write!(f, "the camera has no {name} service"),
            Self::NoMotion => f.write_str("none of the camera's media profiles has a PTZ configuration"),
            Self::NoProfile { chosen, moving } => write!(
                f,
                "no media profile of the camera that moves is called {chosen:?}: let video.stream be one of {}",
                moving.join(", ")
            ),
            Self::NoVelocity => f.write_str("the camera cannot be turned at a speed (ContinuousMove)"),
            Self::LateTimeout(least) => write!(
                f,
                "the camera ends no motion by itself before {} s, and a connection that fails would leave it turning for \
                 longer than {} s",
                least.as_secs_f64(),
                LATEST_TIMEOUT.as_secs_f64()
            ),
        }
    }
}

impl core::error::Error for JoiningError {}

/// The body of an answer, which the camera may have refused.
pub(super) fn answer<B: serde::de::DeserializeOwned>(
    question: &'static str,
    refused: Option<Refusal>,
    body: &[u8],
) -> Result<B, JoiningError> {
    match refused {
        Some(refusal) => Err(JoiningError::Refused { question, refusal }),
        None => soap::read(body).ok_or(JoiningError::Unreadable(question)),
    }
}
