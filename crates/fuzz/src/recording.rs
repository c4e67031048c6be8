//! Recordings (MCAP).

use barrelman_trial::records::table::read_rows;
use barrelman_trial::records::{ReadError, RecordingReader};

/// Any bytes, and the same behind the magic of the format: entries or errors, no panic.
pub fn read(bytes: &[u8]) {
    for bytes in [bytes.to_vec(), [b"\x89MCAP0\r\n".as_slice(), bytes].concat()] {
        let _ = RecordingReader::new(bytes.as_slice()).count();
        let _ = read_rows(bytes.as_slice(), |_| Ok::<(), ReadError>(()));
    }
}
