//! When a share that failed is started again, and what the log says of it: each failure once.

use std::time::Duration;

/// Shortest and longest pause before the next start.
const PAUSES: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(30));
/// A share that has served for so long begins with the shortest pause again.
const SOUND: Duration = Duration::from_secs(60);

/// The failures so far.
#[derive(Debug)]
pub(super) struct Failures {
    pause: Duration,
    told: Option<String>,
}

impl Failures {
    pub(super) const fn new() -> Self {
        Self { pause: PAUSES.0, told: None }
    }

    /// A share has ended after it served for so long. Returns the pause before the next one, and whether the
    /// reason is new.
    pub(super) fn on_end(&mut self, served: Duration, reason: &str) -> (Duration, bool) {
        if served >= SOUND {
            *self = Self::new();
        }
        let pause = self.pause;
        self.pause = (pause * 2).min(PAUSES.1);
        let is_new = self.told.as_deref() != Some(reason);
        self.told = Some(reason.to_owned());
        (pause, is_new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_and_a_reason_is_told_once() {
        let mut failures = Failures::new();
        let ends: Vec<_> = (0..9).map(|_| failures.on_end(Duration::ZERO, "killed")).collect();
        let pauses: Vec<_> = ends.iter().map(|(pause, _)| pause.as_millis()).collect();
        assert_eq!(pauses, [250, 500, 1000, 2000, 4000, 8000, 16_000, 30_000, 30_000]);
        assert_eq!(ends.iter().filter(|(_, is_new)| *is_new).count(), 1);
        assert!(failures.on_end(Duration::ZERO, "another").1);
        assert_eq!(failures.on_end(SOUND, "another"), (PAUSES.0, true));
    }
}
