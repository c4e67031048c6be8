//! Look-up table from Y, U and V to the weight of the hue in the target's histogram.
//!
//! The four pixels of a 2 x 2 block share U and V, and a picture contains few pairs of them. A row of 256
//! weights, one per Y, is computed when a pair first occurs and kept until the next selection. After that a
//! pixel costs one look-up. Pairs without weight at any Y, such as those of grey water, share one row.
//!
//! Work: 256 conversions, about a microsecond, for each pair that occurs for the first time since the
//! selection; there are 65,536 pairs, and a few thousand in a natural picture. Memory: a quarter of a
//! megabyte plus 256 bytes per pair with a weight, at most 16 MiB, reserved at the selection and used on
//! demand.

use crate::hue::{Floors, YuvToHue};

/// Number of pairs of U and V.
const PAIRS: usize = 1 << 16;

/// The weights of all colours of one encoding for one histogram.
#[derive(Debug)]
pub(crate) struct HueWeightTable {
    hue: YuvToHue,
    floors: Floors,
    /// Weight of each hue code.
    weight_by_hue: [u8; 256],
    /// For each pair: 0 before it first occurs, else the index of its row plus one.
    row_numbers: Vec<u32>,
    /// The first row is all zeros.
    rows: Vec<[u8; 256]>,
}

impl HueWeightTable {
    pub(crate) fn new(hue: YuvToHue, floors: Floors, weight_by_hue: [u8; 256]) -> Self {
        let mut rows = Vec::with_capacity(PAIRS + 1);
        rows.push([0; 256]);
        Self { hue, floors, weight_by_hue, row_numbers: vec![0; PAIRS], rows }
    }

    /// Sets the encoding of the pictures and discards the rows.
    pub(crate) fn set_encoding(&mut self, hue: YuvToHue) {
        self.hue = hue;
        self.row_numbers.fill(0);
        self.rows.truncate(1);
    }

    pub(crate) const fn hue(&self) -> &YuvToHue {
        &self.hue
    }

    /// Looks up two rows of pixels that share a row of chroma samples: each is given as its Y and the weights
    /// to fill. A row may be empty, or end with the first half of the last block.
    pub(crate) fn fill_weights(&mut self, us: &[u8], vs: &[u8], [upper, lower]: [(&[u8], &mut [u8]); 2]) {
        let (upper_whole, upper_rest) = upper.0.as_chunks::<2>();
        let (upper_weights, upper_rest_weights) = upper.1.as_chunks_mut::<2>();
        let (lower_whole, lower_rest) = lower.0.as_chunks::<2>();
        let (lower_weights, lower_rest_weights) = lower.1.as_chunks_mut::<2>();
        let mut chroma = us.iter().zip(vs);
        if lower_whole.len() == upper_whole.len() {
            let upper = upper_whole.iter().zip(upper_weights);
            let lower = lower_whole.iter().zip(lower_weights);
            for ((upper, lower), (&u, &v)) in upper.zip(lower).zip(&mut chroma) {
                let row = self.row_for(u, v);
                *upper.1 = upper.0.map(|y| row[usize::from(y)]);
                *lower.1 = lower.0.map(|y| row[usize::from(y)]);
            }
        } else {
            for ((ys, weights), (&u, &v)) in upper_whole.iter().zip(upper_weights).zip(&mut chroma) {
                let row = self.row_for(u, v);
                *weights = ys.map(|y| row[usize::from(y)]);
            }
        }
        if let (Some(&u), Some(&v)) = (us.get(upper_whole.len()), vs.get(upper_whole.len())) {
            let row = self.row_for(u, v);
            let upper = upper_rest.iter().zip(upper_rest_weights);
            let lower = lower_rest.iter().zip(lower_rest_weights);
            for (&y, weight) in upper.chain(lower) {
                *weight = row[usize::from(y)];
            }
        }
    }

    /// The weights of all Y for a pair of U and V.
    #[inline]
    fn row_for(&mut self, u: u8, v: u8) -> &[u8; 256] {
        let pair = usize::from(u) << 8 | usize::from(v);
        let number = match self.row_numbers[pair] {
            0 => self.compute_row(u, v),
            known => known,
        };
        &self.rows[number as usize - 1]
    }

    #[cold]
    fn compute_row(&mut self, u: u8, v: u8) -> u32 {
        let weight =
            |y: usize| self.weight_by_hue[usize::from(self.hue.hue_code([y as u8, u, v], self.floors))];
        let row = core::array::from_fn(weight);
        if row.iter().any(|&weight| weight > 0) {
            self.rows.push(row);
        }
        // The row of zeros is the first one. There are at most `PAIRS + 1` rows, so the cast is lossless.
        let number = if row == self.rows[0] { 1 } else { self.rows.len() as u32 };
        self.row_numbers[usize::from(u) << 8 | usize::from(v)] = number;
        number
    }
}
