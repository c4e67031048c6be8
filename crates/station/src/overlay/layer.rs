//! A transparent layer of premultiplied red, green, blue and opacity, and which parts of it were drawn on.
//!
//! The layer is divided into square tiles. Whatever draws marks the tiles that it can reach; only those are cleared
//! for the next frame and mixed into a picture.

use barrelman_vocab::{PictureSize, PixelBox};
use tiny_skia::{FillRule, Paint, Path, PathSegment, Pixmap, Point, PremultipliedColorU8, Stroke, Transform};

use super::style::Ink;

/// Pixels along a tile's side: even, so that a tile covers whole chroma samples.
pub(super) const TILE: usize = 16;

/// A layer of one picture's size.
#[derive(Debug, Default)]
pub(super) struct Layer {
    pixels: Option<Pixmap>,
    tiles_across: usize,
    drawn: Vec<bool>,
}

/// How much of each pixel a glyph covers, and where it lies from its origin.
#[derive(Debug, Default)]
pub(super) struct Coverage {
    offset: (i32, i32),
    width: usize,
    shares: Vec<u8>,
}

impl Coverage {
    /// Nothing covered yet of `width` x `height` pixels.
    pub(super) fn new(offset: (i32, i32), (width, height): (usize, usize)) -> Self {
        Self { offset, width, shares: vec![0; width * height] }
    }

    /// Covers a share, 0 to 1, of one pixel. What lies outside is left out.
    pub(super) fn set(&mut self, column: usize, row: usize, share: f32) {
        if column < self.width
            && let Some(cell) = self.shares.get_mut(row * self.width + column)
        {
            *cell = (share * 255.0 + 0.5) as u8;
        }
    }
}

impl Layer {
    /// Makes the layer transparent and as large as a picture. `false` where there is no room to draw: an empty
    /// picture, or one that no layer can be as large as.
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
        let Some(pixels) = &mut self.pixels else { return false };
        let width = size.width as usize;
        for tile in (0..self.drawn.len()).filter(|tile| self.drawn[*tile]) {
            let (left, top) = (tile % self.tiles_across * TILE, tile / self.tiles_across * TILE);
            let right = (left + TILE).min(width);
            for row in pixels.data_mut().chunks_exact_mut(width * 4).skip(top).take(TILE) {
                row[left * 4..right * 4].fill(0);
            }
        }
        self.drawn.fill(false);
        true
    }

    /// The layer's size, which is the picture's.
    pub(super) fn size(&self) -> PictureSize {
        self.pixels
            .as_ref()
            .map_or(PictureSize::new(0, 0), |pixels| PictureSize::new(pixels.width(), pixels.height()))
    }

    /// Red, green, blue (premultiplied) and opacity of all pixels, four bytes each, rows tightly packed.
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
    pub(super) fn fill(&mut self, path: &Path, ink: Ink) {
        let bounds = path.bounds();
        self.mark(bounds.left(), bounds.top(), bounds.right(), bounds.bottom());
        if let Some(pixels) = &mut self.pixels {
            pixels.fill_path(path, &paint(ink), FillRule::Winding, Transform::identity(), None);
        }
    }

    /// Draws along a path.
    pub(super) fn stroke(&mut self, path: &Path, stroke: &Stroke, ink: Ink) {
        self.mark_along(path, stroke.width / 2.0 + 1.0);
        if let Some(pixels) = &mut self.pixels {
            pixels.stroke_path(path, &paint(ink), stroke, Transform::identity(), None);
        }
    }

    /// Lays a glyph on the layer, its origin at a pixel.
    pub(super) fn cover(&mut self, glyph: &Coverage, origin: (i32, i32), ink: Ink) {
        if glyph.width == 0 {
            return;
        }
        let (left, top) = (origin.0 + glyph.offset.0, origin.1 + glyph.offset.1);
        for (row, shares) in (top..).zip(glyph.shares.chunks_exact(glyph.width)) {
            for (column, share) in (left..).zip(shares) {
                let opacity = u32::from(*share) * u32::from(ink.opacity) / 255;
                self.lay(column, row, Ink { opacity: opacity as u8, ..ink });
            }
        }
        let (width, height) = (glyph.width as f32, (glyph.shares.len() / glyph.width) as f32);
        self.mark(left as f32, top as f32, left as f32 + width, top as f32 + height);
    }

    /// Lays a colour for each whole pixel of a box: `ink` is given a column and a row from the box's corner.
    pub(super) fn paint(&mut self, place: PixelBox, mut ink: impl FnMut(usize, usize) -> Ink) {
        let (left, top) = (place.u.round() as i32, place.v.round() as i32);
        for row in 0..place.h.round() as usize {
            for column in 0..place.w.round() as usize {
                self.lay(left + column as i32, top + row as i32, ink(column, row));
            }
        }
        let (u, v) = (place.u as f32, place.v as f32);
        self.mark(u, v, u + place.w as f32, v + place.h as f32);
    }

    fn lay(&mut self, column: i32, row: i32, ink: Ink) {
        let Some(pixels) = &mut self.pixels else { return };
        let (width, height) = (pixels.width() as i32, pixels.height() as i32);
        if ink.opacity == 0 || !(0..width).contains(&column) || !(0..height).contains(&row) {
            return;
        }
        let pixel = &mut pixels.pixels_mut()[row as usize * width as usize + column as usize];
        let over = ink.colour().premultiply().to_color_u8();
        let rest = 255 - u32::from(ink.opacity);
        let mix =
            |over: u8, under: u8| (u32::from(over) + (u32::from(under) * rest + 127) / 255).min(255) as u8;
        let opacity = mix(over.alpha(), pixel.alpha());
        let channel = |over: u8, under: u8| mix(over, under).min(opacity);
        let mixed = PremultipliedColorU8::from_rgba(
            channel(over.red(), pixel.red()),
            channel(over.green(), pixel.green()),
            channel(over.blue(), pixel.blue()),
            opacity,
        );
        *pixel = mixed.unwrap_or(*pixel);
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
        let least = |of: fn(&Point) -> f32| points.iter().map(of).fold(f32::INFINITY, f32::min) - reach;
        let most = |of: fn(&Point) -> f32| points.iter().map(of).fold(f32::NEG_INFINITY, f32::max) + reach;
        self.mark(
            least(|point| point.x),
            least(|point| point.y),
            most(|point| point.x),
            most(|point| point.y),
        );
    }

    /// Marks the tiles that a box of the picture reaches into.
    fn mark(&mut self, left: f32, top: f32, right: f32, bottom: f32) {
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

fn paint(ink: Ink) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(ink.colour());
    paint
}
