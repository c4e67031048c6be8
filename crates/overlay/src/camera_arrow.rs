//! The camera's motion as an arrow near the picture's edge: filled for the command in force, dashed for a
//! command that the law advises while the camera rests.

use barrelman_vocab::{CameraCommand, PixelBox, VehicleRates};
use tiny_skia::Path;

use super::canvas::Canvas;
use super::placement::LabelPlacement;
use super::scene::Scene;
use super::shapes::{Line, polyline};
use super::status_strip::strip_height;
use super::style::{Detail, Rgba};
use super::text;

/// Draws the arrows, and remembers their places to keep them while they are free.
#[derive(Debug, Default)]
pub(super) struct CameraArrow {
    pan_place: Option<usize>,
    tilt_place: Option<usize>,
    buffer: String,
}

/// One axis of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Axis {
    Pan,
    Tilt,
}

/// An arrow to draw.
#[derive(Debug, Clone, Copy)]
struct Motion {
    axis: Axis,
    /// Whether it points right or up.
    positive: bool,
    /// Whether it is in force.
    in_force: bool,
}

/// Possible positions of an arrow along its edge, in shares of the edge, in order of preference.
const ALONG: [f64; 7] = [0.5, 0.36, 0.64, 0.25, 0.75, 0.14, 0.86];

impl CameraArrow {
    /// Draws an arrow for each axis with a rate.
    pub(super) fn draw(&mut self, canvas: &mut Canvas, placement: &mut LabelPlacement, scene: &Scene<'_>) {
        let in_force = !scene.command.is_rest();
        let shown = match scene.advice {
            Some(advice) if !in_force => advice.command,
            _ => scene.command,
        };
        let rates = scene.rates.filter(|_| in_force);
        for (axis, rate) in [(Axis::Pan, shown.pan), (Axis::Tilt, shown.tilt)] {
            let rate = rate.radians_per_second();
            if rate == 0.0 || !rate.is_finite() {
                *self.place_of(axis) = None;
                continue;
            }
            let motion = Motion { axis, positive: rate > 0.0, in_force };
            self.buffer.clear();
            if canvas.style.detail == Detail::Full {
                write_label(&mut self.buffer, motion, shown, rates);
            }
            self.draw_one(canvas, placement, motion);
        }
    }

    fn place_of(&mut self, axis: Axis) -> &mut Option<usize> {
        match axis {
            Axis::Pan => &mut self.pan_place,
            Axis::Tilt => &mut self.tilt_place,
        }
    }

    fn draw_one(&mut self, canvas: &mut Canvas, placement: &mut LabelPlacement, motion: Motion) {
        let length = f64::from(canvas.style.scaled(84.0).max(10.0));
        let width = length * 0.36;
        let buffer = core::mem::take(&mut self.buffer);
        let plate = if buffer.is_empty() { None } else { Some(canvas.plate_size(&buffer)) };
        let gap = canvas.style.margin;
        // The label lies below a horizontal arrow, and to the right of a vertical one.
        let group = match (motion.axis, plate) {
            (Axis::Pan, Some((w, h))) => (length.max(w), width + gap + h),
            (Axis::Pan, None) => (length, width),
            (Axis::Tilt, Some((w, h))) => (width + gap + w, length.max(h)),
            (Axis::Tilt, None) => (width, length),
        };
        let clear = match motion.axis {
            Axis::Pan => gap * 2.0,
            // Above the strip, or below it.
            Axis::Tilt => strip_height(canvas) + gap,
        };
        let choices = choices(placement.picture_bounds(), motion, group, clear);
        if let Some(place) = placement.place_stable(self.place_of(motion.axis), &choices) {
            let arrow = match motion.axis {
                Axis::Pan => {
                    let u = if motion.positive { place.u + place.w - length } else { place.u };
                    PixelBox { u, v: place.v, w: length, h: width }
                }
                Axis::Tilt => PixelBox { u: place.u, v: place.v, w: width, h: length },
            };
            draw_arrow(canvas, arrow, motion);
            if let Some((w, h)) = plate {
                let at = match motion.axis {
                    Axis::Pan if motion.positive => (place.u + place.w - w, place.v + width + gap),
                    Axis::Pan => (place.u, place.v + width + gap),
                    Axis::Tilt => (place.u + width + gap, place.v + (place.h - h) / 2.0),
                };
                let label = PixelBox { u: at.0, v: at.1, w, h };
                canvas.plate(label);
                canvas.centred_text(&buffer, label, if motion.in_force { Rgba::ACCENT } else { Rgba::LIGHT });
            }
        }
        self.buffer = buffer;
    }
}

fn write_label(buffer: &mut String, motion: Motion, shown: CameraCommand, rates: Option<VehicleRates>) {
    // Pan is positive to the right and tilt upwards, as everywhere but on the vehicle's line.
    let shown = rates.map_or(shown, |rates| rates.in_the_senses_of(shown));
    let (name, rate) = match motion.axis {
        Axis::Pan => ("pan ", shown.pan),
        Axis::Tilt => ("tilt ", shown.tilt),
    };
    if !motion.in_force {
        buffer.push_str("would ");
    }
    buffer.push_str(name);
    text::push_signed(buffer, rate.radians_per_second(), 3);
    buffer.push_str(" rad/s");
}

/// The possible places of an arrow with its label: along the edge that the arrow points to, at a distance of
/// `gap`.
fn choices(
    picture_bounds: PixelBox,
    motion: Motion,
    (w, h): (f64, f64),
    gap: f64,
) -> [PixelBox; ALONG.len()] {
    let far = |edge: f64, extent: f64| if motion.positive { edge - extent - gap } else { gap };
    ALONG.map(|share| match motion.axis {
        Axis::Pan => PixelBox { u: far(picture_bounds.w, w), v: picture_bounds.h * share - h / 2.0, w, h },
        Axis::Tilt => {
            let v = if motion.positive { gap } else { picture_bounds.h - h - gap };
            PixelBox { u: picture_bounds.w * share - w / 2.0, v, w, h }
        }
    })
}

fn draw_arrow(canvas: &mut Canvas, place: PixelBox, motion: Motion) {
    let outline = arrow(place, motion);
    if motion.in_force {
        // The casing first: the arrow covers half of it.
        canvas.line(outline.clone(), Line::new(Rgba::DARK.with_opacity(0.5)).with_weight(1.4));
        if let Some(outline) = outline {
            canvas.layer.fill(&outline, Rgba::ACCENT);
        }
    } else {
        if let Some(outline) = &outline {
            canvas.layer.fill(outline, Rgba::DARK.with_opacity(0.25));
        }
        canvas.line(outline, Line::new(Rgba::LIGHT.with_opacity(0.9)).dashed());
    }
}

/// Outline of an arrow that fills a box.
fn arrow(place: PixelBox, motion: Motion) -> Option<Path> {
    // (along from tail to tip, across from the middle), in shares of the box.
    let outline =
        [(0.0, 0.15), (0.62, 0.15), (0.62, 0.5), (1.0, 0.0), (0.62, -0.5), (0.62, -0.15), (0.0, -0.15)];
    let middle = place.centre();
    let sense = if motion.positive { 1.0 } else { -1.0 };
    let points = outline.map(|(along, across)| {
        let along = sense * (along - 0.5);
        let (u, v) = match motion.axis {
            Axis::Pan => (middle.u + along * place.w, middle.v + across * place.h),
            Axis::Tilt => (middle.u + across * place.w, middle.v - along * place.h),
        };
        (u as f32, v as f32)
    });
    polyline(points, true)
}
