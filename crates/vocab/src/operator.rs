//! Requests to the pilot from the operator, or from a program on behalf of the operator.

use crate::angle::Angle;
use crate::image::{PixelBox, PixelPoint};
use crate::time::Timestamp;
use crate::vessel::VesselCommand;

/// A request to the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorRequest {
    /// Track the content of this box of the next video frame.
    Select(PixelBox),
    /// Track what this box contained in the video frame on which it was drawn. The track is brought up to the newest
    /// frame, and then has to be confirmed.
    SelectOn(DrawnSelection),
    /// "Not that one": forget the present track, do not take that object again, and search for the selected target.
    Reject,
    /// Forget the target and follow nothing.
    Deselect,
    /// Turn the camera slowly, for a short time unless this is renewed; while disengaged only.
    Nudge(Nudge),
    /// Turn the camera slowly to find the target that was lost: the last bearing first, then a bounded sweep.
    Search,
    /// Turn the camera slowly, by itself, to measure its axes.
    Calibrate,
    /// State by how much the vehicle is turned, and with it the tether twisted: positive to the right.
    SetNetYaw(Angle),
    /// Change the camera law; while not engaged only.
    ChangeLaw(LawId),
    /// Let the pilot move the camera. After a stop, only `Engage` allows motion again.
    Engage,
    /// Continue tracking with the camera at rest. This also ends a stop, without allowing motion.
    Disengage,
    /// Rest the camera immediately, and stop the boat. The camera stays at rest until the next `Engage`.
    Stop(StopCause),
    /// Mark a place or a person in a video frame.
    Mark(DrawnMark),
    /// Move a mark to where what it marks is now.
    MoveMark(MovedMark),
    /// Remove the mark of this number.
    Unmark(u32),
    /// Remove all marks.
    UnmarkAll,
    /// The next mark becomes the destination.
    NextMark,
    /// Let the boat go to the destination by itself.
    Guide,
    /// Let the boat go to the place that is marked as home.
    GoHome,
    /// Steer the boat by hand, for a short time unless this is renewed. Neutral lets go.
    Steer(VesselCommand),
    /// Stop the boat alone.
    StopBoat(BoatStop),
    /// Command the boat no more: another program or a person may steer it.
    ReleaseBoat,
}

/// A mark, and the video frame on which it was set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnMark {
    /// What is there.
    pub kind: MarkKind,
    /// The point, pixels.
    pub pixel: PixelPoint,
    /// Time of capture of the video frame.
    pub captured: Timestamp,
}

/// A mark that is moved, and the video frame on which it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovedMark {
    /// Number of the mark.
    pub id: u32,
    /// The point, pixels.
    pub pixel: PixelPoint,
    /// Time of capture of the video frame.
    pub captured: Timestamp,
}

/// What is marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MarkKind {
    /// A place: the boat goes there and stays.
    Place,
    /// A person: the boat stops before the stand-off if the person is the destination, and keeps away otherwise.
    Person,
    /// A point to pass on the way to the destination.
    WayPoint,
    /// The centre of an area that the boat must not enter.
    Forbidden,
    /// The place that the boat comes back to.
    Home,
}

/// Who stops the boat alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BoatStop {
    /// The operator.
    Operator,
    /// The console that was in control is gone.
    ConsoleLost,
}

/// A selection, and the video frame on which it was drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnSelection {
    /// The box, pixels.
    pub bounds: PixelBox,
    /// Time of capture of the video frame.
    pub captured: Timestamp,
}

/// A slow turn of the camera by hand, in shares of the nudge rate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Nudge {
    /// -1 to 1, positive to the right.
    pub pan: f64,
    /// -1 to 1, positive upwards.
    pub tilt: f64,
}

/// The camera laws that an operator can choose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LawId {
    /// The paper's motor schema.
    MotorSchema,
    /// Optimal law: least energy.
    MinimumEnergy,
    /// Optimal law: time in motion and energy.
    TimeFuel,
    /// Optimal law: longest rest.
    Eco,
    /// Optimal law: one movement for each excursion.
    Intermittent,
}

/// The reason for a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StopCause {
    /// The operator pressed Stop.
    Operator,
    /// The program is ending (signal, quit key, closed output).
    Ending,
    /// The video ended.
    VideoEnded,
    /// A part of the program failed.
    Fault,
    /// The vehicle no longer accepts commands from this program.
    ControlLost,
    /// The vehicle, or its ground station, restarted.
    VehicleRestarted,
    /// The vehicle reports an emergency.
    Emergency,
    /// The vehicle lands.
    Landing,
    /// A battery of the vehicle became low.
    BatteryLow,
    /// The vehicle fell silent, though its port was open.
    VehicleSilent,
    /// The machine was suspended, or the program did not run for a second or more.
    Suspended,
    /// The picture turned against the commanded pan: the sign of the yaw rate is probably wrong.
    PanOpposed,
    /// The picture turned against the commanded tilt: the sign of the pitch rate is probably wrong.
    TiltOpposed,
}
