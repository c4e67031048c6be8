//! The outcome of a step: the track, the command with its reason, and the time of the next step.

use core::fmt;
use core::time::Duration;

use barrelman_control::{Percept, Region, Sector};
use barrelman_vision::{SelectionError, SelectionReport};
use barrelman_vocab::earth::WaterOnEarth;
use barrelman_vocab::{
    AngularRate, CameraCommand, HoldCause, LawId, Localisation, MarkKind, Named as _, PixelBox, StopCause,
    Timestamp, Track,
};

use crate::candidates::{Candidate, MAX_CANDIDATES};
use crate::net_yaw::{NetYawLevel, NetYawState};
use crate::on_earth::NotOnEarth;
use crate::proposing::ProposedObject;
use crate::vessel::guiding::NoWater;
use crate::vessel::{VesselHold, VesselMode, VesselOutcome, VesselStop};

pub use crate::refusal::{LOST_BEFORE_SEARCH, Refusal};
pub use barrelman_vocab::RENEWAL_GRACE;

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
    /// Time by which the pilot renews the command. Without any other input, a tick at that time makes the
    /// pilot stop the camera. `None` if no deadline is pending.
    pub wake_at: Option<Timestamp>,
    /// Whether a selection waits for its confirmation. The camera rests meanwhile.
    pub is_confirming: bool,
    /// Whether a detector contradicts that what was found again is the boat. The camera rests meanwhile.
    pub is_doubted: bool,
    /// The object that is proposed; nothing follows it.
    pub proposal: Option<ProposedObject>,
    /// The objects that may be the wanted one, by their numbers; none while they are not shown.
    pub candidates: [Option<Candidate>; MAX_CANDIDATES],
    /// Whether candidates are shown also while a target is followed.
    pub are_candidates_wanted: bool,
    /// By how much the vehicle is turned about the vertical.
    pub net_yaw: NetYawState,
    /// The zoom; `None`: the camera does not zoom, or has not told whether it does.
    pub zoom: Option<ZoomState>,
    /// The rate of a camera that turns although zero is commanded, as the vehicle reports it; `None`: no such
    /// motion is reported.
    pub unasked_motion: Option<AngularRate>,
    /// Why a search would be refused now; `None`: the operator can ask for one.
    pub search_refusal: Option<Refusal>,
    /// The vessel's part.
    pub vessel: VesselOutcome,
    /// Where the water frame lies on Earth, or why that is not known.
    pub earth: Result<WaterOnEarth, NotOnEarth>,
    /// A message for the operator.
    pub notice: Option<Notice>,
}

impl Outcome {
    /// Whether what is followed may be another object than the boat. The camera rests meanwhile.
    pub const fn is_target_uncertain(&self) -> bool {
        self.is_confirming || self.is_doubted
    }

    /// The outcome of a pilot that has observed nothing and was asked for nothing.
    pub fn idle(at: Timestamp) -> Self {
        Self {
            at,
            mode: Mode::Idle,
            track: Track::Unseeded,
            age: None,
            region: None,
            percept: None,
            advice: None,
            command: CameraCommand::REST,
            wake_at: None,
            is_confirming: false,
            is_doubted: false,
            proposal: None,
            candidates: [None; MAX_CANDIDATES],
            are_candidates_wanted: false,
            net_yaw: NetYawState::default(),
            zoom: None,
            unasked_motion: None,
            search_refusal: None,
            vessel: VesselOutcome::absent(),
            earth: Err(NotOnEarth::NoPosition),
            notice: None,
        }
    }

    /// Latest time of the next step, for camera and vessel; `None` if no deadline is pending.
    pub fn next_step_at(&self) -> Option<Timestamp> {
        let deadlines = [self.wake_at, self.vessel.renew_by];
        deadlines.into_iter().flatten().min()
    }
}

/// The zoom of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoomState {
    /// The present focal length over that of the widest view: as reported, or as commanded since.
    pub ratio: f64,
    /// Whether the target's size is kept by the zoom while engaged.
    pub keeps_size: bool,
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

impl Mode {
    /// Whether the camera follows the target as soon as it can.
    pub const fn is_engaged(self) -> bool {
        match self {
            Self::Servoing | Self::Holding(_) => true,
            Self::Idle | Self::Nudging | Self::Searching | Self::Calibrating | Self::Stopped(_) => false,
        }
    }
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
    /// An object is proposed.
    Proposed(PixelBox),
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
    /// The target's size is kept by the zoom from now on, or no longer.
    KeepingSize(bool),
    /// The mark of this number was set.
    Marked(u32, MarkKind),
    /// The boat goes to its destination: over the water, or, for this reason, in the picture.
    Going(Option<NoWater>),
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
            Self::Proposed(_) => f.write_str("an object is proposed: tap it again to follow it"),
            Self::TargetRejected => f.write_str("not that one: that object is not followed any more"),
            Self::Deselected => f.write_str("nothing is followed"),
            Self::LawChanged(law) => write!(f, "camera law: {}", law.text()),
            Self::SearchFound => f.write_str("the search has found the boat"),
            Self::SearchGaveUp => {
                f.write_str("the search has ended without the boat: select it, or search again")
            }
            Self::TestMotionsMade => f.write_str("the test motions have been made"),
            Self::NetYaw(net) => net_yaw_text(*net, f),
            Self::KeepingSize(true) => f.write_str("the zoom keeps the boat's size"),
            Self::KeepingSize(false) => f.write_str("the zoom does not keep the boat's size any more"),
            Self::Marked(id, kind) => write!(f, "mark {id}: {}", mark_text(*kind)),
            Self::Going(None) => f.write_str("the boat goes over the water, around the circles"),
            Self::Going(Some(why)) => {
                write!(f, "the boat goes in the picture, which keeps out of no circles: {}", why.text())
            }
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

impl fmt::Display for VesselMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let held = |hold: &VesselHold| match hold {
            VesselHold::NoDestination => "no destination",
            VesselHold::NoPlace => {
                "the boat is too near to the horizon, or its destination behind the camera"
            }
            VesselHold::UnplacedMark => "a mark has no place on the water: move or remove it",
            VesselHold::Cause(cause) => cause.text(),
        };
        match self {
            Self::Absent => f.write_str("no boat"),
            Self::Released => f.write_str("boat not commanded"),
            Self::Neutral => f.write_str("boat neutral"),
            Self::ByHand => f.write_str("boat steered by hand"),
            Self::Guided => f.write_str("boat guided"),
            Self::Holding(hold) => write!(f, "boat holding: {}", held(hold)),
            Self::KeepingWay(hold) => write!(f, "boat keeps way: {}", held(hold)),
            Self::Stopped(VesselStop::Operator) => f.write_str("boat stopped: by the operator"),
            Self::Stopped(VesselStop::ConsoleLost) => f.write_str("boat stopped: the console is gone"),
            Self::Stopped(VesselStop::OtherBoat) => f.write_str("boat stopped: what is followed was changed"),
            Self::Stopped(VesselStop::Everything(cause) | VesselStop::Vessel(cause)) => {
                write!(f, "boat stopped: {}", cause.text())
            }
            Self::Stopped(VesselStop::NotAccepted(said)) => write!(f, "boat stopped: {said}"),
            Self::Stopped(VesselStop::WaterLost) => f.write_str(
                "boat stopped: height or tilt of the camera are not reported any more, and circles cannot be kept",
            ),
            Self::Stopped(VesselStop::NoAnswer) => f.write_str(
                "boat stopped: what is followed did not move as commanded; check the box, and the boat's drive",
            ),
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
            Self::Holding(cause) => write!(f, "holding: {}", cause.text()),
            Self::Stopped(cause) => write!(f, "stopped: {}", cause.text()),
        }
    }
}
