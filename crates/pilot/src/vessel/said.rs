//! What a boat says to commands, in words for the operator.

use barrelman_vocab::Named as _;
use core::fmt;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::drive_mode::DriveMode;

/// What a boat says to commands, with the mode that it is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Said {
    /// What it says.
    pub acceptance: Acceptance,
    /// Its mode, where it reports one.
    pub mode: Option<DriveMode>,
}

/// Why the boat takes no commands, and what to do: the armed state, the mode, or what its autopilot says.
impl fmt::Display for Said {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.acceptance, self.mode) {
            (Acceptance::OtherClient, Some(mode)) => write!(
                f,
                "the boat is in {mode}: its remote control or another program steers it; Go asks for the mode in which it is \
                 steered from here"
            ),
            (Acceptance::ModeRefused, Some(mode)) => {
                write!(f, "the boat is in {mode}: {}", Acceptance::ModeRefused.text())
            }
            (said, _) => write!(f, "the boat: {}", said.text()),
        }
    }
}
