//! Estimates the time of capture of a picture from its RTP time (RFC 3550) and its time of arrival.
//!
//! RTP time counts ticks of the sender's clock from an unknown start, modulo 2^32. A picture with RTP time r (seconds,
//! unwrapped) that arrives at a has the offset a - r: clock difference plus latency. The latency varies and is never
//! negative. So the smallest offset of the last 30 s is the clock difference plus the smallest latency, and r plus this
//! offset estimates the time of capture. The estimate is late by the smallest latency, which the stream does not tell;
//! the vehicle profile's nominal video latency accounts for it.
//!
//! A sender report (RTCP) does not wait for an encoder. Its offset is often smaller than that of any picture and improves
//! the estimate. A report that is off by more than a second is ignored.
//!
//! A jump of the sender's clock (backwards by more than reordered pictures explain, or forwards faster than time passed)
//! resets the estimate. Until enough pictures have arrived, the capture quality is that of an arrival.

use std::collections::VecDeque;
use std::time::Duration;

use barrelman_vocab::time::Timestamp;
use barrelman_vocab::video::{Capture, CaptureQuality};

/// Window of the smallest offset, seconds: long against bursts of the network, short against the drift of quartz clocks
/// (50 ppm: 1.5 ms in 30 s).
const WINDOW_S: u64 = 30;

/// Largest step backwards that reordered pictures explain, and largest step forwards beyond the time passed that the
/// network explains.
const MAX_STEP_NS: i128 = 1_000_000_000;

/// Number of pictures from which on the smallest offset is used.
const MIN_PICTURES: u32 = 8;

/// Maps the RTP times of one connection to the program's clock.
#[derive(Debug, Clone)]
pub(super) struct RtpClock {
    ticks_per_second: u32,
    last: Option<LastPicture>,
    /// Smallest offset of each second of arrival, in nanoseconds, oldest first.
    smallest: VecDeque<(u64, i128)>,
    pictures: u32,
}

#[derive(Debug, Clone, Copy)]
struct LastPicture {
    /// RTP time, unwrapped.
    ticks: i64,
    arrival: Timestamp,
}

impl RtpClock {
    /// A clock without a picture.
    pub(super) const fn new(ticks_per_second: u32) -> Self {
        Self { ticks_per_second, last: None, smallest: VecDeque::new(), pictures: 0 }
    }

    /// The time of capture of the picture with this RTP time, which arrived at `arrival`.
    pub(super) fn capture(&mut self, rtp: u32, arrival: Timestamp) -> Capture {
        let ticks = self.unwrap(rtp);
        if self.has_jumped(ticks, arrival) {
            *self = Self::new(self.ticks_per_second);
        }
        self.last = Some(LastPicture { ticks, arrival });
        self.pictures = self.pictures.saturating_add(1);
        let sent_ns = self.nanos(ticks);
        self.record_offset(i128::from(arrival.as_nanos()) - sent_ns, arrival);
        if self.pictures < MIN_PICTURES {
            return Capture { at: arrival, quality: CaptureQuality::Arrival };
        }
        let offset = self.smallest_offset().unwrap_or_default();
        let at = Timestamp::from_nanos(u64::try_from(sent_ns + offset).unwrap_or(0)).min(arrival);
        Capture { at, quality: CaptureQuality::Sender }
    }

    /// Processes a sender report with this RTP time.
    pub(super) fn on_sender_report(&mut self, rtp: u32, arrival: Timestamp) {
        let Some(known) = self.smallest_offset() else { return };
        let offset = i128::from(arrival.as_nanos()) - self.nanos(self.unwrap(rtp));
        if (known - MAX_STEP_NS..known).contains(&offset) {
            self.record_offset(offset, arrival);
        }
    }

    /// The tick with the low 32 bits `rtp` that is nearest to the last tick.
    fn unwrap(&self, rtp: u32) -> i64 {
        let Some(last) = self.last else { return i64::from(rtp) };
        let step = rtp.wrapping_sub(last.ticks as u32) as i32;
        last.ticks.saturating_add(i64::from(step))
    }

    fn nanos(&self, ticks: i64) -> i128 {
        i128::from(ticks) * 1_000_000_000 / i128::from(self.ticks_per_second.max(1))
    }

    fn has_jumped(&self, ticks: i64, arrival: Timestamp) -> bool {
        let Some(last) = self.last else { return false };
        let step = self.nanos(ticks) - self.nanos(last.ticks);
        let passed = i128::from(nanos_of(arrival.since(last.arrival)));
        step < -MAX_STEP_NS || step > passed + MAX_STEP_NS
    }

    fn record_offset(&mut self, offset: i128, arrival: Timestamp) {
        let second = arrival.as_nanos() / 1_000_000_000;
        match self.smallest.back_mut() {
            Some((newest, smallest)) if *newest == second => *smallest = offset.min(*smallest),
            _ => self.smallest.push_back((second, offset)),
        }
        while self.smallest.front().is_some_and(|(oldest, _)| oldest + WINDOW_S < second) {
            self.smallest.pop_front();
        }
    }

    fn smallest_offset(&self) -> Option<i128> {
        self.smallest.iter().map(|(_, offset)| *offset).min()
    }
}

fn nanos_of(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: u32 = 90_000;

    fn ms(millis: u64) -> Timestamp {
        Timestamp::from_nanos(millis * 1_000_000)
    }

    /// Pictures each 40 ms from RTP time `first` on, sent at 1000 ms and later, each so many ms late.
    fn run(clock: &mut RtpClock, first: u32, latencies: &[u64]) -> Vec<Capture> {
        let picture = |(n, latency): (usize, &u64)| {
            let rtp = first.wrapping_add(n as u32 * 3600);
            clock.capture(rtp, ms(1000 + 40 * n as u64 + latency))
        };
        latencies.iter().enumerate().map(picture).collect()
    }

    #[test]
    fn a_late_picture_was_taken_when_the_quickest_one_says() {
        let mut clock = RtpClock::new(RATE);
        let captures = run(&mut clock, 12_345, &[5, 9, 5, 7, 30, 6, 12, 5, 80, 33]);
        assert_eq!(captures[0], Capture { at: ms(1005), quality: CaptureQuality::Arrival });
        assert_eq!(captures[8], Capture { at: ms(1000 + 320 + 5), quality: CaptureQuality::Sender });
        assert_eq!(captures[9].at, ms(1000 + 360 + 5));
    }

    #[test]
    fn the_counter_may_wrap() {
        let mut clock = RtpClock::new(RATE);
        let captures = run(&mut clock, u32::MAX - 20_000, &[5; 12]);
        for (n, capture) in captures.iter().enumerate() {
            assert_eq!(capture.at, ms(1005 + 40 * n as u64), "picture {n}");
        }
    }

    #[test]
    fn what_was_quick_long_ago_is_forgotten() {
        let mut clock = RtpClock::new(RATE);
        // One quick picture, then 40 s of slow ones: as when the sender's clock drifts.
        let latencies: Vec<_> = std::iter::once(1).chain(std::iter::repeat_n(21, 1000)).collect();
        let captures = run(&mut clock, 0, &latencies);
        assert_eq!(captures[500].at, ms(1000 + 500 * 40 + 1));
        assert_eq!(captures[1000].at, ms(1000 + 1000 * 40 + 21));
    }

    #[test]
    fn a_jump_of_the_senders_clock_begins_anew() {
        for jump in [-20_i32, 20] {
            let mut clock = RtpClock::new(RATE);
            run(&mut clock, 10_000_000, &[5; 10]);
            let jumped = 10_000_000_u32.wrapping_add_signed(jump * RATE as i32);
            let capture = clock.capture(jumped.wrapping_add(36_000), ms(1405));
            assert_eq!(capture, Capture { at: ms(1405), quality: CaptureQuality::Arrival }, "{jump} s");
        }
    }

    #[test]
    fn a_burst_after_a_stall_keeps_its_times_of_capture() {
        let mut clock = RtpClock::new(RATE);
        run(&mut clock, 0, &[5; 10]);
        // The next picture, of 1400 ms, is 3 s late.
        assert_eq!(clock.capture(36_000, ms(4400)).at, ms(1405));
    }

    #[test]
    fn reordered_pictures_are_no_jump() {
        let mut clock = RtpClock::new(RATE);
        run(&mut clock, 100_000, &[5; 10]);
        assert_eq!(clock.capture(100_000 + 12 * 3600, ms(1485)).at, ms(1485));
        assert_eq!(clock.capture(100_000 + 11 * 3600, ms(1490)).at, ms(1445));
    }

    #[test]
    fn a_sender_report_brings_the_time_nearer_to_the_sensor() {
        let mut clock = RtpClock::new(RATE);
        run(&mut clock, 0, &[50; 10]);
        clock.on_sender_report(35_100, ms(1391));
        assert_eq!(clock.capture(36_000, ms(1450)).at, ms(1401));
    }

    #[test]
    fn a_sender_report_that_makes_no_sense_is_not_believed() {
        let mut clock = RtpClock::new(RATE);
        run(&mut clock, 0, &[50; 10]);
        clock.on_sender_report(35_100 + 5 * RATE, ms(1391));
        clock.on_sender_report(0, ms(9000));
        assert_eq!(clock.capture(36_000, ms(1450)).at, ms(1450));
    }
}
