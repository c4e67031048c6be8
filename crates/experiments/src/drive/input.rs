//! The inputs of a drive: the actions of a person, each before a tick.

use barrelman_sim::boat::HelmCommand;
use barrelman_trial::campaign::{Simulation, StepObserver};
use barrelman_vocab::{Angle, DrawnSelection, LawId, Nudge, OperatorRequest, PixelBox, StopCause, Timestamp};
use serde::{Deserialize, Serialize};

/// An action of a person in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "kebab-case")]
pub enum DriveInput {
    /// Steers the boat: percent of the throttle (negative: astern) and of the rudder (positive: to the left).
    Helm {
        /// -100 to 100.
        thrust: i8,
        /// -100 to 100.
        rudder: i8,
    },
    /// Returns control to the scenario's helmsman.
    Helmsman,
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
    /// Pauses the time. The world and the pilot are not affected.
    Pause,
    /// Resumes the time.
    Resume,
}

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
            Self::Helm { .. } | Self::Helmsman | Self::Pause | Self::Resume => return None,
        })
    }

    /// The helm after the input: `Some(Some(helm))` if a person steers, `Some(None)` if the helmsman does, `None` if
    /// the input does not change it.
    pub(super) fn helm_change(self) -> Option<Option<HelmCommand>> {
        let share = |percent: i8| f64::from(percent.clamp(-100, 100)) / 100.0;
        match self {
            Self::Helm { thrust, rudder } => {
                Some(Some(HelmCommand { throttle: share(thrust), rudder: share(rudder) }))
            }
            Self::Helmsman => Some(None),
            _ => None,
        }
    }

    /// Applies the input to a trial, before the next tick of the trial.
    pub fn apply(self, simulation: &mut Simulation<'_>, observer: &mut dyn StepObserver) {
        if let Some(helm) = self.helm_change() {
            simulation.steer(helm);
        }
        // A pause changes only when the next tick runs.
        if let Some(request) = self.request() {
            simulation.request(request, observer);
        }
    }
}
