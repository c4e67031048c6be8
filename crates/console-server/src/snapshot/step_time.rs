//! The time that the loop takes for a video frame.

use std::collections::VecDeque;
use std::time::Duration;

/// Number of frames over which the median is taken: two seconds at 30 frames a second.
const FRAMES: usize = 60;

/// Measures the time for a video frame.
#[derive(Debug, Default)]
pub(super) struct StepTime {
    newest: VecDeque<Duration>,
    sorted: Vec<Duration>,
}

impl StepTime {
    /// A frame took this long.
    pub(super) fn add(&mut self, taken: Duration) {
        if self.newest.len() >= FRAMES {
            self.newest.pop_front();
        }
        self.newest.push_back(taken);
    }

    /// The median of the last frames.
    pub(super) fn median(&mut self) -> Option<Duration> {
        self.sorted.clear();
        self.sorted.extend(&self.newest);
        self.sorted.sort_unstable();
        self.sorted.get(self.sorted.len() / 2).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_that_of_the_last_sixty_frames() {
        let mut time = StepTime::default();
        assert_eq!(time.median(), None);
        for ms in [900, 1, 2, 3] {
            time.add(Duration::from_millis(ms));
        }
        assert_eq!(time.median(), Some(Duration::from_millis(3)));
        (0..60).for_each(|_| time.add(Duration::from_millis(7)));
        assert_eq!(time.median(), Some(Duration::from_millis(7)));
    }
}
