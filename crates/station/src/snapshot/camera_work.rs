//! The camera's work: how often, how far and how long a camera moves, and what the paper's schema would have done.

use barrelman_experiments::drive::motor_schema_shadow::MotorSchemaShadow;
use barrelman_pilot::{Mode, Outcome};
use barrelman_vocab::{CameraCommand, LawId, Timestamp, VehicleProfile};

/// Figures of a camera's work since the first engage.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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

    /// The camera is not engaged: no time counts until the next [`Self::add`].
    fn pause(&mut self) {
        (self.in_force, self.since) = (CameraCommand::REST, None);
    }
}

/// Measures the work of the camera and of the schema's simulated camera, while the pilot is engaged.
pub(super) struct CameraWorkMeter {
    camera: WorkMeter,
    schema: WorkMeter,
    shadow: MotorSchemaShadow,
}

impl CameraWorkMeter {
    /// A meter at the start of a session.
    pub(super) fn new(profile: &VehicleProfile) -> Self {
        Self {
            camera: WorkMeter::default(),
            schema: WorkMeter::default(),
            shadow: MotorSchemaShadow::new(profile),
        }
    }

    /// Adds a step.
    pub(super) fn on_step(&mut self, outcome: &Outcome) {
        self.shadow.step(outcome.at, outcome);
        if matches!(outcome.mode, Mode::Servoing | Mode::Holding(_)) {
            self.camera.add(outcome.command, outcome.at);
            self.schema.add(self.shadow.command(), outcome.at);
        } else {
            self.camera.pause();
            self.schema.pause();
        }
    }

    /// The work so far under this law.
    pub(super) fn work(&self, law: Option<LawId>) -> CameraWork {
        let is_schema = law == Some(LawId::MotorSchema);
        CameraWork {
            camera: self.camera.figures,
            schema: (!is_schema).then_some(self.schema.figures),
            schema_p: self.shadow.p().filter(|_| !is_schema),
        }
    }
}
