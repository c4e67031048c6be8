//! A short text from outside of the program.

use core::fmt;

/// Printable ASCII, at most [`ShortText::MAX_BYTES`]. What is not becomes a question mark; what finds no room
/// is left out.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ShortText {
    length: u8,
    bytes: [u8; Self::MAX_BYTES],
}

impl ShortText {
    /// Longest text, bytes.
    pub const MAX_BYTES: usize = 120;
    /// The empty text.
    pub const EMPTY: Self = Self { length: 0, bytes: [0; Self::MAX_BYTES] };

    /// A text of these bytes.
    pub fn of(text: &[u8]) -> Self {
        let mut made = Self::EMPTY;
        made.push(text);
        made
    }

    /// Appends bytes.
    pub fn push(&mut self, text: &[u8]) {
        for byte in text {
            let Some(place) = self.bytes.get_mut(usize::from(self.length)) else { return };
            *place = if (b' '..=b'~').contains(byte) { *byte } else { b'?' };
            self.length += 1;
        }
    }

    /// Whether there is no room for more.
    pub const fn is_full(&self) -> bool {
        self.length as usize == Self::MAX_BYTES
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl fmt::Debug for ShortText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl fmt::Display for ShortText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
