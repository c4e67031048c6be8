//! Keeping clear of circles: a course around them, and a speed at which the boat can stop before them.
//!
//! Each circle is passed along its tangent, at a margin from its edge. Where a tangent meets another circle,
//! that circle's tangent on the same side is tried. Work: O(n²) for n circles at most [`MAX_TURNS`] times; no
//! trigonometry.

use barrelman_vocab::WaterPoint;

use super::input::KeepOut;

/// Tangents that are tried one after the other on each side.
const MAX_TURNS: usize = 4;
/// A course on the side on which the boat goes around already is taken unless the other deviates less by
/// this, as the cosine.
const SIDE_PREFERENCE: f64 = 0.3;
/// How strongly a boat within the margin is turned outwards.
const OUTWARD_GAIN: f64 = 0.7;

/// The side on which circles are passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The circle stays to the right: the boat turns left.
    Left,
    /// The circle stays to the left.
    Right,
}

/// A course that keeps clear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClearCourse {
    /// Unit vector along x and y.
    pub direction: (f64, f64),
    /// The side on which the boat goes around; `None`: the desired course is clear.
    pub side: Option<Side>,
}

/// The course to `goal` nearest to `desired` (a unit vector) that keeps `margin_m` from all circles. `None`
/// where no course is clear, or the goal itself lies within a circle's margin.
pub fn clear_course(
    boat: WaterPoint,
    goal: WaterPoint,
    desired: (f64, f64),
    keep_outs: &[KeepOut],
    margin_m: f64,
    last: Option<Side>,
) -> Option<ClearCourse> {
    let to_goal = boat.distance_to(goal);
    if keep_outs.iter().any(|circle| circle.centre.distance_to(goal) < circle.radius_m) {
        return None;
    }
    let Some(first) = first_hit(boat, desired, to_goal, keep_outs, margin_m) else {
        return Some(ClearCourse { direction: desired, side: None });
    };
    let mut best: Option<(f64, ClearCourse)> = None;
    for side in [Side::Left, Side::Right] {
        let Some(direction) = around(boat, to_goal, desired, first, side, keep_outs, margin_m) else {
            continue;
        };
        let preference = if last == Some(side) { SIDE_PREFERENCE } else { 0.0 };
        let rating = dot(direction, desired) + preference;
        if best.is_none_or(|(best_rating, _)| rating > best_rating) {
            best = Some((rating, ClearCourse { direction, side: Some(side) }));
        }
    }
    best.map(|(_, course)| course)
}

/// Distance that the boat may go on along its velocity before it enters a circle, metres; `None`: it enters
/// none. Negative or 0 within a circle that the boat goes deeper into.
pub fn free_distance(
    boat: WaterPoint,
    velocity: (f64, f64),
    keep_outs: &[KeepOut],
    margin_m: f64,
) -> Option<f64> {
    let squared_speed = dot(velocity, velocity);
    if squared_speed <= 0.0 {
        return None;
    }
    let scale = 1.0 / libm::sqrt(squared_speed);
    let direction = (scale * velocity.0, scale * velocity.1);
    keep_outs.iter().filter_map(|circle| entry(boat, direction, circle, margin_m)).min_by(f64::total_cmp)
}

/// Whether a boat that turns to one side with this radius, metres, from its present course (a unit vector)
/// on, stays `margin_m` away from all circles.
pub fn turn_clears(
    boat: WaterPoint,
    course: (f64, f64),
    side: Side,
    radius_m: f64,
    keep_outs: &[KeepOut],
    margin_m: f64,
) -> bool {
    let left = (-course.1, course.0);
    let reach = if side == Side::Left { radius_m } else { -radius_m };
    let centre = WaterPoint { x: boat.x + reach * left.0, y: boat.y + reach * left.1 };
    // NaN does not clear.
    keep_outs.iter().all(|circle| centre.distance_to(circle.centre) >= radius_m + circle.radius_m + margin_m)
}

/// The direction around the circle `first` on one side, and around those that it meets.
fn around(
    boat: WaterPoint,
    to_goal: f64,
    desired: (f64, f64),
    first: usize,
    side: Side,
    keep_outs: &[KeepOut],
    margin_m: f64,
) -> Option<(f64, f64)> {
    let mut index = first;
    for _ in 0..MAX_TURNS {
        let circle = keep_outs.get(index)?;
        let direction = tangent(boat, circle, margin_m, side, desired);
        // Only circles nearer than the goal, or than the circle that is passed, are in the way.
        let reach = to_goal.max(boat.distance_to(circle.centre));
        match first_hit(boat, direction, reach, keep_outs, margin_m) {
            None => return Some(direction),
            Some(next) if next == index => return Some(direction),
            Some(next) => index = next,
        }
    }
    None
}

/// The direction of the tangent to a circle; within its margin, along the circle and outwards.
fn tangent(boat: WaterPoint, circle: &KeepOut, margin_m: f64, side: Side, desired: (f64, f64)) -> (f64, f64) {
    let (x, y) = boat.vector_to(circle.centre);
    let distance = libm::sqrt(x * x + y * y);
    let radius = circle.radius_m + margin_m;
    if distance <= f64::MIN_POSITIVE {
        return desired;
    }
    let (x, y) = (x / distance, y / distance);
    // To the left of the direction to the centre.
    let left = (-y, x);
    let aside = if side == Side::Left { left } else { (-left.0, -left.1) };
    let (towards, across) = if distance > radius {
        let sin = radius / distance;
        (libm::sqrt(1.0 - sin * sin), sin)
    } else {
        let depth = ((radius - distance) / margin_m.max(f64::MIN_POSITIVE)).min(1.0);
        let outwards = OUTWARD_GAIN * depth;
        (-outwards, libm::sqrt(1.0 - outwards * outwards))
    };
    (towards * x + across * aside.0, towards * y + across * aside.1)
}

/// The circle that a course enters first within `reach` metres. The tolerance keeps a tangent from meeting
/// its own circle.
fn first_hit(
    boat: WaterPoint,
    direction: (f64, f64),
    reach: f64,
    keep_outs: &[KeepOut],
    margin_m: f64,
) -> Option<usize> {
    const TOLERANCE_M: f64 = 1e-6;
    keep_outs
        .iter()
        .enumerate()
        .filter_map(|(index, circle)| {
            entry(boat, direction, circle, margin_m - TOLERANCE_M)
                .filter(|distance| *distance < reach)
                .map(|distance| (index, distance))
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// Distance along a direction to a circle with its margin; `None` if the direction does not meet it, or leads
/// out of it.
fn entry(boat: WaterPoint, direction: (f64, f64), circle: &KeepOut, margin_m: f64) -> Option<f64> {
    let centre = boat.vector_to(circle.centre);
    let radius = circle.radius_m + margin_m;
    let along = dot(centre, direction);
    let squared_distance = dot(centre, centre);
    if along <= 0.0 {
        return None;
    }
    let half_chord = radius * radius - (squared_distance - along * along);
    (half_chord > 0.0).then(|| {
        if squared_distance <= radius * radius {
            libm::sqrt(squared_distance) - radius
        } else {
            along - libm::sqrt(half_chord)
        }
    })
}

fn dot(a: (f64, f64), b: (f64, f64)) -> f64 {
    a.0 * b.0 + a.1 * b.1
}
