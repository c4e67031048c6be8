//! The outcome of a step: the track, the command with its reason, and the time of the next step.

use core::fmt;
use core::time::Duration;

use barrelman_control::{Percept, Region, Sector};
use barrelman_vision::{SelectionError, SelectionReport};
use barrelman_vocab::{CameraCommand, LawId, Localisation, MarkKind, StopCause, Timestamp, Track};

use crate::net_yaw::{NetYawLevel, NetYawState};
use crate::purpose::Purpose;
use crate::vessel::marks::MAX_MARKS;
use crate::vessel::{VesselHold, VesselMode, VesselOutcome, VesselStop};

pub use barrelman_vocab::RENEWAL_GRACE;

/// A target must be lost for this time before the operator can ask for a search: the tracker's own search is faster.
pub const LOST_BEFORE_SEARCH: Duration = Duration::from_secs(3);

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
    pub age: Option<Duration>,
    /// The region in the picture of the newest observation; `None` before the first one.
    pub region: Option<Region>,
    /// Percept of the newest localisation; `None` while the target's position is unknown.
    pub percept: Option<Percept>,
    /// What the law advises for that percept, whether or not the camera may move.
    pub advice: Option<Advice>,
    /// The command in force from this step on (pan > 0 right, tilt > 0 up).
    pub command: CameraCommand,
    /// Time by which the pilot renews the command. Without any other input, a tick at that time makes the pilot stop the
    /// camera. `None` if no deadline is pending.
    pub wake_at: Option<Timestamp>,
    /// Whether a selection waits for its confirmation. The camera rests meanwhile.
    pub is_confirming: bool,
    /// By how much the vehicle is turned about the vertical.
    pub net_yaw: NetYawState,
    /// Why a search would be refused now; `None`: the operator can ask for one.
    pub search_refusal: Option<Refusal>,
    /// The vessel's part.
    pub vessel: VesselOutcome,
    /// A message for the operator.
    pub notice: Option<Notice>,
}

impl Outcome {
    /// Latest time of the next step, for camera and vessel; `None` if no deadline is pending.
    pub fn next_step_at(&self) -> Option<Timestamp> {
        let deadlines = [self.wake_at, self.vessel.renew_by];
        deadlines.into_iter().flatten().min()
    }
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
///   ^  ^ <--- disengage ---                     nothing fresh for coast_motion, or the vehicle takes no commands
///   |  +-- nudge, renewed within 250 ms --> Nudging
///   |                                 |
///   +---- disengage --- Stopped <-----+--- stop, from every mode
///                        ^ |   --- engage ---> (engaged)
///                        +--- (engaged): control taken away, restart, emergency, landing, battery low
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Not engaged: the pilot tracks, and the camera rests.
    Idle,
    /// Not engaged: the operator turns the camera by hand.
    Nudging,
    /// The camera searches for the target, as the operator asked.
    Searching,
    /// The camera makes test motions, as the operator asked.
    Calibrating,
    /// Engaged: the camera follows the law's advice.
    Servoing,
    /// Engaged, but the camera rests: for lack of fresh localisations, or of a vehicle that takes commands.
    Holding(HoldCause),
    /// Stopped until the next `Engage` (or `Disengage`, which leads to `Idle`).
    Stopped(StopCause),
}

/// The reason why an engaged pilot rests the camera: for want of something to follow, or of a camera that may move.
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
    /// A selection waits for its confirmation.
    Confirming,
    /// There is no link: a dry run shows advice only.
    DryRun,
    /// The link is not up: commands do not reach the vehicle.
    LinkDown,
    /// The vehicle does not accept commands from this program.
    NoControl,
    /// The vehicle reports an emergency.
    Emergency,
    /// The vehicle lands.
    Landing,
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
    /// The request of this step, or the selection that was pending, was refused and has no effect.
    RequestRefused(Refusal),
    /// The track of a selection has been confirmed on the newest video frame.
    SelectionConfirmed(Localisation),
    /// The track of a selection could not be confirmed: nothing is followed.
    SelectionUnconfirmed(Unconfirmed),
    /// The object that was followed is not followed any more, and will not be taken again.
    TargetRejected,
    /// The target was forgotten.
    Deselected,
    /// This law is in force.
    LawChanged(LawId),
    /// The search has found the target.
    SearchFound,
    /// The search has ended without the target.
    SearchGaveUp,
    /// The test motions of a calibration have been made.
    TestMotionsMade,
    /// The net yaw has come to another level, or was set.
    NetYaw(NetYawState),
    /// The mark of this number was set.
    Marked(u32, MarkKind),
}

/// The reason why a request has no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// The video frame of the selection is no longer kept.
    SelectionTooOld {
        /// Age of the video frame.
        age: Duration,
        /// How long video frames are kept.
        kept: Duration,
    },
    /// A nudge or a change of the law while the pilot is engaged.
    Engaged,
    /// A nudge while the pilot is stopped.
    Stopped,
    /// A nudge without fresh video: the operator cannot see what the camera looks at.
    NoFreshVideo,
    /// No object is followed that could be rejected.
    NothingToReject,
    /// The camera moves for another purpose.
    Busy(Purpose),
    /// A nudge while no command may move the camera, for this reason.
    NoMotion(HoldCause),
    /// A search while no target is lost.
    NothingLost,
    /// A search for a target that was lost just now.
    LostTooBriefly,
    /// A net yaw that is no number, or larger than any tether bears.
    NetYawOutOfRange,
    /// A request about a boat that is not connected.
    NoVessel,
    /// The boat cannot be commanded, for this reason.
    NoVesselMotion(HoldCause),
    /// The helm was held when the boat was stopped, and was not let go since.
    HelmHeldAtStop,
    /// There is no mark of that number.
    NoSuchMark,
    /// There is no mark that could be a destination.
    NothingMarked,
    /// No place is marked as home.
    NoHome,
    /// There is no guidance: the boat is steered by hand alone.
    ByHandOnly,
    /// The boat is not followed in fresh video.
    BoatNotSeen,
    /// There are as many marks as there can be.
    TooManyMarks,
    /// A mark at the horizon, or above it.
    MarkNotOnWater,
}

/// The reason why a selection was not confirmed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Unconfirmed {
    /// The track was lost before it reached the newest video frame.
    LostBeforeNewest,
    /// The track was lost on the newest video frames.
    Lost,
    /// The target's size changed implausibly.
    SizeChanged,
    /// The confidence stayed low.
    NotSure,
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Selected(report) => {
                write!(f, "following the selection {}", report.used)?;
                if report.is_clipped {
                    f.write_str(" (cut off at the picture's edge)")?;
                }
                if report.is_refined {
                    f.write_str(" (a tighter box than the one drawn)")?;
                }
                write!(f, "; {:.0} % of it has a colour to go by", report.coloured_share * 100.0)
            }
            Self::SelectionRefused(refusal) => refusal.fmt(f),
            Self::VideoClockWentBack => f.write_str("the video's clock ran backwards"),
            Self::RequestRefused(refusal) => refusal.fmt(f),
            Self::SelectionConfirmed(seen) => {
                write!(f, "following the selection; confidence {:.2}", seen.confidence)
            }
            Self::SelectionUnconfirmed(why) => {
                let why = match why {
                    Unconfirmed::LostBeforeNewest => "the boat was lost between the frozen picture and now",
                    Unconfirmed::Lost => "the boat was lost at once",
                    Unconfirmed::SizeChanged => "the box did not stay on the boat",
                    Unconfirmed::NotSure => "the boat is not clear enough in the picture",
                };
                write!(f, "the selection could not be followed: {why}; select again")
            }
            Self::TargetRejected => f.write_str("not that one: that object is not followed any more"),
            Self::Deselected => f.write_str("nothing is followed"),
            Self::LawChanged(law) => write!(f, "camera law: {}", law_text(*law)),
            Self::SearchFound => f.write_str("the search has found the boat"),
            Self::SearchGaveUp => {
                f.write_str("the search has ended without the boat: select it, or search again")
            }
            Self::TestMotionsMade => f.write_str("the test motions have been made"),
            Self::NetYaw(net) => net_yaw_text(*net, f),
            Self::Marked(id, kind) => write!(f, "mark {id}: {}", mark_text(*kind)),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SelectionTooOld { age, kept } => write!(
                f,
                "the picture of the selection is {:.1} s old; select within {:.1} s",
                age.as_secs_f64(),
                kept.as_secs_f64()
            ),
            Self::Engaged => f.write_str("the camera is engaged: disengage first"),
            Self::Stopped => f.write_str("the camera is stopped: disengage first"),
            Self::NoFreshVideo => f.write_str("there is no fresh video: the camera is not turned blindly"),
            Self::NothingToReject => f.write_str("no object is followed"),
            Self::Busy(purpose) => {
                let now = match purpose {
                    Purpose::Follow => "following",
                    Purpose::Nudge => "turned by hand",
                    Purpose::Search => "searching",
                    Purpose::Calibrate => "being calibrated",
                };
                write!(f, "the camera is {now}: stop or disengage first")
            }
            Self::NoMotion(cause) => write!(f, "the camera cannot be turned now: {}", hold_text(*cause)),
            Self::NothingLost => {
                f.write_str("no boat is lost: a search is for a boat that was selected and is lost")
            }
            Self::LostTooBriefly => write!(
                f,
                "the boat was lost just now: a search can begin {} s after the loss",
                LOST_BEFORE_SEARCH.as_secs()
            ),
            Self::NetYawOutOfRange => f.write_str("the net yaw must be a number of radians from -100 to 100"),
            Self::NoVessel => f.write_str("there is no boat to command: start with --vessel"),
            Self::NoVesselMotion(cause) => {
                write!(f, "the boat cannot be commanded now: {}", hold_text(*cause))
            }
            Self::HelmHeldAtStop => f.write_str("the boat was stopped: let go of the helm first"),
            Self::NoSuchMark => f.write_str("there is no such mark"),
            Self::NothingMarked => f.write_str("nothing is marked: mark a place or a person first"),
            Self::NoHome => f.write_str("no home is marked: mark it first"),
            Self::ByHandOnly => f.write_str("the boat is steered by hand alone: start with --guidance los"),
            Self::BoatNotSeen => f.write_str("the boat is not seen: select it first"),
            Self::TooManyMarks => write!(f, "there are {MAX_MARKS} marks already: remove one first"),
            Self::MarkNotOnWater => f.write_str("there is no water at that point: mark below the horizon"),
        }
    }
}

/// The net yaw in words, with the way back where there is need.
fn net_yaw_text(net: NetYawState, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let degrees = net.angle.degrees();
    let (side, back) = if degrees < 0.0 { ("left", "right") } else { ("right", "left") };
    let turned = degrees.abs();
    match net.level {
        NetYawLevel::Free => write!(f, "net yaw {turned:.0} degrees to the {side}"),
        NetYawLevel::Warned => {
            write!(
                f,
                "the tether winds up: net yaw {turned:.0} degrees to the {side}; turn back to the {back}"
            )
        }
        NetYawLevel::Refused => write!(
            f,
            "the tether is wound up: net yaw {turned:.0} degrees to the {side}; the camera turns to the {back} only: disengage, and turn it back by hand"
        ),
    }
}

/// What is marked, in words.
const fn mark_text(kind: MarkKind) -> &'static str {
    match kind {
        MarkKind::Place => "a place",
        MarkKind::Person => "a person",
        MarkKind::WayPoint => "a way-point",
        MarkKind::Forbidden => "a forbidden area",
        MarkKind::Home => "home",
    }
}

/// A law in words.
const fn law_text(law: LawId) -> &'static str {
    match law {
        LawId::MotorSchema => "the paper's motor schema",
        LawId::MinimumEnergy => "optimal, minimum energy",
        LawId::TimeFuel => "optimal, time and fuel",
        LawId::Eco => "optimal, eco",
        LawId::Intermittent => "optimal, intermittent",
    }
}

/// The reason for holding in words.
const fn hold_text(cause: HoldCause) -> &'static str {
    match cause {
        HoldCause::NoSelection => "nothing selected",
        HoldCause::TrackLost => "track lost",
        HoldCause::Coasting => "coasting",
        HoldCause::VideoStale => "video stale",
        HoldCause::VideoSilent => "no video",
        HoldCause::Confirming => "confirming the selection",
        HoldCause::DryRun => "dry run, nothing is sent",
        HoldCause::LinkDown => "the link is not up",
        HoldCause::NoControl => "the vehicle takes no commands",
        HoldCause::Emergency => "the vehicle has an emergency",
        HoldCause::Landing => "the vehicle lands",
    }
}

/// The reason for a stop in words.
const fn stop_text(cause: StopCause) -> &'static str {
    match cause {
        StopCause::Operator => "stopped by the operator",
        StopCause::Ending => "stopped: ending",
        StopCause::VideoEnded => "stopped: video ended",
        StopCause::Fault => "stopped: fault",
        StopCause::ControlLost => "stopped: the vehicle gave the control away",
        StopCause::VehicleRestarted => "stopped: the vehicle restarted",
        StopCause::Emergency => "stopped: the vehicle has an emergency",
        StopCause::Landing => "stopped: the vehicle lands",
        StopCause::BatteryLow => "stopped: a battery of the vehicle is low",
        StopCause::VehicleSilent => "stopped: the vehicle fell silent",
        StopCause::Suspended => "stopped: the machine was suspended",
        StopCause::PanOpposed => {
            "stopped: the picture turned against the commanded pan; check vehicle.yaw_sign of the configuration"
        }
        StopCause::TiltOpposed => {
            "stopped: the picture turned against the commanded tilt; check vehicle.pitch_sign of the configuration"
        }
    }
}

impl fmt::Display for VesselMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let held = |hold: &VesselHold| match hold {
            VesselHold::NoDestination => "no destination",
            VesselHold::Cause(cause) => hold_text(*cause),
        };
        match self {
            Self::Absent => f.write_str("no boat"),
            Self::Released => f.write_str("boat not commanded"),
            Self::Neutral => f.write_str("boat neutral"),
            Self::ByHand => f.write_str("boat steered by hand"),
            Self::Guided => f.write_str("boat guided"),
            Self::Holding(hold) => write!(f, "boat holding: {}", held(hold)),
            Self::Stopped(VesselStop::Operator) => f.write_str("boat stopped by the operator"),
            Self::Stopped(VesselStop::ConsoleLost) => f.write_str("boat stopped: the console is gone"),
            Self::Stopped(VesselStop::OtherBoat) => f.write_str("boat stopped: another one was selected"),
            Self::Stopped(VesselStop::Everything(cause) | VesselStop::Vessel(cause)) => {
                write!(f, "boat {}", stop_text(*cause))
            }
            Self::Stopped(VesselStop::HeldTooLong(hold)) => {
                write!(f, "boat stopped: {} for too long", held(hold))
            }
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Idle => f.write_str("disengaged"),
            Self::Nudging => f.write_str("nudging"),
            Self::Searching => f.write_str("searching"),
            Self::Calibrating => f.write_str("calibrating"),
            Self::Servoing => f.write_str("servoing"),
            Self::Holding(cause) => write!(f, "holding: {}", hold_text(*cause)),
            Self::Stopped(cause) => f.write_str(stop_text(*cause)),
        }
    }
}
