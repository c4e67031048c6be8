//! The rows of a frame: shaded in bands as linear light, then developed into samples.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use barrelman_vocab::{Picture, PictureSize};

use super::develop_rows::{SampleBand, develop_two_rows, motion_blur_px};
use super::light_rows::{BAND_ROWS, LightBand, LightRows, padded_width};
use super::parallel::{ParallelFor, get_mut, lock};
use super::sensor::NoiseTable;
use super::shade_row::shade_row;
use super::view::FrameView;

/// Memory for the rows of one picture size.
#[derive(Debug)]
pub(super) struct Frame {
    size: PictureSize,
    noise: NoiseTable,
    light: LightRows,
    samples: Vec<Mutex<SampleBand>>,
    /// For each band, how many bands must still be shaded before the band can be developed.
    missing: Vec<AtomicUsize>,
}

impl Frame {
    pub(super) fn new(size: PictureSize, seed: u64) -> Self {
        let light = LightRows::new(size);
        let bands = light.bands();
        Self {
            size,
            noise: NoiseTable::new(seed),
            light,
            samples: (0..bands).map(|_| Mutex::new(SampleBand::new(size.width as usize))).collect(),
            missing: (0..bands).map(|_| AtomicUsize::new(0)).collect(),
        }
    }

    /// Renders all rows into a picture of this size. The thread that shades the last band that a band needs
    /// also develops that band, while the light is still in the cache.
    pub(super) fn render(&mut self, view: &FrameView<'_>, picture: &mut Picture, parallel: &dyn ParallelFor) {
        let blur = motion_blur_px(view);
        let count = self.light.bands();
        let reach = (libm::ceil(0.5 * libm::fabs(blur.1)) as usize + 1).div_ceil(BAND_ROWS);
        let needed = |band: usize| band.saturating_sub(reach)..(band + reach + 1).min(count);
        for (band, missing) in self.missing.iter_mut().enumerate() {
            *missing.get_mut() = needed(band).len();
        }
        let this = &*self;
        parallel.run(count, &|band| {
            this.light.write_rows(band, &|row, light| shade_row(view, row, light));
            this.light.write_rows(band, &|row, light| this.composite_row(view, row, light));
            for ready in needed(band) {
                if this.missing[ready].fetch_sub(1, Ordering::AcqRel) == 1 {
                    this.develop_band(view, blur, ready);
                }
            }
        });
        self.copy_to_picture(picture);
    }

    /// Shades all rows.
    pub(super) fn shade(&self, view: &FrameView<'_>, parallel: &dyn ParallelFor) {
        parallel.run(self.light.bands(), &|band| {
            self.light.write_rows(band, &|row, light| shade_row(view, row, light));
        });
    }

    /// Composites the objects over the shaded rows.
    pub(super) fn composite(&self, view: &FrameView<'_>, parallel: &dyn ParallelFor) {
        parallel.run(self.light.bands(), &|band| {
            self.light.write_rows(band, &|row, light| self.composite_row(view, row, light));
        });
    }

    /// Develops the rows of light into a picture of this size.
    pub(super) fn develop(
        &mut self,
        view: &FrameView<'_>,
        picture: &mut Picture,
        parallel: &dyn ParallelFor,
    ) {
        let blur = motion_blur_px(view);
        let this = &*self;
        parallel.run(this.samples.len(), &|band| this.develop_band(view, blur, band));
        self.copy_to_picture(picture);
    }

    fn composite_row(&self, view: &FrameView<'_>, row: usize, light: &mut LightBand) {
        let width = self.size.width as usize;
        let padded = padded_width(width);
        let values = &mut light.values[(row % BAND_ROWS) * 3 * padded..][..3 * padded];
        for &index in &view.objects.order {
            view.objects.tiles[index].direct.composite_row(row, width, padded, values);
        }
    }

    fn develop_band(&self, view: &FrameView<'_>, blur: (f64, f64), band: usize) {
        let mut samples = lock(&self.samples[band]);
        for row in self.light.rows_of(band).step_by(2) {
            develop_two_rows(view, (&self.light, &self.noise), blur, row, &mut samples);
        }
    }

    fn copy_to_picture(&mut self, picture: &mut Picture) {
        let [y, u, v] = picture.planes_mut();
        for (band, samples) in self.samples.iter_mut().map(get_mut).enumerate() {
            let copy = |out: &mut [u8], from: &[u8]| {
                let start = (band * from.len()).min(out.len());
                let end = (start + from.len()).min(out.len());
                out[start..end].copy_from_slice(&from[..end - start]);
            };
            copy(y, &samples.y);
            copy(u, &samples.u);
            copy(v, &samples.v);
        }
    }
}
