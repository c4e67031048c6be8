//! The boat's motion over the water: forward along its heading, with orders that change now and then.
//!
//! Speed and turn rate follow their orders through first-order lags. A boat that hardly moves hardly turns.

use barrelman_vocab::rng::SplitMix64;

use super::choices::Choices;
use super::view::PlanePoint;

/// Time constant of the turn rate, s: a small boat answers its rudder within half a second.
const TURN_LAG_S: f64 = 0.35;
/// Time constant of the speed, s.
const SPEED_LAG_S: f64 = 0.6;
/// Largest turn rate, rad/s (60 degrees per second).
const MAX_TURN_RATE: f64 = core::f64::consts::FRAC_PI_3;
/// Turn rate per heading error when the boat has a direction to go in, 1/s.
const STEERING_GAIN: f64 = 1.8;
/// Lowest and highest ordered speed, hull lengths per second.
pub(super) const MIN_SPEED: f64 = 0.55;
const MAX_SPEED: f64 = 3.0;

/// An order to the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    /// Move about at random.
    Roam,
    /// Move about slowly.
    Loiter,
    /// Move briskly in a direction of the plane (radians, anticlockwise from x).
    Head(f64),
}

/// The boat and its helmsman.
#[derive(Debug, Clone)]
pub(super) struct BoatMotion {
    rng: SplitMix64,
    hull: f64,
    max_speed: f64,
    /// Radius around the start that roaming keeps to, in the plane's unit; `None`: no limit.
    home_radius: Option<f64>,
    pub(super) at: PlanePoint,
    /// Radians, anticlockwise from the plane's x.
    pub(super) heading: f64,
    /// Hull lengths per second.
    pub(super) speed: f64,
    turn: f64,
    ordered_speed: f64,
    ordered_turn: f64,
    next_order_s: f64,
}

impl BoatMotion {
    /// A boat of this length at the plane's origin. `max_speed` is in the plane's unit per second.
    pub(super) fn new(mut rng: SplitMix64, hull: f64, max_speed: f64, home_radius: Option<f64>) -> Self {
        let max_speed = (max_speed / hull).clamp(MIN_SPEED * 1.5, MAX_SPEED);
        let heading = rng.between(-core::f64::consts::PI, core::f64::consts::PI);
        let speed = rng.between(MIN_SPEED, max_speed);
        let at = PlanePoint::default();
        Self {
            rng,
            hull,
            max_speed,
            home_radius,
            at,
            heading,
            speed,
            turn: 0.0,
            ordered_speed: speed,
            ordered_turn: 0.0,
            next_order_s: 0.0,
        }
    }

    /// Velocity over the water, in the plane's unit per second.
    pub(super) fn velocity(&self) -> (f64, f64) {
        let speed = self.speed * self.hull;
        (speed * libm::cos(self.heading), speed * libm::sin(self.heading))
    }

    /// Advances by a short time.
    pub(super) fn step(&mut self, order: Order, now_s: f64, dt_s: f64) {
        match order {
            Order::Head(direction) => {
                self.ordered_speed = self.max_speed.min(2.0);
                self.steer_to(direction);
                self.next_order_s = now_s;
            }
            Order::Roam | Order::Loiter => {
                if now_s >= self.next_order_s {
                    self.sample_order(now_s);
                }
                if order == Order::Loiter {
                    self.ordered_speed = self.ordered_speed.min(MIN_SPEED);
                }
                let from_home = self.at.distance(PlanePoint::default());
                if self.home_radius.is_some_and(|radius| from_home > radius) {
                    self.steer_to(libm::atan2(-self.at.y, -self.at.x));
                    self.ordered_speed = self.ordered_speed.max(MIN_SPEED);
                }
            }
        }
        self.turn += (self.ordered_turn - self.turn) * (dt_s / TURN_LAG_S);
        self.speed += (self.ordered_speed - self.speed) * (dt_s / SPEED_LAG_S);
        self.heading += self.turn * (self.speed / (self.speed + 0.15)) * dt_s;
        let (vx, vy) = self.velocity();
        self.at = self.at.offset(vx * dt_s, vy * dt_s);
    }

    fn sample_order(&mut self, now_s: f64) {
        if self.rng.chance(0.15) {
            self.ordered_speed = 0.0;
            self.ordered_turn = 0.0;
            self.next_order_s = now_s + self.rng.between(2.0, 4.0);
            return;
        }
        self.ordered_speed = self.rng.between(MIN_SPEED, self.max_speed);
        let hard = self.rng.chance(0.3);
        let share = if hard { self.rng.between(0.6, 1.0) } else { self.rng.between(0.0, 0.4) };
        self.ordered_turn = MAX_TURN_RATE * share * self.rng.sign();
        self.next_order_s =
            now_s + if hard { self.rng.between(0.8, 2.5) } else { self.rng.between(1.0, 3.5) };
    }

    fn steer_to(&mut self, direction: f64) {
        let off = wrap_angle(direction - self.heading);
        self.ordered_turn = (STEERING_GAIN * off).clamp(-MAX_TURN_RATE, MAX_TURN_RATE);
    }
}

/// The same angle within -pi to pi.
fn wrap_angle(radians: f64) -> f64 {
    libm::atan2(libm::sin(radians), libm::cos(radians))
}
