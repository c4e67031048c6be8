//! Open-loop evaluation of a camera law on the recorded positions of a log.
//!
//! The law receives the recorded positions row by row; its commands have no effect on the positions that
//! follow. The result can be compared with the recorded commands; it does not show how well the law would
//! have held the target. A law with a camera model assumes that the camera followed the law's own commands.

use barrelman_control::{CameraLaw, LawInput, LawSettings, Percept, Region};
use barrelman_vocab::{CameraCommand, ImagePoint, Timestamp, VehicleProfile, VehicleRates};

use crate::logs::TrialLog;

/// The command of the law at one row of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawRow {
    /// Index of the row in the log, from 0.
    pub row: usize,
    /// Seconds since the log's first row.
    pub time_s: f64,
    /// Position of the target and P there; `None` while the track was lost.
    pub target: Option<(ImagePoint, f64)>,
    /// The commanded rates, in the vehicle's own signs. Zero without a target.
    pub rates: VehicleRates,
}

/// Evaluates a law for a vehicle on the positions of a log. The recorded commands are not used.
pub fn run_open_loop(
    log: &TrialLog,
    region: Region,
    profile: &VehicleProfile,
    settings: LawSettings,
) -> Vec<LawRow> {
    let mut law = CameraLaw::new(settings, profile);
    let rows = log.rows.iter().enumerate();
    rows.map(|(row, at)| {
        let percept = at.position.map(|position| Percept::new(position, region));
        let now = Timestamp::from_secs_f64(at.time_s);
        let command = percept.map_or(CameraCommand::REST, |percept| {
            law.command(&LawInput::measured(&percept, region, log.frame, now, now))
        });
        law.on_command_applied(command, now);
        let rates = profile.to_vehicle(command);
        let target = percept.map(|percept| (percept.position, percept.p));
        LawRow { row, time_s: at.time_s, target, rates }
    })
    .collect()
}
