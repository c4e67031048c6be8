//! Our guidance law: along a line over the water, around people and forbidden areas, and to rest before the
//! goal.
//!
//! One step:
//!
//! 1. [`BoatTrack`] predicts position, velocity and heading to the present.
//! 2. [`Route`] gives the course that leads back to the line (integral line of sight).
//! 3. [`clear_course`] turns that course around circles that are in the way.
//! 4. The boat may go as fast as it can stop: `v² = 2 a d` with the distance d to the stop, less the
//!    reaction, for the destination, the stand-off of a person, and each circle that the velocity points
//!    into.
//! 5. The rudder asks the vessel's model for a turn rate in proportion to the course error; the throttle is
//!    that of the limit while the allowed speed is higher, and follows the allowed speed below. Astern is
//!    used before people and circles only.
//!
//! While neither course nor heading is known, the boat goes straight on gently; the throttle rises, because a
//! head current may hold a slow boat in its place. At a place the boat drifts within
//! [`LineOfSightTuning::hold_m`], and goes back from there. Before a person it stays outside of the
//! stand-off, astern if need be, as far as the circles let it.
//!
//! What the law cannot do: keep away from a person who comes nearer faster than the boat goes astern, or hold
//! its place in a current faster than the boat.

use barrelman_vocab::{Angle, Timestamp, VesselCommand, VesselLimits, wrapped};

use super::answer::ApproachCheck;
use super::clearance::{ClearCourse, Side, clear_course};
use super::input::{Destination, GuidanceInput, GuidanceState, GuidanceStep, Progress};
use super::route::{LegGuidance, Route};
use super::track::{BoatState, BoatTrack};
use super::tuning::{LineOfSightTuning, VesselModel};

mod resting;
mod speed;

/// Longest time that one step integrates, seconds.
const MAX_STEP_S: f64 = 0.2;
/// Least throttle that the rudder is divided by.
const MIN_STEERING_THRUST: f64 = 0.2;
/// Excess of the speed over the allowed speed, m/s, from which on the boat goes astern, and that of full
/// astern.
const ASTERN_EXCESS: (f64, f64) = (0.15, 0.6);
/// The boat comes nearer to a person again from this distance beyond its place on, metres.
const STAND_OFF_DRIFT_M: f64 = 1.5;
/// Distance to a circle's edge within which the boat stops, metres.
const EDGE_M: f64 = 1.0;
/// A slow boat that is this close to a circle's edge and points at the circle backs off, to the second
/// distance, metres, before it turns.
const BACK_OFF_M: (f64, f64) = (1.3, 2.4);
/// A boat slower than this is slow: its velocity has no direction, m/s.
const SLOW_M_PER_S: f64 = 0.5;
/// The boat points at a circle from this cosine on, and no longer below the second.
const POINTS_AT: (f64, f64) = (0.3, 0.0);

/// What the boat does at its destination.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// On the way.
    Going,
    /// At rest there.
    Resting,
}

/// The law with its state.
#[derive(Debug, Clone)]
pub struct LineOfSight {
    tuning: LineOfSightTuning,
    model: VesselModel,
    track: BoatTrack,
    approach: ApproachCheck,
    route: Option<Route>,
    /// Whether the destination was moved since the last step.
    is_destination_moved: bool,
    phase: Phase,
    side: Option<Side>,
    /// Whether the boat goes astern from a circle.
    backs_off: bool,
    rudder: f64,
    way_since: Option<Timestamp>,
    last_step: Option<Timestamp>,
}

/// Where the boat must stop.
#[derive(Debug, Clone, Copy)]
struct Stop {
    /// Distance that is left, metres; negative beyond.
    left_m: f64,
    /// Whether the boat goes astern rather than beyond.
    is_strict: bool,
}

impl LineOfSight {
    /// The law for a vessel, without fixes.
    pub fn new(tuning: LineOfSightTuning, model: VesselModel) -> Self {
        Self {
            track: BoatTrack::new(model, &tuning),
            approach: ApproachCheck::default(),
            tuning,
            model,
            route: None,
            is_destination_moved: false,
            phase: Phase::Going,
            side: None,
            backs_off: false,
            rudder: 0.0,
            way_since: None,
            last_step: None,
        }
    }

    /// The estimate of the boat.
    pub const fn track(&self) -> &BoatTrack {
        &self.track
    }

    /// A mark is set or moved now.
    pub fn anchor(&mut self) {
        self.track.anchor();
        self.approach.move_end();
    }

    /// The destination is moved now. The route stays: a boat that has passed way-points does not go back to
    /// them. On the last leg, another line begins where the boat is, and a boat that rests goes on.
    pub const fn move_destination(&mut self) {
        self.is_destination_moved = true;
    }

    /// Expects an answer of the boat to its commands from now on.
    pub fn expect_answer(&mut self) {
        self.track.expect_answer();
        self.approach.restart();
    }

    /// Whether what is followed did not move as the boat on its way would have moved under the commands that
    /// were in force.
    pub fn is_unanswered(&self) -> bool {
        self.track.is_unanswered() || self.approach.is_unanswered()
    }

    /// Discards the fixes and the route: another boat was selected.
    pub fn reset_boat(&mut self) {
        self.track.reset();
        self.approach.restart();
        self.route = None;
        self.way_since = None;
    }

    /// Notes that `command` is in force from `now` on: the law's own, or what the safety rule made of it.
    pub fn on_command_applied(&mut self, command: VesselCommand, now: Timestamp) {
        self.track.apply_command(command, now);
    }

    /// Computes the command of one step.
    pub fn step(&mut self, input: &GuidanceInput<'_>) -> GuidanceStep {
        let now = input.now;
        self.track.advance_to(now);
        if let Some(fix) = &input.fix {
            self.track.observe(fix, now);
        }
        let duration_s = self.last_step.map_or(0.0, |last| now.since(last).as_secs_f64()).min(MAX_STEP_S);
        self.last_step = Some(now);
        let Some(destination) = input.destination else {
            self.route = None;
            self.expect_answer();
            return self.neutral(GuidanceState::NoDestination, None);
        };
        let Some((_, boat)) = self.track.predicted(now).filter(|(arrived, _)| {
            let captured = self.track.captured().unwrap_or(*arrived);
            now.since(*arrived).as_secs_f64() <= self.tuning.max_silence_s
                && now.since(captured).as_secs_f64() <= self.tuning.max_age_s
        }) else {
            return self.neutral(GuidanceState::NoFix, None);
        };
        let mut route = match self.route {
            Some(mut route) if route.id() == input.route => {
                if self.is_destination_moved && route.leg() >= input.way_points.len() {
                    self.begin_line();
                    route.re_anchor(boat.point);
                }
                route
            }
            _ => {
                self.begin_line();
                Route::new(input.route, boat.point)
            }
        };
        self.is_destination_moved = false;
        let leg = route.guidance(
            boat.point,
            input.way_points,
            destination.point(),
            if self.phase == Phase::Going { duration_s } else { 0.0 },
            &self.tuning,
        );
        let (command, state) = self.command(input, destination, &boat, &leg, &mut route);
        self.check_answer(state, &leg, route.leg(), now);
        let progress = Progress {
            boat: boat.point,
            speed_m_per_s: boat.speed_m_per_s(),
            course: self.course(&boat),
            distance_m: boat.point.distance_to(destination.point()),
            cross_track_m: leg.cross_track_m,
            leg: route.leg(),
        };
        self.route = Some(route);
        self.rudder = command.rudder;
        GuidanceStep { command: command.clamped(), state, progress: Some(progress) }
    }

    /// Another line begins, which the boat goes along.
    fn begin_line(&mut self) {
        self.phase = Phase::Going;
        self.side = None;
        self.backs_off = false;
        self.way_since = None;
        self.approach.move_end();
    }

    /// Whether the boat answers is asked only while it goes: a boat that keeps its place in a current goes
    /// through the water, and not over ground.
    fn check_answer(&mut self, state: GuidanceState, leg: &LegGuidance, number: usize, now: Timestamp) {
        match state {
            GuidanceState::UnderWay | GuidanceState::GettingWay => {
                self.approach.add(number, now.as_secs_f64(), leg.distance_m, self.track.way_m());
            }
            // The way around a circle may lead away from the end of the leg.
            GuidanceState::Avoiding => self.approach.restart(),
            _ => self.expect_answer(),
        }
    }

    fn neutral(&mut self, state: GuidanceState, progress: Option<Progress>) -> GuidanceStep {
        self.rudder = 0.0;
        self.way_since = None;
        GuidanceStep { command: VesselCommand::NEUTRAL, state, progress }
    }

    /// Course over ground, or the heading of a boat that is too slow for a course.
    fn course(&self, boat: &BoatState) -> Option<Angle> {
        if boat.speed_m_per_s() >= self.tuning.course_speed_m_per_s
            && boat.surge >= self.tuning.way_speed_m_per_s
        {
            Some(boat.course())
        } else {
            boat.heading
        }
    }

    fn command(
        &mut self,
        input: &GuidanceInput<'_>,
        destination: Destination,
        boat: &BoatState,
        leg: &LegGuidance,
        route: &mut Route,
    ) -> (VesselCommand, GuidanceState) {
        let limits = &input.limits;
        let stop = self.stop_at(destination, boat, leg);
        self.update_phase(destination, boat, leg, stop, route);
        if self.phase == Phase::Resting {
            self.way_since = None;
            return self.rest(input, destination, boat, stop);
        }
        let (sin, cos) = libm::sincos(leg.course);
        let clear = clear_course(
            boat.point,
            leg.end,
            (sin, cos),
            input.keep_outs,
            self.tuning.keep_out_margin_m,
            self.side,
        );
        let state = match clear {
            None => GuidanceState::Blocked,
            Some(ClearCourse { side: Some(_), .. }) => GuidanceState::Avoiding,
            Some(ClearCourse { side: None, .. }) => GuidanceState::UnderWay,
        };
        let side = clear.and_then(|clear| clear.side);
        if self.side.is_some() && side.is_none() {
            route.re_anchor(boat.point);
        }
        self.side = side;
        let direction = clear.map_or((sin, cos), |clear| clear.direction);
        let desired_course = libm::atan2(direction.0, direction.1);
        let course = self.course(boat);
        let error = course.map(|course| wrapped(desired_course - course.radians()));
        let speed = self.allowed_speed(input, boat, stop);
        if self.backs_off(boat, input) {
            let may_go = self.can_go_astern(boat, destination, input);
            let throttle = if may_go { -limits.astern } else { 0.0 };
            return (VesselCommand { throttle, rudder: 0.0 }, state);
        }
        let Some(error) = error else {
            let command = self.get_way(input, speed);
            let is_blocked = command.is_neutral();
            return (command, if is_blocked { GuidanceState::Blocked } else { GuidanceState::GettingWay });
        };
        self.way_since = None;
        let throttle = self.throttle(boat, &speed, limits);
        let rudder = self.rudder(boat, error, throttle, limits);
        (VesselCommand { throttle, rudder }, state)
    }

    /// Where the boat must stop on this leg; `None`: it passes the end of the leg.
    fn stop_at(&self, destination: Destination, boat: &BoatState, leg: &LegGuidance) -> Option<Stop> {
        match destination {
            // A person's stand-off holds on every leg.
            Destination::Person { at, stand_off_m, uncertainty_m, .. } => {
                let rest_m = stand_off_m + uncertainty_m + self.tuning.stand_off_margin_m;
                let left_m = boat.point.distance_to(at) - rest_m;
                let is_near = leg.is_last || left_m < self.tuning.pursuit_m;
                is_near.then_some(Stop { left_m, is_strict: true })
            }
            Destination::Place(_) if leg.is_last => {
                Some(Stop { left_m: leg.distance_m - 0.5 * self.tuning.arrival_m, is_strict: false })
            }
            Destination::Place(_) => None,
        }
    }

    fn update_phase(
        &mut self,
        destination: Destination,
        boat: &BoatState,
        leg: &LegGuidance,
        stop: Option<Stop>,
        route: &mut Route,
    ) {
        let (is_there, is_away) = match (destination, stop) {
            (Destination::Place(_), Some(_)) => {
                (leg.distance_m < self.tuning.arrival_m, leg.distance_m > self.tuning.hold_m)
            }
            // Also on the way to a way-point: a person may drift there.
            (Destination::Person { .. }, Some(stop)) => (stop.left_m < 0.2, stop.left_m > STAND_OFF_DRIFT_M),
            _ => (false, true),
        };
        match self.phase {
            Phase::Going if is_there => self.phase = Phase::Resting,
            Phase::Resting if is_away => {
                self.phase = Phase::Going;
                route.re_anchor(boat.point);
            }
            Phase::Going | Phase::Resting => {}
        }
    }

    /// Whether the boat goes astern from a circle that it has no room to turn before.
    fn backs_off(&mut self, boat: &BoatState, input: &GuidanceInput<'_>) -> bool {
        let Some(heading) = boat.heading.filter(|_| input.limits.astern > 0.0) else {
            self.backs_off = false;
            return false;
        };
        let (sin, cos) = libm::sincos(heading.radians());
        let is_slow = boat.speed_m_per_s() < SLOW_M_PER_S;
        let (min_gap_m, min_cos) =
            if self.backs_off { (BACK_OFF_M.1, POINTS_AT.1) } else { (BACK_OFF_M.0, POINTS_AT.0) };
        self.backs_off = (self.backs_off || is_slow)
            && input.keep_outs.iter().any(|circle| {
                let (x, y) = boat.point.vector_to(circle.centre);
                let distance = libm::sqrt(x * x + y * y);
                distance - circle.radius_m < min_gap_m && x * sin + y * cos > min_cos * distance
            });
        self.backs_off
    }

    fn rudder(&self, boat: &BoatState, error: f64, throttle: f64, limits: &VesselLimits) -> f64 {
        let thrust = boat.thrust.max(throttle).max(MIN_STEERING_THRUST);
        let authority = self.model.turn_authority(thrust, boat.speed_m_per_s());
        let turn = self.tuning.course_gain_per_s * (error - self.tuning.turn_damping * boat.turn_to_come);
        let rudder = (turn / authority).clamp(-limits.rudder, limits.rudder);
        if (rudder - self.rudder).abs() < self.tuning.rudder_step { self.rudder } else { rudder }
    }
}
