//! The tracker's explanation: the search window in the picture, and a panel in a corner with the tracker's
//! state and confidence, the target probability of the examined pixels (back projection), the response of the
//! correlation filter, and the hue histogram. Parts that a tracker does not have are left out.

use std::fmt::Write;

use barrelman_vision::{Explanation, GreyMap, TrackerState};
use barrelman_vocab::PixelBox;

use super::canvas::Canvas;
use super::placement::LabelPlacement;
use super::shapes::{Line, upright};
use super::status_strip::strip_height;
use super::style::{Detail, Rgba};

/// Draws the panel, and remembers its corner.
#[derive(Debug, Default)]
pub(super) struct TrackerPanel {
    corner: Option<usize>,
    /// The column of the map for each column of the drawn map; `None` beyond the map.
    columns: Vec<Option<usize>>,
    buffer: String,
}

/// A map with its name and colour, and the part of it that is drawn.
struct Inset<'e> {
    map: &'e GreyMap,
    part: PixelBox,
    name: &'static str,
    colour: Rgba,
}

/// Minimum height of a map, in heights of a line of text.
const MIN_SIDE_TEXTS: f64 = 4.5;

/// Dimensions of a panel, pixels.
struct Layout {
    /// Padding at the sides and between the parts.
    pad: f64,
    /// Width without the padding.
    width: f64,
    /// Height of a line of text.
    line: f64,
    /// Height of the bar of the confidence.
    bar: f64,
    /// Width and height of the space for a map.
    cell: (f64, f64),
    /// Height of the histogram.
    hues: f64,
}

/// Draws the search window of the next frame.
pub(super) fn draw_search_window(canvas: &mut Canvas, window: PixelBox) {
    let window = window.clipped(canvas.layer.size());
    if !window.is_empty() {
        canvas.line(upright(window), Line::new(Rgba::LIGHT.with_opacity(0.7)).dashed());
    }
}

impl TrackerPanel {
    /// Draws the panel in a free corner, if there is one. `target` is outlined in the maps.
    pub(super) fn draw(
        &mut self,
        canvas: &mut Canvas,
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
        let layout = Layout::new(canvas, placement.picture_bounds(), insets.len(), bins.is_empty());
        let Layout { pad, width, line, bar, cell, hues } = layout;
        let head = if explanation.state.is_some() { line + bar + pad } else { 0.0 };
        let maps = if insets.is_empty() { 0.0 } else { line + cell.1 + pad };
        let strip = if bins.is_empty() { 0.0 } else { hues + pad };
        let (w, h) = (width + 2.0 * pad, pad / 2.0 + head + maps + strip);

        // The height of the strip stays free at both edges, so that the panel does not move with the strip.
        let picture_bounds = placement.picture_bounds();
        let (left, right) = (canvas.style.margin, picture_bounds.w - w - canvas.style.margin);
        let edge = strip_height(canvas) + canvas.style.margin;
        let (top, bottom) = (edge, picture_bounds.h - h - edge);
        let corners = [(right, top), (left, top), (right, bottom), (left, bottom)];
        let corners = corners.map(|(u, v)| PixelBox { u: u.round(), v: v.round(), w, h });
        let Some(place) = placement.place_stable(&mut self.corner, &corners) else { return };

        canvas.plate(place);
        let (u, mut v) = (place.u + pad, place.v + pad / 2.0);
        if let Some(state) = explanation.state {
            let body = PixelBox { u, v, w: width, h: line };
            self.draw_head(canvas, body, bar, state, explanation.confidence);
            v += head;
        }
        for (index, inset) in insets.iter().enumerate() {
            let u = u + index as f64 * (cell.0 + pad);
            canvas.text(inset.name, (u as f32, (v + line / 2.0) as f32), Rgba::QUIET);
            let body = PixelBox { u, v: v + line, w: cell.0, h: cell.1 };
            draw_inset(canvas, body, inset, target, &mut self.columns);
        }
        draw_hues(canvas, PixelBox { u, v: v + maps, w: width, h: hues }, bins);
    }

    /// Draws the tracker's state, and its confidence as a number over a bar.
    fn draw_head(
        &mut self,
        canvas: &mut Canvas,
        body: PixelBox,
        bar: f64,
        state: TrackerState,
        confidence: f64,
    ) {
        let (colour, word) = match state {
            TrackerState::Tracking => (Rgba::ACCENT, "tracking"),
            TrackerState::Coasting => (Rgba::CAUTION, "coasting"),
            TrackerState::Lost => (Rgba::ALARM, "lost"),
            TrackerState::Confirming => (Rgba::CAUTION, "confirming"),
        };
        let text = f32::from(canvas.style.text_px);
        let middle = body.centre().v as f32;
        canvas.dot((body.u as f32 + text * 0.25, middle), text * 0.22, colour);
        canvas.text(word, (body.u as f32 + text * 0.75, middle), Rgba::LIGHT);
        let share = if confidence.is_finite() { confidence.clamp(0.0, 1.0) } else { 0.0 };
        self.buffer.clear();
        // Writing into a string cannot fail.
        let _ = write!(self.buffer, "{share:.2}");
        let width = canvas.type_face.width(&self.buffer, canvas.style.text_px);
        canvas.text(&self.buffer, ((body.u + body.w) as f32 - width, middle), Rgba::LIGHT);
        let place = PixelBox { v: (body.v + body.h).round(), h: bar, ..body };
        canvas.layer.fill_box(place, Rgba::QUIET.with_opacity(0.35));
        canvas.layer.fill_box(PixelBox { w: (body.w * share).round(), ..place }, colour);
    }
}

impl Layout {
    fn new(canvas: &Canvas, picture_bounds: PixelBox, insets: usize, without_hues: bool) -> Self {
        let text = f64::from(canvas.style.text_px);
        let pad = (text * 0.5).round();
        let share = if canvas.style.detail == Detail::Full { 0.16 } else { 0.28 };
        let side =
            (picture_bounds.h.min(picture_bounds.w * 9.0 / 16.0) * share).max(MIN_SIDE_TEXTS * text).round();
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
            bar: f64::from(canvas.style.scaled(6.0)).max(3.0).round(),
            cell,
            hues: if without_hues { 0.0 } else { (picture_bounds.h * 0.05).round() },
        }
    }
}

/// The maps to draw. With a response, both maps show the same part of the picture.
fn insets_of(explanation: &Explanation) -> Vec<Inset<'_>> {
    let usable = |map: &GreyMap| {
        let PixelBox { u, v, w, h } = map.bounds;
        let is_usable = [u, v, w, h].iter().all(|side| side.abs() < 1e6) && w > 0.0 && h > 0.0;
        is_usable && map.width > 0 && map.height > 0 && map.samples.len() >= map.width * map.height
    };
    let (probability, response) = (&explanation.back_projection, &explanation.response);
    let mut insets = Vec::with_capacity(2);
    if usable(probability) {
        let part = if usable(response) { response.bounds } else { probability.bounds };
        insets.push(Inset { map: probability, part, name: "likeness", colour: Rgba::ACCENT });
    }
    if usable(response) {
        insets.push(Inset { map: response, part: response.bounds, name: "response", colour: Rgba::PATTERN });
    }
    insets
}

/// Draws a part of a map as large as fits into a box, with a colour scale from dark over the map's colour to
/// white.
fn draw_inset(
    canvas: &mut Canvas,
    body: PixelBox,
    inset: &Inset<'_>,
    target: Option<PixelBox>,
    columns: &mut Vec<Option<usize>>,
) {
    let Inset { map, part, colour, .. } = *inset;
    let scale = (body.w / part.w).min(body.h / part.h);
    let (w, h) = ((part.w * scale).round().max(1.0), (part.h * scale).round().max(1.0));
    let place =
        PixelBox { u: (body.u + (body.w - w) / 2.0).round(), v: (body.v + (body.h - h) / 2.0).round(), w, h };
    canvas.layer.fill_box(body, Rgba::DARK.with_opacity(0.6));
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
    let colours: [Rgba; 256] = core::array::from_fn(|value| heat(value as u8, colour));
    let (mut last, mut start) = (usize::MAX, None);
    canvas.layer.paint(place, |column, row| {
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
            canvas.line(upright(shown), Line::new(Rgba::LIGHT.with_opacity(0.6)).with_weight(0.6));
        }
    }
}

/// The colour scale of a map: from dark over `colour` to white.
fn heat(value: u8, colour: Rgba) -> Rgba {
    let share = f32::from(value) / 255.0;
    let (from, to, share) = if share < 0.7 {
        (Rgba::DARK, colour, share / 0.7)
    } else {
        (colour, Rgba::LIGHT, (share - 0.7) / 0.3)
    };
    let mix = |from: u8, to: u8| (f32::from(from) + (f32::from(to) - f32::from(from)) * share) as u8;
    Rgba {
        red: mix(from.red, to.red),
        green: mix(from.green, to.green),
        blue: mix(from.blue, to.blue),
        opacity: 255,
    }
}

/// Draws a bar for each bin of a hue histogram in the colour of its hue. A thin line below shows the hue of
/// each bin.
fn draw_hues(canvas: &mut Canvas, place: PixelBox, bins: &[u8]) {
    if bins.is_empty() {
        return;
    }
    let width = place.w / bins.len() as f64;
    let base = f64::from(canvas.style.scaled(2.0).max(1.0)).round();
    // Wide bars are separated by a gap.
    let space = if width >= 4.0 { 1.0 } else { 0.0 };
    for (index, bin) in bins.iter().enumerate() {
        let colour = pure_hue((index as f32 + 0.5) / bins.len() as f32);
        let (u, bottom) = (place.u + index as f64 * width, place.v + place.h);
        canvas.layer.fill_box(PixelBox { u, v: bottom - base, w: width, h: base }, colour);
        let h = (place.h - base) * f64::from(*bin) / 255.0;
        if h >= 0.5 {
            canvas.layer.fill_box(PixelBox { u, v: bottom - base - h, w: width - space, h }, colour);
        }
    }
}

/// The saturated colour of a hue, given as a share of the circle from red over green and blue.
fn pure_hue(turn: f32) -> Rgba {
    let channel = |shift: f32| {
        let away = ((turn + shift).rem_euclid(1.0) * 6.0 - 3.0).abs() - 1.0;
        (away.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
    };
    Rgba { red: channel(0.0), green: channel(2.0 / 3.0), blue: channel(1.0 / 3.0), opacity: 255 }
}
