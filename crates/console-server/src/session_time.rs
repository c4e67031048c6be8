//! The time of a session: the program's clock, or the time of a demo's world, which can be paused.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use barrelman_host::clock::Clock;
use barrelman_vocab::Timestamp;

/// The time of a session. Clones share it.
#[derive(Debug, Clone)]
pub struct SessionTime {
    clock: Clock,
    /// Time of the session less the program's clock, nanoseconds.
    offset_ns: Arc<AtomicI64>,
}

impl SessionTime {
    /// The time of the program's clock.
    pub fn new(clock: Clock) -> Self {
        Self { clock, offset_ns: Arc::default() }
    }

    /// Sets the time of the session.
    pub fn set(&self, session: Timestamp) {
        let offset = session.as_nanos() as i64 - self.clock.now().as_nanos() as i64;
        self.offset_ns.store(offset, Ordering::Relaxed);
    }

    /// The time of the session.
    pub(super) fn now(&self) -> Timestamp {
        let offset = self.offset_ns.load(Ordering::Relaxed);
        Timestamp::from_nanos(self.clock.now().as_nanos().saturating_add_signed(offset))
    }

    /// The time of the program's clock, which never stands still.
    pub(super) fn clock(&self) -> Timestamp {
        self.clock.now()
    }

    /// The time of day at a time of the session, such as "14:03:07.4"; `None`: the time is simulated.
    pub fn time_of_day(&self, at: Timestamp) -> Option<String> {
        if self.offset_ns.load(Ordering::Relaxed) != 0 {
            return None;
        }
        let ago = self.clock.now().since(at);
        let zoned = jiff::Zoned::now().checked_sub(ago).ok()?;
        Some(zoned.strftime("%H:%M:%S%.1f").to_string())
    }

    /// The program's clock.
    pub(super) const fn program_clock(&self) -> Clock {
        self.clock
    }
}
