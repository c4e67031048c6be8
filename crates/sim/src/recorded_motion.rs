//! The motion of platform and target over a trial, computed once for many trials that differ only in the camera.
//!
//! A swaying platform and a target on its path move the same whatever the camera does. The search of a law's values
//! tries thousands of laws on the same seeds; with the motion recorded, a trial takes a third of the time, and its log
//! is the same bit for bit.
//!
//! What must not be here: a kite, which pan turns, and a boat that can be steered.

use barrelman_vocab::Angle;

use crate::pose::{BodyPose, WorldPoint};
use crate::snapshot::SensorState;

/// The motion, tick by tick from the start of the trial to its end.
#[derive(Debug, Clone)]
pub struct RecordedMotion {
    ticks: Vec<MotionAtTick>,
}

/// Platform and target at one tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotionAtTick {
    /// Offset of the platform's attitude: yaw, pitch, roll.
    pub(crate) attitude: (Angle, Angle, Angle),
    /// Offset of the platform's position, metres.
    pub(crate) displacement: WorldPoint,
    /// The target.
    pub(crate) target: BodyPose,
    /// The camera's drifting gains.
    pub(crate) sensor: SensorState,
}

impl RecordedMotion {
    pub(crate) const fn new(ticks: Vec<MotionAtTick>) -> Self {
        Self { ticks }
    }

    /// The motion at a tick; beyond the end, that of the last tick. `None`: the trial had no tick.
    pub(crate) fn at(&self, tick: u64) -> Option<&MotionAtTick> {
        usize::try_from(tick).ok().and_then(|tick| self.ticks.get(tick)).or_else(|| self.ticks.last())
    }

    /// Whether the trial is over at a tick.
    pub(crate) fn is_over_at(&self, tick: u64) -> bool {
        tick + 1 >= self.ticks.len() as u64
    }
}
