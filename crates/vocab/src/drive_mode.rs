//! The mode of a boat's autopilot.

use core::fmt;

/// A mode by the number that ArduPilot Rover gives it.
///
/// ```
/// use barrelman_vocab::drive_mode::DriveMode;
///
/// assert_eq!(DriveMode(11).to_string(), "RTL");
/// assert_eq!(DriveMode(99).to_string(), "mode 99");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DriveMode(pub u32);

impl DriveMode {
    /// The name; `None`: a number that this program does not know.
    pub const fn name(self) -> Option<&'static str> {
        Some(match self.0 {
            0 => "MANUAL",
            1 => "ACRO",
            3 => "STEERING",
            4 => "HOLD",
            5 => "LOITER",
            6 => "FOLLOW",
            7 => "SIMPLE",
            8 => "DOCK",
            9 => "CIRCLE",
            10 => "AUTO",
            11 => "RTL",
            12 => "SMART_RTL",
            15 => "GUIDED",
            16 => "INITIALISING",
            _ => return None,
        })
    }
}

impl fmt::Display for DriveMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "mode {}", self.0),
        }
    }
}
