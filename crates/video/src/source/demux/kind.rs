//! Detects the kind of a file from its first bytes.

/// Number of bytes that [`FileKind::detect`] needs.
pub const HEAD_BYTES: u64 = 4096;

const REENCODE: &str = "Convert it: ffmpeg -i IN -c:v libx264 -pix_fmt yuv420p OUT.mp4";
const REPACK: &str = "Put it into MP4 without loss: ffmpeg -i IN -c copy OUT.mp4 \
                      (if its codec is not H.264: ffmpeg -i IN -c:v libx264 -pix_fmt yuv420p OUT.mp4)";
/// The kind of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// MP4 or QuickTime.
    Mp4,
    /// Y4M (YUV4MPEG2): uncompressed pictures with a text header.
    Y4m,
    /// A PNG picture.
    Png,
    /// A JPEG picture.
    Jpeg,
    /// A WebP picture.
    Webp,
    /// A TIFF picture.
    Tiff,
    /// No video.
    NotVideo {
        /// What it is, with its article.
        what: &'static str,
    },
    /// A kind that the built-in engine does not read.
    Other {
        /// The kind, with its article.
        what: &'static str,
        /// How to convert it.
        remedy: &'static str,
    },
}

impl FileKind {
    /// The kind of the file that starts with these bytes.
    pub fn detect(head: &[u8]) -> Self {
        let other = |what, remedy| Self::Other { what, remedy };
        match head {
            [] => Self::NotVideo { what: "an empty file" },
            [b'Y', b'U', b'V', b'4', b'M', b'P', b'E', b'G', b'2', ..] => Self::Y4m,
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Self::Png,
            [0xff, 0xd8, 0xff, ..] => Self::Jpeg,
            [_, _, _, _, kind @ ..] if is_mp4_box(kind) => Self::Mp4,
            [b'R', b'I', b'F', b'F', _, _, _, _, b'A', b'V', b'I', b' ', ..] => {
                other("an AVI file", REENCODE)
            }
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Self::Webp,
            [b'R', b'I', b'F', b'F', ..] => other("a RIFF file", REENCODE),
            [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => Self::Tiff,
            [0x1a, 0x45, 0xdf, 0xa3, ..] if contains(head, b"webm") => other("a WebM file", REENCODE),
            [0x1a, 0x45, 0xdf, 0xa3, ..] => other("a Matroska (MKV) file", REPACK),
            [b'D', b'K', b'I', b'F', ..] => other("an IVF file", REENCODE),
            [b'O', b'g', b'g', b'S', ..] => other("an Ogg file", REENCODE),
            [b'F', b'L', b'V', ..] => other("an FLV file", REPACK),
            [b'G', b'I', b'F', b'8', ..] => other("a GIF file", REENCODE),
            [0x30, 0x26, 0xb2, 0x75, ..] => other("an ASF (WMV) file", REENCODE),
            [0, 0, 1, 0xba, ..] => other("an MPEG programme stream", REENCODE),
            [0x47, ..] if head.get(188).is_none_or(|sync| *sync == 0x47) && head.len() >= 188 => {
                other("an MPEG transport stream", REPACK)
            }
            [0, 0, 1, ..] | [0, 0, 0, 1, ..] => other(
                "a raw H.264 or H.265 stream without times",
                "Put it into MP4: ffmpeg -r 30 -i IN -c copy OUT.mp4 (H.264 only)",
            ),
            _ if is_text(head) => Self::NotVideo { what: "a text file" },
            _ => other("of a kind that is not known", REENCODE),
        }
    }
}

impl FileKind {
    /// Whether the file is a single picture.
    pub const fn is_picture(self) -> bool {
        matches!(self, Self::Png | Self::Jpeg | Self::Webp | Self::Tiff)
    }
}

fn is_mp4_box(kind: &[u8]) -> bool {
    let known: [&[u8]; 8] = [b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot", b"styp"];
    known.iter().any(|known| kind.starts_with(known))
}

fn contains(head: &[u8], word: &[u8]) -> bool {
    head.windows(word.len()).any(|window| window == word)
}

fn is_text(head: &[u8]) -> bool {
    // The last character may be incomplete.
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => return is_text(&head[..error.valid_up_to()]),
        Err(_) => return false,
    };
    text.chars().all(|c| !c.is_control() || c.is_ascii_whitespace() || c == '\u{1b}')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(head: &[u8], expected: &str) {
        match FileKind::detect(head) {
            FileKind::Other { what, .. } | FileKind::NotVideo { what } => {
                assert!(what.contains(expected), "{head:?}: {what}")
            }
            known => panic!("{head:?} was detected as {known:?}"),
        }
    }

    #[test]
    fn what_is_not_read_is_named() {
        check(b"", "empty");
        check(b"x,y,w,h\n1,2,3,4\n", "text");
        check("cut in a charact\u{e4}".as_bytes().split_last().unwrap().1, "text");
        check(b"RIFF\x10\x00\x00\x00AVI LIST", "AVI");
        check(b"\x1a\x45\xdf\xa3\x01\x00webm", "WebM");
        check(b"\x1a\x45\xdf\xa3\x01\x00matroska", "Matroska");
        check(&[0x47; 400], "transport stream");
        check(b"\x00\x00\x00\x01\x67\x42", "raw H.264");
        check(&[0xde, 0xad, 0xbe, 0xef, 1, 2, 3, 4], "not known");
    }

    #[test]
    fn what_is_read_is_known_by_its_content() {
        assert_eq!(FileKind::detect(b"\x00\x00\x00\x18ftypisom"), FileKind::Mp4);
        assert_eq!(FileKind::detect(b"YUV4MPEG2 W2 H2\n"), FileKind::Y4m);
        assert_eq!(FileKind::detect(b"\x89PNG\r\n\x1a\n\x00"), FileKind::Png);
        assert_eq!(FileKind::detect(&[0xff, 0xd8, 0xff, 0xe0]), FileKind::Jpeg);
    }
}
