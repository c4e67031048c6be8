//! The status strip along the bottom, or along the top while the target is at the bottom, and the banner of a
//! lost target.

use core::ops::Range;
use std::fmt::Write;

use barrelman_control::MotorSchema;
use barrelman_pilot::Mode;
use barrelman_vocab::{PixelBox, Timestamp, Track, VideoFrame};

use super::canvas::Canvas;
use super::placement::LabelPlacement;
use super::scene::Scene;
use super::shapes::PLATE;
use super::style::{Detail, Rgba};
use super::target::TargetView;
use super::text;

/// Draws the strip, remembers its place, and reuses its buffers.
#[derive(Debug, Default)]
pub(super) struct StatusStrip {
    place: Option<usize>,
    buffer: String,
    fields: Vec<Field>,
}

/// A value with its name in front.
#[derive(Debug, Clone)]
struct Field {
    name: &'static str,
    /// Range of the value in the strip's buffer.
    value: Range<usize>,
    /// The widest usual value: the following fields keep their places while digits come and go.
    widest: &'static str,
    style: FieldStyle,
    /// In a narrow picture the fields of the lowest ranks are kept.
    rank: u8,
}

impl Field {
    /// A field in the usual colour, without a value yet.
    const fn plain(name: &'static str, widest: &'static str, rank: u8) -> Self {
        Self { name, value: 0..0, widest, style: FieldStyle::Plain(Rgba::LIGHT), rank }
    }
}

/// The rank of frame number and time, at the right end.
const TIME_RANK: u8 = 4;
/// The highest rank.
const LAST_RANK: u8 = 7;

/// Style of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FieldStyle {
    /// A value in its colour.
    Plain(Rgba),
    /// A value on a plate of its own colour.
    Badge(Rgba),
    /// A value with a dot in its colour in front.
    Dotted(Rgba),
}

impl StatusStrip {
    /// Draws the strip, and for a lost target the banner.
    pub(super) fn draw(
        &mut self,
        canvas: &mut Canvas,
        placement: &mut LabelPlacement,
        frame: &VideoFrame,
        scene: &Scene<'_>,
        view: Option<&TargetView>,
    ) {
        let picture_bounds = placement.picture_bounds();
        let height = strip_height(canvas);
        let bottom = PixelBox { u: 0.0, v: picture_bounds.h - height, w: picture_bounds.w, h: height };
        let choices = [bottom, PixelBox { v: 0.0, ..bottom }];
        // With a target from the top to the bottom, the strip covers part of it.
        let place = placement.place_stable(&mut self.place, &choices).unwrap_or(bottom);

        self.buffer.clear();
        self.fields.clear();
        self.list_fields(scene, view, canvas.style.detail);
        self.list_time(frame, scene.time_of_day);
        canvas.layer.fill_box(place, Rgba::DARK.with_opacity(PLATE));
        self.lay_out(canvas, place);
        if let Track::Lost { since, .. } = scene.track {
            self.draw_banner(canvas, placement, frame.capture.at, *since);
        }
    }

    /// Adds a field. `value` writes the value to the strip's buffer.
    fn field(&mut self, field: Field, value: impl FnOnce(&mut String)) {
        let start = self.buffer.len();
        value(&mut self.buffer);
        self.fields.push(Field { value: start..self.buffer.len(), ..field });
    }

    fn list_fields(&mut self, scene: &Scene<'_>, view: Option<&TargetView>, detail: Detail) {
        if let Some(mode) = scene.mode {
            let colour = match mode {
                Mode::Idle => Rgba::QUIET,
                Mode::Servoing | Mode::Nudging | Mode::Searching | Mode::Calibrating => Rgba::ACCENT,
                Mode::Holding(_) => Rgba::CAUTION,
                Mode::Stopped(_) => Rgba::ALARM,
            };
            self.field(
                Field { style: FieldStyle::Badge(colour), ..Field::plain("", "servoing", 0) },
                |buffer| {
                    let _ = write!(buffer, "{mode}");
                },
            );
        }
        let (colour, state, confidence) = match scene.track {
            Track::Unseeded => (Rgba::QUIET, "nothing selected", None),
            Track::Tracking(seen) => (Rgba::ACCENT, "tracking", Some(seen.confidence)),
            Track::Coasting(seen) => (Rgba::CAUTION, "coasting", Some(seen.confidence)),
            Track::Lost { confidence, .. } => (Rgba::ALARM, "lost", Some(*confidence)),
        };
        self.field(
            Field { style: FieldStyle::Dotted(colour), ..Field::plain("", "coasting", 1) },
            |buffer| buffer.push_str(state),
        );
        if let Some(confidence) = confidence {
            self.field(Field::plain("confidence", "0.00", 5), |buffer| {
                let _ = write!(buffer, "{confidence:.2}");
            });
        }
        if let Some(percept) = view.map(|view| view.percept) {
            let colour = if MotorSchema::is_released(&percept) { Rgba::ACCENT } else { Rgba::LIGHT };
            self.field(
                Field { style: FieldStyle::Plain(colour), ..Field::plain("P", "0.00", 2) },
                |buffer| {
                    let _ = write!(buffer, "{:.2}", percept.p);
                },
            );
            self.field(Field::plain("r", "000 px", 6), |buffer| {
                let _ = write!(buffer, "{:.0} px", percept.r_px);
            });
            self.field(Field::plain("angle", "\u{2212}000.0°", 6), |buffer| {
                text::push_signed(buffer, percept.direction.degrees(), 1);
                buffer.push('°');
            });
        }
        self.list_rates(scene);
        if let Some(link) = scene.link.filter(|_| detail == Detail::Full) {
            self.field(Field::plain("link", "", 7), |buffer| buffer.push_str(link));
        }
    }

    /// Adds the rates of the camera's axes: those that were sent, or else those that were commanded.
    fn list_rates(&mut self, scene: &Scene<'_>) {
        let axes = match (scene.rates, scene.mode) {
            (Some(rates), _) => Some(rates.in_the_senses_of(scene.command)),
            (None, Some(_)) => Some(scene.command),
            (None, None) => None,
        };
        let axes = axes.map(|command| [("pan", command.pan), ("tilt", command.tilt)]);
        for (name, rate) in axes.into_iter().flatten() {
            let moving = if rate.is_zero() { Rgba::LIGHT } else { Rgba::ACCENT };
            self.field(
                Field { style: FieldStyle::Plain(moving), ..Field::plain(name, "\u{2212}0.000 rad/s", 3) },
                |buffer| {
                    text::push_signed(buffer, rate.radians_per_second(), 3);
                    buffer.push_str(" rad/s");
                },
            );
        }
    }

    /// Adds frame number and time of capture: the last two fields, at the right end.
    fn list_time(&mut self, frame: &VideoFrame, time_of_day: Option<&str>) {
        let style = FieldStyle::Plain(Rgba::LIGHT);
        self.field(Field { name: "frame", value: 0..0, widest: "", style, rank: TIME_RANK }, |buffer| {
            let _ = write!(buffer, "{}", frame.sequence);
        });
        self.field(Field { name: "", value: 0..0, widest: "", style, rank: TIME_RANK }, |buffer| {
            match time_of_day {
                Some(time) => buffer.push_str(time),
                None => drop(write!(buffer, "{}", frame.capture.at)),
            }
        });
    }

    fn lay_out(&mut self, canvas: &mut Canvas, place: PixelBox) {
        let text = f32::from(canvas.style.text_px);
        let (gap, edge) = (text * 1.0, text * 0.5);
        let room = place.w as f32 - 2.0 * edge;
        self.remove_overflow(canvas, gap, room);
        let middle = place.centre().v as f32;
        // Frame number and time, the only fields of their rank, are at the right end.
        let at_right = self.fields.iter().filter(|field| field.rank == TIME_RANK);
        let tail: f32 = at_right.map(|field| field.width(canvas, &self.buffer) + gap).sum::<f32>() - gap;
        let mut u = place.u as f32 + edge;
        for field in self.fields.iter().filter(|field| field.rank != TIME_RANK) {
            field.draw(canvas, &self.buffer, (u, middle));
            u += field.width(canvas, &self.buffer) + gap;
        }
        u = (place.u + place.w) as f32 - edge - tail;
        for field in self.fields.iter().filter(|field| field.rank == TIME_RANK) {
            field.draw(canvas, &self.buffer, (u, middle));
            u += field.width(canvas, &self.buffer) + gap;
        }
    }

    /// Removes the fields that do not fit, the highest ranks first, all fields of a rank or none.
    fn remove_overflow(&mut self, canvas: &Canvas, gap: f32, room: f32) {
        let mut left = room + gap;
        for rank in 0..=LAST_RANK {
            let of_rank = self.fields.iter().filter(|field| field.rank == rank);
            let needed: f32 = of_rank.map(|field| field.width(canvas, &self.buffer) + gap).sum();
            if needed <= left {
                left -= needed;
            } else {
                self.fields.retain(|field| field.rank != rank);
            }
        }
    }

    fn draw_banner(
        &mut self,
        canvas: &mut Canvas,
        placement: &mut LabelPlacement,
        now: Timestamp,
        since: Timestamp,
    ) {
        self.buffer.clear();
        let _ = write!(self.buffer, "target lost for {:.1} s", now.since(since).as_secs_f64());
        let (w, h) = canvas.plate_size(&self.buffer);
        let (w, h) = (w * 1.25, h * 1.35);
        let picture_bounds = placement.picture_bounds();
        // Below the strip's upper place, and above the region.
        let v = (picture_bounds.h * 0.16 - h / 2.0).max(strip_height(canvas) + canvas.style.margin);
        let place = PixelBox { u: (picture_bounds.w - w) / 2.0, v, w, h };
        placement.reserve(place);
        canvas.rounded(place, Rgba::ALARM.with_opacity(0.92));
        canvas.centred_text(&self.buffer, place, Rgba::LIGHT);
    }
}

/// Height of the strip, pixels.
pub(super) fn strip_height(canvas: &Canvas) -> f64 {
    (f64::from(canvas.style.text_px) * 1.7).round()
}

impl Field {
    fn value<'w>(&self, buffer: &'w str) -> &'w str {
        &buffer[self.value.clone()]
    }

    fn width(&self, canvas: &Canvas, buffer: &str) -> f32 {
        let size = canvas.style.text_px;
        let text = f32::from(size);
        let width = |text: &str| canvas.type_face.width(text, size);
        let value = width(self.value(buffer)).max(width(self.widest));
        let name = if self.name.is_empty() { 0.0 } else { width(self.name) + text * 0.35 };
        name + match self.style {
            FieldStyle::Plain(_) => value,
            FieldStyle::Badge(_) => value + text * 0.9,
            FieldStyle::Dotted(_) => value + text * 0.75,
        }
    }

    fn draw(&self, canvas: &mut Canvas, buffer: &str, (mut u, middle): (f32, f32)) {
        let text = f32::from(canvas.style.text_px);
        if !self.name.is_empty() {
            u = canvas.text(self.name, (u, middle), Rgba::QUIET) + text * 0.35;
        }
        let value = self.value(buffer);
        match self.style {
            FieldStyle::Plain(colour) => {
                canvas.text(value, (u, middle), colour);
            }
            FieldStyle::Dotted(colour) => {
                canvas.dot((u + text * 0.25, middle), text * 0.22, colour);
                canvas.text(value, (u + text * 0.75, middle), Rgba::LIGHT);
            }
            FieldStyle::Badge(colour) => {
                let (w, h) = (f64::from(self.width(canvas, buffer)), f64::from(text * 1.25));
                let plate = PixelBox { u: f64::from(u), v: f64::from(middle) - h / 2.0, w, h };
                canvas.rounded(plate, colour);
                let on = if colour == Rgba::ALARM { Rgba::LIGHT } else { Rgba::DARK };
                canvas.centred_text(value, plate, on);
            }
        }
    }
}
