//! What makes a lens unusable: found once, when a lens is loaded.

use barrelman_vocab::{Distortion, Lens, PixelPoint};

use super::lens::tangents_of;

/// Points on each side of the grid that covers the picture from border to border.
const GRID: u32 = 65;

/// Why a lens cannot be used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LensFault {
    /// A value is not finite.
    NotFinite,
    /// A focal length is not above zero.
    FocalLength,
    /// The principal point is outside of the picture.
    PrincipalPoint,
    /// The distortion folds over inside of the picture: nothing is seen at this pixel.
    Fold(PixelPoint),
}

/// The first fault of a lens; `None`: every pixel of its picture has a line of sight. The fold is looked for
/// at 65 x 65 points from border to border.
pub fn fault_of(lens: &Lens) -> Option<LensFault> {
    let coefficients = match lens.distortion {
        Distortion::None => [0.0; 5],
        Distortion::Barrel { k } => [k, 0.0, 0.0, 0.0, 0.0],
        Distortion::BrownConrady(model) => [model.k1, model.k2, model.p1, model.p2, model.k3],
    };
    let (focal, principal) = (lens.focal_px, lens.principal);
    let lengths = [focal.0, focal.1, principal.u, principal.v];
    if !lengths.iter().chain(&coefficients).all(|value| value.is_finite()) {
        return Some(LensFault::NotFinite);
    }
    if focal.0 <= 0.0 || focal.1 <= 0.0 {
        return Some(LensFault::FocalLength);
    }
    let (width, height) = (f64::from(lens.picture.width), f64::from(lens.picture.height));
    if !(0.0..=width).contains(&principal.u) || !(0.0..=height).contains(&principal.v) {
        return Some(LensFault::PrincipalPoint);
    }
    let share = |step: u32| f64::from(step) / f64::from(GRID - 1);
    (0..GRID * GRID)
        .map(|index| PixelPoint { u: width * share(index % GRID), v: height * share(index / GRID) })
        .find(|pixel| tangents_of(lens, *pixel).is_none())
        .map(LensFault::Fold)
}
