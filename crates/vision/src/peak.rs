//! The peaks of a response, how far they stand out from the sidelobes, and the peak that is desired.

use crate::fourier::{AREA, Fourier, Map, SIDE, Spectrum};

/// The maximum of a response.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Peak {
    /// Cells to the right of the centre, interpolated by a parabola.
    pub(crate) right: f32,
    /// Cells below the centre.
    pub(crate) down: f32,
    /// Value of the response at the maximum: about 1 for the learned patch.
    pub(crate) height: f32,
    /// Peak-to-sidelobe ratio (Bolme et al. 2010): height above the mean of the sidelobes, in their standard
    /// deviations.
    pub(crate) peak_to_sidelobe_ratio: f32,
}

/// Half side of the square around the peak that is not part of the sidelobes, cells.
const PEAK_RADIUS_CELLS: usize = 3;

impl Peak {
    /// Finds the maximum of a response whose shift zero is at index 0.
    pub(crate) fn find(response: &Map) -> Self {
        let mut best = 0;
        for (i, &value) in response.iter().enumerate() {
            if value > response[best] {
                best = i;
            }
        }
        let (row, column) = (best / SIDE, best % SIDE);
        let height = response[best];
        let (mut sum, mut squares, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
        for (i, &value) in response.iter().enumerate() {
            let (r, c) = (i / SIDE, i % SIDE);
            if is_beside_peak((r, c), (row, column)) {
                sum += value;
                squares += value * value;
                count += 1.0;
            }
        }
        let mean = sum / count;
        let std_dev = (squares / count - mean * mean).max(0.0).sqrt();
        let peak_to_sidelobe_ratio = if std_dev > 0.0 { (height - mean) / std_dev } else { 0.0 };
        let (right, down) = interpolated_shift(response, row, column);
        Self { right, down, height, peak_to_sidelobe_ratio }
    }

    /// The highest other local maximum that is not part of this peak; `None` where there is none above zero.
    /// Its peak-to-sidelobe ratio refers to the sidelobes of this peak.
    pub(crate) fn find_second(&self, response: &Map) -> Option<Self> {
        // Rounded cells of the peak: a cast after the remainder is lossless.
        let cell = |shift: f32| (libm::roundf(shift) as i32).rem_euclid(SIDE as i32) as usize;
        let peak = (cell(self.down), cell(self.right));
        self.find_maximum(response, |r, c| is_beside_peak((r, c), peak))
    }

    /// The highest local maximum at which `is_allowed`, by its shift right and down in cells; `None` where
    /// there is none above zero. Its peak-to-sidelobe ratio refers to the sidelobes of this peak.
    pub(crate) fn find_other(&self, response: &Map, is_allowed: impl Fn(f32, f32) -> bool) -> Option<Self> {
        self.find_maximum(response, |r, c| is_allowed(signed_shift(c), signed_shift(r)))
    }

    /// The highest local maximum at an allowed row and column.
    fn find_maximum(&self, response: &Map, is_allowed: impl Fn(usize, usize) -> bool) -> Option<Self> {
        let is_maximum = |r: usize, c: usize| {
            let here = cyclic(response, r, c);
            [(r, c + 1), (r, c + SIDE - 1), (r + 1, c), (r + SIDE - 1, c)]
                .into_iter()
                .all(|(r, c)| here >= cyclic(response, r, c))
        };
        let mut best: Option<(usize, usize)> = None;
        let mut height = 0.0;
        for (index, &value) in response.iter().enumerate() {
            let (r, c) = (index / SIDE, index % SIDE);
            if value > height && is_maximum(r, c) && is_allowed(r, c) {
                (best, height) = (Some((r, c)), value);
            }
        }
        let (r, c) = best.filter(|_| self.height > 0.0)?;
        let (right, down) = interpolated_shift(response, r, c);
        Some(Self {
            right,
            down,
            height,
            peak_to_sidelobe_ratio: self.peak_to_sidelobe_ratio * height / self.height,
        })
    }
}

/// The value at a row and column, which wrap around.
fn cyclic(response: &Map, row: usize, column: usize) -> f32 {
    response[(row % SIDE) * SIDE + column % SIDE]
}

/// Whether a cell (row, column) lies outside the square around a peak's cell.
fn is_beside_peak((r, c): (usize, usize), (row, column): (usize, usize)) -> bool {
    circular_distance(r, row) > PEAK_RADIUS_CELLS || circular_distance(c, column) > PEAK_RADIUS_CELLS
}

/// Shift right and down of a maximum, interpolated by parabolas, cells.
fn interpolated_shift(response: &Map, row: usize, column: usize) -> (f32, f32) {
    let at = |r: usize, c: usize| cyclic(response, r, c);
    let height = at(row, column);
    (
        signed_shift(column) + parabola_vertex(at(row, column + SIDE - 1), height, at(row, column + 1)),
        signed_shift(row) + parabola_vertex(at(row + SIDE - 1, column), height, at(row + 1, column)),
    )
}

/// Abscissa of the maximum of the parabola through three values at -1, 0 and 1; limited to -1/2 to 1/2, 0 if
/// convex.
pub(crate) fn parabola_vertex(before: f32, here: f32, after: f32) -> f32 {
    let curvature = before - 2.0 * here + after;
    if curvature < 0.0 { (0.5 * (before - after) / curvature).clamp(-0.5, 0.5) } else { 0.0 }
}

/// Spectrum of the desired response: a Gaussian of this standard deviation at shift zero.
pub(crate) fn desired_response_spectrum(fourier: &mut Fourier, std_dev_cells: f32) -> Spectrum {
    let mut map: Box<Map> = Box::new([0.0; AREA]);
    for (i, value) in map.iter_mut().enumerate() {
        let (r, c) = (signed_shift(i / SIDE), signed_shift(i % SIDE));
        *value = libm::expf(-0.5 * (r * r + c * c) / (std_dev_cells * std_dev_cells));
    }
    let (mut spectrum, mut other) = (Spectrum::default(), Spectrum::default());
    fourier.forward_pair((&map, &map), (&mut spectrum, &mut other));
    spectrum
}

/// The shift of a row or column of a response: the second half is negative.
fn signed_shift(index: usize) -> f32 {
    if index < SIDE / 2 { index as f32 } else { index as f32 - SIDE as f32 }
}

fn circular_distance(a: usize, b: usize) -> usize {
    let d = a.abs_diff(b);
    d.min(SIDE - d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_peak_is_another_maximum() {
        let mut response: Box<Map> = Box::new([0.0; AREA]);
        let mut add = |row: usize, column: usize, height: f32| {
            for (r, c, share) in
                [(0, 0, 1.0), (0, 1, 0.5), (1, 0, 0.5), (0, SIDE - 1, 0.5), (SIDE - 1, 0, 0.5)]
            {
                response[(row + r) % SIDE * SIDE + (column + c) % SIDE] = share * height;
            }
        };
        add(0, 2, 1.0);
        add(0, 5, 0.9);
        add(SIDE - 6, 3, 0.6);
        let first = Peak::find(&response);
        assert_eq!((first.right, first.down, first.height), (2.0, 0.0, 1.0));
        // The one three cells away is part of the first.
        let second = first.find_second(&response).unwrap();
        assert_eq!((second.right, second.down, second.height), (3.0, -6.0, 0.6));
        assert!((second.peak_to_sidelobe_ratio / first.peak_to_sidelobe_ratio - 0.6).abs() < 1e-6);
        assert_eq!(first.find_second(&[0.0; AREA]), None);
    }

    #[test]
    fn the_peak_lies_between_cells_where_its_neighbours_differ() {
        let mut map: Box<Map> = Box::new([0.0; AREA]);
        for (index, value) in map.iter_mut().enumerate() {
            let (down, right) = (signed_shift(index / SIDE) + 2.3, signed_shift(index % SIDE) - 4.4);
            *value = libm::expf(-0.5 * (right * right + down * down) / 4.0);
        }
        let peak = Peak::find(&map);
        // A parabola fitted to a Gaussian of two cells is off by a few hundredths.
        assert!((peak.right - 4.4).abs() < 0.05 && (peak.down + 2.3).abs() < 0.05, "{peak:?}");
    }

    #[test]
    fn a_flat_response_has_a_peak_that_stands_out_by_nothing() {
        for level in [0.0, 0.5] {
            assert_eq!(Peak::find(&[level; AREA]).peak_to_sidelobe_ratio, 0.0);
        }
    }
}
