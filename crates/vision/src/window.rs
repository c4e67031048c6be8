//! A box of whole pixels in a picture.

use barrelman_vocab::{PictureSize, PixelBox};

use crate::tracker::SelectionError;

/// Columns `x` to `x + w` and rows `y` to `y + h`, the last excluded. Empty if w or h is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Window {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// Columns.
    pub w: usize,
    /// Rows.
    pub h: usize,
}

impl Window {
    /// The window of a whole picture.
    pub const fn full(width: usize, height: usize) -> Self {
        Self { x: 0, y: 0, w: width, h: height }
    }

    /// The pixels of `area` in the picture: edges are rounded to whole pixels, but at least one pixel is
    /// kept. `None` if the box is empty or outside the picture.
    pub fn rounded_from(area: PixelBox, picture: PictureSize) -> Option<Self> {
        let inside = area.clipped(picture);
        if area.is_empty() || inside.is_empty() {
            return None;
        }
        let (x, w) = rounded_span(inside.u, inside.w, picture.width);
        let (y, h) = rounded_span(inside.v, inside.h, picture.height);
        Some(Self { x, y, w, h })
    }

    /// The part of a selection that is used.
    ///
    /// # Errors
    /// If the selection is empty or lies outside the picture.
    pub(crate) fn from_selection(selection: PixelBox, picture: PictureSize) -> Result<Self, SelectionError> {
        if selection.is_empty() {
            return Err(SelectionError::Empty { selection, picture });
        }
        Self::rounded_from(selection, picture).ok_or(SelectionError::Outside { selection, picture })
    }

    /// Number of pixels.
    pub const fn area(self) -> usize {
        self.w * self.h
    }

    /// Whether the window contains no pixel.
    pub const fn is_empty(self) -> bool {
        self.w == 0 || self.h == 0
    }

    /// First column to the right of the window.
    pub const fn right(self) -> usize {
        self.x + self.w
    }

    /// First row below the window.
    pub const fn bottom(self) -> usize {
        self.y + self.h
    }

    /// The window enlarged by `margin` pixels on every side, clipped to a map of this size.
    #[must_use]
    pub fn inflated(self, margin: usize, width: usize, height: usize) -> Self {
        let (x, y) = (self.x.saturating_sub(margin), self.y.saturating_sub(margin));
        let right = self.right().saturating_add(margin).min(width);
        let bottom = self.bottom().saturating_add(margin).min(height);
        Self { x, y, w: right.saturating_sub(x), h: bottom.saturating_sub(y) }
    }

    /// The part of the window in a map of this size.
    #[must_use]
    pub fn clipped(self, width: usize, height: usize) -> Self {
        let (x, y) = (self.x.min(width), self.y.min(height));
        Self { x, y, w: self.w.min(width - x), h: self.h.min(height - y) }
    }

    /// Whether all pixels of `other` lie in this window.
    pub const fn contains(self, other: Self) -> bool {
        other.is_empty()
            || (self.x <= other.x
                && self.y <= other.y
                && self.right() >= other.right()
                && self.bottom() >= other.bottom())
    }

    /// The smallest window that contains both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let (right, bottom) = (self.right().max(other.right()), self.bottom().max(other.bottom()));
        Self { x, y, w: right - x, h: bottom - y }
    }

    /// The part of this window outside `other`, as the pieces above, below, left and right of it; each may be
    /// empty.
    pub fn difference(self, other: Self) -> [Self; 4] {
        let (left, right) = (other.x.clamp(self.x, self.right()), other.right().clamp(self.x, self.right()));
        let (top, bottom) =
            (other.y.clamp(self.y, self.bottom()), other.bottom().clamp(self.y, self.bottom()));
        if left >= right || top >= bottom {
            let nothing = Self { w: 0, h: 0, ..self };
            return [self, nothing, nothing, nothing];
        }
        let beside = Self { y: top, h: bottom - top, ..self };
        [
            Self { h: top - self.y, ..self },
            Self { y: bottom, h: self.bottom() - bottom, ..self },
            Self { w: left - self.x, ..beside },
            Self { x: right, w: self.right() - right, ..beside },
        ]
    }

    /// The smallest window of whole 2 x 2 chroma blocks that contains this one, in a picture of this size.
    #[must_use]
    pub fn aligned_to_chroma_blocks(self, width: usize, height: usize) -> Self {
        let (x, y) = (self.x & !1, self.y & !1);
        let right = self.right().next_multiple_of(2).min(width);
        let bottom = self.bottom().next_multiple_of(2).min(height);
        Self { x, y, w: right.saturating_sub(x), h: bottom.saturating_sub(y) }
    }

    /// The window in pixel coordinates.
    pub fn to_pixel_box(self) -> PixelBox {
        PixelBox { u: self.x as f64, v: self.y as f64, w: self.w as f64, h: self.h as f64 }
    }
}

/// Whether part of the box lies outside the picture.
pub(crate) fn exceeds_picture(selection: PixelBox, picture: PictureSize) -> bool {
    let (right, bottom) = (selection.u + selection.w, selection.v + selection.h);
    selection.u < 0.0
        || selection.v < 0.0
        || right > f64::from(picture.width)
        || bottom > f64::from(picture.height)
}

/// `start..start + length` rounded to whole pixels, at least one, below `end`.
fn rounded_span(start: f64, length: f64, end: u32) -> (usize, usize) {
    let last = (end as usize).saturating_sub(1);
    let first = ((start + 0.5) as usize).min(last);
    let behind = ((start + length + 0.5) as usize).clamp(first + 1, last + 1);
    (first, behind - first)
}
