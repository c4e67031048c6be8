//! The travel that is enough to keep the target inside the region when its whole path is known beforehand.
//!
//! The course of one axis for a given course of the other one: at each picture there is an interval of angles
//! at which the target is inside. The axis turns only where it must, by as little as it must (the play
//! operator), which is the least total variation of any course through the intervals. Pan and tilt are found
//! in turn, a few times. The result is a course that is enough; a better one may exist, since the problem in
//! both axes is not convex.
//!
//! Rates, lags and dead times are left out: the course may jump. The focal length is the profile's.

use anyhow::Result;
use barrelman_control::Region;
use barrelman_control::view::{Direction, View};
use barrelman_experiments::campaign::plan::CampaignPlan;
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::Truth;
use barrelman_trial::campaign::step_observer::StepObserver;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{ImagePoint, Timestamp, VehicleRates};

use super::law_under_test::LawUnderTest;
use crate::parallel;
use crate::statistics::mean;

/// How often pan and tilt are found in turn.
const TURNS: usize = 4;
/// Only every third picture counts: ten for each second.
const EVERY: usize = 3;
/// Intervals are searched for up to this distance from the target, radians, and in this number of steps.
const REACH: f64 = 1.5;
const STEPS: u32 = 150;

/// Mean travel of such a course for each trial, rad.
///
/// # Errors
/// If a trial cannot be simulated.
pub(super) fn mean_travel(plan: &CampaignPlan, seeds: std::ops::Range<u64>) -> Result<f64> {
    let seeds: Vec<u64> = seeds.collect();
    let travels = parallel::map(&seeds, |seed| {
        let mut observer = Observer::default();
        let schema = LawUnderTest::MotorSchema.build(plan.profile());
        let log = plan.simulate_with_law(Some(schema), *seed, &mut observer)?;
        let region = log.region(plan.profile().region);
        let focal_px = plan.profile().camera.focal_share * f64::from(log.picture.width);
        Ok(travel(&observer.directions(focal_px), focal_px, region))
    });
    Ok(mean(&travels.into_iter().collect::<Result<Vec<f64>>>()?))
}

/// What is seen in each picture.
#[derive(Debug, Default)]
struct Observer(Vec<PictureTruth>);

#[derive(Debug, Clone, Copy)]
struct PictureTruth {
    at_s: f64,
    image: ImagePoint,
    /// Tilt with the sway, radians.
    tilt: f64,
    rates: [f64; 2],
}

impl StepObserver for Observer {
    fn on_step(&mut self, _: Timestamp, _: &Input<'_>, _: &Outcome, _: VehicleRates) {}

    fn on_truth(&mut self, truth: &Truth, _: Option<&TargetInPicture>) {
        self.0.push(PictureTruth {
            at_s: truth.at.as_secs_f64(),
            image: truth.image,
            tilt: truth.camera.tilt.radians(),
            rates: [truth.rates.0, truth.rates.1],
        });
    }
}

impl Observer {
    /// The target's directions, with the sway, in a frame that does not turn with the axes.
    fn directions(&self, focal_px: f64) -> Vec<Direction> {
        let mut turned = vec![[0.0; 2]; self.0.len()];
        for (index, pair) in self.0.windows(2).enumerate() {
            let half_s = 0.5 * (pair[1].at_s - pair[0].at_s);
            turned[index + 1] =
                [0, 1].map(|axis| turned[index][axis] + half_s * (pair[0].rates[axis] + pair[1].rates[axis]));
        }
        // The sway of the tilt has a mean of zero.
        let first_tilts: Vec<f64> =
            self.0.iter().zip(&turned).map(|(picture, turned)| picture.tilt - turned[1]).collect();
        let first_tilt = mean(&first_tilts);
        let direction = |(picture, turned): (&PictureTruth, &[f64; 2])| {
            View::new(focal_px, turned[0], first_tilt + turned[1]).unproject(picture.image)
        };
        self.0.iter().zip(&turned).step_by(EVERY).map(direction).collect()
    }
}

/// The travel of both axes that is enough for these directions, rad.
fn travel(directions: &[Direction], focal_px: f64, region: Region) -> f64 {
    let is_inside = |direction: &Direction, pan: f64, tilt: f64| {
        region.p(View::new(focal_px, pan, tilt).project(*direction)) <= 1.0
    };
    let mut last = 0.0;
    let towards: Vec<[f64; 2]> = directions
        .iter()
        .map(|[right, ahead, above]| {
            // The azimuth without jumps at the back.
            let azimuth = right.atan2(*ahead);
            last += (azimuth - last + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
            [last, above.clamp(-1.0, 1.0).asin()]
        })
        .collect();
    let mut courses = [0, 1].map(|axis| towards.iter().map(|angles| angles[axis]).collect::<Vec<f64>>());
    for turn in 0..2 * TURNS {
        // Tilt first: it has the smaller reach.
        let axis = (turn + 1) % 2;
        let other = courses[1 - axis].clone();
        let intervals: Vec<(f64, f64)> = directions
            .iter()
            .zip(&towards)
            .zip(&other)
            .map(|((direction, towards), other)| {
                let at = |angle: f64| match axis {
                    0 => is_inside(direction, angle, *other),
                    _ => is_inside(direction, *other, angle),
                };
                interval_around(towards[axis], at)
            })
            .collect();
        courses[axis] = least_variation(&intervals);
    }
    courses.iter().map(|course| course.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>()).sum()
}

/// The interval of angles within reach at which a condition holds; where there is none, the centre alone.
fn interval_around(centre: f64, holds: impl Fn(f64) -> bool) -> (f64, f64) {
    let step = REACH / f64::from(STEPS);
    let angles = || (0..=2 * STEPS).map(|k| centre - REACH + step * f64::from(k));
    let first = angles().find(|angle| holds(*angle));
    let last = angles().rev().find(|angle| holds(*angle));
    first.zip(last).unwrap_or((centre, centre))
}

/// A course through intervals with the least total variation: it changes only where it must, by as little as
/// it must.
fn least_variation(intervals: &[(f64, f64)]) -> Vec<f64> {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut first = None;
    for (from, to) in intervals {
        if *from > high || *to < low {
            first = Some(if *from > high { high } else { low });
            break;
        }
        (low, high) = (low.max(*from), high.min(*to));
    }
    let mut angle = first.unwrap_or(0.5 * (low + high));
    intervals
        .iter()
        .map(|(from, to)| {
            angle = angle.max(*from).min(*to);
            angle
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_changes_only_where_it_must() {
        let course = least_variation(&[(-1.0, 1.0), (0.0, 2.0), (1.5, 3.0), (-0.5, 1.0)]);
        assert_eq!(course, [1.0, 1.0, 1.5, 1.0]);
        assert_eq!(least_variation(&[(-1.0, 1.0), (0.0, 2.0)]), [0.5, 0.5]);
    }

    #[test]
    fn a_target_that_swings_within_the_region_needs_no_travel_and_one_that_swings_farther_does() {
        let region = Region { a_px: 192.0, b_px: 120.0 };
        let swing = |reach: f64| -> f64 {
            let directions: Vec<Direction> = (0..200_u32)
                .map(|k| {
                    let azimuth = reach * (0.1 * f64::from(k)).sin();
                    [azimuth.sin(), azimuth.cos(), 0.0]
                })
                .collect();
            travel(&directions, 330.0, region)
        };
        assert!(swing(0.4) < 1e-9);
        // The region's edge is at atan(192/330) = 0.527 rad.
        let swings = 200.0 * 0.1 / core::f64::consts::TAU;
        assert!((swing(0.7) / (4.0 * (0.7 - 0.527) * swings) - 1.0).abs() < 0.2, "{}", swing(0.7));
    }
}
