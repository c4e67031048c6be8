//! A crop of the picture at the coarsest resolution that the target's size allows, computed once per search
//! window.
//!
//! The luma plane is averaged over cells of k x k pixels (k whole, integer arithmetic), the chroma planes
//! over cells of the size of two crop samples of luma. The colour model turns each chroma sample with its
//! luma into a *target probability*: the probability that the colour belongs to the target. Later stages
//! sample patches of any position, size and rotation from these two maps and never from the picture. Outside
//! the picture the border samples are replicated; the feature extractor blanks the cells there.

use barrelman_vocab::Picture;

use crate::colour_model::ColourModel;
use crate::decimation::decimate;
use crate::explanation::GreyMap;
use crate::probability_view::{ColourContrast, ProbabilityView};
use crate::sampling::{SampleMap, SampleRow, SamplingGrid, sample_bilinear};

/// Maximum decimation, pixels per luma sample.
const MAX_DECIMATION: i32 = 64;

/// The decimated maps of one search window.
#[derive(Debug, Default)]
pub(crate) struct Crop {
    /// Left and top edge, pixels of the picture: even multiples of `decimation`.
    left: i32,
    top: i32,
    /// Pixels of the picture per luma sample.
    decimation: i32,
    luma: SampleMap,
    /// Target probability, 0 to 255, at half the resolution of `luma`.
    probability: SampleMap,
    chroma: [Vec<u8>; 2],
    columns: Vec<u16>,
    row: SampleRow,
    /// Size of the picture, pixels.
    picture: (i32, i32),
}

/// A copy of a crop's brightness.
#[derive(Debug, Clone, Default)]
pub(crate) struct CropLuma {
    pub(crate) map: SampleMap,
    /// Left and top edge, pixels of the picture.
    origin: (f32, f32),
    /// Pixels of the picture per sample; 0 before the first copy.
    pub(crate) decimation: f32,
}

impl CropLuma {
    /// A grid placed on the picture, in samples of the map.
    pub(crate) fn to_samples(&self, grid: &SamplingGrid) -> SamplingGrid {
        grid.on_map(self.origin, 1.0 / self.decimation)
    }

    /// Becomes a copy of another, in the buffers that are there.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.map.copy_from(&other.map);
        (self.origin, self.decimation) = (other.origin, other.decimation);
    }

    /// Whether a point, in samples, lies in the map.
    pub(crate) fn contains(&self, (x, y): (f32, f32)) -> bool {
        x >= 0.0 && y >= 0.0 && x <= self.map.width as f32 && y <= self.map.height as f32
    }
}

impl Crop {
    /// Extracts the part of the picture within `reach` pixels of `centre` along each axis. Each luma sample
    /// covers at most `step` pixels a side.
    pub(crate) fn extract(
        &mut self,
        picture: &Picture,
        model: &ColourModel,
        centre: (f32, f32),
        reach: f32,
        step: f32,
    ) {
        // A cast turns NaN into 0.
        let k = (step as i32).clamp(1, MAX_DECIMATION);
        let unit = 2 * k;
        let size = picture.size();
        self.picture = (size.width as i32, size.height as i32);
        let side = |middle: f32, length: i32| {
            let from = ((middle - reach) as i32).clamp(0, (length - 1).max(0)) / unit * unit;
            let to = ((middle + reach) as i32).clamp(from, length);
            (from, ((to - from + unit - 1) / unit + 1) as usize)
        };
        let ((left, across), (top, down)) = (side(centre.0, self.picture.0), side(centre.1, self.picture.1));
        (self.left, self.top, self.decimation) = (left, top, k);
        let luma_size = (2 * across, 2 * down);
        decimate(picture.y(), (left, top), k, luma_size, &mut self.columns, &mut self.luma.values);
        (self.luma.width, self.luma.height) = luma_size;
        let [u, v] = &mut self.chroma;
        decimate(picture.u(), (left / 2, top / 2), k, (across, down), &mut self.columns, u);
        decimate(picture.v(), (left / 2, top / 2), k, (across, down), &mut self.columns, v);
        (self.probability.width, self.probability.height) = (across, down);
        self.look_up_probabilities(model);
        self.luma.pack();
        self.probability.pack();
    }

    /// Fills the probability map from the decimated planes.
    fn look_up_probabilities(&mut self, model: &ColourModel) {
        let (across, down) = (self.probability.width, self.probability.height);
        let [u, v] = &self.chroma;
        let table = model.table();
        self.probability.values.clear();
        for row in 0..down {
            let upper = &self.luma.values[4 * row * across..][..2 * across];
            let lower = &self.luma.values[(4 * row + 2) * across..][..2 * across];
            let (us, vs) = (&u[row * across..][..across], &v[row * across..][..across]);
            let pairs = upper.chunks_exact(2).zip(lower.chunks_exact(2)).zip(us.iter().zip(vs));
            self.probability.values.extend(pairs.map(|((a, b), (&u, &v))| {
                let y = (u16::from(a[0]) + u16::from(a[1]) + u16::from(b[0]) + u16::from(b[1])) / 4;
                table.probability(y as u8, u, v)
            }));
        }
    }

    /// Copies the brightness.
    pub(crate) fn copy_luma(&self, out: &mut CropLuma) {
        out.map.copy_from(&self.luma);
        out.origin = (self.left as f32, self.top as f32);
        out.decimation = self.decimation as f32;
    }

    /// Samples the luma on a grid placed on the picture, 0 to 255.
    pub(crate) fn sample_luma(&mut self, grid: &SamplingGrid, out: &mut Vec<f32>) {
        let scale = 1.0 / self.decimation as f32;
        let grid = self.to_map_grid(grid, scale);
        sample_bilinear(&self.luma, grid, &mut self.row, out);
    }

    /// Samples the target probability on a grid placed on the picture, 0 to 255.
    pub(crate) fn sample_probability(&mut self, grid: &SamplingGrid, out: &mut Vec<f32>) {
        let scale = 0.5 / self.decimation as f32;
        let grid = self.to_map_grid(grid, scale);
        sample_bilinear(&self.probability, grid, &mut self.row, out);
    }

    /// The chroma nearest to the points of a grid placed on the picture, which is not rotated: U and V, 0 to
    /// 255.
    pub(crate) fn sample_chroma(&self, grid: &SamplingGrid, out: &mut [Vec<f32>; 2]) {
        let grid = self.to_map_grid(grid, 0.5 / self.decimation as f32);
        let (width, height) = (self.probability.width, self.probability.height);
        let ([u_out, v_out], [u, v]) = (out, &self.chroma);
        u_out.clear();
        v_out.clear();
        for row in 0..grid.height {
            // A cast turns negative numbers into 0.
            let first = (grid.sample_centre(0, row).1 as usize).min(height - 1) * width;
            for column in 0..grid.width {
                let index = first + (grid.sample_centre(column, row).0 as usize).min(width - 1);
                u_out.push(f32::from(u[index]));
                v_out.push(f32::from(v[index]));
            }
        }
    }

    /// U and V of the samples of the probability map, row by row.
    pub(crate) fn chroma(&self) -> [&[u8]; 2] {
        self.chroma.each_ref().map(Vec::as_slice)
    }

    /// The target probabilities, with their place in the picture.
    pub(crate) fn probabilities(&self) -> ProbabilityView<'_> {
        // 1 before the first extraction, when there are no samples.
        let unit = (2 * self.decimation).max(1);
        let samples_in_picture =
            |from: i32, length: usize, whole: i32| length.min(((whole - from).max(0) / unit) as usize);
        ProbabilityView {
            values: &self.probability.values,
            width: self.probability.width,
            height: self.probability.height,
            size_in_picture: (
                samples_in_picture(self.left, self.probability.width, self.picture.0),
                samples_in_picture(self.top, self.probability.height, self.picture.1),
            ),
            left: self.left as f32,
            top: self.top as f32,
            unit: self.probability_step(),
        }
    }

    /// Number of samples of the probability map for which there is room.
    pub(crate) fn sample_capacity(&self) -> usize {
        self.probability.values.capacity()
    }

    /// Side of the square covered by one sample of the probability map, pixels.
    pub(crate) fn probability_step(&self) -> f32 {
        (2 * self.decimation) as f32
    }

    /// Calls `visit` for each sample of the probability map inside an ellipse and inside the picture, with
    /// the distance right and down of the centre (pixels) and the target probability (0 to 255). The ellipse
    /// has the half axes `half` (pixels) around `centre`; `angle` turns it clockwise, radians.
    pub(crate) fn for_each_probability(
        &self,
        centre: (f32, f32),
        half: (f32, f32),
        angle: f32,
        mut visit: impl FnMut(f32, f32, u8),
    ) {
        let map = self.probabilities();
        map.for_each_in_ellipse(centre, half, angle, |du, dv, index| visit(du, dv, map.values[index]));
    }

    /// The same with the chroma of each sample: U and V, 0 to 255.
    pub(crate) fn for_each_chroma(
        &self,
        centre: (f32, f32),
        half: (f32, f32),
        angle: f32,
        mut visit: impl FnMut(f32, f32, u8, u8),
    ) {
        let [u, v] = &self.chroma;
        let map = self.probabilities();
        map.for_each_in_ellipse(centre, half, angle, |du, dv, index| visit(du, dv, u[index], v[index]));
    }

    /// Mean target probability inside an ellipse (see [`Self::for_each_probability`]) and in the ring around
    /// it.
    pub(crate) fn contrast(&self, centre: (f32, f32), half: (f32, f32), angle: f32) -> ColourContrast {
        self.probabilities().contrast(centre, half, angle)
    }

    /// Writes the probability map for an overlay.
    pub(crate) fn write_probability_map(&self, out: &mut GreyMap) {
        let map = self.probabilities();
        (out.width, out.height) = (map.width, map.height);
        out.bounds = map.bounds();
        out.samples.extend_from_slice(map.values);
    }

    /// A grid placed on the picture, in samples of a map of `scale` samples per pixel.
    fn to_map_grid(&self, grid: &SamplingGrid, scale: f32) -> SamplingGrid {
        grid.on_map((self.left as f32, self.top as f32), scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::picture;

    fn patch(picture: &Picture, centre: (f32, f32), step: f32, angle: f32) -> Vec<f32> {
        let mut crop = Crop::default();
        crop.extract(picture, &ColourModel::default(), centre, 16.0 * step, step);
        let turn = (libm::cosf(angle), libm::sinf(angle));
        let mut out = Vec::new();
        crop.sample_luma(&SamplingGrid { centre, step, stretch: 1.0, turn, width: 16, height: 12 }, &mut out);
        out
    }

    #[test]
    fn a_patch_of_a_picture_of_one_brightness_is_of_that_brightness_everywhere() {
        let picture = picture((97, 61), |_, _| 93.0);
        for centre in [(48.0, 30.0), (0.0, 0.0), (97.0, 61.0), (96.3, 2.2), (-500.0, 900.0)] {
            for step in [0.3, 1.0, 2.7, 5.0, 9.5, 80.0] {
                for angle in [0.0, 0.6, 3.0] {
                    let patch = patch(&picture, centre, step, angle);
                    assert_eq!(patch.len(), 16 * 12);
                    assert!(patch.iter().all(|&sample| sample == 93.0), "{centre:?} {step} {angle}");
                }
            }
        }
    }

    #[test]
    fn a_turned_patch_of_a_ramp_is_a_turned_ramp() {
        // One grey level per pixel to the right: the brightness gives the position.
        let picture = picture((240, 160), |column, _| column as f32);
        let centre = (118.0, 80.0);
        for step in [1.0, 1.6, 2.0, 3.5] {
            for angle_deg in [0.0_f32, 30.0, 90.0, 180.0, -45.0] {
                let angle = angle_deg.to_radians();
                let patch = patch(&picture, centre, step, angle);
                for (index, &sample) in patch.iter().enumerate() {
                    let (right, down) = ((index % 16) as f32 - 7.5, (index / 16) as f32 - 5.5);
                    let u = centre.0 + step * (right * libm::cosf(angle) - down * libm::sinf(angle));
                    // Pixel `n` covers n to n + 1; positions are rounded to 1/256 sample, means to whole
                    // numbers.
                    let expected = u - 0.5;
                    assert!(
                        (sample - expected).abs() < 0.6,
                        "{step} {angle_deg} {index}: {sample}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_picture_of_no_pixels_gives_black() {
        let picture = picture((0, 0), |_, _| 0.0);
        assert!(patch(&picture, (3.0, 3.0), 1.0, 0.0).iter().all(|&sample| sample == 0.0));
    }

    #[test]
    fn probabilities_are_visited_within_the_ellipse_and_the_picture_only() {
        let picture = picture((64, 48), |_, _| 90.0);
        let mut crop = Crop::default();
        for (centre, half, share) in [
            ((32.0, 24.0), (20.0, 12.0), 1.0),
            ((0.0, 24.0), (20.0, 12.0), 0.5),
            ((64.0, 48.0), (20.0, 12.0), 0.25),
        ] {
            crop.extract(&picture, &ColourModel::default(), centre, 40.0, 1.0);
            let mut area = 0.0;
            crop.for_each_probability(centre, half, 0.0, |du, dv, _| {
                assert!((0.0..=64.0).contains(&(centre.0 + du)) && (0.0..=48.0).contains(&(centre.1 + dv)));
                assert!(libm::hypotf(du / half.0, dv / half.1) <= 1.0);
                area += crop.probability_step() * crop.probability_step();
            });
            let expected = share * core::f32::consts::PI * half.0 * half.1;
            assert!((area / expected - 1.0).abs() < 0.05, "{centre:?}: {area}, not {expected}");
        }
    }
}
