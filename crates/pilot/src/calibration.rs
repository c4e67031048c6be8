//! The test motions of a calibration: each axis turns to and fro at the low rate, with rests between.
//!
//! ```text
//!   rate  +r      +----+              +----+                     axis after axis, pan first
//!          0  ----+    +---+    +-----+    +---+    +---- ...
//!         -r               +----+              +----+
//!             lead  move rest move rest    second time ... fifth time
//! ```
//! The motions are the same whatever the picture shows. What they do to the picture is measured by
//! `barrelman-experiments`, from the recorded frames and commands.

use core::time::Duration;

use barrelman_vocab::{AngularRate, CameraCommand, Timestamp};

use crate::safety::NUDGE_RATE_RAD_PER_S;

/// Rest before the first motion.
const LEAD: Duration = Duration::from_millis(1000);
/// Time of a motion to one side.
pub const MOVE: Duration = Duration::from_millis(2500);
/// Rest after each motion: longer than dead time and lag of any known camera.
pub const REST: Duration = Duration::from_millis(2000);
/// How often each axis turns to and fro.
pub const REPETITIONS: u32 = 5;

/// A calibration in progress.
#[derive(Debug, Clone, Copy)]
pub struct Calibration {
    begun: Timestamp,
}

impl Calibration {
    /// A calibration that begins now.
    pub const fn new(now: Timestamp) -> Self {
        Self { begun: now }
    }

    /// The command at a time. `None`: all motions have been made.
    pub fn command(&self, now: Timestamp) -> Option<CameraCommand> {
        let Some(since) = now.since(self.begun).checked_sub(LEAD) else { return Some(CameraCommand::REST) };
        let part = MOVE + REST;
        let index = u32::try_from(since.as_nanos() / part.as_nanos()).unwrap_or(u32::MAX);
        let moves = since.as_nanos() % part.as_nanos() < MOVE.as_nanos();
        if index >= 4 * REPETITIONS {
            return None;
        }
        let size = if moves { NUDGE_RATE_RAD_PER_S } else { 0.0 };
        let rate = AngularRate::from_radians_per_second(if index.is_multiple_of(2) { size } else { -size });
        Some(if index < 2 * REPETITIONS {
            CameraCommand { pan: rate, tilt: AngularRate::ZERO }
        } else {
            CameraCommand { pan: AngularRate::ZERO, tilt: rate }
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
        let calibration = Calibration::new(begun);
        let (mut pan, mut tilt, mut widest, mut ms) = (0.0, 0.0, 0.0_f64, 0);
        while let Some(command) = calibration.command(begun.plus(Duration::from_millis(ms))) {
            assert!(command.pan.is_zero() || command.tilt.is_zero(), "one axis at a time");
            pan += 0.01 * command.pan.radians_per_second();
            tilt += 0.01 * command.tilt.radians_per_second();
            widest = widest.max(f64::abs(pan)).max(f64::abs(tilt));
            ms += 10;
        }
        assert!(pan.abs() < 1e-9 && tilt.abs() < 1e-9, "{pan} {tilt}");
        assert!((0.24..0.26).contains(&widest), "{widest}");
        assert!(Duration::from_millis(ms) < CALIBRATION_CONSENT, "{ms}");
    }
}
