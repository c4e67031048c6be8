//! How often a moving target changes its direction, and by how much over a pause.

use super::bearings::BearingSample;
use super::pauses::Pause;
use super::summary::mean;
use super::velocities::VelocitySample;

/// A change of direction by more than this within a second counts, degrees.
const MIN_CHANGE_DEG: f64 = 50.0;
/// A pause is at a turn where the directions before and after it differ by more than this, degrees. They are
/// those of the displacements within this time before and after the pause, seconds, of at least this length,
/// pixels.
const MIN_TURN_DEG: f64 = 60.0;
const TURN_S: f64 = 1.2;
const MIN_TURN_PX: f64 = 8.0;

/// The changes of direction of a trial.
pub(super) struct DirectionChanges {
    pub(super) count: f64,
    /// Mean speed in the middle of the changes, pixels per second.
    pub(super) mean_speed: f64,
}

impl DirectionChanges {
    pub(super) fn from_velocities(velocities: &[VelocitySample]) -> Self {
        let (mut speed, mut speeds) = (0.0, 0_usize);
        let mut count = 0;
        let mut was_change = false;
        let mut later = 0;
        for VelocitySample { time_s, velocity } in velocities {
            while later + 1 < velocities.len() && velocities[later].time_s < time_s + 1.0 {
                later += 1;
            }
            let is_change = match (velocity, velocities[later].velocity) {
                (Some(now), Some(then)) if now.is_moving() && then.is_moving() => {
                    angle_deg((now.across, now.vertical), (then.across, then.vertical)) > MIN_CHANGE_DEG
                }
                _ => false,
            };
            count += usize::from(is_change && !was_change);
            let middle = velocities.partition_point(|sample| sample.time_s < time_s + 0.5);
            if is_change && let Some(velocity) = velocities.get(middle).and_then(|sample| sample.velocity) {
                speed += velocity.speed();
                speeds += 1;
            }
            was_change = is_change;
        }
        Self { count: count as f64, mean_speed: speed / speeds.max(1) as f64 }
    }
}

/// The share of pauses at a turn, of those with a direction before and after; 0 where there is none.
pub(super) fn share_of_pauses_at_turns(samples: &[BearingSample], focal_px: f64, pauses: &[Pause]) -> f64 {
    let turns: Vec<f64> = pauses.iter().filter_map(|pause| turn_deg(samples, focal_px, *pause)).collect();
    mean(turns.iter().map(|turn_deg| f64::from(*turn_deg > MIN_TURN_DEG)))
}

/// The angle between the directions before and after a pause, degrees; `None` where the target hardly moved.
fn turn_deg(samples: &[BearingSample], focal_px: f64, pause: Pause) -> Option<f64> {
    let at = |time_s: f64| samples.get(samples.partition_point(|sample| sample.time_s < time_s));
    let displacement = |from: &BearingSample, to: &BearingSample| {
        let across = focal_px * (to.azimuth - from.azimuth) * to.depression.cos();
        let vertical = focal_px * (to.depression - from.depression);
        (across.hypot(vertical) >= MIN_TURN_PX).then_some((across, vertical))
    };
    let before = displacement(at(pause.start_s - TURN_S)?, at(pause.start_s)?)?;
    let after = displacement(at(pause.end_s)?, at(pause.end_s + TURN_S)?)?;
    Some(angle_deg(before, after))
}

/// The angle between two directions, 0 to 180 degrees.
fn angle_deg(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1).abs().to_degrees()
}
