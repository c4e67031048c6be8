//! Bounds of what one client may send and keep open.

use std::time::Duration;

use barrelman_vocab::Timestamp;

/// Longest text message and request body, bytes.
pub(super) const MAX_MESSAGE_BYTES: usize = 4096;
/// Largest number of connections at a time that have shown a token.
pub(super) const MAX_CONNECTIONS: usize = 64;
/// Of these, those that may only watch: the others are for the operator.
pub(super) const MAX_CONNECTIONS_OF_WATCHERS: usize = 32;
/// Largest number of connections at a time that have shown no token. Each further one closes the oldest: so
/// many must come before the operator's first request is read, to keep the operator out.
pub(super) const MAX_STRANGERS: usize = 256;
/// Of these, those of one address.
pub(super) const MAX_STRANGERS_OF_ADDRESS: usize = 192;
/// How long a TLS handshake may take.
pub(super) const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(2);
/// How long the head of a request may take, and how long a connection may be idle between two requests.
pub(super) const HEADER_TIMEOUT: Duration = Duration::from_secs(2);
/// How long the body of a request may take after its head.
pub(super) const BODY_TIMEOUT: Duration = Duration::from_secs(2);
/// A page that sent nothing for this long is dropped.
pub(super) const IDLE_TIMEOUT: Duration = Duration::from_secs(10);
/// A client that takes nothing of what is sent to it for this long is dropped.
pub(super) const SEND_TIMEOUT: Duration = Duration::from_secs(10);
/// Most bytes that one connection reads before all others have their turn.
pub(super) const READ_BYTES: usize = 2048;
/// Frames of a page's socket: messages, parts of messages, pings and pongs.
pub(super) const FRAMES: Rate = Rate { per_second: 200.0, burst: 400.0 };
/// Requests over HTTP: of all connections with one token together, and of each connection without one.
pub(super) const REQUESTS: Rate = Rate { per_second: 200.0, burst: 400.0 };
/// What the opening of a socket counts as: it sends the event log.
pub(super) const SOCKET_REQUESTS: f64 = 10.0;
/// Bytes that one connection sends to the program: more than what its other limits permit.
pub(super) const BYTES: Rate = Rate { per_second: 1_048_576.0, burst: 2_097_152.0 };

/// How often something may happen: at once, and in the long run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rate {
    /// A second, in the long run.
    pub(super) per_second: f64,
    /// At once, after a silence.
    pub(super) burst: f64,
}

/// Bounds how often something happens: a bucket of permits that fills steadily.
#[derive(Debug)]
pub(super) struct RateLimit {
    rate: Rate,
    permits: f64,
    filled_at: Timestamp,
}

impl RateLimit {
    /// A full bucket.
    pub(super) const fn new(rate: Rate, now: Timestamp) -> Self {
        Self { rate, permits: rate.burst, filled_at: now }
    }

    /// Takes `count` permits. Returns whether there were as many; otherwise none is taken.
    pub(super) fn takes(&mut self, count: f64, now: Timestamp) -> bool {
        let elapsed_s = now.since(self.filled_at).as_secs_f64();
        self.permits = (self.permits + elapsed_s * self.rate.per_second).min(self.rate.burst);
        // A clock that goes back gives nothing twice.
        self.filled_at = self.filled_at.max(now);
        let is_permitted = self.permits >= count;
        if is_permitted {
            self.permits -= count;
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
        let mut limit = RateLimit::new(FRAMES, at(0));
        assert!((0..400).all(|_| limit.takes(1.0, at(0))));
        assert!(!limit.takes(1.0, at(0)));
        assert!(limit.takes(1.0, at(10)) && limit.takes(1.0, at(10)) && !limit.takes(1.0, at(10)));
    }

    /// A flood of one message every `interval_ms`, of which this share passes in the long run.
    #[track_caller]
    fn check(interval_ms: u64, passed: f64) {
        const MESSAGES: u64 = 20_000;
        let mut limit = RateLimit::new(FRAMES, Timestamp::ZERO);
        let permits = (1..=MESSAGES)
            .filter(|index| limit.takes(1.0, Timestamp::from_nanos(index * interval_ms * 1_000_000)))
            .count() as f64;
        let expected = (passed * MESSAGES as f64 + FRAMES.burst).min(MESSAGES as f64);
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
        let mut limit = RateLimit::new(FRAMES, Timestamp::ZERO);
        assert_eq!((0..1000).filter(|_| limit.takes(1.0, day)).count(), FRAMES.burst as usize);
    }

    #[test]
    fn a_clock_that_stands_still_or_goes_back_gives_no_permits() {
        let mut limit = RateLimit::new(FRAMES, Timestamp::from_secs_f64(10.0));
        let permits = (0..1000).filter(|_| limit.takes(1.0, Timestamp::from_secs_f64(9.0))).count();
        assert_eq!(permits, FRAMES.burst as usize);
    }
}
