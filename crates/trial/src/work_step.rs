//! A step of a run, as far as the camera's work goes.

use barrelman_control::{Percept, Region};
use barrelman_pilot::{Mode, Outcome};
use barrelman_vocab::{CameraCommand, Timestamp, Track};

/// What a step says of the camera's work.
#[derive(Debug, Clone, Copy)]
pub struct WorkStep<'a> {
    /// Time of the step.
    pub at: Timestamp,
    /// Mode of the pilot.
    pub mode: Mode,
    /// Command in force from the step on.
    pub command: CameraCommand,
    /// The track.
    pub track: &'a Track,
    /// Percept of the newest localisation.
    pub percept: Option<Percept>,
    /// The region; `None` before the first picture.
    pub region: Option<Region>,
}

impl<'a> From<&'a Outcome> for WorkStep<'a> {
    fn from(outcome: &'a Outcome) -> Self {
        let Outcome { at, mode, command, ref track, percept, region, .. } = *outcome;
        Self { at, mode, command, track, percept, region }
    }
}
