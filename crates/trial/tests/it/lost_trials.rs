//! When a trial counts as lost, and when as a success.

use barrelman_trial::metrics::measure;

use crate::trial_logs::{PICTURE, REGION, log_from, measured};

#[test]
fn a_trial_is_lost_after_more_than_two_seconds_at_a_stretch_or_at_its_end() {
    let check = |rows: &str, lost: bool, out_s: f64| {
        let metrics = measured(rows);
        assert_eq!((metrics.lost, metrics.out_of_picture_s), (Some(lost), Some(out_s)), "{rows}");
        assert_eq!(metrics.is_success(), !lost, "{rows}");
    };
    check("....", false, 0.0);
    check(".----.", false, 2.0);
    check(".-----.", true, 2.5);
    check(".---.---.", false, 3.0);
    check(".-----...", true, 2.5);
    check("...-", true, 0.5);
    check("-...", false, 0.5);
    // Outside the region, but with a known position.
    check("..aa", false, 0.0);
}

#[test]
fn a_log_that_cannot_tell_succeeds_where_it_ends_inside() {
    let check = |rows: &str, succeeded: bool| {
        let log = barrelman_trial::logs::TrialLog { records_track_loss: false, ..log_from(rows) };
        let metrics = measure(&log, REGION, PICTURE);
        assert_eq!((metrics.lost, metrics.out_of_picture_s), (None, None));
        assert_eq!(metrics.is_success(), succeeded, "{rows}");
    };
    check("aa..", true);
    check("..aa", false);
}
