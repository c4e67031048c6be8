//! The motion of the simulated axes in the place of the commands, so that the figures of commands can be
//! computed for it.

use barrelman_trial::logs::TrialLog;
use barrelman_vocab::{AngularRate, CameraCommand};

/// An axis that turns more slowly counts as resting, rad/s.
const MIN_RATE: f64 = 0.01;

/// The log of a trial whose commands are the rates that the axes achieved.
pub(super) fn as_commands(log: &TrialLog) -> TrialLog {
    let mut achieved = log.clone();
    let rate =
        |rate: f64| AngularRate::from_radians_per_second(if rate.abs() < MIN_RATE { 0.0 } else { rate });
    for (row, truth) in achieved.rows.iter_mut().zip(log.truth.iter().flatten()) {
        row.command = truth.achieved_rates.map(|(pan, tilt)| CameraCommand::turning(rate(pan), rate(tilt)));
    }
    achieved
}
