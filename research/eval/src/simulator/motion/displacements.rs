//! How far the target's direction moves within a time, when the target sets off, and how far it goes first.

use super::bearings::BearingSample;
use super::summary::SortedValues;

/// The target has set off when it is this far from its first position, pixels, for this long, seconds.
const SET_OFF_PX: f64 = 60.0;
const SET_OFF_S: f64 = 2.5;

/// Changes of a bearing within a time, radians, from each valid sample to a valid one.
pub(super) fn displacements<'a>(
    samples: &'a [BearingSample],
    interval_s: f64,
    bearing: fn(&BearingSample) -> f64,
) -> impl Iterator<Item = f64> + 'a {
    let mut later = 0;
    samples.iter().filter_map(move |sample| {
        while later < samples.len() && samples[later].time_s < sample.time_s + interval_s {
            later += 1;
        }
        let then = samples.get(later)?;
        (sample.is_valid && then.is_valid).then(|| bearing(then) - bearing(sample))
    })
}

/// The change of azimuth from the first position to where the target first turns back by `min_leg_px` after
/// it has set off, pixels, positive to the right; 0 where it does not turn back.
pub(super) fn first_leg_px(samples: &[BearingSample], focal_px: f64, set_off_s: f64, min_leg_px: f64) -> f64 {
    let azimuth_px = |sample: &BearingSample| focal_px * sample.azimuth;
    let Some(first) = samples.first() else { return 0.0 };
    let first_moving = samples.partition_point(|sample| sample.time_s < first.time_s + set_off_s);
    let start = initial_value(samples, azimuth_px);
    let (mut rightmost, mut leftmost) = (start, start);
    for sample in &samples[first_moving..] {
        let now = azimuth_px(sample);
        (rightmost, leftmost) = (rightmost.max(now), leftmost.min(now));
        if rightmost - start >= min_leg_px && rightmost - now >= min_leg_px {
            return rightmost - start;
        }
        if start - leftmost >= min_leg_px && now - leftmost >= min_leg_px {
            return leftmost - start;
        }
    }
    0.0
}

/// The median of a value over the first second.
fn initial_value(samples: &[BearingSample], value: impl Fn(&BearingSample) -> f64) -> f64 {
    let start_s = samples.first().map_or(0.0, |first| first.time_s);
    SortedValues::new(samples.iter().take_while(|sample| sample.time_s < start_s + 1.0).map(value))
        .quantile(0.5)
}

/// When the target sets off, seconds from the start: from then on it is at least [`SET_OFF_PX`] from its
/// first position for at least [`SET_OFF_S`]. What a hand does to the target or to the tracker before the
/// start lasts for less.
pub(super) fn set_off_s(samples: &[BearingSample], focal_px: f64) -> f64 {
    let Some(first) = samples.first() else { return 0.0 };
    let (azimuth, depression) =
        (initial_value(samples, |sample| sample.azimuth), initial_value(samples, |sample| sample.depression));
    let mut since_s = first.time_s;
    for sample in samples {
        let distance_px = (sample.azimuth - azimuth).hypot(sample.depression - depression) * focal_px;
        if distance_px < SET_OFF_PX {
            since_s = sample.time_s;
        } else if sample.time_s - since_s > SET_OFF_S {
            break;
        }
    }
    since_s - first.time_s
}
