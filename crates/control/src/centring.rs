//! Centring: a PID on the target's place in the picture, which never lets the camera rest.
//!
//! The paper names it as what it does not want (`biswas2017`, section I): a camera that follows every move of the
//! target works all the time. It is here to be compared with.
//!
//! With e the target's image coordinates in half widths of the picture, on each axis
//! `rate = gain e + integral ∫e dt + derivative de/dt`, clipped to the profile's limits. The derivative is that of
//! e through a first-order filter; the integral is held while the rate is clipped, so that it does not wind up.
//! Both begin anew after a gap. O(1), no allocation.

use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{AngularRate, CameraCommand, PictureSize, Timestamp};

use crate::percept::Percept;

/// Gains, for errors in half widths of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentringGains {
    /// rad/s for each half width.
    pub gain: f64,
    /// rad/s for each half width and second.
    pub integral: f64,
    /// rad/s for each half width per second.
    pub derivative: f64,
    /// Time constant of the derivative's filter, seconds.
    pub filter_s: f64,
}

impl CentringGains {
    /// Set by hand so that the integral of the squared rate is about the schema's on the laboratory's two scenarios:
    /// what is compared is then what else that much energy buys.
    pub const HAND_TUNED: Self = Self { gain: 0.42, integral: 0.0, derivative: 0.12, filter_s: 0.1 };
}

/// A gap of more than this makes it begin anew, seconds.
const MAX_GAP_S: f64 = 0.5;

/// The law with its memory.
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
    integral: f64,
    /// The error last seen, and its filtered derivative.
    before: Option<f64>,
    slope: f64,
}

impl Centring {
    /// A law that has seen nothing.
    pub fn new(gains: CentringGains, limits: AxisRates) -> Self {
        Self { gains, limits, pan: Axis::default(), tilt: Axis::default(), last: None }
    }

    /// Forgets what it has seen: another target, or a long time.
    pub fn reset_target(&mut self) {
        (self.pan, self.tilt, self.last) = (Axis::default(), Axis::default(), None);
    }

    /// What to ask of the camera for a percept of a picture taken at `captured`.
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
        CameraCommand {
            pan: axis(&mut self.pan, percept.position.x, self.limits.pan),
            tilt: axis(&mut self.tilt, percept.position.y, self.limits.tilt),
        }
    }
}

impl Axis {
    fn rate(&mut self, gains: &CentringGains, error: f64, step_s: f64, limit: f64) -> f64 {
        if let Some(before) = self.before.filter(|_| step_s > 0.0) {
            let share = step_s / (step_s + gains.filter_s);
            self.slope += share * ((error - before) / step_s - self.slope);
        }
        self.before = Some(error);
        let integral = self.integral + error * step_s;
        let wanted = gains.gain * error + gains.integral * integral + gains.derivative * self.slope;
        let rate = wanted.clamp(-limit, limit);
        if rate == wanted {
            self.integral = integral;
        }
        if rate.is_nan() { 0.0 } else { rate }
    }
}
