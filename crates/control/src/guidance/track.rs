//! Position, velocity and heading of the boat over the water plane, from delayed fixes.
//!
//! A Kalman filter ([`super::estimate`]) for place, velocity and the camera's apparent displacement. Between
//! two fixes the velocity turns by the turn that the vessel's model predicts from the commands in force, and
//! a white acceleration disturbs it.
//!
//! The turn is that of the time of capture, looked up in a history, so that the video latency does not enter;
//! a prediction to the present continues with the commands given since (`smith1957`). The current is part of
//! the velocity. The heading is the integrated turn, corrected by the tracker's heading, or by the course
//! while the boat moves. The tracker takes the end of the boat that goes first for the bow: of a boat that
//! went astern, or was set by waves and wind, while another hand steered it, it reports the stern. So the
//! tracker's heading counts as an axis. Its end is the one near the course of a boat that goes ahead by the
//! model, or else the one near the heading so far. A heading that the boat's answer to its thrust contradicts
//! is corrected ([`AnsweredBow`]).
//!
//! Work: O(1) per step, with one search in the history of [`HISTORY_LEN`] entries; no allocation after
//! construction.

use barrelman_vocab::{Angle, Timestamp, VesselCommand, WaterPoint, wrapped};

use super::answer::AnswerCheck;
use super::estimate::{Estimate, Input, Measured, ThroughWater, turned};
use super::input::BoatFix;
use super::tuning::{LineOfSightTuning, VesselModel};
use crate::ring::Ring;

mod answered_bow;
mod bow;
mod motion;

use answered_bow::AnsweredBow;
use motion::{HISTORY_LEN, MIN_INTERVAL_S, Motion, motion_at, turned_at};

/// Standard deviation of each component of the velocity before the second fix, m/s.
const INITIAL_SPEED_M_PER_S: f64 = 0.7;
/// The filter starts anew after a gap of this length, seconds.
const MAX_GAP_S: f64 = 3.0;
/// Variance beyond which the heading is unknown, rad².
const MAX_HEADING_VARIANCE: f64 = 0.6;
/// Variance of the heading up to which it tells the velocity through the water, rad².
const KNOWN_HEADING_VARIANCE: f64 = 0.125;
/// Below this modelled speed, m/s, and thrust the boat is at rest in the water.
const STILL_M_PER_S: f64 = 0.3;
const STILL_THRUST: f64 = 0.1;
/// Above this modelled speed, m/s, a boat goes ahead. The path of a slower boat does not tell the bow.
const AHEAD_M_PER_S: f64 = 0.1;
/// From this modelled speed, m/s, or thrust on the boat is under way.
const UNDER_WAY_M_PER_S: f64 = 1.0;
const UNDER_WAY_THRUST: f64 = 0.3;
/// Time constants with which the velocity returns to that of the model, under way and at rest, seconds.
const RETURN_S: f64 = 2.3;
const RETURN_AT_REST_S: f64 = 0.36;
/// Density of the acceleration of a boat at rest, m/s² per root hertz: waves.
const ACCELERATION_AT_REST: f64 = 0.04;
/// Share of the modelled gain of speed that is taken over at once; the rest comes with the return to the
/// model.
const GAINED_SHARE: f64 = 0.4;

/// That before any fix.
const NO_DISPLACEMENT: Displacement = Displacement { at_s: f64::NEG_INFINITY, metres: (0.0, 0.0) };

/// The boat at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoatState {
    /// Where the boat is.
    pub point: WaterPoint,
    /// Velocity over ground along x and y, m/s.
    pub velocity: (f64, f64),
    /// Where the bow points, if known.
    pub heading: Option<Angle>,
    /// Angle by which the course goes on turning with the rudder amidships, by the model, radians, positive
    /// to the right.
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

/// The camera's apparent displacement at the time of a fix, along x and y.
#[derive(Debug, Clone, Copy)]
struct Displacement {
    at_s: f64,
    metres: (f64, f64),
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
    /// Length of the way through the water by the model, metres.
    way_m: f64,
    displacements: Ring<Displacement, HISTORY_LEN>,
    estimate: Option<Estimate>,
    heading: Option<Heading>,
    arrived: Option<Timestamp>,
    answer: AnswerCheck,
    answered_bow: AnsweredBow,
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
                way: (0.0, 0.0),
            }),
            way_m: 0.0,
            displacements: Ring::new(NO_DISPLACEMENT),
            estimate: None,
            heading: None,
            arrived: None,
            answer: AnswerCheck::new(),
            answered_bow: AnsweredBow::default(),
        }
    }

    /// Discards all fixes: another boat was selected.
    pub fn reset(&mut self) {
        self.estimate = None;
        self.heading = None;
        self.arrived = None;
        self.expect_answer();
    }

    /// Whether what is seen hardly moved while the commanded boat would have.
    pub(super) fn is_unanswered(&self) -> bool {
        self.answer.is_unanswered()
    }

    /// Expects an answer to the commands from now on.
    pub(super) fn expect_answer(&mut self) {
        self.answer.restart();
        self.answered_bow = AnsweredBow::default();
    }

    /// Length of the way through the water by the model, metres.
    pub(super) const fn way_m(&self) -> f64 {
        self.way_m
    }

    /// Advances the vessel's model to `now` under the command in force.
    pub fn advance_to(&mut self, now: Timestamp) {
        let (now_s, last) = (now.as_secs_f64(), *self.motion.newest());
        if now_s <= last.at_s {
            return;
        }
        let speed = self.estimate.map_or(0.0, |estimate| {
            let (x, y) = estimate.velocity();
            libm::hypot(x, y)
        });
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
            let turned = last.turned + mean_yaw * duration_s + excess * self.model.drift_lag_s * (1.0 - kept);
            let (sin, cos) = libm::sincos(0.5 * (turned + last.turned));
            let ahead_m = 0.5 * (surge + last.surge) * duration_s;
            self.way_m += ahead_m.abs();
            Motion {
                at_s: now_s,
                turned,
                way: (last.way.0 + ahead_m * sin, last.way.1 + ahead_m * cos),
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

    /// Processes a fix that arrived at `now`. A fix that is not later than the last one, or not finite, is
    /// ignored.
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
        let measured = Measured { point: fix.water.point, noise };
        let is_continued = self.estimate.is_some_and(|last| at_s - last.at_s < MAX_GAP_S);
        let estimate = match self.estimate {
            Some(last) if at_s <= last.at_s => return,
            Some(last) if is_continued => {
                let unknown = Input {
                    turn: self.turned_at(at_s) - self.turned_at(last.at_s),
                    gained: (0.0, 0.0),
                    through_water: None,
                    acceleration_noise: self.acceleration_noise,
                    sway_per_s: fix.sway_per_s,
                };
                let input = if fix.is_commanded {
                    Input {
                        gained: self.gained(last.at_s, at_s),
                        through_water: self.through_water(at_s),
                        acceleration_noise: self.acceleration_noise_at(at_s),
                        ..unknown
                    }
                } else {
                    unknown
                };
                last.propagated(at_s, &input).updated(&measured)
            }
            _ => Estimate::new(at_s, &measured, self.displacements.newest().metres, INITIAL_SPEED_M_PER_S),
        };
        self.estimate = Some(estimate);
        let displacement = Displacement { at_s, metres: estimate.displacement() };
        self.displacements
            .push(displacement, |previous, newest| newest.at_s - previous.at_s >= MIN_INTERVAL_S);
        self.arrived = Some(now);
        if fix.is_commanded {
            self.answer.add(at_s, (x, y), self.motion_at(at_s).way);
        } else {
            self.expect_answer();
        }
        self.observe_heading(fix, at_s);
    }

    /// The time at which the last fix arrived, and the boat predicted to `now`.
    pub fn predicted(&self, now: Timestamp) -> Option<(Timestamp, BoatState)> {
        let (estimate, arrived) = (self.estimate?, self.arrived?);
        let (now_s, motion) = (now.as_secs_f64(), self.motion.newest());
        let turn = motion.turned - self.turned_at(estimate.at_s);
        let (WaterPoint { x, y }, (vx, vy)) = (estimate.point(), estimate.velocity());
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

    /// Whether a boat that is commanded went ahead through the water at a time of capture, by the model.
    pub fn went_ahead_at(&self, captured: Timestamp) -> bool {
        self.motion_at(captured.as_secs_f64()).surge > AHEAD_M_PER_S
    }

    /// The camera's apparent displacement at a time of capture: that of the newest fix that is not later, or
    /// else the oldest one that is stored.
    pub fn displacement_at(&self, captured: Timestamp) -> WaterPoint {
        let at_s = captured.as_secs_f64();
        let mut found = self.displacements.newest();
        let mut earlier = self.displacements.earlier();
        while found.at_s > at_s
            && let Some(before) = earlier.next()
        {
            found = before;
        }
        let (x, y) = found.metres;
        WaterPoint { x, y }
    }

    /// A mark is set or moved now: the distance between it and the boat is to be kept.
    pub fn anchor(&mut self) {
        self.estimate = self.estimate.map(|estimate| estimate.anchored());
    }

    /// Time of capture of the last fix.
    pub fn captured(&self) -> Option<Timestamp> {
        self.estimate.map(|estimate| Timestamp::from_secs_f64(estimate.at_s))
    }

    /// Velocity through the water by the model: none at rest; unknown under way while the heading is not
    /// known well.
    fn through_water(&self, at_s: f64) -> Option<ThroughWater> {
        let motion = self.motion_at(at_s);
        if motion.surge.abs() < STILL_M_PER_S && motion.thrust.abs() < STILL_THRUST {
            return Some(ThroughWater { velocity: (0.0, 0.0), return_s: RETURN_AT_REST_S });
        }
        let heading = self.heading.filter(|heading| heading.variance < KNOWN_HEADING_VARIANCE)?;
        let (sin, cos) = libm::sincos(heading.angle);
        Some(ThroughWater { velocity: (motion.surge * sin, motion.surge * cos), return_s: RETURN_S })
    }

    /// Change of the velocity by the modelled thrust between two times, along the heading, m/s; none while
    /// the heading is unknown.
    fn gained(&self, from_s: f64, to_s: f64) -> (f64, f64) {
        let Some(heading) = self.heading.filter(|heading| heading.variance < MAX_HEADING_VARIANCE) else {
            return (0.0, 0.0);
        };
        let gained = GAINED_SHARE * (self.motion_at(to_s).surge - self.motion_at(from_s).surge);
        let (sin, cos) = libm::sincos(heading.angle);
        (gained * sin, gained * cos)
    }

    /// Density of the acceleration that the model does not know, m/s² per root hertz: less of a boat at rest.
    fn acceleration_noise_at(&self, at_s: f64) -> f64 {
        let motion = self.motion_at(at_s);
        let way = (motion.surge.abs() / UNDER_WAY_M_PER_S).max(motion.thrust.abs() / UNDER_WAY_THRUST);
        ACCELERATION_AT_REST + way.min(1.0) * (self.acceleration_noise - ACCELERATION_AT_REST)
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
