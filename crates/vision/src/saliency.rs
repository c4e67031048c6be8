//! Places of a picture that stand out from the water around them.
//!
//! The picture is reduced to cells. A cell stands out by how much its brightness and colour differ from those
//! of the ring of cells around it, in standard deviations of that ring: rough water has a large deviation.
//! The ring is wide and flat, as the water's brightness changes with the distance. Colour counts more than
//! brightness, since glare and foam have none.
//!
//! Not handled: an object as large as the ring, the horizon and the shore (they stand out, too).

use barrelman_vocab::{Picture, PixelPoint};

use crate::decimation::decimate;

/// Most places that are returned.
pub const MAX_PLACES: usize = 8;
/// Largest number of cells in a row, and smallest side of a cell, pixels.
const MAX_COLUMNS: usize = 160;
const MIN_CELL_PX: usize = 4;
/// Sides of the cells, in smallest sides: objects are small and large.
const SCALES: [usize; 3] = [1, 2, 4];
/// Half the width and height of the ring, cells, and of what it leaves out.
const OUTER: (usize, usize) = (12, 5);
const INNER: (usize, usize) = (2, 2);
/// Deviation of brightness and of each colour difference that is added to that of the ring, levels.
const FLOORS: [f64; 3] = [5.0, 2.0, 2.0];
/// What brightness and each colour difference may add to the score at most.
const MOST: [f64; 3] = [20.0, 40.0, 40.0];
/// Least score of a place.
const MIN_SCORE: f64 = 18.0;
/// Least distance of two places, cells.
const APART: usize = 3;

/// The sums of one plane's cells above and to the left, and of their squares, with a first row and column of
/// zeros.
#[derive(Debug, Default)]
struct Sums {
    cells: Vec<u8>,
    sums: Vec<(u32, u32)>,
    stride: usize,
}

/// Columns and rows of cells, the ends excluded.
type Window = ((usize, usize), (usize, usize));

impl Sums {
    fn build(&mut self, width: usize, height: usize) {
        self.stride = width + 1;
        self.sums.clear();
        self.sums.resize(self.stride * (height + 1), (0, 0));
        for row in 0..height {
            let (mut sum, mut squares) = (0, 0);
            for column in 0..width {
                let cell = u32::from(self.cells[row * width + column]);
                sum += cell;
                squares += cell * cell;
                let above = self.sums[row * self.stride + column + 1];
                self.sums[(row + 1) * self.stride + column + 1] = (above.0 + sum, above.1 + squares);
            }
        }
    }

    fn of(&self, ((left, right), (top, bottom)): Window) -> (f64, f64) {
        let at = |row: usize, column: usize| self.sums[row * self.stride + column];
        let corners = [at(bottom, right), at(top, left), at(top, right), at(bottom, left)];
        let total = |value: fn((u32, u32)) -> u32| {
            let [plus, plus_too, minus, minus_too] = corners.map(|corner| f64::from(value(corner)));
            plus + plus_too - minus - minus_too
        };
        (total(|(sum, _)| sum), total(|(_, squares)| squares))
    }
}

/// Finds the places that stand out; keeps its buffers.
#[derive(Debug, Default)]
pub struct Saliency {
    planes: [Sums; 3],
    columns: Vec<u16>,
    scores: Vec<f64>,
    peaks: Vec<Peak>,
}

/// A cell that stands out.
#[derive(Debug, Clone, Copy)]
struct Peak {
    score: f64,
    at: PixelPoint,
    cell_px: f64,
}

impl Saliency {
    /// The places of a picture that stand out, the clearest first, at most [`MAX_PLACES`]. Pixels.
    pub fn places(&mut self, picture: &Picture) -> impl Iterator<Item = PixelPoint> + use<> {
        let size = picture.size();
        let smallest = (size.width as usize).div_ceil(MAX_COLUMNS).max(MIN_CELL_PX).next_multiple_of(2);
        self.peaks.clear();
        for cell in SCALES.map(|scale| scale * smallest) {
            self.add_peaks(picture, cell);
        }
        self.peaks.sort_by(|one, other| other.score.total_cmp(&one.score));
        let mut places: [Option<PixelPoint>; MAX_PLACES] = [None; MAX_PLACES];
        let mut count = 0;
        for (index, peak) in self.peaks.iter().enumerate() {
            if count == MAX_PLACES {
                break;
            }
            // A clearer place nearby, of this size or another, stands for this one.
            let is_near = |other: &Peak| {
                let apart = APART as f64 * peak.cell_px.max(other.cell_px);
                (peak.at.u - other.at.u).abs() < apart && (peak.at.v - other.at.v).abs() < apart
            };
            if !self.peaks[..index].iter().any(is_near) {
                places[count] = Some(peak.at);
                count += 1;
            }
        }
        places.into_iter().flatten()
    }

    /// Adds the cells of this side that stand out.
    fn add_peaks(&mut self, picture: &Picture, cell: usize) {
        let size = picture.size();
        let (width, height) = (size.width as usize / cell, size.height as usize / cell);
        self.measure(picture, cell, (width, height));
        let middle = |cells: usize| (cells * cell) as f64 + 0.5 * cell as f64;
        for (index, score) in self.scores.iter().enumerate().filter(|(_, score)| **score >= MIN_SCORE) {
            let at = PixelPoint { u: middle(index % width), v: middle(index / width) };
            self.peaks.push(Peak { score: *score, at, cell_px: cell as f64 });
        }
    }

    /// Computes the scores of all cells.
    fn measure(&mut self, picture: &Picture, cell: usize, (width, height): (usize, usize)) {
        self.scores.clear();
        if width == 0 || height == 0 {
            return;
        }
        let planes = [(picture.y(), cell), (picture.u(), cell / 2), (picture.v(), cell / 2)];
        for (sums, (plane, side)) in self.planes.iter_mut().zip(planes) {
            decimate(plane, (0, 0), side as i32, (width, height), &mut self.columns, &mut sums.cells);
            sums.build(width, height);
        }
        let around = |middle: usize, reach: usize, end: usize| {
            (middle.saturating_sub(reach), (middle + reach + 1).min(end))
        };
        let count = |((left, right), (top, bottom)): Window| ((right - left) * (bottom - top)) as f64;
        for row in 0..height {
            for column in 0..width {
                let window = |(across, down)| (around(column, across, width), around(row, down, height));
                let (outer, inner) = (window(OUTER), window(INNER));
                let cells = count(outer) - count(inner);
                let mut score = 0.0;
                for ((sums, floor), most) in self.planes.iter().zip(FLOORS).zip(MOST) {
                    let ((sum, squares), (within, squares_within)) = (sums.of(outer), sums.of(inner));
                    let mean = (sum - within) / cells.max(1.0);
                    let variance = ((squares - squares_within) / cells.max(1.0) - mean * mean).max(0.0);
                    let off = f64::from(sums.cells[row * width + column]) - mean;
                    score += (off * off / (variance + floor * floor)).min(most);
                }
                self.scores.push(if cells > 0.0 { score } else { 0.0 });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::painted;

    const SIZE: (u32, u32) = (640, 360);

    /// Water with waves, and objects (left, top, width, height) of one colour.
    fn picture(objects: &[([usize; 4], [u8; 3])]) -> Picture {
        painted(SIZE, |column, row| {
            let is_inside = |[left, top, w, h]: [usize; 4]| {
                (left..left + w).contains(&column) && (top..top + h).contains(&row)
            };
            match objects.iter().find(|(place, _)| is_inside(*place)) {
                Some((_, colour)) => *colour,
                None => {
                    let wave = libm::sin(column as f64 * 0.31 + libm::sin(row as f64 * 0.17) * 2.0);
                    [(90.0 + 8.0 * wave) as u8, 150, 112]
                }
            }
        })
    }

    #[test]
    fn objects_stand_out_and_waves_do_not() {
        let objects = [
            ([300, 160, 40, 20], [80, 90, 220]),
            ([60, 60, 12, 10], [210, 128, 128]),
            ([500, 300, 16, 12], [90, 90, 190]),
        ];
        let mut saliency = Saliency::default();
        let places: Vec<PixelPoint> = saliency.places(&picture(&objects)).collect();
        for ([left, top, w, h], _) in objects {
            let is_at = |place: &PixelPoint| {
                let near = |at: f64, from: usize, length: usize| {
                    at > from as f64 - 4.0 && at < (from + length) as f64 + 4.0
                };
                near(place.u, left, w) && near(place.v, top, h)
            };
            assert!(places.iter().any(is_at), "{left} {top}: {places:?}");
        }
        assert_eq!(saliency.places(&picture(&[])).count(), 0);
    }

    #[test]
    fn pictures_of_any_size_have_places_or_none() {
        let mut saliency = Saliency::default();
        for size in [(0, 0), (1, 1), (2, 2), (3, 9), (40, 1), (33, 31), (1_300, 20)] {
            let picture = painted(size, |column, row| [(31 * column + 17 * row) as u8, 128, 128]);
            assert!(saliency.places(&picture).count() <= MAX_PLACES, "{size:?}");
        }
    }
}
