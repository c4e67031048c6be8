//! The command line: exit codes, messages and help texts.

use std::process::Command;

use barrelman_station::cli::Cli;
use clap::CommandFactory as _;

use crate::program::{barrelman, barrelman_in, empty_folder, failed};

/// Runs a command that must fail with this exit code and a message that contains all words, and print no
/// result.
#[track_caller]
fn refused(arguments: &[&str], code: i32, words: &[&str]) {
    let output = barrelman(arguments);
    failed(&output, code, words);
    assert!(output.stdout.is_empty(), "{arguments:?} prints results");
}

#[test]
fn wrong_use_ends_with_2_and_says_what_is_expected() {
    refused(&["track", "clip.mp4", "--select", "1,2,3"], 2, &["X,Y,W,H"]);
    refused(&["track", "clip.mp4", "--select", "1,2,0,5"], 2, &["above zero"]);
    refused(&["law", "log.csv", "--region", "0,2"], 2, &["at most 1"]);
    refused(&["law", "log.csv", "--frame-size", "640"], 2, &["WIDTHxHEIGHT"]);
    refused(&["law", "log.csv", "--rate", "-1"], 2, &["--rate"]);
    refused(&["law", "log.csv", "--mode", "eco"], 2, &["--mode", "optimal"]);
    refused(&["law", "log.csv", "--law", "optimal", "--horizon", "0"], 2, &["--horizon = 0", "0.5 to 5"]);
    refused(&["trials", "lab1", "--horizon", "2"], 2, &["--horizon", "optimal"]);
    refused(&["metrics"], 2, &["LOGS"]);
    refused(&["emulate", "fotokite-pro"], 2, &["--pty"]);
    refused(&["emulate", "fotokite-pro", "--no-echo"], 2, &["--pty", "--listen"]);
    refused(&["run"], 2, &["no video source", "--video"]);
    refused(&["run", "--headless", "--links-file", "links"], 2, &["--headless", "--links-file"]);
    refused(&["fly"], 2, &["fly"]);
    refused(
        &["track", "clip.mp4", "--select", "1,2,3,4", "--tracker", "csrt"],
        2,
        &["csrt", "fused", "camshift"],
    );
    refused(&["run", "--video", "file:clip.mp4", "--tracker", "csrt"], 2, &["csrt", "fused", "camshift"]);
    refused(&["demo", "--clip", "--seed", "3"], 2, &["--clip", "--seed"]);
    refused(&["demo", "--seconds", "-1"], 2, &["above zero"]);
    refused(&["demo", "--tracker", "csrt"], 2, &["csrt", "fused", "camshift"]);
}

#[test]
fn a_service_with_a_configuration_that_it_cannot_run_with_is_not_started_again() {
    const UNIT: &str = include_str!("../../../../config/systemd/barrelman.service");
    for (name, text, words, code) in [
        ("no-video.toml", "[console]\n", ["no video source", "video.url in"], 2),
        ("unknown-key.toml", "[video]\nadress = \"sim:open\"\n", ["is not usable", "adress"], 78),
        ("out-of-range.toml", "[recording]\nquota_gb = -1.0\n", ["is not usable", "quota_gb"], 78),
        ("no-address.toml", "[console]\nlisten = \"localhost\"\n", ["is not usable", "listen"], 78),
    ] {
        let file = empty_folder("unusable_configurations").join(name);
        std::fs::write(&file, text).unwrap();
        let file = file.to_str().unwrap();
        // On a terminal: what is missing on the command line is wrong use, a mistake in the file is a
        // failure.
        refused(&["run", file], if code == 78 { 1 } else { code }, &[words[0], words[1], file]);
        let mut program = Command::new(env!("CARGO_BIN_EXE_barrelman"));
        let done = program.args(["run", file]).env("NOTIFY_SOCKET", "/nowhere").output().unwrap();
        assert_eq!(done.status.code(), Some(code), "{name}");
        let prevented = UNIT.lines().find_map(|line| line.strip_prefix("RestartPreventExitStatus=")).unwrap();
        assert!(prevented.split(' ').any(|status| status == code.to_string()), "{prevented}");
    }
}

#[test]
fn what_is_not_there_is_named_and_ends_with_1() {
    refused(&["track", "nowhere.mp4", "--select", "1,2,3,4"], 1, &["nowhere.mp4", "check the path"]);
    refused(&["law", "nowhere.csv"], 1, &["nowhere.csv"]);
    refused(&["replay", "nowhere.mcap"], 1, &["nowhere.mcap"]);
    refused(&["export", "nowhere.mcap", "--output", "nowhere"], 1, &["nowhere.mcap"]);
    refused(&["run", "nowhere.toml"], 1, &["nowhere.toml"]);
    refused(&["links", "--file", "nowhere"], 1, &["nowhere", "sudo systemctl start barrelman"]);
    refused(&["law", "nowhere.csv", "--profile", "kite"], 1, &["kite", "fotokite-pro"]);
    refused(&["run", "--video", "udp://127.0.0.1"], 1, &["udp://127.0.0.1", "there is no port"]);
    refused(&["run", "--video", "sim:"], 1, &["names no scenario", "sim:arena1"]);
    refused(&["run", "--video", "sim:atlantis"], 1, &["atlantis", "arena1", "barrelman scenarios"]);
    refused(&["run", "--video", "sim:open?seed=many"], 1, &["seed=many", "seed=7"]);
    refused(&["run", "--video", "sim:open?size=0x7"], 1, &["picture", "even"]);
    refused(&["run", "--video", "file:clip.mp4", "--link", "sim:"], 1, &["--video sim:SCENARIO"]);
    refused(&["track", "sim:open", "--select", "1,2,3,4"], 1, &["simulated world", "barrelman run"]);
    refused(&["demo", "atlantis"], 1, &["atlantis", "arena1"]);
    refused(&["demo", "--replay", "nowhere.jsonl"], 1, &["nowhere.jsonl"]);
    refused(&["trials", "--drive", "nowhere.jsonl"], 1, &["nowhere.jsonl"]);
    refused(&["trials", "--drive", "drive.jsonl", "--seed", "3"], 2, &["--drive", "--seed"]);
    refused(&["trials"], 2, &["SCENARIO"]);
    refused(&["demo", "--listen", "192.0.2.1:80"], 1, &["192.0.2.1:80", "--listen"]);
    refused(
        &["emulate", "fotokite-pro", "--pty", "nowhere/pty", "--world", "file:clip.mp4"],
        1,
        &["--world", "sim:arena1"],
    );
    refused(
        &["run", "--video", "file:clip.mp4", "--link", "carrier-pigeon:coop"],
        1,
        &["carrier-pigeon", "serial:"],
    );
}

#[test]
fn every_command_shows_an_example() {
    fn all(command: &clap::Command, words: &[String]) -> Vec<Vec<String>> {
        let below = command.get_subcommands().flat_map(|below| {
            let words = [words, &[below.get_name().to_owned()]].concat();
            all(below, &words)
        });
        below.chain([words.to_vec()]).collect()
    }
    let commands = all(&Cli::command(), &[]);
    assert!(commands.len() > 16, "{commands:?}");
    for command in commands {
        let words: Vec<&str> = command.iter().map(String::as_str).chain(["--help"]).collect();
        let output = barrelman(&words);
        let help = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && help.contains("Example"), "{command:?}: {help}");
    }
}

#[test]
fn examples_fit_a_terminal_of_80_columns() {
    fn check(command: &clap::Command) {
        for help in [command.get_after_help(), command.get_after_long_help()].into_iter().flatten() {
            for line in help.to_string().lines() {
                assert!(line.chars().count() <= 80, "{}: {line}", command.get_name());
            }
        }
        command.get_subcommands().for_each(check);
    }
    check(&Cli::command());
}

#[test]
fn each_command_names_its_own_default_of_the_law() {
    for (command, expected) in [
        ("run", "default: the configuration's, or optimal"),
        ("demo", "default: optimal, and schema with --clip"),
        ("trials", "default: schema, or with --drive the drive's"),
        ("law", "default: schema"),
    ] {
        let cli = Cli::command();
        let command = cli.find_subcommand(command).unwrap();
        let law = command.get_arguments().find(|argument| argument.get_id() == "law").unwrap();
        let help = law.get_help().unwrap().to_string();
        assert_eq!(help, format!("The camera law; {expected}"));
    }
}

#[test]
fn the_columns_of_the_tables_are_defined_in_the_help() {
    for command in ["trials", "metrics", "merge"] {
        let help = String::from_utf8(barrelman(&[command, "--help"]).stdout).unwrap();
        for column in ["exc. ", "switches ", "travel ", "effort ", "tracked ", "blind "] {
            assert!(help.contains(&format!("  {column}")), "{command}: {column}");
        }
    }
}

#[test]
fn the_help_lists_the_keys_of_the_terminal() {
    let help_of = |command| {
        let help = String::from_utf8(barrelman(&[command, "--help"]).stdout).expect("it is text");
        help.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let run = help_of("run");
    let keys = "Keys on a terminal: e engages, d disengages, s searches for a lost boat, space stops camera and boat, q quits.";
    assert!(run.contains(keys), "{run}");
    let demo = help_of("demo");
    assert!(demo.contains(keys), "{demo}");
}

#[test]
fn options_of_a_boat_need_a_boat() {
    for option in [["--guidance", "los"], ["--vessel-profile", "lab-udp"]] {
        let output = barrelman(&["run", "--video", "sim:arena1", option[0], option[1]]);
        assert!(!output.status.success());
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("give its address (--vessel URL"), "{said}");
    }
}

#[test]
fn figures_of_a_track_are_printed_alone() {
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
    let output = barrelman(&["track", clip, "--select", "10,10,20,20", "--json"]);
    let figures: serde_json::Value = serde_json::from_slice(&output.stdout).expect("nothing but JSON");
    assert!(output.status.success() && figures["frames"].as_u64() > Some(1), "{figures}");
}

#[test]
fn a_track_ends_with_a_summary_and_doubtful_selections_are_named() {
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
    let folder = empty_folder("track-summary");
    let track = |selection: &str, more: &[&str]| {
        let output =
            barrelman_in(&folder, &[&["track", clip, "--select", selection, "--force"], more].concat());
        let (out, log) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{log}");
        (out.into_owned(), log.into_owned())
    };
    let (out, log) = track("10,10,20,20", &["--output", "track.csv"]);
    assert!(out.contains(" tracked, ") && out.contains("mean confidence"), "{out}");
    assert!(out.contains("written: track.csv") && log.is_empty(), "{out} {log}");
    // The track on stdout: the summary is a log line.
    let (out, log) = track("10,10,20,20", &[]);
    assert!(out.starts_with("frame,time_s") && !out.contains("mean confidence"), "{out}");
    assert!(log.contains("mean confidence"), "{log}");
    let (_, log) = track("54,10,40,20", &["--output", "track.csv"]);
    assert!(log.contains("75 % of the selection") && log.contains("64x48"), "{log}");
    let (_, log) = track("10,10,8,6", &["--output", "track.csv"]);
    assert!(log.contains("is small"), "{log}");
}

#[test]
fn a_snapshot_shows_a_frame_with_coordinates() {
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
    let folder = empty_folder("snapshot");
    let snapshot = |options: &[&str]| barrelman_in(&folder, &[&["snapshot", clip], options].concat());
    let said = snapshot(&["--output", "first.png"]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(
        said.contains("64x48") && said.contains("every 10 pixels") && said.contains("--select"),
        "{said}"
    );
    let file = std::io::BufReader::new(std::fs::File::open(folder.join("first.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut samples = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut samples).unwrap();
    assert_eq!((info.width, info.height), (64, 48));
    failed(&snapshot(&["--output", "first.png"]), 1, &["--force"]);
    failed(&snapshot(&["--frame", "100000", "--output", "none.png"]), 1, &["there is no frame 100000"]);
    assert!(!folder.join("none.png").exists());
    failed(&snapshot(&["--output", "first.jpg"]), 2, &[".png"]);
}

#[test]
fn a_track_without_a_selection_says_how_to_select() {
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
    let output = Command::new(env!("CARGO_BIN_EXE_barrelman"))
        .args(["track", clip])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the program starts");
    failed(&output, 2, &["--select X,Y,W,H", "barrelman snapshot", "--listen"]);
}

#[test]
fn check_finds_what_is_wrong_and_how_to_mend_it() {
    let output = barrelman(&["check", "--video", "file:nowhere.mp4", "--link", "serial:/dev/nowhere"]);
    let findings = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1));
    for words in ["nowhere.mp4", "/dev/nowhere does not exist", "udev rule", "ModemManager"] {
        assert!(findings.contains(words), "{words:?} is not in {findings}");
    }
}

#[test]
fn check_describes_a_video_in_words() {
    let clip = concat!("file:", env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
    let output = barrelman(&["check", "--video", clip]);
    let findings = String::from_utf8_lossy(&output.stdout);
    assert!(findings.contains("64x48 pictures, colours as BT.601, limited range"), "{findings}");
    assert!(!findings.contains('{'), "{findings}");
}

#[test]
fn results_that_nobody_reads_end_quietly() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_barrelman"))
        .args(["config", "example"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}
