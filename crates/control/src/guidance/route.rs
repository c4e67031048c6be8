//! The line that the boat follows: way-points, then the destination, with integral line-of-sight guidance.
//!
//! With the path angle a of the leg (course from its start to its end), the cross-track error e (metres,
//! positive to the right of the line), the look-ahead distance D and the integral y (metres; Børhaug, Pavlov
//! and Pettersen 2008; Fossen 2011, section 10.3):
//!
//! ```text
//! course = a - atan((e + s y) / D)        y' = D e / (D² + (e + s y)²)
//! ```
//!
//! Near the end of a leg the boat heads for the end itself.

use barrelman_vocab::{WaterPoint, wrapped};

use super::tuning::LineOfSightTuning;

/// A way-point that lies behind the boat counts as passed within this multiple of its radius.
const PASSED_FACTOR: f64 = 2.5;

/// The state of a route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Route {
    id: u32,
    /// Start of the present leg.
    anchor: WaterPoint,
    leg: usize,
    integral_m: f64,
}

/// What to steer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LegGuidance {
    /// Desired course, radians.
    pub course: f64,
    /// End of the leg.
    pub end: WaterPoint,
    /// Distance to the end of the leg, metres.
    pub distance_m: f64,
    /// Distance from the line, metres, positive to the right.
    pub cross_track_m: f64,
    /// Whether the leg ends at the destination.
    pub is_last: bool,
}

impl Route {
    /// A route that starts at `from`.
    pub const fn new(id: u32, from: WaterPoint) -> Self {
        Self { id, anchor: from, leg: 0, integral_m: 0.0 }
    }

    /// Number of the operator's selection.
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// Number of the next way-point.
    pub const fn leg(&self) -> usize {
        self.leg
    }

    /// Starts the present leg anew at `from`: the boat was away from the line on purpose.
    pub const fn re_anchor(&mut self, from: WaterPoint) {
        self.anchor = from;
        self.integral_m = 0.0;
    }

    /// The course to steer from `boat`. `duration_s` is the time since the last step, for the integral; 0
    /// where the boat does not follow the course.
    pub fn guidance(
        &mut self,
        boat: WaterPoint,
        way_points: &[WaterPoint],
        destination: WaterPoint,
        duration_s: f64,
        tuning: &LineOfSightTuning,
    ) -> LegGuidance {
        while let Some(next) = way_points.get(self.leg)
            && self.has_passed(boat, *next, tuning.way_point_m)
        {
            self.anchor = *next;
            self.leg += 1;
            self.integral_m = 0.0;
        }
        self.leg = self.leg.min(way_points.len());
        let end = way_points.get(self.leg).copied().unwrap_or(destination);
        let is_last = self.leg == way_points.len();
        let distance_m = boat.distance_to(end);
        let bearing = boat.bearing_to(end).radians();
        let (along_x, along_y) = self.anchor.vector_to(end);
        let length = libm::sqrt(along_x * along_x + along_y * along_y);
        let (from_x, from_y) = self.anchor.vector_to(boat);
        let cross_track_m = if length > 0.0 { (from_x * along_y - from_y * along_x) / length } else { 0.0 };
        let mut course = bearing;
        if distance_m > tuning.pursuit_m && length > 0.0 {
            let look_ahead =
                (tuning.look_ahead_share * distance_m).clamp(tuning.look_ahead_m.0, tuning.look_ahead_m.1);
            let off = cross_track_m + tuning.integral_gain * self.integral_m;
            if cross_track_m.abs() < tuning.integral_limit_m {
                self.integral_m +=
                    duration_s * look_ahead * cross_track_m / (look_ahead * look_ahead + off * off);
            }
            course = libm::atan2(along_x, along_y) - libm::atan(off / look_ahead);
        }
        LegGuidance { course: wrapped(course), end, distance_m, cross_track_m, is_last }
    }

    fn has_passed(&self, boat: WaterPoint, point: WaterPoint, radius_m: f64) -> bool {
        let distance = boat.distance_to(point);
        let (x, y) = boat.vector_to(point);
        let (along_x, along_y) = self.anchor.vector_to(point);
        distance < radius_m || (distance < PASSED_FACTOR * radius_m && x * along_x + y * along_y < 0.0)
    }
}
