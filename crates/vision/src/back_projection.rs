//! How much each pixel is like the target: the weight of its hue in the target's histogram.
//!
//! The back projection is a map as large as the picture of which only what is asked for is worked out: a box that
//! starts as the first search window and grows as the search moves. So a search sees exactly what it would see on
//! the whole picture, for the cost of the pixels that it visits. Work: every pixel at most once per frame, and only
//! those of the box around all windows visited, enlarged by the margin where it had to grow.

use barrelman_vocab::{Picture, PictureSize};

use crate::likeness::Likeness;
use crate::moments::{ByteMap, Mass, Moments};
use crate::window::Window;

/// The map and what is known of it.
#[derive(Debug, Default)]
pub(crate) struct BackProjection {
    weights: Vec<u8>,
    width: usize,
    height: usize,
    known: Window,
}

impl BackProjection {
    /// Forgets everything, for a new frame of that size. Allocates only where the size grows.
    pub(crate) fn restart(&mut self, size: PictureSize) {
        (self.width, self.height) = (size.width as usize, size.height as usize);
        self.weights.resize(size.area(), 0);
        self.known = Window::default();
    }

    /// What was worked out since the last restart.
    pub(crate) const fn known(&self) -> Window {
        self.known
    }

    /// The weights of one row of what is known, `row` counted from the picture's top.
    pub(crate) fn known_row(&self, row: usize) -> &[u8] {
        &self.weights[row * self.width + self.known.x..][..self.known.w]
    }

    /// The map as seen on one picture, which has the size of the last restart and the encoding of `likeness`.
    /// Where the known box has to grow, `margin` pixels more than needed are worked out.
    pub(crate) fn look<'a>(
        &'a mut self,
        picture: &'a Picture,
        likeness: &'a mut Likeness,
        margin: usize,
    ) -> Look<'a> {
        Look { map: self, picture, likeness, margin }
    }
}

/// A back projection that works out what is asked of it.
pub(crate) struct Look<'a> {
    map: &'a mut BackProjection,
    picture: &'a Picture,
    likeness: &'a mut Likeness,
    margin: usize,
}

impl Look<'_> {
    /// The sum of the weights over the part of `window` that lies in the map: `m00` of the moments, for less.
    pub(crate) fn mass(&mut self, window: Window) -> u64 {
        let window = window.clipped(self.map.width, self.map.height);
        if window.is_empty() {
            return 0;
        }
        self.cover(window);
        let rows = self.map.weights.chunks_exact(self.map.width).skip(window.y).take(window.h);
        let sum =
            |row: &[u8]| row[window.x..window.right()].iter().map(|&weight| u32::from(weight)).sum::<u32>();
        rows.map(|row| u64::from(sum(row))).sum()
    }

    fn cover(&mut self, window: Window) {
        let (width, height) = (self.map.width, self.map.height);
        let known = self.map.known;
        if known.covers(window) {
            return;
        }
        let new = if known.is_empty() {
            window.on_blocks(width, height)
        } else {
            known.union(window.inflated(self.margin, width, height).on_blocks(width, height))
        };
        for missing in new.without(known) {
            self.work_out(missing);
        }
        self.map.known = new;
    }

    /// Works out a window that lies on whole 2 x 2 blocks.
    fn work_out(&mut self, window: Window) {
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
            // An odd picture's last row stands alone.
            let lower = match lower.get_mut(columns.clone()) {
                Some(lower) => (&luma.row(row + 1)[columns.clone()], lower),
                None => (&[][..], &mut [][..]),
            };
            self.likeness.weigh(us, vs, [upper, lower]);
        }
    }
}

impl Mass for Look<'_> {
    fn width(&self) -> usize {
        self.map.width
    }

    fn height(&self) -> usize {
        self.map.height
    }

    fn moments(&mut self, window: Window) -> Moments {
        let window = window.clipped(self.map.width, self.map.height);
        self.cover(window);
        ByteMap::new(&self.map.weights, self.map.width, self.map.height).moments(window)
    }
}
