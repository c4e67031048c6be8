//! Jumps of the tracked position: steps from one row to the next that cannot be the target's motion.

use barrelman_trial::logs::TrialLog;

/// A step longer than this is a jump, pixels.
const MAX_STEP_PX: f64 = 25.0;

/// Whether the position jumped from the row before to this row; false for the first row.
pub(super) fn is_jump(log: &TrialLog, row: usize) -> bool {
    row > 0 && step_px(log, row) > MAX_STEP_PX
}

/// Distance of a row's position from that of the row before, pixels; 0 where one of them is missing.
fn step_px(log: &TrialLog, row: usize) -> f64 {
    match (log.rows[row - 1].position, log.rows[row].position) {
        (Some(before), Some(now)) => (now.x - before.x).hypot(now.y - before.y),
        _ => 0.0,
    }
}
