//! The page that controls, as the console's server sees it: the times are those of `seats.rs` and `server.rs`
//! of the program.

use core::time::Duration;

use barrelman_vocab::Timestamp;

/// A page that commands a boat says so four times a second, ms.
pub(super) const SIGN_INTERVAL_MS: u64 = 250;
/// How long the page in control may be gone or silent before the boat is stopped.
const BOAT_SILENCE: Duration = Duration::from_millis(900);
/// Interval between two looks at the silence.
const CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// The page's signs of life.
#[derive(Debug, Clone, Copy)]
pub(super) struct Console {
    heard: Timestamp,
    checked: Timestamp,
    is_left: bool,
}

impl Console {
    pub(super) const fn new() -> Self {
        Self { heard: Timestamp::ZERO, checked: Timestamp::ZERO, is_left: true }
    }

    /// The page was heard.
    pub(super) const fn hear(&mut self, now: Timestamp) {
        self.heard = now;
    }

    /// The page commands the boat.
    pub(super) const fn commands_vessel(&mut self, now: Timestamp) {
        (self.heard, self.is_left) = (now, false);
    }

    /// Whether no page watches over the boat.
    pub(super) fn is_left(&mut self, now: Timestamp) -> bool {
        if now.since(self.checked) >= CHECK_INTERVAL {
            (self.checked, self.is_left) = (now, now.since(self.heard) > BOAT_SILENCE);
        }
        self.is_left
    }
}
