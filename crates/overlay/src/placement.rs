//! Where there is room: boxes that are taken, and the first of some places that is free of them.

use barrelman_vocab::{PixelBox, PixelPoint};

/// What is taken of one picture.
#[derive(Debug, Default)]
pub(super) struct LabelPlacement {
    page: PixelBox,
    gap: f64,
    taken: Vec<PixelBox>,
}

impl LabelPlacement {
    /// Frees everything. `gap` is kept between things that are placed.
    pub(super) fn begin(&mut self, page: PixelBox, gap: f64) {
        self.page = page;
        self.gap = gap;
        self.taken.clear();
    }

    /// The picture.
    pub(super) fn page(&self) -> PixelBox {
        self.page
    }

    /// Takes a box, whether or not it was free.
    pub(super) fn reserve(&mut self, taken: PixelBox) {
        self.taken.push(taken);
    }

    /// Whether a box lies in the picture and meets nothing that is taken. One that covers nothing does not.
    pub(super) fn is_free(&self, wanted: PixelBox) -> bool {
        let inside = !wanted.is_empty() && wanted.intersection(self.page).area() >= wanted.area() - 1e-6;
        let gap = self.gap / 2.0;
        let wide = PixelBox {
            u: wanted.u - gap,
            v: wanted.v - gap,
            w: wanted.w + 2.0 * gap,
            h: wanted.h + 2.0 * gap,
        };
        inside && self.taken.iter().all(|taken| wide.intersection(*taken).is_empty())
    }

    /// Takes the first free one of some places, given by their middles, for a box of that size.
    pub(super) fn place_first(
        &mut self,
        (w, h): (f64, f64),
        middles: impl IntoIterator<Item = PixelPoint>,
    ) -> Option<PixelBox> {
        let around = |middle: PixelPoint| PixelBox { u: middle.u - w / 2.0, v: middle.v - h / 2.0, w, h };
        let free = middles.into_iter().map(around).find(|wanted| self.is_free(*wanted))?;
        self.reserve(free);
        Some(free)
    }

    /// Takes one of some boxes: the one of last time while it is free, so that things do not jump; else the first
    /// that is.
    pub(super) fn place_steadily(
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
