//! The helmsman: drives the boat along a path by pure pursuit (`coulter1992`).
//!
//! A jet steers by its thrust only. The helmsman therefore slows down before sharp turns, but keeps some
//! throttle in them.
//!
//! A trial ends where the path ends. In a world without an end ([`Helmsman::without_end`]) the helmsman goes
//! round a path that is nearly closed; at the end of any other path the helmsman waits.

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
    at_end: AtEnd,
}

/// What the helmsman does at the end of the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AtEnd {
    /// Nothing: the trial ends.
    TrialEnds,
    /// Stay near the end of the path.
    Wait,
    /// Close the path by a leg from its end to its start, and go on.
    ClosePath,
    /// Begin the path again, which is closed.
    BeginAgain,
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
/// A path is nearly closed where the gap between its ends is at most this share of its length.
const CLOSED_SHARE: f64 = 0.25;
/// A helmsman who waits lets the boat drift so far from the end of the path, metres,
const WAIT_RADIUS_M: f64 = 2.0;
/// and comes back with this speed for each metre beyond, 1/s.
const RETURN_PER_S: f64 = 0.5;

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
            at_end: AtEnd::TrialEnds,
        };
        Ok((helmsman, boat))
    }

    /// The same helmsman, who goes round a path that is nearly closed, and waits at the end of any other.
    #[must_use]
    pub fn without_end(mut self) -> Self {
        let (start, end) = (self.path.point_at(0.0), self.path.point_at(self.path.length()));
        let gap_m = libm::hypot(start.0 - end.0, start.1 - end.1);
        self.at_end = AtEnd::Wait;
        if gap_m <= CLOSED_SHARE * self.path.length() {
            self.at_end = AtEnd::ClosePath;
        }
        self
    }

    /// The helm command for the boat's present state.
    pub fn helm_command(&mut self, boat: &JetBoat) -> HelmCommand {
        let pose = boat.pose();
        let position = (pose.position.x, pose.position.y);
        self.along_m = self.path.nearest_arc_length(position, self.along_m, 3.0 * self.look_ahead_m);
        if self.has_arrived() {
            match self.at_end {
                AtEnd::TrialEnds => {}
                AtEnd::Wait => return self.wait_command(boat),
                // Only now: until here, the boat goes as in a trial.
                AtEnd::ClosePath => {
                    self.path = self.path.closed();
                    self.at_end = AtEnd::BeginAgain;
                }
                AtEnd::BeginAgain => self.along_m = 0.0,
            }
        }
        let mut aim_m = self.along_m + self.look_ahead_m;
        if self.at_end == AtEnd::BeginAgain && aim_m > self.path.length() {
            aim_m -= self.path.length();
        }
        self.command_towards(boat, self.path.point_at(aim_m), self.speed_m_per_s)
    }

    /// The helm command that keeps the boat near the end of the path.
    fn wait_command(&self, boat: &JetBoat) -> HelmCommand {
        let (end, position) = (self.path.point_at(self.path.length()), boat.pose().position);
        let beyond_m = libm::hypot(end.0 - position.x, end.1 - position.y) - WAIT_RADIUS_M;
        if beyond_m <= 0.0 {
            return HelmCommand { throttle: 0.0, rudder: 0.0 };
        }
        self.command_towards(boat, end, (RETURN_PER_S * beyond_m).min(self.speed_m_per_s))
    }

    /// The helm command towards a point, at a speed that is lower in sharp turns.
    fn command_towards(&self, boat: &JetBoat, aim: (f64, f64), speed_m_per_s: f64) -> HelmCommand {
        let pose = boat.pose();
        let bearing = libm::atan2(aim.1 - pose.position.y, aim.0 - pose.position.x);
        let off = wrap_angle(bearing - pose.heading.radians());
        let sharp = (off.abs() / core::f64::consts::FRAC_PI_2).min(1.0);
        let speed = speed_m_per_s * (1.0 - (1.0 - SPEED_IN_TURNS) * sharp);
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
