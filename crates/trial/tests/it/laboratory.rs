//! The authors' 30 laboratory logs: the law reproduces their commands, the metrics their published means.
//!
//! The logs are stored outside the repository. Where they are absent, these tests check nothing; on the build
//! server they fail.

use std::path::{Path, PathBuf};

use barrelman_control::LawSettings;
use barrelman_trial::law::run_open_loop;
use barrelman_trial::logs::{TrialLog, laboratory, read_text};
use barrelman_trial::metrics::{Arena, TrialEntry, TrialMetrics, measure, summarise};
use barrelman_vocab::VehicleProfile;

/// Name and text of every log; `None` where the folder is absent.
#[allow(clippy::print_stdout, reason = "a test that checks nothing says why")]
pub(crate) fn logs() -> Option<Vec<(String, String)>> {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/trials");
    if !folder.is_dir() {
        assert!(std::env::var_os("CI").is_none(), "{} is absent on the build server", folder.display());
        println!("not checked: {} is absent", folder.display());
        return None;
    }
    let mut paths: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    paths.sort();
    assert_eq!(paths.len(), 30);
    let named = |path: &PathBuf| {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read_to_string(path).unwrap())
    };
    Some(paths.iter().map(named).collect())
}

fn log_of(text: &str) -> TrialLog {
    let read = read_text(text).unwrap();
    assert_eq!(read.truncated_at_line, None);
    read.log
}

/// The fields of every row, unparsed.
fn fields(text: &str) -> Vec<Vec<&str>> {
    let rows = text.strip_prefix(laboratory::HEADER).unwrap().lines();
    rows.map(|row| row.split(',').collect()).collect()
}

/// The log with blank pitch, yaw and P.
fn blanked(text: &str) -> String {
    let mut blank = laboratory::HEADER.to_owned();
    for row in fields(text) {
        blank += &[&row[..2], &["", "", ""], &row[5..]].concat().join(",");
        blank.push('\n');
    }
    blank
}

fn metrics_of(text: &str) -> TrialMetrics {
    let log = log_of(text);
    measure(&log, log.region(VehicleProfile::fotokite_pro().region), log.picture)
}

#[test]
fn the_law_gives_every_recorded_command_and_p_from_the_positions_alone() {
    let Some(logs) = logs() else { return };
    let profile = VehicleProfile::fotokite_pro();
    let mut rows = 0;
    for (name, text) in &logs {
        let log = log_of(text);
        let region = log.region(profile.region);
        let law = run_open_loop(&log, region, &profile, LawSettings::MotorSchema);
        for (asked, (recorded, cells)) in law.iter().zip(log.rows.iter().zip(fields(text))) {
            let sent = recorded.command.map(|command| profile.to_vehicle(command));
            assert_eq!(Some(asked.rates), sent, "{name}, row {}", asked.row);
            let (p, recorded_p) = (asked.target.unwrap().1, cells[4].parse::<f64>().unwrap());
            // The program printed P with six significant digits.
            assert!((p - recorded_p).abs() <= 1e-5 * p.max(1.0), "{name}, row {}: {p}", asked.row);
            rows += 1;
        }
        assert_eq!(
            law,
            run_open_loop(&log_of(&blanked(text)), region, &profile, LawSettings::MotorSchema),
            "{name}"
        );
    }
    assert_eq!(rows, 71_914);
}

#[test]
fn the_metrics_give_the_published_means() {
    let Some(logs) = logs() else { return };
    let entry = |(name, text): &(String, String)| TrialEntry {
        name: name.clone(),
        arena: Arena::from_name(name),
        metrics: metrics_of(text),
    };
    let summary = summarise(logs.iter().map(entry).collect());
    assert_eq!(summary.pooled.mean_sensitivity, None);
    // Means by this definition of the sensitivity, and the published divisor n.
    let check = |number: &str, trials: usize, mean: f64, n: f64| {
        let figures = &summary.arenas[number];
        let found = figures.pooled.mean_sensitivity.unwrap();
        assert_eq!(figures.trials, trials);
        assert!((found - mean).abs() < 0.0003, "arena {number}: {found}");
        assert_eq!(figures.pooled.normalised_sensitivity, Some(found / n));
    };
    check("1", 13, 0.6055, 18.0);
    check("2", 17, 0.4535, 13.0);
    assert_eq!(summary.arenas["1"].pooled.success_rate, Some(1.0));
    assert_eq!(summary.arenas["2"].pooled.success_rate, Some(13.0 / 17.0));
    let outside: Vec<&str> = summary
        .trials
        .iter()
        .filter(|trial| trial.metrics.ends_outside)
        .map(|trial| trial.name.as_str())
        .collect();
    assert_eq!(outside, ["arena2_03", "arena2_04", "arena2_05", "arena2_07"]);
}

/// Name, excursions, complete excursions, time outside in s, commands begun (from rest or from another
/// command), largest P, sensitivity, computed from the same logs by another program. Tolerances: half a unit
/// of its last printed digit.
const EACH_TRIAL: [(&str, usize, usize, f64, usize, f64, f64); 30] = [
    ("arena1_01", 17, 17, 24.2, 20, 2.65, 0.304),
    ("arena1_02", 16, 16, 16.9, 18, 1.53, 0.314),
    ("arena1_03", 19, 19, 16.9, 19, 2.2, 0.327),
    ("arena1_04", 13, 13, 15.9, 14, 3.09, 0.341),
    ("arena1_05", 8, 8, 13.0, 8, 3.27, 1.373),
    ("arena1_06", 11, 11, 19.5, 13, 2.71, 0.77),
    ("arena1_07", 10, 10, 15.0, 10, 4.52, 0.288),
    ("arena1_08", 10, 10, 15.4, 10, 3.71, 0.528),
    ("arena1_09", 14, 14, 20.2, 17, 3.15, 0.583),
    ("arena1_10", 9, 9, 15.7, 11, 4.87, 0.959),
    ("arena1_11", 5, 5, 21.1, 10, 4.82, 0.757),
    ("arena1_12", 11, 11, 18.7, 14, 4.22, 1.017),
    ("arena1_13", 13, 13, 16.2, 13, 3.72, 0.311),
    ("arena2_01", 11, 11, 16.3, 13, 2.21, 0.431),
    ("arena2_02", 9, 9, 15.4, 12, 2.38, 0.289),
    ("arena2_03", 2, 1, 14.9, 7, 4.9, 2.646),
    ("arena2_04", 2, 1, 12.6, 4, 4.89, 0.243),
    ("arena2_05", 8, 7, 7.7, 9, 1.83, 0.191),
    ("arena2_06", 7, 7, 6.9, 8, 1.33, 0.168),
    ("arena2_07", 6, 5, 7.9, 6, 2.3, 0.242),
    ("arena2_08", 6, 6, 8.1, 6, 1.58, 0.267),
    ("arena2_09", 6, 6, 8.6, 6, 2.57, 0.38),
    ("arena2_10", 7, 7, 6.9, 7, 1.57, 0.315),
    ("arena2_11", 6, 6, 6.5, 6, 1.71, 0.403),
    ("arena2_12", 5, 5, 7.4, 5, 2.7, 0.598),
    ("arena2_13", 5, 5, 8.4, 5, 1.66, 0.41),
    ("arena2_14", 5, 5, 8.2, 5, 1.97, 0.328),
    ("arena2_15", 6, 6, 8.2, 6, 1.75, 0.303),
    ("arena2_16", 5, 5, 8.5, 5, 1.74, 0.292),
    ("arena2_17", 6, 6, 6.9, 6, 1.4, 0.206),
];

#[test]
fn the_metrics_of_each_trial_agree_with_another_program() {
    let Some(logs) = logs() else { return };
    for ((name, text), row) in logs.iter().zip(EACH_TRIAL) {
        let (expected_name, excursions, complete, outside_s, begun, max_p, sensitivity) = row;
        let found = metrics_of(text);
        assert_eq!(name, expected_name);
        assert_eq!((found.excursions, found.complete_excursions), (excursions, complete), "{name}");
        let (moves, switches) = found.moves.zip(found.switches).unwrap();
        // A command starts from rest exactly where an excursion does.
        assert_eq!((moves, moves + switches), (excursions, begun), "{name}");
        let close = |found: f64, expected: f64, within: f64| (found - expected).abs() <= within + 1e-9;
        assert!(close(found.time_outside_s, outside_s, 0.05), "{name}: {} s", found.time_outside_s);
        assert!(close(found.max_p.unwrap(), max_p, 0.005), "{name}: P {:?}", found.max_p);
        let s = found.sensitivity.unwrap();
        assert!(close(s, sensitivity, 0.0005), "{name}: s {s}");
        // The law moves one axis, and exactly while P > 1.
        assert!(close(found.movement_s.unwrap(), found.time_outside_s, 1e-9), "{name}");
        assert_eq!((found.both_axes, found.lost), (Some(0.0), None), "{name}");
    }
}
