//! Growth of the picture while the camera zooms, by registration of patches all over it.
//!
//! All patches have the same reference frame. The shift of a patch is linear in its place: by the motion of
//! the camera, and by the growth times the distance from the middle. The growth since the reference is the
//! median, over pairs of patches and both axes, of the shift apart over the distance, so that a patch on a
//! boat or a wake has no say. A reference is kept while the patches stay recognisable: errors do not add up
//! with every frame.

use barrelman_vocab::{Picture, PictureSize};

use crate::background::BackgroundMotion;
use crate::fourier::Fourier;
use crate::picture_motion::{PATCH_CENTRES, PATCHES};

/// Least peak-to-sidelobe ratio of a shift. The patches check each other.
const MIN_PEAK_RATIO: f32 = 6.0;
/// Side of a patch, as a share of the picture's height.
const SIDE_SHARE: f32 = 0.27;
/// A reference is used for so many frames at most, while no patch has moved by this share of the picture's
/// height, and the picture has not grown by this logarithm: patches that differ in scale are not recognised.
const MAX_AGE: u32 = 15;
const MAX_SHIFT_SHARE: f32 = 0.1;
const MAX_GROWTH: f64 = 0.04;
/// Patches that are this share of the picture's side apart tell its growth.
const MIN_DISTANCE: f64 = 0.25;
/// Least number of patches that are recognised.
const MIN_PATCHES: usize = 4;

/// Measures the growth of the picture.
#[derive(Debug)]
pub struct PictureGrowth {
    fourier: Fourier,
    registrations: [BackgroundMotion; PATCHES],
    reference: Option<Reference>,
}

/// The frame that the patches are compared with.
#[derive(Debug, Clone, Copy)]
struct Reference {
    size: PictureSize,
    /// Frames since then.
    age: u32,
    /// Growth from then to the frame before.
    growth: f64,
}

impl Default for PictureGrowth {
    fn default() -> Self {
        let registrations = core::array::from_fn(|_| BackgroundMotion::new());
        Self { fourier: Fourier::new(), registrations, reference: None }
    }
}

impl PictureGrowth {
    /// The growth since the last call, as the logarithm of the picture's scale; `None`: too few patches are
    /// recognised.
    pub fn measure(&mut self, picture: &Picture) -> Option<f64> {
        let size = picture.size();
        let before = self.reference.take().filter(|reference| reference.size == size);
        let shifts = before.map_or([None; PATCHES], |_| self.shifts(picture));
        let growth = growth_of(&shifts, size);
        let max_shift = MAX_SHIFT_SHARE * size.height as f32;
        let is_near = shifts.iter().flatten().all(|(u, v)| u.abs().max(v.abs()) <= max_shift);
        self.reference =
            before.zip(growth).map(|(before, growth)| Reference { age: before.age + 1, growth, ..before });
        let is_like = |kept: &Reference| is_near && kept.age < MAX_AGE && kept.growth.abs() <= MAX_GROWTH;
        if !self.reference.as_ref().is_some_and(is_like) {
            self.set_reference(picture);
        }
        before.zip(growth).map(|(before, growth)| growth - before.growth)
    }

    /// Shifts of the patches since the reference, pixels to the right and down.
    fn shifts(&mut self, picture: &Picture) -> [Option<(f32, f32)>; PATCHES] {
        let fourier = &mut self.fourier;
        self.registrations
            .each_mut()
            .map(|patch| patch.measure_distinct_shift(picture.y(), fourier, MIN_PEAK_RATIO))
    }

    fn set_reference(&mut self, picture: &Picture) {
        let size = picture.size();
        let side = SIDE_SHARE * size.height as f32;
        for (registration, (u, v)) in self.registrations.iter_mut().zip(PATCH_CENTRES) {
            let centre = ((u * f64::from(size.width)) as f32, (v * f64::from(size.height)) as f32);
            registration.set_reference_patch(picture.y(), &mut self.fourier, centre, side, 0.0);
        }
        self.reference = Some(Reference { size, age: 0, growth: 0.0 });
    }
}

/// A patch: its place, as shares of the picture's sides, and its shift, pixels.
type Patch = ((f64, f64), (f32, f32));

/// The growth that two patches tell along each axis in which they are far enough apart.
fn growths((first, second): (Patch, Patch), size: PictureSize) -> impl Iterator<Item = f64> {
    let ((at_a, a), (at_b, b)) = (first, second);
    let horizontal = (at_a.0 - at_b.0, f64::from(a.0 - b.0), f64::from(size.width));
    let vertical = (at_a.1 - at_b.1, f64::from(a.1 - b.1), f64::from(size.height));
    let is_apart = |(apart, ..): &(f64, f64, f64)| apart.abs() >= MIN_DISTANCE;
    [horizontal, vertical].into_iter().filter(is_apart).map(|(apart, grown, side)| grown / (apart * side))
}

/// The growth that the shifts of the patches tell.
fn growth_of(shifts: &[Option<(f32, f32)>; PATCHES], size: PictureSize) -> Option<f64> {
    let seen = || PATCH_CENTRES.into_iter().zip(shifts).filter_map(|(at, shift)| Some((at, (*shift)?)));
    if seen().count() < MIN_PATCHES {
        return None;
    }
    let pairs = seen().enumerate().flat_map(|(index, one)| seen().take(index).map(move |other| (one, other)));
    let mut slopes = [0.0; PATCHES * (PATCHES - 1)];
    let mut count = 0;
    for slope in pairs.flat_map(|pair| growths(pair, size)) {
        slopes[count] = slope;
        count += 1;
    }
    let slopes = &mut slopes[..count];
    slopes.sort_unstable_by(f64::total_cmp);
    let (low, high) = (slopes.get(count.checked_sub(1)? / 2)?, slopes.get(count / 2)?);
    // What a patch compares lies between its places in both frames, so that the slope is the logarithm up to
    // its cube.
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::smooth_noise;

    const SIZE: PictureSize = PictureSize::new(640, 360);

    /// A picture that is enlarged around its middle, and moved to the right.
    fn enlarged(scale: f64, right: f64) -> Picture {
        smooth_noise(SIZE, |x, y| (320.0 + (x - right - 320.0) / scale, 180.0 + (y - 180.0) / scale))
    }

    #[test]
    fn the_growth_of_many_frames_adds_up_to_the_scale_whatever_the_camera_turns() {
        for (rate, right) in [(0.01, 0.0), (0.004, 1.5), (-0.01, -1.0)] {
            let mut motion = PictureGrowth::default();
            let mut grown = 0.0;
            for frame in (0..60).map(f64::from) {
                grown += motion.measure(&enlarged(libm::exp(rate * frame), right * frame)).unwrap_or(0.0);
            }
            // Measured: within 1.6 %.
            assert!((grown / (59.0 * rate) - 1.0).abs() < 0.04, "{rate} {right}: {grown}");
        }
    }

    #[test]
    fn a_picture_that_only_moves_does_not_grow() {
        let mut motion = PictureGrowth::default();
        assert_eq!(motion.measure(&enlarged(1.0, 0.0)), None, "there is no frame before");
        for frame in (1..40).map(f64::from) {
            let growth = motion.measure(&enlarged(1.0, 2.0 * frame));
            assert!(growth.is_some_and(|growth| growth.abs() < 0.004), "{frame}: {growth:?}");
        }
    }

    #[test]
    fn an_even_picture_and_few_patches_tell_nothing() {
        let mut motion = PictureGrowth::default();
        let even = smooth_noise(SIZE, |_, _| (0.0, 0.0));
        motion.measure(&even);
        assert_eq!(motion.measure(&even), None);
        let mut shifts = [Some((1.0, 0.0)); PATCHES];
        assert_eq!(growth_of(&shifts, SIZE), Some(0.0));
        shifts[3..].fill(None);
        assert_eq!(growth_of(&shifts, SIZE), None);
    }
}
