//! No input makes CamShift panic, and every answer is valid.

use std::sync::Arc;

use barrelman_vision::{CamShift, CamShiftConfig, Explanation, Tracker};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{
    Localisation, MotionPrior, Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame,
};
use proptest::prelude::*;

/// A picture of one colour or of noise, 0 to 70 x 0 to 50 pixels.
fn any_frame() -> impl Strategy<Value = VideoFrame> {
    let encoding = (any::<bool>(), any::<bool>()).prop_map(|(high, full)| ColourEncoding {
        matrix: if high { ColourMatrix::Bt709 } else { ColourMatrix::Bt601 },
        range: if full { SampleRange::Full } else { SampleRange::Limited },
    });
    (0..70u32, 0..50u32, encoding, any::<[u8; 3]>(), any::<bool>()).prop_map(
        |(width, height, colour, yuv, noise)| {
            let mut picture = Picture::black(PictureSize::new(width, height), colour);
            let mut rng = SplitMix64::new(u64::from(u32::from_le_bytes([yuv[0], yuv[1], yuv[2], 1])));
            for (plane, sample) in picture.planes_mut().into_iter().zip(yuv) {
                for slot in plane {
                    let random = (rng.next_u64() >> 56) as u8;
                    *slot = if noise { random } else { sample };
                }
            }
            let capture = Capture { at: Timestamp::ZERO, quality: CaptureQuality::Arrival };
            VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }
        },
    )
}

/// Numbers around a picture, and occasionally invalid ones.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -20.0..90.0f64,
        4 => prop::sample::select(vec![0.0, 1.0, 3.0, 70.0]),
        1 => prop::num::f64::ANY,
    ]
}

fn any_box() -> impl Strategy<Value = PixelBox> {
    (any_number(), any_number(), any_number(), any_number()).prop_map(|(u, v, w, h)| PixelBox { u, v, w, h })
}

fn check_localisation(here: &Localisation) {
    let picture = here.picture.bounds();
    assert!(!here.bounds.is_empty(), "{here:?}");
    // A box is stored as corner and size, so that their sum may be off by the last bit.
    let outside = here.bounds.area() - here.bounds.intersection(picture).area();
    assert!(outside.abs() < 1e-9, "{here:?}");
    assert!((0.0..=picture.w).contains(&here.centre.u), "{here:?}");
    assert!((0.0..=picture.h).contains(&here.centre.v), "{here:?}");
    assert!((0.0..=1.0).contains(&here.confidence), "{here:?}");
    let shape = here.shape.unwrap();
    assert!(shape.minor_px >= 0.0 && shape.major_px >= shape.minor_px && shape.major_px.is_finite());
    assert!((0.0..core::f64::consts::PI).contains(&shape.axis.radians()), "{here:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_selection_on_any_frames_gives_a_valid_answer(
        frames in prop::collection::vec(any_frame(), 1..6),
        selection in any_box(),
        shift in (any_number(), any_number()),
        bins in 2..=180usize,
        search_margin_px in 0..40usize,
    ) {
        let config = CamShiftConfig { bins, search_margin_px, ..CamShiftConfig::default() };
        let mut tracker = CamShift::new(config).unwrap();
        let mut explanation = Explanation::default();
        let seeded = tracker.select(&frames[0], selection);
        if let Ok(report) = &seeded {
            check_localisation(&report.localisation);
            prop_assert!((0.0..=1.0).contains(&report.coloured_share) && (0.0..=1.0).contains(&report.surroundings_probability));
        }
        let prior = MotionPrior {
            shift_u_px: shift.0,
            shift_v_px: shift.1,
            scale: 1.0, std_dev_px: 1.0,
            interval: core::time::Duration::ZERO,
        };
        for (i, frame) in frames.iter().enumerate() {
            let track = tracker.track(frame, (i % 2 == 1).then_some(&prior));
            match &track {
                Track::Tracking(here) => check_localisation(here),
                Track::Lost { .. } => prop_assert!(seeded.is_ok()),
                other => prop_assert!(seeded.is_err() && *other == Track::Unseeded),
            }
            tracker.explain(&mut explanation);
            let grey = &explanation.back_projection;
            prop_assert_eq!(grey.samples.len(), grey.width * grey.height);
        }
    }
}
