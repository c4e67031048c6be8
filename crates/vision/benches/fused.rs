//! Cost of one frame of the fused tracker, by the size of the target in a 1280x720 picture.
//!
//! Water and target have patterns and different colours, so that no step is skipped: filter, scale, rotation,
//! silhouette, and learning in every frame in which the target is visible. While it is lost, many small
//! objects of its colour on the water provide candidates by colour.

use std::sync::Arc;

use barrelman_vision::{FusedConfig, FusedTracker, PictureGrowth, Tracker};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame};

const SIZE: PictureSize = PictureSize::new(1280, 720);
const FRAME_NS: u64 = 33_333_333;

fn main() {
    divan::main();
}

/// One frame with a visible target of `width` x `width` * 9/16 pixels, which moves back and forth by 1/40 of
/// its width.
#[divan::bench(args = [40, 160, 550])]
fn tracking(bencher: divan::Bencher<'_, '_>, width: u32) {
    let target = target(width);
    let moved = PixelBox { u: target.u + (width / 40) as f64, ..target };
    let frames = [painted(Some(target), false), painted(Some(moved), false)];
    measure(bencher, &frames, target, |track| matches!(track, Track::Tracking(_)));
}

/// One frame while a target that was selected at this size is lost.
#[divan::bench(args = [40, 160, 550])]
fn lost(bencher: divan::Bencher<'_, '_>, width: u32) {
    let target = target(width);
    let frames = [painted(Some(target), false), painted(None, true)];
    measure(bencher, &frames, target, |track| matches!(track, Track::Lost { .. }));
}

/// The growth of the picture, which is measured for a camera that zooms and reports no field of view.
#[divan::bench]
fn growth_of_the_picture(bencher: divan::Bencher<'_, '_>) {
    let frames = [painted(Some(target(160)), false), painted(Some(target(161)), false)];
    let mut growth = PictureGrowth::default();
    let mut turn = 0;
    bencher.bench_local(|| {
        turn = 1 - turn;
        growth.measure(divan::black_box(&frames[turn].picture))
    });
}

fn target(width: u32) -> PixelBox {
    let width = f64::from(width);
    PixelBox { u: 640.0 - 0.5 * width, v: 360.0 - width * 9.0 / 32.0, w: width, h: width * 9.0 / 16.0 }
}

/// Selects on the first frame, runs the frames in turn (for a lost target, only the last) until the track has
/// the wanted state, and measures from there on.
fn measure(
    bencher: divan::Bencher<'_, '_>,
    frames: &[VideoFrame; 2],
    target: PixelBox,
    is_wanted: impl Fn(&Track) -> bool,
) {
    let Ok(mut tracker) = FusedTracker::new(FusedConfig::default()) else {
        return;
    };
    if tracker.select(&frames[0], target).is_err() {
        return;
    }
    let lost = is_wanted(&Track::Lost { since: Timestamp::ZERO, confidence: 0.0 });
    let (mut turn, mut now) = (0, 0);
    let mut next = || {
        turn = if lost { 1 } else { 1 - turn };
        now += FRAME_NS;
        let mut frame = frames[turn].clone();
        frame.capture.at = Timestamp::from_nanos(now);
        tracker.track(divan::black_box(&frame), None)
    };
    let warm = (0..30).map(|_| next()).last();
    assert!(warm.as_ref().is_some_and(&is_wanted), "the track is not in the state to be measured: {warm:?}");
    bencher.bench_local(next);
}

/// Red inside the box, sea blue outside, both with a pattern. `scattered`: another pattern, with red spots on
/// the water.
fn painted(target: Option<PixelBox>, scattered: bool) -> VideoFrame {
    let mut picture = Picture::black(SIZE, ColourEncoding::assumed_for(SIZE));
    let inside =
        |u: f64, v: f64| target.is_some_and(|t| t.u <= u && u < t.u + t.w && t.v <= v && v < t.v + t.h);
    let pattern = |u: f64, v: f64, seed: u32| {
        let mut state = ((u / 6.0).floor() as i32 as u32).wrapping_mul(73_856_093)
            ^ ((v / 6.0).floor() as i32 as u32).wrapping_mul(19_349_663)
            ^ seed;
        state = (state ^ (state >> 15)).wrapping_mul(0x2c1b_3c6d);
        (state >> 26) as u8
    };
    let (width, chroma) = (SIZE.width as usize, picture.chroma_size());
    let [y, u, v] = picture.planes_mut();
    for (i, sample) in y.iter_mut().enumerate() {
        let (right, down) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        *sample = match target {
            // The target's pattern moves with it.
            Some(t) if inside(right, down) => 60 + 2 * pattern(right - t.u, down - t.v, 7),
            _ => 80 + pattern(right, down, if scattered { 99 } else { 1 }),
        };
    }
    for i in 0..chroma.area() {
        let (column, row) = (i % chroma.width as usize, i / chroma.width as usize);
        let (right, down) = (2.0 * column as f64 + 1.0, 2.0 * row as f64 + 1.0);
        let spot = scattered && column % 50 < 9 && row % 40 < 5;
        (u[i], v[i]) = if spot || inside(right, down) { (100, 190) } else { (150, 100) };
    }
    let capture = Capture { at: Timestamp::ZERO, quality: CaptureQuality::Sensor };
    VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }
}
