//! Recordings, drives and campaigns store the law's mode and the behaviour versions of tracker and law; commands name a
//! difference of versions.

use std::fs::File;
use std::path::Path;
use std::process::Output;

use barrelman_experiments::drive::{DriveInput, DriveSetup, DriveWriter, StoredDrive};
use barrelman_experiments::law_choice::{LawChoice, LawName, ModeName};
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_experiments::world_url::WorldUrl;
use barrelman_host::output::OutputFile;
use barrelman_trial::behaviour::BehaviourVersions;
use barrelman_trial::records::{Entry, RecordingReader, RecordingStart, RecordingWriter};
use barrelman_vocab::PictureSize;

use crate::program::{argument, barrelman, empty_folder, failed, succeeded};

const TRIAL: [&str; 7] = ["trials", "lab2", "--perception", "truth", "--seed", "500", "--trials"];

/// Copies a recording with a changed start message.
pub(crate) fn rewrite(from: &Path, to: &Path, change: impl FnOnce(&mut RecordingStart)) {
    let mut entries = RecordingReader::new(File::open(from).unwrap()).map(Result::unwrap);
    let Some(Entry::Start(mut start)) = entries.next() else { panic!("it begins with its start") };
    change(&mut start);
    let mut writer = RecordingWriter::begin(File::create(to).unwrap(), &start).unwrap();
    entries.for_each(|entry| writer.write(&entry).unwrap());
    writer.finish().unwrap();
}

/// The law that a file without modes stands for.
const LEAST_ENERGY: LawChoice =
    LawChoice { mode: Some(ModeName::MinimumEnergy), ..LawChoice::new(LawName::Optimal) };

#[test]
fn a_recording_states_mode_and_versions_and_replay_names_a_difference() {
    let folder = empty_folder("versions-recording");
    succeeded(&barrelman(
        &[&TRIAL[..], &["1", "--law", "optimal", "--mode", "minimum-energy", "--record", argument(&folder)]]
            .concat(),
    ));
    let recording = folder.join("lab2-500.mcap");
    let Some(Ok(Entry::Start(start))) = RecordingReader::new(File::open(&recording).unwrap()).next() else {
        panic!("it begins with its start")
    };
    assert!(start.configuration.contains("mode = \"minimum-energy\""), "{}", start.configuration);
    let current = LEAST_ENERGY.behaviour_with(TrackerName::Camshift);
    assert_eq!(start.behaviour, current);
    let (law, tracker) = (current.law, current.tracker);

    let other = folder.join("other.mcap");
    rewrite(&recording, &other, |start| start.behaviour.law = 70);
    let printed = succeeded(&barrelman(&["replay", argument(&other), "--compare"]));
    let named = format!(
        "recorded with the optimal law's behaviour 70, this program has {law}: outcomes may differ\nevery"
    );
    assert!(printed.contains(&named), "{printed}");

    rewrite(&recording, &other, |start| {
        start.behaviour = BehaviourVersions { tracker: 60, law: 70 };
        start.configuration = start.configuration.replace("minimum-energy", "eco");
    });
    let output = barrelman(&["replay", argument(&other), "--compare"]);
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let named = format!(
        "recorded with the camshift tracker's behaviour 60 and the optimal law's behaviour 70, this program has \
         {tracker} and {law}: outcomes may differ\n"
    );
    assert!(
        !output.status.success() && printed.contains(&named) && printed.contains("commands differ"),
        "{printed}"
    );

    // Another law than the recorded one has no version to compare.
    let schema = folder.join("schema.toml");
    std::fs::write(&schema, "[law]\nname = \"schema\"\n[tracker]\nname = \"camshift\"\n").unwrap();
    let printed = succeeded(&barrelman(&["replay", argument(&other), "--config", argument(&schema)]));
    assert!(
        printed.contains("camshift tracker's behaviour 60,") && !printed.contains("law's behaviour"),
        "{printed}"
    );

    // A recording from before the versions, when an absent mode was the default mode.
    rewrite(&recording, &other, |start| {
        start.behaviour = BehaviourVersions { tracker: 0, law: 0 };
        start.configuration = start.configuration.replace("mode = \"minimum-energy\"\n", "");
    });
    assert_eq!(
        succeeded(&barrelman(&["replay", argument(&other), "--compare"])).contains("this program has"),
        (tracker, law) != (1, 1),
        "version 1 is that of files which state none"
    );
}

#[test]
fn a_drive_states_mode_and_versions_and_its_replay_names_a_difference() {
    let folder = empty_folder("versions-drive");
    let path = folder.join("drive.jsonl");
    let url = WorldUrl { size: Some(PictureSize::new(192, 108)), ..WorldUrl::new("open") };
    let setup = DriveSetup::new(url, TrackerName::Camshift, LEAST_ENERGY, false).unwrap();
    let mut writer = DriveWriter::begin(OutputFile::open(&path, true).unwrap(), &setup).unwrap();
    writer.add(0, DriveInput::Engage).unwrap();
    writer.finish(60, "0123456789abcdef".to_owned()).unwrap();
    let written = std::fs::read_to_string(&path).unwrap();
    let stated = r#""tracker":"camshift","tracker_behaviour":1,"law":{"name":"optimal","mode":"minimum-energy"},"law_behaviour":1,"#;
    assert!(written.contains(stated), "{written}");
    assert_eq!(StoredDrive::read(&path).unwrap().behaviour, setup.law.behaviour_with(setup.tracker));
    // The stored hash is not the hash of this drive.
    failed(
        &barrelman(&["demo", "--replay", argument(&path)]),
        1,
        &["the drive differs: the stored hash is 0123456789abcdef"],
    );

    std::fs::write(&path, written.replace("\"tracker_behaviour\":1", "\"tracker_behaviour\":60")).unwrap();
    let named = "the drive was stored with the camshift tracker's behaviour 60, this program has 1";
    failed(&barrelman(&["demo", "--replay", argument(&path)]), 1, &[named]);

    // A drive from before the versions, when an absent mode was the default mode.
    let of_before = r#""tracker":"camshift","law":{"name":"optimal"},"#;
    std::fs::write(&path, written.replace(stated, of_before)).unwrap();
    let read = StoredDrive::read(&path).unwrap();
    assert_eq!((read.behaviour, read.setup.law), (BehaviourVersions::default(), LEAST_ENERGY));
    assert_ne!(LawChoice::OPTIMAL, LEAST_ENERGY, "the default of today is another one");
}

#[test]
fn campaigns_of_different_versions_are_different_and_the_difference_is_named() {
    let folder = empty_folder("versions-campaign");
    let path = folder.join("campaign.jsonl");
    succeeded(&barrelman(
        &[&TRIAL[..], &["2", "--law", "optimal", "--mode", "minimum-energy", "--output", argument(&path)]]
            .concat(),
    ));
    let written = std::fs::read_to_string(&path).unwrap();
    let stated = r#""law":"optimal","law_behaviour":1,"mode":"minimum-energy","#;
    assert!(written.contains(stated), "{written}");

    // A file from before the versions is read, continued and merged as a file of version 1.
    let of_before = folder.join("before.jsonl");
    std::fs::write(&of_before, written.replace(stated, r#""law":"optimal","#)).unwrap();
    succeeded(&barrelman(&["compare", argument(&path), argument(&of_before)]));
    succeeded(&barrelman(&["merge", argument(&path), argument(&of_before)]));
    assert_eq!(
        succeeded(&barrelman(&["metrics", argument(&path), "--json"])),
        succeeded(&barrelman(&["metrics", argument(&of_before), "--json"]))
    );
    succeeded(&barrelman(&[
        "report",
        argument(&of_before),
        "--output",
        argument(&folder.join("report.html")),
    ]));
    let resume = |path: &Path| -> Output {
        let options =
            ["3", "--law", "optimal", "--mode", "minimum-energy", "--resume", "--output", argument(path)];
        barrelman(&[&TRIAL[..], &options].concat())
    };
    assert!(resume(&of_before).status.success());
    assert_eq!(std::fs::read_to_string(&of_before).unwrap().lines().count(), 3);

    let other = folder.join("other.jsonl");
    std::fs::write(&other, written.replace("\"law_behaviour\":1", "\"law_behaviour\":70")).unwrap();
    let named = "line 1 was run with the optimal law's behaviour 70, this program has 1";
    let output = resume(&other);
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && printed.contains(named), "{printed}");
    let named = "the first was run with the optimal law's behaviour 1, the second with 70";
    failed(&barrelman(&["merge", argument(&path), argument(&other)]), 1, &[named]);
}
