//! Checks the lengths of the records in a chunk against the length of the chunk, ahead of the MCAP reader, which trusts
//! them: a damaged length would make it read beyond the chunk's end. Attachments, which no recording of ours has and whose
//! lengths the MCAP reader trusts too, are passed on as records of a private kind, which the MCAP reader ignores.

use std::io::{self, Read};

/// Bytes of a record's opcode and length.
const RECORD_HEAD: usize = 1 + 8;
/// Bytes of a chunk's fields before its records, without the name of the compression: two times, size and checksum of the
/// records, length of the name, stored length of the records.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;
/// Offset of the length of the compression's name in a chunk's fields, bytes.
const CHUNK_NAME_LENGTH: usize = 28;
/// Offset of the records' stored length, bytes.
const CHUNK_RECORDS_LENGTH: usize = 32;
/// Opcode of a chunk.
const CHUNK: u8 = 0x06;
/// Opcode of an attachment.
const ATTACHMENT: u8 = 0x09;
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
    /// The bytes of the next head that have been read so far.
    head: Vec<u8>,
}

/// What the next head belongs to.
#[derive(Clone, Copy)]
enum State {
    /// A record outside of chunks.
    Record,
    /// The fields of a chunk of this length.
    Chunk { length: u64 },
    /// A record in a chunk: bytes left of the chunk's records, and bytes after them up to the chunk's end.
    InChunk { left: u64, padding: u64 },
}

impl<R> CheckedLengths<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, skip: MAGIC, state: State::Record, head: Vec::with_capacity(CHUNK_HEAD) }
    }

    fn check(&mut self, mut bytes: &mut [u8]) -> io::Result<()> {
        loop {
            if let State::InChunk { left: 0, padding } = self.state {
                self.skip += padding;
                self.state = State::Record;
            }
            let skipped = bytes.len().min(usize::try_from(self.skip).unwrap_or(usize::MAX));
            self.skip -= skipped as u64;
            bytes = &mut bytes[skipped..];
            if self.head.is_empty()
                && matches!(self.state, State::Record)
                && let Some(opcode @ &mut ATTACHMENT) = bytes.first_mut()
            {
                *opcode = PRIVATE;
            }
            let needed = match self.state {
                State::Chunk { .. } => CHUNK_HEAD,
                State::Record | State::InChunk { .. } => RECORD_HEAD,
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
            State::Record => {
                let length = little_endian(&self.head[1..RECORD_HEAD]);
                match self.head[0] {
                    CHUNK => self.state = State::Chunk { length },
                    _ => self.skip = length,
                }
            }
            State::Chunk { length } => {
                let rest = length.saturating_sub(CHUNK_HEAD as u64);
                let is_uncompressed = little_endian(&self.head[CHUNK_NAME_LENGTH..CHUNK_RECORDS_LENGTH]) == 0;
                if is_uncompressed {
                    let left = little_endian(&self.head[CHUNK_RECORDS_LENGTH..]);
                    self.state = State::InChunk { left, padding: rest.saturating_sub(left) };
                } else {
                    self.skip = rest;
                    self.state = State::Record;
                }
            }
            State::InChunk { left, padding } => {
                let length = little_endian(&self.head[1..RECORD_HEAD]);
                let left = length
                    .checked_add(RECORD_HEAD as u64)
                    .and_then(|whole| left.checked_sub(whole))
                    .ok_or_else(|| {
                    io::Error::new(io::ErrorKind::InvalidData, "a record reaches beyond its chunk")
                })?;
                self.skip = length;
                self.state = State::InChunk { left, padding };
            }
        }
        Ok(())
    }
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
