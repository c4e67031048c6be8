//! Centring: a PD controller on the target's position in the picture, which keeps the camera in motion.
//!
//! The paper argues against this law (`biswas2017`, section I): a camera that follows every motion of the
//! target works all the time. It is included for comparison.
//!
//! With the error e (the target's image coordinates in half widths of the picture), each axis has
//! `rate = gain e + derivative de/dt`, clipped to the profile's limits. The derivative is low-pass filtered,
//! and restarts after a gap. Work per step: O(1), no allocation.

use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{AngularRate, CameraCommand, PictureSize, Timestamp};

use crate::percept::Percept;

/// Gains for errors in half widths of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentringGains {
    /// Proportional gain, rad/s per half width.
    pub gain: f64,
    /// Derivative gain, rad/s per half width per second.
    pub derivative: f64,
    /// Time constant of the derivative's low-pass filter, seconds.
    pub filter_s: f64,
}

impl CentringGains {
    /// Tuned by hand for about the same integral of the squared rate as the motor schema in the two
    /// laboratory scenarios, so that laws of equal energy are compared.
    pub const HAND_TUNED: Self = Self { gain: 0.42, derivative: 0.12, filter_s: 0.1 };
}

/// The law restarts after a gap of more than this, seconds.
const MAX_GAP_S: f64 = 0.5;

/// The law with its state.
#[derive(Debug, Clone)]
pub struct Centring {
    gains: CentringGains,
    limits: AxisRates,
    pan: Axis,
    tilt: Axis,
    last: Option<Timestamp>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Axis {
    last_error: Option<f64>,
    /// Filtered derivative of the error.
    derivative: f64,
}

impl Centring {
    /// A law without observations.
    pub fn new(gains: CentringGains, limits: AxisRates) -> Self {
        Self { gains, limits, pan: Axis::default(), tilt: Axis::default(), last: None }
    }

    /// Discards the observations, for a new target or after a gap.
    pub fn reset_target(&mut self) {
        (self.pan, self.tilt, self.last) = (Axis::default(), Axis::default(), None);
    }

    /// Computes the command for a percept in a picture that was captured at `captured`.
    pub fn command(&mut self, percept: &Percept, picture: PictureSize, captured: Timestamp) -> CameraCommand {
        let gap_s = self.last.map_or(f64::INFINITY, |last| captured.since(last).as_secs_f64());
        if gap_s > MAX_GAP_S {
            self.reset_target();
        }
        let step_s = if gap_s > MAX_GAP_S { 0.0 } else { gap_s };
        self.last = Some(captured);
        let half_width = 0.5 * f64::from(picture.width);
        let gains = self.gains;
        let axis = |axis: &mut Axis, px: f64, limit: AngularRate| {
            AngularRate::from_radians_per_second(axis.rate(
                &gains,
                px / half_width,
                step_s,
                limit.radians_per_second(),
            ))
        };
        CameraCommand::turning(
            axis(&mut self.pan, percept.position.x, self.limits.pan),
            axis(&mut self.tilt, percept.position.y, self.limits.tilt),
        )
    }
}

impl Axis {
    fn rate(&mut self, gains: &CentringGains, error: f64, step_s: f64, limit: f64) -> f64 {
        if let Some(last_error) = self.last_error.filter(|_| step_s > 0.0) {
            let share = step_s / (step_s + gains.filter_s);
            self.derivative += share * ((error - last_error) / step_s - self.derivative);
        }
        self.last_error = Some(error);
        let rate = (gains.gain * error + gains.derivative * self.derivative).clamp(-limit, limit);
        if rate.is_nan() { 0.0 } else { rate }
    }
}
