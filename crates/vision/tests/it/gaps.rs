//! What follows a gap in the video, or the target's leaving: the target is lost until it is recognised and
//! confirmed, and an object like it is not reported for sure.

use barrelman_vision::{FusedConfig, FusedTracker, Tracker};
use barrelman_vocab::Track;

use crate::scenes::{BLUE, Hull, Paint, RED, Scene, Yuv};

const FRAME_MS: u64 = 33;
const YELLOW: Yuv = [170, 60, 150];
/// How far the camera turns during a gap, pixels to the left.
const JUMP_PX: f64 = 83.0;
/// Length and breadth of a boat, pixels.
const BOAT_PX: (f64, f64) = (40.0, 16.0);

fn hull(colour: Yuv, pattern: u32, centre: (f64, f64), (length, breadth): (f64, f64)) -> Hull {
    let paint = Paint { colour, contrast: 50.0, pattern };
    Hull { paint, centre, length, breadth, turned_deg: 0.0 }
}

/// A red boat, and another object.
fn scene_with(other: Hull) -> Scene {
    Scene {
        size: (320, 240),
        water: Paint { colour: BLUE, contrast: 30.0, pattern: 1 },
        shift: (0.0, 0.0),
        clutter: Vec::new(),
        hulls: vec![hull(RED, 2, (160.0, 120.0), BOAT_PX), other],
    }
}

/// The boat, and a small yellow buoy where the boat seems to be after the camera has turned.
fn scene_with_buoy() -> Scene {
    scene_with(hull(YELLOW, 3, (160.0 + JUMP_PX, 120.0), (14.0, 10.0)))
}

/// The boat, and another of its kind.
fn scene_with_like_boat() -> Scene {
    scene_with(hull(RED, 2, (160.0 + JUMP_PX, 140.0), BOAT_PX))
}

/// Tracks the boat for 20 frames, and 40 frames after a gap in which `change` is made to the scene. Checks
/// that no box off the boat is reported with 0.5 or more; the number of the first frame after the gap in
/// which the boat is.
fn found_after(mut scene: Scene, gap_ms: u64, change: impl FnOnce(&mut Scene)) -> Option<u64> {
    let mut tracker = FusedTracker::new(FusedConfig::default()).unwrap();
    tracker.select(&scene.at_ms(0), scene.hulls[0].bounds()).unwrap();
    for step in 1..=20 {
        assert!(matches!(tracker.track(&scene.at_ms(FRAME_MS * step), None), Track::Tracking(_)));
    }
    change(&mut scene);
    let mut found = None;
    for step in 0..40 {
        let track = tracker.track(&scene.at_ms(FRAME_MS * (20 + step) + gap_ms), None);
        if let Some(seen) = track.localisation() {
            let is_on_boat = seen.bounds.iou(scene.hulls[0].bounds()) >= 0.3;
            assert!(is_on_boat || seen.confidence < 0.5, "{gap_ms} ms, frame {step}: {seen:?}");
            if is_on_boat && seen.confidence >= 0.5 {
                found.get_or_insert(step);
            }
        }
        assert!(step > 0 || matches!(track, Track::Lost { .. }), "{gap_ms} ms: {track:?}");
        if let Track::Lost { confidence, .. } = track {
            assert!(confidence < 0.5, "{gap_ms} ms, frame {step}: {track:?}");
        }
    }
    found
}

const GAPS_MS: [u64; 4] = [800, 1300, 2500, 4000];

#[test]
fn a_target_that_is_elsewhere_after_a_gap_is_taken_back_once_it_is_confirmed() {
    for gap_ms in GAPS_MS {
        let found = found_after(scene_with_buoy(), gap_ms, |scene| {
            scene.shift.0 -= JUMP_PX;
            scene.hulls.iter_mut().for_each(|hull| hull.centre.0 -= JUMP_PX);
        });
        assert!(found.is_some_and(|frame| (3..30).contains(&frame)), "{gap_ms} ms: {found:?}");
    }
}

#[test]
fn a_buoy_in_the_place_of_a_target_that_is_gone_after_a_gap_is_not_followed() {
    for gap_ms in GAPS_MS {
        let found = found_after(scene_with_buoy(), gap_ms, |scene| {
            scene.shift.0 -= JUMP_PX;
            scene.hulls[0].centre = (-500.0, -500.0);
            scene.hulls[1].centre.0 -= JUMP_PX;
        });
        assert_eq!(found, None, "{gap_ms} ms");
    }
}

#[test]
fn a_boat_like_the_target_is_not_reported_for_sure_after_a_gap() {
    for gap_ms in GAPS_MS {
        let found = found_after(scene_with_like_boat(), gap_ms, |scene| {
            scene.shift.0 -= JUMP_PX;
            scene.hulls[0].centre = (-500.0, -500.0);
            scene.hulls[1].centre.0 -= JUMP_PX;
        });
        assert_eq!(found, None, "{gap_ms} ms");
    }
}

#[test]
fn a_boat_like_the_target_is_not_reported_for_sure_when_the_target_leaves() {
    let mut scene = scene_with_like_boat();
    scene.hulls.iter_mut().for_each(|hull| hull.centre.0 -= 80.0);
    let mut tracker = FusedTracker::new(FusedConfig::default()).unwrap();
    tracker.select(&scene.at_ms(0), scene.hulls[0].bounds()).unwrap();
    for step in 1..=90 {
        if (20..44).contains(&step) {
            scene.shift.0 -= 5.0;
            scene.hulls.iter_mut().for_each(|hull| hull.centre.0 -= 5.0);
        }
        let track = tracker.track(&scene.at_ms(FRAME_MS * step), None);
        let confidence = track.localisation().map_or(0.0, |seen| seen.confidence);
        assert!(step >= 20 || confidence >= 0.5, "frame {step}: {track:?}");
        assert!(step < 60 || confidence < 0.5, "frame {step}: {track:?}");
    }
}

#[test]
fn a_slow_video_has_no_gaps() {
    let scene = scene_with_buoy();
    let mut tracker = FusedTracker::new(FusedConfig::default()).unwrap();
    tracker.select(&scene.at_ms(0), scene.hulls[0].bounds()).unwrap();
    let last = (1..=10).map(|step| tracker.track(&scene.at_ms(600 * step), None)).last();
    assert!(matches!(last, Some(Track::Tracking(_))), "{last:?}");
}
