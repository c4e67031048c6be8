//! The legs of a bearing: what lies between two turning points.

use super::bearings::BearingSample;
use super::summary::mean;

/// A leg of at least this many minimum lengths is long.
const LONG_LEG: f64 = 3.0;

/// The legs of one bearing.
pub(super) struct Legs {
    pub(super) count: f64,
    /// RMS length, pixels.
    pub(super) rms_px: f64,
    /// Mean speed over the long legs, pixels per second; 0 where there is none.
    pub(super) long_px_per_s: f64,
}

impl Legs {
    /// Finds the legs of a bearing, pixels. A turning point is an extreme from which the bearing returns by
    /// at least `min_leg_px`.
    pub(super) fn from_samples(
        samples: &[BearingSample],
        min_leg_px: f64,
        bearing_px: impl Fn(&BearingSample) -> f64,
    ) -> Self {
        let turning_points = turning_points(samples, min_leg_px, bearing_px);
        let legs: Vec<(f64, f64)> = turning_points
            .windows(2)
            .map(|pair| (pair[1].0 - pair[0].0, (pair[1].1 - pair[0].1).abs()))
            .collect();
        let (long_s, long_px) = legs
            .iter()
            .filter(|(_, px)| *px >= LONG_LEG * min_leg_px)
            .fold((0.0, 0.0), |sum, leg| (sum.0 + leg.0, sum.1 + leg.1));
        Self {
            count: legs.len() as f64,
            rms_px: mean(legs.iter().map(|(_, px)| px * px)).sqrt(),
            long_px_per_s: if long_s > 0.0 { long_px / long_s } else { 0.0 },
        }
    }
}

/// Time and bearing of the first sample, of each turning point, and of the last extreme.
fn turning_points(
    samples: &[BearingSample],
    min_leg_px: f64,
    bearing_px: impl Fn(&BearingSample) -> f64,
) -> Vec<(f64, f64)> {
    let Some(first) = samples.first() else { return Vec::new() };
    let mut extreme = (first.time_s, bearing_px(first));
    let mut turning_points = vec![extreme];
    // The direction in which the bearing moves: 1, -1, or 0 until it has moved by a leg.
    let mut sense = 0.0_f64;
    for sample in samples {
        let now = (sample.time_s, bearing_px(sample));
        let moved_px = now.1 - extreme.1;
        if sense == 0.0 {
            if moved_px.abs() >= min_leg_px {
                (sense, extreme) = (moved_px.signum(), now);
            }
        } else if sense * moved_px >= 0.0 {
            extreme = now;
        } else if moved_px.abs() >= min_leg_px {
            turning_points.push(extreme);
            (sense, extreme) = (-sense, now);
        }
    }
    turning_points.push(extreme);
    turning_points
}
