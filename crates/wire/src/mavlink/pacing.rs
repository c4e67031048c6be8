//! Pacing: when rates are sent.
//!
//! One message carries both axes. A gimbal manager may keep a rate for ever, or let it expire within a
//! fraction of a second, and a packet may get lost: rates in force are repeated at 10 Hz, and zeros, sent at
//! once and three times, every 0.25 s. What stops or reverses an axis is sent at once, other changes at the
//! earliest 50 ms after the message before. (With 100 ms, the boat is outside of the region 1.4 times as long
//! as with a Fotokite Pro; with 50 ms, 1.1 times.)

use core::time::Duration;

use barrelman_vocab::{Timestamp, VehicleRates};

/// Interval between a zero and its repetition, and least interval between two messages with rates.
pub const SPACING: Duration = Duration::from_millis(50);
/// Number of repetitions of a zero.
pub const ZERO_REPEATS: u8 = 2;
/// Rates in force are repeated after this time.
pub const REFRESH: Duration = Duration::from_millis(100);
/// Zeros in force are repeated after this time.
pub const ZERO_REFRESH: Duration = Duration::from_millis(250);

/// The target rates, and what was sent of them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pacing {
    target: VehicleRates,
    /// The rates that were sent last, and when.
    last: Option<(VehicleRates, Timestamp)>,
    /// Number of pending repetitions of a zero.
    repeats_left: u8,
    has_moved: bool,
}

impl Pacing {
    /// Sets the target rates. Rates that were not sent yet are dropped.
    pub const fn set_rates(&mut self, rates: VehicleRates) {
        self.target = rates;
    }

    /// Forgets what was sent: zeros are sent before any rate.
    pub const fn begin_with_zeros(&mut self) {
        self.last = None;
    }

    /// The rates that are due now.
    pub fn due(&mut self, now: Timestamp) -> Option<VehicleRates> {
        if now < self.wake_at() {
            return None;
        }
        let rates = if self.last.is_none() { VehicleRates::REST } else { self.target };
        let is_repetition = self.last.is_some_and(|(last, _)| last == rates);
        self.repeats_left = match (rates.is_rest(), is_repetition) {
            (false, _) => 0,
            (true, false) => ZERO_REPEATS,
            (true, true) => self.repeats_left.saturating_sub(1),
        };
        self.has_moved = match rates.is_rest() {
            true => self.has_moved && self.repeats_left > 0,
            false => true,
        };
        self.last = Some((rates, now));
        Some(rates)
    }

    /// When the next message is due.
    pub fn wake_at(&self) -> Timestamp {
        let Some((last, at)) = self.last else { return Timestamp::ZERO };
        if last != self.target {
            let is_urgent =
                last.parts().into_iter().zip(self.target.parts()).any(|(last, target)| stops(last, target));
            return if is_urgent { Timestamp::ZERO } else { at.plus(SPACING) };
        }
        at.plus(match (self.repeats_left, last.is_rest()) {
            (0, true) => ZERO_REFRESH,
            (0, false) => REFRESH,
            _ => SPACING,
        })
    }

    /// Whether rates other than zero were sent last, or a zero that was not repeated yet.
    pub const fn may_be_turning(&self) -> bool {
        self.has_moved
    }
}

/// Whether an axis that moves at the rate `last` is to stop, or to move the other way.
fn stops(last: f64, target: f64) -> bool {
    last * target < 0.0 || target == 0.0 && last != 0.0
}
