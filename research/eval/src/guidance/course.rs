//! Where a trial starts, where it goes, and where the people are: drawn from the seed.

use barrelman_control::water::WaterView;
use barrelman_sim::noise;
use barrelman_sim::scenario::{Scenario, TargetScript};
use barrelman_sim::scenery::ObjectScript;
use barrelman_sim::snapshot::ObjectKind;
use barrelman_vocab::{Angle, PixelPoint, WaterPoint};

use super::condition::Condition;

/// The camera: height (m), tilt, focal length (px), barrel distortion; 1280 x 720 pixels, at rest.
pub(super) const HEIGHT_M: f64 = 15.0;
pub(super) const TILT_DEG: f64 = -40.0;
/// Legs, metres.
const LEG_M: (f64, f64) = (13.0, 25.0);
/// Distance ahead of the camera in which start and target lie, metres: farther away, the laboratory's 30 px
/// would be more than the arrival circle.
const AHEAD_M: (f64, f64) = (10.0, 30.0);
/// Start and target are so far inside the picture, pixels.
const BORDER_PX: f64 = 80.0;
/// Distance of the people beside the way from the line, metres.
const BESIDE_M: (f64, f64) = (6.0, 9.0);
/// Streams of the draws; one trial is one seed.
const STREAM: u64 = 0x6D1D;

/// A trial's course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Course {
    pub(super) start: WaterPoint,
    pub(super) target: WaterPoint,
    /// The boat's heading at the start: 0 ahead, to the right, radians.
    pub(super) heading: f64,
    /// Current along x and y, m/s.
    pub(super) current: (f64, f64),
    pub(super) people: [Option<WaterPoint>; 2],
}

impl Course {
    /// The course of a seed.
    pub(super) fn drawn(condition: &Condition, scenario: &Scenario, view: &WaterView, seed: u64) -> Self {
        let unit = |index: u64| noise::unit(seed, STREAM, index);
        let between = |index: u64, (low, high): (f64, f64)| low + (high - low) * unit(index);
        let is_inside = |point: WaterPoint| {
            view.pixel_of_water(point).is_some_and(|PixelPoint { u, v }| {
                (BORDER_PX..1280.0 - BORDER_PX).contains(&u) && (BORDER_PX..720.0 - BORDER_PX).contains(&v)
            })
        };
        let point =
            |index: u64| WaterPoint { x: between(index, (-14.0, 14.0)), y: between(index + 1, AHEAD_M) };
        let (start, target) = (0..1000_u64)
            .map(|attempt| (point(4 * attempt + 100), point(4 * attempt + 102)))
            .find(|(start, target)| {
                is_inside(*start)
                    && is_inside(*target)
                    && (LEG_M.0..LEG_M.1).contains(&start.distance_to(*target))
            })
            .unwrap_or((WaterPoint { x: -4.0, y: 12.0 }, WaterPoint { x: 5.0, y: 26.0 }));
        let (x, y) = start.vector_to(target);
        let length = start.distance_to(target);
        let right = (y / length, -x / length);
        let current = condition.current_m_per_s.map_or_else(
            || scenario.water.map_or((0.0, 0.0), |water| water.current_m_per_s),
            |speed| {
                let (sin, cos) = (core::f64::consts::TAU * unit(0)).sin_cos();
                (speed * cos, speed * sin)
            },
        );
        let at = |share: f64, aside: f64| WaterPoint {
            x: start.x + share * x + aside * right.0,
            y: start.y + share * y + aside * right.1,
        };
        // People beside the way drift away from it.
        let away = current.0 * right.0 + current.1 * right.1;
        let side = |index: u64| if away.abs() > 0.05 { away.signum() } else { (unit(index) - 0.5).signum() };
        let people = if condition.person_on_way {
            // The person meets the boat about here.
            let (share, aside) = (between(1, (0.4, 0.65)), between(2, (-1.0, 1.0)));
            [Some(at(share, aside)), None]
        } else {
            [
                Some(at(between(3, (0.2, 0.8)), side(4) * between(5, BESIDE_M))),
                Some(at(between(6, (0.2, 0.8)), side(7) * between(8, BESIDE_M))),
            ]
        };
        let spread = condition.heading_spread_deg.to_radians();
        let heading = start.bearing_to(target).radians() + between(9, (-spread, spread));
        Self { start, target, heading, current, people }
    }

    /// The scenario of the trial: boat, current and people of this course. The destination is the first
    /// object.
    pub(super) fn scenario(&self, base: &Scenario, condition: &Condition, max_s: f64) -> Scenario {
        let mut scenario = base.clone();
        scenario.max_s = max_s;
        if let Some(water) = &mut scenario.water {
            water.current_m_per_s = self.current;
        }
        if let TargetScript::Boat(script) = &mut scenario.target {
            let (sin, cos) = self.heading.sin_cos();
            script.way_points =
                vec![(self.start.x, self.start.y), (self.start.x + 500.0 * sin, self.start.y + 500.0 * cos)];
            script.way_point_jitter_m = 0.0;
        }
        let person = |at: WaterPoint, drifts: bool| ObjectScript {
            kind: ObjectKind::Swimmer,
            at: (at.x, at.y),
            jitter_m: 0.0,
            heading: Angle::ZERO,
            velocity_m_per_s: (0.0, 0.0),
            turns_after_s: None,
            drifts,
        };
        let others = self.people.iter().flatten().map(|at| person(*at, true));
        scenario.objects = std::iter::once(person(self.target, condition.to_person)).chain(others).collect();
        scenario
    }
}
