//! Draws text in DejaVu Sans Condensed, glyph by glyph, from a cache of coverages.
//!
//! The font is embedded from the `dejavu` crate; the Bitstream Vera licence allows this. Glyphs are cached
//! for four positions within a pixel, so that letters are evenly spaced at small sizes.

use std::collections::BTreeMap;
use std::fmt::Write;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use super::layer::{Coverage, Layer};
use super::style::Rgba;

/// Positions within a pixel for which a glyph is cached.
const STEPS: f32 = 4.0;

/// The font and its cached glyphs.
#[derive(Debug)]
pub(super) struct Typeface {
    font: FontRef<'static>,
    glyphs: BTreeMap<(char, u16, u8), Coverage>,
}

impl Default for Typeface {
    fn default() -> Self {
        let font = FontRef::try_from_slice(dejavu::sans_condensed::regular())
            .expect("the embedded font is a well-formed one");
        Self { font, glyphs: BTreeMap::new() }
    }
}

impl Typeface {
    /// Drops the cached glyphs, at a change of the text size.
    pub(super) fn clear_cache(&mut self) {
        self.glyphs.clear();
    }

    /// Width of a text, pixels.
    pub(super) fn width(&self, text: &str, size_px: u16) -> f32 {
        let font = self.font.as_scaled(PxScale::from(f32::from(size_px)));
        text.chars().map(|letter| font.h_advance(font.glyph_id(letter))).sum()
    }

    /// Height of the capitals and figures, pixels.
    pub(super) fn capital_height(&self, size_px: u16) -> f32 {
        // The capitals of DejaVu Sans are 1493 units of the 2384 from its highest to its lowest stroke.
        f32::from(size_px) * 1493.0 / 2384.0
    }

    /// Draws a text with its left end at `u` and its baseline at `baseline`, and returns where it ends.
    pub(super) fn draw(
        &mut self,
        layer: &mut Layer,
        text: &str,
        (u, baseline): (f32, f32),
        (size_px, colour): (u16, Rgba),
    ) -> f32 {
        let scale = PxScale::from(f32::from(size_px));
        let (mut cursor, baseline) = (u, baseline.round() as i32);
        for letter in text.chars() {
            let font = self.font.as_scaled(scale);
            let id = font.glyph_id(letter);
            let advance = font.h_advance(id);
            let column = cursor.floor();
            let step = (((cursor - column) * STEPS) as u8).min(STEPS as u8 - 1);
            let glyph = self.glyphs.entry((letter, size_px, step)).or_insert_with(|| {
                let shifted = id.with_scale_and_position(scale, point(f32::from(step) / STEPS, 0.0));
                self.font.outline_glyph(shifted).map_or_else(Coverage::default, |outline| {
                    let bounds = outline.px_bounds();
                    let mut glyph = Coverage::new(
                        (bounds.min.x as i32, bounds.min.y as i32),
                        (bounds.width() as usize, bounds.height() as usize),
                    );
                    outline.draw(|column, row, share| glyph.set(column as usize, row as usize, share));
                    glyph
                })
            });
            layer.draw_glyph(glyph, (column as i32, baseline), colour);
            cursor += advance;
        }
        cursor
    }
}

/// Appends a number with a sign as wide as the digits: `+0.300`, `−0.300`, and `0.000` for zero.
pub(super) fn push_signed(text: &mut String, value: f64, decimals: usize) {
    let start = text.len();
    // Writing into a string cannot fail.
    let _ = write!(text, "{:.decimals$}", value.abs());
    let is_zero = text[start..].bytes().all(|figure| matches!(figure, b'0' | b'.'));
    if !is_zero {
        text.insert(start, if value < 0.0 { '\u{2212}' } else { '+' });
    }
}
