//! When the camera's state is asked for.

use core::time::Duration;

use barrelman_vocab::Timestamp;

/// Interval of the states.
pub const INTERVAL: Duration = Duration::from_millis(200);
/// The same while zeros are sent, until two states show rest.
pub const INTERVAL_STOPPING: Duration = Duration::from_millis(100);
/// The same of a camera that refuses to tell it: its answer still shows that it is there.
pub const INTERVAL_REFUSED: Duration = Duration::from_secs(1);

/// When the camera's state is asked for next.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    at: Timestamp,
    is_refused: bool,
}

impl Schedule {
    /// At once.
    pub const fn starting(now: Timestamp) -> Self {
        Self { at: now, is_refused: false }
    }

    /// Whether the camera has told its state, or refused to.
    pub const fn on_answer(&mut self, is_refused: bool) {
        self.is_refused = is_refused;
    }

    /// Whether it is due. The next one is due an interval later.
    pub fn take_due(&mut self, is_stopping: bool, now: Timestamp) -> bool {
        let interval = match (self.is_refused, is_stopping) {
            (true, _) => INTERVAL_REFUSED,
            (false, true) => INTERVAL_STOPPING,
            (false, false) => INTERVAL,
        };
        let is_due = self.at <= now;
        if is_due {
            self.at = now.plus(interval);
        }
        is_due
    }

    /// When the next one is due.
    pub const fn wake_at(&self) -> Timestamp {
        self.at
    }
}
