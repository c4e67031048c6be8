//! How fast the boat may go, and the throttle for that speed.

use barrelman_vocab::{VesselCommand, VesselLimits, WaterPoint};

use super::{ASTERN_EXCESS, EDGE_M, LineOfSight, SLOW_M_PER_S, Stop};
use crate::guidance::clearance::{free_distance, turn_clears};
use crate::guidance::input::GuidanceInput;
use crate::guidance::track::BoatState;

/// Time in which the throttle rises from that for getting way on to the limit, seconds.
const WAY_RISE_S: f64 = 3.0;
/// Throttle for each m/s of missing speed.
const THROTTLE_PER_SPEED: f64 = 0.25;

/// The largest allowed speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct AllowedSpeed {
    m_per_s: f64,
    is_strict: bool,
}

impl AllowedSpeed {
    fn limit(&mut self, m_per_s: f64, is_strict: bool) {
        if m_per_s < self.m_per_s {
            self.m_per_s = m_per_s;
            self.is_strict = is_strict;
        }
    }
}

impl LineOfSight {
    /// The largest speed at which the boat can stop in time, m/s, and whether it goes astern to keep it.
    pub(super) fn allowed_speed(
        &self,
        input: &GuidanceInput<'_>,
        boat: &BoatState,
        stop: Option<Stop>,
    ) -> AllowedSpeed {
        let limits = &input.limits;
        let speed_limit = limits.speed_m_per_s.unwrap_or(f64::INFINITY).max(0.0);
        let mut allowed = AllowedSpeed { m_per_s: speed_limit, is_strict: false };
        if let Some(stop) = stop {
            let (from, is_strict) = (stop.left_m, stop.is_strict);
            allowed.limit(self.stopping_speed(from, self.braking_before(is_strict, limits)), is_strict);
        }
        // A boat whose bow is not known may go anywhere.
        if boat.heading.is_none() {
            for circle in input.keep_outs {
                let left_m = boat.point.distance_to(circle.centre) - circle.radius_m - EDGE_M;
                allowed.limit(self.stopping_speed(left_m, self.braking_before(true, limits)), true);
            }
        }
        // The velocity of a slow boat has no direction: the bow's counts.
        let direction = match boat.heading {
            Some(heading) if boat.speed_m_per_s() < SLOW_M_PER_S => libm::sincos(heading.radians()),
            _ => boat.velocity,
        };
        let free = free_distance(boat.point, direction, input.keep_outs, EDGE_M);
        if let Some(free_m) = free.filter(|_| !self.turns_clear(boat, input)) {
            allowed.limit(self.stopping_speed(free_m, self.braking_before(true, limits)), true);
        }
        allowed
    }

    /// Whether the turn to the side on which the boat goes around keeps clear of all circles: then the boat
    /// needs its thrust.
    fn turns_clear(&self, boat: &BoatState, input: &GuidanceInput<'_>) -> bool {
        let Some(side) = self.side else { return false };
        let run_on_s = self.tuning.reaction_s;
        let point = WaterPoint {
            x: boat.point.x + run_on_s * boat.velocity.0,
            y: boat.point.y + run_on_s * boat.velocity.1,
        };
        let course = self.course(boat).unwrap_or_else(|| boat.course());
        let (sin, cos) = libm::sincos(course.radians());
        turn_clears(point, (sin, cos), side, self.model.turn_radius_m, input.keep_outs, EDGE_M)
    }

    fn braking_before(&self, is_strict: bool, limits: &VesselLimits) -> f64 {
        if is_strict { self.braking(limits) } else { self.tuning.approach_m_per_s2 }
    }

    /// Deceleration with which the boat can stop, m/s².
    fn braking(&self, limits: &VesselLimits) -> f64 {
        self.model.coasting_m_per_s2 + self.model.astern_m_per_s2 * limits.astern * limits.astern
    }

    /// The speed from which the boat stops within a distance: `v t + v² / (2 a) = d`.
    pub(super) fn stopping_speed(&self, distance_m: f64, braking: f64) -> f64 {
        let run_on = braking * self.tuning.reaction_s;
        libm::sqrt(run_on * run_on + 2.0 * braking * distance_m.max(0.0)) - run_on
    }

    /// The command of a boat whose heading is unknown.
    pub(super) fn get_way(&mut self, input: &GuidanceInput<'_>, speed: AllowedSpeed) -> VesselCommand {
        let since = *self.way_since.get_or_insert(input.now);
        let rise = (input.now.since(since).as_secs_f64() / WAY_RISE_S).min(1.0);
        let start = self.tuning.way_throttle.min(input.limits.ahead);
        let throttle =
            (start + rise * (input.limits.ahead - start)).min(speed.m_per_s / self.model.speed_per_throttle);
        VesselCommand { throttle, rudder: 0.0 }
    }

    pub(super) fn throttle(&self, boat: &BoatState, speed: &AllowedSpeed, limits: &VesselLimits) -> f64 {
        let missing = speed.m_per_s - boat.speed_m_per_s();
        if speed.is_strict && -missing > ASTERN_EXCESS.0 {
            let share = libm::sqrt((-missing / ASTERN_EXCESS.1).min(1.0));
            // A boat that moves astern is stopped by thrust ahead.
            let is_ahead = boat.heading.is_none_or(|heading| {
                let (sin, cos) = libm::sincos(heading.radians());
                boat.velocity.0 * sin + boat.velocity.1 * cos >= 0.0
            });
            return if is_ahead { -limits.astern * share } else { 0.5 * limits.ahead * share };
        }
        let throttle = speed.m_per_s / self.model.speed_per_throttle + THROTTLE_PER_SPEED * missing;
        throttle.clamp(0.0, limits.ahead)
    }
}
