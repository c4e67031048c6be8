//! A grid of pixel coordinates over a picture, to read a box from.
//!
//! Labelled lines lie at multiples of a round number of pixels, fainter ones at fifths of it. A line lies on
//! the edge between two pixels: the line 100 has the pixel 99 on its left and the pixel 100 on its right.

use barrelman_vocab::{Picture, PixelBox};

use super::blend;
use super::canvas::Canvas;
use super::style::{Rgba, Style};

/// Distances of the labelled lines, pixels.
const SPACINGS: [u32; 8] = [10, 20, 50, 100, 200, 500, 1000, 2000];
/// Largest number of labelled lines across the picture.
const MAX_LINES: u32 = 16;
/// Faint lines between two labelled ones, plus one.
const PARTS: u32 = 5;

/// Draws the grid, and returns the distance of the labelled lines in pixels.
pub fn draw(picture: &mut Picture) -> u32 {
    let size = picture.size();
    let spacing = SPACINGS
        .into_iter()
        .find(|spacing| size.width.max(size.height) / spacing <= MAX_LINES)
        .unwrap_or(SPACINGS[SPACINGS.len() - 1]);
    let mut canvas = Canvas::default();
    canvas.begin(Style::for_picture(size));
    if canvas.layer.begin(size) {
        lines(&mut canvas, size.bounds(), f64::from(spacing / PARTS), Rgba::LIGHT.with_opacity(0.16));
        lines(&mut canvas, size.bounds(), f64::from(spacing), Rgba::DARK.with_opacity(0.35));
        lines(&mut canvas, size.bounds(), f64::from(spacing), Rgba::LIGHT.with_opacity(0.55));
        labels(&mut canvas, size.bounds(), spacing);
        blend::blend_layer(&canvas.layer, picture);
    }
    spacing
}

/// Multiples of a distance within a length, without 0.
fn multiples(distance: f64, length: f64) -> impl Iterator<Item = f64> {
    (1..).map(move |index| f64::from(index) * distance).take_while(move |at| *at < length)
}

fn lines(canvas: &mut Canvas, picture: PixelBox, distance: f64, colour: Rgba) {
    for u in multiples(distance, picture.w) {
        canvas.layer.fill_box(PixelBox { u, v: 0.0, w: 1.0, h: picture.h }, colour);
    }
    for v in multiples(distance, picture.h) {
        canvas.layer.fill_box(PixelBox { u: 0.0, v, w: picture.w, h: 1.0 }, colour);
    }
}

/// The numbers of the labelled lines: along the top and the left edge.
fn labels(canvas: &mut Canvas, picture: PixelBox, spacing: u32) {
    let (_, height) = canvas.plate_size("0");
    for u in multiples(f64::from(spacing), picture.w) {
        let text = format!("{u:.0}");
        let (w, h) = canvas.plate_size(&text);
        label(canvas, &text, PixelBox { u: u - w / 2.0, v: 0.0, w, h });
    }
    for v in multiples(f64::from(spacing), picture.h) {
        let text = format!("{v:.0}");
        let (w, h) = canvas.plate_size(&text);
        // The corner belongs to the labels of the top edge.
        if v > 1.6 * height {
            label(canvas, &text, PixelBox { u: 0.0, v: v - h / 2.0, w, h });
        }
    }
}

fn label(canvas: &mut Canvas, text: &str, place: PixelBox) {
    canvas.plate(place);
    canvas.centred_text(text, place, Rgba::LIGHT);
}
