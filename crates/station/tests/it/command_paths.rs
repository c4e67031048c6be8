//! A recording states where the pilot's commands went, and is replayed so.

use std::fs;
use std::path::{Path, PathBuf};

use barrelman_pilot::CommandPath;
use barrelman_station::commands::run::build_pilot;
use barrelman_station::config::{self, Configuration};
use barrelman_trial::records::{
    Entry, RecordedInput, RecordedOutcome, RecordedVideo, RecordingStart, RecordingWriter,
};
use barrelman_vocab::VehicleProfile;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{CameraRequest, OperatorRequest, Telemetry, Timestamp, Track};

use crate::live_scenes::{at, localisation};
use crate::program::{argument, barrelman, empty_folder, failed, succeeded};

const CONFIGURATION: &str = "[law]\nname = \"schema\"\n[tracker]\nname = \"camshift\"\n";

/// Records an engaged pilot whose link comes up after a second, and whose commands took `made`; the recording
/// states `stated`. Returns the file, and whether the camera was commanded to move before the link was up.
fn record(name: &str, made: CommandPath, stated: CommandPath) -> (PathBuf, bool) {
    let configuration = Configuration::resolve(&config::parse(CONFIGURATION).unwrap()).unwrap();
    let start = RecordingStart {
        program: "0.1.0".to_owned(),
        monotonic_ns: 0,
        unix_ns: 0,
        configuration: configuration.to_toml().unwrap(),
        videos: RecordedVideo::only("file:pictures", false),
        link: "tcp://127.0.0.1:5000".to_owned(),
        command_path: stated,
        trial: None,
    };
    let path = empty_folder(name).join("run.mcap");
    let mut writer =
        RecordingWriter::begin(fs::File::create(&path).unwrap(), &start, &VehicleProfile::fotokite_pro())
            .unwrap();
    let mut pilot = build_pilot(&configuration, made).unwrap();
    let report = |state, now: Timestamp| Telemetry { at: now, report: Report::Link(state) };
    let mut inputs = vec![
        (1_000, RecordedInput::Request(OperatorRequest::Camera(CameraRequest::Engage))),
        (1_010, RecordedInput::Telemetry(report(LinkState::Starting, at(1_010)))),
        (2_000, RecordedInput::Telemetry(report(LinkState::Up, at(2_000)))),
    ];
    let look = |ms| (ms + 200, RecordedInput::Localisation(Track::Tracking(localisation(at(ms)))));
    inputs.extend((1_000..3_000).step_by(33).map(look));
    inputs.sort_by_key(|(ms, _)| *ms);
    let mut moved_early = false;
    for (step, (ms, input)) in (0..).zip(inputs) {
        let outcome = pilot.step(input.to_input(|_| Err("there is no video")).unwrap(), at(ms));
        moved_early |= ms < 2_000 && !outcome.command.is_rest();
        let rates = configuration.profile.to_vehicle(outcome.command);
        writer.write(&Entry::Input { step, now: at(ms), input }).unwrap();
        writer.write(&Entry::Outcome(RecordedOutcome::new(step, &outcome, rates))).unwrap();
    }
    writer.finish().unwrap();
    (path, moved_early)
}

fn compare(path: &Path) -> std::process::Output {
    barrelman(&["replay", argument(path), "--compare"])
}

#[test]
fn each_path_is_replayed_as_it_is_recorded() {
    for (name, made) in [
        ("paths-link", CommandPath::Link),
        ("paths-simulated", CommandPath::Simulated),
        ("paths-dry-run", CommandPath::DryRun),
    ] {
        let (path, moved_early) = record(name, made, made);
        assert_eq!(moved_early, made == CommandPath::Simulated, "{made:?}");
        assert!(succeeded(&compare(&path)).contains("every command is the same, bit for bit"));
    }
}

#[test]
fn a_recording_that_states_another_path_is_found() {
    let (path, _) = record("paths-wrong", CommandPath::Simulated, CommandPath::Link);
    failed(&compare(&path), 1, &[]);
}

#[test]
fn the_exported_table_of_a_dry_run_can_be_read_again() {
    let (path, _) = record("paths-exported", CommandPath::DryRun, CommandPath::DryRun);
    let out = path.with_file_name("out");
    succeeded(&barrelman(&["export", "--output", argument(&out), argument(&path)]));
    let table = out.join("trial.csv");
    assert!(fs::read_to_string(&table).unwrap().contains("\"holding: dry run, nothing is sent\""));
    succeeded(&barrelman(&["metrics", argument(&table)]));
}
