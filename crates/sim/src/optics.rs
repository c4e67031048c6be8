//! A camera's lens: from the directions of things to places in the picture, and back.
//!
//! A pinhole of focal length f with radial distortion given by its inverse model,
//! `r_pinhole = r (1 + k r²)` with r the distance from the picture's centre in focal lengths: `k` > 0 is a barrel.
//! The inverse model is what a renderer needs for every pixel; the forward direction, needed for single points,
//! solves the cubic by Newton's method.

use barrelman_vocab::{PictureSize, PixelPoint};

/// A lens and the picture behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    /// Size of the picture.
    pub picture: PictureSize,
    /// Focal length, pixels.
    pub focal_px: f64,
    /// Barrel distortion k of the inverse model, at least 0.
    pub barrel: f64,
}

/// Newton steps: from the undistorted radius the cubic is solved to the last bits within six.
const STEPS: usize = 8;
/// Share of the pinhole's radius at which they end sooner: a ten-millionth of a pixel.
const CLOSE_ENOUGH: f64 = 1e-10;

impl Optics {
    /// Where a thing is seen that lies so far right, down and ahead of the optical centre (metres); `None` behind
    /// the camera.
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
                if excess <= CLOSE_ENOUGH * pinhole {
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

    /// The direction in which a place of the picture looks: right and down for each unit ahead.
    pub fn ray_direction(&self, point: PixelPoint) -> (f64, f64) {
        let x = (point.u - 0.5 * f64::from(self.picture.width)) / self.focal_px;
        let y = (point.v - 0.5 * f64::from(self.picture.height)) / self.focal_px;
        let stretch = 1.0 + self.barrel * (x * x + y * y);
        (x * stretch, y * stretch)
    }
}

/// What lies nearer than this is not seen, metres.
const MIN_DEPTH_M: f64 = 0.05;
