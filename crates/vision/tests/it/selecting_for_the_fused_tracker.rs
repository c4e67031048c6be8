//! Reports and errors of the fused tracker's selections.

use barrelman_vision::{Explanation, FusedConfig, FusedTracker, SelectionError, SelectionReport, Tracker};
use barrelman_vocab::{PixelBox, Track};

use crate::scenes::{BLACK, BLUE, GREY, Hull, Paint, RED, Scene, Yuv, frame, pixels};

fn tracker() -> FusedTracker {
    FusedTracker::new(FusedConfig::default()).unwrap()
}

fn paint(colour: Yuv, pattern: u32) -> Paint {
    Paint { colour, contrast: 40.0, pattern }
}

fn hull(colour: Yuv, pattern: u32, centre: (f64, f64), (length, breadth): (f64, f64)) -> Hull {
    Hull { paint: paint(colour, pattern), centre, length, breadth, turned_deg: 0.0 }
}

fn scene(water: Yuv, hulls: &[Hull]) -> Scene {
    Scene {
        size: (240, 180),
        water: paint(water, 1),
        shift: (0.0, 0.0),
        clutter: Vec::new(),
        hulls: hulls.to_vec(),
    }
}

/// The report on a selection of the first hull's own box.
fn report(scene: &Scene) -> SelectionReport {
    tracker().select(&scene.at_ms(0), scene.hulls[0].bounds()).unwrap()
}

#[test]
fn a_target_with_a_distinct_colour_is_reported_as_such() {
    let report = report(&scene(BLUE, &[hull(RED, 2, (120.0, 90.0), (70.0, 40.0))]));
    assert!(!report.is_clipped);
    // An ellipse fills 0.785 of its box; the box around its paint, 0.92 of the ellipse's axes long and wide,
    // leaves out more of the water in the corners.
    assert!((0.72..0.93).contains(&report.coloured_share), "{report:?}");
    assert!(report.surroundings_probability < 0.02, "{report:?}");
    assert_eq!(report.localisation.confidence, 1.0);
}

#[test]
fn a_target_like_its_surroundings_is_reported_as_such() {
    let similar = report(&scene(GREY, &[hull(GREY, 2, (120.0, 90.0), (70.0, 40.0))]));
    // A colour as frequent around the target as on it has a probability of one half.
    assert!((0.4..0.6).contains(&similar.surroundings_probability), "{similar:?}");
}

#[test]
fn an_elongated_target_has_an_axis_from_the_start_and_a_round_one_has_none() {
    for turned_deg in [0.0, 30.0, 90.0, 150.0] {
        let slanting = Hull { turned_deg, ..hull(RED, 2, (120.0, 90.0), (80.0, 30.0)) };
        let here = report(&scene(BLUE, &[slanting])).localisation;
        let axis = here.shape.unwrap().axis.degrees();
        let off = (axis - turned_deg).rem_euclid(180.0);
        assert!(off.min(180.0 - off) < 2.0, "{axis}, not {turned_deg}");
        assert_eq!(here.heading, None);
    }
    let round = report(&scene(BLUE, &[hull(RED, 2, (120.0, 90.0), (50.0, 50.0))]));
    assert_eq!(round.localisation.shape, None);
}

#[test]
fn the_part_of_a_box_outside_the_picture_is_cut_off_and_said() {
    let scene = scene(BLUE, &[hull(RED, 2, (230.0, 90.0), (60.0, 40.0))]);
    let report = report(&scene);
    assert!(report.is_clipped);
    assert_eq!(report.used, pixels(200.0, 70.0, 40.0, 40.0));
    assert_eq!(report.localisation.bounds, report.used);
}

#[test]
fn a_box_in_the_picture_is_not_said_to_be_cut_off_because_of_rounding() {
    let frame = frame((320, 180), BLUE, &[(RED, [142, 62, 20, 56])]);
    let report = tracker().select(&frame, pixels(142.2, 63.2, 20.2, 55.2)).unwrap();
    assert!(!report.is_clipped, "{report:?}");
}

#[test]
fn a_second_selection_forgets_the_first() {
    let (first, second) = ((60.0, 60.0), (170.0, 120.0));
    let size = (50.0, 30.0);
    let scene = scene(BLUE, &[hull(RED, 2, first, size), hull(GREY, 3, second, size)]);
    let mut tracker = tracker();
    for (hull, other) in [(0, 1), (1, 0), (0, 1)] {
        let bounds = scene.hulls[hull].bounds();
        tracker.select(&scene.at_ms(0), bounds).unwrap();
        for step in 1..6 {
            let Track::Tracking(here) = tracker.track(&scene.at_ms(33 * step), None) else {
                panic!("the second selection is tracked");
            };
            assert!(here.bounds.iou(bounds) > 0.7, "{}", here.bounds);
            assert_eq!(here.bounds.iou(scene.hulls[other].bounds()), 0.0);
        }
    }
    // A tracker that forgot a target is equal to a new one.
    let mut fresh = self::tracker();
    fresh.select(&scene.at_ms(0), scene.hulls[1].bounds()).unwrap();
    tracker.select(&scene.at_ms(0), scene.hulls[1].bounds()).unwrap();
    for step in 1..6 {
        let frame = scene.at_ms(33 * step);
        assert_eq!(tracker.track(&frame, None), fresh.track(&frame, None));
    }
}

#[test]
fn a_refused_selection_keeps_the_earlier_target() {
    let scene = scene(BLUE, &[hull(RED, 2, (120.0, 90.0), (60.0, 36.0))]);
    let (mut tracker, mut undisturbed) = (tracker(), tracker());
    for tracker in [&mut tracker, &mut undisturbed] {
        tracker.select(&scene.at_ms(0), scene.hulls[0].bounds()).unwrap();
    }
    for (step, refused) in
        [pixels(240.0, 0.0, 9.0, 9.0), pixels(9.0, 9.0, 0.0, 9.0), pixels(f64::NAN, 9.0, 9.0, 9.0)]
            .into_iter()
            .enumerate()
    {
        let frame = scene.at_ms(33 * (step as u64 + 1));
        let error = tracker.select(&frame, refused).unwrap_err();
        assert!(matches!(error, SelectionError::Outside { .. } | SelectionError::Empty { .. }));
        let track = tracker.track(&frame, None);
        assert!(matches!(track, Track::Tracking(_)), "{track:?}");
        assert_eq!(track, undisturbed.track(&frame, None));
    }
}

fn message(selection: PixelBox) -> String {
    tracker().select(&frame((64, 48), GREY, &[]), selection).unwrap_err().to_string()
}

#[test]
fn a_refusal_names_the_box_and_the_picture() {
    let text = message(pixels(64.0, 10.0, 20.0, 20.0));
    assert!(text.contains("64,10,20,20") && text.contains("64x48") && text.contains("outside"), "{text}");
    let text = message(pixels(10.0, 10.0, 0.0, 20.0));
    assert!(text.contains("10,10,0,20") && text.contains("64x48") && text.contains("take a box"), "{text}");
}

#[test]
fn nothing_is_tracked_or_explained_before_a_selection() {
    let mut tracker = tracker();
    assert_eq!(tracker.track(&frame((64, 48), BLACK, &[]), None), Track::Unseeded);
    let mut out = Explanation { histogram: vec![1, 2, 3], confidence: 0.5, ..Explanation::default() };
    tracker.explain(&mut out);
    assert_eq!(out, Explanation::default());
}

#[test]
fn a_setting_outside_its_range_is_refused_by_name() {
    let refused = |config: FusedConfig| FusedTracker::new(config).unwrap_err().to_string();
    let default = FusedConfig::default();
    assert!(refused(FusedConfig { padding: 2.4, ..default }).contains("padding = 2.4: use 2.5 to 6"));
    assert!(refused(FusedConfig { seen: f64::NAN, ..default }).contains("seen = NaN"));
    assert!(refused(FusedConfig { confirm: 21, ..default }).contains("confirm = 21: use 0 to 20"));
    assert!(refused(FusedConfig { coast_s: -0.1, ..default }).contains("coast_s"));
    assert!(refused(FusedConfig { agility: f64::INFINITY, ..default }).contains("agility"));
}
