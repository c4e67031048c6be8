//! Distractors: objects of the target's colour, rendered into a picture.

use barrelman_vocab::{Picture, PixelBox};

/// Amplitude of the brightness over a distractor, of 255, like light and shade on a hull.
const SHADING: f64 = 14.0;

/// Amplitude of the noise of each sample, of 255.
const NOISE: f64 = 6.0;

/// Shape of a distractor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outline {
    Ellipse,
    Rectangle,
}

/// Mean colour of a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Paint {
    y: f64,
    u: f64,
    v: f64,
}

impl Paint {
    /// The mean over the more saturated half of the samples in the inner half of a box. The inner half is
    /// mostly the target; the less saturated samples are windows, shadows and surroundings.
    pub(super) fn sample(picture: &Picture, bounds: PixelBox) -> Self {
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
        let by_saturation = |[_, u, v]: &[u8; 3]| {
            let (u, v) = (i32::from(*u) - 128, i32::from(*v) - 128);
            std::cmp::Reverse(u * u + v * v)
        };
        samples.sort_by_key(by_saturation);
        samples.truncate(samples.len().div_ceil(2));
        let mean = |channel: usize| {
            samples.iter().map(|sample| f64::from(sample[channel])).sum::<f64>() / samples.len() as f64
        };
        Self { y: mean(0), u: mean(1), v: mean(2) }
    }
}

/// The samples in the middle half of a side, at least one.
fn inner_half(from: f64, length: f64, limit: usize) -> std::ops::Range<usize> {
    let first = ((from + length / 4.0).max(0.0) as usize).min(limit - 1);
    first..((from + 0.75 * length) as usize).clamp(first + 1, limit)
}

/// A distractor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Distractor {
    pub(super) bounds: PixelBox,
    pub(super) outline: Outline,
    pub(super) paint: Paint,
    /// Seed of the texture.
    pub(super) seed: u32,
}

impl Distractor {
    /// Renders the distractor over the picture. Parts outside the picture are left out.
    pub(super) fn render(&self, picture: &mut Picture) {
        let (size, chroma) = (picture.size(), picture.chroma_size());
        let [y, u, v] = picture.planes_mut();
        self.fill(y, size.width as usize, 1.0, |across, along, at| {
            let shade = SHADING * (across * 9.0 + along * 4.0 + f64::from(self.seed % 7)).sin();
            self.paint.y + shade + NOISE * noise(self.seed, at)
        });
        self.fill(u, chroma.width as usize, 0.5, |_, _, _| self.paint.u);
        self.fill(v, chroma.width as usize, 0.5, |_, _, _| self.paint.v);
    }

    /// Fills the distractor's part of a plane that has `scale` samples per pixel. The arguments of `value`
    /// are the place across and along the distractor, each -1 to 1, and column and row counted from the
    /// distractor's corner.
    fn fill(&self, plane: &mut [u8], width: usize, scale: f64, value: impl Fn(f64, f64, [i64; 2]) -> f64) {
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
                    *sample = value(across, along, at).round().clamp(0.0, 255.0) as u8;
                }
            }
        }
    }
}

/// Noise from -1 to 1 that is the same for the same place on the distractor in every frame.
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

    fn rendered(outline: Outline, bounds: PixelBox) -> Picture {
        let mut picture = Picture::black(SIZE, ColourEncoding::JPEG);
        Distractor { bounds, outline, paint: Paint { y: 120.0, u: 90.0, v: 200.0 }, seed: 3 }
            .render(&mut picture);
        picture
    }

    #[test]
    fn a_distractor_has_the_given_paint() {
        let bounds = PixelBox { u: 8.0, v: 6.0, w: 20.0, h: 16.0 };
        for outline in [Outline::Ellipse, Outline::Rectangle] {
            let paint = Paint::sample(&rendered(outline, bounds), bounds);
            assert!((paint.y - 120.0).abs() < SHADING, "{paint:?}");
            assert_eq!((paint.u, paint.v), (90.0, 200.0));
        }
    }

    #[test]
    fn nothing_is_rendered_outside_the_box() {
        let bounds = PixelBox { u: -6.0, v: 24.0, w: 20.0, h: 16.0 };
        let picture = rendered(Outline::Rectangle, bounds);
        for row in 0..30 {
            for column in 0..40 {
                let inside = column < 14 && row >= 24;
                assert_eq!(picture.y().row(row)[column] > 0, inside, "{column},{row}");
            }
        }
        assert_eq!(
            rendered(Outline::Ellipse, PixelBox { u: 100.0, ..bounds }),
            Picture::black(SIZE, ColourEncoding::JPEG)
        );
    }
}
