//! The elliptical region that the target may roam in without the camera moving.
//!
//! P = x²/a² + y²/b² (`biswas2017`, equation 1), x and y in image coordinates (pixels from the picture's
//! centre, x right, y up), a and b the semi-axes in pixels. P is 0 at the centre, 1 on the ellipse.

use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{ImagePoint, PictureSize};

/// An ellipse around the picture's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Horizontal semi-axis, pixels, above zero.
    pub a_px: f64,
    /// Vertical semi-axis, pixels, above zero.
    pub b_px: f64,
}

impl Region {
    /// The region that takes up these shares of half the width and half the height of a picture.
    pub fn from_shares(shares: RegionShares, picture: PictureSize) -> Self {
        Self {
            a_px: shares.half_width * f64::from(picture.width) / 2.0,
            b_px: shares.half_height * f64::from(picture.height) / 2.0,
        }
    }

    /// P of a point: at most 1 inside and on the ellipse, more than 1 outside.
    pub fn p(self, point: ImagePoint) -> f64 {
        let across = point.x / self.a_px;
        let up = point.y / self.b_px;
        across * across + up * up
    }
}
