//! What a step comes to: what was seen, what is asked of the vehicle and why, and when to step again.

use core::fmt;

use barrelman_control::{Percept, Sector};
use barrelman_vision::{SelectionError, SelectionReport};
use barrelman_vocab::{CameraCommand, StopCause, Timestamp, Track};

/// The outcome of one step.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The `now` of the step.
    pub at: Timestamp,
    /// Whether the camera may move, and if not, why.
    pub mode: Mode,
    /// The track after this step.
    pub track: Track,
    /// Age of what was seen in this step, from its capture to `at`; `None` where nothing new was seen.
    pub age: Option<core::time::Duration>,
    /// What the newest localisation means to the law, while the target's place is known.
    pub percept: Option<Percept>,
    /// What the law asks for at that percept, whether or not the camera may move.
    pub advice: Option<Advice>,
    /// What is in force from this step on, inside (pan > 0 right, tilt > 0 up).
    pub command: CameraCommand,
    /// The latest time by which the pilot must be stepped again, if nothing else happens before: silence, too,
    /// ends in zeros.
    pub wake_at: Option<Timestamp>,
    /// Something that an operator should be told.
    pub notice: Option<Notice>,
}

/// What a law asks for, and where it saw the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice {
    /// The rates.
    pub command: CameraCommand,
    /// The sector, where the target is outside of the region.
    pub sector: Option<Sector>,
}

/// The pilot's modes.
///
/// ```text
///            engage                       fresh localisation
///   Idle ----------------> (engaged): Holding <----------------> Servoing
///    ^  <--- disengage ---                     nothing fresh for coast_motion
///    |                                |
///    +--- disengage --- Stopped <-----+--- stop, from every mode
///                          |   --- engage ---> (engaged)
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Not engaged: tracks, and rests the camera.
    Idle,
    /// Engaged, and moving the camera as the law asks.
    Servoing,
    /// Engaged, but the camera rests, because there is nothing fresh to go by.
    Holding(HoldCause),
    /// Stopped until the operator engages anew.
    Stopped(StopCause),
}

/// Why an engaged pilot rests the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HoldCause {
    /// Nothing was selected yet.
    NoSelection,
    /// The track is lost.
    TrackLost,
    /// The track has been coasting for too long.
    Coasting,
    /// Video frames come, but too old.
    VideoStale,
    /// No video frames come.
    VideoSilent,
}

/// What an operator should be told about a step.
#[derive(Debug, Clone, PartialEq)]
pub enum Notice {
    /// The selection was taken; how distinct it is.
    Selected(SelectionReport),
    /// The selection cannot be followed; the track that was there before goes on.
    SelectionRefused(SelectionError),
    /// The video's clock ran backwards: a new epoch begins.
    VideoClockWentBack,
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Selected(report) => {
                write!(f, "following the selection {}", report.used)?;
                if report.is_clipped {
                    f.write_str(" (cut off at the picture's edge)")?;
                }
                write!(f, "; {:.0} % of it has a colour to go by", report.coloured_share * 100.0)
            }
            Self::SelectionRefused(refusal) => refusal.fmt(f),
            Self::VideoClockWentBack => f.write_str("the video's clock ran backwards"),
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Idle => "idle",
            Self::Servoing => "servoing",
            Self::Holding(HoldCause::NoSelection) => "holding: nothing selected",
            Self::Holding(HoldCause::TrackLost) => "holding: track lost",
            Self::Holding(HoldCause::Coasting) => "holding: coasting",
            Self::Holding(HoldCause::VideoStale) => "holding: video stale",
            Self::Holding(HoldCause::VideoSilent) => "holding: no video",
            Self::Stopped(StopCause::Operator) => "stopped by the operator",
            Self::Stopped(StopCause::Ending) => "stopped: ending",
            Self::Stopped(StopCause::VideoEnded) => "stopped: video ended",
            Self::Stopped(StopCause::Fault) => "stopped: fault",
        })
    }
}
