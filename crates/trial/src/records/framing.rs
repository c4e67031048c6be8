//! Holds the lengths of the records in a chunk against the chunk's own, before the container's reader sees them: it
//! trusts them, and a damaged length would take it past the chunk's end.

use std::io::{self, Read};

/// A record's opcode and length.
const RECORD_HEAD: usize = 1 + 8;
/// A chunk's fields before its records, without the name of its compression: two times, the size and the checksum of
/// the records, the length of the name, and the records' length as they are stored.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;
const CHUNK_NAME_LENGTH: usize = 28;
const CHUNK_RECORDS_LENGTH: usize = 32;
const CHUNK: u8 = 0x06;
const MAGIC: u64 = 8;

/// Hands on the bytes of an MCAP file, and fails where a record reaches beyond the chunk that it is in.
pub(super) struct Framed<R> {
    input: R,
    /// How many of the following bytes do not matter.
    pass: u64,
    place: Place,
    head: Vec<u8>,
}

#[derive(Clone, Copy)]
enum Place {
    Record,
    Chunk { length: u64 },
    Records { left: u64, padding: u64 },
}

impl<R> Framed<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, pass: MAGIC, place: Place::Record, head: Vec::with_capacity(CHUNK_HEAD) }
    }

    fn follow(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        loop {
            if let Place::Records { left: 0, padding } = self.place {
                self.pass += padding;
                self.place = Place::Record;
            }
            let passed = bytes.len().min(usize::try_from(self.pass).unwrap_or(usize::MAX));
            self.pass -= passed as u64;
            bytes = &bytes[passed..];
            let needed = match self.place {
                Place::Chunk { .. } => CHUNK_HEAD,
                Place::Record | Place::Records { .. } => RECORD_HEAD,
            };
            let taken = bytes.len().min(needed - self.head.len());
            self.head.extend_from_slice(&bytes[..taken]);
            bytes = &bytes[taken..];
            if self.head.len() < needed {
                return Ok(());
            }
            self.enter()?;
            self.head.clear();
        }
    }

    fn enter(&mut self) -> io::Result<()> {
        match self.place {
            Place::Record => {
                let length = number(&self.head[1..RECORD_HEAD]);
                match self.head[0] {
                    CHUNK => self.place = Place::Chunk { length },
                    _ => self.pass = length,
                }
            }
            Place::Chunk { length } => {
                let rest = length.saturating_sub(CHUNK_HEAD as u64);
                let stored_as_they_are = number(&self.head[CHUNK_NAME_LENGTH..CHUNK_RECORDS_LENGTH]) == 0;
                if stored_as_they_are {
                    let left = number(&self.head[CHUNK_RECORDS_LENGTH..]);
                    self.place = Place::Records { left, padding: rest.saturating_sub(left) };
                } else {
                    self.pass = rest;
                    self.place = Place::Record;
                }
            }
            Place::Records { left, padding } => {
                let length = number(&self.head[1..RECORD_HEAD]);
                let left = length
                    .checked_add(RECORD_HEAD as u64)
                    .and_then(|whole| left.checked_sub(whole))
                    .ok_or_else(|| {
                    io::Error::new(
                        io::ErrorKind::InvalidData,
                        "a record reaches beyond the chunk that it is in",
                    )
                })?;
                self.pass = length;
                self.place = Place::Records { left, padding };
            }
        }
        Ok(())
    }
}

impl<R: Read> Read for Framed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.follow(&buffer[..read])?;
        Ok(read)
    }
}

/// A number as it is stored: its lowest byte first.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}
