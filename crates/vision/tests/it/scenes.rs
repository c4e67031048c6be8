//! Small synthetic video frames.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, VideoFrame};

/// Y, U and V of a colour, BT.601 limited range.
pub(crate) type Yuv = [u8; 3];

pub(crate) const RED: Yuv = [81, 90, 240];
pub(crate) const ORANGE_RED: Yuv = [100, 85, 235];
pub(crate) const BLUE: Yuv = [70, 190, 100];
pub(crate) const GREY: Yuv = [120, 128, 128];
pub(crate) const BLACK: Yuv = [16, 128, 128];

/// A frame of one colour with boxes of other colours painted over it in order; chroma in blocks of 2 x 2.
pub(crate) fn frame(size: (u32, u32), water: Yuv, boats: &[(Yuv, [usize; 4])]) -> VideoFrame {
    let size = PictureSize::new(size.0, size.1);
    let mut picture = Picture::black(size, ColourEncoding::assumed_for(PictureSize::new(640, 480)));
    let (width, height) = (size.width as usize, size.height as usize);
    let chroma_width = width.div_ceil(2);
    let [y, u, v] = picture.planes_mut();
    let everything = (water, [0, 0, width, height]);
    for &([luma, cb, cr], [left, top, w, h]) in core::iter::once(&everything).chain(boats) {
        for row in top..(top + h).min(height) {
            for column in left..(left + w).min(width) {
                y[row * width + column] = luma;
                u[row / 2 * chroma_width + column / 2] = cb;
                v[row / 2 * chroma_width + column / 2] = cr;
            }
        }
    }
    let capture = Capture { at: Timestamp::ZERO, quality: CaptureQuality::Sensor };
    VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }
}

/// The same frame, captured at this time.
pub(crate) fn at_ms(mut frame: VideoFrame, milliseconds: u64) -> VideoFrame {
    frame.capture.at = Timestamp::from_nanos(milliseconds * 1_000_000);
    frame
}

pub(crate) const fn pixels(u: f64, v: f64, w: f64, h: f64) -> PixelBox {
    PixelBox { u, v, w, h }
}

/// A picture of patterned water with patterned hulls.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) size: (u32, u32),
    pub(crate) water: Paint,
    /// Shift of the water by the camera since the start, pixels right and down.
    pub(crate) shift: (f64, f64),
    /// Boxes (left, top, width, height) of one paint each, which lie on the water and shift with it.
    pub(crate) clutter: Vec<(Paint, [f64; 4])>,
    /// Painted in this order.
    pub(crate) hulls: Vec<Hull>,
}

/// A colour and the amplitude of its brightness pattern, grey levels.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Paint {
    pub(crate) colour: Yuv,
    pub(crate) contrast: f64,
    /// Seed of the pattern.
    pub(crate) pattern: u32,
}

/// An ellipse with a pattern of its own, which turns and grows with it.
#[derive(Clone, Copy)]
pub(crate) struct Hull {
    pub(crate) paint: Paint,
    pub(crate) centre: (f64, f64),
    pub(crate) length: f64,
    pub(crate) breadth: f64,
    /// Degrees anticlockwise from image right.
    pub(crate) turned_deg: f64,
}

impl Hull {
    /// Position relative to the centre, along and across, in half axes.
    fn local_coordinates(&self, u: f64, v: f64) -> (f64, f64) {
        let (right, down) = (u - self.centre.0, v - self.centre.1);
        let (sin, cos) = libm::sincos(-self.turned_deg.to_radians());
        ((right * cos + down * sin) * 2.0 / self.length, (down * cos - right * sin) * 2.0 / self.breadth)
    }

    /// The upright box around the hull.
    pub(crate) fn bounds(&self) -> PixelBox {
        let (sin, cos) = libm::sincos(self.turned_deg.to_radians());
        let w = libm::hypot(self.length * cos, self.breadth * sin);
        let h = libm::hypot(self.length * sin, self.breadth * cos);
        PixelBox { u: self.centre.0 - 0.5 * w, v: self.centre.1 - 0.5 * h, w, h }
    }
}

impl Paint {
    /// Brightness at a position in blocks of the pattern.
    fn luma(&self, across: f64, down: f64) -> u8 {
        let corner = |column: f64, row: f64| {
            let mut state = (column as i32 as u32).wrapping_mul(73_856_093)
                ^ (row as i32 as u32).wrapping_mul(19_349_663)
                ^ self.pattern.wrapping_mul(83_492_791);
            state = (state ^ (state >> 15)).wrapping_mul(0x2c1b_3c6d);
            state = (state ^ (state >> 12)).wrapping_mul(0x297a_2d39);
            f64::from(state >> 16) / 32_768.0 - 1.0
        };
        let (column, row) = (across.floor(), down.floor());
        let (a, b) = (across - column, down - row);
        let upper = corner(column, row) * (1.0 - a) + corner(column + 1.0, row) * a;
        let lower = corner(column, row + 1.0) * (1.0 - a) + corner(column + 1.0, row + 1.0) * a;
        let level = f64::from(self.colour[0]) + self.contrast * (upper * (1.0 - b) + lower * b);
        level.clamp(16.0, 235.0) as u8
    }
}

/// Side of a block of the water's pattern, pixels.
const BLOCK_PX: f64 = 7.0;
/// Blocks of a hull's pattern per half length.
const HULL_BLOCKS: f64 = 4.0;
/// Period of the water's pattern, pixels.
const TILE: usize = 448;

/// Brightness of one period of the water.
struct Water(Vec<u8>);

thread_local! {
    /// Computed patterns are reused.
    static WATERS: RefCell<Vec<(Paint, Rc<Water>)>> = const { RefCell::new(Vec::new()) };
}

impl Water {
    fn cached(paint: &Paint) -> Rc<Self> {
        WATERS.with_borrow_mut(|waters| {
            if let Some((_, water)) = waters.iter().find(|(known, _)| known == paint) {
                return Rc::clone(water);
            }
            let place = |k: usize| (k as f64 + 0.5) / BLOCK_PX;
            let samples = (0..TILE * TILE).map(|index| paint.luma(place(index % TILE), place(index / TILE)));
            let water = Rc::new(Self(samples.collect()));
            waters.push((*paint, Rc::clone(&water)));
            water
        })
    }

    fn luma(&self, column: i32, row: i32) -> u8 {
        let wrapped = |k: i32| k.rem_euclid(TILE as i32) as usize;
        self.0[wrapped(row) * TILE + wrapped(column)]
    }
}

impl Scene {
    /// Renders the picture, captured at this time.
    pub(crate) fn at_ms(&self, milliseconds: u64) -> VideoFrame {
        let size = PictureSize::new(self.size.0, self.size.1);
        let mut picture = Picture::black(size, ColourEncoding::assumed_for(PictureSize::new(640, 480)));
        let (width, height) = (size.width as usize, size.height as usize);
        let [y, u, v] = picture.planes_mut();
        let chroma_width = width.div_ceil(2);
        let mut paint = |[left, top, right, bottom]: [f64; 4],
                         sample: &dyn Fn(f64, f64) -> Option<(u8, Yuv)>| {
            let whole = |at: f64, length: usize| (at.max(0.0) as usize).min(length);
            for row in whole(top, height)..whole(bottom + 1.0, height) {
                for column in whole(left, width)..whole(right + 1.0, width) {
                    if let Some((luma, [_, cb, cr])) = sample(column as f64 + 0.5, row as f64 + 0.5) {
                        y[row * width + column] = luma;
                        u[row / 2 * chroma_width + column / 2] = cb;
                        v[row / 2 * chroma_width + column / 2] = cr;
                    }
                }
            }
        };
        let (right, down) = (self.shift.0.round(), self.shift.1.round());
        let whole = |at: f64| at.floor() as i32;
        let everything = [-right, -down, width as f64, height as f64];
        for (colour, [left, top, w, h]) in core::iter::once(&(self.water, everything)).chain(&self.clutter) {
            let water = Water::cached(colour);
            let (left, top) = (left + right, top + down);
            let inside = |u: f64, v: f64| (left..left + w).contains(&u) && (top..top + h).contains(&v);
            paint([left, top, left + w, top + h], &|u, v| {
                inside(u, v).then(|| (water.luma(whole(u - right), whole(v - down)), colour.colour))
            });
        }
        for hull in &self.hulls {
            let box_ = hull.bounds();
            paint([box_.u, box_.v, box_.u + box_.w, box_.v + box_.h], &|u, v| {
                let (a, b) = hull.local_coordinates(u, v);
                let slender = hull.breadth / hull.length;
                (a * a + b * b <= 1.0)
                    .then(|| (hull.paint.luma(HULL_BLOCKS * a, HULL_BLOCKS * slender * b), hull.paint.colour))
            });
        }
        let capture = Capture { at: Timestamp::ZERO, quality: CaptureQuality::Sensor };
        at_ms(VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }, milliseconds)
    }
}
