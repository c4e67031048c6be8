//! Campaigns of trials: the same for any number of threads, when continued, and in shards.

use std::path::{Path, PathBuf};
use std::process::Output;

use xxhash_rust::xxh3::Xxh3;

use crate::program::{argument, barrelman, empty_folder, failed, succeeded};
use crate::stated_program::rewrite;

fn trials(options: &[&str]) -> Output {
    barrelman(&[&["trials", "lab2", "--perception", "truth", "--seed", "500"], options].concat())
}

/// A campaign of eight trials, and its file.
fn campaign(folder: &Path, name: &str, options: &[&str]) -> PathBuf {
    let path = folder.join(name);
    succeeded(&trials(&[&["--trials", "8", "--output", argument(&path)], options].concat()));
    path
}

#[test]
fn results_do_not_depend_on_the_threads_nor_on_being_interrupted_nor_on_parts() {
    let folder = empty_folder("campaigns-campaigns");
    let read = |path: &Path| std::fs::read(path).unwrap();
    let whole = campaign(&folder, "one.jsonl", &["--threads", "1"]);
    let expected = read(&whole);
    assert_eq!(expected.iter().filter(|byte| **byte == b'\n').count(), 8);
    assert_eq!(read(&campaign(&folder, "two.jsonl", &["--threads", "2"])), expected);
    // Cut anywhere, as a killed program leaves the file.
    for cut in [0, 1, expected.len() / 3, expected.len() / 2, expected.len() - 1] {
        let path = folder.join("cut.jsonl");
        std::fs::write(&path, &expected[..cut]).unwrap();
        succeeded(&trials(&["--trials", "8", "--resume", "--output", argument(&path)]));
        assert_eq!(read(&path), expected, "cut after {cut} bytes");
    }
    let parts: Vec<PathBuf> = (1..=3)
        .map(|part| campaign(&folder, &format!("part{part}.jsonl"), &["--shard", &format!("{part}/3")]))
        .collect();
    let merged = folder.join("merged.jsonl");
    let summary = succeeded(&barrelman(&[
        "merge",
        argument(&parts[2]),
        argument(&parts[0]),
        argument(&parts[1]),
        "--output",
        argument(&merged),
        "--json",
    ]));
    assert_eq!(read(&merged), expected);
    let same = succeeded(&trials(&["--trials", "8", "--json"]));
    assert_eq!(summary, same, "merge and trials print the same document");
}

#[test]
fn two_laws_are_compared_by_seed() {
    let folder = empty_folder("campaigns-compare");
    let schema = campaign(&folder, "schema.jsonl", &[]);
    let centre = campaign(&folder, "centre.jsonl", &["--law", "centre"]);
    let text = succeeded(&barrelman(&["compare", argument(&schema), argument(&centre)]));
    assert!(text.contains("8 trials in both"), "{text}");
    let json = succeeded(&barrelman(&["compare", argument(&schema), argument(&centre), "--json"]));
    let document: serde_json::Value = serde_json::from_str(&json).unwrap();
    let figure = |name: &str| {
        let figures = document["figures"].as_array().unwrap();
        figures.iter().find(|figure| figure["figure"] == name).unwrap().clone()
    };
    assert!(figure("time outside")["ratio"]["high"].as_f64().unwrap() < 1.0, "{json}");
    assert!(figure("movement time")["ratio"]["low"].as_f64().unwrap() > 1.0, "{json}");
}

#[test]
fn a_comparison_says_on_how_many_pairs_each_figure_rests() {
    let folder = empty_folder("campaigns-pairs");
    let lab2 = |name: &str, law: &[&str]| {
        let path = folder.join(name);
        let options = ["trials", "lab2", "--perception", "truth", "--trials", "8", "--law"];
        succeeded(&barrelman(&[&options[..], law, &["--output", argument(&path)]].concat()));
        path
    };
    let schema = lab2("schema.jsonl", &["schema"]);
    let optimal = lab2("optimal.jsonl", &["optimal", "--mode", "minimum-energy"]);
    let json = succeeded(&barrelman(&["compare", argument(&schema), argument(&optimal), "--json"]));
    let document: serde_json::Value = serde_json::from_str(&json).unwrap();
    let figures = document["figures"].as_array().unwrap();
    let sensitivity = figures.iter().find(|figure| figure["figure"] == "sensitivity").unwrap();
    // With least energy some trials have no excursion: those have no sensitivity.
    let pairs = sensitivity["pairs"].as_u64().unwrap();
    assert!((1..8).contains(&pairs), "{sensitivity}");
    let of_file = succeeded(&barrelman(&["metrics", argument(&schema), "--json"]));
    let of_file: serde_json::Value = serde_json::from_str(&of_file).unwrap();
    let mean = sensitivity["first_of_all"]["mean"].as_f64().unwrap();
    assert!((mean - of_file["mean_sensitivity"].as_f64().unwrap()).abs() < 1e-12, "{mean}");
    let text = succeeded(&barrelman(&["compare", argument(&schema), argument(&optimal)]));
    let row = text.lines().find(|line| line.starts_with("sensitivity")).unwrap();
    assert!(row.contains(&format!("{pairs}*")), "{row}");
    assert!(
        text.contains("Not of all 8 pairs") && text.contains("law schema") && text.contains("law optimal"),
        "{text}"
    );
    // But for the two lines with the files' paths, a terminal of 80 columns holds the table.
    for line in text.lines().skip(2) {
        assert!(line.chars().count() <= 80, "{line}");
    }
}

#[test]
fn campaigns_of_different_worlds_are_compared_only_when_asked() {
    let folder = empty_folder("campaigns-worlds");
    let usual = campaign(&folder, "usual.jsonl", &[]);
    let check = |options: &[&str], words: &[&str]| {
        let other = campaign(&folder, "other.jsonl", &[options, &["--force"]].concat());
        let arguments = ["compare", argument(&usual), argument(&other)];
        failed(&barrelman(&arguments), 1, &[words, &["--anyway"]].concat());
        succeeded(&barrelman(&[&arguments[..], &["--anyway"]].concat()));
    };
    check(&["--setting", "windy"], &["setting: indoor and windy"]);
    check(&["--plant", "drawn"], &["plant: nominal and drawn"]);
    check(&["--size", "320x180"], &["size: the scenario's and 320x180"]);
    // Truth and pixels: the settings as a campaign in pixels would have them.
    let text = std::fs::read_to_string(&usual).unwrap();
    let pixels = folder.join("pixels.jsonl");
    let changed = text.replace("\"perception\":\"truth\"", "\"perception\":\"pixels\",\"tracker\":\"fused\"");
    assert_ne!(changed, text);
    std::fs::write(&pixels, changed).unwrap();
    failed(
        &barrelman(&["compare", argument(&usual), argument(&pixels)]),
        1,
        &["perception: truth and pixels", "--anyway"],
    );
}

#[test]
fn what_cannot_be_gone_on_with_is_refused_and_kept() {
    let folder = empty_folder("campaigns-refused");
    let path = campaign(&folder, "schema.jsonl", &[]);
    let before = std::fs::read(&path).unwrap();
    let refused = |options: &[&str], words: &str| {
        let output = trials(&[&["--output", argument(&path)], options].concat());
        failed(&output, 1, &[words]);
        assert_eq!(std::fs::read(&path).unwrap(), before);
    };
    refused(&["--trials", "8"], "exists already");
    refused(&["--trials", "8", "--resume", "--law", "centre"], "another campaign");
    refused(&["--trials", "8", "--resume", "--setting", "windy"], "another campaign");
    refused(&["--trials", "4", "--resume"], "line 5");
    refused(&["--trials", "8", "--resume", "--setting", "stormy"], "indoor, still, windy");
    let other = campaign(&folder, "centre.jsonl", &["--law", "centre"]);
    failed(&barrelman(&["merge", argument(&path), argument(&other)]), 1, &["different campaigns"]);
    let text = folder.join("text.jsonl");
    std::fs::write(&text, "{\"seed\": 1}\n").unwrap();
    failed(&barrelman(&["merge", argument(&text)]), 1, &["line 1"]);
}

#[test]
fn the_rate_of_the_schema_can_be_swept_beyond_the_vehicles_limit() {
    let sensitivity = |rate: &str| {
        let json = succeeded(&trials(&["--trials", "12", "--rate", rate, "--json"]));
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
    let folder = empty_folder("campaigns-recorded");
    succeeded(&trials(&["--trials", "1", "--record", argument(&folder)]));
    let recording = folder.join("lab2-500.mcap");
    succeeded(&barrelman(&["replay", argument(&recording), "--compare"]));
}

/// The hash of a recorded trial: topic, time and payload of all messages, and the bytes of the annotated
/// video.
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
    let folder = empty_folder("campaigns-pictures");
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/scenarios");
    let text = std::fs::read_to_string(scenarios.join("arena1.toml")).unwrap();
    let short = folder.join("short.toml");
    std::fs::write(&short, text.replace("longest_s = 400", "longest_s = 2")).unwrap();
    std::fs::create_dir(folder.join("paths")).unwrap();
    std::fs::copy(scenarios.join("paths/arena1.toml"), folder.join("paths/arena1.toml")).unwrap();
    let hashes = |name: &str, options: &[&str]| {
        let into = folder.join(name);
        let plain =
            ["trials", argument(&short), "--trials", "2", "--size", "208x118", "--record", argument(&into)];
        succeeded(&barrelman(&[&plain, options].concat()));
        ["arena1-1.mcap", "arena1-2.mcap"].map(|recording| hash_of(&into.join(recording)))
    };
    let expected = hashes("one", &["--threads", "1"]);
    assert_ne!(expected[0], expected[1]);
    // A recording holds no pictures: they are rendered again, to the same bits.
    let recording = folder.join("one/arena1-2.mcap");
    let said = succeeded(&barrelman(&["replay", argument(&recording), "--compare"]));
    assert!(said.contains("rendered again") && said.contains("every command is the same"), "{said}");
    let optimal = folder.join("optimal.toml");
    std::fs::write(&optimal, "[law]\nname = \"optimal\"\n").unwrap();
    let changed = ["replay", argument(&recording), "--config", argument(&optimal)];
    succeeded(&barrelman(&changed));
    // Without what it takes to render them, the message says what to do.
    let early = folder.join("early.mcap");
    rewrite(&recording, &early, |start| start.trial = None);
    failed(&barrelman(&["replay", argument(&early)]), 1, &["holds no pictures", "--record"]);
    let exported = folder.join("exported");
    let said = succeeded(&barrelman(&["export", argument(&recording), "--output", argument(&exported)]));
    assert!(
        said.contains("no video.mp4") && said.contains("Its film is") && said.contains("arena1-2.mp4"),
        "{said}"
    );
    assert_eq!(hashes("two", &["--threads", "2"]), expected, "two threads");
    for level in ["scalar", "sse2", "avx2"] {
        assert_eq!(hashes(level, &["--simd", level]), expected, "{level}");
    }
}
