//! One row of a convolution: most of the refinement network's work.
//!
//! The sums are taken tap by tap. The accumulators are separate variables: as an array of rows, a compiler may vectorise
//! across the outputs with gathered weights, which takes forty times as long as across the columns.

use crate::simd::simd_kernel;

/// Columns of the maps.
pub(super) const COLUMNS: usize = 16;
/// Outputs that are summed at the same time.
const BLOCK: usize = 4;

simd_kernel! {
/// Computes a row of `out.len()` outputs, a multiple of [`BLOCK`]. Tap by tap, `starts` gives the place in `map` from
/// which a row of inputs is read, and `weights` the weights of all outputs.
pub(super) fn convolve_row(weights: &[f32], bias: &[f32], map: &[f32], starts: &[usize], out: &mut [[f32; COLUMNS]]) {
    let outputs = bias.len();
    let blocks = out.as_chunks_mut::<BLOCK>().0.iter_mut().zip(bias.as_chunks::<BLOCK>().0);
    for (block, (out, bias)) in blocks.enumerate() {
        let [mut a, mut b, mut c, mut d] = bias.map(|bias| [bias; COLUMNS]);
        for (&start, weights) in starts.iter().zip(weights.chunks_exact(outputs)) {
            let line = &map[start..][..COLUMNS];
            let weights = &weights[block * BLOCK..][..BLOCK];
            add_scaled(&mut a, weights[0], line);
            add_scaled(&mut b, weights[1], line);
            add_scaled(&mut c, weights[2], line);
            add_scaled(&mut d, weights[3], line);
        }
        *out = [a, b, c, d];
    }
}
}

/// Adds the inputs times a weight to the sums of a row.
#[inline(always)]
fn add_scaled(sums: &mut [f32; COLUMNS], weight: f32, line: &[f32]) {
    for x in 0..COLUMNS {
        sums[x] += weight * line[x];
    }
}
