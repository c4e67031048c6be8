//! Recordings, drives and campaigns state the program that made them; commands name a difference.

use std::fs::File;
use std::path::Path;

use barrelman_experiments::drive::{DriveSetup, DriveWriter, StoredDrive};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_experiments::world_url::WorldUrl;
use barrelman_host::output::OutputFile;
use barrelman_trial::records::{Entry, RecordingReader, RecordingStart, RecordingWriter};
use barrelman_vocab::VehicleProfile;
use barrelman_vocab::{CameraRequest, PictureSize};

use crate::program::{argument, barrelman, empty_folder, failed, succeeded};

const TRIAL: [&str; 7] = ["trials", "lab2", "--perception", "truth", "--seed", "500", "--trials"];

/// Copies a recording with a changed start message.
pub(crate) fn rewrite(from: &Path, to: &Path, change: impl FnOnce(&mut RecordingStart)) {
    let mut entries = RecordingReader::new(File::open(from).unwrap()).map(Result::unwrap);
    let Some(Entry::Start(mut start)) = entries.next() else { panic!("it begins with its start") };
    change(&mut start);
    let mut writer =
        RecordingWriter::begin(File::create(to).unwrap(), &start, &VehicleProfile::fotokite_pro()).unwrap();
    entries.for_each(|entry| writer.write(&entry).unwrap());
    writer.finish().unwrap();
}

#[test]
fn a_replay_names_another_program_than_the_one_that_recorded() {
    let folder = empty_folder("program-recording");
    succeeded(&barrelman(
        &[&TRIAL[..], &["1", "--law", "optimal", "--mode", "minimum-energy", "--record", argument(&folder)]]
            .concat(),
    ));
    let recording = folder.join("lab2-500.mcap");
    let printed = succeeded(&barrelman(&["replay", argument(&recording), "--compare"]));
    assert!(printed.contains("bit for bit") && !printed.contains("may differ"), "{printed}");

    let other = folder.join("other.mcap");
    rewrite(&recording, &other, |start| start.program = "0.0.9+0123456789abcdef".to_owned());
    let printed = succeeded(&barrelman(&["replay", argument(&other), "--compare"]));
    let named = "recorded by barrelman 0.0.9+0123456789abcdef, this program is 0.1.0+";
    assert!(printed.contains(named) && printed.contains("outcomes may differ\nevery"), "{printed}");

    rewrite(&recording, &other, |start| {
        start.configuration = start.configuration.replace("minimum-energy", "eco");
    });
    let output = barrelman(&["replay", argument(&other), "--compare"]);
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!output.status.success() && printed.contains("commands differ"), "{printed}");
}

#[test]
fn the_replay_of_a_drive_names_another_program_than_the_one_that_stored_it() {
    let folder = empty_folder("program-drive");
    let path = folder.join("drive.jsonl");
    let url = WorldUrl { size: Some(PictureSize::new(192, 108)), ..WorldUrl::new("open") };
    let setup = DriveSetup::new(url, TrackerName::Camshift, LawChoice::OPTIMAL, false).unwrap();
    let mut writer = DriveWriter::begin(OutputFile::open(&path, true).unwrap(), &setup).unwrap();
    writer.add(0, CameraRequest::Engage.into()).unwrap();
    writer.finish(60, "0123456789abcdef".to_owned()).unwrap();
    let stored = StoredDrive::read(&path).unwrap();
    assert!(stored.program.starts_with("0.1.0+"), "{}", stored.program);
    // The stored hash is not the hash of this drive.
    let named = format!(
        "the drive differs: the stored hash is 0123456789abcdef; barrelman {} stored the drive",
        stored.program
    );
    failed(&barrelman(&["demo", "--replay", argument(&path)]), 1, &[&named]);
}

#[test]
fn campaigns_of_two_programs_are_neither_continued_nor_merged() {
    let folder = empty_folder("program-campaign");
    let path = folder.join("campaign.jsonl");
    succeeded(&barrelman(&[&TRIAL[..], &["2", "--output", argument(&path)]].concat()));
    let written = std::fs::read_to_string(&path).unwrap();
    let (before, after) = written.split_once("\"program\":\"0.1.0+").unwrap();
    let program = format!("0.1.0+{}", &after[..16]);
    assert!(!before.contains('\n'), "each line states the program");

    let other = folder.join("other.jsonl");
    std::fs::write(&other, written.replace(&program, "0.0.9+0123456789abcdef")).unwrap();
    let resumed = [&TRIAL[..], &["3", "--resume", "--output", argument(&other)]].concat();
    let named =
        format!("line 1 was run with barrelman 0.0.9+0123456789abcdef, this program is {program}; run all");
    failed(&barrelman(&resumed), 1, &[&named]);
    let named = format!("the first was run with barrelman {program}, the second with 0.0.9+0123456789abcdef");
    failed(&barrelman(&["merge", argument(&path), argument(&other)]), 1, &[&named]);
    succeeded(&barrelman(&["compare", argument(&path), argument(&other)]));
}
