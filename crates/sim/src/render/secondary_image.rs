//! Reflections and shadows of objects as the water shows them: image tiles, shifted by the slopes of the
//! surface.

use super::chunk::{CHUNK, Chunk};
use super::texture::round_to_i32;
use super::view::FrameView;

/// The shift is clamped to this part of the shift at a slope of 1.
const MAX_SHIFT_SHARE: f32 = 0.4;
/// Share of the sun's light that a shadow takes away.
const SHADOW_DEPTH: f32 = 0.85;

/// A reflection or a shadow that may be visible in a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct SecondaryImage {
    /// Index of the object.
    index: usize,
    is_reflection: bool,
    /// Pixels by which a slope of 1 shifts the image.
    shift_per_slope: f32,
    /// Upper bound of the shift, pixels.
    max_shift: i32,
}

/// Lists the reflections and shadows that may be visible in a row, from far to near.
pub(super) fn list_secondary_images(view: &FrameView<'_>, row: usize, images: &mut Vec<SecondaryImage>) {
    images.clear();
    images.reserve(2 * view.objects.order.len());
    for &index in &view.objects.order {
        let tiles = &view.objects.tiles[index];
        for (tile, is_reflection) in [(&tiles.reflection, true), (&tiles.shadow, false)] {
            let shift_per_slope =
                if is_reflection { 2.0 * tiles.shift_per_slope } else { 0.5 * tiles.shift_per_slope };
            let max_shift = (MAX_SHIFT_SHARE * shift_per_slope) as i32 + 2;
            let row = row as i32;
            let bottom = tile.top + tile.height as i32;
            if tile.width > 0 && row >= tile.top - max_shift && row < bottom + max_shift {
                images.push(SecondaryImage { index, is_reflection, shift_per_slope, max_shift });
            }
        }
    }
}

/// Adds a reflection or a shadow to a chunk. Returns whether the image may lie in the chunk at all.
pub(super) fn add_secondary_image(
    view: &FrameView<'_>,
    image: &SecondaryImage,
    (row, column): (usize, usize),
    chunk: &mut Chunk,
) -> bool {
    let tiles = &view.objects.tiles[image.index];
    let tile = if image.is_reflection { &tiles.reflection } else { &tiles.shadow };
    let column = column as i32;
    let first = (tile.left - image.max_shift - column).max(0);
    let last = (tile.left + tile.width as i32 + image.max_shift - column).min(CHUNK as i32);
    let (scale, limit) = (image.shift_per_slope, MAX_SHIFT_SHARE * image.shift_per_slope);
    let affected = first.max(0) as usize..last.max(0) as usize;
    for i in affected.clone() {
        let (dx, dy) = (chunk.dx[i], chunk.dy[i]);
        let level = (dx * dx + dy * dy).sqrt().max(1e-3);
        let (ax, ay) = (dx / level, dy / level);
        let away = chunk.sx[i] * ax + chunk.sy[i] * ay;
        let aside = chunk.sx[i] * ay - chunk.sy[i] * ax;
        let dv = (scale * away).clamp(-limit, limit);
        let du = (0.5 * scale * aside).clamp(-limit, limit);
        let (x, y) = (column + i as i32 - tile.left, row as i32 - tile.top);
        let (x, y) = (x + round_to_i32(du), y + round_to_i32(dv));
        if x < 0 || y < 0 || x as usize >= tile.width || y as usize >= tile.height {
            continue;
        }
        let pixel = tile.pixels[y as usize * tile.width + x as usize];
        let left = 1.0 - pixel[3];
        if image.is_reflection {
            for c in 0..3 {
                chunk.reflection[c][i] = chunk.reflection[c][i] * left + pixel[c];
            }
            chunk.sky_left[i] *= left;
        } else {
            chunk.lit[i] *= 1.0 - SHADOW_DEPTH * pixel[3];
        }
    }
    !affected.is_empty()
}
