//! Channels of a recording as tables.

use std::collections::BTreeMap;

use barrelman_trial::records::table::{TableRow, read_rows};
use barrelman_trial::records::{Entry, ReadError, RecordedInput, RecordedOutcome};
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::{Note, OperatorRequest, StopCause, Timestamp, Track, VideoNumber};

use crate::entries::{every_kind, input, outcome, unit, written};

fn rows_of(bytes: &[u8]) -> (Vec<TableRow>, Result<(), ReadError>) {
    let mut rows = Vec::new();
    let result = read_rows(bytes, |row| {
        rows.push(row);
        Ok(())
    });
    (rows, result)
}

/// The topics that repeat an outcome for other programs.
const SHOWN: [&str; 3] = ["/video/annotations", "/log", "/boat/location"];

/// The cells of an entry's last row, by column.
fn cells(entry: Entry) -> BTreeMap<String, String> {
    let (rows, result) = rows_of(&written(&[entry]));
    result.unwrap();
    let TableRow { columns, cells, .. } =
        rows.into_iter().rfind(|row| !SHOWN.contains(&row.topic.as_str())).unwrap();
    assert_eq!(columns.len(), cells.len());
    columns.into_iter().zip(cells).collect()
}

#[track_caller]
fn check(entry: Entry, expected: &[(&str, &str)]) {
    let found = cells(entry);
    for (column, cell) in expected {
        assert_eq!(found.get(*column).map(String::as_str), Some(*cell), "{column}");
    }
}

#[test]
fn a_marked_moment_is_a_row_of_its_own_channel() {
    let text = "smoke, at the pier".to_owned().try_into().unwrap();
    let note = Entry::Note { at: Timestamp::from_nanos(1_000), note: Note { text } };
    check(note.clone(), &[("at_ns", "1000"), ("text", "\"smoke, at the pier\"")]);
    let (rows, _) = rows_of(&written(&[note]));
    assert_eq!(rows.last().map(|row| row.topic.as_str()), Some("/note"));
}

#[test]
fn a_row_has_the_time_and_every_field() {
    let time = "1493598415000001000";
    check(input(RecordedInput::Tick), &[("log_time_ns", time), ("step", "7"), ("now_ns", "1000")]);
    assert_eq!(cells(input(RecordedInput::Tick)).len(), 3);
}

#[test]
fn fields_of_nested_messages_are_columns_of_their_own() {
    check(
        Entry::Outcome(outcome(0.25)),
        &[
            ("percept.p", "0.25"),
            ("track.localisation.bounds.w", "0.25"),
            ("track.localisation.picture_width", "640"),
            ("pan", "0.25"),
            ("age_ns", "200000001"),
        ],
    );
}

#[test]
fn variants_are_told_by_name() {
    check(
        Entry::Outcome(outcome(0.25)),
        &[
            ("mode", "MODE_SERVOING"),
            ("track.state", "TRACK_STATE_TRACKING"),
            ("sector", "SECTOR_LEFT"),
            ("hold_cause", "HOLD_CAUSE_NONE"),
        ],
    );
    let stop = OperatorRequest::Stop(StopCause::VideoEnded);
    check(
        input(RecordedInput::Request(stop)),
        &[("request", r#""{""kind"":""stop"",""cause"":""video-ended""}""#)],
    );
}

#[test]
fn what_is_absent_is_an_empty_cell() {
    let bare = RecordedOutcome {
        track: Track::Unseeded,
        percept: None,
        advice: None,
        age: None,
        wake_at: None,
        ..outcome(0.0)
    };
    check(
        Entry::Outcome(bare),
        &[
            ("percept.p", ""),
            ("track.localisation.u", ""),
            ("track.localisation.bounds.u", ""),
            ("advised_pan", ""),
            ("age_ns", ""),
            ("wake_at_ns", ""),
            ("pan", "0"),
            ("track.confidence", "0"),
        ],
    );
}

#[test]
fn texts_are_quoted_where_a_csv_needs_it() {
    let notice = |text: &str| Entry::Outcome(RecordedOutcome { notice: text.to_owned(), ..outcome(0.0) });
    for (text, cell) in [
        ("", ""),
        ("plain; text", "plain; text"),
        ("a, b", "\"a, b\""),
        ("say \"aye\"", "\"say \"\"aye\"\"\""),
        ("two\nlines", "\"two\nlines\""),
        ("a\rb", "\"a\rb\""),
    ] {
        check(notice(text), &[("notice", cell)]);
    }
}

#[test]
fn bytes_are_told_by_their_number() {
    check(
        Entry::Unit(VideoNumber::First, unit(UnitCodec::H264AnnexB, &[1, 2, 3])),
        &[("data", "3"), ("format", "h264")],
    );
    check(Entry::Unit(VideoNumber::First, unit(UnitCodec::Png, &[])), &[("data", "0"), ("format", "png")]);
}

#[test]
fn numbers_are_told_so_that_they_are_read_as_they_were() {
    for (value, cell) in [
        (0.1, "0.1"),
        (-0.25, "-0.25"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (1.0 / 3.0, "0.3333333333333333"),
    ] {
        check(Entry::Outcome(outcome(value)), &[("yaw_rate", cell)]);
    }
}

#[test]
fn every_row_of_a_topic_has_the_same_columns() {
    let (rows, result) = rows_of(&written(&every_kind()));
    result.unwrap();
    let mut columns: BTreeMap<&str, &[String]> = BTreeMap::new();
    for row in &rows {
        assert_eq!(row.columns.len(), row.cells.len());
        assert_eq!(*columns.entry(&row.topic).or_insert(&row.columns), row.columns);
    }
    assert_eq!(columns.len(), 20);
}

#[test]
fn a_cut_recording_gives_the_rows_before_the_cut() {
    let bytes = written(&every_kind());
    let (whole, _) = rows_of(&bytes);
    let (found, result) = rows_of(&bytes[..bytes.len() - 1]);
    assert!(matches!(result, Err(ReadError::Truncated)), "{result:?}");
    assert_eq!(found, whole);
}
