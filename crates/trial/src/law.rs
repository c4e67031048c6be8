//! Recorded positions through a camera law, open loop.
//!
//! The law sees where the target was, row by row, and says what it would have commanded. What it commands does
//! not move the recorded picture: it is a check of the law against the recorded commands, no proof of how well
//! it would have held the target. A law that imagines the camera imagines that it did what it was asked.

use barrelman_control::{CameraLaw, LawInput, LawSettings, Percept, Region};
use barrelman_vocab::{CameraCommand, ImagePoint, Timestamp, VehicleProfile, VehicleRates};

use crate::logs::TrialLog;

/// What the law asks for at one row of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawRow {
    /// Row of the log, from 0.
    pub row: usize,
    /// Seconds since the log's first row.
    pub time_s: f64,
    /// Where the target was, and P there; `None` while the track was lost.
    pub target: Option<(ImagePoint, f64)>,
    /// The rates asked for, in the vehicle's own signs. Zero without a target.
    pub rates: VehicleRates,
}

/// Puts the positions of a log through a law for a vehicle. The recorded commands are not looked at.
pub fn law_over(
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
            law.command(&LawInput {
                percept: &percept,
                region,
                picture: log.frame,
                captured: now,
                is_measured: true,
                now,
            })
        });
        law.on_command_applied(command, now);
        let rates = profile.to_vehicle(command);
        let target = percept.map(|percept| (percept.position, percept.p));
        LawRow { row, time_s: at.time_s, target, rates }
    })
    .collect()
}
