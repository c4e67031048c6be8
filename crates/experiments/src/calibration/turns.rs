//! The camera's turns between two video frames, from the shifts of patches of the picture.
//!
//! A camera with the tilt t that pans by d (right) and tilts by e (up) moves a distant image point (x, y), in
//! pixels with y upwards, with the focal length f, by
//!
//! ```text
//!   dx = -(f + x^2/f) a + y b - (x y/f) e        a = d cos t, b = d sin t
//!   dy = -(x y/f) a - x b - (f + y^2/f) e
//! ```
//! (Longuet-Higgins and Prazdny 1980, without translation). Both shares of the pan, a and b, are solved for:
//! the pan is known without the tilt, and tells the tilt.

use barrelman_vision::PatchShift;
use barrelman_vocab::PictureSize;

/// The turn between two frames, radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Turn {
    /// Pan times the cosine of the tilt.
    pub(super) pan_cos: f64,
    /// Pan times the sine of the tilt.
    pub(super) pan_sin: f64,
    /// Tilt.
    pub(super) tilt: f64,
}

/// Least number of patches that tell a turn.
const MIN_PATCHES: usize = 4;
/// A patch whose shift differs by more than this from that of the turn is left out, pixels.
const MAX_RESIDUAL_PX: f64 = 1.5;

impl Turn {
    /// The turn that explains the shifts best; `None`: too few of them agree.
    pub(super) fn from_shifts(
        shifts: &[Option<PatchShift>],
        picture: PictureSize,
        focal_px: f64,
    ) -> Option<Self> {
        let mut used: Vec<PatchShift> = shifts.iter().flatten().copied().collect();
        loop {
            if used.len() < MIN_PATCHES {
                return None;
            }
            let turn = Self::least_squares(&used, picture, focal_px)?;
            let residual = |shift: &PatchShift| turn.residual_px(shift, picture, focal_px);
            let (worst, size) =
                used.iter().map(residual).enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
            if size <= MAX_RESIDUAL_PX {
                return Some(turn);
            }
            used.swap_remove(worst);
        }
    }

    fn least_squares(shifts: &[PatchShift], picture: PictureSize, focal_px: f64) -> Option<Self> {
        let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
        for shift in shifts {
            for (row, value) in equations(shift, picture, focal_px) {
                for i in 0..3 {
                    right[i] += row[i] * value;
                    for j in 0..3 {
                        normal[i][j] += row[i] * row[j];
                    }
                }
            }
        }
        let [pan_cos, pan_sin, tilt] = solve(normal, right)?;
        Some(Self { pan_cos, pan_sin, tilt })
    }

    fn residual_px(&self, shift: &PatchShift, picture: PictureSize, focal_px: f64) -> f64 {
        let off = equations(shift, picture, focal_px)
            .map(|(row, value)| row[0] * self.pan_cos + row[1] * self.pan_sin + row[2] * self.tilt - value);
        libm::hypot(off[0], off[1])
    }
}

/// The equations of a shift: the row of coefficients and the measured value, for x and y.
fn equations(shift: &PatchShift, picture: PictureSize, f: f64) -> [([f64; 3], f64); 2] {
    let point = shift.centre.in_image(picture);
    let (x, y) = (point.x, point.y);
    [([-(f + x * x / f), y, -(x * y / f)], shift.u_px), ([-(x * y / f), -x, -(f + y * y / f)], -shift.v_px)]
}

/// Solves three linear equations by elimination with pivots; `None`: they have no single solution.
fn solve(mut m: [[f64; 3]; 3], mut r: [f64; 3]) -> Option<[f64; 3]> {
    for column in 0..3 {
        let pivot = (column..3).max_by(|a, b| m[*a][column].abs().total_cmp(&m[*b][column].abs()))?;
        if m[pivot][column].abs() < 1e-9 {
            return None;
        }
        m.swap(column, pivot);
        r.swap(column, pivot);
        for row in column + 1..3 {
            let above = m[column];
            let factor = m[row][column] / above[column];
            for (value, from) in m[row].iter_mut().zip(above).skip(column) {
                *value -= factor * from;
            }
            r[row] -= factor * r[column];
        }
    }
    let mut solution = [0.0; 3];
    for row in (0..3).rev() {
        let known: f64 = (row + 1..3).map(|k| m[row][k] * solution[k]).sum();
        solution[row] = (r[row] - known) / m[row][row];
    }
    Some(solution)
}

#[cfg(test)]
mod tests {
    use barrelman_control::view::View;
    use barrelman_vocab::{ImagePoint, PixelPoint};

    use super::*;

    const PICTURE: PictureSize = PictureSize::new(640, 360);
    const FOCAL_PX: f64 = 330.0;

    fn shifts(pan: f64, tilt_before: f64, tilt: f64) -> Vec<Option<PatchShift>> {
        let places =
            [(0.0, 0.0), (-150.0, 60.0), (150.0, 60.0), (-150.0, -60.0), (150.0, -60.0), (0.0, 90.0)];
        let seen = places.map(|(x, y)| {
            let direction = View::new(FOCAL_PX, 0.0, tilt_before).unproject(ImagePoint { x, y });
            let after = View::new(FOCAL_PX, pan, tilt).project(direction);
            let centre: PixelPoint = ImagePoint { x, y }.in_pixels(PICTURE);
            Some(PatchShift { centre, u_px: after.x - x, v_px: y - after.y })
        });
        seen.to_vec()
    }

    #[test]
    fn a_turn_is_told_at_every_tilt() {
        for tilt_deg in [0.0_f64, -24.0, -60.0, -90.0] {
            let tilt = tilt_deg.to_radians();
            for (pan, up) in [(0.004, 0.0), (-0.004, 0.0), (0.0, 0.003), (0.0, -0.003)] {
                let turn = Turn::from_shifts(&shifts(pan, tilt, tilt + up), PICTURE, FOCAL_PX).unwrap();
                let expected = [pan * libm::cos(tilt), pan * libm::sin(tilt), up];
                for (seen, expected) in [turn.pan_cos, turn.pan_sin, turn.tilt].into_iter().zip(expected) {
                    assert!((seen - expected).abs() < 1e-4, "{tilt_deg} {pan} {up}: {turn:?}");
                }
            }
        }
    }

    #[test]
    fn a_patch_that_moves_by_itself_is_left_out_and_too_few_tell_nothing() {
        let mut moved = shifts(0.004, -0.4, -0.4);
        let honest = Turn::from_shifts(&moved, PICTURE, FOCAL_PX).unwrap();
        moved[3].as_mut().unwrap().u_px += 8.0;
        let robust = Turn::from_shifts(&moved, PICTURE, FOCAL_PX).unwrap();
        assert!((robust.pan_cos - honest.pan_cos).abs() < 2e-4, "{robust:?}");
        assert_eq!(Turn::from_shifts(&moved[..3], PICTURE, FOCAL_PX), None);
    }
}
