//! What a vehicle says in words.

use core::fmt;

use crate::short_text::ShortText;

/// A text of a vehicle.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct VehicleText {
    severity: u8,
    text: ShortText,
}

impl VehicleText {
    /// Texts of this severity, and of a lower number, are warnings (MAVLink: warning).
    pub const WARNING: u8 = 4;

    /// A text that is empty. `severity`: MAVLink's, 0 (emergency) to 7 (debug).
    pub const fn new(severity: u8) -> Self {
        Self { severity, text: ShortText::EMPTY }
    }

    /// A text of these bytes.
    pub fn of(severity: u8, text: &[u8]) -> Self {
        Self { severity, text: ShortText::of(text) }
    }

    /// Appends bytes.
    pub fn push(&mut self, text: &[u8]) {
        self.text.push(text);
    }

    /// Whether there is no room for more.
    pub const fn is_full(&self) -> bool {
        self.text.is_full()
    }

    /// MAVLink's severity, 0 (emergency) to 7 (debug).
    pub const fn severity(&self) -> u8 {
        self.severity
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        self.text.as_str()
    }
}

impl fmt::Debug for VehicleText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:?}", self.severity, self.text)
    }
}

impl fmt::Display for VehicleText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text.fmt(f)
    }
}
