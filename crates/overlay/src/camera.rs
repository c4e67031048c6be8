//! The camera's motion as an arrow near the picture's edge: filled where the command is in force, dashed where the
//! law would ask for it but the camera rests.

use barrelman_vocab::{CameraCommand, PixelBox, VehicleRates};
use tiny_skia::Path;

use super::pen::Pen;
use super::placement::LabelPlacement;
use super::scene::Scene;
use super::shapes::{Line, polyline};
use super::strip::strip_height;
use super::style::{Detail, Ink};
use super::text;

/// Remembers where the arrows were, so that they stay there while there is room.
#[derive(Debug, Default)]
pub(super) struct CameraArrow {
    pan_place: Option<usize>,
    tilt_place: Option<usize>,
    words: String,
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

/// Where the arrow may lie along its edge, in shares of that edge: its middle first.
const ALONG: [f64; 7] = [0.5, 0.36, 0.64, 0.25, 0.75, 0.14, 0.86];

impl CameraArrow {
    /// Draws an arrow for each axis that moves or would move.
    pub(super) fn draw(&mut self, pen: &mut Pen, placement: &mut LabelPlacement, scene: &Scene<'_>) {
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
            self.words.clear();
            if pen.style.detail == Detail::Full {
                write_label(&mut self.words, motion, shown, rates);
            }
            self.draw_one(pen, placement, motion);
        }
    }

    fn place_of(&mut self, axis: Axis) -> &mut Option<usize> {
        match axis {
            Axis::Pan => &mut self.pan_place,
            Axis::Tilt => &mut self.tilt_place,
        }
    }

    fn draw_one(&mut self, pen: &mut Pen, placement: &mut LabelPlacement, motion: Motion) {
        let length = f64::from(pen.style.scaled(84.0).max(10.0));
        let width = length * 0.36;
        let words = core::mem::take(&mut self.words);
        let plate = if words.is_empty() { None } else { Some(pen.plate_size(&words)) };
        let gap = pen.style.margin;
        // The label lies below a level arrow, and to the right of an upright one.
        let group = match (motion.axis, plate) {
            (Axis::Pan, Some((w, h))) => (length.max(w), width + gap + h),
            (Axis::Pan, None) => (length, width),
            (Axis::Tilt, Some((w, h))) => (width + gap + w, length.max(h)),
            (Axis::Tilt, None) => (width, length),
        };
        let clear = match motion.axis {
            Axis::Pan => gap * 2.0,
            // Above the strip, or below it.
            Axis::Tilt => strip_height(pen) + gap,
        };
        let choices = choices(placement.page(), motion, group, clear);
        if let Some(place) = placement.place_steadily(self.place_of(motion.axis), &choices) {
            let arrow = match motion.axis {
                Axis::Pan => {
                    let u = if motion.positive { place.u + place.w - length } else { place.u };
                    PixelBox { u, v: place.v, w: length, h: width }
                }
                Axis::Tilt => PixelBox { u: place.u, v: place.v, w: width, h: length },
            };
            draw_arrow(pen, arrow, motion);
            if let Some((w, h)) = plate {
                let at = match motion.axis {
                    Axis::Pan if motion.positive => (place.u + place.w - w, place.v + width + gap),
                    Axis::Pan => (place.u, place.v + width + gap),
                    Axis::Tilt => (place.u + width + gap, place.v + (place.h - h) / 2.0),
                };
                let label = PixelBox { u: at.0, v: at.1, w, h };
                pen.plate(label);
                pen.centred_text(&words, label, if motion.in_force { Ink::ACCENT } else { Ink::LIGHT });
            }
        }
        self.words = words;
    }
}

fn write_label(words: &mut String, motion: Motion, shown: CameraCommand, rates: Option<VehicleRates>) {
    let rate = match (motion.axis, rates) {
        (Axis::Pan, Some(rates)) => {
            words.push_str("yaw ");
            rates.yaw
        }
        (Axis::Tilt, Some(rates)) => {
            words.push_str("pitch ");
            rates.pitch
        }
        (Axis::Pan, None) => {
            words.push_str(if motion.in_force { "pan " } else { "would pan " });
            shown.pan
        }
        (Axis::Tilt, None) => {
            words.push_str(if motion.in_force { "tilt " } else { "would tilt " });
            shown.tilt
        }
    };
    text::push_signed(words, rate.radians_per_second(), 3);
    words.push_str(" rad/s");
}

/// The places of an arrow with its label: along the edge that it points to, and so far away from it.
fn choices(page: PixelBox, motion: Motion, (w, h): (f64, f64), gap: f64) -> [PixelBox; ALONG.len()] {
    let far = |edge: f64, extent: f64| if motion.positive { edge - extent - gap } else { gap };
    ALONG.map(|share| match motion.axis {
        Axis::Pan => PixelBox { u: far(page.w, w), v: page.h * share - h / 2.0, w, h },
        Axis::Tilt => {
            let v = if motion.positive { gap } else { page.h - h - gap };
            PixelBox { u: page.w * share - w / 2.0, v, w, h }
        }
    })
}

fn draw_arrow(pen: &mut Pen, place: PixelBox, motion: Motion) {
    let outline = arrow(place, motion);
    if motion.in_force {
        // The casing first, half of which the arrow covers.
        pen.line(outline.clone(), Line::of(Ink::DARK.at(0.5)).wide(1.4));
        if let Some(outline) = outline {
            pen.layer.fill(&outline, Ink::ACCENT);
        }
    } else {
        if let Some(outline) = &outline {
            pen.layer.fill(outline, Ink::DARK.at(0.25));
        }
        pen.line(outline, Line::of(Ink::LIGHT.at(0.9)).dashed());
    }
}

/// Outline of an arrow that fills a box.
fn arrow(place: PixelBox, motion: Motion) -> Option<Path> {
    // Along from the tail to the tip, and across from the middle to one side, in shares of the box.
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
