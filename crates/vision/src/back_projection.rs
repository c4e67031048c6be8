//! The back projection: for each pixel, the weight of its hue in the target's histogram.
//!
//! The map has the size of the picture, but only the required part is computed: a box that starts as the
//! first search window and grows with the search. A search therefore gives the same result as on the whole
//! picture, for the cost of the pixels it visits. Work: every pixel at most once per frame, and only inside
//! the box around all visited windows, enlarged by the margin where it had to grow.

use barrelman_vocab::{Picture, PictureSize};

use crate::hue_weight_table::HueWeightTable;
use crate::moments::{MomentSource, Moments, WeightMap};
use crate::window::Window;

/// The weights and the part of them that is computed.
#[derive(Debug, Default)]
pub(crate) struct BackProjection {
    weights: Vec<u8>,
    width: usize,
    height: usize,
    computed: Window,
}

impl BackProjection {
    /// Discards all weights, for a new frame of this size. Allocates only if the size grows.
    pub(crate) fn reset(&mut self, size: PictureSize) {
        (self.width, self.height) = (size.width as usize, size.height as usize);
        self.weights.resize(size.area(), 0);
        self.computed = Window::default();
    }

    /// The part computed since the last reset.
    pub(crate) const fn computed(&self) -> Window {
        self.computed
    }

    /// The computed weights of one row; `row` is counted from the picture's top.
    pub(crate) fn computed_row(&self, row: usize) -> &[u8] {
        &self.weights[row * self.width + self.computed.x..][..self.computed.w]
    }

    /// The back projection of one picture, which has the size of the last reset and the encoding of `table`.
    /// Where the computed part has to grow, it grows by `margin` pixels more than needed.
    pub(crate) fn lazy<'a>(
        &'a mut self,
        picture: &'a Picture,
        table: &'a mut HueWeightTable,
        margin: usize,
    ) -> LazyBackProjection<'a> {
        LazyBackProjection { map: self, picture, table, margin }
    }
}

/// A back projection that computes its weights on demand.
pub(crate) struct LazyBackProjection<'a> {
    map: &'a mut BackProjection,
    picture: &'a Picture,
    table: &'a mut HueWeightTable,
    margin: usize,
}

impl LazyBackProjection<'_> {
    /// Sum of the weights over the part of `window` in the map: `m00` of the moments, at lower cost.
    pub(crate) fn weight_sum(&mut self, window: Window) -> u64 {
        let window = window.clipped(self.map.width, self.map.height);
        if window.is_empty() {
            return 0;
        }
        self.ensure_computed(window);
        let rows = self.map.weights.chunks_exact(self.map.width).skip(window.y).take(window.h);
        let sum =
            |row: &[u8]| row[window.x..window.right()].iter().map(|&weight| u32::from(weight)).sum::<u32>();
        rows.map(|row| u64::from(sum(row))).sum()
    }

    fn ensure_computed(&mut self, window: Window) {
        let (width, height) = (self.map.width, self.map.height);
        let computed = self.map.computed;
        if computed.contains(window) {
            return;
        }
        let new = if computed.is_empty() {
            window.aligned_to_chroma_blocks(width, height)
        } else {
            computed
                .union(window.inflated(self.margin, width, height).aligned_to_chroma_blocks(width, height))
        };
        for missing in new.difference(computed) {
            self.compute(missing);
        }
        self.map.computed = new;
    }

    /// Computes the weights of a window on whole 2 x 2 blocks.
    fn compute(&mut self, window: Window) {
        if window.is_empty() {
            return;
        }
        let (luma, u_plane, v_plane) = (self.picture.y(), self.picture.u(), self.picture.v());
        let chroma = window.x / 2..window.right().div_ceil(2);
        let columns = window.x..window.right();
        let rows = &mut self.map.weights[window.y * self.map.width..window.bottom() * self.map.width];
        for (i, pair) in rows.chunks_mut(2 * self.map.width).enumerate() {
            let row = window.y + 2 * i;
            let us = &u_plane.row(row / 2)[chroma.clone()];
            let vs = &v_plane.row(row / 2)[chroma.clone()];
            let (upper, lower) = pair.split_at_mut(self.map.width);
            let upper = (&luma.row(row)[columns.clone()], &mut upper[columns.clone()]);
            // The last row of a picture of odd height has no partner.
            let lower = match lower.get_mut(columns.clone()) {
                Some(lower) => (&luma.row(row + 1)[columns.clone()], lower),
                None => (&[][..], &mut [][..]),
            };
            self.table.fill_weights(us, vs, [upper, lower]);
        }
    }
}

impl MomentSource for LazyBackProjection<'_> {
    fn width(&self) -> usize {
        self.map.width
    }

    fn height(&self) -> usize {
        self.map.height
    }

    fn moments(&mut self, window: Window) -> Moments {
        let window = window.clipped(self.map.width, self.map.height);
        self.ensure_computed(window);
        WeightMap::new(&self.map.weights, self.map.width, self.map.height).moments(window)
    }
}
