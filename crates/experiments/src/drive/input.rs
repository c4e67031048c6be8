//! The inputs of a drive: the actions of a person, each before a tick.

use barrelman_trial::campaign::{Simulation, StepObserver};
use barrelman_vocab::{
    Angle, BoatStop, DrawnMark, DrawnSelection, LawId, MarkKind, MovedMark, Nudge, OperatorRequest, PixelBox,
    PixelPoint, StopCause, Timestamp, VesselCommand,
};
use serde::{Deserialize, Serialize};

/// An action of a person in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "kebab-case")]
pub enum DriveInput {
    /// Engages: the camera may move.
    Engage,
    /// Stops the camera.
    Stop,
    /// Continues with the camera at rest.
    Disengage,
    /// Selects the content of a box.
    Select {
        /// Left, top, width, height, pixels.
        bounds: [f64; 4],
        /// Time of capture of the picture on which the box was drawn; `None`: the next picture.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        captured_ns: Option<u64>,
    },
    /// Rejects the object that is followed.
    Reject,
    /// Forgets the target.
    Deselect,
    /// Turns the camera by hand.
    Nudge {
        /// Share of the nudge rate, -1 to 1, positive to the right.
        pan: f64,
        /// Share of the nudge rate, -1 to 1, positive upwards.
        tilt: f64,
    },
    /// Searches for the target that is lost.
    Search,
    /// Measures the camera's axes.
    Calibrate,
    /// States the net yaw.
    NetYaw {
        /// Positive to the right, radians.
        radians: f64,
    },
    /// Changes the camera law.
    Law {
        /// The law.
        law: DriveLaw,
    },
    /// Steers the boat through the pilot, until it is renewed no more.
    Steer {
        /// -1 (astern) to 1 (ahead).
        throttle: f64,
        /// -1 (left) to 1 (right).
        rudder: f64,
    },
    /// Marks a place or a person.
    Mark {
        /// What is there.
        mark: DriveMark,
        /// The point, pixels: u, v.
        at: [f64; 2],
        /// Time of capture of the picture on which the mark was set.
        captured_ns: u64,
    },
    /// Moves a mark.
    MoveMark {
        /// Its number.
        id: u32,
        /// The point, pixels: u, v.
        at: [f64; 2],
        /// Time of capture of the picture on which the mark was moved.
        captured_ns: u64,
    },
    /// Removes a mark.
    Unmark {
        /// Its number.
        id: u32,
    },
    /// Removes all marks.
    UnmarkAll,
    /// The next mark becomes the destination.
    NextMark,
    /// Lets the boat go to the destination.
    Guide,
    /// Lets the boat go home.
    GoHome,
    /// Stops the boat alone.
    StopBoat,
    /// Stops the boat, as the console in control is gone.
    LeaveBoat,
    /// Commands the boat no more: the scenario's helmsman steers.
    ReleaseBoat,
    /// Pauses the time. The world and the pilot are not affected.
    Pause,
    /// Resumes the time.
    Resume,
}

/// What can be marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DriveMark {
    /// A place to go to.
    Place,
    /// A person to go to.
    Person,
    /// A point to pass.
    WayPoint,
    /// An area to keep out of.
    Forbidden,
    /// The place to come back to.
    Home,
}

/// What can be marked, by both names.
const MARKS: [(DriveMark, MarkKind); 5] = [
    (DriveMark::Place, MarkKind::Place),
    (DriveMark::Person, MarkKind::Person),
    (DriveMark::WayPoint, MarkKind::WayPoint),
    (DriveMark::Forbidden, MarkKind::Forbidden),
    (DriveMark::Home, MarkKind::Home),
];

/// The camera laws that can be switched to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DriveLaw {
    /// The paper's motor schema.
    Schema,
    /// Optimal law: least energy.
    MinimumEnergy,
    /// Optimal law: time in motion and energy.
    TimeFuel,
    /// Optimal law: longest rest.
    Eco,
    /// Optimal law: one movement for each excursion.
    Intermittent,
}

/// The laws by both names.
const LAWS: [(DriveLaw, LawId); 5] = [
    (DriveLaw::Schema, LawId::MotorSchema),
    (DriveLaw::MinimumEnergy, LawId::MinimumEnergy),
    (DriveLaw::TimeFuel, LawId::TimeFuel),
    (DriveLaw::Eco, LawId::Eco),
    (DriveLaw::Intermittent, LawId::Intermittent),
];

impl From<OperatorRequest> for DriveInput {
    fn from(request: OperatorRequest) -> Self {
        let bounds = |area: PixelBox| [area.u, area.v, area.w, area.h];
        match request {
            OperatorRequest::Select(area) => Self::Select { bounds: bounds(area), captured_ns: None },
            OperatorRequest::SelectOn(drawn) => {
                Self::Select { bounds: bounds(drawn.bounds), captured_ns: Some(drawn.captured.as_nanos()) }
            }
            OperatorRequest::Reject => Self::Reject,
            OperatorRequest::Deselect => Self::Deselect,
            OperatorRequest::Nudge(Nudge { pan, tilt }) => Self::Nudge { pan, tilt },
            OperatorRequest::ChangeLaw(id) => {
                let law = LAWS.iter().find(|(_, own)| *own == id).map_or(DriveLaw::Schema, |(law, _)| *law);
                Self::Law { law }
            }
            OperatorRequest::Search => Self::Search,
            OperatorRequest::Calibrate => Self::Calibrate,
            OperatorRequest::SetNetYaw(net) => Self::NetYaw { radians: net.radians() },
            OperatorRequest::Engage => Self::Engage,
            OperatorRequest::Disengage => Self::Disengage,
            OperatorRequest::Stop(_) => Self::Stop,
            OperatorRequest::Steer(VesselCommand { throttle, rudder }) => Self::Steer { throttle, rudder },
            OperatorRequest::Mark(DrawnMark { kind, pixel, captured }) => {
                let mark =
                    MARKS.iter().find(|(_, own)| *own == kind).map_or(DriveMark::Place, |(mark, _)| *mark);
                Self::Mark { mark, at: [pixel.u, pixel.v], captured_ns: captured.as_nanos() }
            }
            OperatorRequest::MoveMark(MovedMark { id, pixel, captured }) => {
                Self::MoveMark { id, at: [pixel.u, pixel.v], captured_ns: captured.as_nanos() }
            }
            OperatorRequest::Unmark(id) => Self::Unmark { id },
            OperatorRequest::UnmarkAll => Self::UnmarkAll,
            OperatorRequest::NextMark => Self::NextMark,
            OperatorRequest::Guide => Self::Guide,
            OperatorRequest::GoHome => Self::GoHome,
            OperatorRequest::StopBoat(BoatStop::Operator) => Self::StopBoat,
            OperatorRequest::StopBoat(BoatStop::ConsoleLost) => Self::LeaveBoat,
            OperatorRequest::ReleaseBoat => Self::ReleaseBoat,
        }
    }
}

impl DriveInput {
    /// The request to the pilot; `None`: the input is for the world, or for the clock.
    pub fn request(self) -> Option<OperatorRequest> {
        Some(match self {
            Self::Engage => OperatorRequest::Engage,
            Self::Disengage => OperatorRequest::Disengage,
            Self::Stop => OperatorRequest::Stop(StopCause::Operator),
            Self::Select { bounds: [u, v, w, h], captured_ns } => {
                let bounds = PixelBox { u, v, w, h };
                match captured_ns.map(Timestamp::from_nanos) {
                    Some(captured) => OperatorRequest::SelectOn(DrawnSelection { bounds, captured }),
                    None => OperatorRequest::Select(bounds),
                }
            }
            Self::Reject => OperatorRequest::Reject,
            Self::Deselect => OperatorRequest::Deselect,
            Self::Search => OperatorRequest::Search,
            Self::Calibrate => OperatorRequest::Calibrate,
            Self::NetYaw { radians } => OperatorRequest::SetNetYaw(Angle::from_radians(radians)),
            Self::Nudge { pan, tilt } => OperatorRequest::Nudge(Nudge { pan, tilt }),
            Self::Law { law } => {
                let id = LAWS.iter().find(|(own, _)| *own == law).map_or(LawId::MotorSchema, |(_, id)| *id);
                OperatorRequest::ChangeLaw(id)
            }
            Self::Steer { throttle, rudder } => OperatorRequest::Steer(VesselCommand { throttle, rudder }),
            Self::Mark { mark, at: [u, v], captured_ns } => OperatorRequest::Mark(DrawnMark {
                kind: MARKS.iter().find(|(own, _)| *own == mark).map_or(MarkKind::Place, |(_, kind)| *kind),
                pixel: PixelPoint { u, v },
                captured: Timestamp::from_nanos(captured_ns),
            }),
            Self::MoveMark { id, at: [u, v], captured_ns } => OperatorRequest::MoveMark(MovedMark {
                id,
                pixel: PixelPoint { u, v },
                captured: Timestamp::from_nanos(captured_ns),
            }),
            Self::Unmark { id } => OperatorRequest::Unmark(id),
            Self::UnmarkAll => OperatorRequest::UnmarkAll,
            Self::NextMark => OperatorRequest::NextMark,
            Self::Guide => OperatorRequest::Guide,
            Self::GoHome => OperatorRequest::GoHome,
            Self::StopBoat => OperatorRequest::StopBoat(BoatStop::Operator),
            Self::LeaveBoat => OperatorRequest::StopBoat(BoatStop::ConsoleLost),
            Self::ReleaseBoat => OperatorRequest::ReleaseBoat,
            Self::Pause | Self::Resume => return None,
        })
    }

    /// Applies the input to a trial, before the next tick of the trial.
    pub fn apply(self, simulation: &mut Simulation<'_>, observer: &mut dyn StepObserver) {
        // A pause changes only when the next tick runs.
        if let Some(request) = self.request() {
            simulation.request(request, observer);
        }
    }
}
