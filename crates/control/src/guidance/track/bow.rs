//! Where the boat's bow points: the integrated turn, corrected by the tracker's heading, or by the course.

use barrelman_vocab::wrapped;

use super::motion::turned_at;
use super::{BoatTrack, Heading, MAX_HEADING_VARIANCE};
use crate::guidance::input::BoatFix;

/// Growth of the heading's variance, rad² per second, of a boat whose turns the model knows.
const HEADING_NOISE: f64 = 0.01;
/// The same of a boat that this program does not command: its turns are not known.
const UNKNOWN_TURNS: f64 = 0.25;
/// Standard deviation of the course as a heading, radians: the crab angle.
const CRAB_RAD: f64 = 0.35;
/// Variance of a heading that the boat's answer to its thrust tells, rad².
const ANSWERED_VARIANCE: f64 = 0.2;

impl BoatTrack {
    pub(super) fn observe_heading(&mut self, fix: &BoatFix, at_s: f64) {
        let Some(estimate) = self.estimate else { return };
        let motion = self.motion_at(at_s);
        if let Some(last) = &mut self.heading {
            let turn = motion.turned - turned_at(&self.motion, last.at_s);
            let noise = if fix.is_commanded { HEADING_NOISE } else { UNKNOWN_TURNS };
            *last = Heading {
                at_s,
                angle: last.angle + turn,
                variance: last.variance + noise * (at_s - last.at_s).max(0.0),
            };
            let contradiction =
                self.answered_bow.contradiction(&self.answer, at_s, last.angle - motion.turned);
            if let Some(angle) = contradiction.filter(|_| fix.heading.is_none()) {
                (last.angle, last.variance) = (wrapped(angle + motion.turned), ANSWERED_VARIANCE);
            }
        }
        let (vx, vy) = estimate.velocity();
        let squared_speed = vx * vx + vy * vy;
        let of_tracker = fix
            .heading
            .map(|(angle, std_dev)| (angle.radians(), std_dev.radians() * std_dev.radians()))
            .filter(|(angle, variance)| angle.is_finite() && *variance > 0.0);
        let is_moving =
            motion.surge > self.way_speed && squared_speed > self.course_speed * self.course_speed;
        let of_course = is_moving.then(|| {
            (libm::atan2(vx, vy), CRAB_RAD * CRAB_RAD + estimate.velocity_variance() / squared_speed)
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
}

/// The end of an axis that points nearer to a direction: the angle itself, or the opposite one, radians.
fn end_near(angle: f64, direction: f64) -> f64 {
    if wrapped(angle - direction).abs() > core::f64::consts::FRAC_PI_2 {
        angle + core::f64::consts::PI
    } else {
        angle
    }
}
