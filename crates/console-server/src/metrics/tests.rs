//! The text of the metrics, line by line.

use std::collections::BTreeSet;

use barrelman_control::{Percept, Region};
use barrelman_pilot::{Mode, Outcome};
use barrelman_vocab::{ImagePoint, StopCause, Timestamp, Track, VehicleProfile, Videos};
use serde_json::Value;

use super::super::status::status_of;
use super::*;
use crate::snapshot::{LinkStatus, RecordingState, Snapshot, VehicleSnapshot};
use crate::test_scenes::{PICTURE, at, command, idle, localisation};

/// The samples of a text in Prometheus' format, after a check of each of its lines.
fn samples_of(text: &str) -> Vec<(&str, f64)> {
    assert!(text.ends_with('\n'), "the last line ends, too");
    let lines: Vec<_> = text.lines().collect();
    let samples = lines.chunks(3).map(|lines| {
        let [help, kind, sample] = lines else { panic!("HELP, TYPE and a sample: {lines:?}") };
        let (name, value) = sample.split_once(' ').unwrap();
        let help = help.strip_prefix(&format!("# HELP {name} ")).unwrap_or_else(|| panic!("{help}"));
        let kind = kind.strip_prefix(&format!("# TYPE {name} ")).unwrap_or_else(|| panic!("{kind}"));
        assert!(!help.is_empty() && ["counter", "gauge"].contains(&kind), "{lines:?}");
        assert_eq!(kind == "counter", name.ends_with("_total"), "{name} is a {kind}");
        let own = name.strip_prefix("barrelman_").unwrap_or_else(|| panic!("{name}"));
        assert!(own.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_'), "{name}");
        (own, value.parse().unwrap())
    });
    let samples: Vec<_> = samples.collect();
    let names: BTreeSet<_> = samples.iter().map(|(name, _)| name).collect();
    assert_eq!(names.len(), samples.len(), "each metric is there once");
    samples
}

/// The metrics of a snapshot, with two pages, contain these.
#[track_caller]
fn check(snapshot: &Snapshot, expected: &[(&str, f64)]) {
    let text = metrics_text(&status_of(snapshot, &Videos::default()), 2);
    let samples = samples_of(&text);
    for sample in expected {
        assert!(samples.contains(sample), "{sample:?} is not in {samples:?}");
    }
}

fn after(outcome: Outcome) -> Snapshot {
    Snapshot { steps: 7, outcome: Some(outcome), ..Snapshot::default() }
}

#[test]
fn what_is_not_known_is_left_out() {
    let text = metrics_text(&status_of(&Snapshot::default(), &Videos::default()), 0);
    let names: Vec<_> = samples_of(&text).into_iter().map(|(name, _)| name).collect();
    for unknown in ["p", "track_confidence", "video_age_seconds"] {
        assert!(!names.contains(&unknown), "{unknown}");
    }
    assert!(names.contains(&"steps_total"), "{names:?}");
}

#[test]
fn a_step_is_given_in_the_units_of_the_names() {
    let track = Track::Tracking(localisation(at(0)));
    let servoing =
        after(Outcome { mode: Mode::Servoing, track, command: command(0.25, -0.125), ..idle(at(40)) });
    let rates = [("pan_rate_radians_per_second", 0.25), ("tilt_rate_radians_per_second", -0.125)];
    check(&servoing, &rates);
    check(&servoing, &[("steps_total", 7.0), ("tracking", 1.0), ("track_confidence", 0.75)]);
    check(&servoing, &[("engaged", 1.0), ("stopped", 0.0), ("alarms", 0.0), ("console_clients", 2.0)]);
    let mut aged = servoing.clone();
    aged.video.age = Some(std::time::Duration::from_millis(250));
    (aged.video.fps, aged.video.dropped) = (25.0, 3);
    let video =
        [("video_age_seconds", 0.25), ("video_frames_per_second", 25.0), ("video_dropped_total", 3.0)];
    check(&aged, &video);
}

#[test]
fn flags_are_one_while_something_is_so() {
    let stopped = Mode::Stopped(StopCause::Operator);
    check(&after(Outcome { mode: stopped, ..idle(at(0)) }), &[("engaged", 0.0), ("stopped", 1.0)]);
    let lost = Track::Lost { since: Timestamp::ZERO, confidence: 0.5 };
    check(&after(Outcome { track: lost, ..idle(at(0)) }), &[("tracking", 0.0), ("track_confidence", 0.5)]);
    for (link, is_up) in [(LinkStatus::DryRun, 0.0), (LinkStatus::Simulated, 1.0)] {
        let vehicle = VehicleSnapshot { link, ..VehicleSnapshot::default() };
        check(&Snapshot { vehicle, ..Snapshot::default() }, &[("link_up", is_up)]);
    }
    let recording = RecordingState::On("a.mcap".to_owned());
    check(&Snapshot { recording, ..Snapshot::default() }, &[("recording", 1.0)]);
    check(&Snapshot { stops_taken: 4, ..Snapshot::default() }, &[("stops_total", 4.0), ("recording", 0.0)]);
}

#[test]
fn work_adds_up() {
    let mut snapshot = Snapshot::default();
    (snapshot.work.camera.moves, snapshot.work.camera.travel_rad) = (3, 1.5);
    check(&snapshot, &[("camera_moves_total", 3.0), ("camera_travel_radians_total", 1.5)]);
}

#[test]
fn numbers_without_end_are_numbers_to_prometheus_too() {
    let mut snapshot = Snapshot::default();
    snapshot.work.camera.travel_rad = f64::INFINITY;
    check(&snapshot, &[("camera_travel_radians_total", f64::INFINITY)]);
}

/// A snapshot in which everything is known.
fn complete() -> Snapshot {
    let track = Track::Tracking(localisation(at(0)));
    let region = Region::from_shares(VehicleProfile::fotokite_pro().region, PICTURE);
    let percept = Some(Percept::new(ImagePoint { x: 96.0, y: 0.0 }, region));
    let mut snapshot = after(Outcome { track, percept, ..idle(at(40)) });
    let known = Some(std::time::Duration::from_millis(20));
    (snapshot.video.age, snapshot.video.step_time) = (known, known);
    snapshot
}

/// The names of metrics in the queries below a value of a dashboard.
fn add_queried(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            let queries = ["expr", "query"].into_iter().filter_map(|key| fields.get(key)?.as_str());
            let words = queries.flat_map(|text| text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_'));
            names.extend(words.filter_map(|word| word.strip_prefix("barrelman_")).map(str::to_owned));
            fields.values().for_each(|value| add_queried(value, names));
        }
        Value::Array(values) => values.iter().for_each(|value| add_queried(value, names)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

#[test]
fn the_dashboard_for_grafana_shows_what_is_served_and_nothing_else() {
    let dashboard = include_str!("../../../../docs/grafana-dashboard.json");
    let mut queried = BTreeSet::new();
    add_queried(&serde_json::from_str(dashboard).unwrap(), &mut queried);
    let text = metrics_text(&status_of(&complete(), &Videos::default()), 2);
    let served: BTreeSet<_> = samples_of(&text).into_iter().map(|(name, _)| name.to_owned()).collect();
    assert_eq!(queried, served);
}
