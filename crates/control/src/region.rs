//! The elliptical region in which the target may roam without camera motion.
//!
//! P = x²/a² + y²/b² (`biswas2017`, equation 1), with x and y in image coordinates (pixels from the picture's
//! centre, x right, y up) and the semi-axes a and b in pixels. P is 0 at the centre and 1 on the ellipse.

use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{ImagePoint, PictureSize};

/// An ellipse around the picture's centre.
///
/// ```
/// use barrelman_control::Region;
/// use barrelman_vocab::profile::RegionShares;
/// use barrelman_vocab::{ImagePoint, PictureSize};
///
/// let shares = RegionShares { half_width: 0.6, half_height: 0.5 };
/// let region = Region::from_shares(shares, PictureSize::new(640, 480));
/// assert_eq!((region.a_px, region.b_px), (192.0, 120.0));
/// assert_eq!(region.p(ImagePoint { x: 192.0, y: 0.0 }), 1.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Horizontal semi-axis, pixels, above zero.
    pub a_px: f64,
    /// Vertical semi-axis, pixels, above zero.
    pub b_px: f64,
}

impl Region {
    /// The region with these shares of half the picture's width and height.
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
