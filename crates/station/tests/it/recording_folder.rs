//! The folder of the recordings that `run` makes without being asked.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, SystemTime};

use barrelman_host::output::OutputFile;
use barrelman_station::config::RecordingConfig;
use barrelman_station::live::recording_folder::open_next;

use crate::program::empty_folder;

const OLDEST: &str = "run-20260101T000000Z.mcap";
const OLD: &str = "run-20260201T000000Z.mcap";
const FOREIGN: &str = "sortie.mcap";

/// Writes a file of 600 bytes whose last change was `days` days ago.
fn write_old(path: &Path, days: u64) {
    fs::write(path, [0; 600]).unwrap();
    let changed = SystemTime::now() - Duration::from_secs(days * 86_400);
    fs::File::options().write(true).open(path).unwrap().set_modified(changed).unwrap();
}

/// Opens the next recording in a folder with files of 600 bytes, each a day newer than the one before. The
/// names of the files that are there afterwards, the new one left out.
fn kept(name: &str, files: &[&str], quota_bytes: f64) -> Vec<String> {
    let folder = empty_folder(name);
    for (days, file) in files.iter().rev().enumerate() {
        write_old(&folder.join(file), days as u64);
    }
    let config = RecordingConfig {
        enabled: true,
        folder: folder.clone(),
        quota_gb: quota_bytes / 1e9,
        reserve_gb: 0.0,
    };
    let mut file = open_next(&config).unwrap();
    file.write_all(b"new").unwrap();
    let own = file.path().to_owned();
    assert_eq!(own.parent(), Some(folder.as_path()));
    assert_eq!(fs::read(&own).unwrap(), b"new");
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let others = entries.filter(|path| *path != own);
    let mut names: Vec<String> =
        others.map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

#[test]
fn recordings_within_the_quota_are_kept() {
    assert_eq!(kept("recordings-within", &[OLDEST, OLD], 1200.0), [OLDEST, OLD]);
}

#[test]
fn the_oldest_recordings_are_removed_beyond_the_quota() {
    assert_eq!(kept("recordings-oldest", &[OLDEST, OLD], 1100.0), [OLD]);
    assert_eq!(kept("recordings-all", &[OLD, OLDEST], 100.0), [""; 0]);
}

#[test]
fn a_name_from_a_wrong_clock_does_not_make_a_recording_old() {
    let newest = "run-19700101T000012Z.mcap";
    assert_eq!(kept("recordings-clock", &[OLDEST, newest], 1100.0), [newest]);
}

#[test]
fn an_export_counts_and_goes_with_its_recording() {
    let folder = empty_folder("recordings-exports");
    for export in ["run-20260101T000000Z.export", "run-20260115T000000Z.export", "sortie.export"] {
        fs::create_dir(folder.join(export)).unwrap();
        fs::write(folder.join(export).join("annotated.mp4"), [0; 600]).unwrap();
    }
    write_old(&folder.join(OLDEST), 2);
    write_old(&folder.join(OLD), 1);
    let names = |quota_bytes: f64| {
        let quota_gb = quota_bytes / 1e9;
        let config = RecordingConfig { enabled: true, folder: folder.clone(), quota_gb, reserve_gb: 0.0 };
        drop(open_next(&config).unwrap());
        let entries = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<String> = entries.map(|name| name.into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names(2400.0).len(), 5, "all within the quota");
    let orphan = "run-20260115T000000Z.export";
    assert_eq!(names(1200.0), [orphan, OLD, "sortie.export"], "the film counts, and goes with its recording");
    assert_eq!(names(599.0), [orphan, "sortie.export"]);
    assert_eq!(names(0.0), [orphan, "sortie.export"], "an export without a recording was kept on purpose");
}

#[test]
fn a_recording_whose_film_is_being_made_stays() {
    let folder = empty_folder("recordings-film-in-use");
    let export = folder.join("run-20260101T000000Z.export");
    fs::create_dir(&export).unwrap();
    fs::write(folder.join(OLDEST), [0; 600]).unwrap();
    let _film = OutputFile::open(&export.join("annotated.mp4"), false).unwrap();
    let config = RecordingConfig { enabled: true, folder, quota_gb: 0.0, reserve_gb: 0.0 };
    drop(open_next(&config).unwrap());
    assert!(config.folder.join(OLDEST).exists() && export.exists());
}

#[test]
fn files_that_the_program_did_not_name_are_never_removed() {
    let foreign =
        [FOREIGN, "notes.txt", "run-notes.txt", "run-harbour.mcap", "old-run-20250101T000000Z.mcap"];
    let mut expected = foreign.map(str::to_owned);
    expected.sort();
    assert_eq!(kept("recordings-foreign", &[&foreign[..], &[OLDEST]].concat(), 1.0), expected);
}

#[test]
fn a_folder_that_is_not_there_is_made() {
    let folder = empty_folder("recordings-made").join("a/b");
    let config = RecordingConfig { enabled: true, folder: folder.clone(), quota_gb: 1.0, reserve_gb: 0.0 };
    drop(open_next(&config).unwrap());
    assert_eq!(fs::read_dir(folder).unwrap().count(), 0, "a recording that was never written is removed");
}

#[test]
fn a_folder_that_cannot_be_used_is_named() {
    let folder = empty_folder("recordings-unusable");
    fs::write(folder.join("file"), "").unwrap();
    let config =
        RecordingConfig { enabled: true, folder: folder.join("file"), quota_gb: 1.0, reserve_gb: 0.0 };
    let error = format!("{:#}", open_next(&config).unwrap_err());
    assert!(error.contains("the recordings' folder") && error.contains("file"), "{error}");
    let full = RecordingConfig { folder: folder.clone(), reserve_gb: 1e9, ..config };
    let error = format!("{:#}", open_next(&full).unwrap_err());
    assert!(error.contains("recording.reserve_gb"), "{error}");
    assert_eq!(fs::read_dir(folder).unwrap().count(), 1, "no recording was begun");
}

#[test]
fn a_disk_without_the_reserve_still_loses_what_is_beyond_the_quota() {
    let folder = empty_folder("recordings-full-disk");
    fs::write(folder.join(OLDEST), [0; 600]).unwrap();
    fs::write(folder.join(OLD), [0; 600]).unwrap();
    let config = RecordingConfig { enabled: true, folder, quota_gb: 600.0 / 1e9, reserve_gb: 1e9 };
    assert!(open_next(&config).is_err());
    assert!(!config.folder.join(OLDEST).exists(), "the quota holds on a full disk, too");
    assert!(config.folder.join(OLD).exists(), "a reserve beyond reach removes nothing");
}

#[test]
fn a_recording_that_is_being_written_stays() {
    let folder = empty_folder("recordings-in-use");
    let config = RecordingConfig { enabled: true, folder: folder.clone(), quota_gb: 0.0, reserve_gb: 0.0 };
    let mut written = OutputFile::open(&folder.join(OLD), false).unwrap();
    written.write_all(b"half").unwrap();
    fs::write(folder.join(OLDEST), "whole").unwrap();
    let mut next = open_next(&config).unwrap();
    next.write_all(b"new").unwrap();
    assert!(!folder.join(OLDEST).exists());
    assert!(folder.join(OLD).exists(), "another program writes it");
    drop((written, next));
    drop(open_next(&config).unwrap());
    assert!(!folder.join(OLD).exists());
}
