//! Bounds of what one client may send and keep open.

use std::time::Duration;

use barrelman_vocab::Timestamp;

/// Longest text message and request body, bytes.
pub(super) const MAX_MESSAGE_BYTES: usize = 4096;
/// Largest number of connections at a time.
pub(super) const MAX_CONNECTIONS: usize = 64;
/// How long the head of a request may take.
pub(super) const HEADER_TIMEOUT: Duration = Duration::from_secs(5);
/// A page that sent nothing for this long is dropped.
pub(super) const IDLE_TIMEOUT: Duration = Duration::from_secs(10);
/// A page that does not take a message for this long is dropped.
pub(super) const SEND_TIMEOUT: Duration = Duration::from_secs(10);
/// Messages that a page may send at once, and a second.
const BURST: f64 = 400.0;
const PER_SECOND: f64 = 200.0;

/// Bounds the rate of messages: a bucket of permits that fills steadily.
#[derive(Debug)]
pub(super) struct RateLimit {
    permits: f64,
    filled_at: Timestamp,
}

impl RateLimit {
    /// A full bucket.
    pub(super) const fn new(now: Timestamp) -> Self {
        Self { permits: BURST, filled_at: now }
    }

    /// Whether a further message is within the limit.
    pub(super) fn permits(&mut self, now: Timestamp) -> bool {
        let elapsed_s = now.since(self.filled_at).as_secs_f64();
        self.permits = (self.permits + elapsed_s * PER_SECOND).min(BURST);
        self.filled_at = now;
        let is_permitted = self.permits >= 1.0;
        if is_permitted {
            self.permits -= 1.0;
        }
        is_permitted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_passes_and_a_flood_does_not() {
        let at = |ms: u64| Timestamp::from_nanos(ms * 1_000_000);
        let mut limit = RateLimit::new(at(0));
        assert!((0..400).all(|_| limit.permits(at(0))));
        assert!(!limit.permits(at(0)));
        assert!(limit.permits(at(10)) && limit.permits(at(10)) && !limit.permits(at(10)));
    }
}
