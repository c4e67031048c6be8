//! Output files: existing files are kept, links are not followed, and failed work leaves no files behind.

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::Path;

use barrelman_host::output::{OutputFile, create};

use crate::program::{barrelman_in, empty_folder, failed, succeeded};

const CLIP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");

fn files_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_that_exists_is_kept_unless_it_may_be_overwritten() {
    let path = empty_folder("output-files-exists").join("there");
    fs::write(&path, "precious, and longer than what comes").unwrap();
    let refusal = OutputFile::open(&path, false).unwrap_err().to_string();
    assert!(refusal.contains("exists already") && refusal.contains("--force"), "{refusal}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious, and longer than what comes");
    // Opened for overwriting but never written, as by work that failed.
    drop(OutputFile::open(&path, true).unwrap());
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious, and longer than what comes");
    OutputFile::open(&path, true).unwrap().write_all(b"new").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    drop(create(&path, true).unwrap());
    assert_eq!(fs::read_to_string(&path).unwrap(), "");
}

/// The permissions of a file.
fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o777
}

#[test]
fn a_new_file_is_for_its_owner_alone() {
    let path = empty_folder("output-files-mode").join("out");
    OutputFile::open(&path, false).unwrap().write_all(b"one").unwrap();
    assert_eq!(mode(&path), 0o600);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
    OutputFile::open(&path, true).unwrap().write_all(b"two").unwrap();
    assert_eq!(mode(&path), 0o600, "also where it takes the place of one that others could read");
}

#[test]
fn another_name_of_a_file_that_is_overwritten_keeps_the_old_content() {
    let folder = empty_folder("output-files-hard-link");
    let (path, other) = (folder.join("out"), folder.join("other"));
    fs::write(&path, "old").unwrap();
    fs::hard_link(&path, &other).unwrap();
    let mut file = OutputFile::open(&path, true).unwrap();
    assert!(OutputFile::open(&path, true).is_err(), "it is taken before the first write, too");
    file.write_all(b"new").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new", "it can be read while it grows");
    assert!(OutputFile::open(&path, true).is_err() && OutputFile::resume(&path).is_err());
    file.write_all(b" and more").unwrap();
    drop(file);
    assert_eq!(fs::read_to_string(&path).unwrap(), "new and more");
    assert_eq!(fs::read_to_string(&other).unwrap(), "old");
    drop(OutputFile::open(&path, true).unwrap());
    assert_eq!(files_in(&folder), ["other", "out"], "work without a result leaves nothing beside it");
    let mut file = OutputFile::open(Path::new("/dev/null"), true).unwrap();
    file.write_all(b"nothing").unwrap();
}

#[test]
fn a_link_is_never_followed() {
    let folder = empty_folder("output-files-links");
    let target = folder.join("target");
    for (link, leads_to) in [("dangling", "target"), ("to-a-file", "file"), ("to-itself", "to-itself")] {
        let link = folder.join(link);
        fs::write(folder.join("file"), "precious").unwrap();
        symlink(leads_to, &link).unwrap();
        for force in [false, true] {
            let refusal = OutputFile::open(&link, force).unwrap_err().to_string();
            assert!(refusal.contains("symbolic link"), "{refusal}");
        }
        let refusal = OutputFile::resume(&link).unwrap_err().to_string();
        assert!(refusal.contains("symbolic link"), "{refusal}");
    }
    assert!(!target.exists());
    assert_eq!(fs::read_to_string(folder.join("file")).unwrap(), "precious");
}

#[test]
fn a_file_that_appears_in_between_is_kept() {
    let folder = empty_folder("output-files-between");
    let path = folder.join("out");
    let first = OutputFile::open(&path, false).unwrap();
    for refusal in [OutputFile::open(&path, false), OutputFile::open(&path, true)] {
        assert!(refusal.is_err(), "two programs cannot both have it");
    }
    let refusal = OutputFile::resume(&path).unwrap_err().to_string();
    assert!(refusal.contains("being written"), "{refusal}");
    // Another program replaces the open file: its file must not be removed.
    fs::rename(&path, folder.join("moved")).unwrap();
    fs::write(&path, "theirs").unwrap();
    drop(first);
    assert_eq!(fs::read_to_string(&path).unwrap(), "theirs");
}

#[test]
fn a_file_that_was_begun_and_never_written_is_removed() {
    let path = empty_folder("output-files-unwritten").join("out");
    drop(OutputFile::open(&path, false).unwrap());
    assert!(!path.exists());
    OutputFile::open(&path, false).unwrap().write_all(b"result").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "result");
}

#[test]
fn a_file_that_is_opened_again_is_appended_to_and_is_the_same() {
    let path = empty_folder("output-files-again").join("out");
    let mut file = create(&path, false).unwrap();
    file.write_all(b"one ").unwrap();
    let mut file = file.close().unwrap().reopen().unwrap();
    file.write_all(b"two").unwrap();
    let closed = file.close().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "one two");
    fs::rename(&path, path.with_extension("moved")).unwrap();
    fs::write(&path, "theirs").unwrap();
    let refusal = closed.reopen().unwrap_err().to_string();
    assert!(refusal.contains("replaced"), "{refusal}");
}

#[test]
fn no_command_writes_through_a_link() {
    let folder = empty_folder("output-files-commands");
    let recording = ["trials", "lab1", "--perception", "truth", "--trials", "1", "--record", "."];
    let output = barrelman_in(&folder, &recording);
    succeeded(&output);
    assert_eq!(files_in(&folder), ["lab1-1.mcap"], "no film without frames");
    let targets = folder.join("targets");
    fs::create_dir(&targets).unwrap();
    fs::create_dir(folder.join("exported")).unwrap();
    fs::create_dir(folder.join("film")).unwrap();
    for link in
        ["film.mp4", "track.csv", "page.html", "exported/video.mp4", "film/lab1-1.mp4", "campaign.jsonl"]
    {
        symlink(targets.join("stolen"), folder.join(link)).unwrap();
    }
    let track = ["track", CLIP, "--select", "10,10,20,20"];
    let render = ["render", "lab1", "--seconds", "0.1", "--truth", "truth.csv", "--output", "film.mp4"];
    let trials = ["trials", "lab1", "--trials", "1", "--perception", "truth"];
    for force in [&[][..], &["--force"]] {
        let check = |arguments: &[&str], options: &[&str], name: &str| {
            failed(
                &barrelman_in(&folder, &[arguments, options, force].concat()),
                1,
                &[name, "symbolic link"],
            );
        };
        check(&track, &["--overlay", "film.mp4"], "film.mp4");
        check(&track, &["--output", "track.csv"], "track.csv");
        check(&render, &[], "film.mp4");
        check(&["run", "--video", "sim:lab1"], &["--overlay", "film.mp4"], "film.mp4");
        check(&["demo", "lab1", "--seconds", "1"], &["--record", "film.mp4"], "film.mp4");
        check(&["report", "lab1-1.mcap"], &["--output", "page.html"], "page.html");
        check(&["export", "lab1-1.mcap"], &["--output", "exported"], "video.mp4");
        check(&trials, &["--record", "film"], "lab1-1.mp4");
        check(&trials, &["--output", "campaign.jsonl"], "campaign.jsonl");
    }
    let resumed = [&trials[..], &["--output", "campaign.jsonl", "--resume"]].concat();
    failed(&barrelman_in(&folder, &resumed), 1, &["campaign.jsonl", "symbolic link"]);
    assert!(files_in(&targets).is_empty(), "{:?}", files_in(&targets));
    // A refused command leaves none of its other outputs behind.
    assert_eq!(files_in(&folder.join("exported")), ["video.mp4"]);
    assert_eq!(files_in(&folder.join("film")), ["lab1-1.mp4"]);
    assert!(!folder.join("truth.csv").exists());
}

#[test]
fn work_that_fails_leaves_no_empty_outputs_and_keeps_the_old_ones() {
    let folder = empty_folder("output-files-failed");
    let outputs = ["--output", "track.csv", "--overlay", "film.mp4"];
    let outside = [&["track", CLIP, "--select", "9000,9000,20,20"][..], &outputs].concat();
    failed(&barrelman_in(&folder, &outside), 1, &["selection"]);
    assert!(files_in(&folder).is_empty(), "{:?}", files_in(&folder));
    fs::write(folder.join("track.csv"), "old").unwrap();
    fs::write(folder.join("film.mp4"), "old").unwrap();
    failed(&barrelman_in(&folder, &[&outside[..], &["--force"]].concat()), 1, &["selection"]);
    for name in ["track.csv", "film.mp4"] {
        assert_eq!(fs::read_to_string(folder.join(name)).unwrap(), "old", "{name}");
    }
}
