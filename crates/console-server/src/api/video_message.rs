//! The head of a binary message: one unit of video.
//!
//! | bytes | content (little-endian) |
//! |---|---|
//! | 0 | version, 1 |
//! | 1 | kind: 1 an H.264 access unit (Annex B), 2 a JPEG picture, 3 an H.265 access unit (Annex B) |
//! | 2 | flags: bit 0 key frame, bit 1 displayed |
//! | 3 | clockwise quarter turns that make the picture upright, 0 to 3 |
//! | 4..8 | number of the connection to the source; decode no unit with those of another |
//! | 8..16 | time of capture, nanoseconds since the program's start |
//! | 16..24 | number of the unit; a gap: units were left out, and decoding starts again with a key frame |
//! | 24..26, 26..28 | width and height of the stored picture, pixels; 0: not known |
//! | 28 | number of the video: 1 or 2 |
//! | 29..32 | 0 |

use barrelman_vocab::unit::Rotation;
use barrelman_vocab::{EncodedUnit, VideoFrame, VideoNumber};

/// Length of the head, bytes.
pub const HEAD_BYTES: usize = 32;
/// Version of the head.
const VERSION: u8 = 1;

/// What a binary message contains after its head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum VideoKind {
    /// An H.264 access unit.
    H264 = 1,
    /// A JPEG picture.
    Jpeg = 2,
    /// An H.265 access unit.
    H265 = 3,
}

/// The head of a binary message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VideoHead {
    /// What follows.
    pub kind: VideoKind,
    /// Whether decoding can start here.
    pub key: bool,
    /// Whether the picture is displayed.
    pub shown: bool,
    /// Rotation that makes the picture upright.
    pub rotation: Rotation,
    /// Number of the connection to the source.
    pub epoch: u32,
    /// Time of capture, nanoseconds since the program's start.
    pub captured_ns: u64,
    /// Number of the unit.
    pub index: u64,
    /// Stored width and height; (0, 0) where they are not known.
    pub size: (u16, u16),
    /// The video to which it belongs.
    pub video: VideoNumber,
}

impl VideoHead {
    /// The head of a unit as it was received.
    pub fn of_unit(kind: VideoKind, unit: &EncodedUnit, video: VideoNumber) -> Self {
        Self {
            kind,
            key: unit.key,
            shown: unit.shown,
            rotation: unit.rotation,
            epoch: unit.epoch,
            captured_ns: unit.capture.at.as_nanos(),
            index: unit.index,
            size: (0, 0),
            video,
        }
    }

    /// The head of a video frame as JPEG.
    pub fn of_picture(frame: &VideoFrame, video: VideoNumber) -> Self {
        let side = |length: u32| u16::try_from(length).unwrap_or(u16::MAX);
        let size = frame.picture.size();
        Self {
            kind: VideoKind::Jpeg,
            key: true,
            shown: true,
            rotation: Rotation::None,
            epoch: 0,
            captured_ns: frame.capture.at.as_nanos(),
            index: frame.sequence,
            size: (side(size.width), side(size.height)),
            video,
        }
    }

    /// The whole message.
    pub fn message(self, payload: &[u8]) -> Vec<u8> {
        [self.to_bytes().as_slice(), payload].concat()
    }

    /// The bytes of the head.
    pub fn to_bytes(self) -> [u8; HEAD_BYTES] {
        let mut bytes = [0; HEAD_BYTES];
        bytes[0] = VERSION;
        bytes[1] = self.kind as u8;
        bytes[2] = u8::from(self.key) | u8::from(self.shown) << 1;
        bytes[3] = match self.rotation {
            Rotation::None => 0,
            Rotation::Clockwise90 => 1,
            Rotation::Half => 2,
            Rotation::Clockwise270 => 3,
        };
        bytes[4..8].copy_from_slice(&self.epoch.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.captured_ns.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.index.to_le_bytes());
        bytes[24..26].copy_from_slice(&self.size.0.to_le_bytes());
        bytes[26..28].copy_from_slice(&self.size.1.to_le_bytes());
        bytes[28] = self.video.count();
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: VideoHead = VideoHead {
        kind: VideoKind::H264,
        key: false,
        shown: false,
        rotation: Rotation::None,
        epoch: 0,
        captured_ns: 0,
        index: 0,
        size: (0, 0),
        video: VideoNumber::First,
    };

    /// The bytes of a head that are not zero, with their places.
    #[track_caller]
    fn check(head: VideoHead, expected: &[(usize, u8)]) {
        let bytes = head.to_bytes();
        let set = bytes[..28].iter().copied().enumerate().filter(|(_, byte)| *byte != 0);
        assert_eq!(set.collect::<Vec<_>>(), expected, "{head:?}");
        assert_eq!(bytes[28..], [head.video.count(), 0, 0, 0]);
    }

    #[test]
    fn each_field_has_its_place() {
        check(HEAD, &[(0, 1), (1, 1)]);
        check(VideoHead { video: VideoNumber::Second, ..HEAD }, &[(0, 1), (1, 1)]);
        check(VideoHead { kind: VideoKind::Jpeg, ..HEAD }, &[(0, 1), (1, 2)]);
        check(VideoHead { key: true, ..HEAD }, &[(0, 1), (1, 1), (2, 1)]);
        check(VideoHead { shown: true, ..HEAD }, &[(0, 1), (1, 1), (2, 2)]);
        check(VideoHead { key: true, shown: true, ..HEAD }, &[(0, 1), (1, 1), (2, 3)]);
        check(VideoHead { rotation: Rotation::Clockwise90, ..HEAD }, &[(0, 1), (1, 1), (3, 1)]);
        check(VideoHead { rotation: Rotation::Half, ..HEAD }, &[(0, 1), (1, 1), (3, 2)]);
        check(VideoHead { rotation: Rotation::Clockwise270, ..HEAD }, &[(0, 1), (1, 1), (3, 3)]);
        check(VideoHead { epoch: 0x0100_0002, ..HEAD }, &[(0, 1), (1, 1), (4, 2), (7, 1)]);
        check(VideoHead { captured_ns: 3 << 56 | 4, ..HEAD }, &[(0, 1), (1, 1), (8, 4), (15, 3)]);
        check(VideoHead { index: 5 << 56 | 6, ..HEAD }, &[(0, 1), (1, 1), (16, 6), (23, 5)]);
        check(
            VideoHead { size: (0x0201, 0x0403), ..HEAD },
            &[(0, 1), (1, 1), (24, 1), (25, 2), (26, 3), (27, 4)],
        );
    }
}
