//! Suspension of the machine: the monotonic clock stands still meanwhile, the boot clock does not.

use std::time::Duration;

use rustix::time::ClockId;

/// Growth of the boot clock over the monotonic clock that counts as a suspension. The two are read one after
/// the other.
const LEAST_GAP: Duration = Duration::from_millis(100);

/// Detects suspensions of the machine.
#[derive(Debug, Clone, Copy)]
pub struct SuspendWatch {
    /// The boot clock minus the monotonic clock.
    offset: Duration,
}

impl SuspendWatch {
    /// A watch that counts from now.
    pub fn start() -> Self {
        Self { offset: offset() }
    }

    /// How long the machine was suspended since the last call, if it was.
    pub fn check(&mut self) -> Option<Duration> {
        self.gap_to(offset())
    }

    fn gap_to(&mut self, offset: Duration) -> Option<Duration> {
        let gap = offset.saturating_sub(self.offset);
        (gap >= LEAST_GAP).then(|| {
            self.offset = offset;
            gap
        })
    }
}

fn offset() -> Duration {
    // Monotonic first: a pause between the two reads makes the gap longer, never negative.
    let monotonic = read(ClockId::Monotonic);
    read(ClockId::Boottime).saturating_sub(monotonic)
}

fn read(clock: ClockId) -> Duration {
    let now = rustix::time::clock_gettime(clock);
    // Both count from the machine's start, so neither part is negative.
    Duration::new(now.tv_sec as u64, now.tv_nsec as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_suspension_is_told_once() {
        let mut watch = SuspendWatch { offset: Duration::from_secs(100) };
        let ms = |ms: u64| Duration::from_millis(100_000 + ms);
        assert_eq!(watch.gap_to(ms(50)), None);
        assert_eq!(watch.gap_to(ms(3_000)), Some(Duration::from_secs(3)));
        assert_eq!(watch.gap_to(ms(3_000)), None);
    }

    #[test]
    fn a_machine_that_runs_is_not_suspended() {
        assert_eq!(SuspendWatch::start().check(), None);
    }
}
