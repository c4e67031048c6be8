//! Checks lengths ahead of the MCAP reader, which trusts them: those of the records in a chunk, as a damaged
//! one would make it read beyond the chunk's end, and those of the texts in a record, for which it takes
//! memory before it reads, up to 4 GiB each. Records that no table and no replay needs (attachments, indices,
//! metadata) are passed on as records of a private kind, which the MCAP reader ignores.

use std::io::{self, Read};

/// Longest accepted record, bytes: more than a raw picture of 7680 x 4320 needs. Bounds the memory that a
/// damaged length can allocate.
pub(super) const MAX_RECORD_BYTES: usize = 64 << 20;
/// Bytes of a record's opcode and length.
const RECORD_HEAD: usize = 1 + 8;
/// Bytes of a chunk's fields before its records, without the name of the compression: two times, size and
/// checksum of the records, length of the name, stored length of the records.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;
/// Offset of the length of the compression's name in a chunk's fields, bytes.
const CHUNK_NAME_LENGTH: usize = 28;
/// Offset of the records' stored length, bytes.
const CHUNK_RECORDS_LENGTH: usize = 32;
/// Opcodes of the header, a schema, a channel and a chunk.
const HEADER: u8 = 0x01;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const CHUNK: u8 = 0x06;
/// Opcodes of records that are not needed: index of a chunk, attachment and its index, metadata and their
/// index.
const NOT_NEEDED: [u8; 5] = [0x08, 0x09, 0x0a, 0x0c, 0x0d];
/// Bytes of a schema and of a channel before their texts; a header begins with texts.
const SCHEMA_NUMBERS: usize = 2;
const CHANNEL_NUMBERS: usize = 4;
/// The first opcode for private use.
const PRIVATE: u8 = 0x80;
/// Bytes of the magic number at the beginning of a file.
const MAGIC: u64 = 8;

/// Passes on the bytes of an MCAP file; fails where a record reaches beyond its chunk.
pub(super) struct CheckedLengths<R> {
    input: R,
    /// Number of following bytes that need no check.
    skip: u64,
    state: State,
    /// The bytes of the next head, or of the next record with texts, that have been read so far.
    head: Vec<u8>,
}

/// Where a record is.
#[derive(Clone, Copy)]
enum Place {
    /// Outside of chunks.
    File,
    /// In a chunk: bytes left of the chunk's records, and bytes after them up to the chunk's end.
    Chunk { left: u64, padding: u64 },
}

/// What the next head belongs to.
#[derive(Clone, Copy)]
enum State {
    /// A record.
    Record(Place),
    /// The fields of a chunk of this length.
    Chunk { length: u64 },
    /// The content of a record with texts, and the place of the record after it.
    Texts { opcode: u8, length: usize, then: Place },
}

impl<R> CheckedLengths<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, skip: MAGIC, state: State::Record(Place::File), head: Vec::with_capacity(CHUNK_HEAD) }
    }

    fn check(&mut self, mut bytes: &mut [u8]) -> io::Result<()> {
        loop {
            if let State::Record(Place::Chunk { left: 0, padding }) = self.state {
                self.skip += padding;
                self.state = State::Record(Place::File);
            }
            let skipped = bytes.len().min(usize::try_from(self.skip).unwrap_or(usize::MAX));
            self.skip -= skipped as u64;
            bytes = &mut bytes[skipped..];
            if self.head.is_empty()
                && matches!(self.state, State::Record(_))
                && let Some(opcode) = bytes.first_mut().filter(|opcode| NOT_NEEDED.contains(opcode))
            {
                *opcode = PRIVATE;
            }
            let needed = match self.state {
                State::Chunk { .. } => CHUNK_HEAD,
                State::Record(_) => RECORD_HEAD,
                State::Texts { length, .. } => length,
            };
            let taken = bytes.len().min(needed - self.head.len());
            self.head.extend_from_slice(&bytes[..taken]);
            bytes = &mut bytes[taken..];
            if self.head.len() < needed {
                return Ok(());
            }
            self.interpret_head()?;
            self.head.clear();
        }
    }

    fn interpret_head(&mut self) -> io::Result<()> {
        match self.state {
            State::Record(place) => self.begin_record(place)?,
            State::Chunk { length } => {
                let rest = length.saturating_sub(CHUNK_HEAD as u64);
                let name_length = little_endian(&self.head[CHUNK_NAME_LENGTH..CHUNK_RECORDS_LENGTH]);
                if name_length > rest {
                    return Err(damaged("a text reaches beyond its record"));
                }
                if name_length == 0 {
                    let left = little_endian(&self.head[CHUNK_RECORDS_LENGTH..]);
                    let padding = rest.saturating_sub(left);
                    self.state = State::Record(Place::Chunk { left, padding });
                } else {
                    self.skip = rest;
                    self.state = State::Record(Place::File);
                }
            }
            State::Texts { opcode, then, .. } => {
                if !texts_fit(opcode, &self.head) {
                    return Err(damaged("a text reaches beyond its record"));
                }
                self.state = State::Record(then);
            }
        }
        Ok(())
    }

    fn begin_record(&mut self, place: Place) -> io::Result<()> {
        let (opcode, length) = (self.head[0], little_endian(&self.head[1..RECORD_HEAD]));
        let then = match place {
            Place::File => Place::File,
            Place::Chunk { left, padding } => {
                let left = length
                    .checked_add(RECORD_HEAD as u64)
                    .and_then(|whole| left.checked_sub(whole))
                    .ok_or_else(|| damaged("a record reaches beyond its chunk"))?;
                Place::Chunk { left, padding }
            }
        };
        self.state = State::Record(then);
        match opcode {
            CHUNK if matches!(place, Place::File) => self.state = State::Chunk { length },
            CHUNK => return Err(damaged("a chunk lies in a chunk")),
            // The MCAP reader refuses longer records.
            HEADER | SCHEMA | CHANNEL if length <= MAX_RECORD_BYTES as u64 => {
                self.state = State::Texts { opcode, length: length as usize, then };
            }
            _ => self.skip = length,
        }
        Ok(())
    }
}

fn damaged(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// Whether the texts of a header, a schema or a channel lie within the record.
fn texts_fit(opcode: u8, record: &[u8]) -> bool {
    let before = match opcode {
        SCHEMA => SCHEMA_NUMBERS,
        CHANNEL => CHANNEL_NUMBERS,
        _ => 0,
    };
    let texts = record.get(before..);
    let Some(rest) = texts.and_then(after_text).and_then(after_text) else { return false };
    if opcode != CHANNEL {
        return true;
    }
    // A table of pairs of texts; its length counts bytes.
    let Some(mut pairs) = text(rest) else { return false };
    while !pairs.is_empty() {
        let Some(rest) = after_text(pairs).and_then(after_text) else { return false };
        pairs = rest;
    }
    true
}

/// The bytes of the text at the front.
fn text(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_at_checked(4)?;
    rest.get(..usize::try_from(little_endian(length)).ok()?)
}

/// The bytes after the text at the front.
fn after_text(bytes: &[u8]) -> Option<&[u8]> {
    Some(&bytes[4 + text(bytes)?.len()..])
}

impl<R: Read> Read for CheckedLengths<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.check(&mut buffer[..read])?;
        Ok(read)
    }
}

/// The number that these bytes encode, least significant byte first.
fn little_endian(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}
