//! Places labels: keeps the reserved boxes of a picture and finds free places.

use barrelman_vocab::{PixelBox, PixelPoint};

/// The reserved boxes of one picture.
#[derive(Debug, Default)]
pub(super) struct LabelPlacement {
    picture_bounds: PixelBox,
    gap: f64,
    reserved: Vec<PixelBox>,
}

impl LabelPlacement {
    /// Removes all reservations. Placed boxes keep a distance of `gap`.
    pub(super) fn begin(&mut self, picture_bounds: PixelBox, gap: f64) {
        self.picture_bounds = picture_bounds;
        self.gap = gap;
        self.reserved.clear();
    }

    /// The bounds of the picture.
    pub(super) fn picture_bounds(&self) -> PixelBox {
        self.picture_bounds
    }

    /// Reserves a box, whether or not it is free.
    pub(super) fn reserve(&mut self, reserved: PixelBox) {
        self.reserved.push(reserved);
    }

    /// Whether a box is not empty, lies in the picture and meets no reserved box.
    pub(super) fn is_free(&self, wanted: PixelBox) -> bool {
        let is_inside =
            !wanted.is_empty() && wanted.intersection(self.picture_bounds).area() >= wanted.area() - 1e-6;
        let gap = self.gap / 2.0;
        let with_gap = PixelBox {
            u: wanted.u - gap,
            v: wanted.v - gap,
            w: wanted.w + 2.0 * gap,
            h: wanted.h + 2.0 * gap,
        };
        is_inside && self.reserved.iter().all(|reserved| with_gap.intersection(*reserved).is_empty())
    }

    /// Reserves a box of this size at the first free place. The places are given by their centres.
    pub(super) fn place_at_first_free(
        &mut self,
        (w, h): (f64, f64),
        centres: impl IntoIterator<Item = PixelPoint>,
    ) -> Option<PixelBox> {
        let around = |centre: PixelPoint| PixelBox { u: centre.u - w / 2.0, v: centre.v - h / 2.0, w, h };
        let free = centres.into_iter().map(around).find(|wanted| self.is_free(*wanted))?;
        self.reserve(free);
        Some(free)
    }

    /// Reserves one of the boxes: the last one while it is free, so that labels do not jump; otherwise the
    /// first free one.
    pub(super) fn place_stable(
        &mut self,
        last: &mut Option<usize>,
        choices: &[PixelBox],
    ) -> Option<PixelBox> {
        let kept = last.filter(|index| choices.get(*index).is_some_and(|wanted| self.is_free(*wanted)));
        *last = kept.or_else(|| choices.iter().position(|wanted| self.is_free(*wanted)));
        let chosen = last.map(|index| choices[index])?;
        self.reserve(chosen);
        Some(chosen)
    }
}
