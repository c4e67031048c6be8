//! No input makes the fused tracker panic, and every answer is valid.

use core::time::Duration;
use std::sync::Arc;

use barrelman_vision::{Explanation, FusedConfig, FusedTracker, SelectionError, Tracker};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{
    Localisation, MotionPrior, Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame,
};
use proptest::prelude::*;

use crate::scenes::pixels;

/// Content of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Content {
    Uniform([u8; 3]),
    Noise(u32),
    /// A red box (left, top, side) on noise.
    Boat(i32, i32, i32),
}

fn frame((width, height): (u32, u32), content: Content, at_ms: u64, colour: ColourEncoding) -> VideoFrame {
    let mut picture = Picture::black(PictureSize::new(width, height), colour);
    let chroma_width = width.div_ceil(2) as usize;
    let mut rng = SplitMix64::new(if let Content::Noise(seed) = content { u64::from(seed) } else { 1 });
    let planes = picture.planes_mut().into_iter().zip([width as usize, chroma_width, chroma_width]);
    for (plane, (samples, row_length)) in planes.enumerate() {
        let pixels_a_sample = if plane == 0 { 1 } else { 2 };
        for (index, slot) in samples.iter_mut().enumerate() {
            let noise = (rng.next_u64() >> 56) as u8;
            let at = |k: usize| k as i32 * pixels_a_sample;
            let (column, row) = (at(index % row_length), at(index / row_length));
            *slot = match content {
                Content::Uniform(yuv) => yuv[plane],
                Content::Noise(_) => noise,
                Content::Boat(left, top, side) => {
                    let inside = (left..left + side).contains(&column) && (top..top + side).contains(&row);
                    if inside { [81 + noise / 8, 90, 240][plane] } else { 64 + noise / 2 }
                }
            };
        }
    }
    let at = Timestamp::from_nanos(at_ms * 1_000_000);
    let capture = Capture { at, quality: CaptureQuality::Arrival };
    VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }
}

const SD: ColourEncoding = ColourEncoding { matrix: ColourMatrix::Bt601, range: SampleRange::Limited };

fn tracker() -> FusedTracker {
    FusedTracker::new(FusedConfig::default()).unwrap()
}

fn check_localisation(here: &Localisation, frame: &VideoFrame) {
    assert_eq!((here.captured, here.picture), (frame.capture.at, frame.picture.size()));
    let picture = here.picture.bounds();
    assert!(here.centre.u.is_finite() && here.centre.v.is_finite(), "{here:?}");
    let box_ = here.bounds;
    // A box is stored as corner and size, so that their sum may be off by the last bit.
    let inside =
        |from: f64, length: f64, whole: f64| from >= 0.0 && length >= 0.0 && from + length <= whole + 1e-9;
    assert!(inside(box_.u, box_.w, picture.w) && inside(box_.v, box_.h, picture.h), "{here:?}");
    assert!((0.0..=1.0).contains(&here.confidence), "{here:?}");
    if let Some(shape) = here.shape {
        assert!(
            shape.minor_px >= 0.0 && shape.major_px >= shape.minor_px && shape.major_px.is_finite(),
            "{here:?}"
        );
        assert!((0.0..core::f64::consts::PI).contains(&shape.axis.radians()), "{here:?}");
    }
    if let Some(heading) = here.heading {
        assert!((0.0..core::f64::consts::TAU).contains(&heading.radians()), "{here:?}");
    }
}

/// Passes a frame to a tracker with a target and checks all of its answers.
fn track_and_check(tracker: &mut FusedTracker, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track {
    let track = tracker.track(frame, prior);
    match &track {
        Track::Tracking(here) | Track::Coasting(here) => check_localisation(here, frame),
        Track::Lost { confidence, .. } => assert!((0.0..=1.0).contains(confidence), "{track:?}"),
        Track::Unseeded => panic!("unseeded after a selection"),
    }
    let mut explanation = Explanation::default();
    tracker.explain(&mut explanation);
    for grey in [&explanation.back_projection, &explanation.response] {
        assert_eq!(grey.samples.len(), grey.width * grey.height);
    }
    assert!((0.0..=1.0).contains(&explanation.confidence), "{explanation:?}");
    track
}

fn select(tracker: &mut FusedTracker, frame: &VideoFrame, selection: PixelBox) -> Result<(), SelectionError> {
    let report = tracker.select(frame, selection)?;
    check_localisation(&report.localisation, frame);
    assert_eq!(report.localisation.bounds, report.used);
    let (right, bottom) = (selection.u + selection.w, selection.v + selection.h);
    let size = frame.picture.size();
    let beyond = right > f64::from(size.width) || bottom > f64::from(size.height);
    assert_eq!(report.is_clipped, selection.u < 0.0 || selection.v < 0.0 || beyond);
    assert!(
        (0.0..=1.0).contains(&report.coloured_share)
            && (0.0..=1.0).contains(&report.surroundings_probability)
    );
    Ok(())
}

/// Selects a box of which some part lies in the picture. Whether it is large enough.
fn is_selected(tracker: &mut FusedTracker, frame: &VideoFrame, selection: PixelBox) -> bool {
    let result = select(tracker, frame, selection);
    let inside = selection.clipped(frame.picture.size());
    match result {
        Ok(()) => assert!(inside.w > 5.0 && inside.h > 3.0, "{selection} is too small"),
        Err(SelectionError::TooSmall { width, height, .. }) => {
            assert_eq!((width, height), (6, 4));
            assert!(inside.w < 7.0 || inside.h < 5.0, "{selection} is not too small");
        }
        Err(error) => panic!("{error}"),
    }
    result.is_ok()
}

const PATTERNED: [Content; 3] = [Content::Noise(5), Content::Boat(20, 12, 14), Content::Noise(6)];
const FLAT: [Content; 3] =
    [Content::Uniform([16, 128, 128]), Content::Uniform([81, 90, 240]), Content::Uniform([255, 255, 255])];

#[test]
fn any_part_of_a_picture_can_be_selected_and_tracked() {
    let (width, height) = (60.0, 44.0);
    let mut selections = vec![
        pixels(0.0, 0.0, width, height),
        pixels(-100.0, -100.0, 1e4, 1e4),
        pixels(0.0, 20.0, width, 1.0),
        pixels(30.0, 0.0, 1.0, height),
        pixels(30.7, 20.2, 1e-9, 1e-9),
        pixels(0.0, 0.0, 1e300, 1e300),
    ];
    for side in [1.0, 3.0, 14.0] {
        // Inside, at each border and corner, and half outside.
        for u in [-0.5 * side, 0.0, 20.0, width - side, width - 0.5 * side] {
            for v in [-0.5 * side, 0.0, 12.0, height - side, height - 0.5 * side] {
                selections.push(pixels(u, v, side, side));
            }
        }
    }
    for (index, selection) in selections.into_iter().enumerate() {
        let (content, flat) = (PATTERNED[index % PATTERNED.len()], FLAT[index % FLAT.len()]);
        let mut tracker = tracker();
        if !is_selected(&mut tracker, &frame((60, 44), content, 0, SD), selection) {
            continue;
        }
        for (step, content) in [content, content, flat, Content::Noise(7), content].into_iter().enumerate() {
            track_and_check(&mut tracker, &frame((60, 44), content, 33 * (step as u64 + 1), SD), None);
        }
    }
}

#[test]
fn a_box_without_area_or_outside_is_refused_and_nothing_is_tracked() {
    let scene = frame((60, 44), PATTERNED[1], 0, SD);
    let mut tracker = tracker();
    for selection in [
        pixels(10.0, 10.0, 0.0, 5.0),
        pixels(10.0, 10.0, 5.0, -5.0),
        pixels(f64::NAN, 10.0, 5.0, 5.0),
        pixels(10.0, 10.0, f64::NAN, 5.0),
        pixels(10.0, f64::NEG_INFINITY, 5.0, 5.0),
        pixels(10.0, 10.0, 5.0, f64::INFINITY),
    ] {
        assert!(
            matches!(select(&mut tracker, &scene, selection), Err(SelectionError::Empty { .. })),
            "{selection}"
        );
    }
    for selection in [
        pixels(60.0, 10.0, 5.0, 5.0),
        pixels(10.0, 44.0, 5.0, 5.0),
        pixels(-5.0, 10.0, 5.0, 5.0),
        pixels(10.0, -1e300, 5.0, 5.0),
        pixels(1e18, 1e18, 5.0, 5.0),
    ] {
        assert!(
            matches!(select(&mut tracker, &scene, selection), Err(SelectionError::Outside { .. })),
            "{selection}"
        );
    }
    let nothing = frame((0, 0), FLAT[0], 0, SD);
    assert!(matches!(
        select(&mut tracker, &nothing, pixels(0.0, 0.0, 5.0, 5.0)),
        Err(SelectionError::Outside { .. })
    ));
    assert_eq!(tracker.track(&scene, None), Track::Unseeded);
}

#[test]
fn pictures_of_a_few_pixels_are_pictures() {
    for size in [(1, 1), (2, 2), (3, 1), (1, 3), (1, 40), (40, 1), (5, 4), (6, 4), (40, 4), (6, 40)] {
        for content in PATTERNED {
            let mut tracker = tracker();
            let whole = pixels(0.0, 0.0, f64::from(size.0), f64::from(size.1));
            if !is_selected(&mut tracker, &frame(size, content, 0, SD), whole) {
                continue;
            }
            for step in 1..4 {
                track_and_check(&mut tracker, &frame(size, content, 33 * step, SD), None);
            }
            track_and_check(&mut tracker, &frame(size, FLAT[1], 133, SD), None);
            track_and_check(&mut tracker, &frame(size, content, 166, SD), None);
        }
    }
}

#[test]
fn what_has_no_pattern_can_be_selected() {
    for content in FLAT {
        for selection in
            [pixels(0.0, 0.0, 60.0, 44.0), pixels(20.0, 12.0, 14.0, 14.0), pixels(3.0, 3.0, 6.0, 4.0)]
        {
            let mut tracker = tracker();
            select(&mut tracker, &frame((60, 44), content, 0, SD), selection).unwrap();
            for (step, content) in [content, content, FLAT[0], PATTERNED[0], content].into_iter().enumerate()
            {
                track_and_check(&mut tracker, &frame((60, 44), content, 33 * (step as u64 + 1), SD), None);
            }
        }
    }
}

#[test]
fn a_selection_of_a_few_pixels_is_refused_and_the_earlier_target_kept() {
    let scene = frame((60, 44), PATTERNED[1], 0, SD);
    let mut tracker = tracker();
    select(&mut tracker, &scene, pixels(20.0, 12.0, 14.0, 14.0)).unwrap();
    for selection in [
        pixels(30.2, 20.1, 1e-9, 1e-9),
        pixels(20.0, 12.0, 5.0, 14.0),
        pixels(20.0, 12.0, 14.0, 3.0),
        // Large enough, but not in the picture.
        pixels(-9.0, 3.0, 14.0, 20.0),
    ] {
        assert!(!is_selected(&mut tracker, &scene, selection), "{selection}");
        track_and_check(&mut tracker, &scene, None);
    }
}

#[test]
fn a_target_may_become_ten_times_as_large_or_as_small() {
    for (from, factor) in [(8.0, 1.08_f64), (80.0, 1.0 / 1.08)] {
        let mut tracker = tracker();
        let boat = |side: f64, at_ms| {
            let (left, top) = (50.0 - 0.5 * side, 45.0 - 0.5 * side);
            frame((100, 90), Content::Boat(left as i32, top as i32, side as i32), at_ms, SD)
        };
        let mut side: f64 = from;
        let selection = pixels(50.0 - 0.5 * side, 45.0 - 0.5 * side, side, side);
        select(&mut tracker, &boat(side, 0), selection).unwrap();
        for step in 1..=30 {
            side *= factor;
            track_and_check(&mut tracker, &boat(side, 33 * step), None);
        }
    }
}

#[test]
fn a_picture_may_become_one_of_any_other_size() {
    let sizes = [(60, 44), (1, 1), (120, 3), (3, 120), (44, 60), (2, 2), (400, 300), (59, 43)];
    for from in sizes {
        for to in sizes.into_iter().chain([(0, 0), (60, 0), (0, 3)]) {
            let mut tracker = tracker();
            let (w, h) = (f64::from(from.0), f64::from(from.1));
            let selection = pixels(0.2 * w, 0.2 * h, 0.5 * w, 0.5 * h);
            if !is_selected(&mut tracker, &frame(from, PATTERNED[0], 0, SD), selection) {
                continue;
            }
            for (step, size) in [from, to, to, from].into_iter().enumerate() {
                track_and_check(&mut tracker, &frame(size, PATTERNED[0], 33 * step as u64 + 33, SD), None);
            }
        }
    }
}

#[test]
fn time_may_stand_still_leap_and_run_backwards() {
    for times_ms in [
        [33, 66, 1066, 1100, 101_100, 101_133],
        [33, 33, 33, 33, 33, 33],
        [100_000, 50_000, 10, 5, 0, 33],
        [0, u64::MAX / 2_000_000, 0, u64::MAX / 1_000_000, 1, 2],
    ] {
        for content in PATTERNED {
            let mut tracker = tracker();
            select(&mut tracker, &frame((60, 44), content, 50, SD), pixels(20.0, 12.0, 14.0, 14.0)).unwrap();
            for (step, at_ms) in times_ms.into_iter().enumerate() {
                let content = if step == 3 { Content::Noise(77) } else { content };
                track_and_check(&mut tracker, &frame((60, 44), content, at_ms, SD), None);
            }
        }
    }
}

#[test]
fn a_prior_that_is_not_a_number_is_ignored() {
    let boat = |at_ms| frame((120, 90), Content::Boat(40, 30, 24), at_ms, SD);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for which in 0..3 {
            let mut tracker = tracker();
            select(&mut tracker, &boat(0), pixels(40.0, 30.0, 24.0, 24.0)).unwrap();
            for step in 1..6 {
                let mut numbers = [0.0, 0.0, 1.0];
                numbers[which] = bad;
                let track = track_and_check(&mut tracker, &boat(33 * step), Some(&prior(numbers)));
                assert!(matches!(track, Track::Tracking(_)), "{bad} {which}: {track:?}");
            }
        }
    }
}

fn prior([shift_u_px, shift_v_px, std_dev_px]: [f64; 3]) -> MotionPrior {
    MotionPrior { shift_u_px, shift_v_px, scale: 1.0, std_dev_px, interval: Duration::ZERO }
}

#[test]
fn the_tracker_recovers_from_a_wrong_prior_of_any_size() {
    let boat = |at_ms| frame((120, 90), Content::Boat(40, 30, 24), at_ms, SD);
    for huge in [1e3, -1e3, 1e6, -1e9, 1e100, -1e150, 1e160, f64::MAX, f64::MIN] {
        for numbers in [[huge, 0.0, 1.0], [0.0, huge, 0.0], [0.0, 0.0, huge], [huge, huge, huge]] {
            let mut tracker = tracker();
            select(&mut tracker, &boat(0), pixels(40.0, 30.0, 24.0, 24.0)).unwrap();
            track_and_check(&mut tracker, &boat(33), None);
            track_and_check(&mut tracker, &boat(66), Some(&prior(numbers)));
            let found = (3..90).any(|step| {
                matches!(track_and_check(&mut tracker, &boat(33 * step), None), Track::Tracking(_))
            });
            assert!(found, "{numbers:?}");
        }
    }
}

fn any_content() -> impl Strategy<Value = Content> {
    prop_oneof![
        any::<[u8; 3]>().prop_map(Content::Uniform),
        any::<u32>().prop_map(Content::Noise),
        (-20..70i32, -20..50i32, 1..60i32).prop_map(|(left, top, side)| Content::Boat(left, top, side)),
    ]
}

fn any_frame() -> impl Strategy<Value = VideoFrame> {
    let encoding = (any::<bool>(), any::<bool>()).prop_map(|(high, full)| ColourEncoding {
        matrix: if high { ColourMatrix::Bt709 } else { ColourMatrix::Bt601 },
        range: if full { SampleRange::Full } else { SampleRange::Limited },
    });
    let at_ms = prop_oneof![8 => 0..2000u64, 1 => any::<u64>().prop_map(|at| at / 1_000_000)];
    ((0..70u32, 0..50u32), any_content(), at_ms, encoding)
        .prop_map(|(size, content, at_ms, encoding)| frame(size, content, at_ms, encoding))
}

/// Numbers around a picture, and occasionally invalid ones.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -20.0..90.0f64,
        4 => prop::sample::select(vec![0.0, 1.0, 3.0, 70.0]),
        1 => prop::num::f64::ANY,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn any_selection_on_any_frames_gives_a_valid_answer(
        frames in prop::collection::vec(any_frame(), 1..8),
        selections in prop::array::uniform2((any_number(), any_number(), any_number(), any_number())),
        numbers in prop::array::uniform3(any_number()),
    ) {
        let mut tracker = tracker();
        let mut seeded = false;
        for (index, frame) in frames.iter().enumerate() {
            if index % 4 == 0 {
                let (u, v, w, h) = selections[index / 4];
                seeded |= select(&mut tracker, frame, pixels(u, v, w, h)).is_ok();
            }
            let prior = prior(numbers);
            let prior = (index % 2 == 1).then_some(&prior);
            if seeded {
                track_and_check(&mut tracker, frame, prior);
            } else {
                prop_assert_eq!(tracker.track(frame, prior), Track::Unseeded);
            }
        }
    }
}
