//! What the boat does, as far as this program commands it, and why it waits or is stopped.

use barrelman_vocab::{HoldCause, StopCause};

use crate::vessel::said::Said;

/// What the boat does, as far as this program commands it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VesselMode {
    /// There is no vessel.
    Absent,
    /// The boat is not commanded: another program or a person may steer it.
    Released,
    /// Neutral: commanded, and steered neither by guidance nor by hand.
    Neutral,
    /// The operator steers by hand.
    ByHand,
    /// The boat goes to its destination by itself.
    Guided,
    /// The boat shall go by itself, but is neutral for this reason.
    Holding(VesselHold),
    /// The same, but the boat keeps way for a while.
    KeepingWay(VesselHold),
    /// Stopped, until the next request.
    Stopped(VesselStop),
}

/// Why a boat that shall go by itself is neutral.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VesselHold {
    /// There is no destination.
    NoDestination,
    /// A mark that the boat must regard has no place on the water.
    UnplacedMark,
    /// The boat has no place on the water: its line of sight is too near to the horizon, or beyond the lens.
    /// Or the boat is guided in the picture, and its destination has no pixel: it is behind the camera.
    NoPlace,
    /// For want of a boat in the picture, of video, or of a link.
    Cause(HoldCause),
}

/// Why the boat is stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VesselStop {
    /// The operator stopped the boat.
    Operator,
    /// The console that was in control is gone.
    ConsoleLost,
    /// Everything was stopped.
    Everything(StopCause),
    /// What the vessel reported.
    Vessel(StopCause),
    /// The boat takes no commands any more.
    NotAccepted(Said),
    /// Another boat was selected, or none.
    OtherBoat,
    /// The guidance waited for too long, for this reason.
    HeldTooLong(VesselHold),
    /// Height or tilt of the camera are not reported any more, and circles are marked: in the picture they
    /// would not be kept.
    WaterLost,
    /// What is followed did not move as the commanded boat would have.
    NoAnswer,
}
