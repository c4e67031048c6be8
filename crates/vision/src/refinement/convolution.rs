//! Convolutions of the refinement network, in integers: most of its work.
//!
//! The inputs of a convolution are rounded to [`INPUT_STEPS`] steps of the largest one, and the weights of an
//! output to up to 32,767 steps of the largest one. The sums are exact, so that they are the same on every
//! machine, and two products take one instruction (`barrelman-simd`).

use barrelman_simd::{COLUMNS, OUTPUTS, Pair, RowSums, sum_pair_products};

use crate::simd::{level, simd_kernel};

/// Largest number of rows.
pub(super) const MAX_ROWS: usize = 16;

/// Steps of the largest input of a convolution.
const INPUT_STEPS: f32 = 4095.0;
/// Largest number of steps of a weight.
const WEIGHT_STEPS: f32 = 32_767.0;
/// Limit of the sum of an output, whatever the inputs are. The rounding of a thousand weights adds at most 2
/// million to it, and 32 bits hold 2,147 million.
const SUM_LIMIT: f32 = 2.1e9;

/// A row of a map.
type Row = [f32; COLUMNS];

/// Weights of a convolution.
#[derive(Debug)]
pub(super) struct Convolution {
    /// Block by block of outputs; in each, for each pair of channels and each tap of the window, the weights
    /// of the outputs.
    weights: Vec<[Pair; OUTPUTS]>,
    /// Size of a step of each output's weights.
    units: Vec<f32>,
    bias: Vec<f32>,
}

impl Convolution {
    /// From the weights of all inputs, output by output, and the biases. An input is a tap, of `taps`, of a
    /// channel. The number of outputs is a multiple of [`OUTPUTS`].
    pub(super) fn new(weights: &[f32], bias: Vec<f32>, taps: usize) -> Self {
        let outputs = bias.len();
        let inputs = weights.len() / outputs;
        let channels = inputs / taps;
        let units: Vec<f32> = weights
            .chunks_exact(inputs)
            .map(|weights| {
                let largest = weights.iter().fold(0.0_f32, |largest, weight| largest.max(weight.abs()));
                let sum: f32 = weights.iter().map(|weight| weight.abs()).sum();
                // Above 0, so that weights of zero are zero steps.
                (largest / WEIGHT_STEPS).max(sum * (INPUT_STEPS / SUM_LIMIT)).max(f32::MIN_POSITIVE)
            })
            .collect();
        let step = |output: usize, channel: usize, tap: usize| {
            // The second channel of the last pair may be missing.
            let weight =
                if channel < channels { weights[output * inputs + channel * taps + tap] } else { 0.0 };
            libm::roundf(weight / units[output]) as i16
        };
        let mut blocks = Vec::with_capacity(channels.div_ceil(2) * taps * outputs / OUTPUTS);
        for first in (0..outputs).step_by(OUTPUTS) {
            for pair in 0..channels.div_ceil(2) {
                blocks.extend((0..taps).map(|tap| -> [Pair; OUTPUTS] {
                    core::array::from_fn(|k| [0, 1].map(|second| step(first + k, 2 * pair + second, tap)))
                }));
            }
        }
        Self { weights: blocks, units, bias }
    }

    /// Applies the convolution, to whose sums the maps of `added` are added, and in whose results negative
    /// values become 0. For each pair of channels and each tap, `starts` gives the place in `maps` that the
    /// first row of the results reads from.
    pub(super) fn apply(&self, maps: &IntegerMaps, starts: &[usize], added: Option<&[f32]>, to: &mut [f32]) {
        let mut sums = [[[0; COLUMNS]; OUTPUTS]; MAX_ROWS];
        let sums = &mut sums[..maps.layout.rows];
        for (block, weights) in self.weights.chunks_exact(starts.len()).enumerate() {
            sum_pair_products(level(), weights, &maps.pairs, starts, maps.layout.stride, sums);
            finish_block(self, sums, block, maps.unit, added, to);
        }
    }
}

/// Where the rows of a map lie in its integers, which may have a border of zeros.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Number of integers.
    pub(super) area: usize,
    /// Place of the first row.
    pub(super) first: usize,
    /// From the begin of a row to that of the next one.
    pub(super) stride: usize,
    /// Number of rows.
    pub(super) rows: usize,
}

/// The inputs of a convolution: maps as integers, two channels beside each other.
#[derive(Debug)]
pub(super) struct IntegerMaps {
    pairs: Vec<Pair>,
    layout: Layout,
    /// The value of a step.
    unit: f32,
}

impl IntegerMaps {
    /// Maps of zeros of an even number of channels.
    pub(super) fn new(channels: usize, layout: Layout) -> Self {
        Self { pairs: vec![[0; 2]; channels / 2 * layout.area], layout, unit: 0.0 }
    }

    /// Rounds maps, one channel after the other and row by row.
    pub(super) fn round(&mut self, maps: &[f32]) {
        let rows = maps.as_chunks::<COLUMNS>().0;
        let mut largest = [0.0];
        find_largest(rows, &mut largest);
        // Maps without a value, and those with one that is not finite, become zeros.
        let is_usable = largest[0] > 0.0 && largest[0].is_finite();
        self.unit = if is_usable { largest[0] / INPUT_STEPS } else { 0.0 };
        let steps_per_unit = if is_usable { INPUT_STEPS / largest[0] } else { 0.0 };
        round_rows(rows, steps_per_unit, self.layout, &mut self.pairs);
    }
}

simd_kernel! {
/// Turns the sums of a block into results.
fn finish_block(
    layer: &Convolution, sums: &[RowSums], block: usize, unit: f32, added: Option<&[f32]>, to: &mut [f32]
) {
    let rows = sums.len();
    for k in 0..OUTPUTS {
        let channel = block * OUTPUTS + k;
        let (scale, bias) = (layer.units[channel] * unit, layer.bias[channel]);
        for (row, sums) in sums.iter().enumerate() {
            let place = (channel * rows + row) * COLUMNS;
            let before = added.map_or(&[0.0; COLUMNS][..], |maps| &maps[place..][..COLUMNS]);
            let out = &mut to[place..][..COLUMNS];
            for x in 0..COLUMNS {
                out[x] = (sums[k][x] as f32 * scale + bias + before[x]).max(0.0);
            }
        }
    }
}
}

simd_kernel! {
fn find_largest(rows: &[Row], largest: &mut [f32; 1]) {
    let mut columns = [0.0_f32; COLUMNS];
    for row in rows {
        for x in 0..COLUMNS {
            let value = row[x].abs();
            columns[x] = if value > columns[x] { value } else { columns[x] };
        }
    }
    largest[0] = columns.into_iter().fold(0.0, f32::max);
}
}

simd_kernel! {
fn round_rows(rows: &[Row], steps_per_unit: f32, layout: Layout, pairs: &mut [Pair]) {
    for (channels, pairs) in rows.chunks_exact(2 * layout.rows).zip(pairs.chunks_exact_mut(layout.area)) {
        let (first, second) = channels.split_at(layout.rows);
        for (row, (first, second)) in first.iter().zip(second).enumerate() {
            let out = &mut pairs[layout.first + row * layout.stride..][..COLUMNS];
            for x in 0..COLUMNS {
                out[x] = [rounded(first[x] * steps_per_unit), rounded(second[x] * steps_per_unit)];
            }
        }
    }
}
}

/// The nearest integer of a value of at most [`INPUT_STEPS`]; of two, the even one. In a sum with 3 * 2^22
/// the last bits are the integer's; a conversion, which limits the value, takes several times as long.
#[inline(always)]
fn rounded(value: f32) -> i16 {
    (value + 12_582_912.0).to_bits() as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYOUT: Layout = Layout { area: 18, first: 1, stride: 18, rows: 1 };

    #[test]
    fn a_convolution_holds_to_a_thousandth_of_its_largest_product() {
        let value = |k: usize| ((k * 37 % 101) as f32 - 50.0) * 0.013;
        let weights: Vec<f32> = (0..8 * 4 * 3).map(value).collect();
        let maps: Vec<f32> = (0..4 * COLUMNS).map(|k| 20.0 * value(k + 7)).collect();
        let bias: Vec<f32> = (0..8).map(|k| k as f32).collect();
        let convolution = Convolution::new(&weights, bias, 3);
        let mut integers = IntegerMaps::new(4, LAYOUT);
        integers.round(&maps);
        let starts: Vec<usize> = (0..6).map(|tap| tap / 3 * LAYOUT.area + tap % 3).collect();
        let mut out = [[0.0; COLUMNS]; 8];
        convolution.apply(&integers, &starts, Some(&[3.0; 8 * COLUMNS]), out.as_flattened_mut());
        for (output, row) in out.iter().enumerate() {
            for (x, value) in row.iter().enumerate() {
                let expected: f32 = (0..12)
                    .map(|input| {
                        let (channel, column) = (input / 3, (x + input % 3).checked_sub(1));
                        let column = column.filter(|&column| column < COLUMNS);
                        weights[output * 12 + input]
                            * column.map_or(0.0, |column| maps[channel * COLUMNS + column])
                    })
                    .sum();
                let expected = (expected + output as f32 + 3.0).max(0.0);
                assert!((value - expected).abs() < 0.009, "{output}, {x}: {value}, not {expected}");
            }
        }
    }

    #[test]
    fn the_largest_sum_does_not_wrap_around() {
        let convolution = Convolution::new(&[3.0; 8 * 432], vec![0.0; 8], 9);
        let layout = Layout { area: 18 * 18, first: 19, stride: 18, rows: 16 };
        let mut maps = IntegerMaps::new(48, layout);
        maps.round(&[5.0; 48 * 256]);
        let starts: Vec<usize> =
            (0..24 * 9).map(|tap| tap / 9 * layout.area + tap % 9 / 3 * 18 + tap % 3).collect();
        let mut out = [0.0; 8 * 256];
        convolution.apply(&maps, &starts, None, &mut out);
        assert!((out[5 * COLUMNS + 7] / (432.0 * 15.0) - 1.0).abs() < 1e-3, "{}", out[5 * COLUMNS + 7]);
    }

    #[test]
    fn maps_without_a_finite_value_are_zeros() {
        let mut maps = IntegerMaps::new(2, LAYOUT);
        for value in [0.0, f32::INFINITY, f32::NAN] {
            maps.round(&[value; 2 * COLUMNS]);
            assert!(maps.pairs.iter().all(|pair| *pair == [0; 2]), "{value}");
            assert_eq!(maps.unit, 0.0);
        }
    }

    #[test]
    fn values_are_rounded_to_the_nearest_integer() {
        let cases = [
            (0.0, 0),
            (0.4, 0),
            (0.6, 1),
            (-0.4, 0),
            (-0.6, -1),
            (1.5, 2),
            (2.5, 2),
            (4095.0, 4095),
            (-4095.0, -4095),
        ];
        for (value, integer) in cases {
            assert_eq!(rounded(value), integer, "{value}");
        }
    }

    #[test]
    fn weights_of_zero_give_the_bias() {
        let mut maps = IntegerMaps::new(2, LAYOUT);
        maps.round(&[1.0; 2 * COLUMNS]);
        let mut out = [[0.0; COLUMNS]; 8];
        Convolution::new(&[0.0; 8 * 2], vec![1.5; 8], 1).apply(&maps, &[0], None, out.as_flattened_mut());
        assert_eq!(out, [[1.5; COLUMNS]; 8]);
    }
}
