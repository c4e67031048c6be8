//! A message that the vehicle shall send: asked for while it does not come, and asked for again when it
//! stops.
//!
//! A message that comes is not asked for: another client may have set a shorter interval, which a request
//! would replace.

use core::time::Duration;

use barrelman_vocab::Timestamp;
use barrelman_vocab::mavlink::Address;
use mavlink::dialects::common::COMMAND_LONG_DATA;

use super::command_long::{request_message, set_interval};

/// Interval of the requests.
const ASK_SPACING: Duration = Duration::from_secs(1);
/// A message that was asked for so often in vain is asked for less often.
const PATIENCE: u32 = 10;
/// Interval of the requests then.
const SLOW_SPACING: Duration = Duration::from_secs(10);

/// What makes a vehicle send a message at its interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Means {
    /// One request: the vehicle repeats the message by itself.
    Interval,
    /// A request for each message.
    Requests,
}

/// A message with the interval at which it shall come.
#[derive(Debug, Clone, Copy)]
pub(super) struct Subscription {
    message: u32,
    means: Means,
    interval: Duration,
    heard_at: Option<Timestamp>,
    ask_at: Timestamp,
    asked: u32,
}

impl Subscription {
    /// A message that was not heard yet.
    pub(super) const fn new(message: u32, interval: Duration) -> Self {
        let (means, ask_at) = (Means::Interval, Timestamp::ZERO);
        Self { message, means, interval, heard_at: None, ask_at, asked: 0 }
    }

    /// A message that the vehicle sends on request alone.
    pub(super) const fn by_requests(message: u32, interval: Duration) -> Self {
        Self { means: Means::Requests, ..Self::new(message, interval) }
    }

    /// The message was heard.
    pub(super) fn on_heard(&mut self, now: Timestamp) {
        (self.heard_at, self.asked) = (Some(now), 0);
        self.ask_at = now.plus(ASK_SPACING);
    }

    /// The request to this component that is due.
    pub(super) fn due(&mut self, to: Address, now: Timestamp) -> Option<COMMAND_LONG_DATA> {
        let patience = match self.means {
            Means::Interval => ASK_SPACING.max(self.interval * 3),
            Means::Requests => self.interval,
        };
        let is_missing = self.heard_at.is_none_or(|at| now.since(at) >= patience);
        if !is_missing || now < self.ask_at {
            return None;
        }
        self.asked = self.asked.saturating_add(1);
        self.ask_at = now.plus(if self.asked < PATIENCE { ASK_SPACING } else { SLOW_SPACING });
        Some(match self.means {
            Means::Interval => set_interval(to, self.message, self.interval),
            Means::Requests => request_message(to, self.message),
        })
    }
}
