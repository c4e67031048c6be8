//! The lens of a camera: focal lengths, principal point and distortion.
//!
//! *Normalised coordinates* (x right, y down) are the tangents of a line of sight: a point in the camera's
//! frame of reference (right, down, ahead) has x = right / ahead and y = down / ahead. A lens maps them to
//! pixel coordinates; the maps are computed in `barrelman-control`.

use crate::image::{PictureSize, PixelPoint};

/// A camera's lens, for pictures of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Size of the picture to which the pixel coordinates refer.
    pub picture: PictureSize,
    /// Focal length in pixels: horizontal, vertical.
    pub focal_px: (f64, f64),
    /// Where the optical axis meets the picture. The centre of the first pixel is (0.5, 0.5): OpenCV's
    /// principal point is smaller by 0.5 in both coordinates.
    pub principal: PixelPoint,
    /// Distortion.
    pub distortion: Distortion,
}

/// How a lens displaces a line of sight in the picture. The radius r is the distance from the principal point
/// in focal lengths.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Distortion {
    /// A pinhole.
    #[default]
    None,
    /// The simulator's model, from the picture to the line of sight: `r_pinhole = r (1 + k r²)`; k > 0 is
    /// barrel distortion.
    Barrel {
        /// Coefficient k, at least 0.
        k: f64,
    },
    /// The model of Brown and Conrady as in OpenCV, from the line of sight to the picture.
    BrownConrady(BrownConrady),
}

/// Coefficients of the model of Brown and Conrady, in the order of OpenCV's files. With r² = x² + y²:
///
/// ```text
/// s   = 1 + k1 r² + k2 r⁴ + k3 r⁶
/// x'  = s x + 2 p1 x y + p2 (r² + 2 x²)
/// y'  = s y + p1 (r² + 2 y²) + 2 p2 x y
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BrownConrady {
    /// Radial, second order; negative for barrel distortion.
    pub k1: f64,
    /// Radial, fourth order.
    pub k2: f64,
    /// Tangential, along y.
    pub p1: f64,
    /// Tangential, along x.
    pub p2: f64,
    /// Radial, sixth order.
    pub k3: f64,
}

impl Lens {
    /// A pinhole with square pixels, and the principal point at the centre of the picture.
    pub fn pinhole(picture: PictureSize, focal_px: f64) -> Self {
        Self {
            picture,
            focal_px: (focal_px, focal_px),
            principal: picture.centre(),
            distortion: Distortion::None,
        }
    }

    /// The lens for pictures of another size that show the same as those of the lens. `None`: the aspect
    /// ratios differ, by more than one row of the other picture.
    pub fn scaled_to(&self, picture: PictureSize) -> Option<Self> {
        let (width, height) = (u64::from(self.picture.width), u64::from(self.picture.height));
        let (across, down) = (u64::from(picture.width) * height, u64::from(picture.height) * width);
        if across.abs_diff(down) > width || across == 0 || down == 0 {
            return None;
        }
        let share = (
            f64::from(picture.width) / f64::from(self.picture.width),
            f64::from(picture.height) / f64::from(self.picture.height),
        );
        Some(Self {
            picture,
            focal_px: (share.0 * self.focal_px.0, share.1 * self.focal_px.1),
            principal: PixelPoint { u: share.0 * self.principal.u, v: share.1 * self.principal.v },
            distortion: self.distortion,
        })
    }

    /// A lens with square pixels, the principal point at the centre of the picture, and the simulator's
    /// distortion.
    pub fn barrel(picture: PictureSize, focal_px: f64, k: f64) -> Self {
        Self { distortion: Distortion::Barrel { k }, ..Self::pinhole(picture, focal_px) }
    }
}
