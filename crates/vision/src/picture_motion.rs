//! Motion of the whole picture between video frames, by registration of a few patches: for measuring a camera
//! that turns, without a target.
//!
//! Each patch is registered with its own reference frame until the picture has moved by a share of the patch;
//! then a new reference is taken. Errors of a registration therefore do not add up with every frame.

use barrelman_vocab::{Picture, PictureSize, PixelPoint};

use crate::background::BackgroundMotion;
use crate::fourier::Fourier;

/// Centres of the patches, as shares of the picture.
pub const PATCH_CENTRES: [(f64, f64); PATCHES] =
    [(0.5, 0.5), (0.25, 0.35), (0.75, 0.35), (0.25, 0.65), (0.75, 0.65), (0.5, 0.25), (0.5, 0.75)];
/// A reference is used for so many frames at most: water changes.
const MAX_AGE: u32 = 8;
/// Least peak-to-sidelobe ratio of a shift. The patches check each other.
const MIN_PEAK_RATIO: f32 = 6.0;
/// Number of patches.
pub const PATCHES: usize = 7;
/// Side of a patch, as a share of the picture's height.
const SIDE_SHARE: f32 = 0.45;
/// A new reference is taken from this shift on, as a share of the picture's height.
const MAX_SHIFT_SHARE: f32 = 0.05;

/// The shift of a patch since the frame before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchShift {
    /// The patch's centre.
    pub centre: PixelPoint,
    /// To the right, pixels.
    pub u_px: f64,
    /// Downwards, pixels.
    pub v_px: f64,
}

/// Measures the motion of the picture.
#[derive(Debug)]
pub struct PictureMotion {
    fourier: Fourier,
    patches: [Patch; PATCHES],
    size: Option<PictureSize>,
}

#[derive(Debug)]
struct Patch {
    registration: BackgroundMotion,
    /// The shift since the reference in the last frame; `None` without a reference.
    shift: Option<(f32, f32)>,
    /// Frames since the reference.
    age: u32,
}

impl Default for PictureMotion {
    fn default() -> Self {
        let patch = |_| Patch { registration: BackgroundMotion::new(), shift: None, age: 0 };
        Self { fourier: Fourier::new(), patches: core::array::from_fn(patch), size: None }
    }
}

impl PictureMotion {
    /// The shifts of the patches since the last call; `None` for a patch that cannot be registered.
    pub fn measure(&mut self, picture: &Picture) -> [Option<PatchShift>; PATCHES] {
        let size = picture.size();
        if self.size.replace(size) != Some(size) {
            self.patches.iter_mut().for_each(|patch| patch.shift = None);
        }
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let max_shift = MAX_SHIFT_SHARE * size.height as f32;
        let mut shifts = [None; PATCHES];
        for ((patch, (u, v)), shift) in self.patches.iter_mut().zip(PATCH_CENTRES).zip(&mut shifts) {
            let centre = PixelPoint { u: u * width, v: v * height };
            let before = patch.shift;
            let now = before.and_then(|_| {
                patch.registration.measure_distinct_shift(picture.y(), &mut self.fourier, MIN_PEAK_RATIO)
            });
            *shift = before.zip(now).map(|(before, now)| PatchShift {
                centre,
                u_px: f64::from(now.0 - before.0),
                v_px: f64::from(now.1 - before.1),
            });
            patch.shift = now;
            patch.age += 1;
            let is_far = now.is_none_or(|(right, down)| right.abs().max(down.abs()) > max_shift);
            if is_far || patch.age >= MAX_AGE {
                patch.age = 0;
                let place = (centre.u as f32, centre.v as f32);
                let side = SIDE_SHARE * size.height as f32;
                patch.registration.set_reference_patch(picture.y(), &mut self.fourier, place, side, 0.0);
                patch.shift = Some((0.0, 0.0));
            }
        }
        shifts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::smooth_noise;
    use barrelman_vocab::video::ColourEncoding;

    const SIZE: PictureSize = PictureSize::new(320, 180);

    /// A picture of smooth noise that is shifted by (right, down) pixels.
    fn picture(right: f64, down: f64) -> Picture {
        smooth_noise(SIZE, |x, y| (x - right, y - down))
    }

    #[test]
    fn the_shifts_of_many_frames_add_up_to_the_way() {
        let mut motion = PictureMotion::default();
        assert_eq!(
            motion.measure(&picture(0.0, 0.0)),
            [None; PATCHES],
            "the first frame has nothing before it"
        );
        let mut ways = [(0.0, 0.0); PATCHES];
        for step in 1..=60 {
            let shifts = motion.measure(&picture(1.3 * f64::from(step), -0.6 * f64::from(step)));
            for (way, shift) in ways.iter_mut().zip(shifts) {
                let shift = shift.expect("noise can be registered");
                *way = (way.0 + shift.u_px, way.1 + shift.v_px);
            }
        }
        for (right, down) in ways {
            assert!((right - 78.0).abs() < 3.0 && (down + 36.0).abs() < 3.0, "{right} {down}");
        }
    }

    #[test]
    fn an_even_picture_has_no_motion_to_measure() {
        let mut motion = PictureMotion::default();
        let even = Picture::black(SIZE, ColourEncoding::JPEG);
        motion.measure(&even);
        assert_eq!(motion.measure(&even), [None; PATCHES]);
    }
}
