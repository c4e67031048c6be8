//! The target probabilities of a crop, and their means in and around an ellipse.

use barrelman_vocab::PixelBox;

use crate::vector::Rotation;

/// Inner radius of the ring around an ellipse, squared, in squared radii of the ellipse: 1.3^2. The outer
/// radius is 2.
const RING_INNER_SQUARED: f32 = 1.69;

/// Mean target probability inside the target's ellipse and in the ring around it, 0 to 1 each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ColourContrast {
    pub(crate) inside: f32,
    pub(crate) ring: f32,
}

/// The target probabilities of a crop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProbabilityView<'a> {
    /// Row by row, 0 to 255.
    pub(crate) values: &'a [u8],
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Columns and rows that lie in the picture.
    pub(crate) size_in_picture: (usize, usize),
    /// Left and top edge, pixels of the picture.
    pub(crate) left: f32,
    pub(crate) top: f32,
    /// Pixels of the picture per sample.
    pub(crate) unit: f32,
}

impl ProbabilityView<'_> {
    /// Bounds of all samples, pixels of the picture.
    pub(crate) fn bounds(&self) -> PixelBox {
        self.bounds_of((0, 0), (self.width, self.height))
    }

    /// Bounds of the samples from a first column and row to before an end, pixels of the picture.
    pub(crate) fn bounds_of(&self, first: (usize, usize), end: (usize, usize)) -> PixelBox {
        let unit = f64::from(self.unit);
        PixelBox {
            u: f64::from(self.left) + unit * first.0 as f64,
            v: f64::from(self.top) + unit * first.1 as f64,
            w: unit * (end.0 - first.0) as f64,
            h: unit * (end.1 - first.1) as f64,
        }
    }

    /// Calls `visit` for each sample inside an ellipse and inside the picture, with the distance right and
    /// down of the centre (pixels) and the index of the sample. The ellipse has the half axes `half` (pixels)
    /// around `centre`; `angle` turns it clockwise, radians.
    pub(crate) fn for_each_in_ellipse(
        &self,
        centre: (f32, f32),
        half: (f32, f32),
        angle: f32,
        mut visit: impl FnMut(f32, f32, usize),
    ) {
        let unit = self.unit;
        let turn = Rotation::by(angle);
        let Rotation { cos, sin } = turn;
        let reach =
            ((half.0 * cos).abs() + (half.1 * sin).abs(), (half.0 * sin).abs() + (half.1 * cos).abs());
        // A cast turns negative numbers and NaN into 0.
        let index = |at: f32, length: usize| ((at / unit) as usize).min(length);
        let (left, top) = (centre.0 - self.left, centre.1 - self.top);
        let (width, height) = self.size_in_picture;
        let columns = index(left - reach.0, width)..index(left + reach.0 + unit, width);
        let inverse = (1.0 / half.0.max(1.0), 1.0 / half.1.max(1.0));
        for row in index(top - reach.1, height)..index(top + reach.1 + unit, height) {
            let dv = (row as f32 + 0.5) * unit - top;
            let first = row * self.width;
            for column in columns.clone() {
                let du = (column as f32 + 0.5) * unit - left;
                let (along, across) = turn.undo((du, dv));
                let (a, b) = (along * inverse.0, across * inverse.1);
                if a * a + b * b <= 1.0 {
                    visit(du, dv, first + column);
                }
            }
        }
    }

    /// Mean target probability inside an ellipse (see [`Self::for_each_in_ellipse`]) and in the ring from
    /// 1.3 to 2 times its size; 0 where no sample of either lies in the picture.
    pub(crate) fn contrast(&self, centre: (f32, f32), half: (f32, f32), angle: f32) -> ColourContrast {
        let (mut inner, mut outer) = ((0_u32, 0_u32), (0_u32, 0_u32));
        let turn = Rotation::by(angle);
        let inverse = (1.0 / half.0.max(1.0), 1.0 / half.1.max(1.0));
        self.for_each_in_ellipse(centre, (2.0 * half.0, 2.0 * half.1), angle, |du, dv, index| {
            let probability = u32::from(self.values[index]);
            let (along, across) = turn.undo((du, dv));
            let (a, b) = (along * inverse.0, across * inverse.1);
            let radius_squared = a * a + b * b;
            if radius_squared <= 1.0 {
                inner = (inner.0 + probability, inner.1 + 1);
            } else if radius_squared >= RING_INNER_SQUARED {
                outer = (outer.0 + probability, outer.1 + 1);
            }
        });
        let mean =
            |(sum, count): (u32, u32)| if count == 0 { 0.0 } else { sum as f32 / (255 * count) as f32 };
        ColourContrast { inside: mean(inner), ring: mean(outer) }
    }
}

impl ColourContrast {
    /// Inside less ring, -1 to 1.
    pub(crate) fn difference(self) -> f32 {
        self.inside - self.ring
    }
}
