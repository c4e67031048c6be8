//! What else is on the water: things that look like the boat, things that do not, and land.
//!
//! All of it rests on the water or moves straight on, and is placed so that the camera's way passes it and the
//! boat's way does not.

use barrelman_vocab::PixelPoint;

use super::chance::Chance;
use super::colour::{self, Yuv};
use super::outline::{Outline, Shape};
use super::shore::{self, Shore};
use super::thing::{Berth, Body, Livery, Thing};
use super::view::PlanePoint;
use super::voyage::Voyage;
use super::{FRAMES_PER_SECOND, TargetPaint};

/// Places tried for each thing.
const TRIES: usize = 60;
/// Frames from one check of a place to the next; a thing counts as in view a little beyond the border.
const CHECK_EVERY: usize = 3;
/// That much beyond, as a share of the picture's width: as far as a pan takes a thing between two checks.
const BORDER_SHARE: f64 = 0.07;
/// Distractors in view at the same time, at most.
pub(super) const MOST_DISTRACTORS: usize = 2;
/// Share of an absence during which a distractor must be in view to be worth placing.
const WORTH_PLACING: f64 = 0.25;
/// A thing comes no nearer to the boat than this, in shares of both their reaches.
const BERTH_SHARE: f64 = 1.15;

/// What placing must know.
pub(super) struct Site<'a> {
    pub(super) voyage: &'a Voyage,
    pub(super) frames: usize,
    pub(super) outline: &'a Outline,
    pub(super) paint: TargetPaint,
    pub(super) shore: Option<&'a Shore>,
    /// Picture width over the reference picture's.
    pub(super) relative: f64,
}

impl Site<'_> {
    fn checks(&self) -> impl Iterator<Item = usize> {
        (0..self.frames).step_by(CHECK_EVERY)
    }

    /// The frames (of those checked) in which a thing may be in view; none if it comes too near to the boat.
    fn appearances(&self, thing: &Thing) -> Option<Vec<bool>> {
        let reach = thing.body.outline.reach();
        let clear = BERTH_SHARE * (reach + self.outline.reach());
        self.checks()
            .map(|frame| {
                let pose = self.voyage.pose(frame as i64);
                let at = thing.berth(frame as f64 / f64::from(FRAMES_PER_SECOND)).at;
                let middle = pose.view.picture(at);
                let (width, height) = (f64::from(pose.view.size.width), f64::from(pose.view.size.height));
                let beyond = reach * pose.view.zoom + BORDER_SHARE * width;
                let seen = middle.u > -beyond
                    && middle.u < width + beyond
                    && middle.v > -beyond
                    && middle.v < height + beyond;
                (at.distance(pose.boat) > clear).then_some(seen)
            })
            .collect()
    }

    /// Whether a thing keeps off the shore's line: what moves is afloat throughout, what rests may stand on land.
    fn keeps_off_the_shore(&self, thing: &Thing) -> bool {
        let Some(shore) = self.shore else { return true };
        let clear = thing.body.outline.reach() + shore::MOST_RAGGED * self.relative;
        let inland = |frame: usize| shore.inland(thing.berth(frame as f64 / f64::from(FRAMES_PER_SECOND)).at);
        let rests_on_land = thing.velocity == (0.0, 0.0) && inland(0) > clear;
        rests_on_land || self.checks().all(|frame| inland(frame) < -clear)
    }

    /// The place of the plane that a frame shows at a share of its width and height.
    fn shown(&self, frame: usize, share: (f64, f64)) -> PlanePoint {
        let view = self.voyage.pose(frame as i64).view;
        view.plane(share.0 * f64::from(view.size.width), share.1 * f64::from(view.size.height))
    }
}

/// Things of the hull's very paint: one that is in view for as long as possible, and one for each absence.
pub(super) fn distractors(site: &Site<'_>, hull: Yuv, mut chance: Chance) -> Vec<Thing> {
    let mut placed: Vec<Thing> = Vec::new();
    let mut in_view: Vec<usize> = site.checks().map(|_| 0).collect();
    let spans = site.voyage.absences.iter().map(|absence| (absence.from, absence.until, Some(*absence)));
    let whole = core::iter::once((0, site.frames, None));
    for (from, until, absence) in spans.chain(whole) {
        let mut best: Option<(f64, Thing, Vec<bool>)> = None;
        for _ in 0..TRIES {
            let frame = from + (chance.unit() * (until - from) as f64) as usize;
            let near =
                absence.map(|absence| if chance.happens(0.5) { absence.left_at } else { absence.back_at });
            let share = match near {
                Some(border) if chance.happens(0.6) => near_border(site, border, &mut chance),
                _ => (chance.between(0.08, 0.92), chance.between(0.08, 0.92)),
            };
            let thing = lookalike(site, hull, site.shown(frame, share), frame, &mut chance);
            if !site.keeps_off_the_shore(&thing) {
                continue;
            }
            let Some(seen) = site.appearances(&thing) else { continue };
            if seen.iter().zip(&in_view).any(|(seen, others)| *seen && *others >= MOST_DISTRACTORS) {
                continue;
            }
            let span = &seen
                [from.div_ceil(CHECK_EVERY).min(seen.len())..until.div_ceil(CHECK_EVERY).min(seen.len())];
            let score = span.iter().filter(|seen| **seen).count() as f64 / span.len().max(1) as f64;
            if score > best.as_ref().map_or(WORTH_PLACING, |best| best.0) {
                best = Some((score, thing, seen));
            }
        }
        if let Some((_, thing, seen)) = best {
            in_view.iter_mut().zip(seen).for_each(|(count, seen)| *count += usize::from(seen));
            placed.push(thing);
        }
    }
    placed
}

/// A place in the picture, as shares of its sides, not far from where the boat crossed the border.
fn near_border(site: &Site<'_>, border: PixelPoint, chance: &mut Chance) -> (f64, f64) {
    let size = site.voyage.pose(0).view.size;
    let (u, v) = (border.u / f64::from(size.width), border.v / f64::from(size.height));
    let inside = |share: f64, off: f64| (share + off).clamp(0.06, 0.94);
    (inside(u, chance.between(-0.15, 0.15)), inside(v, chance.between(-0.2, 0.2)))
}

/// A buoy, a raft or a roof of half to twice the boat's area.
fn lookalike(site: &Site<'_>, hull: Yuv, at: PlanePoint, frame: usize, chance: &mut Chance) -> Thing {
    let area = site.outline.area() * chance.between(0.55, 1.9);
    let buoy = chance.happens(0.35);
    let aspect = if buoy { 1.0 } else { chance.between(0.5, 1.0) };
    let shape = if buoy { Shape::Round } else { Shape::Raft };
    let unit = Outline::new(shape, 1.0, aspect);
    let length = libm::sqrt(area / unit.area());
    let livery = if buoy {
        Livery::Spotted { paint: hull, spot: colour::lit(hull, 0.55) }
    } else if chance.happens(0.4) {
        Livery::Planks { paint: hull, joints: 3.0 }
    } else {
        Livery::Plain(hull)
    };
    let speed = if !buoy && chance.happens(0.4) { chance.between(10.0, 60.0) * site.relative } else { 0.0 };
    let course = chance.between(0.0, core::f64::consts::TAU);
    let velocity = (speed * libm::cos(course), speed * libm::sin(course));
    // It is at the place in that frame.
    let time_s = frame as f64 / f64::from(FRAMES_PER_SECOND);
    let at = at.offset(-velocity.0 * time_s, -velocity.1 * time_s);
    let heading = if speed > 0.0 { course } else { chance.between(0.0, core::f64::consts::TAU) };
    let outline = Outline::new(shape, length, length * aspect);
    Thing { body: Body { outline, livery }, berth: Berth { at, heading }, velocity }
}

/// Things of other colours. They keep off the boat's way, the distractors and the shore.
pub(super) fn clutter(site: &Site<'_>, distractors: &[Thing], mut chance: Chance) -> Vec<Thing> {
    let wanted = chance.between(2.0, 14.0) as usize;
    let mut placed: Vec<Thing> = Vec::new();
    for _ in 0..3 * wanted {
        if placed.len() >= wanted {
            break;
        }
        let frame = (chance.unit() * site.frames as f64) as usize;
        let at = site.shown(frame, (chance.between(-0.1, 1.1), chance.between(-0.1, 1.1)));
        let thing = flotsam(site, at, &mut chance);
        let reach = thing.body.outline.reach();
        let apart = distractors.iter().all(|other| {
            let gap = reach + other.body.outline.reach();
            site.checks().all(|frame| {
                let time_s = frame as f64 / f64::from(FRAMES_PER_SECOND);
                thing.berth(time_s).at.distance(other.berth(time_s).at) > gap
            })
        });
        if apart && site.keeps_off_the_shore(&thing) && site.appearances(&thing).is_some() {
            placed.push(thing);
        }
    }
    placed
}

/// Driftwood, a swimmer's cap, a jetty, another boat or buoy.
fn flotsam(site: &Site<'_>, at: PlanePoint, chance: &mut Chance) -> Thing {
    let hull = 2.0 * site.outline.half_length;
    let timber = colour::lit(colour::yuv(colour::timber(site.paint)), chance.between(0.5, 1.1) as f32);
    let paint = colour::yuv(chance.pick(&colour::OTHER_PAINTS));
    let dark = colour::lit(paint, 0.5);
    let kind = chance.unit();
    let (shape, length, aspect, livery) = if kind < 0.4 {
        (Shape::Bar, chance.between(0.2, 0.9), chance.between(0.06, 0.2), Livery::Plain(timber))
    } else if kind < 0.6 {
        (Shape::Round, chance.between(0.08, 0.16), 1.0, Livery::Plain(paint))
    } else if kind < 0.68 {
        (
            Shape::Bar,
            chance.between(2.0, 4.0),
            chance.between(0.1, 0.2),
            Livery::Planks { paint: timber, joints: 14.0 },
        )
    } else if kind < 0.85 {
        let fullness = chance.between(1.6, 2.6);
        let livery =
            Livery::Boat { hull: paint, cockpit: dark, stripe: colour::lit(paint, 1.3), engine: dark };
        (Shape::Hull { fullness }, chance.between(0.6, 1.3), chance.between(0.28, 0.45), livery)
    } else {
        (Shape::Round, chance.between(0.2, 0.5), 1.0, Livery::Spotted { paint, spot: dark })
    };
    let velocity = if matches!(shape, Shape::Hull { .. }) {
        (chance.between(-30.0, 30.0) * site.relative, chance.between(-30.0, 30.0) * site.relative)
    } else {
        (0.0, 0.0)
    };
    let heading = if velocity == (0.0, 0.0) {
        chance.between(0.0, core::f64::consts::TAU)
    } else {
        libm::atan2(velocity.1, velocity.0)
    };
    let length = length * hull;
    let outline = Outline::new(shape, length, length * aspect);
    Thing { body: Body { outline, livery }, berth: Berth { at, heading }, velocity }
}
