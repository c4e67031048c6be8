//! Bounds of what one client may send and keep open.

use std::time::Duration;

use barrelman_vocab::Timestamp;

/// Longest text message and request body, bytes.
pub(super) const MAX_MESSAGE_BYTES: usize = 4096;
/// Largest number of connections at a time.
pub(super) const MAX_CONNECTIONS: usize = 64;
/// Largest number of connections of one address at a time: enough for the largest number of pages, with some left for others.
pub(super) const MAX_CONNECTIONS_OF_ADDRESS: usize = 48;
/// How long the head of a request may take.
pub(super) const HEADER_TIMEOUT: Duration = Duration::from_secs(5);
/// How long the body of a request may take after its head.
pub(super) const BODY_TIMEOUT: Duration = Duration::from_secs(5);
/// A page that sent nothing for this long is dropped.
pub(super) const IDLE_TIMEOUT: Duration = Duration::from_secs(10);
/// A client that takes nothing of what is sent to it for this long is dropped.
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

    /// A flood of one message every `interval_ms`, of which this share passes in the long run.
    #[track_caller]
    fn check(interval_ms: u64, passed: f64) {
        const MESSAGES: u64 = 20_000;
        let mut limit = RateLimit::new(Timestamp::ZERO);
        let permits = (1..=MESSAGES)
            .filter(|index| limit.permits(Timestamp::from_nanos(index * interval_ms * 1_000_000)))
            .count() as f64;
        let expected = (passed * MESSAGES as f64 + BURST).min(MESSAGES as f64);
        assert!((permits - expected).abs() <= 1.0, "every {interval_ms} ms: {permits} of {expected}");
    }

    #[test]
    fn two_hundred_messages_a_second_pass_for_ever() {
        check(1, 0.2);
        check(2, 0.4);
        check(4, 0.8);
        check(5, 1.0);
        check(20, 1.0);
    }

    #[test]
    fn silence_saves_no_more_than_one_burst() {
        let day = Timestamp::from_secs_f64(86_400.0);
        let mut limit = RateLimit::new(Timestamp::ZERO);
        assert_eq!((0..1000).filter(|_| limit.permits(day)).count(), BURST as usize);
    }

    #[test]
    fn a_clock_that_stands_still_or_goes_back_gives_no_permits() {
        let mut limit = RateLimit::new(Timestamp::from_secs_f64(10.0));
        let permits = (0..1000).filter(|_| limit.permits(Timestamp::from_secs_f64(9.0))).count();
        assert_eq!(permits, BURST as usize);
    }
}
