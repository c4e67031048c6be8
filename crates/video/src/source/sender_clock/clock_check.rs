//! Recognises a sender's clock that no quartz explains: a wrong rate or unit, a coarse resolution, jumps.
//!
//! A clock that is too slow looks like a delay that grows, which is the dangerous one of the two. So a slow
//! clock is recognised only if everything else is excluded: the rate is less than 0.9, the same from the
//! first picture on, on two connections in turn (a new connection drops a queue), the intervals of arrival do
//! not depend on the sizes of the pictures (on a saturated link they do), and sender reports do not confirm
//! the clock. It is taken back when the rate returns to 1.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use barrelman_vocab::time::Timestamp;

use super::picture_rate::{PictureRate, RATE_TOLERANCE, SizeCorrelation, Step};

/// Rates of clocks that are wrong. The gap to 1 keeps slowly growing delays apart.
const SLOW: f64 = 0.9;
const FAST: f64 = 1.1;
/// Segments of a steady rate that show a slow clock, on each of two connections, and a fast one.
const SLOW_SEGMENTS: u32 = 3;
const FAST_SEGMENTS: u32 = 5;
/// Segments of a rate near 1 that take a wrong rate back.
const CONTRARY_SEGMENTS: u32 = 3;
/// Largest delay of pictures that do not come out of a queue, which drains faster than time passes.
const MAX_UNQUEUED_NS: i128 = 50_000_000;
/// Of so many pictures in turn, so many with the time of the one before show a coarse resolution.
const BLOCK: u32 = 100;
const MAX_EQUAL: u32 = 20;
/// So many jumps within this time show a clock that jumps.
const JUMPS: usize = 3;
const JUMPS_WITHIN: Duration = Duration::from_secs(60);
/// Weight of a new value in the running means of the interval and of the jitter (RFC 3550, 6.4.1).
const JITTER_WEIGHT: f64 = 1.0 / 16.0;

/// What is wrong with a sender's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClockFault {
    /// The rate: seconds of the sender for each second.
    Rate(f64),
    /// Many pictures have the time of the one before.
    Resolution,
    /// The clock jumps again and again.
    Jumps,
}

// The rate is never NaN: a segment lasts a second or more.
impl Eq for ClockFault {}

impl fmt::Display for ClockFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rate(rate) => write!(f, "it runs at {:.0} % of true time", rate * 100.0),
            Self::Resolution => f.write_str("many pictures have the time of the picture before"),
            Self::Jumps => f.write_str("it jumps again and again"),
        }
    }
}

#[derive(Debug, Clone, Default)]
pub(super) struct ClockCheck {
    fault: Option<ClockFault>,
    /// Rate and sizes of this connection.
    rate: PictureRate,
    sizes: SizeCorrelation,
    last_bytes: usize,
    /// The rate of the connection before, where it was slow.
    slow_before: Option<f64>,
    contrary: u32,
    /// Whether sender reports show that the rate is right.
    is_confirmed: bool,
    /// Pictures of the block in progress, and those with an equal time.
    block: (u32, u32),
    jumps: VecDeque<Timestamp>,
    /// Running mean of the interval, and of its deviation, seconds.
    interval_s: Option<f64>,
    jitter_s: f64,
}

impl ClockCheck {
    pub(super) fn on_connected(&mut self) {
        self.slow_before = self.rate.steady(SLOW_SEGMENTS).filter(|rate| *rate < SLOW);
        (self.rate, self.sizes, self.last_bytes, self.block) = Default::default();
    }

    pub(super) const fn fault(&self) -> Option<ClockFault> {
        self.fault
    }

    /// The jitter of the times of arrival: the mean deviation of their intervals.
    pub(super) fn jitter(&self) -> Duration {
        Duration::from_secs_f64(self.jitter_s.clamp(0.0, 1.0))
    }

    /// Whether sender reports show that the rate is right.
    pub(super) fn set_confirmed(&mut self, is_confirmed: bool) {
        self.is_confirmed = is_confirmed;
        if is_confirmed {
            self.acquit();
        }
    }

    fn acquit(&mut self) {
        self.slow_before = None;
        if matches!(self.fault, Some(ClockFault::Rate(_))) {
            self.fault = None;
        }
    }

    /// Takes the step to a picture of this size and with this delay by the sender's clock.
    pub(super) fn observe(
        &mut self,
        step: Step,
        has_jumped: bool,
        delay_ns: i128,
        bytes: usize,
        arrival: Timestamp,
    ) {
        let interval_s = step.arrived_ns as f64 / 1e9;
        self.observe_interval(interval_s);
        match std::mem::replace(&mut self.last_bytes, bytes) {
            0 => {}
            last_bytes => self.sizes.observe(last_bytes, interval_s),
        }
        self.count_equal(step);
        if has_jumped {
            self.rate.drop_segment();
            return self.count_jump(arrival);
        }
        let Some(segment) = self.rate.observe(step) else { return };
        match self.fault {
            Some(ClockFault::Rate(rate)) => self.count_contrary(segment, rate),
            Some(ClockFault::Resolution | ClockFault::Jumps) => {}
            None if self.is_confirmed => {}
            None => self.judge_rate(delay_ns),
        }
    }

    fn judge_rate(&mut self, delay_ns: i128) {
        let slow = self.rate.steady(SLOW_SEGMENTS).filter(|rate| {
            let is_repeated = self.slow_before.is_some_and(|before| (before - rate).abs() <= RATE_TOLERANCE);
            *rate < SLOW && is_repeated && self.sizes.is_link_free()
        });
        let is_queued = delay_ns > MAX_UNQUEUED_NS;
        let fast = self.rate.steady(FAST_SEGMENTS).filter(|rate| *rate > FAST && !is_queued);
        self.fault = slow.or(fast).map(ClockFault::Rate);
        self.contrary = 0;
    }

    fn count_contrary(&mut self, segment: f64, rate: f64) {
        let is_contrary = (segment - 1.0).abs() < (rate - 1.0).abs() / 2.0;
        self.contrary = if is_contrary { self.contrary + 1 } else { 0 };
        if self.contrary >= CONTRARY_SEGMENTS {
            self.acquit();
        }
    }

    fn count_equal(&mut self, step: Step) {
        let (pictures, equal) = &mut self.block;
        *pictures += 1;
        *equal += u32::from(step.sent_ns == 0);
        if *equal >= MAX_EQUAL {
            self.fault.get_or_insert(ClockFault::Resolution);
        }
        if *pictures >= BLOCK {
            self.block = (0, 0);
        }
    }

    fn count_jump(&mut self, arrival: Timestamp) {
        self.jumps.push_back(arrival);
        while self.jumps.front().is_some_and(|first| arrival.since(*first) > JUMPS_WITHIN) {
            self.jumps.pop_front();
        }
        if self.jumps.len() >= JUMPS {
            self.jumps.clear();
            self.fault.get_or_insert(ClockFault::Jumps);
        }
    }

    fn observe_interval(&mut self, interval_s: f64) {
        let mean_s = self.interval_s.get_or_insert(interval_s);
        let deviation_s = (interval_s - *mean_s).abs();
        *mean_s += JITTER_WEIGHT * (interval_s - *mean_s);
        self.jitter_s += JITTER_WEIGHT * (deviation_s - self.jitter_s);
    }
}
