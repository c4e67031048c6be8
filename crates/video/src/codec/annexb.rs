//! H.264 access units as bytes: NAL units behind start codes (ITU-T H.264, Annex B), and NAL units behind
//! their lengths as in MP4 files (ISO/IEC 14496-15).
//!
//! This module reads only what the crate needs to pass units on: the kinds of NAL units, the type of a slice,
//! and the parameter sets of an `avcC` box. It decodes no picture. The fields of NAL units are read by
//! `h264-reader`. Two parts are the module's own:
//!
//! - The search for start codes. The units are whole in memory, and [`nals`] borrows them; the `AnnexBReader`
//!   of `h264-reader` is a parser for a stream in pieces, which hands out copies.
//! - The `avcC` box. The record of `h264-reader` panics on an empty parameter set, as a damaged file may
//!   hold, and refuses a file for parameter sets of another kind, which the decoder ignores.

use h264_reader::nal::UnitType;
use h264_reader::rbsp::{BitRead as _, BitReader, ByteReader};

/// A start code in its long form, which is valid before every NAL unit.
pub const START_CODE: [u8; 4] = [0, 0, 0, 1];

/// The kinds of NAL units that the crate tells apart (`nal_unit_type`, table 7-1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NalKind {
    /// A slice of a picture that is not a key picture.
    Slice,
    /// A slice of a key picture (IDR): decoding can begin here.
    KeySlice,
    /// A sequence parameter set.
    Sps,
    /// A picture parameter set.
    Pps,
    /// Anything else.
    Other,
}

/// The kind of a NAL unit, from its first byte.
pub fn kind(nal: &[u8]) -> NalKind {
    match unit_type(nal) {
        Some(
            UnitType::SliceLayerWithoutPartitioningNonIdr
            | UnitType::SliceDataPartitionALayer
            | UnitType::SliceDataPartitionBLayer
            | UnitType::SliceDataPartitionCLayer,
        ) => NalKind::Slice,
        Some(UnitType::SliceLayerWithoutPartitioningIdr) => NalKind::KeySlice,
        Some(UnitType::SeqParameterSet) => NalKind::Sps,
        Some(UnitType::PicParameterSet) => NalKind::Pps,
        _ => NalKind::Other,
    }
}

/// `nal_unit_type`, the low five bits of the first byte. The other bits are not checked.
fn unit_type(nal: &[u8]) -> Option<UnitType> {
    UnitType::for_id(nal.first()? & 0x1f).ok()
}

/// The NAL units of an Annex B access unit, without start codes and trailing zeros.
pub fn nals(unit: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = after_start_code(unit);
    std::iter::from_fn(move || {
        let current = rest?;
        let end = find_start_code(current);
        rest = end.and_then(|end| after_start_code(&current[end..]));
        let nal = &current[..end.unwrap_or(current.len())];
        let trailing = nal.iter().rev().take_while(|byte| **byte == 0).count();
        Some(&nal[..nal.len() - trailing])
    })
    .filter(|nal| !nal.is_empty())
}

fn find_start_code(bytes: &[u8]) -> Option<usize> {
    let mut from = 0;
    // Looking at every third byte is enough: a start code has none above 1.
    while from + 2 < bytes.len() {
        match bytes[from + 2] {
            0 => from += 1,
            1 if bytes[from] == 0 && bytes[from + 1] == 0 => return Some(from),
            _ => from += 3,
        }
    }
    None
}

fn after_start_code(bytes: &[u8]) -> Option<&[u8]> {
    find_start_code(bytes).map(|at| &bytes[at + 3..])
}

/// Whether a slice is bidirectional (B): its picture is shown before one that was decoded earlier. A slice
/// whose header cannot be read is not.
pub fn is_bidirectional(slice: &[u8]) -> bool {
    /// The NAL header, and at most 31 + 7 bits of the two fields with their emulation prevention bytes.
    const MAX_BYTES: usize = 8;
    // Slice header (7.3.3). `SliceHeader` of h264-reader reads all of it and needs the parameter sets for
    // that.
    let header = &slice[..slice.len().min(MAX_BYTES)];
    let mut bits = BitReader::new(ByteReader::skipping_h264_header(header));
    let slice_type = bits.read_ue("first_mb_in_slice").and_then(|_| bits.read_ue("slice_type"));
    // Table 7-6: B is 1, or 6 where all slices of the picture are B.
    matches!(slice_type, Ok(1 | 6))
}

/// Whether an access unit has slices, and none of a key picture (IDR).
pub fn lacks_key_slice(unit: &[u8]) -> bool {
    let mut has_slice = false;
    for nal in nals(unit) {
        match kind(nal) {
            NalKind::KeySlice => return false,
            NalKind::Slice => has_slice = true,
            NalKind::Sps | NalKind::Pps | NalKind::Other => {}
        }
    }
    has_slice
}

/// Whether an access unit has a recovery point (SEI message 6, D.2.8): decoding can begin here, and the
/// pictures are intact some units later. Streams with periodic intra refresh have no key picture but these.
pub fn has_recovery_point(unit: &[u8]) -> bool {
    const RECOVERY_POINT: u32 = 6;
    let is_sei = |nal: &&[u8]| unit_type(nal) == Some(UnitType::SEI);
    nals(unit).filter(is_sei).any(|nal| sei_types(&nal[1..]).any(|kind| kind == RECOVERY_POINT))
}

/// The types of the messages in the payload of an SEI NAL unit (7.3.2.3.1). Emulation prevention bytes stand
/// only in long messages: the types behind one may be missed.
fn sei_types(payload: &[u8]) -> impl Iterator<Item = u32> {
    let mut rest = payload;
    std::iter::from_fn(move || {
        // The trailing bits alone are a byte.
        if rest.len() < 2 {
            return None;
        }
        let (kind, after) = sei_number(rest)?;
        let (size, after) = sei_number(after)?;
        rest = after.get(size as usize..).unwrap_or_default();
        Some(kind)
    })
}

/// A number as a run of 255 and a last byte.
fn sei_number(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let full = bytes.iter().take_while(|byte| **byte == 0xff).count();
    let last = *bytes.get(full)?;
    Some((255 * u32::try_from(full).ok()? + u32::from(last), &bytes[full + 1..]))
}

/// The content of an `avcC` box (ISO/IEC 14496-15, 5.3.3.1).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AvcConfiguration {
    /// Bytes of the length before each NAL unit: 1, 2 or 4; a damaged box may say 3.
    pub length_size: usize,
    /// The parameter sets, Annex B.
    pub parameter_sets: Vec<u8>,
}

impl AvcConfiguration {
    /// Reads the content of an `avcC` box; `None` if it is cut short or malformed.
    pub fn parse(content: &[u8]) -> Option<Self> {
        let length_size = usize::from(content.get(4)? & 3) + 1;
        let mut parameter_sets = Vec::new();
        let mut rest = content.get(5..)?;
        for mask in [0x1f, 0xff] {
            let (count, mut sets) = rest.split_first()?;
            for _ in 0..count & mask {
                let length = usize::from(u16::from_be_bytes(sets.first_chunk().copied()?));
                parameter_sets.extend_from_slice(&START_CODE);
                parameter_sets.extend_from_slice(sets.get(2..2 + length)?);
                sets = &sets[2 + length..];
            }
            rest = sets;
        }
        Some(Self { length_size, parameter_sets })
    }

    /// Converts a sample of an MP4 file to an Annex B access unit. A key picture without parameter sets of
    /// its own gets those of the box before it.
    ///
    /// # Errors
    /// A length that reaches past the end of the sample.
    pub fn to_annex_b(&self, sample: &[u8]) -> Result<AnnexBUnit, MalformedSample> {
        let mut nals = Vec::new();
        let mut rest = sample;
        while !rest.is_empty() {
            let length = rest.get(..self.length_size).ok_or(MalformedSample)?;
            let length = length.iter().fold(0_usize, |value, byte| value << 8 | usize::from(*byte));
            let end = self.length_size.checked_add(length).ok_or(MalformedSample)?;
            let nal = rest.get(self.length_size..end).ok_or(MalformedSample)?;
            if !nal.is_empty() {
                nals.push(nal);
            }
            rest = &rest[end..];
        }
        let key = nals.iter().any(|nal| kind(nal) == NalKind::KeySlice);
        let has_parameter_sets = nals.iter().any(|nal| kind(nal) == NalKind::Sps);
        let mut bytes = Vec::with_capacity(sample.len() + 4 * nals.len() + self.parameter_sets.len());
        // An access unit delimiter must stay the first NAL unit.
        let is_delimiter = |nal: &&&[u8]| unit_type(nal) == Some(UnitType::AccessUnitDelimiter);
        let delimiters = nals.iter().take_while(is_delimiter).count();
        for nal in &nals[..delimiters] {
            push_nal(&mut bytes, nal);
        }
        if key && !has_parameter_sets {
            bytes.extend_from_slice(&self.parameter_sets);
        }
        for nal in &nals[delimiters..] {
            push_nal(&mut bytes, nal);
        }
        Ok(AnnexBUnit { bytes, key })
    }
}

/// Appends a NAL unit behind a start code.
pub fn push_nal(unit: &mut Vec<u8>, nal: &[u8]) {
    unit.extend_from_slice(&START_CODE);
    unit.extend_from_slice(nal);
}

/// An access unit, and whether decoding can begin with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AnnexBUnit {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Whether it is a key picture.
    pub key: bool,
}

/// A length in a sample reaches past the end of the sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MalformedSample;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_codes_of_three_and_four_bytes_part_nal_units() {
        let unit = [0, 0, 0, 1, 0x67, 5, 0, 0, 1, 0x68, 6, 0, 0, 0, 1, 0x65, 7, 0, 0];
        let found: Vec<_> = nals(&unit).collect();
        assert_eq!(found, [&[0x67, 5][..], &[0x68, 6], &[0x65, 7]]);
        assert_eq!(kind(found[0]), NalKind::Sps);
        assert_eq!(kind(found[2]), NalKind::KeySlice);
    }

    #[test]
    fn bytes_without_a_start_code_hold_no_nal_unit() {
        for bytes in [&[][..], &[0], &[0, 0], &[0, 0, 1], &[1, 2, 3, 4, 5]] {
            assert_eq!(nals(bytes).count(), 0, "{bytes:?}");
        }
    }

    #[test]
    fn the_slice_type_tells_a_bidirectional_slice() {
        // first_mb_in_slice = 0 is "1"; slice_type 1 (B) is "010", 6 (B) "00111", 0 (P) "1", 7 (I) "0001000".
        assert!(is_bidirectional(&[0x01, 0b1010_0000]));
        assert!(is_bidirectional(&[0x01, 0b1001_1100]));
        assert!(!is_bidirectional(&[0x41, 0b1100_0000]));
        assert!(!is_bidirectional(&[0x65, 0b1000_1000]));
        assert!(!is_bidirectional(&[0x65]));
        // first_mb_in_slice = 7 is "0001000": the slice type, 6 ("00111"), reaches into the second byte.
        assert!(is_bidirectional(&[0x01, 0b0001_0000, 0b0111_0000]));
    }

    #[test]
    fn a_damaged_slice_header_is_not_bidirectional() {
        // Cut short; only zeros; more leading zeros than any value has; a forbidden run of zeros.
        for slice in
            [&[][..], &[0x01], &[0x01, 0], &[0x01, 0, 0, 3, 0, 0, 3, 0, 0], &[0x41, 0, 0, 0, 0, 1, 2]]
        {
            assert!(!is_bidirectional(slice), "{slice:?}");
        }
    }

    #[test]
    fn a_key_slice_is_told_from_others() {
        assert!(lacks_key_slice(&[0, 0, 1, 0x67, 5, 0, 0, 1, 0x41, 6]));
        assert!(!lacks_key_slice(&[0, 0, 1, 0x41, 6, 0, 0, 1, 0x65, 6]));
        assert!(!lacks_key_slice(&[0, 0, 1, 0x67, 5, 0, 0, 1, 0x68, 6]));
    }

    #[test]
    fn a_recovery_point_is_found_among_sei_messages() {
        // A message of type 5 and 2 bytes, then type 6 and 1 byte, then the trailing bits.
        assert!(has_recovery_point(&[0, 0, 1, 6, 5, 2, 9, 9, 6, 1, 0xc4, 0x80]));
        assert!(!has_recovery_point(&[0, 0, 1, 6, 5, 2, 6, 1, 0x80]));
        assert!(!has_recovery_point(&[0, 0, 1, 6, 0xff, 6, 1, 6]));
        assert!(!has_recovery_point(&[0, 0, 1, 6, 5, 0xff, 0xff, 0xff]));
        assert!(!has_recovery_point(&[0, 0, 1, 0x41, 6, 1, 0xc4]));
    }

    #[test]
    fn an_empty_parameter_set_is_no_panic() {
        let avc = AvcConfiguration::parse(&[1, 66, 0, 10, 0xff, 0xe1, 0, 0, 1, 0, 0]).unwrap();
        assert_eq!(nals(&avc.parameter_sets).count(), 0);
    }

    const AVCC: [u8; 14] = [1, 66, 0, 10, 0xff, 0xe1, 0, 2, 0x67, 9, 1, 0, 1, 0x68];

    #[test]
    fn a_key_sample_gets_the_parameter_sets_in_front() {
        let avc = AvcConfiguration::parse(&AVCC).unwrap();
        assert_eq!(avc.length_size, 4);
        let unit = avc.to_annex_b(&[0, 0, 0, 2, 0x65, 1]).unwrap();
        assert!(unit.key);
        let kinds: Vec<_> = nals(&unit.bytes).map(kind).collect();
        assert_eq!(kinds, [NalKind::Sps, NalKind::Pps, NalKind::KeySlice]);
        let unit = avc.to_annex_b(&[0, 0, 0, 2, 0x41, 1]).unwrap();
        assert!(!unit.key);
        assert_eq!(unit.bytes, [0, 0, 0, 1, 0x41, 1]);
    }

    #[test]
    fn lengths_that_do_not_add_up_are_an_error() {
        let avc = AvcConfiguration::parse(&AVCC).unwrap();
        for sample in [&[0, 0, 0, 9, 1][..], &[0, 0], &[255, 255, 255, 255, 0]] {
            assert_eq!(avc.to_annex_b(sample), Err(MalformedSample), "{sample:?}");
        }
        for cut in 0..AVCC.len() {
            assert_eq!(AvcConfiguration::parse(&AVCC[..cut]), None, "cut at {cut}");
        }
    }
}
