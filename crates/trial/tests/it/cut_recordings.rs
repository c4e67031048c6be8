//! Truncated recordings, as of a killed process.

use barrelman_trial::records::{Entry, ReadError, RecordedInput, RecordingWriter};
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::{VehicleProfile, VideoNumber};

use crate::entries::{input, outcome, read, start, unit, written};

/// A recording flushed after every second entry, and its entries.
fn recording() -> (Vec<u8>, Vec<Entry>) {
    let entries = vec![
        Entry::Unit(VideoNumber::First, unit(UnitCodec::H264AnnexB, &[0, 0, 0, 1, 9, 0xf0])),
        input(RecordedInput::Tick),
        Entry::Outcome(outcome(0.5)),
        Entry::Unit(VideoNumber::First, unit(UnitCodec::Jpeg, &[0xff, 0xd8])),
        input(RecordedInput::Tick),
    ];
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::begin(&mut bytes, &start(), &VehicleProfile::fotokite_pro()).unwrap();
    for pair in entries.chunks(2) {
        for entry in pair {
            writer.write(entry).unwrap();
        }
        writer.flush().unwrap();
    }
    writer.finish().unwrap();
    (bytes, [vec![Entry::Start(start())], entries].concat())
}

/// Distance of the cuts within what holds no entries, the schemas before them and the summary behind them,
/// bytes: a prime.
const DISTANCE: usize = 97;
/// Sizes of a container's magic bytes, and of a record's head: its kind, and the length of what follows.
const MAGIC: usize = 8;
const HEAD: usize = 9;

/// Where the container's records begin, and where the last one ends.
fn record_starts(bytes: &[u8]) -> impl Iterator<Item = usize> {
    let next = move |&start: &usize| {
        let length = bytes.get(start + 1..start + HEAD)?;
        Some(start + HEAD + usize::try_from(u64::from_le_bytes(length.try_into().unwrap())).unwrap())
    };
    core::iter::successors(Some(MAGIC), next).take_while(|&start| start <= bytes.len() - MAGIC)
}

#[test]
fn a_recording_cut_at_any_byte_of_its_entries_or_of_a_head_is_read_up_to_the_cut() {
    let (bytes, entries) = recording();
    let found_in = |length: usize| read(&bytes[..length]).0.len();
    let mut distant = (0..bytes.len()).step_by(DISTANCE);
    let first = distant.find(|&length| found_in(length) > 0).unwrap().saturating_sub(DISTANCE);
    let all = distant.find(|&length| found_in(length) == entries.len()).unwrap();
    assert!(all - first > 10 * DISTANCE, "the entries lie from {first} to {all}");
    let heads = record_starts(&bytes).flat_map(|start| start - 1..start + HEAD + 1);
    let mut cuts: Vec<usize> = (0..bytes.len()).step_by(DISTANCE).chain(first..all).chain(heads).collect();
    cuts.retain(|&length| length < bytes.len());
    cuts.sort_unstable();
    cuts.dedup();
    let mut max_found = 0;
    for length in cuts {
        let (found, error) = read(&bytes[..length]);
        assert!(entries.starts_with(&found), "cut at {length}");
        assert!(found.len() >= max_found, "cut at {length}: fewer entries than before");
        max_found = found.len();
        match error {
            Some(ReadError::Truncated) => assert!(!found.is_empty(), "cut at {length}"),
            Some(ReadError::Container(_)) => assert!(found.is_empty(), "cut at {length}"),
            other => panic!("cut at {length}: {other:?}"),
        }
    }
    assert_eq!(max_found, entries.len());
}

#[test]
fn a_cut_says_what_was_lost() {
    let bytes = written(&[input(RecordedInput::Tick)]);
    let (_, error) = read(&bytes[..bytes.len() - 1]);
    assert_eq!(error.unwrap().to_string(), "the recording is cut off: everything before the cut was read");
}

#[test]
fn what_is_no_recording_is_said_to_be_none() {
    for bytes in [&b""[..], b"x_val,y_val,pitch,yaw,val,time", &[0; 64]] {
        let (found, error) = read(bytes);
        assert!(found.is_empty());
        assert!(matches!(error, Some(ReadError::Container(_))), "{error:?}");
    }
}
