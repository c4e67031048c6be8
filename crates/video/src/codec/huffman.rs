//! JPEG pictures without Huffman tables, as USB cameras send them (Motion JPEG).
//!
//! Such a picture uses the tables that ITU-T T.81 gives as typical (K.3.3). The decoder needs them in the
//! picture, in a DHT segment (B.2.4.2).

const SOI: u8 = 0xd8;
const EOI: u8 = 0xd9;
const SOS: u8 = 0xda;
const DHT: u8 = 0xc4;

/// A Huffman table.
struct Table {
    /// Class (0: DC, 1: AC) and number (0: luma, 1: chroma).
    head: u8,
    /// The number of codes of 1 to 16 bits.
    lengths: [u8; 16],
    /// The symbols, in the order of their codes.
    symbols: &'static [u8],
}

/// Tables K.3 to K.6.
const TABLES: [Table; 4] = [
    Table {
        head: 0x00,
        lengths: [0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0],
        symbols: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
    },
    Table {
        head: 0x01,
        lengths: [0, 3, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0],
        symbols: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
    },
    Table { head: 0x10, lengths: [0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 0x7d], symbols: &LUMA_AC },
    Table { head: 0x11, lengths: [0, 2, 1, 2, 4, 4, 3, 4, 7, 5, 4, 4, 0, 1, 2, 0x77], symbols: &CHROMA_AC },
];

/// The symbols of table K.5.
const LUMA_AC: [u8; 162] = [
    0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06, 0x13, 0x51, 0x61, 0x07, 0x22,
    0x71, 0x14, 0x32, 0x81, 0x91, 0xa1, 0x08, 0x23, 0x42, 0xb1, 0xc1, 0x15, 0x52, 0xd1, 0xf0, 0x24, 0x33,
    0x62, 0x72, 0x82, 0x09, 0x0a, 0x16, 0x17, 0x18, 0x19, 0x1a, 0x25, 0x26, 0x27, 0x28, 0x29, 0x2a, 0x34,
    0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55,
    0x56, 0x57, 0x58, 0x59, 0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75, 0x76,
    0x77, 0x78, 0x79, 0x7a, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8a, 0x92, 0x93, 0x94, 0x95, 0x96,
    0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4, 0xb5,
    0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2, 0xd3, 0xd4,
    0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe1, 0xe2, 0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf1,
    0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa,
];

/// The symbols of table K.6.
const CHROMA_AC: [u8; 162] = [
    0x00, 0x01, 0x02, 0x03, 0x11, 0x04, 0x05, 0x21, 0x31, 0x06, 0x12, 0x41, 0x51, 0x07, 0x61, 0x71, 0x13,
    0x22, 0x32, 0x81, 0x08, 0x14, 0x42, 0x91, 0xa1, 0xb1, 0xc1, 0x09, 0x23, 0x33, 0x52, 0xf0, 0x15, 0x62,
    0x72, 0xd1, 0x0a, 0x16, 0x24, 0x34, 0xe1, 0x25, 0xf1, 0x17, 0x18, 0x19, 0x1a, 0x26, 0x27, 0x28, 0x29,
    0x2a, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54,
    0x55, 0x56, 0x57, 0x58, 0x59, 0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75,
    0x76, 0x77, 0x78, 0x79, 0x7a, 0x82, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8a, 0x92, 0x93, 0x94,
    0x95, 0x96, 0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3,
    0xb4, 0xb5, 0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2,
    0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe2, 0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea,
    0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa,
];

/// The picture with Huffman tables: the picture itself where it has some, or where it cannot be read.
/// Otherwise its copy in `buffer`.
pub(super) fn with_tables<'a>(picture: &'a [u8], buffer: &'a mut Vec<u8>) -> &'a [u8] {
    if !lacks_tables(picture) {
        return picture;
    }
    let (start, rest) = picture.split_at(2);
    buffer.clear();
    buffer.extend_from_slice(start);
    push_tables(buffer);
    buffer.extend_from_slice(rest);
    buffer
}

/// Whether a picture has its first scan, and no Huffman table in front of it.
fn lacks_tables(picture: &[u8]) -> bool {
    segments(picture).find(|marker| matches!(*marker, DHT | SOS | EOI)) == Some(SOS)
}

/// The markers of the segments from the start of a picture (B.1.1.2), up to one that is cut short or
/// malformed. Behind SOS they are of no use: the samples of the scan are no segments.
fn segments(picture: &[u8]) -> impl Iterator<Item = u8> {
    let mut rest = picture.strip_prefix(&[0xff, SOI]).unwrap_or_default();
    std::iter::from_fn(move || {
        // Any number of fill bytes stands before a marker.
        let fill = rest.iter().take_while(|byte| **byte == 0xff).count();
        let marker = *rest.get(fill).filter(|_| fill > 0)?;
        rest = &rest[fill + 1..];
        let has_length = !matches!(marker, 0x01 | 0xd0..=EOI);
        if has_length {
            let length = u16::from_be_bytes(*rest.first_chunk()?);
            rest = rest.get(usize::from(length.max(2))..)?;
        }
        Some(marker)
    })
}

fn push_tables(picture: &mut Vec<u8>) {
    let length = 2 + TABLES.iter().map(|table| 17 + table.symbols.len()).sum::<usize>();
    picture.extend_from_slice(&[0xff, DHT]);
    picture.extend_from_slice(&(length as u16).to_be_bytes());
    for table in &TABLES {
        picture.push(table.head);
        picture.extend_from_slice(&table.lengths);
        picture.extend_from_slice(table.symbols);
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::image::PictureSize;
    use barrelman_vocab::video::{ColourEncoding, Picture};

    use super::super::jpeg;
    use super::super::pool::PicturePool;
    use super::super::still::StillDecoder;
    use super::*;

    /// A picture of noise, which needs most of the codes, as a file with the typical tables.
    fn noise() -> Vec<u8> {
        let mut picture = Picture::black(PictureSize::new(160, 96), ColourEncoding::JPEG);
        let mut state = 1_u32;
        for plane in picture.planes_mut() {
            for sample in plane.iter_mut() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *sample = (state >> 24) as u8;
            }
        }
        jpeg::encode(&picture).unwrap()
    }

    /// The same file without its tables.
    fn without_tables(file: &[u8]) -> Vec<u8> {
        let mut bare = file[..2].to_vec();
        let mut rest = &file[2..];
        while rest[1] != SOS {
            let length = 2 + usize::from(u16::from_be_bytes([rest[2], rest[3]]));
            if rest[1] != DHT {
                bare.extend_from_slice(&rest[..length]);
            }
            rest = &rest[length..];
        }
        [&bare, rest].concat()
    }

    fn decoded(file: &[u8]) -> Result<Picture, String> {
        let picture = StillDecoder::default().jpeg(file, &mut PicturePool::default())?;
        Ok(Picture::clone(&picture))
    }

    #[test]
    fn a_picture_without_tables_gives_the_same_samples() {
        let file = noise();
        let bare = without_tables(&file);
        assert!(bare.len() < file.len() - 400);
        assert!(decoded(&bare).unwrap() == decoded(&file).unwrap());
    }

    #[test]
    fn a_picture_with_tables_stays_as_it_is() {
        let file = noise();
        let mut buffer = Vec::new();
        assert!(std::ptr::eq(with_tables(&file, &mut buffer), file.as_slice()));
    }

    #[test]
    fn fill_bytes_are_no_marker() {
        let bare = without_tables(&noise());
        let filled = [&bare[..2], &[0xff, 0xff, 0xff], &bare[2..]].concat();
        assert!(lacks_tables(&filled));
        assert!(!lacks_tables(&[0xff, SOI, 0, SOS]));
        assert!(!lacks_tables(&[0xff, SOI, 0xff, EOI, 0xff, SOS, 0, 2]));
    }

    #[test]
    fn a_picture_that_is_cut_off_is_judged_as_one_with_tables() {
        let file = noise();
        let bare = without_tables(&file);
        for cut in (0..bare.len() - 400).step_by(bare.len() / 200) {
            let end = bare.len() - cut;
            let with_tables = decoded(&file[..file.len() - cut]);
            assert!(decoded(&bare[..end]) == with_tables, "cut at {end}");
        }
        for end in 0..400 {
            assert!(decoded(&bare[..end]).is_err(), "cut at {end}");
        }
    }
}
