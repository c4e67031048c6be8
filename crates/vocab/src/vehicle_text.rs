//! What a vehicle says in words.

use core::fmt;

/// A text of a vehicle: printable ASCII, at most [`VehicleText::MAX_BYTES`].
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct VehicleText {
    severity: u8,
    length: u8,
    bytes: [u8; Self::MAX_BYTES],
}

impl VehicleText {
    /// Longest text, bytes. What is beyond is left out.
    pub const MAX_BYTES: usize = 120;
    /// Texts of this severity, and of a lower number, are warnings (MAVLink: warning).
    pub const WARNING: u8 = 4;

    /// A text that is empty. `severity`: MAVLink's, 0 (emergency) to 7 (debug).
    pub const fn new(severity: u8) -> Self {
        Self { severity, length: 0, bytes: [0; Self::MAX_BYTES] }
    }

    /// A text of these bytes.
    pub fn of(severity: u8, text: &[u8]) -> Self {
        let mut made = Self::new(severity);
        made.push(text);
        made
    }

    /// Appends bytes. What is not printable ASCII becomes a question mark; what finds no room is left out.
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

    /// MAVLink's severity, 0 (emergency) to 7 (debug).
    pub const fn severity(&self) -> u8 {
        self.severity
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl fmt::Debug for VehicleText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:?}", self.severity, self.as_str())
    }
}

impl fmt::Display for VehicleText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
