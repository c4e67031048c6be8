//! Reads the boxes of MP4 and QuickTime files (ISO/IEC 14496-12, 4.2): a length, a type of four letters,
//! content.
//!
//! Every read is checked against the end of the data: a damaged file gives `None`.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// The type of a box: four letters.
pub(super) type BoxKind = [u8; 4];

/// Most boxes of the outermost level: two boxes for each fragment of a tenth of a second, for a day.
const MAX_BOXES: u32 = 2_000_000;

/// A box of the outermost level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TopLevelBox {
    pub(super) kind: BoxKind,
    /// Offset of the box in the file.
    pub(super) start: u64,
    /// Offset of its content.
    pub(super) content: u64,
    /// End of the box by its length, which may lie beyond the end of the file.
    pub(super) end: u64,
}

/// The boxes of an index on the outermost level (moov, moof), up to the end of the file, the first malformed
/// box, or the first [`MAX_BOXES`].
pub(super) fn top_level(file: &File, file_size: u64) -> io::Result<Vec<TopLevelBox>> {
    let mut boxes = Vec::new();
    let mut start = 0;
    for _ in 0..MAX_BOXES {
        if start + 8 > file_size {
            break;
        }
        let mut head = [0; 16];
        let available = (file_size - start).min(16) as usize;
        file.read_exact_at(&mut head[..available], start)?;
        let mut fields = Fields::new(&head[..available]);
        let Some((size, kind)) = fields.u32().zip(fields.kind()) else { break };
        let (header, size) = match size {
            0 => (8, file_size - start),
            1 => match fields.u64() {
                Some(size) => (16, size),
                None => break,
            },
            size => (8, u64::from(size)),
        };
        let Some(end) = start.checked_add(size).filter(|_| size >= header) else { break };
        if matches!(&kind, b"moov" | b"moof") {
            boxes.push(TopLevelBox { kind, start, content: start + header, end });
        }
        start = end;
    }
    Ok(boxes)
}

/// The boxes in a slice, with their content.
#[derive(Debug, Clone, Copy)]
pub(super) struct Boxes<'a> {
    rest: &'a [u8],
}

impl<'a> Boxes<'a> {
    pub(super) const fn new(content: &'a [u8]) -> Self {
        Self { rest: content }
    }

    /// The content of the first box of this type.
    pub(super) fn find(self, kind: &BoxKind) -> Option<&'a [u8]> {
        self.of_kind(kind).next()
    }

    /// The contents of all boxes of this type.
    pub(super) fn of_kind(self, kind: &BoxKind) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let kind = *kind;
        self.filter(move |(found, _)| *found == kind).map(|(_, content)| content)
    }

    /// The content of the box at the end of a path of nested boxes.
    pub(super) fn path(self, kinds: &[&BoxKind]) -> Option<&'a [u8]> {
        let (last, outer) = kinds.split_last()?;
        outer.iter().try_fold(self, |boxes, kind| boxes.find(kind).map(Boxes::new))?.find(last)
    }
}

impl<'a> Iterator for Boxes<'a> {
    type Item = (BoxKind, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let mut fields = Fields::new(self.rest);
        let size = fields.u32()?;
        let kind = fields.kind()?;
        let (header, size) = match size {
            0 => (8, self.rest.len()),
            1 => (16, usize::try_from(fields.u64()?).ok()?),
            size => (8, size as usize),
        };
        let content = self.rest.get(header..size)?;
        self.rest = &self.rest[size..];
        Some((kind, content))
    }
}

/// Reads consecutive numbers, big-endian.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a> {
    rest: &'a [u8],
}

impl<'a> Fields<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Version and flags of a full box, which precede its fields.
    pub(super) fn version_and_flags(&mut self) -> Option<(u8, u32)> {
        let both = self.u32()?;
        Some(((both >> 24) as u8, both & 0x00ff_ffff))
    }

    pub(super) fn skip(&mut self, bytes: usize) -> Option<()> {
        self.rest = self.rest.get(bytes..)?;
        Some(())
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*first)
    }

    pub(super) fn kind(&mut self) -> Option<BoxKind> {
        self.array()
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_be_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_be_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_be_bytes)
    }

    /// A number of 64 bits in version 1 of a box, of 32 bits in version 0.
    pub(super) fn wide(&mut self, version: u8) -> Option<u64> {
        if version == 1 { self.u64() } else { self.u32().map(u64::from) }
    }

    pub(super) const fn left(&self) -> usize {
        self.rest.len()
    }

    pub(super) const fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NESTED: [u8; 20] =
        [0, 0, 0, 20, b'm', b'o', b'o', b'v', 0, 0, 0, 12, b't', b'k', b'h', b'd', 1, 2, 3, 4];

    #[test]
    fn boxes_are_found_along_a_path() {
        assert_eq!(Boxes::new(&NESTED).path(&[b"moov", b"tkhd"]), Some(&[1, 2, 3, 4][..]));
        assert_eq!(Boxes::new(&NESTED).path(&[b"moov", b"trak"]), None);
    }

    #[test]
    fn a_box_that_is_cut_short_is_no_box() {
        for cut in 0..NESTED.len() {
            assert_eq!(Boxes::new(&NESTED[..cut]).count(), 0, "cut at {cut}");
        }
        assert_eq!(Boxes::new(&[0, 0, 0, 3, b'm', b'o', b'o', b'v']).count(), 0);
    }
}
