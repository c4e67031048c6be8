//! The camera's work: how often, how far and how long a camera moves, and what the paper's schema would have
//! done.

use barrelman_vocab::{CameraCommand, LawId, Timestamp, VehicleProfile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shadow::MotorSchemaShadow;
use crate::work_step::WorkStep;

/// Figures of a camera's work since the first engage.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "SortieWork")]
pub struct WorkFigures {
    /// Starts of a command from rest.
    pub moves: u64,
    /// Integral of the absolute rates of both axes, rad.
    pub travel_rad: f64,
    /// Time at rest, seconds.
    pub rest_s: f64,
    /// Time, seconds.
    pub seconds: f64,
}

/// The camera's work, and that of the schema beside it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraWork {
    /// The camera's own.
    pub camera: WorkFigures,
    /// What the motor schema would have done; `None` while the schema is the law.
    pub schema: Option<WorkFigures>,
    /// P as the schema would have kept it.
    pub schema_p: Option<f64>,
}

/// Adds up the work of one camera.
#[derive(Debug, Default)]
struct WorkMeter {
    figures: WorkFigures,
    in_force: CameraCommand,
    since: Option<Timestamp>,
}

impl WorkMeter {
    /// `command` is in force from `now` on.
    fn add(&mut self, command: CameraCommand, now: Timestamp) {
        let seconds = self.since.map_or(0.0, |since| now.since(since).as_secs_f64());
        let rate = |command: CameraCommand| {
            command.pan.radians_per_second().abs() + command.tilt.radians_per_second().abs()
        };
        self.figures.seconds += seconds;
        self.figures.travel_rad += rate(self.in_force) * seconds;
        self.figures.rest_s += if self.in_force.is_rest() { seconds } else { 0.0 };
        self.figures.moves += u64::from(self.in_force.is_rest() && !command.is_rest());
        (self.in_force, self.since) = (command, Some(now));
    }

    /// The camera is not engaged from `now` on: no time counts until the next [`Self::add`].
    fn pause(&mut self, now: Timestamp) {
        self.add(CameraCommand::REST, now);
        self.since = None;
    }
}

/// Measures the work of the camera and of the schema's simulated camera, while the pilot is engaged.
#[derive(Debug)]
pub struct CameraWorkMeter {
    camera: WorkMeter,
    schema: WorkMeter,
    shadow: MotorSchemaShadow,
}

impl CameraWorkMeter {
    /// A meter at the start of a session.
    pub fn new(profile: &VehicleProfile) -> Self {
        Self {
            camera: WorkMeter::default(),
            schema: WorkMeter::default(),
            shadow: MotorSchemaShadow::new(profile),
        }
    }

    /// Adds a step.
    pub fn on_step<'a>(&mut self, step: impl Into<WorkStep<'a>>) {
        let step = step.into();
        self.shadow.step(&step);
        if step.mode.is_engaged() {
            self.camera.add(step.command, step.at);
            self.schema.add(self.shadow.command(), step.at);
        } else {
            self.camera.pause(step.at);
            self.schema.pause(step.at);
        }
    }

    /// The work so far under this law.
    pub fn work(&self, law: Option<LawId>) -> CameraWork {
        let is_schema = law == Some(LawId::Schema);
        CameraWork {
            camera: self.camera.figures,
            schema: (!is_schema).then_some(self.schema.figures),
            schema_p: self.shadow.p().filter(|_| !is_schema),
        }
    }
}
