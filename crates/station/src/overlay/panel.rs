//! What the tracker goes by: its search window in the picture, and in a corner how much each pixel that was looked
//! at is like the target (the back projection) above the target's hues (the histogram).

use barrelman_vision::{Explanation, GreyMap};
use barrelman_vocab::PixelBox;

use super::Pen;
use super::placing::Places;
use super::shapes::{Line, upright};
use super::strip::strip_height;
use super::style::Ink;

/// Remembers which corner the panel is in.
#[derive(Debug, Default)]
pub(super) struct Panel {
    corner: Option<usize>,
    /// The column of the map that each column of its picture shows.
    columns: Vec<usize>,
}

/// Draws where the next frame's search starts.
pub(super) fn draw_search_window(pen: &mut Pen, window: PixelBox) {
    let window = window.clipped(pen.layer.size());
    if !window.is_empty() {
        pen.line(upright(window), Line::of(Ink::LIGHT.at(0.7)).dashed());
    }
}

impl Panel {
    /// Draws the panel in a corner where it covers nothing, if there is one.
    pub(super) fn draw(&mut self, pen: &mut Pen, places: &mut Places, explanation: &Explanation) {
        let (map, hues) = (&explanation.back_projection, &explanation.histogram);
        let has_map = map.width > 0 && map.height > 0 && map.samples.len() >= map.width * map.height;
        if !has_map && hues.is_empty() {
            self.corner = None;
            return;
        }
        let page = places.page();
        let text = f64::from(pen.style.text_px);
        let (pad, head) = ((text * 0.5).round(), (text * 1.4).round());
        let width = (page.w * 0.17).round();
        let strip = if hues.is_empty() { 0.0 } else { (page.h * 0.05).round() };
        let inset = if has_map { (width * 9.0 / 16.0).round() } else { 0.0 };
        let between = if has_map && !hues.is_empty() { pad } else { 0.0 };
        let (w, h) = (width + 2.0 * pad, head + inset + between + strip + pad);

        // The strip's height is left free at both edges, so that the panel need not move when the strip does.
        let (left, right) = (pen.style.margin, page.w - w - pen.style.margin);
        let edge = strip_height(pen) + pen.style.margin;
        let (top, bottom) = (edge, page.h - h - edge);
        let corners = [(right, top), (left, top), (right, bottom), (left, bottom)];
        let corners = corners.map(|(u, v)| PixelBox { u: u.round(), v: v.round(), w, h });
        let Some(place) = places.take_steadily(&mut self.corner, &corners) else { return };

        pen.plate(place);
        pen.text("likeness", ((place.u + pad) as f32, (place.v + head / 2.0) as f32), Ink::QUIET);
        let body = PixelBox { u: place.u + pad, v: place.v + head, w: width, h: inset };
        if has_map {
            draw_map(pen, body, map, &mut self.columns);
        }
        draw_hues(pen, PixelBox { v: body.v + inset + between, h: strip, ..body }, hues);
    }
}

/// Draws a map as large as it fits into a box, in the accent's colour, white where it is largest.
fn draw_map(pen: &mut Pen, body: PixelBox, map: &GreyMap, columns: &mut Vec<usize>) {
    let scale = (body.w / map.width as f64).min(body.h / map.height as f64);
    let (w, h) = ((map.width as f64 * scale).round().max(1.0), (map.height as f64 * scale).round().max(1.0));
    let place =
        PixelBox { u: (body.u + (body.w - w) / 2.0).round(), v: (body.v + (body.h - h) / 2.0).round(), w, h };
    pen.layer.fill_box(body, Ink::DARK.at(0.6));
    let nearest = |position: usize, extent: f64, samples: usize| {
        (((position as f64 + 0.5) * samples as f64 / extent) as usize).min(samples - 1)
    };
    columns.clear();
    columns.extend((0..w as usize).map(|column| nearest(column, w, map.width)));
    let colours: [Ink; 256] = core::array::from_fn(|likeness| heat(likeness as u8));
    let (mut last, mut start) = (usize::MAX, 0);
    pen.layer.paint(place, |column, row| {
        if row != last {
            (last, start) = (row, nearest(row, h, map.height) * map.width);
        }
        colours[usize::from(map.samples[start + columns[column]])]
    });
}

/// From the plate's dark over the accent to white.
fn heat(likeness: u8) -> Ink {
    let share = f32::from(likeness) / 255.0;
    let (from, to, share) = if share < 0.7 {
        (Ink::DARK, Ink::ACCENT, share / 0.7)
    } else {
        (Ink::ACCENT, Ink::LIGHT, (share - 0.7) / 0.3)
    };
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
