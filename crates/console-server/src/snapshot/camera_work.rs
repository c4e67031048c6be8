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

    /// The camera is not engaged from `now` on: no time counts until the next [`Self::add`].
    fn pause(&mut self, now: Timestamp) {
        self.add(CameraCommand::REST, now);
        self.since = None;
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
            self.camera.pause(outcome.at);
            self.schema.pause(outcome.at);
        }
    }

    /// The work so far under this law.
    pub(super) fn work(&self, law: Option<LawId>) -> CameraWork {
        let is_schema = law == Some(LawId::Schema);
        CameraWork {
            camera: self.camera.figures,
            schema: (!is_schema).then_some(self.schema.figures),
            schema_p: self.shadow.p().filter(|_| !is_schema),
        }
    }
}

#[cfg(test)]
mod tests {
    use barrelman_control::{Percept, Region};
    use barrelman_vocab::{ImagePoint, StopCause, Track};

    use barrelman_vocab::HoldCause;

    use super::*;
    use crate::test_scenes::{at, command, idle, localisation};

    /// A command that comes into force in this mode at this time, ms.
    type Step = (u64, Mode, CameraCommand);

    const SERVOING: Mode = Mode::Servoing;
    const HOLDING: Mode = Mode::Holding(HoldCause::Coasting);
    const REST: CameraCommand = CameraCommand::REST;

    fn metered(steps: &[Step]) -> WorkFigures {
        let mut meter = CameraWorkMeter::new(&VehicleProfile::fotokite_pro());
        for (ms, mode, command) in steps {
            meter.on_step(&Outcome { mode: *mode, command: *command, ..idle(at(*ms)) });
        }
        meter.work(None).camera
    }

    /// Steps lead to these moves, radians, seconds at rest, and seconds. The tolerance is that of a sum of ten roundings.
    #[track_caller]
    fn check(steps: &[Step], moves: u64, travel_rad: f64, rest_s: f64, seconds: f64) {
        let got = metered(steps);
        assert_eq!(got.moves, moves, "{steps:?}");
        for (name, got, expected) in [
            ("rad", got.travel_rad, travel_rad),
            ("s at rest", got.rest_s, rest_s),
            ("s", got.seconds, seconds),
        ] {
            assert!((got - expected).abs() < 1e-12, "{got} {name}, not {expected}: {steps:?}");
        }
    }

    #[test]
    fn a_move_begins_at_rest() {
        let (right, left, up) = (command(0.25, 0.0), command(-0.25, 0.0), command(0.0, 0.5));
        check(&[], 0, 0.0, 0.0, 0.0);
        check(&[(0, SERVOING, REST)], 0, 0.0, 0.0, 0.0);
        check(&[(0, SERVOING, right)], 1, 0.0, 0.0, 0.0);
        check(&[(0, SERVOING, right), (1000, SERVOING, right)], 1, 0.25, 0.0, 1.0);
        check(&[(0, SERVOING, right), (1000, SERVOING, left), (2000, SERVOING, up)], 1, 0.5, 0.0, 2.0);
        check(
            &[(0, SERVOING, right), (1000, SERVOING, REST), (1500, SERVOING, right), (2000, HOLDING, REST)],
            2,
            0.375,
            0.5,
            2.0,
        );
    }

    #[test]
    fn both_axes_add_up_whatever_their_signs() {
        check(&[(0, SERVOING, command(-0.25, 0.5)), (2000, SERVOING, REST)], 1, 1.5, 0.0, 2.0);
        check(&[(0, SERVOING, command(0.25, -0.5)), (2000, SERVOING, REST)], 1, 1.5, 0.0, 2.0);
    }

    #[test]
    fn the_time_counts_while_the_pilot_is_engaged_only() {
        let right = command(0.25, 0.0);
        let stopped = Mode::Stopped(StopCause::Operator);
        check(&[(0, Mode::Idle, REST), (9000, SERVOING, REST), (10_000, HOLDING, REST)], 0, 0.0, 1.0, 1.0);
        check(&[(0, Mode::Nudging, right), (1000, Mode::Nudging, right)], 0, 0.0, 0.0, 0.0);
        check(
            &[(0, Mode::Nudging, right), (1000, SERVOING, right), (2000, SERVOING, right)],
            1,
            0.25,
            0.0,
            1.0,
        );
        check(
            &[(0, SERVOING, right), (1000, SERVOING, REST), (1000, stopped, REST), (9000, SERVOING, REST)],
            1,
            0.25,
            0.0,
            1.0,
        );
    }

    #[test]
    fn the_last_command_counts_until_the_pilot_is_disengaged() {
        let right = command(0.25, 0.0);
        let stopped = Mode::Stopped(StopCause::Operator);
        check(&[(0, SERVOING, right), (1000, Mode::Idle, REST)], 1, 0.25, 0.0, 1.0);
        check(&[(0, SERVOING, right), (1000, stopped, REST), (9000, stopped, REST)], 1, 0.25, 0.0, 1.0);
        check(&[(0, HOLDING, REST), (1000, Mode::Idle, REST), (9000, Mode::Idle, REST)], 0, 0.0, 1.0, 1.0);
    }

    #[test]
    fn a_clock_that_starts_again_adds_nothing() {
        let right = command(0.25, 0.0);
        check(&[(9000, SERVOING, right), (0, SERVOING, right), (1000, SERVOING, right)], 1, 0.25, 0.0, 1.0);
    }

    #[test]
    fn the_schema_is_measured_beside_every_other_law() {
        let mut meter = CameraWorkMeter::new(&VehicleProfile::fotokite_pro());
        let region = Region { a_px: 192.0, b_px: 120.0 };
        for ms in [0, 100, 200] {
            let percept = Percept::new(ImagePoint { x: 300.0, y: 0.0 }, region);
            let track = Track::Tracking(localisation(at(ms)));
            meter.on_step(&Outcome {
                mode: SERVOING,
                track,
                region: Some(region),
                percept: Some(percept),
                ..idle(at(ms))
            });
        }
        let beside = meter.work(Some(LawId::Eco));
        let schema = beside.schema.unwrap();
        assert_eq!((beside.camera.moves, beside.camera.rest_s), (0, 0.2), "the camera has rested");
        assert_eq!((schema.moves, schema.rest_s), (1, 0.0), "the schema would have panned");
        assert!(beside.schema_p.is_some_and(|p| p > 1.0) && meter.work(None).schema.is_some());
        let own = meter.work(Some(LawId::Schema));
        assert_eq!((own.schema, own.schema_p), (None, None));
        assert_eq!(own.camera, beside.camera);
    }
}
