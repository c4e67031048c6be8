//! The target in the picture: box, axes, heading, the line from the picture's centre with r and the angle, and P.

use core::f64::consts::PI;
use std::fmt::Write;

use barrelman_control::{MotorSchema, Percept};
use barrelman_vocab::track::Shape;
use barrelman_vocab::{Angle, PictureSize, PixelBox, PixelPoint, Track};

use super::pen::Pen;
use super::placement::LabelPlacement;
use super::scene::Scene;
use super::shapes::{Line, polyline, upright};
use super::style::{Detail, Ink};
use super::text;

/// A target whose place is known, in pixels of the frame that is drawn on.
#[derive(Debug, Clone, Copy)]
pub(super) struct TargetView {
    centre: PixelPoint,
    /// Box around it, within the picture.
    pub(super) bounds: PixelBox,
    shape: Option<Shape>,
    heading: Option<Angle>,
    coasting: bool,
    /// What its place means to the law.
    pub(super) percept: Percept,
}

impl TargetView {
    /// What a scene knows of the target's place; none where it knows nothing or no finite number.
    pub(super) fn of(scene: &Scene<'_>, picture: PictureSize) -> Option<Self> {
        let seen = scene.track.localisation()?;
        // A localisation may count in pixels of another size of the same picture.
        let across = f64::from(picture.width) / f64::from(seen.picture.width);
        let down = f64::from(picture.height) / f64::from(seen.picture.height);
        let (far_u, far_v) = (f64::from(picture.width) * 2.0, f64::from(picture.height) * 2.0);
        let centre = PixelPoint { u: seen.centre.u * across, v: seen.centre.v * down };
        if !(centre.u.is_finite() && centre.v.is_finite()) {
            return None;
        }
        let centre = PixelPoint { u: centre.u.clamp(-far_u, far_u), v: centre.v.clamp(-far_v, far_v) };
        let bounds = seen.bounds;
        let bounds =
            PixelBox { u: bounds.u * across, v: bounds.v * down, w: bounds.w * across, h: bounds.h * down };
        let shape = seen.shape.map(|shape| Shape {
            major_px: (shape.major_px * across).clamp(0.0, far_u),
            minor_px: (shape.minor_px * across).clamp(0.0, far_u),
            axis: shape.axis,
        });
        Some(Self {
            centre,
            bounds: bounds.clipped(picture),
            shape,
            heading: seen.heading,
            coasting: matches!(scene.track, Track::Coasting(_)),
            percept: scene.percept.unwrap_or_else(|| Percept::new(centre.in_image(picture), scene.region)),
        })
    }

    /// The colour of its state.
    fn ink(&self) -> Ink {
        if self.coasting { Ink::CAUTION } else { Ink::ACCENT }
    }

    fn direction(&self) -> f64 {
        self.percept.direction.radians()
    }
}

/// A point so many pixels from another in a direction, anticlockwise from image right.
fn towards(from: PixelPoint, direction: f64, distance: f64) -> (f32, f32) {
    let (u, v) = (from.u + distance * libm::cos(direction), from.v - distance * libm::sin(direction));
    (u as f32, v as f32)
}

/// Draws the target and the line to it, without words.
pub(super) fn draw(pen: &mut Pen, view: &TargetView) {
    draw_line(pen, view);
    draw_box(pen, view);
    draw_axes(pen, view);
    let centre = (view.centre.u as f32, view.centre.v as f32);
    pen.dot(centre, pen.style.scaled(3.0).max(1.2), Ink::LIGHT);
}

/// Radius of the arc that shows the angle, where there is room for one.
fn arc_radius(pen: &Pen, view: &TargetView) -> Option<f64> {
    let largest = f64::from(pen.style.scaled(64.0));
    let radius = largest.min(view.percept.r_px * 0.6);
    (pen.style.detail == Detail::Full && radius > largest * 0.4).then_some(radius)
}

fn draw_line(pen: &mut Pen, view: &TargetView) {
    let centre = pen.layer.size().centre();
    let line = Line::of(Ink::LIGHT.at(0.9));
    let origin = (centre.u as f32, centre.v as f32);
    pen.segment(origin, (view.centre.u as f32, view.centre.v as f32), line);
    let Some(radius) = arc_radius(pen, view) else { return };
    pen.segment(origin, towards(centre, 0.0, radius * 1.35), Line::of(Ink::LIGHT.at(0.5)).dashed());
    let chords = 24;
    let on_arc =
        |chord: u32| towards(centre, view.direction() * f64::from(chord) / f64::from(chords), radius);
    pen.line(polyline((0..=chords).map(on_arc), false), line);
}

fn draw_box(pen: &mut Pen, view: &TargetView) {
    let PixelBox { u, v, w, h } = view.bounds;
    if view.bounds.is_empty() {
        return;
    }
    let line = Line::of(view.ink());
    if view.coasting {
        pen.line(upright(view.bounds), line.dashed().wide(1.3));
        return;
    }
    pen.line(upright(view.bounds), Line::of(view.ink().at(0.35)));
    // The corners are drawn out: the box is seen at a glance, and the target within it stays plain.
    let (left, top, right, bottom) = (u as f32, v as f32, (u + w) as f32, (v + h) as f32);
    let arm = (w.min(h) as f32 * 0.28).min(pen.style.scaled(22.0));
    for (corner_u, into_u) in [(left, arm), (right, -arm)] {
        for (corner_v, into_v) in [(top, arm), (bottom, -arm)] {
            let corner = [(corner_u + into_u, corner_v), (corner_u, corner_v), (corner_u, corner_v + into_v)];
            pen.line(polyline(corner, false), line.wide(1.5));
        }
    }
}

fn draw_axes(pen: &mut Pen, view: &TargetView) {
    if let Some(shape) = view.shape {
        let (major, minor) = (shape.major_px / 2.0, shape.minor_px / 2.0);
        let axis = shape.axis.radians();
        let ends = |direction: f64, half: f64| {
            [towards(view.centre, direction, -half), towards(view.centre, direction, half)]
        };
        pen.line(polyline(ends(axis + PI / 2.0, minor), false), Line::of(view.ink().at(0.6)));
        pen.line(polyline(ends(axis, major), false), Line::of(view.ink()));
    }
    if let Some(heading) = view.heading.map(Angle::radians) {
        let reach = view.shape.map_or(view.bounds.w.min(view.bounds.h) / 2.0, |shape| shape.major_px / 2.0);
        let size = f64::from(pen.style.scaled(12.0).max(7.0));
        let tip = towards(view.centre, heading, reach + size);
        let tip_point = PixelPoint { u: f64::from(tip.0), v: f64::from(tip.1) };
        let barb = |side: f64| towards(tip_point, heading + PI - side * 0.45, size);
        pen.segment((view.centre.u as f32, view.centre.v as f32), tip, Line::of(view.ink()));
        let head = polyline([barb(1.0), tip, barb(-1.0)], true);
        pen.line(head.clone(), Line::of(view.ink()));
        if let Some(head) = head {
            pen.layer.fill(&head, view.ink());
        }
    }
}

/// Keeps labels off the line from the picture's centre to the target.
fn reserve_line(pen: &Pen, placement: &mut LabelPlacement, view: &TargetView) {
    let centre = pen.layer.size().centre();
    let step = f64::from(pen.style.text_px).max(1.0);
    let end = view.percept.r_px.min(libm::hypot(centre.u, centre.v));
    let mut along = 0.0;
    while along < end {
        let (u, v) = towards(centre, view.direction(), along);
        placement.reserve(PixelBox { u: f64::from(u) - 0.5, v: f64::from(v) - 0.5, w: 1.0, h: 1.0 });
        along += step;
    }
}

/// Labels r, the angle and P, each where there is room for it; the strip holds them, too.
pub(super) fn label(pen: &mut Pen, placement: &mut LabelPlacement, view: &TargetView) {
    let centre = pen.layer.size().centre();
    let mut words = String::new();
    reserve_line(pen, placement, view);

    let _ = write!(words, "P {:.2}", view.percept.p);
    let (w, h) = pen.plate_size(&words);
    let PixelBox { u: left, v: top, w: across, h: down } = view.bounds;
    let (gap, middle) = (pen.style.margin, view.bounds.centre());
    let at = |u: f64, v: f64| PixelPoint { u, v };
    let beside = [
        at(middle.u, top - gap - h / 2.0),
        at(middle.u, top + down + gap + h / 2.0),
        at(left + across + gap + w / 2.0, middle.v),
        at(left - gap - w / 2.0, middle.v),
    ];
    if let Some(place) = placement.place_first((w, h), beside) {
        let released = MotorSchema::is_released(&view.percept);
        pen.plate(place);
        pen.centred_text(&words, place, if released { Ink::ACCENT } else { Ink::LIGHT });
    }

    let Some(radius) = arc_radius(pen, view) else { return };
    words.clear();
    words.push_str("angle ");
    text::push_signed(&mut words, view.percept.direction.degrees(), 1);
    words.push('°');
    let size = pen.plate_size(&words);
    let direction = view.direction();
    let outside = |share: f64| {
        // The plate's middle lies so far out that its corner is clear of the arc.
        let clear = radius + gap + (size.0 * libm::cos(direction * share).abs() + size.1) / 2.0;
        let (u, v) = towards(centre, direction * share, clear);
        at(f64::from(u), f64::from(v))
    };
    let opposite = at(centre.u, centre.v + (size.1 / 2.0 + gap * 2.0).copysign(direction));
    let arc = [0.5, 0.35, 0.65].map(outside);
    if let Some(place) = placement.place_first(size, arc.into_iter().chain([opposite])) {
        pen.plate(place);
        pen.centred_text(&words, place, Ink::LIGHT);
    }

    words.clear();
    let _ = write!(words, "r {:.0} px", view.percept.r_px);
    let size = pen.plate_size(&words);
    let along = |share: f64, side: f64| {
        let (u, v) = towards(centre, direction, view.percept.r_px * share);
        let (s, c) = (libm::sin(direction), libm::cos(direction));
        // Off the line by as much as the plate reaches towards it.
        let off = side * (size.0 * s.abs() + size.1 * c.abs() + gap * 1.5) / 2.0;
        at(f64::from(u) - off * s, f64::from(v) - off * c)
    };
    // On the side that the angle does not grow from first.
    let side = if direction < 0.0 { -1.0 } else { 1.0 };
    let beside = [0.6, 0.7, 0.5].into_iter().flat_map(|share| [along(share, side), along(share, -side)]);
    if let Some(place) = placement.place_first(size, beside) {
        pen.plate(place);
        pen.centred_text(&words, place, Ink::LIGHT);
    }
}
