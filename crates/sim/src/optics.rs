//! The camera's optics: projection of points into the picture, and the rays of pixels.
//!
//! A pinhole of focal length f with radial distortion, given by its inverse model `r_pinhole = r (1 + k r²)`,
//! where r is the distance from the centre of the picture in focal lengths; k > 0 is barrel distortion. A
//! renderer needs the inverse model for every pixel. The forward direction, needed for single points, solves
//! the cubic by Newton's method.

use barrelman_vocab::{PictureSize, PixelPoint};

/// A lens and the picture size behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    /// Size of the picture.
    pub picture: PictureSize,
    /// Focal length, pixels.
    pub focal_px: f64,
    /// Barrel distortion k of the inverse model, at least 0.
    pub barrel: f64,
}

/// Newton steps; from the undistorted radius, six solve the cubic to the last bits.
const STEPS: usize = 8;
/// The iteration ends early below this share of the pinhole radius: a ten-millionth of a pixel.
const MAX_RELATIVE_EXCESS: f64 = 1e-10;

impl Optics {
    /// Projects a point given right, down and ahead of the optical centre (metres). `None` nearer than 0.05 m
    /// ahead, or behind the camera.
    pub fn project(&self, (right, down, ahead): (f64, f64, f64)) -> Option<PixelPoint> {
        if ahead <= MIN_DEPTH_M {
            return None;
        }
        let (x, y) = (right / ahead, down / ahead);
        let pinhole = libm::hypot(x, y);
        let mut r = pinhole;
        if self.barrel > 0.0 {
            for _ in 0..STEPS {
                let excess = r * (1.0 + self.barrel * r * r) - pinhole;
                if excess <= MAX_RELATIVE_EXCESS * pinhole {
                    break;
                }
                r -= excess / (1.0 + 3.0 * self.barrel * r * r);
            }
        }
        let shrink = if pinhole > 0.0 { r / pinhole } else { 1.0 };
        Some(PixelPoint {
            u: 0.5 * f64::from(self.picture.width) + self.focal_px * x * shrink,
            v: 0.5 * f64::from(self.picture.height) + self.focal_px * y * shrink,
        })
    }

    /// The direction of a pixel's line of sight: right and down for each unit ahead.
    pub fn ray_direction(&self, point: PixelPoint) -> (f64, f64) {
        let x = (point.u - 0.5 * f64::from(self.picture.width)) / self.focal_px;
        let y = (point.v - 0.5 * f64::from(self.picture.height)) / self.focal_px;
        let stretch = 1.0 + self.barrel * (x * x + y * y);
        (x * stretch, y * stretch)
    }
}

/// Points less far ahead than this are not projected, metres.
const MIN_DEPTH_M: f64 = 0.05;
