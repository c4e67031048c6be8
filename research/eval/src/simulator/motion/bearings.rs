//! The target's direction in the room at each row of a trial.

use std::collections::VecDeque;

use barrelman_sim::tick::TICK_S;
use barrelman_sim::{CameraMount, Scenario};
use barrelman_trial::logs::TrialLog;
use barrelman_vocab::{Angle, ImagePoint};

use crate::simulator::position_jump::is_jump;

/// Depression of the camera at the start, degrees, as identified.
const INITIAL_DEPRESSION_DEG: f64 = 24.0;
/// Two jumps within this time belong together: the positions between them are not the target's, seconds.
const MAX_JUMP_GAP_S: f64 = 1.5;
/// For this long before the first and after the last of several jumps the position is not the target's
/// either, seconds.
const JUMP_MARGIN_S: f64 = 0.25;
/// A position this close to the picture's border may be clamped, pixels.
const BORDER_PX: f64 = 4.0;

/// The target's direction at a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct BearingSample {
    pub(super) time_s: f64,
    /// To the right of the camera's first direction, radians.
    pub(super) azimuth: f64,
    /// Below the horizon, radians.
    pub(super) depression: f64,
    pub(super) is_valid: bool,
    /// Whether the position is at the picture's border, where it may be clamped.
    is_at_border: bool,
    /// Whether the position jumped from the row before.
    is_jump: bool,
}

/// The direction at each row that has a position. The plant is the scenario's nominal one.
///
/// Stretches without a valid position are interpolated linearly. Between jumps they stay invalid. Beyond the
/// border they become valid: the target crossed them at a speed whose mean is that of the interpolation.
pub(super) fn bearings(log: &TrialLog, scenario: &Scenario) -> Vec<BearingSample> {
    let mut mount = CameraMount::at_rest(scenario.mount, Angle::from_degrees(INITIAL_DEPRESSION_DEG));
    let latency_ticks = (scenario.camera.video.latency_s / TICK_S).round() as usize;
    // Pan and tilt of the last ticks: the first are those at which the picture of the current row was taken.
    let mut history: VecDeque<(f64, f64)> = VecDeque::new();
    let focal_px = scenario.camera.optics.focal_px;
    let (half_width, half_height) =
        (0.5 * f64::from(log.picture.width) - BORDER_PX, 0.5 * f64::from(log.picture.height) - BORDER_PX);
    let mut samples = Vec::with_capacity(log.rows.len());
    for (index, row) in log.rows.iter().enumerate() {
        let until = ((row.time_s - log.rows[0].time_s) / TICK_S) as u64;
        while mount.tick() < until {
            mount.advance();
            history.push_back((mount.pan.angle().radians(), mount.tilt.angle().radians()));
            if history.len() > latency_ticks + 1 {
                history.pop_front();
            }
        }
        let initial = (0.0, -INITIAL_DEPRESSION_DEG.to_radians());
        let (pan, tilt) = history.front().copied().unwrap_or(initial);
        if let Some(command) = row.command {
            mount.command(command);
        }
        let Some(at) = row.position else { continue };
        let (azimuth, depression) = direction(at, focal_px, pan, tilt);
        let is_at_border = at.x.abs() >= half_width || at.y.abs() >= half_height;
        let is_jump = is_jump(log, index);
        samples.push(BearingSample {
            time_s: row.time_s,
            azimuth,
            depression,
            is_valid: !is_at_border && !is_jump,
            is_at_border,
            is_jump,
        });
    }
    interpolate_between_jumps(&mut samples);
    interpolate_beyond_border(&mut samples);
    samples
}

/// Azimuth and depression of a position in the picture, for the camera's pan and tilt, all in radians.
fn direction(at: ImagePoint, focal_px: f64, pan: f64, tilt: f64) -> (f64, f64) {
    let (right, up) = (at.x / focal_px, at.y / focal_px);
    let (s, c) = (-tilt).sin_cos();
    let (forward, down) = (c + up * s, s - up * c);
    (right.atan2(forward) + pan, down.atan2(right.hypot(forward)))
}

fn interpolate_between_jumps(samples: &mut [BearingSample]) {
    let jumps: Vec<usize> = (0..samples.len()).filter(|index| samples[*index].is_jump).collect();
    for pair in jumps.windows(2) {
        let (from_s, to_s) = (samples[pair[0]].time_s, samples[pair[1]].time_s);
        if to_s - from_s <= MAX_JUMP_GAP_S {
            let first = samples.partition_point(|sample| sample.time_s < from_s - JUMP_MARGIN_S);
            let end = samples.partition_point(|sample| sample.time_s <= to_s + JUMP_MARGIN_S);
            interpolate(samples, first, end, false);
        }
    }
}

fn interpolate_beyond_border(samples: &mut [BearingSample]) {
    let mut first = 0;
    while first < samples.len() {
        let run = samples[first..].iter().take_while(|sample| sample.is_at_border).count();
        if run > 0 {
            interpolate(samples, first, first + run, true);
        }
        first += run.max(1);
    }
}

/// Replaces the samples from `first` up to `end` by the straight line between their neighbours; does nothing
/// where a neighbour is missing.
fn interpolate(samples: &mut [BearingSample], first: usize, end: usize, is_valid: bool) {
    if first == 0 || end >= samples.len() {
        return;
    }
    let (from, to) = (samples[first - 1], samples[end]);
    for sample in &mut samples[first..end] {
        let share = (sample.time_s - from.time_s) / (to.time_s - from.time_s);
        sample.azimuth = from.azimuth + share * (to.azimuth - from.azimuth);
        sample.depression = from.depression + share * (to.depression - from.depression);
        sample.is_valid = is_valid;
    }
}
