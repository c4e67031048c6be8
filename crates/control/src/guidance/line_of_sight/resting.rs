//! What the boat does at its destination: it drifts at a place, and keeps the stand-off of a person.

use barrelman_vocab::{VesselCommand, VesselLimits, WaterPoint, wrapped};

use super::{ASTERN_EXCESS, EDGE_M, LineOfSight, POINTS_AT, Stop};
use crate::guidance::clearance::free_distance;
use crate::guidance::input::{Destination, GuidanceInput, GuidanceState, KeepOut};
use crate::guidance::track::BoatState;

/// A boat before a person moves away from a place too close by this share of the distance each second, and at
/// most so fast, m/s.
const BACKING_PER_S: f64 = 0.5;
const BACKING_M_PER_S: f64 = 0.4;

impl LineOfSight {
    /// The command of a boat at its destination.
    pub(super) fn rest(
        &self,
        input: &GuidanceInput<'_>,
        destination: Destination,
        boat: &BoatState,
        stop: Option<Stop>,
    ) -> (VesselCommand, GuidanceState) {
        let Destination::Person { at, velocity_m_per_s, .. } = destination else {
            return (VesselCommand::NEUTRAL, GuidanceState::Holding);
        };
        let left_m = stop.map_or(0.0, |stop| stop.left_m);
        let away = self.retreat(boat, (at, velocity_m_per_s), left_m, &input.limits);
        let may_go = self.can_coast_to_rest(boat, away.throttle, input.keep_outs);
        (if may_go { away } else { VesselCommand::NEUTRAL }, GuidanceState::StandingOff)
    }

    /// Whether a boat under this thrust, ahead or astern, still comes to rest before every circle when the
    /// thrust ends.
    fn can_coast_to_rest(&self, boat: &BoatState, throttle: f64, circles: &[KeepOut]) -> bool {
        let Some(heading) = boat.heading else { return false };
        let (sin, cos) = libm::sincos(heading.radians());
        let sign = if throttle < 0.0 { -1.0 } else { 1.0 };
        let direction = (sign * sin, sign * cos);
        let Some(free_m) = free_distance(boat.point, direction, circles, EDGE_M) else { return true };
        let speed = boat.velocity.0 * direction.0 + boat.velocity.1 * direction.1;
        speed.max(0.0) < self.stopping_speed(free_m, self.model.coasting_m_per_s2)
    }

    /// Whether a boat that backs off from a circle keeps out of those behind it, and of the stand-off of its
    /// destination.
    pub(super) fn can_go_astern(
        &self,
        boat: &BoatState,
        destination: Destination,
        input: &GuidanceInput<'_>,
    ) -> bool {
        let is_free = |circles: &[KeepOut]| self.can_coast_to_rest(boat, -input.limits.astern, circles);
        let is_free_of_destination = match destination {
            Destination::Place(_) => true,
            Destination::Person { at, stand_off_m, .. } => {
                is_free(&[KeepOut { centre: at, radius_m: stand_off_m }])
            }
        };
        is_free(input.keep_outs) && is_free_of_destination
    }

    /// The command of a boat at rest before a person: away from the person where it is too close. A boat that
    /// points at the person goes astern, another one ahead and turns away. One whose bow is not known stays
    /// neutral: any thrust might move it to the person.
    fn retreat(
        &self,
        boat: &BoatState,
        (person, (vx, vy)): (WaterPoint, (f64, f64)),
        left_m: f64,
        limits: &VesselLimits,
    ) -> VesselCommand {
        let bearing = boat.point.bearing_to(person).radians();
        let (sin, cos) = libm::sincos(bearing);
        let closing = (boat.velocity.0 - vx) * sin + (boat.velocity.1 - vy) * cos;
        let desired = (BACKING_PER_S * left_m).clamp(-BACKING_M_PER_S, 0.0);
        let excess = closing - desired;
        if excess <= 0.0 || (left_m > 0.0 && closing < ASTERN_EXCESS.0) {
            return VesselCommand::NEUTRAL;
        }
        let Some(heading) = boat.heading else { return VesselCommand::NEUTRAL };
        let off_bow = wrapped(bearing - heading.radians());
        // Thrust grows with the square of the throttle.
        let share = libm::sqrt((excess / ASTERN_EXCESS.1).min(1.0));
        if libm::cos(off_bow) > POINTS_AT.0 {
            VesselCommand { throttle: -limits.astern * share, rudder: 0.0 }
        } else {
            // Until the person is astern.
            let rudder = -libm::copysign(limits.rudder * libm::sin(off_bow).abs(), off_bow);
            VesselCommand { throttle: 0.5 * limits.ahead * share, rudder }
        }
    }
}
