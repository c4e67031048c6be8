//! Campaigns of trials from outside: the same for any number of threads, gone on with, in parts.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use xxhash_rust::xxh3::Xxh3;

fn trials(options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_barrelman"))
        .args(["trials", "lab2", "--perception", "truth", "--seed", "500"])
        .args(options)
        .output()
        .unwrap()
}

fn barrelman(options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_barrelman")).args(options).output().unwrap()
}

/// An empty folder of that name.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("campaigns-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn ok(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn word(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A campaign of eight trials, and its file.
fn campaign(folder: &Path, name: &str, options: &[&str]) -> PathBuf {
    let path = folder.join(name);
    ok(&trials(&[&["--trials", "8", "--output", word(&path)], options].concat()));
    path
}

#[test]
fn results_do_not_depend_on_the_threads_nor_on_being_interrupted_nor_on_parts() {
    let folder = scratch("campaigns");
    let read = |path: &Path| std::fs::read(path).unwrap();
    let whole = campaign(&folder, "one.jsonl", &["--threads", "1"]);
    let expected = read(&whole);
    assert_eq!(expected.iter().filter(|byte| **byte == b'\n').count(), 8);
    assert_eq!(read(&campaign(&folder, "two.jsonl", &["--threads", "2"])), expected);
    // Cut anywhere, as a killed program leaves it.
    for cut in [0, 1, expected.len() / 3, expected.len() / 2, expected.len() - 1] {
        let path = folder.join("cut.jsonl");
        std::fs::write(&path, &expected[..cut]).unwrap();
        ok(&trials(&["--trials", "8", "--resume", "--output", word(&path)]));
        assert_eq!(read(&path), expected, "cut after {cut} bytes");
    }
    let parts: Vec<PathBuf> = (1..=3)
        .map(|part| campaign(&folder, &format!("part{part}.jsonl"), &["--shard", &format!("{part}/3")]))
        .collect();
    let merged = folder.join("merged.jsonl");
    let summary = ok(&barrelman(&[
        "merge",
        word(&parts[2]),
        word(&parts[0]),
        word(&parts[1]),
        "--output",
        word(&merged),
        "--json",
    ]));
    assert_eq!(read(&merged), expected);
    let same = ok(&trials(&["--trials", "8", "--json"]));
    assert_eq!(summary, same, "merge and trials print the same document");
}

#[test]
fn two_laws_are_compared_by_seed() {
    let folder = scratch("compare");
    let schema = campaign(&folder, "schema.jsonl", &[]);
    let centre = campaign(&folder, "centre.jsonl", &["--law", "centre"]);
    let text = ok(&barrelman(&["compare", word(&schema), word(&centre)]));
    assert!(text.contains("8 trials in both"), "{text}");
    let json = ok(&barrelman(&["compare", word(&schema), word(&centre), "--json"]));
    let document: serde_json::Value = serde_json::from_str(&json).unwrap();
    let figure = |name: &str| {
        let figures = document["figures"].as_array().unwrap();
        figures.iter().find(|figure| figure["figure"] == name).unwrap().clone()
    };
    assert!(figure("time outside")["ratio"]["high"].as_f64().unwrap() < 1.0, "{json}");
    assert!(figure("movement time")["ratio"]["low"].as_f64().unwrap() > 1.0, "{json}");
}

#[test]
fn what_cannot_be_gone_on_with_is_refused_and_kept() {
    let folder = scratch("refused");
    let path = campaign(&folder, "schema.jsonl", &[]);
    let before = std::fs::read(&path).unwrap();
    let refused = |options: &[&str], words: &str| {
        let output = trials(&[&["--output", word(&path)], options].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(words), "{said}\nexpected {words}");
        assert_eq!(std::fs::read(&path).unwrap(), before);
    };
    refused(&["--trials", "8"], "exists already");
    refused(&["--trials", "8", "--resume", "--law", "centre"], "another campaign");
    refused(&["--trials", "8", "--resume", "--setting", "windy"], "another campaign");
    refused(&["--trials", "4", "--resume"], "line 5");
    refused(&["--trials", "8", "--resume", "--setting", "stormy"], "indoor, still, windy");
    let other = campaign(&folder, "centre.jsonl", &["--law", "centre"]);
    let output = barrelman(&["merge", word(&path), word(&other)]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("different campaigns"));
    let text = folder.join("text.jsonl");
    std::fs::write(&text, "{\"seed\": 1}\n").unwrap();
    let output = barrelman(&["merge", word(&text)]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("line 1"));
}

#[test]
fn the_rate_of_the_schema_can_be_swept_beyond_the_vehicles_limit() {
    let sensitivity = |rate: &str| {
        let json = ok(&trials(&["--trials", "12", "--rate", rate, "--json"]));
        let document: serde_json::Value = serde_json::from_str(&json).unwrap();
        let trials = document["trials"].as_array().unwrap();
        let outside: f64 = trials.iter().map(|trial| trial["time_outside_s"].as_f64().unwrap()).sum();
        outside
    };
    let (slow, usual, fast) = (sensitivity("0.15"), sensitivity("0.3"), sensitivity("0.6"));
    assert!(slow > usual && usual > fast, "{slow}, {usual}, {fast} s outside");
}

#[test]
fn a_recorded_trial_replays_to_the_same_commands() {
    let folder = scratch("recorded");
    ok(&trials(&["--trials", "1", "--record", word(&folder)]));
    let recording = folder.join("lab2-500.mcap");
    let said = barrelman(&["replay", word(&recording), "--compare"]);
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
}

/// One number for a recorded trial: channel, time and payload of all messages, and the bytes of the annotated video.
fn hash_of(recording: &Path) -> u64 {
    let bytes = std::fs::read(recording).unwrap();
    let mut hash = Xxh3::new();
    let mut frames = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        hash.update(message.channel.topic.as_bytes());
        hash.update(&message.log_time.to_le_bytes());
        hash.update(&message.data);
        frames += usize::from(message.channel.topic == "/truth");
    }
    assert!(frames > 40, "{frames} pictures in {}", recording.display());
    hash.update(&std::fs::read(recording.with_extension("mp4")).unwrap());
    hash.digest()
}

#[test]
fn a_trial_in_pictures_is_the_same_to_the_bit_however_it_is_computed() {
    let folder = scratch("pictures");
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/scenarios");
    let text = std::fs::read_to_string(scenarios.join("arena1.toml")).unwrap();
    let short = folder.join("short.toml");
    std::fs::write(&short, text.replace("longest_s = 400", "longest_s = 2")).unwrap();
    std::fs::create_dir(folder.join("paths")).unwrap();
    std::fs::copy(scenarios.join("paths/arena1.toml"), folder.join("paths/arena1.toml")).unwrap();
    let hashes = |name: &str, options: &[&str]| {
        let into = folder.join(name);
        let plain = ["trials", word(&short), "--trials", "2", "--size", "208x118", "--record", word(&into)];
        ok(&barrelman(&[&plain, options].concat()));
        ["arena1-1.mcap", "arena1-2.mcap"].map(|recording| hash_of(&into.join(recording)))
    };
    let expected = hashes("one", &["--threads", "1"]);
    assert_ne!(expected[0], expected[1]);
    assert_eq!(hashes("two", &["--threads", "2"]), expected, "two threads");
    for level in ["scalar", "sse2", "avx2"] {
        assert_eq!(hashes(level, &["--simd", level]), expected, "{level}");
    }
}
