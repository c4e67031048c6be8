//! A transparent layer of premultiplied red, green, blue and opacity.
//!
//! The layer is divided into square tiles. Each drawing operation marks the tiles that it can reach; only
//! those are cleared for the next frame and blended into a picture.

use barrelman_vocab::{PictureSize, PixelBox};
use tiny_skia::{BlendMode, FillRule, Paint, Path, PathSegment, Pixmap, Point, Rect, Stroke, Transform};

use super::style::Rgba;

/// Side of a tile, pixels: even, so that a tile covers whole chroma samples.
pub(super) const TILE: usize = 8;

/// A layer of one picture's size.
#[derive(Debug, Default)]
pub(super) struct Layer {
    pixels: Option<Pixmap>,
    tiles_across: usize,
    drawn: Vec<bool>,
}

/// The share of each pixel that a glyph covers, and the offset from the glyph's origin.
#[derive(Debug, Default)]
pub(super) struct Coverage {
    offset: (i32, i32),
    width: usize,
    shares: Vec<u8>,
}

impl Coverage {
    /// An empty glyph of `width` x `height` pixels.
    pub(super) fn new(offset: (i32, i32), (width, height): (usize, usize)) -> Self {
        Self { offset, width, shares: vec![0; width * height] }
    }

    /// Sets the covered share of one pixel, 0 to 1. Pixels outside of the glyph are ignored.
    pub(super) fn set(&mut self, column: usize, row: usize, share: f32) {
        if column < self.width
            && let Some(cell) = self.shares.get_mut(row * self.width + column)
        {
            *cell = (share * 255.0 + 0.5) as u8;
        }
    }
}

impl Layer {
    /// Makes the layer transparent, in the size of a picture. `false` if no layer of this size is possible:
    /// the picture is empty or too large.
    pub(super) fn begin(&mut self, size: PictureSize) -> bool {
        if self
            .pixels
            .as_ref()
            .is_none_or(|pixels| (pixels.width(), pixels.height()) != (size.width, size.height))
        {
            self.pixels = Pixmap::new(size.width, size.height);
            self.tiles_across = (size.width as usize).div_ceil(TILE);
            self.drawn.clear();
            self.drawn.resize(self.tiles_across * (size.height as usize).div_ceil(TILE), false);
            return self.pixels.is_some();
        }
        self.copy_tiles(None);
        self.drawn.fill(false);
        self.pixels.is_some()
    }

    /// Makes the layer a copy of `base`. Only the tiles that were drawn on in either layer are copied.
    pub(super) fn begin_on(&mut self, base: &Self) {
        if self.size() != base.size() {
            self.begin(base.size());
        }
        for (drawn, below) in self.drawn.iter_mut().zip(&base.drawn) {
            *drawn |= below;
        }
        self.copy_tiles(Some(base));
        self.drawn.clone_from(&base.drawn);
    }

    /// Copies the tiles that were drawn on from another layer of the same size, or clears them.
    fn copy_tiles(&mut self, from: Option<&Self>) {
        let Some(pixels) = &mut self.pixels else { return };
        let bytes_per_row = pixels.width() as usize * 4;
        let (across, rgba) = (self.tiles_across, pixels.data_mut());
        for tile in (0..self.drawn.len()).filter(|tile| self.drawn[*tile]) {
            let (left, top) = (tile % across * TILE * 4, tile / across * TILE * bytes_per_row);
            let wide = (TILE * 4).min(bytes_per_row - left);
            for start in (top + left..rgba.len()).step_by(bytes_per_row).take(TILE) {
                match from {
                    Some(from) => {
                        rgba[start..start + wide].copy_from_slice(&from.rgba()[start..start + wide])
                    }
                    None => rgba[start..start + wide].fill(0),
                }
            }
        }
    }

    /// The layer's size, which is the picture's.
    pub(super) fn size(&self) -> PictureSize {
        self.pixels
            .as_ref()
            .map_or(PictureSize::new(0, 0), |pixels| PictureSize::new(pixels.width(), pixels.height()))
    }

    /// Red, green, blue (premultiplied) and opacity of all pixels, four bytes each, rows without padding.
    pub(super) fn rgba(&self) -> &[u8] {
        self.pixels.as_ref().map_or(&[], Pixmap::data)
    }

    /// Left and top pixel of each tile that was drawn on.
    pub(super) fn drawn_tiles(&self) -> impl Iterator<Item = (usize, usize)> {
        let across = self.tiles_across;
        let drawn = self.drawn.iter().enumerate().filter(|(_, drawn)| **drawn);
        drawn.map(move |(tile, _)| (tile % across * TILE, tile / across * TILE))
    }

    /// Fills a closed path.
    pub(super) fn fill(&mut self, path: &Path, colour: Rgba) {
        let bounds = path.bounds();
        self.mark_drawn(bounds.left(), bounds.top(), bounds.right(), bounds.bottom());
        if let Some(pixels) = &mut self.pixels {
            pixels.fill_path(path, &paint(colour), FillRule::Winding, Transform::identity(), None);
        }
    }

    /// Fills a closed path with one colour that replaces the pixels, without antialiasing: for large faint
    /// areas below all else.
    pub(super) fn fill_replacing(&mut self, path: &Path, colour: Rgba) {
        let bounds = path.bounds();
        self.mark_drawn(bounds.left(), bounds.top(), bounds.right(), bounds.bottom());
        if let Some(pixels) = &mut self.pixels {
            let paint = Paint { anti_alias: false, blend_mode: BlendMode::Source, ..paint(colour) };
            pixels.fill_path(path, &paint, FillRule::Winding, Transform::identity(), None);
        }
    }

    /// Fills an upright box.
    pub(super) fn fill_box(&mut self, place: PixelBox, colour: Rgba) {
        let (u, v, w, h) = (place.u as f32, place.v as f32, place.w as f32, place.h as f32);
        if let (Some(pixels), Some(rect)) = (&mut self.pixels, Rect::from_xywh(u, v, w, h)) {
            pixels.fill_rect(rect, &paint(colour), Transform::identity(), None);
            self.mark_drawn(u, v, u + w, v + h);
        }
    }

    /// Draws along a path.
    pub(super) fn stroke(&mut self, path: &Path, stroke: &Stroke, colour: Rgba) {
        self.mark_along(path, stroke.width / 2.0 + 1.0);
        if let Some(pixels) = &mut self.pixels {
            pixels.stroke_path(path, &paint(colour), stroke, Transform::identity(), None);
        }
    }

    /// Draws a glyph with its origin at a pixel.
    pub(super) fn draw_glyph(&mut self, glyph: &Coverage, origin: (i32, i32), colour: Rgba) {
        if glyph.width == 0 {
            return;
        }
        let (width, height) = (glyph.width, glyph.shares.len() / glyph.width);
        let corner = (origin.0.saturating_add(glyph.offset.0), origin.1.saturating_add(glyph.offset.1));
        self.paint_pixels(corner, (width, height), |column, row| {
            let opacity = u32::from(glyph.shares[row * width + column]) * u32::from(colour.opacity) / 255;
            Rgba { opacity: opacity as u8, ..colour }
        });
    }

    /// Blends a colour over each pixel of a box. `colour` gets the column and the row from the box's corner.
    pub(super) fn paint(&mut self, place: PixelBox, colour: impl FnMut(usize, usize) -> Rgba) {
        let corner = (place.u.round() as i32, place.v.round() as i32);
        self.paint_pixels(corner, (place.w.round() as usize, place.h.round() as usize), colour);
    }

    fn paint_pixels(
        &mut self,
        (left, top): (i32, i32),
        (width, height): (usize, usize),
        mut colour: impl FnMut(usize, usize) -> Rgba,
    ) {
        let Some(pixels) = &mut self.pixels else { return };
        let (across, down) = (pixels.width() as usize, pixels.height() as usize);
        // The part of the box that lies in the picture, counted from the box's corner.
        let inside = |start: i32, extent: usize, end: usize| {
            let hidden = start.min(0).unsigned_abs() as usize;
            let shown = end.saturating_sub(start.max(0) as usize) + hidden;
            hidden..shown.min(extent).max(hidden)
        };
        let (columns, rows) = (inside(left, width, across), inside(top, height, down));
        for row in rows {
            let start = (top + row as i32) as usize * across;
            for column in columns.clone() {
                let pixel = &mut pixels.pixels_mut()[start + (left + column as i32) as usize];
                *pixel = colour(column, row).blend_over(*pixel);
            }
        }
        self.mark_drawn(left as f32, top as f32, left as f32 + width as f32, top as f32 + height as f32);
    }

    /// Marks the tiles near a path's lines and curves.
    fn mark_along(&mut self, path: &Path, reach: f32) {
        let (mut start, mut at) = (Point::zero(), Point::zero());
        for segment in path.segments() {
            match segment {
                PathSegment::MoveTo(to) => (start, at) = (to, to),
                PathSegment::LineTo(to) => {
                    self.mark_line(at, to, reach);
                    at = to;
                }
                PathSegment::QuadTo(control, to) => {
                    // A curve lies within the triangle of its points.
                    self.mark_line(at, control, reach);
                    self.mark_line(control, to, reach);
                    self.mark_box(&[at, control, to], reach);
                    at = to;
                }
                PathSegment::CubicTo(first, second, to) => {
                    self.mark_box(&[at, first, second, to], reach);
                    at = to;
                }
                PathSegment::Close => {
                    self.mark_line(at, start, reach);
                    at = start;
                }
            }
        }
    }

    fn mark_line(&mut self, from: Point, to: Point, reach: f32) {
        let pieces = (from.distance(to) / TILE as f32).ceil().clamp(1.0, 4096.0);
        let on = |piece: f32| {
            let share = piece / pieces;
            Point::from_xy(from.x + (to.x - from.x) * share, from.y + (to.y - from.y) * share)
        };
        for piece in 0..pieces as u32 {
            self.mark_box(&[on(piece as f32), on(piece as f32 + 1.0)], reach);
        }
    }

    fn mark_box(&mut self, points: &[Point], reach: f32) {
        let min = |of: fn(&Point) -> f32| points.iter().map(of).fold(f32::INFINITY, f32::min) - reach;
        let max = |of: fn(&Point) -> f32| points.iter().map(of).fold(f32::NEG_INFINITY, f32::max) + reach;
        self.mark_drawn(
            min(|point| point.x),
            min(|point| point.y),
            max(|point| point.x),
            max(|point| point.y),
        );
    }

    /// Marks the tiles that a box of the picture reaches into.
    fn mark_drawn(&mut self, left: f32, top: f32, right: f32, bottom: f32) {
        let down = self.drawn.len() / self.tiles_across.max(1);
        // A float-to-integer cast saturates: what lies left of or above the picture becomes its first tile.
        let first = |edge: f32| (edge - 1.0).max(0.0) as usize / TILE;
        let end = |edge: f32, tiles: usize| {
            if edge < -1.0 { 0 } else { ((edge + 1.0) as usize / TILE + 1).min(tiles) }
        };
        for row in first(top)..end(bottom, down) {
            for column in first(left)..end(right, self.tiles_across) {
                self.drawn[row * self.tiles_across + column] = true;
            }
        }
    }
}

fn paint(colour: Rgba) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(colour.to_skia());
    paint
}
