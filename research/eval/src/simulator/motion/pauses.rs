//! When the target stands still: pauses on its way, and the time at its end.

use super::velocities::{ImageVelocity, VelocitySample};

/// The least duration of a pause, seconds.
const MIN_PAUSE_S: f64 = 0.4;

/// A time in which the target stands still, seconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pause {
    pub(super) start_s: f64,
    pub(super) end_s: f64,
}

impl Pause {
    pub(super) fn duration_s(self) -> f64 {
        self.end_s - self.start_s
    }
}

/// The pauses between setting off and the last motion, and how long the target stands after that, seconds.
pub(super) fn find_pauses(velocities: &[VelocitySample], set_off_s: f64) -> (Vec<Pause>, f64) {
    let is_moving = |sample: &VelocitySample| sample.velocity.is_some_and(ImageVelocity::is_moving);
    let start_s = velocities.first().map_or(0.0, |sample| sample.time_s);
    let end_s = velocities.last().map_or(0.0, |sample| sample.time_s);
    let first = velocities.partition_point(|sample| sample.time_s < start_s + set_off_s);
    let last = velocities.iter().rposition(is_moving).unwrap_or(0);
    let mut pauses = Vec::new();
    let mut since: Option<f64> = None;
    for sample in velocities.get(first..=last).unwrap_or_default() {
        match (sample.velocity, since) {
            (Some(_), None) if !is_moving(sample) => since = Some(sample.time_s),
            (Some(_), Some(start_s)) if is_moving(sample) => {
                pauses.push(Pause { start_s, end_s: sample.time_s });
                since = None;
            }
            (None, _) => since = None,
            _ => {}
        }
    }
    pauses.retain(|pause| pause.duration_s() >= MIN_PAUSE_S);
    (pauses, velocities.get(last).map_or(0.0, |sample| end_s - sample.time_s))
}
