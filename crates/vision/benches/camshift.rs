//! Cost of one frame of CamShift, by the size of the target in a 1280x720 picture.
//!
//! The picture is the worst case for the search: saturated water, and a red target that fills the window and
//! moves between the frames, so that mean shift takes several steps.

use std::sync::Arc;

use barrelman_vision::{CamShift, CamShiftConfig, Tracker};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, VideoFrame};

const SIZE: PictureSize = PictureSize::new(1280, 720);

fn main() {
    divan::main();
}

/// One frame with a target of `width` x `width` * 9/16 pixels, alternating between two frames 1/20 of its
/// width apart. The search window is 1.155 times as long: for the widest target a quarter of the picture.
#[divan::bench(args = [40, 80, 160, 320, 550])]
fn one_frame(bencher: divan::Bencher<'_, '_>, width: u32) {
    let width = f64::from(width);
    let target = PixelBox { u: 300.0, v: 170.0, w: width, h: width * 9.0 / 16.0 };
    let frames = [0.0, 0.05].map(|part| painted(PixelBox { u: target.u + part * width, ..target }));
    let Ok(mut tracker) = CamShift::new(CamShiftConfig::default()) else {
        return;
    };
    if tracker.select(&frames[0], target).is_err() {
        return;
    }
    let mut turn = 0;
    bencher.bench_local(|| {
        turn = 1 - turn;
        tracker.track(divan::black_box(&frames[turn]), None)
    });
}

/// Red inside the box, sea blue outside, both with a texture.
fn painted(target: PixelBox) -> VideoFrame {
    let mut picture = Picture::black(SIZE, ColourEncoding::assumed_for(SIZE));
    let inside =
        |u: f64, v: f64| target.u <= u && u < target.u + target.w && target.v <= v && v < target.v + target.h;
    let (width, chroma) = (SIZE.width as usize, picture.chroma_size());
    let [y, u, v] = picture.planes_mut();
    for (i, sample) in y.iter_mut().enumerate() {
        *sample = 70 + ((i * 7 + i / width * 13) % 32) as u8;
    }
    for i in 0..chroma.area() {
        let (column, row) = (i % chroma.width as usize, i / chroma.width as usize);
        let red = inside(2.0 * column as f64, 2.0 * row as f64);
        let texture = (i % 5) as u8;
        (u[i], v[i]) = if red { (100 + texture, 190 + texture) } else { (150 + texture, 100 + texture) };
    }
    let capture = Capture { at: Timestamp::ZERO, quality: CaptureQuality::Sensor };
    VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }
}
