//! Who steers the boat along a path: pure pursuit of a place ahead on it, at a speed.
//!
//! Since a jet steers by its thrust alone, the boat is never allowed to coast through a turn: where it must turn
//! sharply it slows down but keeps some throttle. `coulter1992` for the pursuit.

use crate::boat::{HelmCommand, JetBoat, throttle_for_speed};
use crate::path::{InvalidPath, Path};
use crate::pursuit::wrap_angle;
use crate::random::{CounterRng, Stream};

/// How the boat is driven.
#[derive(Debug, Clone, PartialEq)]
pub struct BoatScript {
    /// Way-points, metres.
    pub way_points: Vec<(f64, f64)>,
    /// Median of the trials' speeds, m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the logarithm of the trials' speeds.
    pub log_speed_std_dev: f64,
    /// Largest throttle, above 0, at most 1.
    pub max_throttle: f64,
    /// How far ahead on the path it aims, metres.
    pub look_ahead_m: f64,
    /// Standard deviation by which each way-point is missed, metres.
    pub way_point_jitter_m: f64,
}

/// Someone at the helm.
#[derive(Debug, Clone)]
pub struct Helmsman {
    path: Path,
    look_ahead_m: f64,
    max_throttle: f64,
    speed_m_per_s: f64,
    along_m: f64,
}

/// Rudder for each radian that it points off, and for each rad/s that it turns.
const RUDDER_PER_RAD: f64 = 1.4;
const RUDDER_PER_RAD_PER_S: f64 = 0.35;
/// Throttle for each m/s that it is too slow.
const THROTTLE_PER_MPS: f64 = 0.25;
/// Share of the speed that is kept where it must turn by a right angle or more.
const SPEED_IN_TURNS: f64 = 0.45;
/// Least throttle where it points off by more than so much: enough to steer by.
const STEERING_THROTTLE: f64 = 0.25;
const POINTS_OFF_RAD: f64 = 0.3;
/// It has arrived when no more than this is left of the path, metres.
const ARRIVED_M: f64 = 1.0;

impl Helmsman {
    /// For a trial, and the boat at the start of its path.
    ///
    /// # Errors
    /// [`InvalidPath`] where the way-points make none.
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
        );
        let helmsman = Self {
            path,
            look_ahead_m: script.look_ahead_m,
            max_throttle: script.max_throttle,
            speed_m_per_s: script.speed_m_per_s * libm::exp(script.log_speed_std_dev * pace.normal(0)),
            along_m: 0.0,
        };
        Ok((helmsman, boat))
    }

    /// What the boat is to do now.
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
        let least = if off.abs() > POINTS_OFF_RAD { STEERING_THROTTLE } else { 0.0 };
        let rudder = RUDDER_PER_RAD * off - RUDDER_PER_RAD_PER_S * boat.turn_rad_per_s();
        HelmCommand {
            throttle: throttle.clamp(least.min(self.max_throttle), self.max_throttle),
            rudder: rudder.clamp(-1.0, 1.0),
        }
    }

    /// Whether the boat has come to the end of the path.
    pub fn has_arrived(&self) -> bool {
        self.path.length() - self.along_m <= ARRIVED_M
    }
}
