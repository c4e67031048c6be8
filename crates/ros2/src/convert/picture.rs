//! A picture of the socket: a head of 32 bytes, then a JPEG file. The interface for programs describes the
//! head.

use bytes::Bytes;

use crate::messages::{CompressedImage, Header, Octets};

const HEAD_BYTES: usize = 32;
const VERSION: u8 = 1;
const JPEG: u8 = 2;

/// A JPEG picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Time of capture, nanoseconds since the program's start.
    pub captured_ns: u64,
    /// The file.
    pub jpeg: Bytes,
}

impl Picture {
    /// The picture of a binary message; `None`: the message contains something else.
    pub fn parse(message: &Bytes) -> Option<Self> {
        let head = message.get(..HEAD_BYTES)?;
        if head[..2] != [VERSION, JPEG] {
            return None;
        }
        let captured_ns = u64::from_le_bytes(head[8..16].try_into().ok()?);
        Some(Self { captured_ns, jpeg: message.slice(HEAD_BYTES..) })
    }

    /// The message.
    pub fn message(self, header: Header) -> CompressedImage {
        CompressedImage { header, format: "jpeg", data: Octets(self.jpeg) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(version: u8, kind: u8, captured_ns: u64, content: &[u8]) -> Bytes {
        let mut bytes = vec![0; HEAD_BYTES];
        (bytes[0], bytes[1]) = (version, kind);
        bytes[8..16].copy_from_slice(&captured_ns.to_le_bytes());
        bytes.extend_from_slice(content);
        bytes.into()
    }

    #[test]
    fn a_jpeg_picture_has_its_time_and_its_file() {
        let captured_ns = 0x0102_0304_0506_0708;
        let picture = Picture::parse(&message(1, 2, captured_ns, &[0xFF, 0xD8]));
        assert_eq!(picture, Some(Picture { captured_ns, jpeg: Bytes::from_static(&[0xFF, 0xD8]) }));
    }

    #[test]
    fn nothing_else_is_a_picture() {
        for other in [message(1, 1, 0, &[0; 9]), message(1, 3, 0, &[]), message(2, 2, 0, &[]), Bytes::new()] {
            assert_eq!(Picture::parse(&other), None, "{other:?}");
        }
        assert_eq!(Picture::parse(&message(1, 2, 0, &[]).slice(..31)), None);
    }
}
