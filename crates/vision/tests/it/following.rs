//! Tracks of CamShift over several frames.

use core::time::Duration;
use std::sync::Arc;

use barrelman_vision::{BELOW_FLOORS, CamShift, CamShiftConfig, Explanation, Floors, Tracker, YuvToHue};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{Localisation, MotionPrior, PixelBox, Timestamp, Track, VideoFrame};

use crate::scenes::{BLACK, BLUE, GREY, ORANGE_RED, RED, Yuv, at_ms, frame, pixels};

const SIZE: (u32, u32) = (320, 240);

fn seeded(scene: &VideoFrame, selection: PixelBox) -> CamShift {
    let mut tracker = CamShift::new(CamShiftConfig::default()).unwrap();
    tracker.select(scene, selection).unwrap();
    tracker
}

fn boat(colour: Yuv, left: usize, top: usize) -> VideoFrame {
    frame(SIZE, BLUE, &[(colour, [left, top, 40, 20])])
}

fn tracked(track: Track) -> Localisation {
    match track {
        Track::Tracking(localisation) => localisation,
        other => panic!("not tracking: {other:?}"),
    }
}

#[test]
fn a_boat_is_followed_across_the_picture() {
    let mut tracker = seeded(&boat(RED, 20, 30), pixels(20.0, 30.0, 40.0, 20.0));
    for step in 1..20 {
        let (left, top) = (20 + 12 * step, 30 + 8 * step);
        let here = tracked(tracker.track(&boat(RED, left, top), None));
        assert!((here.centre.u - (left as f64 + 20.0)).abs() < 0.01, "{step}: {:?}", here.centre);
        assert!((here.centre.v - (top as f64 + 10.0)).abs() < 0.01, "{step}: {:?}", here.centre);
        // A uniform box of length l has an axis of 4 l / sqrt(12), 1.155 l.
        let shape = here.shape.unwrap();
        assert!((shape.major_px - 46.18).abs() < 0.1 && (shape.minor_px - 23.07).abs() < 0.1, "{shape:?}");
        assert_eq!(here.heading, None);
    }
}

#[test]
fn red_is_one_hue_on_both_sides_of_the_wrap() {
    // The selection is half crimson, half vermilion: bins 15 and 0.
    let crimson: Yuv = [81, 100, 240];
    let both = |left: usize| {
        frame(SIZE, BLUE, &[(crimson, [left, 60, 20, 20]), (ORANGE_RED, [left + 20, 60, 20, 20])])
    };
    let mut tracker = seeded(&both(100), pixels(100.0, 60.0, 40.0, 20.0));
    let mut out = Explanation::default();
    tracker.explain(&mut out);
    assert_eq!(out.histogram[0], 255);
    assert_eq!(out.histogram[15], 255);
    let here = tracked(tracker.track(&both(110), None));
    assert!((here.centre.u - 130.0).abs() < 0.01, "{:?}", here.centre);
}

#[test]
fn a_target_without_colour_in_the_window_is_lost_since_the_first_such_frame() {
    let mut tracker = seeded(&boat(RED, 100, 60), pixels(100.0, 60.0, 40.0, 20.0));
    let gone = frame(SIZE, BLUE, &[]);
    let since = Timestamp::from_nanos(40_000_000);
    for milliseconds in [40, 80, 120] {
        let track = tracker.track(&at_ms(gone.clone(), milliseconds), None);
        assert_eq!(track, Track::Lost { since, confidence: 0.0 });
    }
}

#[test]
fn a_lost_target_is_found_again_as_the_window_grows() {
    let mut tracker = seeded(&boat(RED, 100, 60), pixels(100.0, 60.0, 40.0, 20.0));
    tracker.track(&frame(SIZE, BLUE, &[]), None);
    let frames = (0..30).find(|_| tracker.track(&boat(RED, 240, 180), None).localisation().is_some());
    // 100 px to the right of the window, 10 px per frame.
    assert!(frames.is_some_and(|frames| (5..15).contains(&frames)), "{frames:?}");
    // Once the window reaches the boat, it covers all of it within a few frames.
    for _ in 0..5 {
        tracker.track(&boat(RED, 240, 180), None);
    }
    let here = tracked(tracker.track(&boat(RED, 240, 180), None));
    assert!((here.centre.u - 260.0).abs() < 0.01, "{:?}", here.centre);
}

#[test]
fn a_jump_with_the_camera_is_followed_by_the_prior_alone() {
    let prior = |shift_u_px| MotionPrior {
        shift_u_px,
        shift_v_px: 0.0,
        scale: 1.0,
        std_dev_px: 2.0,
        interval: Duration::from_millis(33),
    };
    let selection = pixels(20.0, 60.0, 40.0, 20.0);
    let (before, after) = (boat(RED, 20, 60), boat(RED, 220, 60));
    assert!(matches!(seeded(&before, selection).track(&after, None), Track::Lost { .. }));
    let nonsense = prior(f64::NAN);
    assert!(matches!(seeded(&before, selection).track(&after, Some(&nonsense)), Track::Lost { .. }));
    let here = tracked(seeded(&before, selection).track(&after, Some(&prior(195.0))));
    assert!((here.centre.u - 240.0).abs() < 0.01, "{:?}", here.centre);
}

#[test]
fn a_picture_of_another_size_shows_the_boat_in_the_same_place() {
    let mut tracker = seeded(&boat(RED, 100, 60), pixels(100.0, 60.0, 40.0, 20.0));
    let doubled = frame((640, 480), BLUE, &[(RED, [200, 120, 80, 40])]);
    let here = tracked(tracker.track(&doubled, None));
    assert_eq!((here.picture.width, here.picture.height), (640, 480));
    assert!((here.centre.u - 240.0).abs() < 0.01 && (here.centre.v - 140.0).abs() < 0.01);
}

#[test]
fn the_box_of_a_slanting_boat_holds_all_of_it_and_little_more() {
    // A staircase of 20 x 8 boxes, 4 right and 2 down per step.
    let steps: Vec<_> = (0..16).map(|i| (RED, [100 + 4 * i, 60 + 2 * i, 20, 8])).collect();
    let scene = frame(SIZE, GREY, &steps);
    let whole = pixels(100.0, 60.0, 80.0, 38.0);
    let mut tracker = seeded(&scene, whole);
    for _ in 0..5 {
        tracker.track(&scene, None);
    }
    let here = tracked(tracker.track(&scene, None));
    // The axes of a slab are 4 / sqrt(12) = 1.155 of its length; measured IoU 0.79.
    assert_eq!(here.bounds.intersection(whole), whole);
    assert!(here.bounds.iou(whole) > 0.75, "{} of {whole}", here.bounds);
    let axis = here.shape.unwrap().axis.degrees();
    // Downwards to the right: slightly less than 180 degrees - atan(2/4).
    assert!((152.0..157.0).contains(&axis), "{axis}");
}

#[test]
fn confidence_is_the_mean_weight_in_the_box() {
    let mut tracker = seeded(&boat(RED, 100, 60), pixels(100.0, 60.0, 40.0, 20.0));
    let here = tracked(tracker.track(&boat(RED, 100, 60), None));
    // The box is 46.2 + 3 by 23.1 + 3 pixels, rounded 49 or 50 by 26, of which the boat fills 40 by 20.
    assert!((0.61..0.64).contains(&here.confidence), "{}", here.confidence);
    assert!((here.confidence * here.bounds.area() / 800.0 - 1.0).abs() < 0.02, "{}", here.confidence);
}

#[test]
fn the_margin_of_the_search_changes_no_answer() {
    let path: Vec<_> = (0..12).map(|step| boat(RED, 20 + 20 * step, 30 + 9 * step)).collect();
    let tracks = |search_margin_px| -> Vec<Track> {
        let config = CamShiftConfig { search_margin_px, ..CamShiftConfig::default() };
        let mut tracker = CamShift::new(config).unwrap();
        tracker.select(&path[0], pixels(20.0, 30.0, 40.0, 20.0)).unwrap();
        path.iter().map(|frame| tracker.track(frame, None)).collect()
    };
    assert_eq!(tracks(0), tracks(12));
    assert_eq!(tracks(1000), tracks(12));
}

#[test]
fn an_explanation_shows_the_window_the_back_projection_and_the_histogram() {
    let scene = frame(SIZE, GREY, &[(RED, [100, 60, 40, 20])]);
    let mut tracker = seeded(&scene, pixels(100.0, 60.0, 40.0, 20.0));
    let here = tracked(tracker.track(&scene, None));
    let mut out = Explanation::default();
    tracker.explain(&mut out);
    let window = out.search_window.unwrap();
    assert!(window.iou(here.bounds) > 0.9, "{window} and {}", here.bounds);
    assert_eq!(out.histogram.len(), 16);
    let grey = &out.back_projection;
    assert_eq!(grey.samples.len(), grey.width * grey.height);
    assert_eq!((grey.bounds.w, grey.bounds.h), (grey.width as f64, grey.height as f64));
    for (i, &sample) in grey.samples.iter().enumerate() {
        let (u, v) = (grey.bounds.u + (i % grey.width) as f64, grey.bounds.v + (i / grey.width) as f64);
        let red = (100.0..140.0).contains(&u) && (60.0..80.0).contains(&v);
        assert_eq!(sample, if red { 255 } else { 0 }, "at {u},{v}");
    }
}

#[test]
fn every_pixel_weighs_what_its_hue_weighs_in_the_histogram() {
    // Odd sides, so that the last column and row are half a block each, with samples of every kind.
    let mut scene = frame((61, 45), RED, &[]);
    let mut picture = (*scene.picture).clone();
    let mut rng = SplitMix64::new(1);
    for sample in picture.planes_mut().into_iter().flatten() {
        *sample = (rng.next_u64() >> 56) as u8;
    }
    scene.picture = Arc::new(picture);
    let mut tracker = seeded(&scene, pixels(0.0, 0.0, 61.0, 45.0));
    tracker.track(&scene, None);
    let mut out = Explanation::default();
    tracker.explain(&mut out);
    let grey = &out.back_projection;
    assert_eq!((grey.width, grey.height), (61, 45));

    let config = CamShiftConfig::default();
    let floors = Floors { saturation: config.saturation_floor, value: config.value_floor };
    let hue = YuvToHue::new(scene.picture.colour());
    let (y, u, v) = (scene.picture.y(), scene.picture.u(), scene.picture.v());
    for row in 0..45 {
        for column in 0..61 {
            let yuv = [y.row(row)[column], u.row(row / 2)[column / 2], v.row(row / 2)[column / 2]];
            let weight = match hue.hue_code(yuv, floors) {
                BELOW_FLOORS => 0,
                code => out.histogram[usize::from(code) * 16 / 180],
            };
            assert_eq!(grey.samples[row * 61 + column], weight, "at {column},{row}");
        }
    }
}

#[test]
fn a_black_picture_holds_no_target() {
    let mut tracker = seeded(&boat(RED, 100, 60), pixels(100.0, 60.0, 40.0, 20.0));
    assert!(matches!(tracker.track(&frame(SIZE, BLACK, &[]), None), Track::Lost { .. }));
}
