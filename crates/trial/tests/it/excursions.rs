//! Excursions and their metrics. All expected values are computed by hand.

use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::{Excursion, find_excursions};

use crate::trial_logs::{PICTURE, REGION, log_from, measured};

#[test]
fn an_excursion_is_a_maximal_run_outside() {
    let check = |rows: &str, expected: &[(usize, usize, bool, f64, f64)]| {
        let expected: Vec<Excursion> = expected
            .iter()
            .map(|&(first, end, is_complete, h, b_s)| Excursion { first, end, is_complete, h, b_s })
            .collect();
        assert_eq!(find_excursions(&log_from(rows), REGION), expected, "{rows}");
    };
    check("", &[]);
    check("....", &[]);
    check(".o.o", &[]);
    check("..ab.", &[(2, 4, true, 3.0, 1.0)]);
    check(".bab.", &[(1, 4, true, 3.0, 1.5)]);
    check("a.b.c.", &[(0, 1, true, 1.25, 0.5), (2, 3, true, 3.0, 0.5), (4, 5, true, 8.0, 0.5)]);
    check("aob.", &[(0, 1, true, 1.25, 0.5), (2, 3, true, 3.0, 0.5)]);
    check(".aa", &[(1, 3, false, 1.25, 1.0)]);
    check("c", &[(0, 1, false, 8.0, 0.5)]);
}

#[test]
fn a_row_without_a_position_goes_on_with_what_was_before_it() {
    let check = |rows: &str, expected: &[(usize, usize, bool, f64)]| {
        let found: Vec<_> = find_excursions(&log_from(rows), REGION)
            .iter()
            .map(|excursion| (excursion.first, excursion.end, excursion.is_complete, excursion.b_s))
            .collect();
        assert_eq!(found, expected, "{rows}");
    };
    check("----", &[]);
    check(".--.", &[]);
    check("--a.", &[(2, 3, true, 0.5)]);
    check("a--a.", &[(0, 4, true, 2.0)]);
    check("a--.", &[(0, 3, true, 1.5)]);
    check("a--", &[(0, 3, false, 1.5)]);
    check(".--a", &[(3, 4, false, 0.5)]);
}

#[test]
fn a_trial_is_measured_over_its_complete_excursions() {
    // h 1.25 over 0.5 s, h 3 over 1 s; the last one is open.
    let metrics = measured("a.ab.c");
    assert_eq!((metrics.samples, metrics.duration_s), (6, 3.0));
    assert_eq!((metrics.excursions, metrics.complete_excursions), (3, 2));
    assert_eq!(metrics.time_outside_s, 2.0);
    assert_eq!(metrics.max_p, Some(9.0));
    assert_eq!((metrics.mean_h, metrics.mean_b_s), (Some(2.125), Some(0.75)));
    assert_eq!(metrics.sensitivity, Some(f64::midpoint(1.25 / 0.5, 3.0)));
    assert!(metrics.ends_outside);
}

#[test]
fn what_a_log_cannot_tell_is_absent() {
    let nothing = measured("");
    assert_eq!((nothing.samples, nothing.duration_s, nothing.max_p), (0, 0.0, None));
    assert_eq!((nothing.mean_h, nothing.mean_b_s, nothing.sensitivity), (None, None, None));
    assert_eq!((nothing.duty, nothing.ends_outside), (None, false));
    // Zero without a sign.
    assert_eq!(measured("....").time_outside_s.to_string(), "0");
    let never_back = measured(".cc");
    assert_eq!((never_back.sensitivity, never_back.max_p), (None, Some(9.0)));
    assert_eq!(measured("--").max_p, None);
}

#[test]
fn a_trial_ends_outside_where_its_last_known_position_does() {
    let check = |rows: &str, expected: bool| assert_eq!(measured(rows).ends_outside, expected, "{rows}");
    check("..a", true);
    check(".a.", false);
    check("..o", false);
    check(".a-", true);
    check("a.-", false);
}

#[test]
fn the_border_is_within_five_percent_of_the_pictures_edge() {
    let check = |x: f64, y: f64, expected_s: f64| {
        let position = Some(barrelman_vocab::ImagePoint { x, y });
        let log = crate::trial_logs::log_from_rows([(position, None)]);
        let border_s = barrelman_trial::metrics::measure(&log, REGION, PICTURE).border_s;
        assert_eq!(border_s, expected_s, "{x}, {y}");
    };
    // 95 % of half of 1000 x 800.
    check(475.0, 0.0, 0.5);
    check(-475.0, 0.0, 0.5);
    check(474.9, 379.9, 0.0);
    check(0.0, 380.0, 0.5);
    check(0.0, -380.0, 0.5);
}

#[test]
fn rows_need_not_come_at_a_steady_rate() {
    let mut log: TrialLog = log_from(".ab.");
    for (row, time_s) in log.rows.iter_mut().zip([0.0, 1.0, 3.0, 7.0]) {
        row.time_s = time_s;
    }
    let [excursion] = find_excursions(&log, REGION)[..] else { panic!("one excursion") };
    assert_eq!((excursion.h, excursion.b_s), (3.0, 6.0));
    assert_eq!(log.duration_s(), 7.5);
}

#[test]
fn an_excursion_of_no_duration_has_no_sensitivity() {
    let mut log = log_from(".a.b.");
    for (row, time_s) in log.rows.iter_mut().zip([0.0, 1.0, 1.0, 2.0, 4.0]) {
        row.time_s = time_s;
    }
    let metrics = barrelman_trial::metrics::measure(&log, REGION, PICTURE);
    assert_eq!(metrics.complete_excursions, 2);
    assert_eq!(metrics.sensitivity, Some(3.0 / 2.0));
}
