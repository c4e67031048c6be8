//! The refinement network: from the cells of a window to the box, its expected error and its probability.
//!
//! | layer | from | to |
//! |---|---|---|
//! | convolution 3 x 3, stride 2 | 11 x 32 x 32 | 32 x 16 x 16 |
//! | convolution 3 x 3 | 32 x 16 x 16 | 48 x 16 x 16 |
//! | convolution 3 x 3, dilation 2, added to its input | 48 x 16 x 16 | 48 x 16 x 16 |
//! | convolution 3 x 3, dilation 4, added to its input | 48 x 16 x 16 | 48 x 16 x 16 |
//! | for each axis: maximum and mean over the other axis | 48 x 16 x 16 | 96 x 16 |
//! | for each axis: convolution 3 | 96 x 16 | 24 x 16 |
//! | for each axis: dense | 384 | 48 |
//! | for each axis: dense: shifts of both edges, logarithms of their errors | 48 | 4 |
//! | dense, from mean, maximum and mean of the middle of each map, both axes and measurements | 252 | 32 |
//! | dense: log-odds of the box | 32 | 1 |
//!
//! Both axes share their weights. After each layer but the answers, negative values become 0. About 15
//! million multiplications, those of the convolutions in integers ([`super::convolution`]). Where the
//! probability of the box is below 0.85, the network is evaluated on the window turned by 180 degrees, too,
//! and the answers are averaged: what differs between the two is an error of the weights.

use std::sync::Arc;

use super::convolution::{IntegerMaps, Layout};
use super::refined_box::{RefinedBox, apart};
use super::weights::{ANSWERS, EDGE, FIRST, JUDGE, JUDGED, PROFILE, RefinementWeights, SECOND, SIDE};
use super::window::{MEASUREMENTS, RefinementWindow, WINDOW_CHANNELS, WINDOW_SIDE_CELLS};
use crate::simd::simd_kernel;

/// Border around the maps, cells: the largest dilation.
const BORDER: usize = 4;
/// Side of the maps with their border.
const PADDED: usize = SIDE + 2 * BORDER;
/// Dilations of the convolutions after the first.
const DILATIONS: [usize; 3] = [1, 2, 4];
/// Cells in the middle of the maps, along each axis.
const MIDDLE: core::ops::Range<usize> = 5..11;
/// Scale of the shifts of the edges, in sides of the window.
const SHIFT_SCALE: f32 = 0.4;
/// Log-odds of the box below which the turned window is evaluated, too: a probability of 0.85.
const SURE_LOG_ODDS: f32 = 1.734_601_1;
/// Offset and range of the logarithms of the errors.
const ERROR_OFFSET: f32 = -1.5;
const ERROR_RANGE: (f32, f32) = (-4.0, 3.0);

/// Channels of the window, and one of zeros where their number is odd: two are multiplied at once.
const INPUT: usize = WINDOW_CHANNELS.next_multiple_of(2);
/// Cells of a map.
const AREA: usize = SIDE * SIDE;

/// The four phases of the input, with a row and a column of zeros before them.
const PHASES: Layout =
    Layout { area: (SIDE + 1) * (SIDE + 1), first: SIDE + 2, stride: SIDE + 1, rows: SIDE };
/// The maps between the convolutions.
const MAPS: Layout =
    Layout { area: PADDED * PADDED, first: BORDER * (PADDED + 1), stride: PADDED, rows: SIDE };
/// The profiles of an axis.
const PROFILES: Layout = Layout { area: SIDE + 2, first: 1, stride: SIDE + 2, rows: 1 };

/// The network with its buffers.
#[derive(Debug)]
pub(crate) struct RefinementNetwork {
    weights: Arc<RefinementWeights>,
    /// The input in four phases: odd and even rows of odd and even columns; in each all channels.
    input: Vec<f32>,
    first: Vec<f32>,
    second: Vec<f32>,
    third: Vec<f32>,
    fourth: Vec<f32>,
    /// The inputs of the convolutions as integers.
    phases: IntegerMaps,
    few: IntegerMaps,
    many: IntegerMaps,
    profiles: IntegerMaps,
}

impl RefinementNetwork {
    pub(crate) fn new(weights: Arc<RefinementWeights>) -> Self {
        Self {
            weights,
            input: vec![0.0; 4 * INPUT * AREA],
            first: vec![0.0; FIRST * AREA],
            second: vec![0.0; SECOND * AREA],
            third: vec![0.0; SECOND * AREA],
            fourth: vec![0.0; SECOND * AREA],
            phases: IntegerMaps::new(4 * INPUT, PHASES),
            few: IntegerMaps::new(FIRST, MAPS),
            many: IntegerMaps::new(SECOND, MAPS),
            profiles: IntegerMaps::new(2 * SECOND, PROFILES),
        }
    }

    pub(crate) fn weights(&self) -> Arc<RefinementWeights> {
        Arc::clone(&self.weights)
    }

    /// Evaluates a window.
    pub(crate) fn evaluate(&mut self, window: &RefinementWindow) -> RefinedBox {
        let mut answer = self.answer(window, Orientation::Upright);
        if answer.log_odds < SURE_LOG_ODDS {
            answer = answer.averaged_with_turned(&self.answer(window, Orientation::Turned));
        }
        Self::refined_box(window, &answer)
    }

    /// Evaluates a window as it is only, in half of the time.
    pub(crate) fn evaluate_upright(&mut self, window: &RefinementWindow) -> RefinedBox {
        let answer = self.answer(window, Orientation::Upright);
        Self::refined_box(window, &answer)
    }

    fn refined_box(window: &RefinementWindow, answer: &Answer) -> RefinedBox {
        let (width, height) = window.box_size;
        let (u, v) = window.centre;
        let edge = |from_centre: f32, axis: usize, k: usize| {
            let (middle, side) = if axis == 0 { (u, window.sides.0) } else { (v, window.sides.1) };
            middle + from_centre + SHIFT_SCALE * side * answer.axes[axis][k]
        };
        let error = |axis: usize, k: usize| libm::expf(answer.axes[axis][k] + ERROR_OFFSET);
        let (left, right) = apart(edge(-0.5 * width, 0, 0), edge(0.5 * width, 0, 1));
        let (top, bottom) = apart(edge(-0.5 * height, 1, 0), edge(0.5 * height, 1, 1));
        RefinedBox {
            edges: [left, top, right, bottom],
            errors: [error(0, 2), error(1, 2), error(0, 3), error(1, 3)],
            probability: 1.0 / (1.0 + libm::expf(-answer.log_odds)),
        }
    }

    /// What the layers answer, with the logarithms of the errors in their range.
    fn answer(&mut self, window: &RefinementWindow, orientation: Orientation) -> Answer {
        let mut answer = Answer::default();
        split_phases(self, window, orientation);
        evaluate_layers(self, &window.measurements, &mut answer);
        for logarithm in answer.axes.iter_mut().flat_map(|axis| &mut axis[2..]) {
            *logarithm = logarithm.clamp(ERROR_RANGE.0, ERROR_RANGE.1);
        }
        answer
    }
}

/// The values of the last layers.
#[derive(Debug, Clone, Copy, Default)]
struct Answer {
    axes: [[f32; ANSWERS]; 2],
    log_odds: f32,
}

impl Answer {
    /// The mean of this answer and the one for the turned window, whose first edge is this one's second edge.
    fn averaged_with_turned(&self, turned: &Self) -> Self {
        let axes = core::array::from_fn(|axis| {
            let (
                [begin, end, begin_error, end_error],
                [other_end, other_begin, other_end_error, other_begin_error],
            ) = (self.axes[axis], turned.axes[axis]);
            [
                0.5 * (begin - other_begin),
                0.5 * (end - other_end),
                0.5 * (begin_error + other_begin_error),
                0.5 * (end_error + other_end_error),
            ]
        });
        Self { axes, log_odds: 0.5 * (self.log_odds + turned.log_odds) }
    }
}

/// How the network looks at a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Orientation {
    Upright,
    /// By 180 degrees.
    Turned,
}

/// Splits the input into phases, so that the first convolution reads neighbouring cells: a window with a
/// stride of 2 reads the odd columns before a cell, the even ones at the cell, and the odd ones after the
/// cell.
fn split_phases(network: &mut RefinementNetwork, window: &RefinementWindow, orientation: Orientation) {
    let channels = window.cells.as_chunks::<{ WINDOW_SIDE_CELLS * WINDOW_SIDE_CELLS }>().0;
    for (channel, &(mut cells)) in channels.iter().enumerate() {
        if orientation == Orientation::Turned {
            cells.reverse();
        }
        for (row, line) in cells.as_chunks::<WINDOW_SIDE_CELLS>().0.iter().enumerate() {
            let vertical = if row % 2 == 1 { 0 } else { 2 };
            let [odd, even] =
                [0, 1].map(|horizontal| ((vertical + horizontal) * INPUT + channel) * AREA + row / 2 * SIDE);
            for k in 0..SIDE {
                network.input[even + k] = line[2 * k];
                network.input[odd + k] = line[2 * k + 1];
            }
        }
    }
    network.phases.round(&network.input);
}

fn evaluate_layers(network: &mut RefinementNetwork, measurements: &[f32; MEASUREMENTS], answer: &mut Answer) {
    // Phase and shift of the three taps along an axis.
    const TAPS: [(usize, usize); 3] = [(0, 0), (1, 1), (0, 1)];
    let weights = Arc::clone(&network.weights);
    let starts: [usize; 9 * INPUT / 2] = core::array::from_fn(|tap| {
        let ((vertical, down), (horizontal, right)) = (TAPS[tap % 9 / 3], TAPS[tap % 3]);
        let phase = 2 * vertical + horizontal;
        (phase * INPUT / 2 + tap / 9) * PHASES.area + down * PHASES.stride + right
    });
    weights.first.apply(&network.phases, &starts, None, &mut network.first);
    network.few.round(&network.first);
    let starts: [usize; 9 * FIRST / 2] = taps_of_maps(DILATIONS[0]);
    weights.second.apply(&network.few, &starts, None, &mut network.second);
    network.many.round(&network.second);
    let starts: [usize; 9 * SECOND / 2] = taps_of_maps(DILATIONS[1]);
    weights.third.apply(&network.many, &starts, Some(&network.second), &mut network.third);
    network.many.round(&network.third);
    let starts: [usize; 9 * SECOND / 2] = taps_of_maps(DILATIONS[2]);
    weights.fourth.apply(&network.many, &starts, Some(&network.third), &mut network.fourth);
    let mut judged = [0.0_f32; JUDGED];
    let mut profiles = [[[0.0_f32; SIDE]; 2 * SECOND]; 2];
    pool_maps(&network.fourth, &mut profiles, &mut judged);
    let starts: [usize; 3 * SECOND] = core::array::from_fn(|tap| tap / 3 * PROFILES.area + tap % 3);
    for (axis, profiles) in profiles.iter().enumerate() {
        let mut values = [[0.0; SIDE]; PROFILE];
        network.profiles.round(profiles.as_flattened());
        weights.profile.apply(&network.profiles, &starts, None, values.as_flattened_mut());
        let edge = &mut judged[3 * SECOND + axis * EDGE..][..EDGE];
        weights.edge.apply_and_clear_negative(values.as_flattened(), edge);
        weights.answer.apply(edge, &mut answer.axes[axis]);
    }
    judged[3 * SECOND + 2 * EDGE..].copy_from_slice(measurements);
    let mut judge = [0.0_f32; JUDGE];
    weights.judge.apply_and_clear_negative(&judged, &mut judge);
    let mut log_odds = [0.0];
    weights.odds.apply(&judge, &mut log_odds);
    answer.log_odds = log_odds[0];
}

simd_kernel! {
/// Sums up the maps: for each axis maximum and mean over the other one, and mean, maximum and mean of the
/// middle of each map.
fn pool_maps(maps: &[f32], profiles: &mut [[[f32; SIDE]; 2 * SECOND]; 2], judged: &mut [f32; JUDGED]) {
    for (channel, map) in maps.as_chunks::<AREA>().0.iter().enumerate() {
        let (mut sum, mut most, mut middle) = (0.0_f32, 0.0_f32, 0.0_f32);
        for (row, line) in map.as_chunks::<SIDE>().0.iter().enumerate() {
            let (mut row_sum, mut row_most) = (0.0_f32, 0.0_f32);
            for x in 0..SIDE {
                row_sum += line[x];
                row_most = row_most.max(line[x]);
                profiles[0][channel][x] = profiles[0][channel][x].max(line[x]);
                profiles[0][SECOND + channel][x] += line[x] * (1.0 / SIDE as f32);
            }
            profiles[1][channel][row] = row_most;
            profiles[1][SECOND + channel][row] = row_sum * (1.0 / SIDE as f32);
            sum += row_sum;
            most = most.max(row_most);
            if MIDDLE.contains(&row) {
                middle += line[MIDDLE].iter().sum::<f32>();
            }
        }
        judged[channel] = sum / AREA as f32;
        judged[SECOND + channel] = most;
        judged[2 * SECOND + channel] = middle / (MIDDLE.len() * MIDDLE.len()) as f32;
    }
}
}

/// Where the taps of a convolution 3 x 3 begin in maps with a border.
fn taps_of_maps<const TAPS: usize>(dilation: usize) -> [usize; TAPS] {
    core::array::from_fn(|tap| {
        let (down, right) = (tap % 9 / 3 * dilation, tap % 3 * dilation);
        tap / 9 * MAPS.area + MAPS.first + down * MAPS.stride + right - dilation * (MAPS.stride + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::super::weights::LAYERS;
    use super::*;

    /// Bytes of weights that are all zero, but for the biases of the answers.
    fn weights_with_answers(answers: [f32; ANSWERS], log_odds: f32) -> Vec<u8> {
        let mut values = Vec::new();
        for (index, (inputs, outputs)) in LAYERS.into_iter().enumerate() {
            values.extend(core::iter::repeat_n(0.0, inputs * outputs));
            match index {
                6 => values.extend(answers),
                8 => values.push(log_odds),
                _ => values.extend(core::iter::repeat_n(0.0, outputs)),
            }
        }
        values.iter().flat_map(|value: &f32| value.to_le_bytes()).collect()
    }

    #[test]
    fn answers_become_edges_in_pixels() {
        let weights =
            RefinementWeights::from_bytes(&weights_with_answers([0.1, -0.05, 1.5, 9.0], 0.0)).unwrap();
        let mut network = RefinementNetwork::new(Arc::new(weights));
        let mut window = RefinementWindow::default();
        (window.centre, window.sides, window.box_size) = ((200.0, 100.0), (100.0, 50.0), (40.0, 20.0));
        let refined = network.evaluate(&window);
        assert_eq!(refined.probability, 0.5);
        // Shifts of 0.1 and -0.05 times 0.4 sides of the window; in the turned window the same of the other
        // edge.
        for (edge, expected) in refined.edges.into_iter().zip([183.0, 91.5, 217.0, 108.5]) {
            assert!((edge - expected).abs() < 1e-3, "{:?}", refined.edges);
        }
        // The logarithms of the errors are limited to 3 before 1.5 and 9 are averaged.
        for (error, expected) in refined.errors.into_iter().zip([2.117, 2.117, 2.117, 2.117]) {
            assert!((error - expected).abs() < 1e-3, "{:?}", refined.errors);
        }
    }

    #[test]
    fn a_turned_window_has_the_turned_answer() {
        let mut random = 1_u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let mut window = RefinementWindow::default();
        (window.sides, window.box_size) = ((100.0, 50.0), (40.0, 20.0));
        window.cells.iter_mut().for_each(|cell| *cell = next());
        let mut turned = RefinementWindow::default();
        (turned.sides, turned.box_size) = (window.sides, window.box_size);
        turned.cells.copy_from_slice(&window.cells);
        for channel in turned.cells.chunks_exact_mut(WINDOW_SIDE_CELLS * WINDOW_SIDE_CELLS) {
            channel.reverse();
        }
        let mut network = RefinementNetwork::new(RefinementWeights::built_in());
        let (upright, turned) = (network.evaluate(&window), network.evaluate(&turned));
        assert_eq!(upright.probability, turned.probability);
        assert!(upright.probability < 0.9, "{}: one answer alone", upright.probability);
        let [left, top, right, bottom] = turned.edges;
        assert_eq!(upright.edges, [-right, -bottom, -left, -top]);
        let [left, top, right, bottom] = turned.errors;
        assert_eq!(upright.errors, [right, bottom, left, top]);
        assert!(upright.edges[0] != -upright.edges[2], "{:?}", upright.edges);
    }

    /// The places of `fourth`, channel 0, (row, column), that the 7.0 at this cell of channel 2 of the window
    /// reaches. The first convolution reads (row - 1, column + 1) of channel 2, the second the cell itself,
    /// the others these taps of channel 0.
    fn reached(
        cell: (usize, usize),
        third_tap: Option<usize>,
        fourth_tap: Option<usize>,
    ) -> Vec<(usize, usize)> {
        let begin = |layer: usize| LAYERS[..layer].iter().map(|(i, o)| (i + 1) * o).sum::<usize>();
        let mut values = vec![0.0_f32; begin(LAYERS.len())];
        values[2 * 9 + 2] = 1.0;
        values[begin(1) + 4] = 1.0;
        for (layer, tap) in [(2, third_tap), (3, fourth_tap)] {
            if let Some(tap) = tap {
                values[begin(layer) + tap] = 1.0;
            }
        }
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let mut network = RefinementNetwork::new(Arc::new(RefinementWeights::from_bytes(&bytes).unwrap()));
        let mut window = RefinementWindow::default();
        window.cells[(2 * 32 + cell.0) * 32 + cell.1] = 7.0;
        network.answer(&window, Orientation::Upright);
        // The units of weights and inputs are not exact in binary.
        assert!(network.fourth.iter().all(|value| *value == 0.0 || (*value - 7.0).abs() < 1e-5));
        let places = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column)));
        places.filter(|(row, column)| network.fourth[row * SIDE + column] != 0.0).collect()
    }

    #[test]
    fn the_convolutions_read_the_cells_around_theirs() {
        // Row 2 r - 1 = 9 and column 2 c + 1 = 13.
        assert_eq!(reached((9, 13), None, None), [(5, 6)]);
        // Two rows up and two columns right, added to the cell itself.
        assert_eq!(reached((9, 13), Some(2), None), [(5, 6), (7, 4)]);
        // Four rows down and four columns left.
        assert_eq!(reached((9, 13), None, Some(6)), [(1, 10), (5, 6)]);
        assert_eq!(reached((9, 13), Some(2), Some(6)), [(1, 10), (3, 8), (5, 6), (7, 4)]);
        // Beyond the border nothing comes back on the other side.
        assert_eq!(reached((1, 27), Some(2), Some(6)), [(1, 13), (3, 11)]);
    }
}
