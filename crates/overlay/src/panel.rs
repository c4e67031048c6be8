//! What the tracker goes by: its search window in the picture, and in a corner its own word for its state with its
//! confidence, how much each pixel that was looked at is like the target (the back projection), how well the target's
//! pattern fits at each place (the response), and the target's hues (the histogram). What a tracker does not have is
//! left out.

use std::fmt::Write;

use barrelman_vision::{Explanation, GreyMap, TrackerState};
use barrelman_vocab::PixelBox;

use super::pen::Pen;
use super::placement::LabelPlacement;
use super::shapes::{Line, upright};
use super::strip::strip_height;
use super::style::{Detail, Ink};

/// Remembers which corner the panel is in.
#[derive(Debug, Default)]
pub(super) struct Panel {
    corner: Option<usize>,
    /// The column of the map that each column of its picture shows; none beyond the map.
    columns: Vec<Option<usize>>,
    words: String,
}

/// A map, the part of the picture that is shown of it, and how.
struct Inset<'e> {
    map: &'e GreyMap,
    part: PixelBox,
    name: &'static str,
    ink: Ink,
}

/// A map is at least this many times as high as a line of text: less shows nothing.
const MIN_SIDE_TEXTS: f64 = 4.5;

/// Where the parts of a panel go, pixels.
struct Layout {
    /// Left and right of everything, and between things.
    pad: f64,
    /// Width within the pads.
    width: f64,
    /// Height of a line of words.
    line: f64,
    /// Height of the bar of the confidence.
    bar: f64,
    /// Width and height of what each map has.
    cell: (f64, f64),
    /// Height of the histogram.
    hues: f64,
}

/// Draws where the next frame's search starts.
pub(super) fn draw_search_window(pen: &mut Pen, window: PixelBox) {
    let window = window.clipped(pen.layer.size());
    if !window.is_empty() {
        pen.line(upright(window), Line::of(Ink::LIGHT.at(0.7)).dashed());
    }
}

impl Panel {
    /// Draws the panel in a corner where it covers nothing, if there is one. `target` is outlined in the maps.
    pub(super) fn draw(
        &mut self,
        pen: &mut Pen,
        placement: &mut LabelPlacement,
        explanation: &Explanation,
        target: Option<PixelBox>,
    ) {
        let insets = insets_of(explanation);
        let bins = &explanation.histogram;
        if explanation.state.is_none() && insets.is_empty() && bins.is_empty() {
            self.corner = None;
            return;
        }
        let layout = Layout::of(pen, placement.page(), insets.len(), bins.is_empty());
        let Layout { pad, width, line, bar, cell, hues } = layout;
        let head = if explanation.state.is_some() { line + bar + pad } else { 0.0 };
        let maps = if insets.is_empty() { 0.0 } else { line + cell.1 + pad };
        let strip = if bins.is_empty() { 0.0 } else { hues + pad };
        let (w, h) = (width + 2.0 * pad, pad / 2.0 + head + maps + strip);

        // The strip's height is left free at both edges, so that the panel need not move when the strip does.
        let page = placement.page();
        let (left, right) = (pen.style.margin, page.w - w - pen.style.margin);
        let edge = strip_height(pen) + pen.style.margin;
        let (top, bottom) = (edge, page.h - h - edge);
        let corners = [(right, top), (left, top), (right, bottom), (left, bottom)];
        let corners = corners.map(|(u, v)| PixelBox { u: u.round(), v: v.round(), w, h });
        let Some(place) = placement.place_steadily(&mut self.corner, &corners) else { return };

        pen.plate(place);
        let (u, mut v) = (place.u + pad, place.v + pad / 2.0);
        if let Some(stage) = explanation.state {
            let body = PixelBox { u, v, w: width, h: line };
            self.draw_head(pen, body, bar, stage, explanation.confidence);
            v += head;
        }
        for (index, inset) in insets.iter().enumerate() {
            let u = u + index as f64 * (cell.0 + pad);
            pen.text(inset.name, (u as f32, (v + line / 2.0) as f32), Ink::QUIET);
            let body = PixelBox { u, v: v + line, w: cell.0, h: cell.1 };
            draw_inset(pen, body, inset, target, &mut self.columns);
        }
        draw_hues(pen, PixelBox { u, v: v + maps, w: width, h: hues }, bins);
    }

    /// Draws the tracker's word for its state, and its confidence as a number over a bar.
    fn draw_head(&mut self, pen: &mut Pen, body: PixelBox, bar: f64, stage: TrackerState, confidence: f64) {
        let (ink, word) = match stage {
            TrackerState::Tracking => (Ink::ACCENT, "tracking"),
            TrackerState::Coasting => (Ink::CAUTION, "coasting"),
            TrackerState::Lost => (Ink::ALARM, "lost"),
            TrackerState::Confirming => (Ink::CAUTION, "confirming"),
        };
        let text = f32::from(pen.style.text_px);
        let middle = body.centre().v as f32;
        pen.dot((body.u as f32 + text * 0.25, middle), text * 0.22, ink);
        pen.text(word, (body.u as f32 + text * 0.75, middle), Ink::LIGHT);
        let share = if confidence.is_finite() { confidence.clamp(0.0, 1.0) } else { 0.0 };
        self.words.clear();
        // Writing into a string cannot fail.
        let _ = write!(self.words, "{share:.2}");
        let width = pen.type_face.width(&self.words, pen.style.text_px);
        pen.text(&self.words, ((body.u + body.w) as f32 - width, middle), Ink::LIGHT);
        let place = PixelBox { v: (body.v + body.h).round(), h: bar, ..body };
        pen.layer.fill_box(place, Ink::QUIET.at(0.35));
        pen.layer.fill_box(PixelBox { w: (body.w * share).round(), ..place }, ink);
    }
}

impl Layout {
    fn of(pen: &Pen, page: PixelBox, insets: usize, without_hues: bool) -> Self {
        let text = f64::from(pen.style.text_px);
        let pad = (text * 0.5).round();
        let share = if pen.style.detail == Detail::Full { 0.16 } else { 0.28 };
        let side = (page.h.min(page.w * 9.0 / 16.0) * share).max(MIN_SIDE_TEXTS * text).round();
        let (cell, width) = if insets > 1 {
            ((side, side), 2.0 * side + pad)
        } else {
            let width = (side * 16.0 / 9.0).round();
            ((width, side), width)
        };
        Self {
            pad,
            width,
            line: (text * 1.4).round(),
            bar: f64::from(pen.style.scaled(6.0)).max(3.0).round(),
            cell,
            hues: if without_hues { 0.0 } else { (page.h * 0.05).round() },
        }
    }
}

/// What there is to show. Where there is a response, both maps show the same part of the picture.
fn insets_of(explanation: &Explanation) -> Vec<Inset<'_>> {
    let usable = |map: &GreyMap| {
        let PixelBox { u, v, w, h } = map.bounds;
        let sound = [u, v, w, h].iter().all(|side| side.abs() < 1e6) && w > 0.0 && h > 0.0;
        sound && map.width > 0 && map.height > 0 && map.samples.len() >= map.width * map.height
    };
    let (likeness, response) = (&explanation.back_projection, &explanation.response);
    let mut insets = Vec::with_capacity(2);
    if usable(likeness) {
        let part = if usable(response) { response.bounds } else { likeness.bounds };
        insets.push(Inset { map: likeness, part, name: "likeness", ink: Ink::ACCENT });
    }
    if usable(response) {
        insets.push(Inset { map: response, part: response.bounds, name: "response", ink: Ink::PATTERN });
    }
    insets
}

/// Draws a part of a map as large as it fits into a box, from the plate's dark over the map's colour to white.
fn draw_inset(
    pen: &mut Pen,
    body: PixelBox,
    inset: &Inset<'_>,
    target: Option<PixelBox>,
    columns: &mut Vec<Option<usize>>,
) {
    let Inset { map, part, ink, .. } = *inset;
    let scale = (body.w / part.w).min(body.h / part.h);
    let (w, h) = ((part.w * scale).round().max(1.0), (part.h * scale).round().max(1.0));
    let place =
        PixelBox { u: (body.u + (body.w - w) / 2.0).round(), v: (body.v + (body.h - h) / 2.0).round(), w, h };
    pen.layer.fill_box(body, Ink::DARK.at(0.6));
    let sample = |at: f64, start: f64, extent: f64, samples: usize| {
        let index = ((at - start) / extent * samples as f64).floor();
        (0.0..samples as f64).contains(&index).then_some(index as usize)
    };
    let column_at = |column: usize| part.u + (column as f64 + 0.5) / w * part.w;
    let row_at = |row: usize| part.v + (row as f64 + 0.5) / h * part.h;
    columns.clear();
    columns.extend(
        (0..w as usize).map(|column| sample(column_at(column), map.bounds.u, map.bounds.w, map.width)),
    );
    let colours: [Ink; 256] = core::array::from_fn(|value| heat(value as u8, ink));
    let (mut last, mut start) = (usize::MAX, None);
    pen.layer.paint(place, |column, row| {
        if row != last {
            (last, start) = (row, sample(row_at(row), map.bounds.v, map.bounds.h, map.height));
        }
        let value =
            start.zip(columns[column]).map_or(0, |(row, column)| map.samples[row * map.width + column]);
        colours[usize::from(value)]
    });
    if let Some(target) = target {
        let shown = PixelBox {
            u: place.u + (target.u - part.u) * scale,
            v: place.v + (target.v - part.v) * scale,
            w: target.w * scale,
            h: target.h * scale,
        };
        let shown = shown.intersection(place);
        if !shown.is_empty() {
            pen.line(upright(shown), Line::of(Ink::LIGHT.at(0.6)).wide(0.6));
        }
    }
}

/// From the plate's dark over a colour to white.
fn heat(value: u8, ink: Ink) -> Ink {
    let share = f32::from(value) / 255.0;
    let (from, to, share) =
        if share < 0.7 { (Ink::DARK, ink, share / 0.7) } else { (ink, Ink::LIGHT, (share - 0.7) / 0.3) };
    let mix = |from: u8, to: u8| (f32::from(from) + (f32::from(to) - f32::from(from)) * share) as u8;
    Ink {
        red: mix(from.red, to.red),
        green: mix(from.green, to.green),
        blue: mix(from.blue, to.blue),
        opacity: 255,
    }
}

/// Draws a bar for each bin of a histogram of hues, in its hue's colour. A thin line below names the hue of each.
fn draw_hues(pen: &mut Pen, place: PixelBox, bins: &[u8]) {
    if bins.is_empty() {
        return;
    }
    let width = place.w / bins.len() as f64;
    let base = f64::from(pen.style.scaled(2.0).max(1.0)).round();
    // Between bars that are wide enough, so that neighbours are told apart.
    let space = if width >= 4.0 { 1.0 } else { 0.0 };
    for (index, bin) in bins.iter().enumerate() {
        let ink = pure_hue((index as f32 + 0.5) / bins.len() as f32);
        let (u, bottom) = (place.u + index as f64 * width, place.v + place.h);
        pen.layer.fill_box(PixelBox { u, v: bottom - base, w: width, h: base }, ink);
        let h = (place.h - base) * f64::from(*bin) / 255.0;
        if h >= 0.5 {
            pen.layer.fill_box(PixelBox { u, v: bottom - base - h, w: width - space, h }, ink);
        }
    }
}

/// The brightest colour of a hue, given as a share of the circle from red over green and blue.
fn pure_hue(turn: f32) -> Ink {
    let channel = |shift: f32| {
        let away = ((turn + shift).rem_euclid(1.0) * 6.0 - 3.0).abs() - 1.0;
        (away.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
    };
    Ink { red: channel(0.0), green: channel(2.0 / 3.0), blue: channel(1.0 / 3.0), opacity: 255 }
}
