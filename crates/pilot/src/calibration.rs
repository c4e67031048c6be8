//! The test motions of a calibration: each axis turns to and fro at the low rate, with rests between.
//!
//! ```text
//!   rate  +r      +----+              +----+                     axis after axis, pan first
//!          0  ----+    +---+    +-----+    +---+    +---- ...
//!         -r               +----+              +----+
//!             lead  move rest move rest    second time ...
//! ```
//! The motions are the same whatever the picture shows. What they do to the picture is measured by
//! `barrelman-experiments`, from the recorded frames and commands.

use core::time::Duration;

use barrelman_vocab::{AngularRate, CameraCommand, TestMotions, Timestamp};

use crate::safety::NUDGE_RATE_RAD_PER_S;

/// Rest before the first motion.
const LEAD: Duration = Duration::from_millis(1000);

/// The times of test motions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    /// Time of a motion to one side.
    pub moves: Duration,
    /// Rest after each motion.
    pub rests: Duration,
    /// How often each axis turns to and fro.
    pub repetitions: u32,
}

impl Schedule {
    /// The times of these motions. The long ones rest for longer than dead time and lag of any known camera.
    pub const fn of(motions: TestMotions) -> Self {
        match motions {
            TestMotions::Axes => Self {
                moves: Duration::from_millis(2500),
                rests: Duration::from_millis(2000),
                repetitions: 5,
            },
            TestMotions::Speed => Self {
                moves: Duration::from_millis(2000),
                rests: Duration::from_millis(1500),
                repetitions: 3,
            },
        }
    }

    /// Time of a motion with its rest.
    pub fn part(&self) -> Duration {
        self.moves + self.rests
    }
}

/// A calibration in progress.
#[derive(Debug, Clone, Copy)]
pub struct Calibration {
    schedule: Schedule,
    begun: Timestamp,
}

impl Calibration {
    /// A calibration that begins now.
    pub const fn new(motions: TestMotions, now: Timestamp) -> Self {
        Self { schedule: Schedule::of(motions), begun: now }
    }

    /// The command at a time. `None`: all motions have been made.
    pub fn command(&self, now: Timestamp) -> Option<CameraCommand> {
        let Some(since) = now.since(self.begun).checked_sub(LEAD) else { return Some(CameraCommand::REST) };
        let (part, moves, repetitions) =
            (self.schedule.part().as_nanos(), self.schedule.moves.as_nanos(), self.schedule.repetitions);
        let index = u32::try_from(since.as_nanos() / part).unwrap_or(u32::MAX);
        if index >= 4 * repetitions {
            return None;
        }
        let size = if since.as_nanos() % part < moves { NUDGE_RATE_RAD_PER_S } else { 0.0 };
        let rate = AngularRate::from_radians_per_second(if index.is_multiple_of(2) { size } else { -size });
        Some(if index < 2 * repetitions {
            CameraCommand::turning(rate, AngularRate::ZERO)
        } else {
            CameraCommand::turning(AngularRate::ZERO, rate)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::licence::CALIBRATION_CONSENT;

    #[test]
    fn each_axis_comes_back_to_where_it_was_within_the_consent() {
        let begun = Timestamp::from_secs_f64(5.0);
        for (motions, expected) in [(TestMotions::Axes, 0.25), (TestMotions::Speed, 0.2)] {
            let calibration = Calibration::new(motions, begun);
            let (mut pan, mut tilt, mut widest, mut ms) = (0.0, 0.0, 0.0_f64, 0);
            while let Some(command) = calibration.command(begun.plus(Duration::from_millis(ms))) {
                assert!(command.pan.is_zero() || command.tilt.is_zero(), "one axis at a time");
                pan += 0.01 * command.pan.radians_per_second();
                tilt += 0.01 * command.tilt.radians_per_second();
                widest = widest.max(f64::abs(pan)).max(f64::abs(tilt));
                ms += 10;
            }
            assert!(pan.abs() < 1e-9 && tilt.abs() < 1e-9, "{pan} {tilt}");
            assert!((widest - expected).abs() < 0.01, "{widest}");
            assert!(Duration::from_millis(ms) < CALIBRATION_CONSENT, "{ms}");
        }
    }
}
