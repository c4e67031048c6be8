//! What a patch of the search window looks like: the channels that the correlation filter works on.
//!
//! Nine directions of gradients, the brightness, and the likeness of the colour, in cells of [`CELL`] x [`CELL`]
//! samples. Cells beyond the picture's border hold nothing.

use crate::correlation::CorrelationFilter;
use crate::crop::{Crop, Grid};
use crate::fourier::{AREA, Fourier, Map, SIDE, Spectrum, hann_window};
use crate::gradients::{CELL, DIRECTIONS, Gradients, MARGIN, directions};

/// Channels, an even number.
pub(crate) const CHANNELS: usize = DIRECTIONS + 3;
/// Which channel holds the brightness.
const LUMA: usize = DIRECTIONS;
/// Which channel holds the likeness of the colour.
const LIKENESS: usize = DIRECTIONS + 1;

/// Where and how a patch is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// Its middle, pixels.
    pub(crate) centre: (f32, f32),
    /// Pixels per sample.
    pub(crate) step: f32,
    /// Angle by which it is turned, radians, clockwise as seen.
    pub(crate) angle: f32,
}

impl Place {
    pub(crate) fn grid(&self, width: usize, height: usize) -> Grid {
        Grid {
            centre: self.centre,
            step: self.step,
            turn: (libm::cosf(self.angle), libm::sinf(self.angle)),
            width,
            height,
        }
    }
    /// Side of the whole patch around it, pixels.
    pub(crate) fn side(&self) -> f32 {
        self.step * (SIDE * CELL) as f32
    }

    /// A point given in samples right and down of the middle, as pixels.
    pub(crate) fn point(&self, right: f32, down: f32) -> (f32, f32) {
        let (c, s) = (libm::cosf(self.angle), libm::sinf(self.angle));
        (
            self.centre.0 + self.step * (right * c - down * s),
            self.centre.1 + self.step * (right * s + down * c),
        )
    }
}

#[derive(Debug)]
pub(crate) struct Features {
    luma: Vec<f32>,
    likeness: Vec<f32>,
    gradients: Gradients,
    directions: ([(f32, f32); DIRECTIONS], f32),
    window: Box<Map>,
    /// Channel by channel, as measured.
    raw: Vec<f32>,
    maps: Vec<Box<Map>>,
    /// Of the last whole patch.
    pub(crate) spectra: Vec<Spectrum>,
    pub(crate) fourier: Fourier,
    luma_gain: f32,
    colour_gain: f32,
    /// What to take off the brightness and the likeness, and by what to multiply, from the last whole patch.
    affine: [(f32, f32); 2],
}

impl Features {
    pub(crate) fn new(luma_gain: f32, colour_gain: f32) -> Self {
        Self {
            luma: Vec::new(),
            likeness: Vec::new(),
            gradients: Gradients::default(),
            directions: directions(),
            window: hann_window(),
            raw: Vec::new(),
            maps: vec![Box::new([0.0; AREA]); CHANNELS],
            spectra: vec![Spectrum::default(); CHANNELS],
            fourier: Fourier::new(),
            luma_gain,
            colour_gain,
            affine: [(0.0, 0.0); 2],
        }
    }

    /// Fills `raw` with `width * height` cells around the place.
    fn cells(&mut self, crop: &mut Crop, place: &Place, width: usize, height: usize) {
        let grid = place.grid(width * CELL + 2 * MARGIN, height * CELL + 2 * MARGIN);
        let stride = grid.width;
        crop.luma_patch(&grid, &mut self.luma);
        self.gradients.measure(&self.luma, width, height, &self.directions.0, self.directions.1);
        let half = Grid { step: 2.0 * grid.step, width: width * CELL / 2, height: height * CELL / 2, ..grid };
        crop.likeness_patch(&half, &mut self.likeness);
        let area = width * height;
        self.raw.clear();
        self.raw.extend_from_slice(self.gradients.cells());
        self.raw.resize(CHANNELS * area, 0.0);
        for row in 0..height {
            for column in 0..width {
                let corner = (row * CELL + MARGIN) * stride + column * CELL + MARGIN;
                let mut sum = 0.0;
                for r in 0..CELL {
                    let line = &self.luma[corner + r * stride..][..CELL];
                    sum += line[0] + line[1] + line[2] + line[3];
                }
                let k = 2 * row * half.width + 2 * column;
                let likeness = self.likeness[k]
                    + self.likeness[k + 1]
                    + self.likeness[k + half.width]
                    + self.likeness[k + half.width + 1];
                self.raw[LUMA * area + row * width + column] = sum * (1.0 / 16.0);
                self.raw[LIKENESS * area + row * width + column] = likeness * (0.25 / 255.0);
            }
        }
    }

    /// The spectra of the whole patch at that place.
    pub(crate) fn measure(&mut self, crop: &mut Crop, place: &Place, bounds: (f32, f32)) {
        self.cells(crop, place, SIDE, SIDE);
        let luma = &self.raw[LUMA * AREA..(LUMA + 1) * AREA];
        let mean_luma = luma.iter().sum::<f32>() / AREA as f32;
        let mean_likeness =
            self.raw[LIKENESS * AREA..(LIKENESS + 1) * AREA].iter().sum::<f32>() / AREA as f32;
        let variance = luma.iter().map(|v| (v - mean_luma) * (v - mean_luma)).sum::<f32>() / AREA as f32;
        self.affine =
            [(mean_luma, 0.3 * self.luma_gain / (variance.sqrt() + 8.0)), (mean_likeness, self.colour_gain)];
        self.blank_outside(place, SIDE, SIDE, bounds);
        for (channel, (map, raw)) in self.maps.iter_mut().zip(self.raw.chunks_exact(AREA)).enumerate() {
            let (offset, gain) = affine(&self.affine, channel);
            for ((value, window), raw) in map.iter_mut().zip(self.window.iter()).zip(raw) {
                *value = (raw - offset) * gain * window;
            }
        }
        for pair in 0..CHANNELS / 2 {
            let (first, second) = self.spectra.split_at_mut(2 * pair + 1);
            let maps = (&*self.maps[2 * pair], &*self.maps[2 * pair + 1]);
            self.fourier.forward_pair(maps, (&mut first[2 * pair], &mut second[0]));
        }
    }

    /// Cells beyond the picture's border are made to hold nothing.
    fn blank_outside(&mut self, place: &Place, width: usize, height: usize, bounds: (f32, f32)) {
        let half = (0.5 * (width * CELL) as f32, 0.5 * (height * CELL) as f32);
        let inside = |p: (f32, f32)| p.0 >= 0.0 && p.1 >= 0.0 && p.0 <= bounds.0 && p.1 <= bounds.1;
        let corners = [(-half.0, -half.1), (half.0, -half.1), (-half.0, half.1), (half.0, half.1)];
        if corners.iter().all(|c| inside(place.point(c.0, c.1))) {
            return;
        }
        let area = width * height;
        for row in 0..height {
            for column in 0..width {
                let (right, down) =
                    ((column as f32 + 0.5) * CELL as f32 - half.0, (row as f32 + 0.5) * CELL as f32 - half.1);
                if !inside(place.point(right, down)) {
                    for channel in 0..CHANNELS {
                        self.raw[channel * area + row * width + column] = affine(&self.affine, channel).0;
                    }
                }
            }
        }
    }

    /// The response at no shift of a filter to what lies at that place: what [`Self::measure`] and an inverse
    /// transform would give there, worked out for that one place only. `reach` is how many cells right and down of
    /// the middle count.
    pub(crate) fn score(
        &mut self,
        crop: &mut Crop,
        place: &Place,
        filter: &CorrelationFilter,
        reach: (usize, usize),
        bounds: (f32, f32),
    ) -> f32 {
        let kernel = filter.kernel();
        let (nw, nh) = (reach.0.clamp(1, SIDE / 2), reach.1.clamp(1, SIDE / 2));
        let (width, height) = (2 * nw, 2 * nh);
        self.cells(crop, place, width, height);
        self.blank_outside(place, width, height, bounds);
        let mut sums = [0.0_f32; CHANNELS];
        let area = width * height;
        for (channel, total) in sums.iter_mut().enumerate() {
            let (offset, gain) = affine(&self.affine, channel);
            for row in 0..height {
                let start = (SIDE / 2 - nh + row) * SIDE + SIDE / 2 - nw;
                let raw = &self.raw[channel * area + row * width..][..width];
                let mut sum = 0.0;
                for ((x, h), w) in raw
                    .iter()
                    .zip(&kernel[channel * AREA + start..][..width])
                    .zip(&self.window[start..start + width])
                {
                    sum += (x - offset) * w * h;
                }
                *total += sum * gain;
            }
        }
        sums.iter().sum()
    }
}

fn affine(affine: &[(f32, f32); 2], channel: usize) -> (f32, f32) {
    match channel.checked_sub(LUMA) {
        None => (0.0, 1.0),
        Some(k) => affine.get(k).copied().unwrap_or((0.0, 0.0)),
    }
}
