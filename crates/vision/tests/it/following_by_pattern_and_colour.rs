//! Tracks of the fused tracker over several frames.

use core::time::Duration;

use barrelman_vision::{Explanation, FusedConfig, FusedTracker, Tracker, TrackerState};
use barrelman_vocab::{Localisation, MotionPrior, Track};

use crate::scenes::{BLUE, GREY, Hull, ORANGE_RED, Paint, RED, Scene, Yuv};

/// Frame interval, milliseconds.
const FRAME_MS: u64 = 33;

fn paint(colour: Yuv, contrast: f64, pattern: u32) -> Paint {
    Paint { colour, contrast, pattern }
}

/// One hull on patterned water, 320 x 240 pixels.
fn scene(water: Yuv, boat: Yuv) -> Scene {
    Scene {
        size: (320, 240),
        water: paint(water, 30.0, 1),
        shift: (0.0, 0.0),
        clutter: Vec::new(),
        hulls: vec![Hull {
            paint: paint(boat, 60.0, 2),
            centre: (160.0, 120.0),
            length: 56.0,
            breadth: 30.0,
            turned_deg: 0.0,
        }],
    }
}

/// A changing scene with its tracker and time.
struct Trial {
    scene: Scene,
    tracker: FusedTracker,
    now_ms: u64,
}

impl Trial {
    /// Selects the first hull.
    fn new(scene: Scene) -> Self {
        let mut tracker = FusedTracker::new(FusedConfig::default()).unwrap();
        tracker.select(&scene.at_ms(0), scene.hulls[0].bounds()).unwrap();
        Self { scene, tracker, now_ms: 0 }
    }

    /// Changes the scene and tracks the next frame.
    fn next(&mut self, prior: Option<&MotionPrior>, change: impl FnOnce(&mut Scene)) -> Track {
        change(&mut self.scene);
        self.now_ms += FRAME_MS;
        self.tracker.track(&self.scene.at_ms(self.now_ms), prior)
    }

    /// Changes the scene and tracks the next frame, in which the first hull must be tracked with at least
    /// this IoU.
    fn next_tracked(&mut self, min_iou: f64, change: impl FnOnce(&mut Scene)) -> Localisation {
        let track = self.next(None, change);
        self.check_hull(track, min_iou)
    }

    /// Checks that the first hull is tracked with at least this IoU.
    fn check_hull(&self, track: Track, min_iou: f64) -> Localisation {
        let Track::Tracking(here) = track else {
            panic!("at {} ms: {track:?}", self.now_ms);
        };
        let truth = self.scene.hulls[0].bounds();
        let iou = here.bounds.iou(truth);
        assert!(iou >= min_iou, "at {} ms: {} for {truth}, {iou:.2}", self.now_ms, here.bounds);
        here
    }
}

#[test]
fn a_grey_thing_on_grey_ground_is_followed_by_its_pattern() {
    let mut trial = Trial::new(scene(GREY, GREY));
    for step in 0..60 {
        trial.next_tracked(0.7, |scene| {
            scene.hulls[0].centre.0 = 160.0 + 1.5 * f64::from(step);
            scene.hulls[0].centre.1 = 120.0 - f64::from(step);
        });
    }
}

#[test]
fn a_red_thing_is_followed_past_others_of_its_colour() {
    let mut scene = scene(BLUE, RED);
    scene.hulls[0].centre = (60.0, 120.0);
    for (index, top) in [70.0, 150.0, 78.0, 146.0].into_iter().enumerate() {
        let left = 90.0 + 50.0 * index as f64;
        scene.clutter.push((paint(RED, 20.0, 5 + index as u32), [left, top, 36.0, 22.0]));
    }
    let mut trial = Trial::new(scene);
    for step in 0..80 {
        trial.next_tracked(0.6, |scene| scene.hulls[0].centre.0 = 60.0 + 2.5 * f64::from(step));
    }
}

#[test]
fn a_thing_that_comes_nearer_is_followed_to_twice_its_size() {
    for (water, boat) in [(BLUE, RED), (GREY, GREY)] {
        let mut trial = Trial::new(scene(water, boat));
        for step in 0..=90 {
            let growth = libm::exp2(f64::from(step) / 90.0);
            trial.next_tracked(0.6, |scene| {
                scene.hulls[0].length = 56.0 * growth;
                scene.hulls[0].breadth = 30.0 * growth;
            });
        }
    }
}

#[test]
fn the_axis_follows_a_boat_that_turns_about() {
    let mut trial = Trial::new(scene(BLUE, RED));
    for step in 0..=120 {
        let turned_deg = 1.5 * f64::from(step);
        let here = trial.next_tracked(0.6, |scene| scene.hulls[0].turned_deg = turned_deg);
        let off = (here.shape.unwrap().axis.degrees() - turned_deg).rem_euclid(180.0);
        let off = off.min(180.0 - off);
        // It turns at 45 degrees per second; measured 1.6 at most.
        assert!(off < 4.0, "{off} degrees off at {turned_deg}");
    }
}

#[test]
fn a_jump_with_the_camera_is_followed_by_the_prior() {
    let mut trial = Trial::new(scene(BLUE, RED));
    let prior = |shift_u_px| MotionPrior {
        shift_u_px,
        shift_v_px: 0.0,
        scale: 1.0,
        std_dev_px: 2.0,
        interval: Duration::from_millis(FRAME_MS),
    };
    for step in 0..20 {
        // Back and forth by twice the boat's length per frame.
        let shift = if step % 2 == 0 { 110.0 } else { -110.0 };
        let track = trial.next(Some(&prior(shift)), |scene| {
            scene.shift.0 += shift;
            scene.hulls[0].centre.0 += shift;
        });
        trial.check_hull(track, 0.6);
    }
}

/// Moves the first hull to the right until it is outside the picture; the track of the last frame.
fn leave(trial: &mut Trial, speed_px: f64) -> Track {
    loop {
        let track = trial.next(None, |scene| scene.hulls[0].centre.0 += speed_px);
        if trial.scene.hulls[0].bounds().u > 320.0 {
            return track;
        }
        assert!(matches!(track, Track::Tracking(_)) || trial.scene.hulls[0].centre.0 > 270.0, "{track:?}");
    }
}

#[test]
fn a_thing_that_leaves_is_lost_within_half_a_second_and_tracked_again_within_a_second_of_its_return() {
    for (water, boat) in [(BLUE, RED), (GREY, GREY)] {
        for speed_px in [4.0, 10.0] {
            let mut trial = Trial::new(scene(water, boat));
            let mut track = leave(&mut trial, speed_px);
            let left_ms = trial.now_ms;
            while !matches!(track, Track::Lost { .. }) {
                track = trial.next(None, |_| ());
                assert!(trial.now_ms - left_ms <= 500, "{track:?}");
            }
            let Track::Lost { since, .. } = track else { unreachable!() };
            for _ in 0..30 {
                let track = trial.next(None, |_| ());
                assert!(matches!(track, Track::Lost { since: same, .. } if same == since), "{track:?}");
            }
            // It returns elsewhere, at once wholly in the picture.
            let mut track = trial.next(None, |scene| scene.hulls[0].centre = (80.0, 70.0));
            let back_ms = trial.now_ms;
            while !matches!(track, Track::Tracking(_)) {
                track = trial.next(None, |_| ());
                assert!(trial.now_ms - back_ms <= 1000, "{track:?}");
            }
            trial.check_hull(track, 0.5);
            for _ in 0..10 {
                trial.next_tracked(0.5, |_| ());
            }
        }
    }
}

#[test]
fn a_thing_that_goes_under_in_moving_water_is_carried_on_for_a_while_and_then_lost() {
    let mut trial = Trial::new(scene(BLUE, RED));
    let mut states = Vec::new();
    let mut out = Explanation::default();
    for step in 0..45 {
        let track = trial.next(None, |scene| {
            scene.shift.0 += 2.5;
            if step >= 15 {
                scene.hulls.clear();
            }
        });
        trial.tracker.explain(&mut out);
        let expected = match track {
            Track::Unseeded => None,
            Track::Tracking(_) => Some(TrackerState::Tracking),
            Track::Coasting(_) => Some(TrackerState::Coasting),
            Track::Lost { .. } => Some(TrackerState::Lost),
        };
        assert_eq!(out.state, expected);
        states.extend(out.state);
    }
    states.dedup();
    assert_eq!(states, [TrackerState::Tracking, TrackerState::Coasting, TrackerState::Lost]);
}

#[test]
fn a_thing_of_the_same_colour_that_stays_is_not_taken_for_one_that_left() {
    let mut scene = scene(BLUE, RED);
    scene.clutter.push((paint(RED, 20.0, 9), [40.0, 40.0, 50.0, 50.0]));
    scene.clutter.push((paint(ORANGE_RED, 20.0, 10), [240.0, 170.0, 30.0, 60.0]));
    let mut trial = Trial::new(scene);
    leave(&mut trial, 8.0);
    for _ in 0..15 {
        trial.next(None, |_| ());
    }
    for _ in 0..90 {
        let track = trial.next(None, |_| ());
        assert!(matches!(track, Track::Lost { .. }), "at {} ms: {track:?}", trial.now_ms);
    }
}

#[test]
fn a_twin_that_was_there_before_is_not_taken_for_a_boat_that_is_hidden() {
    let mut scene = scene(BLUE, RED);
    let twin = Hull { centre: (60.0, 60.0), ..scene.hulls[0] };
    scene.hulls.push(twin);
    let mut trial = Trial::new(scene);
    for _ in 0..40 {
        trial.next_tracked(0.5, |_| ());
    }
    let hidden = (-500.0, -500.0);
    for step in 0..150 {
        // The kite sways.
        let sway = 4.0 * libm::sin(f64::from(step) / 10.0);
        let track = trial.next(None, |scene| {
            scene.hulls[0].centre = hidden;
            scene.hulls[1].centre.0 = twin.centre.0 + sway;
        });
        // The boat was farther to the right.
        let is_taken = matches!(&track, Track::Tracking(here) if here.bounds.u <= 100.0);
        assert!(!is_taken, "at {} ms: {track:?}", trial.now_ms);
    }
    // The boat itself is found.
    let back = (0..30).any(|_| {
        let track = trial.next(None, |scene| scene.hulls[0].centre = (200.0, 150.0));
        matches!(track, Track::Tracking(here) if here.bounds.iou(trial.scene.hulls[0].bounds()) > 0.5)
    });
    assert!(back, "the boat is not found again");
}

#[test]
fn a_boat_that_lies_still_has_an_axis_and_no_heading() {
    let mut trial = Trial::new(scene(BLUE, RED));
    for _ in 0..60 {
        let here = trial.next_tracked(0.8, |_| ());
        assert_eq!(here.heading, None);
        let axis = here.shape.unwrap().axis.degrees();
        assert!(axis.min(180.0 - axis) < 3.0, "{axis}");
    }
}

#[test]
fn a_boat_that_went_has_its_heading_the_way_it_went_and_keeps_it() {
    for (turned_deg, expected_deg) in [(0.0, 0.0), (0.0, 180.0), (30.0, 30.0), (30.0, 210.0)] {
        let mut scene = scene(BLUE, RED);
        scene.hulls[0].turned_deg = turned_deg;
        let mut trial = Trial::new(scene);
        let (sin, cos) = libm::sincos(f64::to_radians(expected_deg));
        let mut heading = None;
        for step in 0..60 {
            let speed = if step < 40 { 2.0 } else { 0.0 };
            let here = trial.next_tracked(0.6, |scene| {
                scene.hulls[0].centre.0 += speed * cos;
                scene.hulls[0].centre.1 -= speed * sin;
            });
            assert!(heading.is_none() || here.heading.is_some());
            heading = here.heading;
        }
        let heading = heading.unwrap().degrees();
        let off = (heading - expected_deg).rem_euclid(360.0);
        assert!(off.min(360.0 - off) < 5.0, "{heading}, not {expected_deg}");
    }
}

#[test]
fn a_moving_camera_gives_a_boat_that_lies_still_no_heading() {
    let prior = MotionPrior {
        shift_u_px: 1.5,
        shift_v_px: 0.5,
        scale: 1.0,
        std_dev_px: 0.5,
        interval: Duration::from_millis(FRAME_MS),
    };
    let mut trial = Trial::new(scene(BLUE, RED));
    for _ in 0..60 {
        let track = trial.next(Some(&prior), |scene| {
            scene.shift = (scene.shift.0 + 1.5, scene.shift.1 + 0.5);
            let centre = &mut scene.hulls[0].centre;
            *centre = (centre.0 + 1.5, centre.1 + 0.5);
        });
        assert_eq!(trial.check_hull(track, 0.7).heading, None);
    }
}

#[test]
fn a_picture_of_another_size_shows_the_thing_in_the_same_place() {
    let mut trial = Trial::new(scene(BLUE, RED));
    for _ in 0..5 {
        trial.next_tracked(0.7, |_| ());
    }
    let here = trial.next_tracked(0.6, |scene| {
        scene.size = (640, 480);
        let hull = &mut scene.hulls[0];
        *hull = Hull { centre: (320.0, 240.0), length: 112.0, breadth: 60.0, ..*hull };
    });
    assert_eq!((here.picture.width, here.picture.height), (640, 480));
    for _ in 0..10 {
        trial.next_tracked(0.6, |_| ());
    }
}

#[test]
fn the_same_frames_give_the_same_track_to_the_bit() {
    let tracks = || -> Vec<Track> {
        let mut trial = Trial::new(scene(BLUE, RED));
        let move_right = |trial: &mut Trial| trial.next(None, |scene| scene.hulls[0].centre.0 += 9.0);
        (0..45).map(|_| move_right(&mut trial)).collect()
    };
    let once = tracks();
    assert!(matches!(once[0], Track::Tracking(_)) && matches!(once[44], Track::Lost { .. }));
    assert_eq!(once, tracks());
}

#[test]
fn an_explanation_shows_the_window_the_response_the_probability_and_the_state() {
    let mut trial = Trial::new(scene(BLUE, RED));
    let mut out = Explanation::default();
    let here = trial.next_tracked(0.7, |_| ());
    // The second explanation replaces the first.
    for _ in 0..2 {
        trial.tracker.explain(&mut out);
        assert_eq!(out.state, Some(TrackerState::Tracking));
        assert_eq!(out.confidence, here.confidence);
        let window = out.search_window.unwrap();
        assert_eq!(window.intersection(here.bounds), here.bounds);
        for map in [&out.back_projection, &out.response] {
            assert_eq!(map.samples.len(), map.width * map.height);
            assert_eq!(map.samples.iter().max(), Some(&255));
            assert_eq!(map.bounds.intersection(here.bounds), here.bounds);
        }
        assert!(out.histogram.is_empty());
    }
}

#[test]
fn the_place_of_a_rejected_object_that_is_hidden_turns_with_the_camera() {
    let turn = MotionPrior {
        shift_u_px: -8.0,
        shift_v_px: 0.0,
        scale: 1.0,
        std_dev_px: 3.0,
        interval: Duration::from_millis(FRAME_MS),
    };
    let rejected_then_turned = || {
        let mut trial = Trial::new(scene(GREY, ORANGE_RED));
        for _ in 0..20 {
            trial.next_tracked(0.5, |_| {});
        }
        assert!(trial.tracker.reject());
        for _ in 0..60 {
            trial.next(None, |scene| scene.hulls[0].centre = (-200.0, -200.0));
        }
        for _ in 0..15 {
            trial.next(Some(&turn), |scene| scene.shift.0 -= 8.0);
        }
        trial
    };
    // Another boat lies where the rejected one was in the picture; the rejected one comes back where it was
    // on the water.
    for (u, is_taken) in [(160.0, true), (40.0, false)] {
        let mut trial = rejected_then_turned();
        let takes = (0..30).any(|_| {
            matches!(trial.next(None, |scene| scene.hulls[0].centre = (u, 120.0)), Track::Tracking(_))
        });
        assert_eq!(takes, is_taken, "at {u}");
    }
}

#[test]
fn the_water_is_not_said_to_move_while_nothing_is_followed() {
    let mut trial = Trial::new(scene(BLUE, RED));
    for _ in 0..12 {
        trial.next_tracked(0.5, |scene| scene.shift.0 -= 4.0);
    }
    assert!(trial.tracker.background_shift().is_some());
    trial.tracker.forget();
    for _ in 0..3 {
        assert_eq!(trial.next(None, |scene| scene.shift.0 += 4.0), Track::Unseeded);
        assert!(trial.tracker.background_shift().is_none());
    }
}
