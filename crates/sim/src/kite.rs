//! A tethered kite in the wind: a small UAV that holds the angle and the length of its line, not a place.
//!
//! It hangs at the end of a line of length l, at an elevation from its anchor. What the wind does to it is described
//! by three deviations: two of the line's direction, in the vertical plane of the line and across it, and one of its
//! length:
//!
//! ```text
//! q''  = -w^2 q - 2 z w q' + a / l        each direction, a the wind's push across the line
//! dl'' = -(k/m) max(0, dl) - (c/m) dl' + a_l
//! ```
//!
//! with the push `a = rho CdA |V| v' / m` of a gust v' in a mean wind V. The numbers are engineering values that give
//! a sway of 0.2 m RMS in a wind of 5 m/s, with a period of about 6 s. Its yaw wanders, for it has no compass lock,
//! and drifts while it is commanded; its body leans into what it must do, of which the camera sees a leak of the
//! gimbal. What is not in here: sag and drag of the line, the rotors' wash.

use barrelman_vocab::Angle;

use crate::pose::WorldPoint;
use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::tick::{TICK_S, TICKS_PER_SECOND};
use crate::wind::TurbulentWind;

/// Mass, kg, and drag area, m².
const MASS_KG: f64 = 0.8;
const DRAG_AREA_M2: f64 = 0.03;
const AIR_KG_PER_M3: f64 = 1.225;
/// Natural frequency of the held direction, rad/s, and its damping ratio.
const HOLD_RAD_PER_S: f64 = 1.0;
const HOLD_DAMPING: f64 = 0.5;
/// The line's stiffness against being stretched, N/m, and damping, N s/m.
const LINE_N_PER_M: f64 = 20.0;
const LINE_N_S_PER_M: f64 = 5.0;
/// How steeply the line rises from its anchor.
const ELEVATION_DEG: f64 = 70.0;
const GRAVITY: f64 = 9.81;
/// Share of the body's lean that the gimbal lets through.
const LEAK: f64 = 0.05;
/// Wander of the yaw, and how fast it drifts while it is commanded.
const YAW: OrnsteinUhlenbeck = OrnsteinUhlenbeck { std_dev: 2.0_f64.to_radians(), time_constant_s: 8.0 };
const DRIFT_RAD_PER_S: f64 = 0.2_f64.to_radians();
/// The shiver of the gimbal: what is left of vibrations, on each axis.
const JITTER: OrnsteinUhlenbeck = OrnsteinUhlenbeck { std_dev: 0.05_f64.to_radians(), time_constant_s: 0.03 };

/// A kite on its line.
#[derive(Debug, Clone)]
pub struct Kite {
    length_m: f64,
    /// Unit vectors: along the line, upwards in its plane, and across it.
    line: WorldPoint,
    upwards: WorldPoint,
    across: WorldPoint,
    wind: TurbulentWind,
    /// Deviation and its rate: upwards, across, length.
    offsets: [(f64, f64); 3],
    push: (f64, f64),
    yaw: OrnsteinUhlenbeckProcess,
    drift: f64,
    drift_sign: f64,
    jitter: [OrnsteinUhlenbeckProcess; 3],
}

impl Kite {
    /// A kite that hangs at that height, leeward of its anchor.
    pub fn new(height_m: f64, wind: TurbulentWind, towards: Angle, seed: u64) -> Self {
        let elevation = Angle::from_degrees(ELEVATION_DEG).radians();
        let (se, ce) = libm::sincos(elevation);
        let (sw, cw) = libm::sincos(towards.radians());
        let rng = CounterRng::new(seed, Stream::SwayYaw);
        let jitter = |which: u64| {
            OrnsteinUhlenbeckProcess::new(
                JITTER,
                CounterRng::new(seed.wrapping_add(which << 48), Stream::GimbalJitter),
            )
        };
        Self {
            length_m: height_m / se,
            line: WorldPoint { x: ce * cw, y: ce * sw, z: se },
            upwards: WorldPoint { x: -se * cw, y: -se * sw, z: ce },
            across: WorldPoint { x: -sw, y: cw, z: 0.0 },
            wind,
            offsets: [(0.0, 0.0); 3],
            push: (0.0, 0.0),
            yaw: OrnsteinUhlenbeckProcess::new(YAW, rng),
            drift: 0.0,
            drift_sign: if rng.unit(u64::MAX) < 0.5 { -1.0 } else { 1.0 },
            jitter: [jitter(0), jitter(1), jitter(2)],
        }
    }

    /// Advances through a tick, in which its yaw is commanded or not.
    pub fn advance(&mut self, tick: u64, yaw_commanded: bool) {
        self.wind.advance(tick);
        self.yaw.advance(tick);
        for axis in &mut self.jitter {
            axis.advance(tick);
        }
        if yaw_commanded {
            self.drift += self.drift_sign * DRIFT_RAD_PER_S * TICK_S;
        }
        let (vx, vy, vz) = self.wind.turbulence();
        let (mx, my) = self.wind.velocity();
        let push = AIR_KG_PER_M3 * DRAG_AREA_M2 * libm::hypot(mx, my) / MASS_KG;
        let a = WorldPoint { x: push * vx, y: push * vy, z: push * vz };
        self.push = (a.x, a.y);
        let (w, z) = (HOLD_RAD_PER_S, HOLD_DAMPING);
        for (state, axis) in self.offsets.iter_mut().zip([self.upwards, self.across]) {
            let acceleration = a.dot(axis) / self.length_m - w * w * state.0 - 2.0 * z * w * state.1;
            state.1 += acceleration * TICK_S;
            state.0 += state.1 * TICK_S;
        }
        let stretch = &mut self.offsets[2];
        // Slack, the line does not pull: the kite's own thrust brings it back as gently as it holds its direction.
        let pull = if stretch.0 > 0.0 { LINE_N_PER_M / MASS_KG } else { w * w };
        let acceleration = a.dot(self.line) - pull * stretch.0 - LINE_N_S_PER_M / MASS_KG * stretch.1;
        stretch.1 += acceleration * TICK_S;
        stretch.0 += stretch.1 * TICK_S;
    }

    /// By what it is displaced from where it should hang.
    pub fn displacement(&self) -> WorldPoint {
        let [(up, _), (across, _), (stretch, _)] = self.offsets;
        let (up, across) = (up * self.length_m, across * self.length_m);
        let mix = |u: f64, a: f64, l: f64| up * u + across * a + stretch * l;
        WorldPoint {
            x: mix(self.upwards.x, self.across.x, self.line.x),
            y: mix(self.upwards.y, self.across.y, self.line.y),
            z: mix(self.upwards.z, self.across.z, self.line.z),
        }
    }

    /// By what its camera, that looks along `pan`, is turned: yaw to the right, pitch upwards, roll with its right
    /// side sinking.
    pub fn attitude_offset(&self, pan: Angle) -> (Angle, Angle, Angle) {
        let (sp, cp) = libm::sincos(pan.radians());
        let lean_ahead = (self.push.0 * sp + self.push.1 * cp) / GRAVITY;
        let lean_right = (self.push.0 * cp - self.push.1 * sp) / GRAVITY;
        let [yaw, pitch, roll] = &self.jitter;
        (
            Angle::from_radians(self.yaw.value() + self.drift + yaw.value()),
            Angle::from_radians(LEAK * lean_ahead + pitch.value()),
            Angle::from_radians(-LEAK * lean_right + roll.value()),
        )
    }
}

/// How many ticks it takes until a kite that was let go at rest sways as the wind makes it.
pub const SETTLING_TICKS: u64 = 20 * TICKS_PER_SECOND as u64;
