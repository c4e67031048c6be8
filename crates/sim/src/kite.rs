//! A tethered kite in the wind: a small UAV that holds the direction and the length of its tether, not a
//! position.
//!
//! The kite hangs at the end of a tether of length l, at a fixed elevation from its anchor. Three offsets
//! describe its motion: two of the tether's direction (q, in the vertical plane of the tether and across it),
//! and one of its length (dl):
//!
//! ```text
//! q''  = -w^2 q - 2 z w q' + a / l        each direction, a: acceleration by the wind across the tether
//! dl'' = -(k/m) max(0, dl) - (c/m) dl' + a_l
//! ```
//!
//! A gust v' in a mean wind V causes the acceleration `a = rho CdA |V| v' / m`. The parameters are
//! engineering values; they give a sway of 0.2 m RMS in a wind of 5 m/s, with a period of about 6 s. The yaw
//! varies, because the kite has no compass, and drifts while it is commanded. The body leans to accelerate; a
//! small share of the lean passes through the gimbal. Not modelled: sag and drag of the tether, downwash of
//! the rotors.

use barrelman_vocab::Angle;

use crate::pose::WorldPoint;
use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::tick::{TICK_S, TICKS_PER_SECOND};
use crate::wind::TurbulentWind;

/// Mass, kg, and drag area, m².
const MASS_KG: f64 = 0.8;
const DRAG_AREA_M2: f64 = 0.03;
const AIR_KG_PER_M3: f64 = 1.225;
/// Natural frequency of the direction control, rad/s, and its damping ratio.
const HOLD_RAD_PER_S: f64 = 1.0;
const HOLD_DAMPING: f64 = 0.5;
/// Stiffness of the tether, N/m, and its damping, N s/m.
const TETHER_N_PER_M: f64 = 20.0;
const TETHER_N_S_PER_M: f64 = 5.0;
/// Elevation of the kite from its anchor.
const ELEVATION_DEG: f64 = 70.0;
const GRAVITY: f64 = 9.81;
/// Share of the body's lean that passes through the gimbal.
const GIMBAL_LEAK: f64 = 0.05;
/// Variation of the yaw, and its drift while it is commanded.
const YAW: OrnsteinUhlenbeck = OrnsteinUhlenbeck { std_dev: 2.0_f64.to_radians(), time_constant_s: 8.0 };
const YAW_DRIFT_RAD_PER_S: f64 = 0.2_f64.to_radians();
/// Residual vibration of each axis of the gimbal.
const JITTER: OrnsteinUhlenbeck = OrnsteinUhlenbeck { std_dev: 0.05_f64.to_radians(), time_constant_s: 0.03 };

/// A kite on its tether.
#[derive(Debug, Clone)]
pub struct Kite {
    length_m: f64,
    /// Unit vectors: along the tether, upwards in its vertical plane, and across.
    tether: WorldPoint,
    upwards: WorldPoint,
    across: WorldPoint,
    wind: TurbulentWind,
    /// Offset and its rate: upwards (rad), across (rad), length (m).
    offsets: [(f64, f64); 3],
    push: (f64, f64),
    yaw: OrnsteinUhlenbeckProcess,
    drift: f64,
    drift_sign: f64,
    jitter: [OrnsteinUhlenbeckProcess; 3],
}

impl Kite {
    /// A kite at this height, downwind of its anchor.
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
            tether: WorldPoint { x: ce * cw, y: ce * sw, z: se },
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

    /// Advances by a tick, in which the yaw is commanded or not.
    pub fn advance(&mut self, tick: u64, yaw_commanded: bool) {
        self.wind.advance(tick);
        self.yaw.advance(tick);
        for axis in &mut self.jitter {
            axis.advance(tick);
        }
        if yaw_commanded {
            self.drift += self.drift_sign * YAW_DRIFT_RAD_PER_S * TICK_S;
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
        // A slack tether does not pull: the kite's thrust restores the length as softly as the direction.
        let pull = if stretch.0 > 0.0 { TETHER_N_PER_M / MASS_KG } else { w * w };
        let acceleration = a.dot(self.tether) - pull * stretch.0 - TETHER_N_S_PER_M / MASS_KG * stretch.1;
        stretch.1 += acceleration * TICK_S;
        stretch.0 += stretch.1 * TICK_S;
    }

    /// Displacement from the mean position.
    pub fn displacement(&self) -> WorldPoint {
        let [(up, _), (across, _), (stretch, _)] = self.offsets;
        let (up, across) = (up * self.length_m, across * self.length_m);
        let mix = |u: f64, a: f64, l: f64| up * u + across * a + stretch * l;
        WorldPoint {
            x: mix(self.upwards.x, self.across.x, self.tether.x),
            y: mix(self.upwards.y, self.across.y, self.tether.y),
            z: mix(self.upwards.z, self.across.z, self.tether.z),
        }
    }

    /// Offset of the attitude of a camera that looks along `pan`: yaw to the right, pitch upwards, roll with
    /// the right side sinking.
    pub fn attitude_offset(&self, pan: Angle) -> (Angle, Angle, Angle) {
        let (sp, cp) = libm::sincos(pan.radians());
        let lean_ahead = (self.push.0 * sp + self.push.1 * cp) / GRAVITY;
        let lean_right = (self.push.0 * cp - self.push.1 * sp) / GRAVITY;
        let [yaw, pitch, roll] = &self.jitter;
        (
            Angle::from_radians(self.yaw.value() + self.drift + yaw.value()),
            Angle::from_radians(GIMBAL_LEAK * lean_ahead + pitch.value()),
            Angle::from_radians(-GIMBAL_LEAK * lean_right + roll.value()),
        )
    }
}

/// Ticks until a kite that starts at rest sways as in steady wind.
pub const SETTLING_TICKS: u64 = 20 * TICKS_PER_SECOND as u64;
