//! Points, boxes and sizes in a picture.
//!
//! Two frames of reference: *pixel* coordinates (u right, v down, origin at the top left corner of the picture,
//! pixel (0,0) covering [0,1) x [0,1)) for whatever is cut out of or drawn on a picture, and *image*
//! coordinates (x right, y up, origin at the picture's centre, in pixels of the picture) for control:
//! x = u - W/2, y = H/2 - v.

use core::fmt;

/// Width and height of a picture in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PictureSize {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl PictureSize {
    /// A picture of `width` x `height` pixels.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// The whole picture as a box.
    pub fn bounds(self) -> PixelBox {
        PixelBox { u: 0.0, v: 0.0, w: f64::from(self.width), h: f64::from(self.height) }
    }

    /// The centre in pixel coordinates.
    pub fn centre(self) -> PixelPoint {
        PixelPoint { u: f64::from(self.width) / 2.0, v: f64::from(self.height) / 2.0 }
    }

    /// Pixels in the picture.
    pub const fn area(self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl fmt::Display for PictureSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// A point in pixel coordinates: u to the right, v downwards, origin at the top left corner.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelPoint {
    /// Pixels from the left edge; the centre of the first column is 0.5.
    pub u: f64,
    /// Pixels from the top edge; the centre of the first row is 0.5.
    pub v: f64,
}

impl PixelPoint {
    /// The same point in image coordinates of a picture of that size.
    pub fn in_image(self, picture: PictureSize) -> ImagePoint {
        let centre = picture.centre();
        ImagePoint { x: self.u - centre.u, y: centre.v - self.v }
    }
}

/// A point in image coordinates: x to the right, y upwards, origin at the picture's centre, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImagePoint {
    /// Pixels to the right of the centre.
    pub x: f64,
    /// Pixels above the centre.
    pub y: f64,
}

impl ImagePoint {
    /// The same point in pixel coordinates of a picture of that size.
    pub fn in_pixels(self, picture: PictureSize) -> PixelPoint {
        let centre = picture.centre();
        PixelPoint { u: centre.u + self.x, v: centre.v - self.y }
    }
}

/// An upright box in pixel coordinates: it covers [u, u+w) x [v, v+h).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelBox {
    /// Left edge.
    pub u: f64,
    /// Top edge.
    pub v: f64,
    /// Width; a box with w <= 0 or h <= 0 is empty.
    pub w: f64,
    /// Height.
    pub h: f64,
}

impl PixelBox {
    /// The middle of the box.
    pub fn centre(self) -> PixelPoint {
        PixelPoint { u: self.u + self.w / 2.0, v: self.v + self.h / 2.0 }
    }

    /// Whether the box covers nothing, or one of its numbers is not a number.
    pub fn is_empty(self) -> bool {
        let finite = self.u.is_finite() && self.v.is_finite() && self.w.is_finite() && self.h.is_finite();
        !(finite && self.w > 0.0 && self.h > 0.0)
    }

    /// Square pixels covered.
    pub fn area(self) -> f64 {
        if self.is_empty() { 0.0 } else { self.w * self.h }
    }

    /// What both boxes cover; empty (w = h = 0) where they do not meet, or one of them is empty.
    pub fn intersection(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::default();
        }
        let (left, top) = (self.u.max(other.u), self.v.max(other.v));
        let right = (self.u + self.w).min(other.u + other.w);
        let bottom = (self.v + self.h).min(other.v + other.h);
        if right > left && bottom > top {
            Self { u: left, v: top, w: right - left, h: bottom - top }
        } else {
            Self { u: left, v: top, w: 0.0, h: 0.0 }
        }
    }

    /// The part of the box that lies in a picture of that size.
    pub fn clipped(self, picture: PictureSize) -> Self {
        self.intersection(picture.bounds())
    }

    /// Intersection over union, 0 to 1: the usual measure of how well two boxes agree.
    pub fn iou(self, other: Self) -> f64 {
        let both = self.intersection(other).area();
        let either = self.area() + other.area() - both;
        // The corners of the intersection are rounded: equal boxes may come out a little over 1.
        if either > 0.0 { (both / either).min(1.0) } else { 0.0 }
    }
}

impl fmt::Display for PixelBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.u, self.v, self.w, self.h)
    }
}
