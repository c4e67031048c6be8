//! Metrics of the commands of a trial, against values computed by hand.

use barrelman_trial::metrics::{TrialMetrics, measure};
use barrelman_vocab::ImagePoint;

use crate::trial_logs::{PICTURE, REGION, command, log_from_rows};

/// The metrics of commands (pan, tilt) of 0.5 s each. All rates are sums of powers of two, so that the sums
/// are exact.
fn metrics_of(rows: &[(f64, f64)]) -> TrialMetrics {
    let position = Some(ImagePoint { x: 0.0, y: 0.0 });
    let log = log_from_rows(rows.iter().map(|&(pan, tilt)| (position, Some(command(pan, tilt)))));
    measure(&log, REGION, PICTURE)
}

#[test]
fn moves_start_from_rest_and_switches_do_not() {
    let check = |rows: &[(f64, f64)], moves: usize, switches: usize| {
        let metrics = metrics_of(rows);
        assert_eq!((metrics.moves, metrics.switches), (Some(moves), Some(switches)), "{rows:?}");
    };
    check(&[(0.0, 0.0), (0.0, 0.0)], 0, 0);
    check(&[(0.25, 0.0)], 1, 0);
    check(&[(0.0, 0.0), (0.25, 0.0), (0.25, 0.0), (0.0, 0.0)], 1, 0);
    check(&[(0.25, 0.0), (0.0, 0.0), (0.25, 0.0)], 2, 0);
    check(&[(0.25, 0.0), (0.0, 0.25)], 1, 1);
    check(&[(0.25, 0.0), (-0.25, 0.0)], 1, 1);
    check(&[(0.25, 0.0), (0.25, 0.25), (0.25, 0.0)], 1, 2);
    check(&[(0.25, 0.0), (-0.0, 0.0), (0.0, -0.0)], 1, 0);
}

#[test]
fn times_and_integrals_are_those_of_the_commands() {
    let metrics = metrics_of(&[(0.0, 0.0), (0.5, 0.0), (0.5, -0.25), (0.0, 0.0)]);
    assert_eq!(metrics.movement_s, Some(1.0));
    assert_eq!(metrics.duty, Some(0.5));
    assert_eq!(metrics.both_axes, Some(0.5));
    assert_eq!(metrics.travel_rad, Some(0.625));
    assert_eq!(metrics.effort_rad2_per_s, Some(0.25 * 0.5 + (0.25 + 0.0625) * 0.5));
    // Yaw 0.5 up, pitch 0.25 down, both back to zero.
    assert_eq!(metrics.variation_rad_per_s, Some(1.5));
}

#[test]
fn a_first_command_counts_as_a_change_from_rest() {
    assert_eq!(metrics_of(&[(0.5, 0.25)]).variation_rad_per_s, Some(0.75));
}

#[test]
fn a_camera_that_never_moved_has_no_share_of_moving_time() {
    let metrics = metrics_of(&[(0.0, 0.0), (0.0, 0.0)]);
    assert_eq!((metrics.both_axes, metrics.movement_s, metrics.duty), (None, Some(0.0), Some(0.0)));
    assert_eq!((metrics.travel_rad, metrics.variation_rad_per_s), (Some(0.0), Some(0.0)));
}

#[test]
fn a_log_with_a_row_that_does_not_say_has_no_camera_figures() {
    let position = Some(ImagePoint { x: 0.0, y: 0.0 });
    let log = log_from_rows([(position, Some(command(0.25, 0.0))), (position, None)]);
    let metrics = measure(&log, REGION, PICTURE);
    assert_eq!((metrics.moves, metrics.switches, metrics.duty), (None, None, None));
    assert_eq!((metrics.travel_rad, metrics.effort_rad2_per_s, metrics.movement_s), (None, None, None));
    assert_eq!((metrics.both_axes, metrics.variation_rad_per_s), (None, None));
    assert_eq!(metrics.jerk_rad_per_s3, None);
}
