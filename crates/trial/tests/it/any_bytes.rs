//! No file, however damaged, makes a reader panic.

use barrelman_trial::records::table::read_rows;
use barrelman_trial::records::{ReadError, RecordingReader};
use proptest::prelude::*;

use crate::entries::{every_kind, read, start, written};

fn read_all(bytes: &[u8]) {
    let entries = RecordingReader::new(bytes).count();
    let _ = entries;
    let _ = read_rows(bytes, |_| Ok::<(), ReadError>(()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..4_000)) {
        read_all(&bytes);
    }

    #[test]
    fn any_bytes_behind_the_magic_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..4_000)) {
        read_all(&[b"\x89MCAP0\r\n".as_slice(), &bytes].concat());
    }

    #[test]
    fn a_damaged_recording_is_read_or_refused(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
    ) {
        let mut bytes = written(&every_kind());
        for (place, value) in damage {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        let _ = read(&bytes);
        read_all(&bytes);
    }
}

/// Sets each byte of the first record's length in turn to its largest value.
#[test]
fn a_record_that_reaches_beyond_its_chunk_is_refused() {
    let bytes = written(&every_kind());
    let version = start().program.into_bytes();
    let library = bytes.windows(version.len()).position(|window| window == version).unwrap();
    let chunk = library + version.len();
    assert_eq!(bytes[chunk], 0x06, "a chunk follows the header");
    let first_record = chunk + 9 + 40;
    for place in first_record + 1..first_record + 9 {
        let mut damaged = bytes.clone();
        damaged[place] = 0xff;
        let (_, error) = read(&damaged);
        assert!(matches!(error, Some(ReadError::Container(_))), "length byte at {place}: {error:?}");
    }
}

/// The reader below takes as much memory as the length of a text says, up to 4 GiB.
#[test]
fn a_text_that_reaches_beyond_its_record_is_refused() {
    let bytes = written(&every_kind());
    for text in [start().program.as_str(), "protobuf", "proto3"] {
        let text = [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
        let found: Vec<_> = bytes
            .windows(text.len())
            .enumerate()
            .filter(|(_, window)| *window == text)
            .map(|(at, _)| at)
            .collect();
        for at in found {
            let mut damaged = bytes.clone();
            damaged[at + 3] = 0xff;
            let (_, error) = read(&damaged);
            let Some(ReadError::Container(error)) = error else { panic!("{at}: {error:?}") };
            let cause = format!("{error:?}");
            assert!(cause.contains("reaches beyond its record"), "{at}: {cause}");
        }
    }
}

/// A channel whose table holds a name without a value: the reader below would look for the value behind the
/// table.
#[test]
fn a_table_that_ends_within_a_pair_is_refused() {
    let name = [&1_u32.to_le_bytes()[..], b"x"].concat();
    let content =
        [&[1, 0, 0, 0][..], &name, &name, &(name.len() as u32).to_le_bytes(), &name, &u32::MAX.to_le_bytes()]
            .concat();
    let channel = [&[0x04][..], &(content.len() as u64).to_le_bytes(), &content].concat();
    let bytes = [b"\x89MCAP0\r\n".as_slice(), &channel].concat();
    let errors: Vec<String> = RecordingReader::new(bytes.as_slice())
        .filter_map(|entry| entry.err().map(|error| format!("{error:?}")))
        .collect();
    assert!(errors.iter().any(|error| error.contains("reaches beyond its record")), "{errors:?}");
}

#[test]
fn a_schema_in_an_unknown_syntax_is_refused() {
    let mut bytes = written(&every_kind());
    let places: Vec<_> =
        bytes.windows(6).enumerate().filter(|(_, text)| text == b"proto3").map(|(at, _)| at).collect();
    assert!(!places.is_empty());
    for at in places {
        bytes[at..at + 6].copy_from_slice(b"proto9");
    }
    let refusal = read_rows(bytes.as_slice(), |_| Ok::<(), ReadError>(())).unwrap_err();
    assert!(matches!(refusal, ReadError::Message { .. }), "{refusal:?}");
    assert!(refusal.to_string().contains("proto9"), "{refusal}");
}
