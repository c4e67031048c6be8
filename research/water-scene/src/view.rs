//! From the water to the picture: a flat plane, seen by a camera that looks down at a fixed angle.
//!
//! The *plane* has x to the picture's right and y away from the camera, in picture pixels at zoom 1. The
//! picture is its affine image: u = W/2 + z (x - cx), v = H/2 - z s (y - cy), with the zoom z, the point (cx,
//! cy) that the camera looks at, and the foreshortening s = sin(depression). Not handled: perspective within
//! a picture, and roll.

use barrelman_vocab::{PictureSize, PixelPoint};

/// A point of the water's plane, or an offset in it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct PlanePoint {
    /// To the picture's right, in picture pixels at zoom 1.
    pub(super) x: f64,
    /// Away from the camera, in the same unit.
    pub(super) y: f64,
}

impl PlanePoint {
    pub(super) fn offset(self, x: f64, y: f64) -> Self {
        Self { x: self.x + x, y: self.y + y }
    }

    pub(super) fn distance(self, other: Self) -> f64 {
        libm::hypot(self.x - other.x, self.y - other.y)
    }
}

/// The mapping between the plane and one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    /// The point at the centre of the picture.
    pub(super) camera: PlanePoint,
    /// Picture pixels per unit of the plane's x.
    pub(super) zoom: f64,
    /// Sine of the camera's depression, 0..=1.
    pub(super) foreshortening: f64,
    pub(super) size: PictureSize,
}

impl View {
    pub(super) fn picture(&self, point: PlanePoint) -> PixelPoint {
        let (du, dv) = self.picture_offset(point.x - self.camera.x, point.y - self.camera.y);
        let centre = self.size.centre();
        PixelPoint { u: centre.u + du, v: centre.v + dv }
    }

    /// The offset (du, dv) in the picture of an offset in the plane.
    pub(super) fn picture_offset(&self, x: f64, y: f64) -> (f64, f64) {
        (self.zoom * x, -self.zoom * self.foreshortening * y)
    }

    pub(super) fn plane(&self, u: f64, v: f64) -> PlanePoint {
        let centre = self.size.centre();
        let (x, y) = self.plane_offset(u - centre.u, v - centre.v);
        self.camera.offset(x, y)
    }

    pub(super) fn plane_offset(&self, du: f64, dv: f64) -> (f64, f64) {
        (du / self.zoom, -dv / (self.zoom * self.foreshortening))
    }
}
