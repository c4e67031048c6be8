//! A session in front of a tracker, told in bytes: pictures of any size, selections, times and priors.
//!
//! Every string of bytes is a session, so that a fuzzer needs no grammar; one that ends early goes on in
//! zeros for the step at hand and ends. Pictures are small, so that there are many sessions a second.

use std::sync::Arc;
use std::time::Duration;

use barrelman_vision::{CamShift, CamShiftConfig, Explanation, FusedConfig, FusedTracker, Tracker};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{
    Localisation, MotionPrior, Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame,
};

/// Most steps of a session: bounds its time.
const STEPS: usize = 24;

/// The bytes that are left.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    fn eight(&mut self) -> u64 {
        u64::from_le_bytes(core::array::from_fn(|_| self.byte()))
    }

    /// Mostly a number around a picture, now and then any at all.
    fn number(&mut self) -> f64 {
        match self.byte() {
            0..=159 => f64::from(self.byte()),
            160..=199 => f64::from(self.byte()) - 128.5,
            200..=219 => f64::from(self.byte()) / 64.0,
            220..=229 => -f64::from(self.byte()) * 1e6,
            _ => f64::from_bits(self.eight()),
        }
    }

    fn frame(&mut self, now: &mut u64) -> VideoFrame {
        let kind = self.byte();
        let side = |byte: u8| if byte < 8 { u32::from(byte) } else { u32::from(byte) % 96 };
        let size = PictureSize::new(side(self.byte()), side(self.byte()));
        let colour = ColourEncoding {
            matrix: if kind & 1 == 0 { ColourMatrix::Bt601 } else { ColourMatrix::Bt709 },
            range: if kind & 2 == 0 { SampleRange::Limited } else { SampleRange::Full },
        };
        *now = match kind >> 6 {
            0 | 1 => now.saturating_add(33_000_000),
            2 => now.saturating_add(u64::from(self.byte()) * 50_000_000),
            _ => self.eight(),
        };
        let mut picture = Picture::black(size, colour);
        paint(&mut picture, (kind >> 2) & 3, core::array::from_fn(|_| self.byte()));
        let capture = Capture { at: Timestamp::from_nanos(*now), quality: CaptureQuality::Arrival };
        VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }
    }
}

/// One colour, noise, a ramp, or a box of one colour on noise.
fn paint(picture: &mut Picture, kind: u8, [a, b, c, d]: [u8; 4]) {
    let size = picture.size();
    let (width, chroma) = (size.width as usize, picture.chroma_size().width as usize);
    let mut state = u32::from_le_bytes([a, b, c, d]);
    for (plane, (samples, (length, step))) in
        picture.planes_mut().into_iter().zip([(width, 1), (chroma, 2), (chroma, 2)]).enumerate()
    {
        for (index, slot) in samples.iter_mut().enumerate() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (state >> 24) as u8;
            let (column, row) = (step * (index % length), step * (index / length));
            let from = |start: u8| usize::from(start)..usize::from(start) + usize::from(c % 64) + 1;
            *slot = match kind {
                0 => [a, b, c][plane],
                1 => noise,
                2 => (column as u8).wrapping_mul(a).wrapping_add((row as u8).wrapping_mul(b)),
                _ if from(a % 96).contains(&column) && from(b % 96).contains(&row) => {
                    [d, 90, 240][plane].wrapping_add(noise >> 5)
                }
                _ => noise >> 1,
            };
        }
    }
}

/// Both trackers through the session that the bytes tell.
///
/// # Panics
/// If a tracker panics or says something that is not in order.
pub fn session(bytes: &[u8]) {
    let trackers: [Box<dyn Tracker>; 2] = [
        Box::new(CamShift::new(CamShiftConfig::default()).expect("its own defaults")),
        Box::new(FusedTracker::new(FusedConfig::default()).expect("its own defaults")),
    ];
    for mut tracker in trackers {
        follow(tracker.as_mut(), bytes);
    }
}

fn follow(tracker: &mut dyn Tracker, bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    let mut explanation = Explanation::default();
    let (mut seeded, mut now) = (false, 0);
    for _ in 0..STEPS {
        if bytes.0.is_empty() {
            return;
        }
        let frame = bytes.frame(&mut now);
        let what = bytes.byte();
        if !seeded && what > 8 || what >= 240 {
            let selection =
                PixelBox { u: bytes.number(), v: bytes.number(), w: bytes.number(), h: bytes.number() };
            if let Ok(report) = tracker.select(&frame, selection) {
                seeded = true;
                in_order(&report.localisation, &frame);
                let shares = [report.coloured_share, report.surroundings_probability];
                assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{report:?}");
            }
            continue;
        }
        let prior = (what >= 128).then(|| MotionPrior {
            scale: bytes.number(),
            shift_u_px: bytes.number(),
            shift_v_px: bytes.number(),
            std_dev_px: bytes.number(),
            interval: Duration::from_millis(33),
        });
        match tracker.track(&frame, prior.as_ref()) {
            Track::Unseeded => assert!(!seeded),
            Track::Tracking(here) | Track::Coasting(here) => {
                assert!(seeded);
                in_order(&here, &frame);
            }
            Track::Lost { confidence, .. } => assert!(seeded && (0.0..=1.0).contains(&confidence)),
        }
        tracker.explain(&mut explanation);
        assert!((0.0..=1.0).contains(&explanation.confidence));
        for grey in [&explanation.back_projection, &explanation.response] {
            assert_eq!(grey.samples.len(), grey.width * grey.height);
        }
    }
}

fn in_order(here: &Localisation, frame: &VideoFrame) {
    assert_eq!((here.captured, here.picture), (frame.capture.at, frame.picture.size()));
    assert!(here.centre.u.is_finite() && here.centre.v.is_finite(), "{here:?}");
    let (picture, seen) = (here.picture.bounds(), here.bounds);
    // A box is stored as a corner and a size: their sum may be off by the last bit.
    let inside =
        |from: f64, length: f64, whole: f64| from >= 0.0 && length >= 0.0 && from + length <= whole + 1e-9;
    assert!(inside(seen.u, seen.w, picture.w) && inside(seen.v, seen.h, picture.h), "{here:?}");
    assert!((0.0..=1.0).contains(&here.confidence), "{here:?}");
    if let Some(shape) = here.shape {
        let lengths = shape.minor_px >= 0.0 && shape.major_px >= shape.minor_px && shape.major_px.is_finite();
        assert!(lengths && (0.0..core::f64::consts::PI).contains(&shape.axis.radians()), "{here:?}");
    }
    let turn = 0.0..core::f64::consts::TAU;
    assert!(here.heading.is_none_or(|heading| turn.contains(&heading.radians())), "{here:?}");
}
