//! Histograms of oriented gradients over square cells (Dalal and Triggs 2005): the channels that do not use
//! colour.
//!
//! At each sample the gradient d = (dx, dy) is the central difference, m its magnitude. It votes for the
//! unsigned directions within 20 degrees: with the unit vector e of a direction, the vote is max(0, |d . e| -
//! m cos 20), which is largest along e and zero at the neighbouring directions. The votes are summed over a
//! cell. A cell's histogram is divided by the root of the mean energy of the 3 x 3 cells around it and
//! clipped at [`MAX_NORMALISED`].

use crate::simd::simd_kernel;

/// Number of unsigned directions, 20 degrees apart.
pub(crate) const DIRECTIONS: usize = 9;
/// Side of a cell, samples.
pub(crate) const CELL: usize = 4;
/// Samples around the cells that the differences need.
pub(crate) const MARGIN: usize = 1;

/// Upper bound of a normalised value: limits the influence of a single strong edge.
const MAX_NORMALISED: f32 = 0.4;
/// Noise floor of a cell's energy, squared grey levels: keeps flat water from being amplified.
const NOISE_ENERGY: f32 = 60.0;

/// Gradient histograms of a patch.
#[derive(Debug, Default)]
pub(crate) struct GradientHistograms {
    /// `width * height` cells of each direction in turn.
    cells: Vec<f32>,
    energy: Vec<f32>,
    /// Factor of each cell.
    scales: Vec<f32>,
    lines: Vec<f32>,
}

impl GradientHistograms {
    /// Computes the histograms of a patch of `(width * CELL + 2 * MARGIN) x (height * CELL + 2 * MARGIN)`
    /// samples.
    pub(crate) fn compute(
        &mut self,
        patch: &[f32],
        width: usize,
        height: usize,
        directions: &[(f32, f32); DIRECTIONS],
        cos_step: f32,
    ) {
        compute_cells(self, patch, width, height, directions, cos_step);
        normalise(self, width, height);
    }

    /// The histograms: direction by direction, row by row.
    pub(crate) fn cells(&self) -> &[f32] {
        &self.cells
    }
}

/// The unit vectors of the directions, and the cosine of the angle between neighbouring directions.
pub(crate) fn unit_directions() -> ([(f32, f32); DIRECTIONS], f32) {
    let step = core::f64::consts::PI / DIRECTIONS as f64;
    let mut vectors = [(0.0, 0.0); DIRECTIONS];
    for (k, vector) in vectors.iter_mut().enumerate() {
        let angle = step * k as f64;
        *vector = (libm::cos(angle) as f32, libm::sin(angle) as f32);
    }
    (vectors, libm::cos(step) as f32)
}

simd_kernel! {
fn compute_cells(g: &mut GradientHistograms, patch: &[f32], width: usize, height: usize, directions: &[(f32, f32); DIRECTIONS], cos_step: f32) {
    let samples = width * CELL;
    let stride = samples + 2 * MARGIN;
    g.cells.resize(DIRECTIONS * width * height, 0.0);
    g.lines.resize((DIRECTIONS + 3 * CELL) * samples, 0.0);
    let (sums, gradient) = g.lines.split_at_mut(DIRECTIONS * samples);
    let (dx, rest) = gradient.split_at_mut(CELL * samples);
    let (dy, magnitude) = rest.split_at_mut(CELL * samples);
    for cell_row in 0..height {
        for within in 0..CELL {
            let row = cell_row * CELL + within + MARGIN;
            let above = &patch[(row - 1) * stride + MARGIN..][..samples];
            let below = &patch[(row + 1) * stride + MARGIN..][..samples];
            let left = &patch[row * stride..][..samples];
            let right = &patch[row * stride + 2 * MARGIN..][..samples];
            let line = within * samples..(within + 1) * samples;
            let (dx, dy, magnitude) = (&mut dx[line.clone()], &mut dy[line.clone()], &mut magnitude[line]);
            for i in 0..samples {
                let (x, y) = (right[i] - left[i], below[i] - above[i]);
                dx[i] = x;
                dy[i] = y;
                magnitude[i] = (x * x + y * y).sqrt() * cos_step;
            }
        }
        let ([dx0, dx1, dx2, dx3], [dy0, dy1, dy2, dy3]) = (rows(dx, samples), rows(dy, samples));
        let [magnitude0, magnitude1, magnitude2, magnitude3] = rows(magnitude, samples);
        for (sum, &(cos, sin)) in sums.chunks_exact_mut(samples).zip(directions) {
            let vote = |x: f32, y: f32, magnitude: f32| {
                let along = (x * cos + y * sin).abs() - magnitude;
                if along > 0.0 { along } else { 0.0 }
            };
            for i in 0..samples {
                sum[i] = vote(dx0[i], dy0[i], magnitude0[i])
                    + vote(dx1[i], dy1[i], magnitude1[i])
                    + vote(dx2[i], dy2[i], magnitude2[i])
                    + vote(dx3[i], dy3[i], magnitude3[i]);
            }
        }
        for (direction, sum) in sums.chunks_exact(samples).enumerate() {
            let out = &mut g.cells[(direction * height + cell_row) * width..][..width];
            for (out, cell) in out.iter_mut().zip(sum.chunks_exact(CELL)) {
                *out = cell[0] + cell[1] + cell[2] + cell[3];
            }
        }
    }
}
}

/// The rows of a line of cells.
#[inline(always)]
fn rows(lines: &[f32], samples: usize) -> [&[f32]; CELL] {
    core::array::from_fn(|within| &lines[within * samples..][..samples])
}

simd_kernel! {
fn normalise(g: &mut GradientHistograms, width: usize, height: usize) {
    let area = width * height;
    // The energies have a border of zeros, which add nothing to the sums at the edges.
    let stride = width + 2;
    g.energy.clear();
    g.energy.resize(stride * (height + 2), 0.0);
    for channel in g.cells.chunks_exact(area) {
        for (row, cells) in channel.chunks_exact(width).enumerate() {
            let energy = &mut g.energy[(row + 1) * stride + 1..][..width];
            for (sum, &value) in energy.iter_mut().zip(cells) {
                *sum += value * value;
            }
        }
    }
    g.scales.resize(area, 0.0);
    for (row, scales) in g.scales.chunks_exact_mut(width).enumerate() {
        let [above, here, below] = core::array::from_fn(|k| &g.energy[(row + k) * stride..][..stride]);
        let rows = 1 + usize::from(row > 0) + usize::from(row + 1 < height);
        for (column, scale) in scales.iter_mut().enumerate() {
            let mut sum = 0.0;
            for line in [above, here, below] {
                sum = sum + line[column] + line[column + 1] + line[column + 2];
            }
            let columns = 1 + usize::from(column > 0) + usize::from(column + 1 < width);
            *scale = 1.0 / (sum / (rows * columns) as f32 + NOISE_ENERGY).sqrt();
        }
    }
    for channel in g.cells.chunks_exact_mut(area) {
        for (value, &scale) in channel.iter_mut().zip(&g.scales) {
            let scaled = *value * scale;
            *value = if scaled > MAX_NORMALISED { MAX_NORMALISED } else { scaled };
        }
    }
}
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 6;

    /// The cells of a patch whose samples are given as a function of the distance right and down of its
    /// centre.
    fn measured(sample: impl Fn(f32, f32) -> f32) -> Vec<f32> {
        let stride = SIDE * CELL + 2 * MARGIN;
        let middle = 0.5 * (stride as f32 - 1.0);
        let patch: Vec<f32> = (0..stride * stride)
            .map(|index| sample((index % stride) as f32 - middle, (index / stride) as f32 - middle))
            .collect();
        let (vectors, cos_step) = unit_directions();
        let mut gradients = GradientHistograms::default();
        gradients.compute(&patch, SIDE, SIDE, &vectors, cos_step);
        gradients.cells().to_vec()
    }

    fn total(cells: &[f32], direction: usize) -> f32 {
        cells[direction * SIDE * SIDE..][..SIDE * SIDE].iter().sum()
    }

    #[test]
    fn a_step_edge_falls_into_the_direction_across_it() {
        for expected in 0..DIRECTIONS {
            let angle = 20.0_f32.to_radians() * expected as f32;
            let (cos, sin) = (libm::cosf(angle), libm::sinf(angle));
            for sign in [1.0, -1.0] {
                // Ten grey levels per sample over eight samples: a step as a lens images it.
                let cells = measured(|right, down| {
                    100.0 + sign * (10.0 * (right * cos + down * sin)).clamp(-40.0, 40.0)
                });
                let most = total(&cells, expected);
                assert!(most > 0.0);
                for other in (0..DIRECTIONS).filter(|&other| other != expected) {
                    let share = total(&cells, other) / most;
                    // The ends of the step are curved; measured 0.143 at most.
                    assert!(share < 0.2, "an edge across {expected} is {share} in {other}");
                }
            }
        }
    }

    #[test]
    fn a_flat_patch_has_no_gradients_whatever_its_brightness() {
        for level in [0.0, 127.0, 255.0] {
            assert!(measured(|_, _| level).iter().all(|&value| value == 0.0));
        }
    }

    #[test]
    fn a_faint_edge_stays_faint_and_a_strong_one_is_bounded() {
        let highest = |contrast: f32| {
            let step = measured(|right, _| if right > 0.0 { contrast } else { 0.0 });
            step.into_iter().fold(0.0, f32::max)
        };
        assert!(highest(0.5) < 0.2, "{}", highest(0.5));
        assert!(highest(0.5) < highest(5.0));
        assert_eq!(highest(255.0), MAX_NORMALISED);
        assert_eq!(highest(255.0), highest(120.0));
    }
}
