//! The target in the picture: box, axes, heading, the line from the picture's centre with r and the angle,
//! and P.

use core::f64::consts::PI;
use std::fmt::Write;

use barrelman_control::{MotorSchema, Percept};
use barrelman_vocab::track::Shape;
use barrelman_vocab::{Angle, PictureSize, PixelBox, PixelPoint, Track};

use super::canvas::Canvas;
use super::placement::LabelPlacement;
use super::scene::Scene;
use super::shapes::{Line, polyline, upright};
use super::style::{Detail, Rgba};
use super::text;

/// A localised target, in pixels of the frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct TargetView {
    centre: PixelPoint,
    /// Bounds, clipped to the picture.
    pub(super) bounds: PixelBox,
    shape: Option<Shape>,
    heading: Option<Angle>,
    coasting: bool,
    /// The percept.
    pub(super) percept: Percept,
}

impl TargetView {
    /// The target of a scene; `None` without a localisation with finite numbers.
    pub(super) fn from_scene(scene: &Scene<'_>, picture: PictureSize) -> Option<Self> {
        let seen = scene.track.localisation()?;
        // A localisation may refer to another size of the same picture.
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
    fn colour(&self) -> Rgba {
        if self.coasting { Rgba::CAUTION } else { Rgba::ACCENT }
    }

    fn direction(&self) -> f64 {
        self.percept.direction.radians()
    }
}

/// The point at a distance from another point; the direction counts anticlockwise from image right.
fn towards(from: PixelPoint, direction: f64, distance: f64) -> (f32, f32) {
    let (u, v) = (from.u + distance * libm::cos(direction), from.v - distance * libm::sin(direction));
    (u as f32, v as f32)
}

/// Draws the target and the line to it, without labels.
pub(super) fn draw(canvas: &mut Canvas, view: &TargetView) {
    draw_line(canvas, view);
    draw_box(canvas, view);
    draw_axes(canvas, view);
    let centre = (view.centre.u as f32, view.centre.v as f32);
    canvas.dot(centre, canvas.style.scaled(3.0).max(1.2), Rgba::LIGHT);
}

/// Radius of the arc that shows the angle, where there is room for one.
fn arc_radius(canvas: &Canvas, view: &TargetView) -> Option<f64> {
    let largest = f64::from(canvas.style.scaled(64.0));
    let radius = largest.min(view.percept.r_px * 0.6);
    (canvas.style.detail == Detail::Full && radius > largest * 0.4).then_some(radius)
}

fn draw_line(canvas: &mut Canvas, view: &TargetView) {
    let centre = canvas.layer.size().centre();
    let line = Line::new(Rgba::LIGHT.with_opacity(0.9));
    let origin = (centre.u as f32, centre.v as f32);
    canvas.segment(origin, (view.centre.u as f32, view.centre.v as f32), line);
    let Some(radius) = arc_radius(canvas, view) else { return };
    canvas.segment(
        origin,
        towards(centre, 0.0, radius * 1.35),
        Line::new(Rgba::LIGHT.with_opacity(0.5)).dashed(),
    );
    let chords = 24;
    let on_arc =
        |chord: u32| towards(centre, view.direction() * f64::from(chord) / f64::from(chords), radius);
    canvas.line(polyline((0..=chords).map(on_arc), false), line);
}

fn draw_box(canvas: &mut Canvas, view: &TargetView) {
    let PixelBox { u, v, w, h } = view.bounds;
    if view.bounds.is_empty() {
        return;
    }
    let line = Line::new(view.colour());
    if view.coasting {
        canvas.line(upright(view.bounds), line.dashed().with_weight(1.3));
        return;
    }
    canvas.line(upright(view.bounds), Line::new(view.colour().with_opacity(0.35)));
    // Emphasised corners make the box visible without covering the target.
    let (left, top, right, bottom) = (u as f32, v as f32, (u + w) as f32, (v + h) as f32);
    let arm = (w.min(h) as f32 * 0.28).min(canvas.style.scaled(22.0));
    for (corner_u, into_u) in [(left, arm), (right, -arm)] {
        for (corner_v, into_v) in [(top, arm), (bottom, -arm)] {
            let corner = [(corner_u + into_u, corner_v), (corner_u, corner_v), (corner_u, corner_v + into_v)];
            canvas.line(polyline(corner, false), line.with_weight(1.5));
        }
    }
}

fn draw_axes(canvas: &mut Canvas, view: &TargetView) {
    if let Some(shape) = view.shape {
        let (major, minor) = (shape.major_px / 2.0, shape.minor_px / 2.0);
        let axis = shape.axis.radians();
        let ends = |direction: f64, half: f64| {
            [towards(view.centre, direction, -half), towards(view.centre, direction, half)]
        };
        canvas
            .line(polyline(ends(axis + PI / 2.0, minor), false), Line::new(view.colour().with_opacity(0.6)));
        canvas.line(polyline(ends(axis, major), false), Line::new(view.colour()));
    }
    if let Some(heading) = view.heading.map(Angle::radians) {
        let reach = view.shape.map_or(view.bounds.w.min(view.bounds.h) / 2.0, |shape| shape.major_px / 2.0);
        let size = f64::from(canvas.style.scaled(12.0).max(7.0));
        let tip = towards(view.centre, heading, reach + size);
        let tip_point = PixelPoint { u: f64::from(tip.0), v: f64::from(tip.1) };
        let barb = |side: f64| towards(tip_point, heading + PI - side * 0.45, size);
        canvas.segment((view.centre.u as f32, view.centre.v as f32), tip, Line::new(view.colour()));
        let head = polyline([barb(1.0), tip, barb(-1.0)], true);
        canvas.line(head.clone(), Line::new(view.colour()));
        if let Some(head) = head {
            canvas.layer.fill(&head, view.colour());
        }
    }
}

/// Keeps labels off the line from the picture's centre to the target.
fn reserve_line(canvas: &Canvas, placement: &mut LabelPlacement, view: &TargetView) {
    let centre = canvas.layer.size().centre();
    let step = f64::from(canvas.style.text_px).max(1.0);
    let end = view.percept.r_px.min(libm::hypot(centre.u, centre.v));
    let mut along = 0.0;
    while along < end {
        let (u, v) = towards(centre, view.direction(), along);
        placement.reserve(PixelBox { u: f64::from(u) - 0.5, v: f64::from(v) - 0.5, w: 1.0, h: 1.0 });
        along += step;
    }
}

/// Labels r, the angle and P, each if there is room for it. The strip shows them, too.
pub(super) fn label(canvas: &mut Canvas, placement: &mut LabelPlacement, view: &TargetView) {
    let centre = canvas.layer.size().centre();
    let mut buffer = String::new();
    reserve_line(canvas, placement, view);

    let _ = write!(buffer, "P {:.2}", view.percept.p);
    let (w, h) = canvas.plate_size(&buffer);
    let PixelBox { u: left, v: top, w: across, h: down } = view.bounds;
    let (gap, middle) = (canvas.style.margin, view.bounds.centre());
    let at = |u: f64, v: f64| PixelPoint { u, v };
    let beside = [
        at(middle.u, top - gap - h / 2.0),
        at(middle.u, top + down + gap + h / 2.0),
        at(left + across + gap + w / 2.0, middle.v),
        at(left - gap - w / 2.0, middle.v),
    ];
    if let Some(place) = placement.place_at_first_free((w, h), beside) {
        let released = MotorSchema::is_released(&view.percept);
        canvas.plate(place);
        canvas.centred_text(&buffer, place, if released { Rgba::ACCENT } else { Rgba::LIGHT });
    }

    let Some(radius) = arc_radius(canvas, view) else { return };
    buffer.clear();
    buffer.push_str("angle ");
    text::push_signed(&mut buffer, view.percept.direction.degrees(), 1);
    buffer.push('°');
    let size = canvas.plate_size(&buffer);
    let direction = view.direction();
    let outside = |share: f64| {
        // The plate's centre is far enough out that its corner is clear of the arc.
        let clear = radius + gap + (size.0 * libm::cos(direction * share).abs() + size.1) / 2.0;
        let (u, v) = towards(centre, direction * share, clear);
        at(f64::from(u), f64::from(v))
    };
    let opposite = at(centre.u, centre.v + (size.1 / 2.0 + gap * 2.0).copysign(direction));
    let arc = [0.5, 0.35, 0.65].map(outside);
    if let Some(place) = placement.place_at_first_free(size, arc.into_iter().chain([opposite])) {
        canvas.plate(place);
        canvas.centred_text(&buffer, place, Rgba::LIGHT);
    }

    buffer.clear();
    let _ = write!(buffer, "r {:.0} px", view.percept.r_px);
    let size = canvas.plate_size(&buffer);
    let along = |share: f64, side: f64| {
        let (u, v) = towards(centre, direction, view.percept.r_px * share);
        let (s, c) = (libm::sin(direction), libm::cos(direction));
        // The distance from the line is the extent of the plate towards it.
        let off = side * (size.0 * s.abs() + size.1 * c.abs() + gap * 1.5) / 2.0;
        at(f64::from(u) - off * s, f64::from(v) - off * c)
    };
    // The side opposite to the arc is preferred.
    let side = if direction < 0.0 { -1.0 } else { 1.0 };
    let beside = [0.6, 0.7, 0.5].into_iter().flat_map(|share| [along(share, side), along(share, -side)]);
    if let Some(place) = placement.place_at_first_free(size, beside) {
        canvas.plate(place);
        canvas.centred_text(&buffer, place, Rgba::LIGHT);
    }
}
