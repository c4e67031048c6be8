//! Points, boxes and sizes in a picture.
//!
//! There are two frames of reference. *Pixel* coordinates (u right, v down, origin at the top left corner of
//! the picture, pixel (0,0) covers [0,1) x [0,1)) are used for cropping and drawing. *Image* coordinates (x
//! right, y up, origin at the picture's centre, in pixels) are used for control. With a picture of W x H
//! pixels: x = u - W/2, y = H/2 - v.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use core::fmt;

/// Width and height of a picture in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
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

    /// Number of pixels.
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
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PixelPoint {
    /// Pixels from the left edge; the centre of the first column is 0.5.
    pub u: f64,
    /// Pixels from the top edge; the centre of the first row is 0.5.
    pub v: f64,
}

impl PixelPoint {
    /// The same point in image coordinates of a picture of this size.
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
    /// The same point in pixel coordinates of a picture of this size.
    pub fn in_pixels(self, picture: PictureSize) -> PixelPoint {
        let centre = picture.centre();
        PixelPoint { u: centre.u + self.x, v: centre.v - self.y }
    }

    /// How far the point is from the middle of a picture, as a share of the way to its border: 0 in the
    /// middle, 1 on the border, more than 1 outside.
    pub fn share_to_border(self, picture: PictureSize) -> f64 {
        let PixelPoint { u, v } = picture.centre();
        (self.x.abs() / u.max(0.5)).max(self.y.abs() / v.max(0.5))
    }
}

/// An upright box in pixel coordinates: it covers [u, u+w) x [v, v+h).
///
/// ```
/// use barrelman_vocab::PixelBox;
///
/// let truth = PixelBox { u: 0.0, v: 0.0, w: 20.0, h: 10.0 };
/// let found = PixelBox { u: 10.0, ..truth };
/// assert_eq!(found.iou(truth), 1.0 / 3.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
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
    /// The centre of the box.
    pub fn centre(self) -> PixelPoint {
        PixelPoint { u: self.u + self.w / 2.0, v: self.v + self.h / 2.0 }
    }

    /// Whether a point lies in the box, or on its border.
    pub fn contains(self, PixelPoint { u, v }: PixelPoint) -> bool {
        (self.u..=self.u + self.w).contains(&u) && (self.v..=self.v + self.h).contains(&v)
    }

    /// Whether the box has no area, or one of its values is infinite or NaN.
    pub fn is_empty(self) -> bool {
        let finite = self.u.is_finite() && self.v.is_finite() && self.w.is_finite() && self.h.is_finite();
        !(finite && self.w > 0.0 && self.h > 0.0)
    }

    /// Area in square pixels; 0 for an empty box.
    pub fn area(self) -> f64 {
        if self.is_empty() { 0.0 } else { self.w * self.h }
    }

    /// The intersection of both boxes; empty (w = h = 0) if they do not overlap or one of them is empty.
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

    /// The part of the box that lies in a picture of this size.
    pub fn clipped(self, picture: PictureSize) -> Self {
        self.intersection(picture.bounds())
    }

    /// Intersection over union (IoU), 0 to 1. 0 if either box is empty.
    pub fn iou(self, other: Self) -> f64 {
        let both = self.intersection(other).area();
        let either = self.area() + other.area() - both;
        // The corners of the intersection are rounded: the ratio of equal boxes may exceed 1 slightly.
        if either > 0.0 { (both / either).min(1.0) } else { 0.0 }
    }
}

/// Left, top, width and height for people, to the tenth of a pixel.
impl fmt::Display for PixelBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The sum turns a negative zero into a zero.
        let [u, v, w, h] = [self.u, self.v, self.w, self.h].map(|value| (value * 10.0).round() / 10.0 + 0.0);
        write!(f, "{u},{v},{w},{h}")
    }
}
