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
