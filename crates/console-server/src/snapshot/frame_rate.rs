//! The rate of video frames over the last seconds.

use std::collections::VecDeque;
use std::time::Duration;

use barrelman_vocab::Timestamp;

/// The time over which the frame rate is measured.
const WINDOW: Duration = Duration::from_secs(2);
/// Below this time since the first frame the rate is 0, s.
const MIN_MEASURED_S: f64 = 0.2;

/// Measures the rate of video frames.
#[derive(Debug, Default)]
pub(super) struct FrameRate {
    first: Option<Timestamp>,
    frames: VecDeque<Timestamp>,
}

impl FrameRate {
    /// A frame was processed.
    pub(super) fn add(&mut self, now: Timestamp) {
        self.first.get_or_insert(now);
        self.frames.push_back(now);
        self.forget_before(now);
    }

    /// Frames a second at `now`.
    pub(super) fn per_second(&mut self, now: Timestamp) -> f64 {
        self.forget_before(now);
        let measured_s = self.first.map_or(0.0, |first| now.since(first).min(WINDOW).as_secs_f64());
        if measured_s > MIN_MEASURED_S { self.frames.len() as f64 / measured_s } else { 0.0 }
    }

    fn forget_before(&mut self, now: Timestamp) {
        while self.frames.front().is_some_and(|at| now.since(*at) > WINDOW) {
            self.frames.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::at;

    /// After frames every `interval_ms` until `last_ms`, the rate at `now_ms` is this one.
    #[track_caller]
    fn check(interval_ms: usize, last_ms: u64, now_ms: u64, expected: f64) {
        let mut rate = FrameRate::default();
        for ms in (0..=last_ms).step_by(interval_ms) {
            rate.add(at(ms));
        }
        let got = rate.per_second(at(now_ms));
        // A window of two seconds may hold one frame more: half a frame a second.
        assert!((got - expected).abs() <= 0.5, "every {interval_ms} ms until {last_ms}, at {now_ms}: {got}");
    }

    #[test]
    fn the_rate_is_that_of_the_last_two_seconds() {
        check(40, 10_000, 10_000, 25.0);
        check(20, 60_000, 60_000, 50.0);
        check(1000, 60_000, 60_000, 1.0);
        check(40, 10_000, 11_000, 12.5);
        check(40, 10_000, 12_001, 0.0);
        check(40, 10_000, 99_000, 0.0);
    }

    #[test]
    fn the_rate_is_not_guessed_from_the_first_frames() {
        assert_eq!(FrameRate::default().per_second(at(5000)), 0.0);
        check(40, 0, 0, 0.0);
        check(40, 200, 200, 0.0);
        // 11 frames in 0.4 s: the frame at the beginning counts.
        let mut rate = FrameRate::default();
        (0..=10).for_each(|index| rate.add(at(40 * index)));
        assert_eq!(rate.per_second(at(400)), 27.5);
    }
}
