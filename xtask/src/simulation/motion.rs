//! How a target moved, with the camera's motion taken out: the statistics that the simulated target is fitted to.
//!
//! The camera is followed from the commands with the plant as identified (dead times, lag), so that each place in
//! the picture becomes a bearing in the room: azimuth A and depression E. The target's speed is that of its bearing
//! times the focal length, pixels per second, over half a second. Nothing here looks at P or at the region, and
//! recorded and simulated trials are treated alike: rows, picture coordinates and commands.

use std::collections::VecDeque;

use barrelman_sim::camera_axis::TICK_S;
use barrelman_sim::{CameraMount, Scenario};
use barrelman_trial::logs::TrialLog;
use barrelman_vocab::{Angle, VehicleProfile};

use super::recorded::{JUMP_PX, step_px};

/// Names of [`Motion::values`].
pub(super) const STATISTICS: [&str; 25] = [
    "length, s",
    "speed, 10 %, px/s",
    "speed, 25 %",
    "speed, 50 %",
    "speed, 75 %",
    "speed, 90 %",
    "speed, 95 %",
    "moving share",
    "faster than the camera, share",
    "direction changes per minute",
    "pauses per minute",
    "mean pause, s",
    "standing before, s",
    "standing after, s",
    "azimuth over 1 s, RMS, px",
    "azimuth over 2 s",
    "azimuth over 4 s",
    "azimuth over 8 s",
    "depression over 1 s, RMS, px",
    "depression over 2 s",
    "depression over 4 s",
    "depression over 8 s",
    "speed where the direction changes",
    "correlation of speed over 1 s",
    "correlation of speed over 2 s",
];

/// How the target of a trial moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    /// As [`STATISTICS`] names them.
    pub(super) values: [f64; 25],
}

/// Places are compared over so long, seconds.
const BASE_S: f64 = 0.5;
/// What is slower than this stands, pixels per second.
const STANDING: f64 = 15.0;
/// The speed that the camera can follow, pixels per second.
const CAMERA: f64 = 98.0;
/// A pause lasts at least so long, seconds.
const PAUSE_S: f64 = 0.4;
/// A change of direction by more than this within a second counts, degrees.
const CHANGE_DEG: f64 = 50.0;
/// Depression at the start, as identified.
const DEPRESSION_DEG: f64 = 24.0;
/// A place this close to the picture's border may be clamped, pixels.
const BORDER_PX: f64 = 4.0;

/// One sample: the time, the bearing, and whether it is to be trusted.
#[derive(Debug, Clone, Copy)]
struct Sample {
    at_s: f64,
    azimuth: f64,
    depression: f64,
    good: bool,
}

/// Measures a trial. The plant is the scenario's nominal one.
pub(super) fn of(log: &TrialLog, scenario: &Scenario) -> Motion {
    let samples = bearings(log, scenario);
    let speeds = velocities(&samples, scenario.camera.optics.focal_px);
    let mut sorted: Vec<f64> = speeds.iter().filter_map(|(_, v)| v.map(|(a, e)| a.hypot(e))).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(0.0);
    let share = |condition: &dyn Fn(f64) -> bool| {
        sorted.iter().filter(|speed| condition(**speed)).count() as f64 / sorted.len().max(1) as f64
    };
    let minutes = log.duration_s() / 60.0;
    let (pauses, pause_s, before_s, after_s) = standing(&speeds);
    let (changes, speed_in_changes) = direction_changes(&speeds);
    let moved = |over_s: f64, of: fn(&Sample) -> f64| {
        displacement(&samples, over_s, of) * scenario.camera.optics.focal_px
    };
    Motion {
        values: [
            log.duration_s(),
            at(0.10),
            at(0.25),
            at(0.50),
            at(0.75),
            at(0.90),
            at(0.95),
            share(&|speed| speed > STANDING),
            share(&|speed| speed > CAMERA),
            changes / minutes,
            pauses / minutes,
            pause_s,
            before_s,
            after_s,
            moved(1.0, |sample| sample.azimuth),
            moved(2.0, |sample| sample.azimuth),
            moved(4.0, |sample| sample.azimuth),
            moved(8.0, |sample| sample.azimuth),
            moved(1.0, |sample| sample.depression),
            moved(2.0, |sample| sample.depression),
            moved(4.0, |sample| sample.depression),
            moved(8.0, |sample| sample.depression),
            speed_in_changes,
            persistence(&speeds, 1.0),
            persistence(&speeds, 2.0),
        ],
    }
}

/// The bearings at the rows.
fn bearings(log: &TrialLog, scenario: &Scenario) -> Vec<Sample> {
    let profile = VehicleProfile::fotokite_pro();
    let mut mount = CameraMount::at_rest(scenario.mount, Angle::from_degrees(DEPRESSION_DEG));
    let latency_ticks = (scenario.camera.video.latency_s / TICK_S).round() as usize;
    // The camera as it was when the picture was taken that a row speaks of.
    let mut past: VecDeque<(f64, f64)> = VecDeque::new();
    let f = scenario.camera.optics.focal_px;
    let (half_width, half_height) =
        (0.5 * f64::from(log.picture.width) - BORDER_PX, 0.5 * f64::from(log.picture.height) - BORDER_PX);
    let mut samples = Vec::with_capacity(log.rows.len());
    for (index, row) in log.rows.iter().enumerate() {
        let until = ((row.time_s - log.rows[0].time_s) / TICK_S) as u64;
        while mount.tick() < until {
            mount.advance();
            past.push_back((mount.pan.angle().radians(), mount.tilt.angle().radians()));
            if past.len() > latency_ticks + 1 {
                past.pop_front();
            }
        }
        let (pan, tilt) = past.front().copied().unwrap_or((0.0, -DEPRESSION_DEG.to_radians()));
        if let Some(rates) = row.rates {
            mount.command(profile.incoming(rates));
        }
        let Some(at) = row.position else { continue };
        let (right, up) = (at.x / f, at.y / f);
        let (s, c) = (-tilt).sin_cos();
        let (forward, down) = (c + up * s, s - up * c);
        samples.push(Sample {
            at_s: row.time_s,
            azimuth: right.atan2(forward) + pan,
            depression: down.atan2(right.hypot(forward)),
            good: at.x.abs() < half_width
                && at.y.abs() < half_height
                && (index == 0 || step_px(log, index) <= JUMP_PX),
        });
    }
    samples
}

/// Velocities of the bearing at the samples, pixels per second; `None` where a sample near it is not to be trusted.
fn velocities(samples: &[Sample], focal_px: f64) -> Vec<(f64, Option<(f64, f64)>)> {
    let mut velocities = Vec::with_capacity(samples.len());
    let (mut low, mut high) = (0, 0);
    for sample in samples {
        while samples[low].at_s < sample.at_s - 0.5 * BASE_S {
            low += 1;
        }
        while high + 1 < samples.len() && samples[high].at_s < sample.at_s + 0.5 * BASE_S {
            high += 1;
        }
        let (from, to) = (samples[low], samples[high]);
        let span = to.at_s - from.at_s;
        let good = span > 0.8 * BASE_S && samples[low..=high].iter().all(|near| near.good);
        velocities.push((
            sample.at_s,
            good.then(|| {
                let across = (to.azimuth - from.azimuth) * sample.depression.cos();
                (focal_px * across / span, focal_px * (to.depression - from.depression) / span)
            }),
        ));
    }
    velocities
}

/// RMS of how far a bearing moves within a time, radians, over the samples that are to be trusted.
fn displacement(samples: &[Sample], over_s: f64, of: fn(&Sample) -> f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    let mut later = 0;
    for sample in samples {
        while later < samples.len() && samples[later].at_s < sample.at_s + over_s {
            later += 1;
        }
        let Some(then) = samples.get(later) else { break };
        if sample.good && then.good {
            sum += (of(then) - of(sample)).powi(2);
            count += 1;
        }
    }
    (sum / count.max(1) as f64).sqrt()
}

/// The correlation of the speed with what it is after a time.
fn persistence(velocities: &[(f64, Option<(f64, f64)>)], after_s: f64) -> f64 {
    let mut pairs = Vec::new();
    let mut later = 0;
    for (at_s, velocity) in velocities {
        while later < velocities.len() && velocities[later].0 < at_s + after_s {
            later += 1;
        }
        let Some((_, then)) = velocities.get(later) else { break };
        if let (Some((a, e)), Some((b, f))) = (velocity, then) {
            pairs.push((a.hypot(*e), b.hypot(*f)));
        }
    }
    let count = pairs.len().max(1) as f64;
    let mean = pairs.iter().fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0 / count, sum.1 + pair.1 / count));
    let (mut both, mut first, mut second) = (0.0, 0.0, 0.0);
    for (a, b) in pairs {
        both += (a - mean.0) * (b - mean.1);
        first += (a - mean.0).powi(2);
        second += (b - mean.1).powi(2);
    }
    let scale = (first * second).sqrt();
    if scale > 0.0 { both / scale } else { 0.0 }
}

/// How often the direction changed within a second, and the mean speed in the middle of that.
fn direction_changes(velocities: &[(f64, Option<(f64, f64)>)]) -> (f64, f64) {
    let (mut speed, mut count) = (0.0, 0_usize);
    let mut changes = 0;
    let mut changing = false;
    let mut later = 0;
    for (at_s, velocity) in velocities {
        while later + 1 < velocities.len() && velocities[later].0 < at_s + 1.0 {
            later += 1;
        }
        let changed = match (velocity, velocities[later].1) {
            (Some(a), Some(b)) if a.0.hypot(a.1) > STANDING && b.0.hypot(b.1) > STANDING => {
                let turn = (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1);
                turn.abs().to_degrees() > CHANGE_DEG
            }
            _ => false,
        };
        changes += usize::from(changed && !changing);
        let middle = velocities.partition_point(|(then, _)| *then < at_s + 0.5);
        if changed && let Some((_, Some((a, e)))) = velocities.get(middle) {
            speed += a.hypot(*e);
            count += 1;
        }
        changing = changed;
    }
    (changes as f64, speed / count.max(1) as f64)
}

/// Pauses on the way, their mean length, and how long it stood before and after.
fn standing(velocities: &[(f64, Option<(f64, f64)>)]) -> (f64, f64, f64, f64) {
    let moves = |v: &Option<(f64, f64)>| v.is_some_and(|(a, e)| a.hypot(e) > STANDING);
    let first = velocities.iter().position(|(_, v)| moves(v)).unwrap_or(0);
    let last = velocities.iter().rposition(|(_, v)| moves(v)).unwrap_or(0);
    let start = velocities.first().map_or(0.0, |(at, _)| *at);
    let end = velocities.last().map_or(0.0, |(at, _)| *at);
    let mut pauses = Vec::new();
    let mut since: Option<f64> = None;
    for (at_s, velocity) in velocities.get(first..=last).unwrap_or_default() {
        match (velocity, since) {
            (Some(_), None) if !moves(velocity) => since = Some(*at_s),
            (Some(_), Some(from)) if moves(velocity) => {
                pauses.push(at_s - from);
                since = None;
            }
            (None, _) => since = None,
            _ => {}
        }
    }
    pauses.retain(|pause| *pause >= PAUSE_S);
    let mean = pauses.iter().sum::<f64>() / pauses.len().max(1) as f64;
    (
        pauses.len() as f64,
        mean,
        velocities.get(first).map_or(0.0, |(at, _)| at - start),
        velocities.get(last).map_or(0.0, |(at, _)| end - at),
    )
}
