//! The helmsman: drives the boat along a path by pure pursuit (`coulter1992`).
//!
//! A jet steers by its thrust only. The helmsman therefore slows down before sharp turns, but keeps some throttle in
//! them.

use crate::boat::{HelmCommand, JetBoat, Steering, throttle_for_speed};
use crate::path::{InvalidPath, Path};
use crate::pursuit::wrap_angle;
use crate::random::{CounterRng, Stream};

/// How the boat is driven along its path.
#[derive(Debug, Clone, PartialEq)]
pub struct BoatScript {
    /// Way-points, metres.
    pub way_points: Vec<(f64, f64)>,
    /// Median of the speeds over the trials, m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the logarithm of the speed over the trials.
    pub log_speed_std_dev: f64,
    /// What steers the boat.
    pub steering: Steering,
    /// Largest throttle, above 0, at most 1.
    pub max_throttle: f64,
    /// Distance of the aim along the path, metres.
    pub look_ahead_m: f64,
    /// Standard deviation of each coordinate of each way-point from trial to trial, metres.
    pub way_point_jitter_m: f64,
}

/// A helmsman on its path.
#[derive(Debug, Clone)]
pub struct Helmsman {
    path: Path,
    look_ahead_m: f64,
    max_throttle: f64,
    speed_m_per_s: f64,
    along_m: f64,
}

/// Gains of the rudder: for each radian of heading error, and against each rad/s of turn rate.
const RUDDER_PER_RAD: f64 = 1.4;
const RUDDER_PER_RAD_PER_S: f64 = 0.35;
/// Throttle for each m/s of missing speed.
const THROTTLE_PER_MPS: f64 = 0.25;
/// Share of the speed at a heading error of a right angle or more.
const SPEED_IN_TURNS: f64 = 0.45;
/// Least throttle, so that the jet steers, where the heading error exceeds [`STEERING_ERROR_RAD`].
const STEERING_THROTTLE: f64 = 0.25;
const STEERING_ERROR_RAD: f64 = 0.3;
/// The boat has arrived when at most this is left of the path, metres.
const ARRIVED_M: f64 = 1.0;

impl Helmsman {
    /// The helmsman of a trial, and the boat at rest at the start of the path.
    ///
    /// # Errors
    /// [`InvalidPath`] where the way-points make no path.
    pub fn new(script: &BoatScript, seed: u64) -> Result<(Self, JetBoat), InvalidPath> {
        let jitter = CounterRng::new(seed, Stream::WayPoints);
        let path = Path::from_way_points(script.way_points.iter().enumerate().map(|(index, (x, y))| {
            let off = |which: u64| script.way_point_jitter_m * jitter.normal(2 * index as u64 + which);
            (x + off(0), y + off(1))
        }))?;
        let pace = CounterRng::new(seed, Stream::Pace);
        let boat = JetBoat::at_rest(
            path.point_at(0.0),
            barrelman_vocab::Angle::from_radians(path.direction_at(0.0)),
        )
        .with_steering(script.steering);
        let helmsman = Self {
            path,
            look_ahead_m: script.look_ahead_m,
            max_throttle: script.max_throttle,
            speed_m_per_s: script.speed_m_per_s * libm::exp(script.log_speed_std_dev * pace.normal(0)),
            along_m: 0.0,
        };
        Ok((helmsman, boat))
    }

    /// The helm command for the boat's present state.
    pub fn helm_command(&mut self, boat: &JetBoat) -> HelmCommand {
        let pose = boat.pose();
        let position = (pose.position.x, pose.position.y);
        self.along_m = self.path.nearest_arc_length(position, self.along_m, 3.0 * self.look_ahead_m);
        let aim = self.path.point_at(self.along_m + self.look_ahead_m);
        let bearing = libm::atan2(aim.1 - position.1, aim.0 - position.0);
        let off = wrap_angle(bearing - pose.heading.radians());
        let sharp = (off.abs() / core::f64::consts::FRAC_PI_2).min(1.0);
        let speed = self.speed_m_per_s * (1.0 - (1.0 - SPEED_IN_TURNS) * sharp);
        let throttle = throttle_for_speed(speed) + THROTTLE_PER_MPS * (speed - boat.speed_ahead_mps());
        let min_throttle = if off.abs() > STEERING_ERROR_RAD { STEERING_THROTTLE } else { 0.0 };
        let rudder = RUDDER_PER_RAD * off - RUDDER_PER_RAD_PER_S * boat.turn_rad_per_s();
        HelmCommand {
            throttle: throttle.clamp(min_throttle.min(self.max_throttle), self.max_throttle),
            rudder: rudder.clamp(-1.0, 1.0),
        }
    }

    /// Whether the boat has reached the end of the path.
    pub fn has_arrived(&self) -> bool {
        self.path.length() - self.along_m <= ARRIVED_M
    }
}
