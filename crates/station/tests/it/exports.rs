//! Exports of recordings of other programs: thousands of channels, colliding names, recursive schemas.

use std::collections::BTreeMap;
use std::fs;
use std::io::BufWriter;
use std::path::Path;
use std::process::Command;

use mcap::records::MessageHeader;

use crate::program::empty_folder;

/// A length-delimited protobuf field.
fn field(number: u8, content: &[u8]) -> Vec<u8> {
    [&[number << 3 | 2, content.len() as u8], content].concat()
}

/// The schema of `message Link { Link next = 1; int32 weight = 2; }`.
fn link() -> Vec<u8> {
    let next = [field(1, b"next"), vec![0x18, 1, 0x20, 1, 0x28, 11], field(6, b".chain.Link")].concat();
    let weight = [field(1, b"weight"), vec![0x18, 2, 0x20, 1, 0x28, 5]].concat();
    let message = [field(1, b"Link"), field(2, &next), field(2, &weight)].concat();
    let name = [field(1, b"chain.proto"), field(2, b"chain")].concat();
    field(1, &[name, field(4, &message), field(12, b"proto3")].concat())
}

/// Writes a recording with a `Link` on each topic, `rounds` times. The weight is the number of the round.
fn record(path: &Path, topics: &[String], rounds: u8) {
    let file = BufWriter::new(fs::File::create(path).unwrap());
    let mut writer = mcap::WriteOptions::new().compression(None).create(file).unwrap();
    let schema = writer.add_schema("chain.Link", "protobuf", &link()).unwrap();
    let channels: Vec<u16> = topics
        .iter()
        .map(|topic| writer.add_channel(schema, topic, "protobuf", &BTreeMap::new()).unwrap())
        .collect();
    for round in 1..=rounds {
        for channel_id in &channels {
            let header = MessageHeader {
                channel_id: *channel_id,
                sequence: 0,
                log_time: round.into(),
                publish_time: 0,
            };
            // A link that contains another link.
            writer.write_to_known_channel(&header, &[0x0a, 2, 0x10, 9, 0x10, round]).unwrap();
        }
    }
    writer.finish().unwrap();
}

/// Exports with at most `descriptors` open files. Returns the standard error.
fn export(folder: &Path, descriptors: usize) -> String {
    let output = Command::new("sh")
        .args(["-c", &format!("ulimit -n {descriptors} && exec \"$0\" export r.mcap --output out")])
        .arg(env!("CARGO_BIN_EXE_barrelman"))
        .current_dir(folder)
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{message}");
    message
}

#[test]
fn two_thousand_channels_are_exported_with_few_open_files() {
    let folder = empty_folder("exports-many");
    let topics: Vec<String> = (0..2000).map(|number| format!("/sensor/{number}")).collect();
    record(&folder.join("r.mcap"), &topics, 3);
    export(&folder, 100);
    for number in [0, 1, 1000, 1999] {
        let table = fs::read_to_string(folder.join(format!("out/sensor_{number}.csv"))).unwrap();
        let nested = "\"{\"\"weight\"\":9}\"";
        let expected = format!("log_time_ns,next,weight\n1,{nested},1\n2,{nested},2\n3,{nested},3\n");
        assert_eq!(table, expected, "{number}");
    }
    // All tables and the trial's, but no video.
    assert_eq!(fs::read_dir(folder.join("out")).unwrap().count(), 2001);
}

#[test]
fn channels_whose_names_collide_have_files_of_their_own() {
    let folder = empty_folder("exports-collide");
    let topics = ["/a/b", "/a_b", "a/b/", "/a_b_2", "/trial"].map(str::to_owned);
    record(&folder.join("r.mcap"), &topics, 1);
    export(&folder, 100);
    let mut names: Vec<String> = fs::read_dir(folder.join("out"))
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["a_b.csv", "a_b_2.csv", "a_b_2_2.csv", "a_b_3.csv", "trial.csv", "trial_2.csv"]);
    let trial = fs::read_to_string(folder.join("out/trial.csv")).unwrap();
    assert!(trial.starts_with("time_s,"), "{trial}");
}

#[test]
fn what_is_given_as_json_is_named_once() {
    let folder = empty_folder("exports-json");
    record(&folder.join("r.mcap"), &["/chain".to_owned()], 3);
    let message = export(&folder, 100);
    assert_eq!(message.matches("/chain").count(), 1, "{message}");
    assert!(message.contains("JSON") && message.contains("next"), "{message}");
}
