//! No file, however damaged, makes a reader panic.

use barrelman_trial::records::table::read_rows;
use barrelman_trial::records::{ReadError, RecordingReader};
use proptest::prelude::*;

use crate::entries::{every_kind, read, written};

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
