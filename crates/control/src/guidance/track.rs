//! Position, velocity and heading of the boat over the water plane, from delayed fixes.
//!
//! A Kalman filter with the state (x, y, vx, vy). Between two fixes the velocity turns by the turn that the vessel's model
//! predicts from the commands in force, and a white acceleration of density q (m/s² per root hertz) disturbs it:
//!
//! ```text
//! v' = R(turn) v        p' = p + dt R(turn / 2) v
//! Q = q² [dt³/3, dt²/2; dt²/2, dt]   for each axis
//! ```
//!
//! The turn is that of the time of capture, looked up in a history, so that the video latency does not enter; a
//! prediction to the present continues with the commands given since (`smith1957`). The current is part of the velocity.
//! The heading is the integrated turn, corrected by the tracker's heading, or by the course while the boat moves. The tracker
//! takes the end of the boat that goes first for the bow: of a boat that goes astern, or is set by waves and wind, it reports the
//! stern. So the tracker's heading counts as an axis. Its end is the one near the course of a boat that goes ahead by the model, or
//! else the one near the heading so far.
//!
//! An innovation of more than [`INNOVATION_GATE`] standard deviations is shortened to that. Work: O(1) per step, with one
//! search in the history of [`HISTORY_LEN`] entries; no allocation after construction.

use barrelman_vocab::{Angle, Timestamp, VesselCommand, WaterPoint};

use super::input::BoatFix;
use super::tuning::{LineOfSightTuning, VesselModel};
use crate::ring::Ring;
use crate::wrapped::wrapped;

/// Largest innovation, in standard deviations of its expected length.
const INNOVATION_GATE: f64 = 4.0;
/// Stored states of the model; at [`MIN_INTERVAL_S`] they cover 2 s.
const HISTORY_LEN: usize = 128;
/// Shortest interval between two stored states, seconds.
const MIN_INTERVAL_S: f64 = 0.016;
/// Standard deviation of each component of the velocity before the second fix, m/s.
const INITIAL_SPEED_M_PER_S: f64 = 0.7;
/// The filter starts anew after a gap of this length, seconds.
const MAX_GAP_S: f64 = 3.0;
/// Growth of the heading's variance, rad² per second, and variance beyond which the heading is unknown, rad².
const HEADING_NOISE: f64 = 0.01;
const MAX_HEADING_VARIANCE: f64 = 0.6;
/// Standard deviation of the course as a heading, radians: the crab angle.
const CRAB_RAD: f64 = 0.35;

/// The boat at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoatState {
    /// Where the boat is.
    pub point: WaterPoint,
    /// Velocity over ground along x and y, m/s.
    pub velocity: (f64, f64),
    /// Where the bow points, if known.
    pub heading: Option<Angle>,
    /// Angle by which the course goes on turning with the rudder amidships, by the model, radians, positive to the right.
    pub turn_to_come: f64,
    /// Modelled thrust as a throttle.
    pub thrust: f64,
    /// Modelled speed through the water, m/s.
    pub surge: f64,
}

impl BoatState {
    /// Speed over ground, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        let (x, y) = self.velocity;
        libm::sqrt(x * x + y * y)
    }

    /// Direction of the velocity.
    pub fn course(&self) -> Angle {
        Angle::from_radians(libm::atan2(self.velocity.0, self.velocity.1))
    }
}

/// State of the vessel's model.
#[derive(Debug, Clone, Copy)]
struct Motion {
    at_s: f64,
    /// Integral of the turn rate of the course, radians.
    turned: f64,
    /// Turn rate of the bow, and of the course, rad/s.
    yaw: f64,
    turn: f64,
    thrust: f64,
    /// Speed through the water, m/s.
    surge: f64,
}

/// The estimate at the time of the last fix.
#[derive(Debug, Clone, Copy)]
struct Estimate {
    at_s: f64,
    state: [f64; 4],
    covariance: [[f64; 4]; 4],
}

#[derive(Debug, Clone, Copy)]
struct Heading {
    at_s: f64,
    angle: f64,
    variance: f64,
}

/// The track of the boat.
#[derive(Debug, Clone)]
pub struct BoatTrack {
    model: VesselModel,
    acceleration_noise: f64,
    min_variance: f64,
    course_speed: f64,
    way_speed: f64,
    command: VesselCommand,
    motion: Ring<Motion, HISTORY_LEN>,
    estimate: Option<Estimate>,
    heading: Option<Heading>,
    arrived: Option<Timestamp>,
}

impl BoatTrack {
    /// A track without fixes.
    pub fn new(model: VesselModel, tuning: &LineOfSightTuning) -> Self {
        Self {
            model,
            acceleration_noise: tuning.acceleration_noise,
            min_variance: tuning.min_fix_std_dev_m * tuning.min_fix_std_dev_m,
            course_speed: tuning.course_speed_m_per_s,
            way_speed: tuning.way_speed_m_per_s,
            command: VesselCommand::NEUTRAL,
            motion: Ring::new(Motion {
                at_s: f64::NEG_INFINITY,
                turned: 0.0,
                yaw: 0.0,
                turn: 0.0,
                thrust: 0.0,
                surge: 0.0,
            }),
            estimate: None,
            heading: None,
            arrived: None,
        }
    }

    /// Discards all fixes: another boat was selected.
    pub const fn reset(&mut self) {
        self.estimate = None;
        self.heading = None;
        self.arrived = None;
    }

    /// Advances the vessel's model to `now` under the command in force.
    pub fn advance_to(&mut self, now: Timestamp) {
        let (now_s, last) = (now.as_secs_f64(), *self.motion.newest());
        if now_s <= last.at_s {
            return;
        }
        let speed = self.estimate.map_or(0.0, |estimate| libm::hypot(estimate.state[2], estimate.state[3]));
        let next = if last.at_s == f64::NEG_INFINITY {
            Motion { at_s: now_s, ..last }
        } else {
            let duration_s = now_s - last.at_s;
            let kept = libm::exp(-duration_s / self.model.thrust_lag_s);
            let thrust = self.command.throttle + kept * (last.thrust - self.command.throttle);
            let authority = self.model.turn_authority(0.5 * (thrust + last.thrust), speed);
            let set_point = authority * self.command.rudder;
            let kept = libm::exp(-duration_s / self.model.yaw_lag_s);
            let yaw = set_point + kept * (last.yaw - set_point);
            let mean_yaw = 0.5 * (yaw + last.yaw);
            let kept = libm::exp(-duration_s / self.model.surge_lag_s);
            let ahead = self.model.speed_per_throttle * thrust;
            let surge = ahead + kept * (last.surge - ahead);
            let kept = libm::exp(-duration_s / self.model.drift_lag_s);
            let excess = last.turn - mean_yaw;
            Motion {
                at_s: now_s,
                turned: last.turned + mean_yaw * duration_s + excess * self.model.drift_lag_s * (1.0 - kept),
                yaw,
                turn: mean_yaw + excess * kept,
                thrust,
                surge,
            }
        };
        self.motion.push(next, |previous, newest| newest.at_s - previous.at_s >= MIN_INTERVAL_S);
    }

    /// Puts a command in force from `now` on.
    pub fn apply_command(&mut self, command: VesselCommand, now: Timestamp) {
        self.advance_to(now);
        self.command = command.clamped();
    }

    /// Processes a fix that arrived at `now`. A fix that is not later than the last one, or not finite, is ignored.
    pub fn observe(&mut self, fix: &BoatFix, now: Timestamp) {
        let at_s = fix.captured.as_secs_f64();
        let WaterPoint { x, y } = fix.water.point;
        let covariance = fix.water.covariance;
        let noise = [
            [covariance.xx + self.min_variance, covariance.xy],
            [covariance.xy, covariance.yy + self.min_variance],
        ];
        if !(x.is_finite() && y.is_finite() && noise.as_flattened().iter().all(|value| value.is_finite())) {
            return;
        }
        let is_continued = self.estimate.is_some_and(|last| at_s - last.at_s < MAX_GAP_S);
        match self.estimate {
            Some(last) if at_s <= last.at_s => return,
            Some(last) if is_continued => {
                let turn = self.turned_at(at_s) - self.turned_at(last.at_s);
                let expected = last.propagated(at_s, turn, self.acceleration_noise);
                self.estimate = Some(expected.updated([x, y], &noise));
            }
            _ => {
                let speed = INITIAL_SPEED_M_PER_S * INITIAL_SPEED_M_PER_S;
                let mut covariance = [[0.0; 4]; 4];
                covariance[0][..2].copy_from_slice(&noise[0]);
                covariance[1][..2].copy_from_slice(&noise[1]);
                covariance[2][2] = speed;
                covariance[3][3] = speed;
                self.estimate = Some(Estimate { at_s, state: [x, y, 0.0, 0.0], covariance });
            }
        }
        self.arrived = Some(now);
        self.observe_heading(fix, at_s);
    }

    /// The time at which the last fix arrived, and the boat predicted to `now`.
    pub fn predicted(&self, now: Timestamp) -> Option<(Timestamp, BoatState)> {
        let (estimate, arrived) = (self.estimate?, self.arrived?);
        let (now_s, motion) = (now.as_secs_f64(), self.motion.newest());
        let turn = motion.turned - self.turned_at(estimate.at_s);
        let [x, y, vx, vy] = estimate.state;
        let duration_s = (now_s - estimate.at_s).max(0.0);
        let half = turned((vx, vy), 0.5 * turn);
        let state = BoatState {
            point: WaterPoint { x: x + duration_s * half.0, y: y + duration_s * half.1 },
            velocity: turned((vx, vy), turn),
            heading: self.heading.filter(|heading| heading.variance < MAX_HEADING_VARIANCE).map(|heading| {
                Angle::from_radians(wrapped(heading.angle + motion.turned - self.turned_at(heading.at_s)))
            }),
            turn_to_come: self.model.yaw_lag_s * motion.yaw + self.model.drift_lag_s * motion.turn,
            thrust: motion.thrust,
            surge: motion.surge,
        };
        Some((arrived, state))
    }

    /// Time of capture of the last fix.
    pub fn captured(&self) -> Option<Timestamp> {
        self.estimate.map(|estimate| Timestamp::from_secs_f64(estimate.at_s))
    }

    fn observe_heading(&mut self, fix: &BoatFix, at_s: f64) {
        let Some(estimate) = self.estimate else { return };
        let motion = self.motion_at(at_s);
        if let Some(last) = &mut self.heading {
            let turn = motion.turned - turned_at(&self.motion, last.at_s);
            *last = Heading {
                at_s,
                angle: last.angle + turn,
                variance: last.variance + HEADING_NOISE * (at_s - last.at_s).max(0.0),
            };
        }
        let [_, _, vx, vy] = estimate.state;
        let squared_speed = vx * vx + vy * vy;
        let of_tracker = fix
            .heading
            .map(|(angle, std_dev)| (angle.radians(), std_dev.radians() * std_dev.radians()))
            .filter(|(angle, variance)| angle.is_finite() && *variance > 0.0);
        let is_moving =
            motion.surge > self.way_speed && squared_speed > self.course_speed * self.course_speed;
        let of_course = is_moving.then(|| {
            let velocity_variance = estimate.covariance[2][2] + estimate.covariance[3][3];
            (libm::atan2(vx, vy), CRAB_RAD * CRAB_RAD + velocity_variance / squared_speed)
        });
        let of_way_ahead = of_course.filter(|_| motion.thrust > 0.0).map(|(course, _)| course);
        let of_past = self.heading.filter(|last| last.variance < MAX_HEADING_VARIANCE).map(|last| last.angle);
        let of_tracker = match of_way_ahead.or(of_past) {
            Some(bow) => of_tracker.map(|(angle, variance)| (end_near(angle, bow), variance)),
            // Nothing tells the ends of a boat apart that may go astern.
            None => of_tracker.filter(|_| motion.surge >= 0.0),
        };
        for (angle, variance) in of_tracker.into_iter().chain(of_course) {
            let gained = self.heading.map_or(1.0, |last| last.variance / (last.variance + variance));
            let before = self.heading.map_or(angle, |last| last.angle);
            let kept_variance = self.heading.map_or(variance, |last| (1.0 - gained) * last.variance);
            self.heading = Some(Heading {
                at_s,
                angle: wrapped(before + gained * wrapped(angle - before)),
                variance: kept_variance,
            });
        }
    }

    fn turned_at(&self, at_s: f64) -> f64 {
        turned_at(&self.motion, at_s)
    }

    fn motion_at(&self, at_s: f64) -> Motion {
        motion_at(&self.motion, at_s)
    }
}

impl VesselModel {
    /// Turn rate at full rudder, rad/s.
    pub(super) fn turn_authority(&self, thrust: f64, speed_m_per_s: f64) -> f64 {
        self.turn_per_throttle * thrust.max(0.0) + self.turn_per_speed * speed_m_per_s
    }
}

fn turned_at(motion: &Ring<Motion, HISTORY_LEN>, at_s: f64) -> f64 {
    motion_at(motion, at_s).turned
}

/// The interpolated state of the model at a time; the newest or the oldest stored state beyond the history.
fn motion_at(motion: &Ring<Motion, HISTORY_LEN>, at_s: f64) -> Motion {
    let mut later = motion.newest();
    if at_s >= later.at_s {
        return *later;
    }
    for earlier in motion.earlier() {
        if earlier.at_s <= at_s {
            if earlier.at_s == f64::NEG_INFINITY {
                break;
            }
            let share = (at_s - earlier.at_s) / (later.at_s - earlier.at_s);
            let mix = |a: f64, b: f64| a + share * (b - a);
            return Motion {
                at_s,
                turned: mix(earlier.turned, later.turned),
                yaw: mix(earlier.yaw, later.yaw),
                turn: mix(earlier.turn, later.turn),
                thrust: mix(earlier.thrust, later.thrust),
                surge: mix(earlier.surge, later.surge),
            };
        }
        later = earlier;
    }
    *later
}

impl Estimate {
    /// The prediction step of the filter.
    fn propagated(&self, at_s: f64, turn: f64, acceleration_noise: f64) -> Self {
        let duration_s = at_s - self.at_s;
        let [x, y, vx, vy] = self.state;
        let half = turned((vx, vy), 0.5 * turn);
        let velocity = turned((vx, vy), turn);
        // The covariance ignores the turn, which is small between two fixes.
        let p = &self.covariance;
        let mut next = *p;
        for i in 0..2 {
            for j in 0..2 {
                next[i][j] = p[i][j]
                    + duration_s * (p[i][j + 2] + p[i + 2][j])
                    + duration_s * duration_s * p[i + 2][j + 2];
                next[i][j + 2] = p[i][j + 2] + duration_s * p[i + 2][j + 2];
                next[i + 2][j] = p[i + 2][j] + duration_s * p[i + 2][j + 2];
            }
        }
        let density = acceleration_noise * acceleration_noise;
        for i in 0..2 {
            next[i][i] += density * duration_s * duration_s * duration_s / 3.0;
            next[i][i + 2] += 0.5 * density * duration_s * duration_s;
            next[i + 2][i] += 0.5 * density * duration_s * duration_s;
            next[i + 2][i + 2] += density * duration_s;
        }
        let state = [x + duration_s * half.0, y + duration_s * half.1, velocity.0, velocity.1];
        Self { at_s, state, covariance: next }
    }

    /// The update step of the filter.
    fn updated(&self, measured: [f64; 2], noise: &[[f64; 2]; 2]) -> Self {
        let p = &self.covariance;
        let s = [0, 1].map(|i| [0, 1].map(|j| p[i][j] + noise[i][j]));
        let scale = 1.0 / (s[0][0] * s[1][1] - s[0][1] * s[1][0]);
        let back = [[scale * s[1][1], -scale * s[0][1]], [-scale * s[1][0], scale * s[0][0]]];
        let off = [measured[0] - self.state[0], measured[1] - self.state[1]];
        let squared = off[0] * (back[0][0] * off[0] + back[0][1] * off[1])
            + off[1] * (back[1][0] * off[0] + back[1][1] * off[1]);
        let share = if squared > INNOVATION_GATE * INNOVATION_GATE {
            INNOVATION_GATE / libm::sqrt(squared)
        } else {
            1.0
        };
        let off = off.map(|value| share * value);
        let gains: [[f64; 2]; 4] =
            [0, 1, 2, 3].map(|i| [0, 1].map(|j| p[i][0] * back[0][j] + p[i][1] * back[1][j]));
        let state = [0, 1, 2, 3].map(|i| self.state[i] + gains[i][0] * off[0] + gains[i][1] * off[1]);
        let covariance = [0, 1, 2, 3]
            .map(|i| [0, 1, 2, 3].map(|j| p[i][j] - gains[i][0] * p[0][j] - gains[i][1] * p[1][j]));
        Self { at_s: self.at_s, state, covariance }
    }
}

/// The end of an axis that points nearer to a direction: the angle itself, or the opposite one, radians.
fn end_near(angle: f64, direction: f64) -> f64 {
    if wrapped(angle - direction).abs() > core::f64::consts::FRAC_PI_2 {
        angle + core::f64::consts::PI
    } else {
        angle
    }
}

/// A vector (x right, y ahead) turned to the right.
fn turned((x, y): (f64, f64), angle: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(angle);
    (x * cos + y * sin, y * cos - x * sin)
}
