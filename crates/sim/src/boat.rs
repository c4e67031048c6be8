//! A small rescue boat with a jet, in the class of EMILY: 1.2 m long, 11.3 kg, about 9.5 m/s at full
//! throttle.
//!
//! Three degrees of freedom in the body's frame (u ahead, v to the left, r anticlockwise), relative to water
//! that moves with the waves. The manoeuvring model follows `fossen2011`; the coefficients come from
//! comparison with craft of this size:
//!
//! ```text
//! m11 u' =  T cos d - R(u) + m22 v r            + X_wind
//! m22 v' = -T sin d + (Yv + Yuv |u|) v + Yvv |v| v - m11 u r  + Y_wind
//! m33 r' =  T sin d l_j + (Nr + Nur |u|) r + Nrr |r| r - 0.35 (m22 - m11) u v + N_wind
//! ```
//!
//! T is the thrust of the jet, d the angle of its nozzle. The resistance R grows up to the hump speed and is
//! nearly flat above it: the boat planes. **A jet does not steer without thrust**: a coasting boat goes
//! straight on. (The paper's simulated boat has a rudder, which steers whenever the boat moves:
//! [`Steering::JetAndRudder`].) Above about 4 m/s the hull is unstable in sway and yaw and must be steered to
//! hold its course.
//!
//! Heave, pitch and roll follow the waves, averaged over the hull, through second-order responses. Speed
//! lifts the bow, and the boat heels in turns. Not modelled: slamming, broaching, capsizing, cavitation, yaw
//! moments of the waves.

use barrelman_vocab::{Angle, VesselCommand};

use crate::pose::{BodyPose, WorldPoint};
use crate::sea::Sea;
use crate::tick::TICK_S;

/// Length, breadth and draught of the hull, metres.
pub const LENGTH_M: f64 = 1.2;
/// See [`LENGTH_M`].
pub const BREADTH_M: f64 = 0.36;
const DRAUGHT_M: f64 = 0.08;

const MASS_KG: f64 = 11.3;
/// Masses including the added mass of the water, kg and kg m².
const M11: f64 = MASS_KG + 1.1;
const M22: f64 = MASS_KG + 8.5;
const M33: f64 = 1.02 + 0.9;
/// Resistance ahead: linear and quadratic coefficient up to the hump speed, and the slope above it.
const R_LINEAR: f64 = 2.5;
const R_SQUARE: f64 = 2.2;
const HUMP_MPS: f64 = 3.0;
const R_PLANING: f64 = 1.25;
/// Damping in sway and yaw.
const Y_V: f64 = -16.0;
const Y_UV: f64 = -9.0;
const Y_VV: f64 = -40.0;
const N_R: f64 = -2.4;
const N_UR: f64 = -1.8;
const N_RR: f64 = -2.0;
const MUNK: f64 = 0.35;
/// Full thrust at rest, N; the speed at which the jet gives no thrust, m/s; full thrust astern, N.
const THRUST_N: f64 = 52.0;
const JET_MPS: f64 = 30.0;
const ASTERN_N: f64 = 18.0;
/// Distance of the jet behind the centre of mass, metres, and the largest angle of the nozzle.
const LEVER_M: f64 = 0.58;
const NOZZLE_RAD: f64 = 27.0_f64.to_radians();
/// A rudder beside the jet: force for each (m/s)² of speed through the water at full rudder, N, as a low
/// plate of 60 cm² with a lift coefficient of 1 gives. It moves with the nozzle, at the same place.
const RUDDER_N_PER_M2_PER_S2: f64 = 0.5 * 1000.0 * 0.006;
/// Time constants of throttle and nozzle, seconds.
const THROTTLE_S: f64 = 0.25;
const NOZZLE_S: f64 = 0.15;
/// Air density; drag areas ahead and sideways, including their coefficients; lever of the sideways force.
const AIR_KG_PER_M3: f64 = 1.225;
const DRAG_AHEAD_M2: f64 = 0.6 * 0.05;
const DRAG_ASIDE_M2: f64 = 0.9 * 0.2;
const WIND_LEVER_M: f64 = 0.1 * LENGTH_M;
/// Responses to the waves: natural frequency, rad/s, and damping ratio.
const HEAVE: (f64, f64) = (11.6, 0.3);
const PITCH: (f64, f64) = (15.0, 0.4);
const ROLL: (f64, f64) = (8.6, 0.2);
/// The bow rises with speed, up to a limit; the boat heels with the turn rate.
const TRIM_RAD_PER_MPS: f64 = 2.0_f64.to_radians();
const MAX_TRIM_RAD: f64 = 6.0_f64.to_radians();
const HEEL_S: f64 = 8.0_f64.to_radians();
/// The averaging of the waves over the hull depends on the heading only and is computed every this many
/// ticks.
const AVERAGING_TICKS: u64 = 6;

/// A command to the boat.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HelmCommand {
    /// -1 (full astern) to 1 (full ahead).
    pub throttle: f64,
    /// -1 (right) to 1 (left), as a share of the nozzle's largest angle.
    pub rudder: f64,
}

impl HelmCommand {
    /// The helm of a command to a vessel, whose rudder is positive to the right.
    pub fn of(command: VesselCommand) -> Self {
        Self { throttle: command.throttle, rudder: -command.rudder }
    }
}

/// What steers the boat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Steering {
    /// The nozzle of the jet alone: nothing steers a coasting boat.
    #[default]
    Jet,
    /// The nozzle, and a rudder that steers whenever the boat moves through the water.
    JetAndRudder,
}

/// A boat under way.
#[derive(Debug, Clone)]
pub struct JetBoat {
    steering: Steering,
    position: (f64, f64),
    heading: f64,
    /// Velocity over ground in the body's frame: ahead, left; and turn rate.
    velocity: (f64, f64),
    turn: f64,
    throttle: f64,
    nozzle: f64,
    heave: SecondOrderResponse,
    pitch: SecondOrderResponse,
    roll: SecondOrderResponse,
    averages: Vec<f64>,
}

/// A second-order response.
#[derive(Debug, Clone, Copy, Default)]
struct SecondOrderResponse {
    value: f64,
    rate: f64,
}

impl SecondOrderResponse {
    /// Advances by a tick towards a set point.
    fn follow(&mut self, set_point: f64, (frequency, damping): (f64, f64)) {
        let acceleration =
            frequency * frequency * (set_point - self.value) - 2.0 * damping * frequency * self.rate;
        self.rate += acceleration * TICK_S;
        self.value += self.rate * TICK_S;
    }
}

impl JetBoat {
    /// A boat at rest.
    pub fn at_rest(position: (f64, f64), heading: Angle) -> Self {
        Self {
            steering: Steering::Jet,
            position,
            heading: heading.radians(),
            velocity: (0.0, 0.0),
            turn: 0.0,
            throttle: 0.0,
            nozzle: 0.0,
            heave: SecondOrderResponse::default(),
            pitch: SecondOrderResponse::default(),
            roll: SecondOrderResponse::default(),
            averages: Vec::new(),
        }
    }

    /// The same boat with another steering.
    #[must_use]
    pub fn with_steering(self, steering: Steering) -> Self {
        Self { steering, ..self }
    }

    /// The same boat with this velocity over ground along the world's x and y, m/s.
    #[must_use]
    pub fn with_velocity(self, (x, y): (f64, f64)) -> Self {
        let (s, c) = libm::sincos(self.heading);
        Self { velocity: (x * c + y * s, -x * s + y * c), ..self }
    }

    /// Advances by a tick. `wind` is along the world's x and y, m/s.
    pub fn advance(&mut self, helm: HelmCommand, sea: &Sea, wind: (f64, f64), tick: u64) {
        self.throttle += (helm.throttle.clamp(-1.0, 1.0) - self.throttle) * TICK_S / THROTTLE_S;
        self.nozzle += (helm.rudder.clamp(-1.0, 1.0) * NOZZLE_RAD - self.nozzle) * TICK_S / NOZZLE_S;
        let water = self.advance_on_waves(sea, tick);
        let (s, c) = libm::sincos(self.heading);
        let in_body = |(x, y): (f64, f64)| (x * c + y * s, -x * s + y * c);
        let current = in_body(water);
        let (u, v, r) = (self.velocity.0 - current.0, self.velocity.1 - current.1, self.turn);
        let air = in_body(wind);
        let (air_u, air_v) = (air.0 - self.velocity.0, air.1 - self.velocity.1);
        let blown = |area: f64, speed: f64| 0.5 * AIR_KG_PER_M3 * area * speed * speed.abs();
        let (x_wind, y_wind) = (blown(DRAG_AHEAD_M2, air_u), blown(DRAG_ASIDE_M2, air_v));
        let thrust = thrust(self.throttle, u);
        let (sd, cd) = libm::sincos(self.nozzle);
        let (thrust_aside, rudder_drag) = match self.steering {
            Steering::Jet => (thrust * sd, 0.0),
            Steering::JetAndRudder => {
                let lift = RUDDER_N_PER_M2_PER_S2 * u * u.abs() * (self.nozzle / NOZZLE_RAD);
                (thrust * sd + lift, lift * sd)
            }
        };
        let du = (thrust * cd - resistance(u) - rudder_drag + M22 * v * r + x_wind) / M11;
        let dv =
            (-thrust_aside + (Y_V + Y_UV * u.abs()) * v + Y_VV * v.abs() * v - M11 * u * r + y_wind) / M22;
        let dr = (thrust_aside * LEVER_M + (N_R + N_UR * u.abs()) * r + N_RR * r.abs() * r
            - MUNK * (M22 - M11) * u * v
            + WIND_LEVER_M * y_wind)
            / M33;
        self.velocity.0 += du * TICK_S;
        self.velocity.1 += dv * TICK_S;
        self.turn += dr * TICK_S;
        self.heading += self.turn * TICK_S;
        let (vx, vy) = self.velocity_over_ground();
        self.position.0 += vx * TICK_S;
        self.position.1 += vy * TICK_S;
    }

    /// Advances heave, pitch and roll by a tick. Returns the velocity of the water at the boat along the
    /// world's x and y, m/s.
    fn advance_on_waves(&mut self, sea: &Sea, tick: u64) -> (f64, f64) {
        let (s, c) = libm::sincos(self.heading);
        let waves = sea.waves();
        let is_due = tick.is_multiple_of(AVERAGING_TICKS) || self.averages.len() != waves.len();
        if is_due {
            self.averages.clear();
            self.averages.extend(waves.iter().map(|wave| {
                let (kx, ky) = wave.vector;
                let (along, across) = (kx * c + ky * s, -kx * s + ky * c);
                sinc(0.5 * along * LENGTH_M)
                    * sinc(0.5 * across * BREADTH_M)
                    * libm::exp(-libm::hypot(kx, ky) * DRAUGHT_M)
            }));
        }
        let (mut elevation, mut slope, mut water) = (0.0, (0.0, 0.0), (0.0, 0.0));
        for (wave, average) in waves.iter().zip(&self.averages) {
            let (sin, cos) = libm::sincos(wave.phase_at(self.position.0, self.position.1, tick));
            let amplitude = wave.amplitude * average;
            elevation += amplitude * cos;
            slope.0 -= amplitude * wave.vector.0 * sin;
            slope.1 -= amplitude * wave.vector.1 * sin;
            let (x, y) = wave.crest_velocity();
            water.0 += average * x * cos;
            water.1 += average * y * cos;
        }
        let along = slope.0 * c + slope.1 * s;
        let to_left = -slope.0 * s + slope.1 * c;
        let trim = (TRIM_RAD_PER_MPS * self.velocity.0).clamp(0.0, MAX_TRIM_RAD);
        self.heave.follow(elevation, HEAVE);
        self.pitch.follow(along + trim, PITCH);
        // Water that climbs to the left lifts the left side, so that the right side sinks.
        self.roll.follow(to_left - HEEL_S * self.turn, ROLL);
        let (x, y) = sea.current();
        (water.0 + x, water.1 + y)
    }

    /// Position and attitude.
    pub const fn pose(&self) -> BodyPose {
        BodyPose {
            position: WorldPoint { x: self.position.0, y: self.position.1, z: self.heave.value },
            heading: Angle::from_radians(self.heading),
            pitch: Angle::from_radians(self.pitch.value),
            roll: Angle::from_radians(self.roll.value),
        }
    }

    /// Velocity over ground along the world's x and y, m/s.
    pub fn velocity_over_ground(&self) -> (f64, f64) {
        let (s, c) = libm::sincos(self.heading);
        let (u, v) = self.velocity;
        (u * c - v * s, u * s + v * c)
    }

    /// Speed over ground along the bow, m/s.
    pub const fn speed_ahead_mps(&self) -> f64 {
        self.velocity.0
    }

    /// Turn rate, rad/s, anticlockwise.
    pub const fn turn_rad_per_s(&self) -> f64 {
        self.turn
    }

    /// Throttle, -1 to 1, and angle of the nozzle, positive to turn left.
    pub const fn jet(&self) -> (f64, Angle) {
        (self.throttle, Angle::from_radians(self.nozzle))
    }
}

/// Thrust at a throttle (-1 to 1) and a speed ahead (m/s), N.
fn thrust(throttle: f64, u: f64) -> f64 {
    if throttle >= 0.0 {
        THRUST_N * throttle * throttle * (1.0 - u / JET_MPS)
    } else {
        -ASTERN_N * throttle * throttle
    }
}

/// Resistance at a speed ahead (m/s), N.
fn resistance(u: f64) -> f64 {
    let speed = u.abs();
    let slow = speed.min(HUMP_MPS);
    let resistance = R_LINEAR * slow + R_SQUARE * slow * slow + R_PLANING * (speed - slow);
    if u < 0.0 { -resistance } else { resistance }
}

/// The throttle that holds a speed (m/s) on calm water, 0 to 1.
pub fn throttle_for_speed(speed_mps: f64) -> f64 {
    let speed = speed_mps.clamp(0.0, 0.9 * JET_MPS);
    libm::sqrt(resistance(speed) / (THRUST_N * (1.0 - speed / JET_MPS))).min(1.0)
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1.0e-4 { 1.0 } else { libm::sin(x) / x }
}
