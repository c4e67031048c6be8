//! Shift of the picture since the last frame, measured by registration of the background: for video without
//! camera commands.
//!
//! A patch around the target, with the target itself blanked out, is compared with the same place in the next
//! frame by phase correlation (Kuglin and Hines 1975). With the patches' spectra F and G, the inverse
//! transform of conj(F) G / |F G|^(1/2) peaks at the shift. The exponent is 1/2 instead of 1 because weak
//! components are mostly noise. The water has a motion of its own, so the shift is one input of the
//! prediction among others.

use barrelman_vocab::PixelPoint;
use barrelman_vocab::video::Plane;

use crate::decimation::decimate;
use crate::fourier::{AREA, Fourier, Map, SIDE, Spectrum, hann_window};
use crate::peak::Peak;
use crate::tracker::BackgroundShift;

/// Registers patches of the target's surroundings.
#[derive(Debug, Clone)]
pub(crate) struct BackgroundMotion {
    reference: Spectrum,
    current: Spectrum,
    work: Spectrum,
    reference_patch: Option<Patch>,
    /// The last measured shift.
    measured: Option<BackgroundShift>,
    samples: Vec<u8>,
    columns: Vec<u16>,
    map: Box<Map>,
    response: Box<Map>,
    window: Box<Map>,
}

/// A square of the picture on whole pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Patch {
    left: i32,
    top: i32,
    /// Pixels per sample.
    decimation: i32,
    /// Half side of the square around the centre that is blanked out, pixels.
    blank_px: f32,
}

/// Minimum peak-to-sidelobe ratio of a valid shift.
const MIN_PEAK_TO_SIDELOBE_RATIO: f32 = 11.0;
/// Side of the patch, in sides of the blanked square, ...
const PATCH_BLANKS: f32 = 3.0;
/// ... and its minimum, as a share of the picture's height.
const MIN_HEIGHT_SHARE: f32 = 0.35;

impl BackgroundMotion {
    pub(crate) fn new() -> Self {
        Self {
            reference: Spectrum::default(),
            current: Spectrum::default(),
            work: Spectrum::default(),
            reference_patch: None,
            measured: None,
            samples: Vec::new(),
            columns: Vec::new(),
            map: Box::new([0.0; AREA]),
            response: Box::new([0.0; AREA]),
            window: hann_window(),
        }
    }

    /// The shift measured since [`Self::forget_measurement`].
    pub(crate) const fn measured(&self) -> Option<BackgroundShift> {
        self.measured
    }

    /// Begins another frame: nothing has been measured in it.
    pub(crate) fn forget_measurement(&mut self) {
        self.measured = None;
    }

    /// Discards the reference frame.
    pub(crate) fn clear_reference(&mut self) {
        self.reference_patch = None;
    }

    /// The shift of the surroundings since [`Self::set_reference`], pixels right and down; `None` without a
    /// reference or a distinct peak.
    pub(crate) fn measure_shift(&mut self, luma: Plane<'_>, fourier: &mut Fourier) -> Option<(f32, f32)> {
        self.measure_distinct_shift(luma, fourier, MIN_PEAK_TO_SIDELOBE_RATIO)
    }

    /// The same with another least peak-to-sidelobe ratio.
    pub(crate) fn measure_distinct_shift(
        &mut self,
        luma: Plane<'_>,
        fourier: &mut Fourier,
        min_peak_to_sidelobe_ratio: f32,
    ) -> Option<(f32, f32)> {
        let patch = self.reference_patch?;
        self.transform_patch(luma, fourier, patch);
        let (work_re, work_im) = (&mut self.work.re, &mut self.work.im);
        for index in 0..AREA {
            let (a_re, a_im) = (self.reference.re[index], self.reference.im[index]);
            let (b_re, b_im) = (self.current.re[index], self.current.im[index]);
            let (re, im) = (a_re * b_re + a_im * b_im, a_re * b_im - a_im * b_re);
            // Exponent 1/2: weak components are mostly noise.
            let scale = 1.0 / (re * re + im * im + 1.0e-6).sqrt().sqrt();
            work_re[index] = re * scale;
            work_im[index] = im * scale;
        }
        fourier.inverse(&self.work, &mut self.response);
        let peak = Peak::find(&self.response);
        let limit = (SIDE / 3) as f32;
        if peak.peak_to_sidelobe_ratio < min_peak_to_sidelobe_ratio
            || peak.right.abs() > limit
            || peak.down.abs() > limit
        {
            return None;
        }
        let (u, v) = (peak.right * patch.decimation as f32, peak.down * patch.decimation as f32);
        let half = patch.decimation * (SIDE / 2) as i32;
        let centre = PixelPoint { u: f64::from(patch.left + half), v: f64::from(patch.top + half) };
        self.measured = Some(BackgroundShift { u_px: f64::from(u), v_px: f64::from(v), centre });
        Some((u, v))
    }

    /// Makes the surroundings of the target in this frame the reference for the next. A square of `blank_px`
    /// pixels a side around `centre` is blanked out.
    pub(crate) fn set_reference(
        &mut self,
        luma: Plane<'_>,
        fourier: &mut Fourier,
        centre: (f32, f32),
        blank_px: f32,
    ) {
        let side = (PATCH_BLANKS * blank_px).max(MIN_HEIGHT_SHARE * luma.height as f32);
        self.set_reference_patch(luma, fourier, centre, side, blank_px);
    }

    /// The same for a patch of about `side` pixels a side.
    pub(crate) fn set_reference_patch(
        &mut self,
        luma: Plane<'_>,
        fourier: &mut Fourier,
        centre: (f32, f32),
        side: f32,
        blank_px: f32,
    ) {
        // A cast turns NaN into 0.
        let decimation = ((side / SIDE as f32) as i32).clamp(1, 64);
        let half = decimation * (SIDE / 2) as i32;
        let patch = Patch {
            left: centre.0 as i32 - half,
            top: centre.1 as i32 - half,
            decimation,
            blank_px: 0.5 * blank_px,
        };
        self.transform_patch(luma, fourier, patch);
        core::mem::swap(&mut self.reference, &mut self.current);
        self.reference_patch = Some(patch);
    }

    fn transform_patch(&mut self, luma: Plane<'_>, fourier: &mut Fourier, patch: Patch) {
        decimate(
            luma,
            (patch.left, patch.top),
            patch.decimation,
            (SIDE, SIDE),
            &mut self.columns,
            &mut self.samples,
        );
        let mean = self.samples.iter().map(|&s| f32::from(s)).sum::<f32>() / AREA as f32;
        let half = patch.blank_px / patch.decimation as f32;
        for (index, (value, &sample)) in self.map.iter_mut().zip(&self.samples).enumerate() {
            let off = |k: usize| (k as f32 + 0.5 - (SIDE / 2) as f32).abs();
            let kept = off(index / SIDE) > half || off(index % SIDE) > half;
            *value = if kept { (f32::from(sample) - mean) * self.window[index] } else { 0.0 };
        }
        fourier.forward_pair((&self.map, &self.map), (&mut self.current, &mut self.work));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 240;
    const HEIGHT: usize = 180;

    /// A luma plane of noise, shifted by this many pixels, with `own` painted over its centre.
    fn noise((right, down): (i32, i32), own: Option<u8>) -> Vec<u8> {
        let mut samples = vec![0; WIDTH * HEIGHT];
        for (index, sample) in samples.iter_mut().enumerate() {
            let (column, row) = ((index % WIDTH) as i32, (index / WIDTH) as i32);
            // Blocks of three pixels: objects are larger than a pixel.
            let (across, along) = ((column - right).div_euclid(3), (row - down).div_euclid(3));
            let mut state = (across.wrapping_mul(73_856_093) ^ along.wrapping_mul(19_349_663)) as u32;
            state = (state ^ (state >> 15)).wrapping_mul(0x2c1b_3c6d);
            state = (state ^ (state >> 12)).wrapping_mul(0x297a_2d39);
            let target = (column - 120).abs() < 20 && (row - 90).abs() < 20;
            *sample = own.filter(|_| target).unwrap_or((state >> 24) as u8);
        }
        samples
    }

    fn plane(data: &[u8]) -> Plane<'_> {
        Plane { data, width: WIDTH, height: HEIGHT, stride: WIDTH }
    }

    fn shift_of(before: &[u8], after: &[u8]) -> Option<(f32, f32)> {
        let (mut background, mut fourier) = (BackgroundMotion::new(), Fourier::new());
        background.set_reference(plane(before), &mut fourier, (120.0, 90.0), 44.0);
        background.measure_shift(plane(after), &mut fourier)
    }

    #[test]
    fn a_picture_that_moved_gives_the_shift() {
        for (right, down) in [(0, 0), (8, 0), (0, -8), (-12, 16), (20, 4)] {
            let seen = shift_of(&noise((0, 0), None), &noise((right, down), None));
            let (u, v) = seen.unwrap_or_else(|| panic!("{right},{down}: no shift"));
            // A sample covers four pixels; the parabola interpolates between samples.
            let off = (u - right as f32).abs().max((v - down as f32).abs());
            assert!(off < 1.5, "{right},{down}: {u},{v}");
        }
    }

    #[test]
    fn the_target_in_the_middle_has_no_say() {
        let moved = noise((-8, 4), Some(250));
        let (u, v) = shift_of(&noise((0, 0), Some(250)), &moved).unwrap();
        assert!((u + 8.0).abs() < 1.5 && (v - 4.0).abs() < 1.5, "{u},{v}");
    }

    #[test]
    fn there_is_no_shift_between_different_pictures() {
        let first = noise((0, 0), None);
        let other: Vec<u8> = first.iter().rev().copied().collect();
        let flat = vec![90; WIDTH * HEIGHT];
        assert_eq!(shift_of(&first, &other), None);
        assert_eq!(shift_of(&flat, &flat), None);
        assert_eq!(shift_of(&first, &flat), None);
    }

    #[test]
    fn there_is_no_shift_without_a_reference() {
        let (mut background, mut fourier) = (BackgroundMotion::new(), Fourier::new());
        let picture = noise((0, 0), None);
        assert_eq!(background.measure_shift(plane(&picture), &mut fourier), None);
        background.set_reference(plane(&picture), &mut fourier, (120.0, 90.0), 44.0);
        assert!(background.measure_shift(plane(&picture), &mut fourier).is_some());
        background.clear_reference();
        assert_eq!(background.measure_shift(plane(&picture), &mut fourier), None);
    }
}
