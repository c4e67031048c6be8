//! The status strip along the bottom, or along the top while the target is down there; and the banner of a lost
//! target.

use core::ops::Range;
use std::fmt::Write;

use barrelman_control::MotorSchema;
use barrelman_pilot::Mode;
use barrelman_vocab::{PixelBox, Timestamp, Track, VideoFrame};

use super::pen::Pen;
use super::placement::LabelPlacement;
use super::scene::Scene;
use super::shapes::PLATE;
use super::style::{Detail, Ink};
use super::target::TargetView;
use super::text;

/// Remembers where the strip is, and keeps its words' memory.
#[derive(Debug, Default)]
pub(super) struct Strip {
    place: Option<usize>,
    words: String,
    fields: Vec<Field>,
}

/// A value with its name in front.
#[derive(Debug, Clone)]
struct Field {
    name: &'static str,
    /// The value, in the strip's words.
    value: Range<usize>,
    /// The widest usual value: what is behind it stays where it is while figures come and go.
    widest: &'static str,
    look: FieldStyle,
    /// Fields with the lowest number are shown first where the picture is narrow.
    rank: u8,
}

/// The rank of the frame's number and time, which stand at the right.
const TIME_RANK: u8 = 4;
/// The highest rank.
const LAST_RANK: u8 = 7;

/// How a field is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FieldStyle {
    /// A value in its colour.
    Plain(Ink),
    /// A value on a plate of its own colour.
    Badge(Ink),
    /// A value with a dot in its colour in front.
    Dotted(Ink),
}

impl Strip {
    /// Draws the strip, and the banner where the target is lost.
    pub(super) fn draw(
        &mut self,
        pen: &mut Pen,
        placement: &mut LabelPlacement,
        frame: &VideoFrame,
        scene: &Scene<'_>,
        view: Option<&TargetView>,
    ) {
        let page = placement.page();
        let height = strip_height(pen);
        let bottom = PixelBox { u: 0.0, v: page.h - height, w: page.w, h: height };
        let choices = [bottom, PixelBox { v: 0.0, ..bottom }];
        // A target that reaches from the top to the bottom leaves no choice.
        let place = placement.place_steadily(&mut self.place, &choices).unwrap_or(bottom);

        self.words.clear();
        self.fields.clear();
        self.list_fields(scene, view, pen.style.detail);
        self.list_time(frame);
        pen.layer.fill_box(place, Ink::DARK.at(PLATE));
        self.lay_out(pen, place);
        if let Track::Lost { since, .. } = scene.track {
            self.draw_banner(pen, placement, frame.capture.at, *since);
        }
    }

    /// Adds a field; `value` writes into the strip's words.
    fn field(&mut self, field: Field, value: impl FnOnce(&mut String)) {
        let start = self.words.len();
        value(&mut self.words);
        self.fields.push(Field { value: start..self.words.len(), ..field });
    }

    fn list_fields(&mut self, scene: &Scene<'_>, view: Option<&TargetView>, detail: Detail) {
        let plain = |name, widest, rank| Field {
            name,
            value: 0..0,
            widest,
            look: FieldStyle::Plain(Ink::LIGHT),
            rank,
        };
        if let Some(mode) = scene.mode {
            let ink = match mode {
                Mode::Idle => Ink::QUIET,
                Mode::Servoing => Ink::ACCENT,
                Mode::Holding(_) => Ink::CAUTION,
                Mode::Stopped(_) => Ink::ALARM,
            };
            self.field(Field { look: FieldStyle::Badge(ink), ..plain("", "servoing", 0) }, |words| {
                let _ = write!(words, "{mode}");
            });
        }
        let (ink, state, confidence) = match scene.track {
            Track::Unseeded => (Ink::QUIET, "nothing selected", None),
            Track::Tracking(seen) => (Ink::ACCENT, "tracking", Some(seen.confidence)),
            Track::Coasting(seen) => (Ink::CAUTION, "coasting", Some(seen.confidence)),
            Track::Lost { confidence, .. } => (Ink::ALARM, "lost", Some(*confidence)),
        };
        self.field(Field { look: FieldStyle::Dotted(ink), ..plain("", "coasting", 1) }, |words| {
            words.push_str(state)
        });
        if let Some(confidence) = confidence {
            self.field(plain("confidence", "0.00", 5), |words| {
                let _ = write!(words, "{confidence:.2}");
            });
        }
        if let Some(percept) = view.map(|view| view.percept) {
            let ink = if MotorSchema::is_released(&percept) { Ink::ACCENT } else { Ink::LIGHT };
            self.field(Field { look: FieldStyle::Plain(ink), ..plain("P", "0.00", 2) }, |words| {
                let _ = write!(words, "{:.2}", percept.p);
            });
            self.field(plain("r", "000 px", 6), |words| {
                let _ = write!(words, "{:.0} px", percept.r_px);
            });
            self.field(plain("angle", "\u{2212}000.0°", 6), |words| {
                text::push_signed(words, percept.direction.degrees(), 1);
                words.push('°');
            });
        }
        let axes = match (scene.rates, scene.mode) {
            (Some(rates), _) => Some([("yaw", rates.yaw), ("pitch", rates.pitch)]),
            (None, Some(_)) => Some([("pan", scene.command.pan), ("tilt", scene.command.tilt)]),
            (None, None) => None,
        };
        for (name, rate) in axes.into_iter().flatten() {
            let moving = if rate.is_zero() { Ink::LIGHT } else { Ink::ACCENT };
            self.field(
                Field { look: FieldStyle::Plain(moving), ..plain(name, "\u{2212}0.000 rad/s", 3) },
                |words| {
                    text::push_signed(words, rate.radians_per_second(), 3);
                    words.push_str(" rad/s");
                },
            );
        }
        if let Some(link) = scene.link.filter(|_| detail == Detail::Full) {
            self.field(plain("link", "", 7), |words| words.push_str(link));
        }
    }

    /// Frame number and time of capture: the last two fields, which stand at the right.
    fn list_time(&mut self, frame: &VideoFrame) {
        let look = FieldStyle::Plain(Ink::LIGHT);
        self.field(Field { name: "frame", value: 0..0, widest: "", look, rank: TIME_RANK }, |words| {
            let _ = write!(words, "{}", frame.sequence);
        });
        self.field(Field { name: "", value: 0..0, widest: "", look, rank: TIME_RANK }, |words| {
            let _ = write!(words, "{}", frame.capture.at);
        });
    }

    fn lay_out(&mut self, pen: &mut Pen, place: PixelBox) {
        let text = f32::from(pen.style.text_px);
        let (gap, edge) = (text * 1.0, text * 0.5);
        let room = place.w as f32 - 2.0 * edge;
        self.keep_what_fits(pen, gap, room);
        let middle = place.centre().v as f32;
        // Frame and time, the only fields of their rank, stand at the right.
        let at_right = self.fields.iter().filter(|field| field.rank == TIME_RANK);
        let tail: f32 = at_right.map(|field| field.width(pen, &self.words) + gap).sum::<f32>() - gap;
        let mut u = place.u as f32 + edge;
        for field in self.fields.iter().filter(|field| field.rank != TIME_RANK) {
            field.draw(pen, &self.words, (u, middle));
            u += field.width(pen, &self.words) + gap;
        }
        u = (place.u + place.w) as f32 - edge - tail;
        for field in self.fields.iter().filter(|field| field.rank == TIME_RANK) {
            field.draw(pen, &self.words, (u, middle));
            u += field.width(pen, &self.words) + gap;
        }
    }

    /// Keeps the fields that there is room for, those of the lowest ranks first, all of a rank or none.
    fn keep_what_fits(&mut self, pen: &Pen, gap: f32, room: f32) {
        let mut left = room + gap;
        for rank in 0..=LAST_RANK {
            let of_rank = self.fields.iter().filter(|field| field.rank == rank);
            let needed: f32 = of_rank.map(|field| field.width(pen, &self.words) + gap).sum();
            if needed <= left {
                left -= needed;
            } else {
                self.fields.retain(|field| field.rank != rank);
            }
        }
    }

    fn draw_banner(
        &mut self,
        pen: &mut Pen,
        placement: &mut LabelPlacement,
        now: Timestamp,
        since: Timestamp,
    ) {
        self.words.clear();
        let _ = write!(self.words, "target lost for {:.1} s", now.since(since).as_secs_f64());
        let (w, h) = pen.plate_size(&self.words);
        let (w, h) = (w * 1.25, h * 1.35);
        let page = placement.page();
        // Below where the strip may be, and above the region.
        let v = (page.h * 0.16 - h / 2.0).max(strip_height(pen) + pen.style.margin);
        let place = PixelBox { u: (page.w - w) / 2.0, v, w, h };
        placement.reserve(place);
        pen.rounded(place, Ink::ALARM.at(0.92));
        pen.centred_text(&self.words, place, Ink::LIGHT);
    }
}

/// Height of the strip, pixels.
pub(super) fn strip_height(pen: &Pen) -> f64 {
    (f64::from(pen.style.text_px) * 1.7).round()
}

impl Field {
    fn value<'w>(&self, words: &'w str) -> &'w str {
        &words[self.value.clone()]
    }

    fn width(&self, pen: &Pen, words: &str) -> f32 {
        let size = pen.style.text_px;
        let text = f32::from(size);
        let width = |text: &str| pen.type_face.width(text, size);
        let value = width(self.value(words)).max(width(self.widest));
        let name = if self.name.is_empty() { 0.0 } else { width(self.name) + text * 0.35 };
        name + match self.look {
            FieldStyle::Plain(_) => value,
            FieldStyle::Badge(_) => value + text * 0.9,
            FieldStyle::Dotted(_) => value + text * 0.75,
        }
    }

    fn draw(&self, pen: &mut Pen, words: &str, (mut u, middle): (f32, f32)) {
        let text = f32::from(pen.style.text_px);
        if !self.name.is_empty() {
            u = pen.text(self.name, (u, middle), Ink::QUIET) + text * 0.35;
        }
        let value = self.value(words);
        match self.look {
            FieldStyle::Plain(ink) => {
                pen.text(value, (u, middle), ink);
            }
            FieldStyle::Dotted(ink) => {
                pen.dot((u + text * 0.25, middle), text * 0.22, ink);
                pen.text(value, (u + text * 0.75, middle), Ink::LIGHT);
            }
            FieldStyle::Badge(ink) => {
                let (w, h) = (f64::from(self.width(pen, words)), f64::from(text * 1.25));
                let plate = PixelBox { u: f64::from(u), v: f64::from(middle) - h / 2.0, w, h };
                pen.rounded(plate, ink);
                let on = if ink == Ink::ALARM { Ink::LIGHT } else { Ink::DARK };
                pen.centred_text(value, plate, on);
            }
        }
    }
}
