//! How much each pixel is like the target: the weight of its hue in the target's histogram.
//!
//! The back projection is a map as large as the picture of which only what is asked for is worked out: a box that
//! starts as the first search window and grows as the search moves. So a search sees exactly what it would see on
//! the whole picture, for the cost of the pixels that it visits. Work: every pixel at most once per frame, and only
//! those of the box around all windows visited, enlarged by the margin where it had to grow.

use barrelman_vocab::{Picture, PictureSize};

use crate::hue::{Floors, HueOfYuv};
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

    pub(crate) fn look<'a>(&'a mut self, at: &'a Look<'a>) -> LookedAt<'a> {
        LookedAt { map: self, at }
    }

    fn cover(&mut self, window: Window, at: &Look<'_>) {
        if self.known.covers(window) {
            return;
        }
        if self.known.is_empty() {
            self.work_out(window, at);
            self.known = window;
            return;
        }
        let (old, new) = (self.known, self.known.union(window.inflated(at.margin, self.width, self.height)));
        let above = Window { h: old.y - new.y, ..new };
        let below = Window { y: old.bottom(), h: new.bottom() - old.bottom(), ..new };
        let left = Window { x: new.x, w: old.x - new.x, ..old };
        let right = Window { x: old.right(), w: new.right() - old.right(), ..old };
        for missing in [above, below, left, right] {
            self.work_out(missing, at);
        }
        self.known = new;
    }

    fn work_out(&mut self, window: Window, at: &Look<'_>) {
        let (weights, width) = (&mut self.weights, self.width);
        at.hue.codes(at.picture, window, at.floors, |x, y, codes| {
            let row = &mut weights[y * width + x..][..codes.len()];
            for (weight, &code) in row.iter_mut().zip(codes) {
                *weight = at.weight_of[usize::from(code)];
            }
        });
    }
}

/// What a back projection is taken of, and how.
pub(crate) struct Look<'a> {
    pub(crate) picture: &'a Picture,
    pub(crate) hue: &'a HueOfYuv,
    pub(crate) floors: Floors,
    /// Weight of every hue code.
    pub(crate) weight_of: &'a [u8; 256],
    /// Pixels worked out beyond what is needed where the box has to grow.
    pub(crate) margin: usize,
}

/// A back projection that works out what is asked of it.
pub(crate) struct LookedAt<'a> {
    map: &'a mut BackProjection,
    at: &'a Look<'a>,
}

impl Mass for LookedAt<'_> {
    fn width(&self) -> usize {
        self.map.width
    }

    fn height(&self) -> usize {
        self.map.height
    }

    fn moments(&mut self, window: Window) -> Moments {
        let window = window.clipped(self.map.width, self.map.height);
        self.map.cover(window, self.at);
        ByteMap::new(&self.map.weights, self.map.width, self.map.height).moments(window)
    }
}
