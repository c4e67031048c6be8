//! The numbers of the models whose optimum is sought: the target's motion, the axes of the camera, the picture.

use barrelman_control::Region;
use barrelman_sim::camera_axis::{AxisImperfections, AxisPlant, CameraAxis};
use barrelman_vocab::{Angle, AngularRate};

/// Standard deviation of the bearing's rate, rad/s, and its time constant, seconds: near those of the laboratory.
pub(super) const RATE_STD_DEV: f64 = 0.12;
pub(super) const RATE_TIME_CONSTANT_S: f64 = 2.0;
/// Dead time and lag of an axis, seconds, and its largest rate, rad/s.
pub(super) const DEAD_TIME_S: f64 = 0.3;
pub(super) const LAG_S: f64 = 0.42;
pub(super) const MAX_RATE: f64 = 0.34;

/// The laboratory's focal length, and the region's semi-axes, pixels.
pub(super) const FOCAL_PX: f64 = 330.0;
pub(super) const REGION: Region = Region { a_px: 192.0, b_px: 120.0 };

/// Decisions of a policy for each second.
pub(super) const STEPS_PER_SECOND: u32 = 10;
pub(super) const STEP_S: f64 = 1.0 / STEPS_PER_SECOND as f64;

/// The region's edge, radians of pan.
pub(super) fn edge() -> f64 {
    (REGION.a_px / FOCAL_PX).atan()
}

/// A simulated axis of the camera, at rest at the angle 0.
pub(super) fn axis_at_rest() -> CameraAxis {
    let plant = AxisPlant {
        start_dead_time_s: DEAD_TIME_S,
        stop_dead_time_s: DEAD_TIME_S,
        lag_s: LAG_S,
        max_rate: AngularRate::from_radians_per_second(MAX_RATE),
        end_stops: None,
        imperfections: AxisImperfections::default(),
    };
    CameraAxis::at_rest(plant, Angle::ZERO)
}

/// An axis that answers with a lag: its angle, radians, and its rate, rad/s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub(super) angle: f64,
    pub(super) rate: f64,
}

/// A step of an axis, computed beforehand.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisStep {
    duration_s: f64,
    /// What is left of a difference between rate and command.
    decay: f64,
    /// The time for which the difference counts in full, seconds.
    glide_s: f64,
}

impl AxisStep {
    pub(super) fn of_duration(duration_s: f64) -> Self {
        let decay = (-duration_s / LAG_S).exp();
        Self { duration_s, decay, glide_s: LAG_S * (1.0 - decay) }
    }
}

impl Axis {
    /// The axis after a duration with a command.
    pub(super) fn after(self, command: f64, duration_s: f64) -> Self {
        self.after_step(command, AxisStep::of_duration(duration_s))
    }

    /// The axis after a step with a command.
    pub(super) fn after_step(self, command: f64, step: AxisStep) -> Self {
        let change = self.rate - command;
        Self {
            angle: self.angle + command * step.duration_s + change * step.glide_s,
            rate: command + change * step.decay,
        }
    }

    /// The angle at which the axis comes to rest if its command is zero from now on.
    pub(super) fn rest_angle(self) -> f64 {
        self.angle + LAG_S * self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_ends_at_its_command() {
        let axis = Axis { angle: 0.0, rate: 0.0 }.after(0.2, 10.0);
        assert!((axis.rate - 0.2).abs() < 1e-9 && (axis.angle - 0.2 * (10.0 - LAG_S)).abs() < 1e-9);
    }

    #[test]
    fn an_axis_without_a_command_rests_where_it_was_foreseen() {
        let axis = Axis { angle: 0.1, rate: 0.3 };
        assert!((axis.after(0.0, 20.0).angle - axis.rest_angle()).abs() < 1e-9);
    }
}
