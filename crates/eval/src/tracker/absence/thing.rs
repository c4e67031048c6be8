//! Things of the target's colour, painted into a picture.

use barrelman_vocab::{Picture, PixelBox};

/// How far a thing's brightness waves about its mean, of 255: light and shade on a hull.
const SHADE: f64 = 14.0;

/// Noise on top, of 255, either way.
const NOISE: f64 = 6.0;

/// Shape of a thing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outline {
    Ellipse,
    Rectangle,
}

/// Mean samples of a target's paint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Paint {
    y: f64,
    u: f64,
    v: f64,
}

impl Paint {
    /// The mean over the more colourful half of the inner half of a box: what lies there is mostly the target, and
    /// the half leaves out its windows, shadows and what shows beside it.
    pub(super) fn of(picture: &Picture, bounds: PixelBox) -> Self {
        let (y, u, v) = (picture.y(), picture.u(), picture.v());
        // Chroma samples are two pixels apart.
        let (columns, rows) = (
            inner_half(bounds.u / 2.0, bounds.w / 2.0, u.width),
            inner_half(bounds.v / 2.0, bounds.h / 2.0, u.height),
        );
        let mut samples: Vec<[u8; 3]> = rows
            .flat_map(|row| {
                columns
                    .clone()
                    .map(move |column| [y.row(2 * row)[2 * column], u.row(row)[column], v.row(row)[column]])
            })
            .collect();
        let colourful = |[_, u, v]: &[u8; 3]| {
            let (u, v) = (i32::from(*u) - 128, i32::from(*v) - 128);
            std::cmp::Reverse(u * u + v * v)
        };
        samples.sort_by_key(colourful);
        samples.truncate(samples.len().div_ceil(2));
        let mean = |channel: usize| {
            samples.iter().map(|sample| f64::from(sample[channel])).sum::<f64>() / samples.len() as f64
        };
        Self { y: mean(0), u: mean(1), v: mean(2) }
    }
}

/// The samples in the middle half of a side; at least one.
fn inner_half(from: f64, length: f64, limit: usize) -> std::ops::Range<usize> {
    let first = ((from + length / 4.0).max(0.0) as usize).min(limit - 1);
    first..((from + 0.75 * length) as usize).clamp(first + 1, limit)
}

/// A painted thing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thing {
    pub(super) bounds: PixelBox,
    pub(super) outline: Outline,
    pub(super) paint: Paint,
    /// Whatever tells its texture from another's.
    pub(super) seed: u32,
}

impl Thing {
    /// Paints it over what is there. Parts outside the picture are left out.
    pub(super) fn draw(&self, picture: &mut Picture) {
        let (size, chroma) = (picture.size(), picture.chroma_size());
        let [y, u, v] = picture.planes_mut();
        self.fill(y, size.width as usize, 1.0, |across, along, at| {
            let shade = SHADE * (across * 9.0 + along * 4.0 + f64::from(self.seed % 7)).sin();
            self.paint.y + shade + NOISE * noise(self.seed, at)
        });
        self.fill(u, chroma.width as usize, 0.5, |_, _, _| self.paint.u);
        self.fill(v, chroma.width as usize, 0.5, |_, _, _| self.paint.v);
    }

    /// Fills a plane of which a pixel of the picture is `scale` samples, with what `of` says at a place: across and
    /// along the thing, each -1 to 1, and the sample counted from the thing's corner.
    fn fill(&self, plane: &mut [u8], width: usize, scale: f64, of: impl Fn(f64, f64, [i64; 2]) -> f64) {
        let centre = self.bounds.centre();
        let (left, top) = ((self.bounds.u * scale).floor(), (self.bounds.v * scale).floor());
        let right = ((self.bounds.u + self.bounds.w) * scale).ceil().clamp(0.0, width as f64);
        for (row, samples) in plane.chunks_exact_mut(width).enumerate() {
            let along = ((row as f64 + 0.5) / scale - centre.v) / (self.bounds.h / 2.0);
            if along.abs() > 1.0 {
                continue;
            }
            let first = left.clamp(0.0, width as f64) as usize;
            for (column, sample) in samples.iter_mut().enumerate().take(right as usize).skip(first) {
                let across = ((column as f64 + 0.5) / scale - centre.u) / (self.bounds.w / 2.0);
                let inside = match self.outline {
                    Outline::Ellipse => across * across + along * along <= 1.0,
                    Outline::Rectangle => across.abs() <= 1.0,
                };
                if inside {
                    let at = [column as i64 - left as i64, row as i64 - top as i64];
                    *sample = of(across, along, at).round().clamp(0.0, 255.0) as u8;
                }
            }
        }
    }
}

/// -1 to 1, the same for the same place on the thing in every frame.
fn noise(seed: u32, [column, row]: [i64; 2]) -> f64 {
    let mut z = seed ^ (column as u32).wrapping_mul(0x9E37_79B1) ^ (row as u32).wrapping_mul(0x85EB_CA77);
    z = (z ^ (z >> 15)).wrapping_mul(0x2C1B_3C6D);
    z = (z ^ (z >> 12)).wrapping_mul(0x297A_2D39);
    z ^= z >> 15;
    f64::from(z) / f64::from(u32::MAX) * 2.0 - 1.0
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::ColourEncoding;

    use super::*;

    const SIZE: PictureSize = PictureSize::new(40, 30);

    fn painted(outline: Outline, bounds: PixelBox) -> Picture {
        let mut picture = Picture::black(SIZE, ColourEncoding::JPEG);
        Thing { bounds, outline, paint: Paint { y: 120.0, u: 90.0, v: 200.0 }, seed: 3 }.draw(&mut picture);
        picture
    }

    #[test]
    fn a_thing_has_the_paint_that_it_was_given() {
        let bounds = PixelBox { u: 8.0, v: 6.0, w: 20.0, h: 16.0 };
        for outline in [Outline::Ellipse, Outline::Rectangle] {
            let paint = Paint::of(&painted(outline, bounds), bounds);
            assert!((paint.y - 120.0).abs() < SHADE, "{paint:?}");
            assert_eq!((paint.u, paint.v), (90.0, 200.0));
        }
    }

    #[test]
    fn nothing_is_painted_outside_its_box() {
        let bounds = PixelBox { u: -6.0, v: 24.0, w: 20.0, h: 16.0 };
        let picture = painted(Outline::Rectangle, bounds);
        for row in 0..30 {
            for column in 0..40 {
                let inside = column < 14 && row >= 24;
                assert_eq!(picture.y().row(row)[column] > 0, inside, "{column},{row}");
            }
        }
        assert_eq!(
            painted(Outline::Ellipse, PixelBox { u: 100.0, ..bounds }),
            Picture::black(SIZE, ColourEncoding::JPEG)
        );
    }
}
