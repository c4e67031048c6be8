//! Small painted frames to track on.

use std::sync::Arc;

use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, VideoFrame};

/// Y, U and V of a colour, BT.601 in limited range.
pub(crate) type Yuv = [u8; 3];

pub(crate) const RED: Yuv = [81, 90, 240];
pub(crate) const ORANGE_RED: Yuv = [100, 85, 235];
pub(crate) const BLUE: Yuv = [70, 190, 100];
pub(crate) const GREY: Yuv = [120, 128, 128];
pub(crate) const BLACK: Yuv = [16, 128, 128];

/// A frame of one colour with boxes of others painted over it in order; chroma goes by blocks of 2 x 2.
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

/// The same frame, captured so many milliseconds after the start.
pub(crate) fn at_ms(mut frame: VideoFrame, milliseconds: u64) -> VideoFrame {
    frame.capture.at = Timestamp::from_nanos(milliseconds * 1_000_000);
    frame
}

pub(crate) const fn pixels(u: f64, v: f64, w: f64, h: f64) -> PixelBox {
    PixelBox { u, v, w, h }
}
