//! H.264 and H.265 told apart by the head of an RTP payload: the values that cameras send in H.264 are none
//! in H.265, and the other way round.
//! ```text
//!  H.264 (RFC 6184, 1.3)  |F|NRI| type 5 |                       sets 7 and 8, slices 1 and 5, FU-A 28
//!  H.265 (RFC 7798, 1.1.4)|F| type 6 | layer 6 | TID 3 |         sets 32 to 34, slices 0 to 21, FU 49; layer 0, TID 1 to 7
//! ```

/// Payloads of one format that decide, without one of the other between.
const DECISIVE: usize = 5;

/// Finds out the format of a stream by its payloads.
#[derive(Debug, Default)]
pub(super) struct EncodingGuess {
    h264: usize,
    h265: usize,
}

impl EncodingGuess {
    /// Takes a payload. Returns the encoding name, as soon as it is certain.
    pub(super) fn on_payload(&mut self, payload: &[u8]) -> Option<&'static str> {
        match nal_encoding(payload) {
            Some("H264") => (self.h264, self.h265) = (self.h264 + 1, 0),
            Some(_) => (self.h264, self.h265) = (0, self.h265 + 1),
            None => {}
        }
        if self.h264 >= DECISIVE {
            return Some("H264");
        }
        (self.h265 >= DECISIVE).then_some("H265")
    }
}

/// The encoding name of a payload; `None`: it may be either, or neither.
fn nal_encoding(payload: &[u8]) -> Option<&'static str> {
    let [first, second, ..] = *payload else { return None };
    match (is_h264(first), is_h265(first, second)) {
        (true, false) => Some("H264"),
        (false, true) => Some("H265"),
        _ => None,
    }
}

fn is_h264(first: u8) -> bool {
    first & 0x80 == 0 && matches!(first & 0x1f, 1 | 5..=9 | 24 | 28)
}

fn is_h265(first: u8, second: u8) -> bool {
    first & 0x81 == 0 && matches!(second, 1..=7) && matches!(first >> 1, 0..=9 | 16..=21 | 32..=40 | 48 | 49)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_of_cameras_belong_to_one_format() {
        for head in [[0x67, 0x42], [0x68, 0xce], [0x7c, 0x85], [0x41, 0x9a], [0x61, 1]] {
            assert_eq!(nal_encoding(&head), Some("H264"), "{head:x?}");
        }
        for head in [[0x40, 1], [0x42, 1], [0x44, 1], [0x4e, 1], [0x62, 1], [0x02, 1]] {
            assert_eq!(nal_encoding(&head), Some("H265"), "{head:x?}");
        }
        assert_eq!(nal_encoding(&[0x67]), None);
    }
}
