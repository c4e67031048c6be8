//! Objects beside the boat: distractors, which look like the boat, and clutter, which does not.
//!
//! All of them rest on the water or move uniformly. They are placed so that the camera passes them and the
//! boat does not.

use barrelman_vocab::PixelPoint;
use barrelman_vocab::rng::SplitMix64;

use super::choices::Choices;
use super::colour::{self, Yuv};
use super::object::{Body, PaintScheme, PlanePose, SceneObject};
use super::outline::{Outline, Shape};
use super::placement::{CHECK_EVERY, MAX_DISTRACTORS, PlacementContext};
use super::script::FRAMES_PER_SECOND;
use super::shore::{self, Shore};
use super::view::PlanePoint;

/// Positions tried for each object.
const TRIES: usize = 60;
/// Share of an absence during which a distractor must be in view to be placed.
const MIN_PLACING_SHARE: f64 = 0.25;
/// Whether an object keeps clear of the shore's line: moving objects are afloat throughout, resting ones may
/// stand on land.
fn is_clear_of_shore(context: &PlacementContext<'_>, shore: Option<&Shore>, object: &SceneObject) -> bool {
    let Some(shore) = shore else { return true };
    let clear = object.body.outline.reach() + shore::MAX_EDGE_OFFSET * context.relative;
    let inland = |frame: usize| shore.inland(object.pose_at(frame as f64 / f64::from(FRAMES_PER_SECOND)).at);
    let rests_on_land = object.velocity == (0.0, 0.0) && inland(0) > clear;
    rests_on_land || context.checks().all(|frame| inland(frame) < -clear)
}

/// Objects in exactly the hull's paint: one for each absence, and one that is in view for as long as
/// possible.
pub(super) fn distractors(
    context: &PlacementContext<'_>,
    shore: Option<&Shore>,
    hull: Yuv,
    mut rng: SplitMix64,
) -> Vec<SceneObject> {
    let mut placed: Vec<SceneObject> = Vec::new();
    let mut in_view: Vec<usize> = context.checks().map(|_| 0).collect();
    let spans =
        context.trajectory.absences.iter().map(|absence| (absence.from, absence.until, Some(*absence)));
    let whole = core::iter::once((0, context.frames, None));
    for (from, until, absence) in spans.chain(whole) {
        let mut best: Option<(f64, SceneObject, Vec<bool>)> = None;
        for _ in 0..TRIES {
            let frame = from + (rng.uniform() * (until - from) as f64) as usize;
            let near = absence.map(|absence| if rng.chance(0.5) { absence.left_at } else { absence.back_at });
            let share = match near {
                Some(border) if rng.chance(0.6) => near_border(context, border, &mut rng),
                _ => (rng.between(0.08, 0.92), rng.between(0.08, 0.92)),
            };
            let object =
                sampled_distractor(context, hull, context.plane_point_at(frame, share), frame, &mut rng);
            if !is_clear_of_shore(context, shore, &object) {
                continue;
            }
            let Some(seen) = context.appearances(&object) else { continue };
            if seen.iter().zip(&in_view).any(|(seen, others)| *seen && *others >= MAX_DISTRACTORS) {
                continue;
            }
            let span = &seen
                [from.div_ceil(CHECK_EVERY).min(seen.len())..until.div_ceil(CHECK_EVERY).min(seen.len())];
            let score = span.iter().filter(|seen| **seen).count() as f64 / span.len().max(1) as f64;
            if score > best.as_ref().map_or(MIN_PLACING_SHARE, |best| best.0) {
                best = Some((score, object, seen));
            }
        }
        if let Some((_, object, seen)) = best {
            in_view.iter_mut().zip(seen).for_each(|(count, seen)| *count += usize::from(seen));
            placed.push(object);
        }
    }
    placed
}

/// A position in the picture, as shares of its sides, near where the boat crossed the border.
fn near_border(context: &PlacementContext<'_>, border: PixelPoint, rng: &mut SplitMix64) -> (f64, f64) {
    let size = context.trajectory.pose(0).view.size;
    let (u, v) = (border.u / f64::from(size.width), border.v / f64::from(size.height));
    let inside = |share: f64, off: f64| (share + off).clamp(0.06, 0.94);
    (inside(u, rng.between(-0.15, 0.15)), inside(v, rng.between(-0.2, 0.2)))
}

/// A buoy, a raft or a roof of half to twice the boat's area.
fn sampled_distractor(
    context: &PlacementContext<'_>,
    hull: Yuv,
    at: PlanePoint,
    frame: usize,
    rng: &mut SplitMix64,
) -> SceneObject {
    let area = context.outline.area() * rng.between(0.55, 1.9);
    let buoy = rng.chance(0.35);
    let aspect = if buoy { 1.0 } else { rng.between(0.5, 1.0) };
    let shape = if buoy { Shape::Round } else { Shape::Raft };
    let unit = Outline::new(shape, 1.0, aspect);
    let length = libm::sqrt(area / unit.area());
    let paint_scheme = if buoy {
        PaintScheme::Spotted { paint: hull, spot: colour::lit(hull, 0.55) }
    } else if rng.chance(0.4) {
        PaintScheme::Planks { paint: hull, joints: 3.0 }
    } else {
        PaintScheme::Plain(hull)
    };
    let speed = if !buoy && rng.chance(0.4) { rng.between(10.0, 60.0) * context.relative } else { 0.0 };
    let course = rng.between(0.0, core::f64::consts::TAU);
    let velocity = (speed * libm::cos(course), speed * libm::sin(course));
    // The object is at the position in that frame.
    let time_s = frame as f64 / f64::from(FRAMES_PER_SECOND);
    let at = at.offset(-velocity.0 * time_s, -velocity.1 * time_s);
    let heading = if speed > 0.0 { course } else { rng.between(0.0, core::f64::consts::TAU) };
    let outline = Outline::new(shape, length, length * aspect);
    SceneObject { body: Body { outline, paint_scheme }, plane_pose: PlanePose { at, heading }, velocity }
}

/// Objects of other colours, clear of the boat's way, the distractors and the shore.
pub(super) fn clutter(
    context: &PlacementContext<'_>,
    shore: Option<&Shore>,
    distractors: &[SceneObject],
    mut rng: SplitMix64,
) -> Vec<SceneObject> {
    let wanted = rng.between(2.0, 14.0) as usize;
    let mut placed: Vec<SceneObject> = Vec::new();
    for _ in 0..3 * wanted {
        if placed.len() >= wanted {
            break;
        }
        let frame = (rng.uniform() * context.frames as f64) as usize;
        let at = context.plane_point_at(frame, (rng.between(-0.1, 1.1), rng.between(-0.1, 1.1)));
        let object = sampled_clutter(context, at, &mut rng);
        let reach = object.body.outline.reach();
        let apart = distractors.iter().all(|other| {
            let gap = reach + other.body.outline.reach();
            context.checks().all(|frame| {
                let time_s = frame as f64 / f64::from(FRAMES_PER_SECOND);
                object.pose_at(time_s).at.distance(other.pose_at(time_s).at) > gap
            })
        });
        if apart && is_clear_of_shore(context, shore, &object) && context.appearances(&object).is_some() {
            placed.push(object);
        }
    }
    placed
}

/// Driftwood, a swimmer's cap, a jetty, another boat or a buoy.
fn sampled_clutter(context: &PlacementContext<'_>, at: PlanePoint, rng: &mut SplitMix64) -> SceneObject {
    let hull = 2.0 * context.outline.half_length;
    let timber = colour::lit(colour::yuv(colour::timber(context.paint)), rng.between(0.5, 1.1) as f32);
    let paint = colour::yuv(rng.choose(&colour::OTHER_PAINTS));
    let dark = colour::lit(paint, 0.5);
    let kind = rng.uniform();
    let (shape, length, aspect, paint_scheme) = if kind < 0.4 {
        (Shape::Bar, rng.between(0.2, 0.9), rng.between(0.06, 0.2), PaintScheme::Plain(timber))
    } else if kind < 0.6 {
        (Shape::Round, rng.between(0.08, 0.16), 1.0, PaintScheme::Plain(paint))
    } else if kind < 0.68 {
        (
            Shape::Bar,
            rng.between(2.0, 4.0),
            rng.between(0.1, 0.2),
            PaintScheme::Planks { paint: timber, joints: 14.0 },
        )
    } else if kind < 0.85 {
        let fullness = rng.between(1.6, 2.6);
        let paint_scheme =
            PaintScheme::Boat { hull: paint, cockpit: dark, stripe: colour::lit(paint, 1.3), engine: dark };
        (Shape::Hull { fullness }, rng.between(0.6, 1.3), rng.between(0.28, 0.45), paint_scheme)
    } else {
        (Shape::Round, rng.between(0.2, 0.5), 1.0, PaintScheme::Spotted { paint, spot: dark })
    };
    let velocity = if matches!(shape, Shape::Hull { .. }) {
        (rng.between(-30.0, 30.0) * context.relative, rng.between(-30.0, 30.0) * context.relative)
    } else {
        (0.0, 0.0)
    };
    let heading = if velocity == (0.0, 0.0) {
        rng.between(0.0, core::f64::consts::TAU)
    } else {
        libm::atan2(velocity.1, velocity.0)
    };
    let length = length * hull;
    let outline = Outline::new(shape, length, length * aspect);
    SceneObject { body: Body { outline, paint_scheme }, plane_pose: PlanePose { at, heading }, velocity }
}
