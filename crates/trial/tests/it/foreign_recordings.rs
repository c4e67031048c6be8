//! MCAP files that this program did not write, or that were damaged.

use crate::single_message::read_single_message;
use std::collections::BTreeMap;
use std::io::Cursor;

use barrelman_trial::records::table::{TableRow, read_rows};
use barrelman_trial::records::{Entry, ReadError, RecordedInput};
use barrelman_vocab::Timestamp;
use mcap::records::MessageHeader;

use crate::entries::read;

/// `TickInput { step: 7, now_ns: 1 }`, as protobuf encodes it.
const TICK: &[u8] = &[0x08, 7, 0x11, 1, 0, 0, 0, 0, 0, 0, 0];

/// An MCAP file with these messages (topic, encoding, data), without a schema.
fn file(messages: &[(&str, &str, &[u8])]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).create(&mut bytes).unwrap();
    for (index, (topic, encoding, data)) in messages.iter().enumerate() {
        let schema = match *encoding {
            "json" => writer.add_schema("theirs", "jsonschema", b"{}").unwrap(),
            _ => 0,
        };
        let channel_id = writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
        let header =
            MessageHeader { channel_id, sequence: index as u32, log_time: index as u64, publish_time: 0 };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

fn tick() -> Entry {
    Entry::Input { step: 7, now: Timestamp::from_nanos(1), input: RecordedInput::Tick }
}

#[test]
fn topics_that_are_not_ours_are_passed_over() {
    let (found, error) = read(&file(&[
        ("/camera/info", "json", b"{}"),
        ("/input/tick", "protobuf", TICK),
        ("/input/tick2", "protobuf", &[0xff]),
        ("", "ros1", &[1, 2, 3]),
        ("/input/tick", "protobuf", TICK),
    ]));
    assert!(error.is_none(), "{error:?}");
    assert_eq!(found, [tick(), tick()]);
}

#[test]
fn fields_of_a_later_version_are_passed_over() {
    // Field 200, a text.
    let later = [TICK, &[0xc2, 0x0c, 2, b'h', b'i']].concat();
    let (found, error) = read(&file(&[("/input/tick", "protobuf", &later)]));
    assert!(error.is_none(), "{error:?}");
    assert_eq!(found, [tick()]);
}

#[test]
fn a_message_that_cannot_be_understood_is_named_by_its_topic() {
    let check = |topic: &str, data: &[u8], reason: &str| {
        let (found, error) = read(&file(&[("/input/tick", "protobuf", TICK), (topic, "protobuf", data)]));
        assert_eq!(found, [tick()]);
        let Some(ReadError::Message { topic: named, reason: found }) = error else {
            panic!("{topic}, {data:?}: {error:?}");
        };
        assert_eq!(named, topic);
        assert!(found.contains(reason), "{topic}, {data:?}: {found}");
    };
    for topic in [
        "/recording/start",
        "/video/unit",
        "/video",
        "/video/picture",
        "/video/raw",
        "/input/frame",
        "/input/localisation",
        "/input/telemetry",
        "/input/request",
        "/input/tick",
        "/outcome",
    ] {
        check(topic, &[0xff], "");
    }
    check("/video", &[], "no unit announced");
    check("/video/picture", &[], "no unit announced");
    check("/video/raw", &[], "no unit announced");
    check("/input/frame", &[], "capture_quality is missing");
    check("/input/localisation", &[], "track is missing");
    check("/input/telemetry", &[], "report is missing");
    check("/input/request", &[], "request is unreadable");
    check("/outcome", &[], "track is missing");
    // A request without its fields, and one that does not exist.
    let request = |json: &str| [&[0x1a, json.len() as u8], json.as_bytes()].concat();
    check("/input/request", &request(r#"{"kind":"nudge","pan":1}"#), "missing field `tilt`");
    check("/input/request", &request(r#"{"kind":"take-off"}"#), "there is no request of the kind `take-off`");
    check("/input/request", &request(r#"{"kind":"pause"}"#), "the request is not for the pilot");
}

#[test]
fn a_number_that_means_nothing_is_an_error_and_no_other_value() {
    let check = |topic: &str, data: &[u8], reason: &str| {
        let (_, error) = read(&file(&[(topic, "protobuf", data)]));
        let Some(ReadError::Message { reason: found, .. }) = error else {
            panic!("{topic}, {data:?}: {error:?}");
        };
        assert!(found.contains(reason), "{topic}, {data:?}: {found}");
    };
    // An outcome with an unseeded track and a mode, a hold cause, a stop cause, a sector.
    check("/outcome", &[0x32, 0, 0x18, 99], "mode is missing");
    check("/outcome", &[0x32, 0, 0x18, 2], "hold_cause is missing");
    check("/outcome", &[0x32, 0, 0x18, 2, 0x20, 99], "hold_cause is missing");
    check("/outcome", &[0x32, 0, 0x18, 3, 0x28, 99], "stop_cause is missing");
    check("/outcome", &[0x32, 0, 0x58, 9], "sector is missing");
    // The state of a track.
    check("/outcome", &[0x32, 2, 0x08, 9], "state is missing");
    check("/input/localisation", &[0x1a, 2, 0x08, 9], "state is missing");
    check("/input/localisation", &[0x1a, 2, 0x08, 1], "localisation is missing");
    // Link and flight state.
    check("/input/telemetry", &[0x20, 0], "link is missing");
    check("/input/telemetry", &[0x20, 9], "link is missing");
    check("/input/telemetry", &[0x4a, 2, 0x08, 9], "state is missing");
}

#[test]
fn a_unit_that_means_nothing_is_found_with_its_picture() {
    let check = |unit: &[u8], reason: &str| {
        let (_, error) = read(&file(&[("/video/unit", "protobuf", unit), ("/video/raw", "protobuf", &[])]));
        let Some(ReadError::Message { topic, reason: found }) = error else { panic!("{unit:?}") };
        assert_eq!(topic, "/video/raw");
        assert!(found.contains(reason), "{unit:?}: {found}");
    };
    check(&[], "codec is missing");
    check(&[0x30, 9], "codec is missing");
    check(&[0x30, 2], "capture_quality is missing");
    check(&[0x30, 2, 0x20, 9], "capture_quality is missing");
    check(&[0x30, 2, 0x20, 1, 0x60, 45], "rotation_deg is missing");
    check(&[0x30, 4, 0x20, 1], "matrix is missing");
    check(&[0x30, 4, 0x20, 1, 0x48, 1], "range is missing");
}

#[test]
fn tables_pass_over_channels_whose_schema_they_do_not_speak() {
    let mut rows: Vec<TableRow> = Vec::new();
    let bytes = file(&[("/camera/info", "json", b"{}"), ("/input/tick", "protobuf", TICK)]);
    read_rows(bytes.as_slice(), |row| -> Result<(), ReadError> {
        rows.push(row);
        Ok(())
    })
    .unwrap();
    // The tick has no schema in this file: nothing says what its fields are.
    assert!(rows.is_empty());
}

/// A field of bytes, as protobuf encodes it.
fn field(number: u8, content: &[u8]) -> Vec<u8> {
    [&[number << 3 | 2, content.len() as u8], content].concat()
}

#[test]
fn a_message_that_lies_in_its_own_kind_has_columns_to_the_first_of_them() {
    // message Link { int32 weight = 2; Link next = 1; }
    let next = [field(1, b"next"), vec![0x18, 1, 0x20, 1, 0x28, 11], field(6, b".chain.Link")].concat();
    let weight = [field(1, b"weight"), vec![0x18, 2, 0x20, 1, 0x28, 5]].concat();
    let message = [field(1, b"Link"), field(2, &next), field(2, &weight)].concat();
    let name = [field(1, b"chain.proto"), field(2, b"chain")].concat();
    let schema = field(1, &[name, field(4, &message), field(12, b"proto3")].concat());
    // A link of weight 5 with another one behind it.
    let row = read_single_message("chain.Link", &schema, "/chain", &[0x0a, 2, 0x10, 6, 0x10, 5]);
    assert_eq!(row.columns, ["log_time_ns", "next", "weight"]);
    assert_eq!(row.cells, ["8", "\"{\"\"weight\"\":6}\"", "5"]);
    assert_eq!(row.json_columns, ["next"]);
}

/// The messages of a file with an attachment whose content is cut to its last `kept` bytes before the
/// messages.
fn with_attachment(kept: usize) -> Vec<u8> {
    let whole = file(&[("/input/tick", "protobuf", TICK)]);
    // Magic, then the header: opcode, length, content.
    let header = 8 + 9 + u64::from_le_bytes(whole[9..17].try_into().unwrap()) as usize;
    // Two times, a name, a type of media, the length of the data, the data, a checksum.
    let content =
        [[0; 16].as_slice(), &[1, 0, 0, 0, b'a'], &[0; 4], &[2, 0, 0, 0, 0, 0, 0, 0], b"hi", &[0; 4]]
            .concat();
    let content = &content[..kept.min(content.len())];
    let attachment = [[0x09].as_slice(), &(content.len() as u64).to_le_bytes(), content].concat();
    [&whole[..header], &attachment, &whole[header..]].concat()
}

#[test]
fn an_attachment_is_passed_over_however_short() {
    for kept in 0..=39 {
        let (found, error) = read(&with_attachment(kept));
        assert!(error.is_none(), "{kept}: {error:?}");
        assert_eq!(found, [tick()], "{kept}");
        read_rows(with_attachment(kept).as_slice(), |_| Ok::<(), ReadError>(())).unwrap();
    }
}
