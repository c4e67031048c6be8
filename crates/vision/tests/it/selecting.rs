//! Reports and errors of CamShift's selections.

use barrelman_vision::{CamShift, CamShiftConfig, Explanation, SelectionError, Tracker};
use barrelman_vocab::{PixelBox, Track};

use crate::scenes::{BLACK, BLUE, GREY, RED, frame, pixels};

fn tracker() -> CamShift {
    CamShift::new(CamShiftConfig::default()).unwrap()
}

fn message(selection: PixelBox) -> String {
    let scene = frame((64, 48), GREY, &[(RED, [40, 20, 10, 10])]);
    tracker().select(&scene, selection).unwrap_err().to_string()
}

#[test]
fn a_box_outside_the_picture_is_refused_with_both_named() {
    let text = message(pixels(64.0, 10.0, 20.0, 20.0));
    assert!(text.contains("64,10,20,20") && text.contains("64x48") && text.contains("outside"), "{text}");
}

#[test]
fn a_box_without_a_width_is_refused_with_the_remedy() {
    let text = message(pixels(10.0, 10.0, 0.0, 20.0));
    assert!(text.contains("10,10,0,20") && text.contains("64x48") && text.contains("take a box"), "{text}");
}

#[test]
fn a_box_of_no_number_is_refused() {
    assert!(message(pixels(f64::NAN, 10.0, 5.0, 20.0)).contains("covers nothing"));
    assert!(message(pixels(1.0, 10.0, f64::INFINITY, 20.0)).contains("covers nothing"));
}

#[test]
fn a_grey_selection_is_refused_with_the_floors_named() {
    let text = message(pixels(0.0, 0.0, 20.0, 20.0));
    assert!(text.contains("60") && text.contains("32") && text.contains("64x48"), "{text}");
}

#[test]
fn a_refused_selection_keeps_the_earlier_target() {
    let scene = frame((64, 48), GREY, &[(RED, [40, 20, 10, 10])]);
    let mut tracker = tracker();
    tracker.select(&scene, pixels(40.0, 20.0, 10.0, 10.0)).unwrap();
    assert!(matches!(
        tracker.select(&scene, pixels(0.0, 0.0, 10.0, 10.0)),
        Err(SelectionError::Colourless { .. })
    ));
    assert!(matches!(tracker.track(&scene, None), Track::Tracking(_)));
}

#[test]
fn the_part_of_a_box_outside_the_picture_is_cut_off_and_said() {
    let scene = frame((64, 48), GREY, &[(RED, [54, 20, 10, 10])]);
    let report = tracker().select(&scene, pixels(54.0, 20.0, 20.0, 10.0)).unwrap();
    assert!(report.is_clipped);
    assert_eq!(report.used, pixels(54.0, 20.0, 10.0, 10.0));
    assert_eq!(report.localisation.bounds, report.used);
}

#[test]
fn the_report_says_how_much_of_the_box_has_colour_and_how_like_it_the_surroundings_are() {
    let scene = frame((64, 48), BLUE, &[(GREY, [20, 20, 20, 10]), (RED, [20, 20, 10, 10])]);
    let report = tracker().select(&scene, pixels(20.0, 20.0, 20.0, 10.0)).unwrap();
    assert!(!report.is_clipped);
    assert_eq!((report.coloured_share, report.surroundings_probability), (0.5, 0.0));
    assert_eq!(report.localisation.confidence, 0.5);

    let lost_in_red = frame((64, 48), RED, &[]);
    let report = tracker().select(&lost_in_red, pixels(20.0, 20.0, 20.0, 10.0)).unwrap();
    assert_eq!(report.surroundings_probability, 1.0);
}

#[test]
fn one_pixel_is_enough() {
    let scene = frame((64, 48), GREY, &[(RED, [40, 20, 2, 2])]);
    let report = tracker().select(&scene, pixels(40.2, 20.1, 0.3, 0.3)).unwrap();
    assert_eq!(report.used, pixels(40.0, 20.0, 1.0, 1.0));
}

#[test]
fn nothing_is_tracked_or_explained_before_a_selection() {
    let mut tracker = tracker();
    assert_eq!(tracker.track(&frame((64, 48), BLACK, &[]), None), Track::Unseeded);
    let mut out = Explanation { histogram: vec![1, 2, 3], ..Explanation::default() };
    tracker.explain(&mut out);
    assert_eq!(out, Explanation::default());
}

#[test]
fn a_setting_outside_its_range_is_refused_by_name() {
    let refused = |config: CamShiftConfig| CamShift::new(config).unwrap_err().to_string();
    let default = CamShiftConfig::default();
    assert!(refused(CamShiftConfig { bins: 1, ..default }).contains("bins = 1"));
    assert!(refused(CamShiftConfig { bins: 181, ..default }).contains("2 to 180"));
    assert!(refused(CamShiftConfig { max_iterations: 0, ..default }).contains("max_iterations"));
    assert!(refused(CamShiftConfig { epsilon_px: f64::NAN, ..default }).contains("epsilon_px"));
    assert!(refused(CamShiftConfig { search_margin_px: 9999, ..default }).contains("search_margin_px"));
}
