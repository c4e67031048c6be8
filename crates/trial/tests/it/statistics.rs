//! Means, intervals and paired comparisons, against published tables and values computed by hand.

use barrelman_trial::campaign::CampaignComparison;
use barrelman_trial::campaign::statistics::{Bootstrap, mean_interval, student_t_975};
use barrelman_trial::metrics::{TrialEntry, measure};
use barrelman_vocab::ImagePoint;

use crate::trial_logs::{PICTURE, REGION, command, log_from_rows};

#[test]
fn students_quantiles_are_those_of_the_tables() {
    for (degrees, expected) in [
        (1, 12.706),
        (2, 4.303),
        (3, 3.182),
        (4, 2.776),
        (5, 2.571),
        (11, 2.201),
        (14, 2.145),
        (30, 2.042),
        (199, 1.972),
    ] {
        let found = student_t_975(degrees);
        assert!((found / expected - 1.0).abs() < 2.5e-3, "{degrees}: {found}, expected {expected}");
    }
}

#[test]
fn a_mean_comes_with_its_interval() {
    let interval = mean_interval(&[1.0, 2.0, 3.0, 4.0, 5.0]).expect("five values");
    assert_eq!(interval.value, 3.0);
    // 2.776 times the root of 2.5 over 5.
    assert!((interval.high - 3.0 - 1.963).abs() < 0.005, "{interval:?}");
    assert!((interval.high + interval.low - 6.0).abs() < 1e-12, "{interval:?}");
    assert_eq!(mean_interval(&[1.0]), None);
    assert_eq!(mean_interval(&[]), None);
}

#[test]
fn a_bootstrap_is_the_same_each_time_and_about_as_wide_as_students() {
    let values: Vec<f64> = (0..40).map(|index| f64::from(index * 7919 % 40)).collect();
    let mean =
        |sample: &[usize]| sample.iter().map(|index| values[*index]).sum::<f64>() / sample.len() as f64;
    let once = Bootstrap::DEFAULT.interval(values.len(), mean).expect("values");
    assert_eq!(Some(once), Bootstrap::DEFAULT.interval(values.len(), mean));
    let student = mean_interval(&values).expect("values");
    assert_eq!(once.value, student.value);
    let ratio = (once.high - once.low) / (student.high - student.low);
    assert!((0.85..1.05).contains(&ratio), "{ratio}");
    assert_eq!(Bootstrap::DEFAULT.interval(0, |_| 1.0), None);
}

fn trial(name: &str, rate: f64) -> TrialEntry {
    let inside = Some(ImagePoint { x: 0.0, y: 0.0 });
    let log = log_from_rows([(inside, Some(command(rate, 0.0))), (inside, Some(command(0.0, 0.0)))]);
    TrialEntry { name: name.to_owned(), arena: None, metrics: measure(&log, REGION, PICTURE) }
}

#[test]
fn campaigns_are_paired_by_name() {
    let first = [trial("lab1/1", 0.25), trial("lab1/2", 0.5), trial("lab1/3", 1.0)];
    let second = [trial("lab1/4", 9.0), trial("lab1/2", 1.0), trial("lab1/1", 0.5)];
    let comparison =
        CampaignComparison::new(&first, &second, &Bootstrap { resamples: 200, ..Bootstrap::DEFAULT });
    assert_eq!(comparison.pairs, 2);
    assert_eq!(comparison.only_first, ["lab1/3"]);
    assert_eq!(comparison.only_second, ["lab1/4"]);
    let travel = comparison.metrics.iter().find(|metric| metric.metric == "integral of |rate|").expect("it");
    // Each row lasts half a second; the second campaign turned twice as fast in each pair.
    assert_eq!((travel.first, travel.second), (0.1875, 0.375));
    let ratio = travel.ratio.expect("a ratio");
    assert_eq!((ratio.value, ratio.low, ratio.high), (2.0, 2.0, 2.0));
    assert_eq!(travel.difference.map(|difference| difference.value), Some(0.1875));
}
