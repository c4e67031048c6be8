//! Integral image of the target probabilities of a picture: the sum over a box in four look-ups.

use barrelman_vocab::Picture;

use crate::colour_model::{ColourModel, bin};
use crate::simd::simd_kernel;

/// Sums of target probabilities, with the buffers.
#[derive(Debug, Default)]
pub(crate) struct IntegralImage {
    /// Sums over all samples above and to the left, with a first row and column of zeros.
    sums: Vec<u32>,
    /// Number of samples in a row, and of rows.
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Bins of the colours of one row.
    bins: Vec<u16>,
}

impl IntegralImage {
    /// Computes the integral image of the target probabilities of every `step`-th chroma sample.
    pub(crate) fn build(&mut self, picture: &Picture, model: &ColourModel, step: usize) {
        let (y, u, v) = (picture.y(), picture.u(), picture.v());
        (self.width, self.height) = (u.width / step, u.height / step);
        let stride = self.width + 1;
        self.sums.clear();
        self.sums.resize(stride * (self.height + 1), 0);
        if self.width == 0 {
            return;
        }
        let table = model.table();
        self.bins.resize(self.width, 0);
        for row in 0..self.height {
            let (us, vs) = (u.row(row * step + step / 2), v.row(row * step + step / 2));
            let ys = y.row((2 * (row * step + step / 2)).min(y.height - 1));
            bins_of_row([ys, us, vs], step, &mut self.bins);
            let (above, here) = self.sums.split_at_mut((row + 1) * stride);
            let above = &above[row * stride + 1..];
            let mut sum = 0;
            for ((out, above), &bin) in here[1..stride].iter_mut().zip(above).zip(&self.bins) {
                sum += u32::from(table.of_bin(bin));
                *out = sum + above;
            }
        }
    }

    /// The sums up to a row, from the column of zeros on.
    pub(crate) fn line(&self, row: usize) -> &[u32] {
        let stride = self.width + 1;
        &self.sums[row * stride..][..stride]
    }

    /// Sum and number of the samples in a square with `half` samples to every side of the centre.
    pub(crate) fn square_sum(&self, column: usize, row: usize, half: usize) -> (u32, u32) {
        self.box_sum((column, row), (half, half))
    }

    /// Sum and number of the samples in a box with `half` samples to the sides of the centre.
    pub(crate) fn box_sum(&self, (column, row): (usize, usize), half: (usize, usize)) -> (u32, u32) {
        let (left, top) = (column.saturating_sub(half.0), row.saturating_sub(half.1));
        let (right, bottom) = ((column + half.0 + 1).min(self.width), (row + half.1 + 1).min(self.height));
        let at = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
        let sum = at(right, bottom) + at(left, top) - at(left, bottom) - at(right, top);
        (sum, ((right - left) * (bottom - top)) as u32)
    }
}

simd_kernel! {
/// The bins of the colours of every `step`-th chroma sample of a row of Y, U and V.
fn bins_of_row(planes: [&[u8]; 3], step: usize, out: &mut [u16]) {
    let [ys, us, vs] = planes;
    if step == 1 && ys.len() >= 2 * out.len() {
        for (((out, y), &u), &v) in out.iter_mut().zip(ys.as_chunks::<2>().0).zip(us).zip(vs) {
            *out = bin(y[0], u, v) as u16;
        }
        return;
    }
    for (column, out) in out.iter_mut().enumerate() {
        let x = column * step + step / 2;
        *out = bin(ys[(2 * x).min(ys.len() - 1)], us[x], vs[x]) as u16;
    }
}
}
