//! How a target moved, with the camera's motion taken out: the statistics that the simulated target is fitted to.
//!
//! The camera is followed from the commands with the plant as identified (dead times, lag), so that each place in
//! the picture becomes a bearing in the room: azimuth A and depression E. The target's speed is that of its bearing
//! times the focal length, pixels per second, over half a second. Nothing here looks at P or at the region, and
//! recorded and simulated trials are treated alike: rows, picture coordinates and commands.

use std::collections::VecDeque;

use barrelman_sim::tick::TICK_S;
use barrelman_sim::{CameraMount, Scenario};
use barrelman_trial::logs::TrialLog;
use barrelman_vocab::{Angle, VehicleProfile};

use super::recorded::{JUMP_PX, step_px};

/// Names of [`Motion::values`].
pub(super) const STATISTICS: [&str; COUNT] = [
    "length, s",
    "speed, 10 %, px/s",
    "speed, 25 %",
    "speed, 50 %",
    "speed, 75 %",
    "speed, 90 %",
    "speed, 95 %",
    "speed, 99 %",
    "speed across, 50 %",
    "speed across, 90 %",
    "speed across, 95 %",
    "speed up and down, 50 %",
    "speed up and down, 90 %",
    "speed up and down, 95 %",
    "moving share",
    "faster than the camera, share",
    "faster than the camera, mean s",
    "direction changes per minute",
    "speed where the direction changes",
    "pauses per minute",
    "mean pause, s",
    "pauses where it turns, share",
    "setting off after, s",
    "standing after, s",
    "speed in the last 1 s",
    "speed in the last 3 s",
    "acceleration, RMS, px/s2",
    "correlation of speed over 1 s",
    "correlation of speed over 2 s",
    "correlation of speed over 4 s",
    "correlation of speed over 6 s",
    "persistence across over 1 s",
    "persistence across over 2 s",
    "persistence up, down over 0.5 s",
    "persistence up, down over 1 s",
    "legs across per minute",
    "legs across, RMS, px",
    "speed on long legs across",
    "legs up and down per minute",
    "legs up and down, RMS, px",
    "speed on long legs up, down",
    "azimuth over 1 s, RMS, px",
    "azimuth over 2 s",
    "azimuth over 4 s",
    "azimuth over 8 s",
    "depression over 1 s, RMS, px",
    "depression over 2 s",
    "depression over 4 s",
    "depression over 8 s",
    "azimuth, from end to end, px",
    "azimuth, its first leg, px",
    "depression, 10 to 50 %, degrees",
    "depression, 50 to 90 %",
    "azimuth over 1 s, 95 %, px",
    "azimuth over 2 s, 95 %",
    "azimuth over 2 s, 99 %",
    "azimuth over 4 s, 95 %",
];

/// How many statistics there are.
pub(super) const COUNT: usize = 57;

/// How the target of a trial moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    /// As [`STATISTICS`] names them.
    pub(super) values: [f64; COUNT],
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
/// A pause after which it goes on in a direction that differs by more than this is at a turn, degrees; the directions are
/// those of the displacements over so long before and after, seconds, of so many pixels at least.
const TURN_DEG: f64 = 60.0;
const TURN_S: f64 = 1.2;
const TURN_PX: f64 = 8.0;
/// Depression at the start, as identified.
const DEPRESSION_DEG: f64 = 24.0;
/// A leg is what lies between two turning points of a bearing that are so far apart at least: across, and up and
/// down, pixels.
const LEG_PX: (f64, f64) = (40.0, 25.0);
/// Legs of so many times that are long.
const LONG_LEG: f64 = 3.0;
/// It has set off when it is so far from where it stood, pixels, for so long, seconds.
const SET_OFF_PX: f64 = 60.0;
const SET_OFF_S: f64 = 2.5;
/// So long before the first of several jumps and after the last the place is not the target's either, seconds.
const AROUND_JUMPS_S: f64 = 0.25;
/// Jumps that follow each other within this belong together: what lies between them was not the target, seconds.
const JUMPS_S: f64 = 1.5;
/// A place this close to the picture's border may be clamped, pixels.
const BORDER_PX: f64 = 4.0;

/// One sample: the time, the bearing, and whether it is to be trusted.
#[derive(Debug, Clone, Copy)]
struct Sample {
    at_s: f64,
    azimuth: f64,
    depression: f64,
    good: bool,
    /// Whether its place is at the picture's border, where it may have been clamped.
    at_border: bool,
    /// Whether its place is far from the one before.
    jumped: bool,
}

/// Measures a trial. The plant is the scenario's nominal one.
pub(super) fn of(log: &TrialLog, scenario: &Scenario) -> Motion {
    let f = scenario.camera.optics.focal_px;
    let samples = bearings(log, scenario);
    let velocities = velocities(&samples, f);
    let known: Vec<(f64, f64)> = velocities.iter().filter_map(|(_, v)| *v).collect();
    let speed = |v: (f64, f64)| v.0.hypot(v.1);
    let speeds = Sorted::of(known.iter().map(|v| speed(*v)));
    let across = Sorted::of(known.iter().map(|v| v.0.abs()));
    let upward = Sorted::of(known.iter().map(|v| v.1.abs()));
    let depressions =
        Sorted::of(samples.iter().filter(|sample| sample.good).map(|s| s.depression.to_degrees()));
    let azimuths = Sorted::of(samples.iter().map(|sample| f * sample.azimuth));
    let share = |condition: &dyn Fn(f64) -> bool| {
        speeds.0.iter().filter(|speed| condition(**speed)).count() as f64 / speeds.0.len().max(1) as f64
    };
    let minutes = log.duration_s() / 60.0;
    let before_s = setting_off(&samples, f);
    let (pauses, after_s) = standing(&velocities, before_s);
    let turns: Vec<f64> = pauses.iter().filter_map(|pause| turn(&samples, f, *pause)).collect();
    let (changes, speed_in_changes) = direction_changes(&velocities);
    let moved = |over_s: f64, of: fn(&Sample) -> f64| {
        mean(displacements(&samples, over_s, of).map(|by| by * by)).sqrt() * f
    };
    let went = |over_s: f64, share: f64| {
        Sorted::of(displacements(&samples, over_s, |s| s.azimuth).map(|by| f * by.abs())).at(share)
    };
    let last_s = samples.last().map_or(0.0, |sample| sample.at_s);
    let mean_speed = |from_s: f64, to_s: f64| {
        mean(
            velocities.iter().filter(|(at, _)| (from_s..to_s).contains(at)).filter_map(|(_, v)| v.map(speed)),
        )
    };
    let legs_across = Legs::of(&samples, LEG_PX.0, |sample| f * sample.azimuth * sample.depression.cos());
    let legs_upward = Legs::of(&samples, LEG_PX.1, |sample| f * sample.depression);
    Motion {
        values: [
            log.duration_s(),
            speeds.at(0.10),
            speeds.at(0.25),
            speeds.at(0.50),
            speeds.at(0.75),
            speeds.at(0.90),
            speeds.at(0.95),
            speeds.at(0.99),
            across.at(0.50),
            across.at(0.90),
            across.at(0.95),
            upward.at(0.50),
            upward.at(0.90),
            upward.at(0.95),
            share(&|speed| speed > STANDING),
            share(&|speed| speed > CAMERA),
            stretches(&velocities, |v| v.0.hypot(v.1) > CAMERA),
            changes / minutes,
            speed_in_changes,
            pauses.len() as f64 / minutes,
            mean(pauses.iter().map(|(from_s, to_s)| to_s - from_s)),
            mean(turns.iter().map(|turn| f64::from(*turn > TURN_DEG))),
            before_s,
            after_s,
            mean_speed(last_s - 1.0, last_s),
            mean_speed(last_s - 3.0, last_s),
            acceleration(&velocities),
            correlation(&velocities, 1.0, speed),
            correlation(&velocities, 2.0, speed),
            correlation(&velocities, 4.0, speed),
            correlation(&velocities, 6.0, speed),
            correlation(&velocities, 1.0, |v| v.0),
            correlation(&velocities, 2.0, |v| v.0),
            correlation(&velocities, 0.5, |v| v.1),
            correlation(&velocities, 1.0, |v| v.1),
            legs_across.count / minutes,
            legs_across.rms_px,
            legs_across.long_px_per_s,
            legs_upward.count / minutes,
            legs_upward.rms_px,
            legs_upward.long_px_per_s,
            moved(1.0, |sample| sample.azimuth),
            moved(2.0, |sample| sample.azimuth),
            moved(4.0, |sample| sample.azimuth),
            moved(8.0, |sample| sample.azimuth),
            moved(1.0, |sample| sample.depression),
            moved(2.0, |sample| sample.depression),
            moved(4.0, |sample| sample.depression),
            moved(8.0, |sample| sample.depression),
            azimuths.at(1.0) - azimuths.at(0.0),
            first_leg(&samples, f, before_s),
            depressions.at(0.50) - depressions.at(0.10),
            depressions.at(0.90) - depressions.at(0.50),
            went(1.0, 0.95),
            went(2.0, 0.95),
            went(2.0, 0.99),
            went(4.0, 0.95),
        ],
    }
}

/// Depressions, radians, and speeds, pixels per second, of a target that does not stand.
pub(super) fn under_way(log: &TrialLog, scenario: &Scenario) -> Vec<(f64, f64)> {
    let samples = bearings(log, scenario);
    let velocities = velocities(&samples, scenario.camera.optics.focal_px);
    let pairs = samples.iter().zip(velocities).filter_map(|(sample, (_, velocity))| {
        let (across, upward) = velocity?;
        Some((sample.depression, across.hypot(upward)))
    });
    pairs.filter(|(_, speed)| *speed > STANDING).collect()
}

/// Values in order.
struct Sorted(Vec<f64>);

impl Sorted {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        Self(values)
    }

    /// The quantile of a share; 0 where there are no values.
    fn at(&self, share: f64) -> f64 {
        let index = (share * self.0.len() as f64) as usize;
        self.0.get(index.min(self.0.len().max(1) - 1)).copied().unwrap_or(0.0)
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    sum / count.max(1) as f64
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
            mount.command(profile.from_vehicle(rates));
        }
        let Some(at) = row.position else { continue };
        let (right, up) = (at.x / f, at.y / f);
        let (s, c) = (-tilt).sin_cos();
        let (forward, down) = (c + up * s, s - up * c);
        let at_border = at.x.abs() >= half_width || at.y.abs() >= half_height;
        let jumped = index > 0 && step_px(log, index) > JUMP_PX;
        samples.push(Sample {
            at_s: row.time_s,
            azimuth: right.atan2(forward) + pan,
            depression: down.atan2(right.hypot(forward)),
            good: !at_border && !jumped,
            at_border,
            jumped,
        });
    }
    bridge(&mut samples);
    samples
}

/// Lays a straight line over what is not the target: what lies between jumps, which stays untrusted, and over where it
/// was beyond the picture's border, through which it went at some speed that this is the mean of.
fn bridge(samples: &mut [Sample]) {
    let jumps: Vec<usize> = (0..samples.len()).filter(|index| samples[*index].jumped).collect();
    for pair in jumps.windows(2) {
        let (from_s, to_s) = (samples[pair[0]].at_s, samples[pair[1]].at_s);
        if to_s - from_s <= JUMPS_S {
            let first = samples.partition_point(|sample| sample.at_s < from_s - AROUND_JUMPS_S);
            let end = samples.partition_point(|sample| sample.at_s <= to_s + AROUND_JUMPS_S);
            span(samples, first, end, false);
        }
    }
    let mut first = 0;
    while first < samples.len() {
        let run = samples[first..].iter().take_while(|sample| sample.at_border).count();
        if run > 0 {
            span(samples, first, first + run, true);
        }
        first += run.max(1);
    }
}

/// The straight line from the sample before `first` to the one at `end`, where there are both.
fn span(samples: &mut [Sample], first: usize, end: usize, good: bool) {
    if first == 0 || end >= samples.len() {
        return;
    }
    let (from, to) = (samples[first - 1], samples[end]);
    for sample in &mut samples[first..end] {
        let share = (sample.at_s - from.at_s) / (to.at_s - from.at_s);
        sample.azimuth = from.azimuth + share * (to.azimuth - from.azimuth);
        sample.depression = from.depression + share * (to.depression - from.depression);
        sample.good = good;
    }
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

/// By how much a bearing changes within a time, radians, from each sample on that is to be trusted.
fn displacements<'a>(
    samples: &'a [Sample],
    over_s: f64,
    of: fn(&Sample) -> f64,
) -> impl Iterator<Item = f64> + 'a {
    let mut later = 0;
    samples.iter().filter_map(move |sample| {
        while later < samples.len() && samples[later].at_s < sample.at_s + over_s {
            later += 1;
        }
        let then = samples.get(later)?;
        (sample.good && then.good).then(|| of(then) - of(sample))
    })
}

/// By how much its azimuth changes until it first turns back after it has set off, to the right above 0, pixels.
fn first_leg(samples: &[Sample], focal_px: f64, set_off_s: f64) -> f64 {
    let azimuth = |sample: &Sample| focal_px * sample.azimuth;
    let Some(first) = samples.first() else { return 0.0 };
    let under_way = samples.partition_point(|sample| sample.at_s < first.at_s + set_off_s);
    let stood = stood_at(samples, azimuth);
    let (mut farthest, mut nearest) = (stood, stood);
    for sample in &samples[under_way..] {
        let now = azimuth(sample);
        (farthest, nearest) = (farthest.max(now), nearest.min(now));
        // It has gone one way by a leg, and back from there by another.
        if farthest - stood >= LEG_PX.0 && farthest - now >= LEG_PX.0 {
            return farthest - stood;
        }
        if stood - nearest >= LEG_PX.0 && now - nearest >= LEG_PX.0 {
            return nearest - stood;
        }
    }
    0.0
}

/// Where it stood in the first second.
fn stood_at(samples: &[Sample], of: impl Fn(&Sample) -> f64) -> f64 {
    let start_s = samples.first().map_or(0.0, |first| first.at_s);
    Sorted::of(samples.iter().take_while(|sample| sample.at_s < start_s + 1.0).map(of)).at(0.5)
}

/// When it sets off: from then on it is [`SET_OFF_PX`] from where it stood for [`SET_OFF_S`] at least. What a hand
/// does to it before, and what a tracker makes of the hand, comes back sooner.
fn setting_off(samples: &[Sample], focal_px: f64) -> f64 {
    let Some(first) = samples.first() else { return 0.0 };
    let (azimuth, depression) = (stood_at(samples, |s| s.azimuth), stood_at(samples, |s| s.depression));
    let mut since = first.at_s;
    for sample in samples {
        let off = (sample.azimuth - azimuth).hypot(sample.depression - depression) * focal_px;
        if off < SET_OFF_PX {
            since = sample.at_s;
        } else if sample.at_s - since > SET_OFF_S {
            break;
        }
    }
    since - first.at_s
}

/// The velocity at each sample's time.
type Velocities = [(f64, Option<(f64, f64)>)];

/// The correlation of what `of` makes of the velocity with what it is after a time.
fn correlation(velocities: &Velocities, after_s: f64, of: impl Fn((f64, f64)) -> f64) -> f64 {
    let mut pairs = Vec::new();
    let mut later = 0;
    for (at_s, velocity) in velocities {
        while later < velocities.len() && velocities[later].0 < at_s + after_s {
            later += 1;
        }
        let Some((_, then)) = velocities.get(later) else { break };
        if let (Some(now), Some(then)) = (velocity, then) {
            pairs.push((of(*now), of(*then)));
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

/// RMS change of the velocity within half a second, for each second.
fn acceleration(velocities: &Velocities) -> f64 {
    let mut later = 0;
    let squares = velocities.iter().filter_map(|(at_s, velocity)| {
        while later + 1 < velocities.len() && velocities[later].0 < at_s + BASE_S {
            later += 1;
        }
        let (a, b) = ((*velocity)?, velocities[later].1?);
        Some(((b.0 - a.0).powi(2) + (b.1 - a.1).powi(2)) / (BASE_S * BASE_S))
    });
    mean(squares).sqrt()
}

/// The mean duration of the stretches in which something holds of the velocity, seconds.
fn stretches(velocities: &Velocities, holds: impl Fn((f64, f64)) -> bool) -> f64 {
    let mut durations = Vec::new();
    let mut since: Option<f64> = None;
    for (at_s, velocity) in velocities {
        match (velocity.is_some_and(&holds), since) {
            (true, None) => since = Some(*at_s),
            (false, Some(from)) => {
                durations.push(at_s - from);
                since = None;
            }
            _ => {}
        }
    }
    mean(durations.into_iter())
}

/// What lies between the turning points of a bearing.
struct Legs {
    count: f64,
    rms_px: f64,
    /// Mean speed over the long ones, pixels per second.
    long_px_per_s: f64,
}

impl Legs {
    /// A turning point is one from which the bearing goes by `least_px` before it goes further.
    fn of(samples: &[Sample], least_px: f64, bearing: impl Fn(&Sample) -> f64) -> Self {
        let mut turns: Vec<(f64, f64)> = Vec::new();
        let Some(first) = samples.first() else {
            return Self { count: 0.0, rms_px: 0.0, long_px_per_s: 0.0 };
        };
        let mut extreme = (first.at_s, bearing(first));
        let mut sense = 0.0_f64;
        turns.push(extreme);
        for sample in samples {
            let now = (sample.at_s, bearing(sample));
            let off = now.1 - extreme.1;
            if sense == 0.0 {
                if off.abs() >= least_px {
                    (sense, extreme) = (off.signum(), now);
                }
            } else if sense * off >= 0.0 {
                extreme = now;
            } else if off.abs() >= least_px {
                turns.push(extreme);
                (sense, extreme) = (-sense, now);
            }
        }
        turns.push(extreme);
        let legs: Vec<(f64, f64)> =
            turns.windows(2).map(|pair| (pair[1].0 - pair[0].0, (pair[1].1 - pair[0].1).abs())).collect();
        let long = || legs.iter().filter(|(_, px)| *px >= LONG_LEG * least_px);
        let (long_s, long_px) = long().fold((0.0, 0.0), |sum, leg| (sum.0 + leg.0, sum.1 + leg.1));
        Self {
            count: legs.len() as f64,
            rms_px: mean(legs.iter().map(|(_, px)| px * px)).sqrt(),
            long_px_per_s: if long_s > 0.0 { long_px / long_s } else { 0.0 },
        }
    }
}

/// How often the direction changed within a second, and the mean speed in the middle of that.
fn direction_changes(velocities: &Velocities) -> (f64, f64) {
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
                between_deg(*a, b) > CHANGE_DEG
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

/// By how much the direction after a pause differs from that before, degrees.
fn turn(samples: &[Sample], focal_px: f64, (from_s, to_s): (f64, f64)) -> Option<f64> {
    let at = |at_s: f64| samples.get(samples.partition_point(|sample| sample.at_s < at_s));
    let went = |from: &Sample, to: &Sample| {
        let across = focal_px * (to.azimuth - from.azimuth) * to.depression.cos();
        let upward = focal_px * (to.depression - from.depression);
        (across.hypot(upward) >= TURN_PX).then_some((across, upward))
    };
    let before = went(at(from_s - TURN_S)?, at(from_s)?)?;
    let after = went(at(to_s)?, at(to_s + TURN_S)?)?;
    Some(between_deg(before, after))
}

/// The angle between two directions, degrees.
fn between_deg(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1).abs().to_degrees()
}

/// From when to when it paused on its way, and how long it stood after.
fn standing(velocities: &Velocities, set_off_s: f64) -> (Vec<(f64, f64)>, f64) {
    let moves = |v: &Option<(f64, f64)>| v.is_some_and(|(a, e)| a.hypot(e) > STANDING);
    let start = velocities.first().map_or(0.0, |(at, _)| *at);
    let first = velocities.partition_point(|(at, _)| *at < start + set_off_s);
    let last = velocities.iter().rposition(|(_, v)| moves(v)).unwrap_or(0);
    let end = velocities.last().map_or(0.0, |(at, _)| *at);
    let mut pauses = Vec::new();
    let mut since: Option<f64> = None;
    for (at_s, velocity) in velocities.get(first..=last).unwrap_or_default() {
        match (velocity, since) {
            (Some(_), None) if !moves(velocity) => since = Some(*at_s),
            (Some(_), Some(from)) if moves(velocity) => {
                pauses.push((from, *at_s));
                since = None;
            }
            (None, _) => since = None,
            _ => {}
        }
    }
    pauses.retain(|(from_s, to_s)| to_s - from_s >= PAUSE_S);
    (pauses, velocities.get(last).map_or(0.0, |(at, _)| end - at))
}
