//! The outcome of a step: the track, the command with its reason, and the time of the next step.

use core::fmt;

use barrelman_control::{Percept, Region, Sector};
use barrelman_vision::{SelectionError, SelectionReport};
use barrelman_vocab::{CameraCommand, StopCause, Timestamp, Track};

/// The outcome of one step.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The `now` of the step.
    pub at: Timestamp,
    /// The pilot's mode: whether the camera may move, and if not, why.
    pub mode: Mode,
    /// The track after this step.
    pub track: Track,
    /// Age of this step's observation, from its capture to `at`; `None` without observation.
    pub age: Option<core::time::Duration>,
    /// The region in the picture of the newest observation; `None` before the first one.
    pub region: Option<Region>,
    /// Percept of the newest localisation; `None` while the target's position is unknown.
    pub percept: Option<Percept>,
    /// What the law advises for that percept, whether or not the camera may move.
    pub advice: Option<Advice>,
    /// The command in force from this step on (pan > 0 right, tilt > 0 up).
    pub command: CameraCommand,
    /// Latest time of the next step. Without any other input, a tick at that time makes the pilot stop the camera.
    /// `None` if no deadline is pending.
    pub wake_at: Option<Timestamp>,
    /// A message for the operator.
    pub notice: Option<Notice>,
}

/// The advice of a law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice {
    /// The advised command.
    pub command: CameraCommand,
    /// The target's sector; `None` inside the region.
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
    /// Not engaged: the pilot tracks, and the camera rests.
    Idle,
    /// Engaged: the camera follows the law's advice.
    Servoing,
    /// Engaged, but the camera rests for lack of fresh localisations.
    Holding(HoldCause),
    /// Stopped until the next `Engage` (or `Disengage`, which leads to `Idle`).
    Stopped(StopCause),
}

/// The reason why an engaged pilot rests the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HoldCause {
    /// Nothing was selected yet.
    NoSelection,
    /// The track is lost.
    TrackLost,
    /// The track has been coasting for too long.
    Coasting,
    /// The video frames are too old.
    VideoStale,
    /// No video frames arrive.
    VideoSilent,
}

/// A message for the operator about a step.
#[derive(Debug, Clone, PartialEq)]
pub enum Notice {
    /// The selection was accepted, with a report on its quality.
    Selected(SelectionReport),
    /// The selection cannot be tracked; the previous track continues.
    SelectionRefused(SelectionError),
    /// The times of capture ran backwards: a new epoch begins.
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
