//! The velocity of the target's direction, and what follows from it: correlation over time, acceleration,
//! runs.

use super::bearings::BearingSample;
use super::summary::mean;

/// The interval over which a velocity is measured, seconds.
const INTERVAL_S: f64 = 0.5;

/// A target slower than this stands still, pixels per second.
pub(super) const MIN_MOVING_SPEED: f64 = 15.0;

/// A velocity in the picture, pixels per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImageVelocity {
    /// To the right.
    pub(super) across: f64,
    /// Downwards.
    pub(super) vertical: f64,
}

impl ImageVelocity {
    pub(super) fn speed(self) -> f64 {
        self.across.hypot(self.vertical)
    }

    pub(super) fn is_moving(self) -> bool {
        self.speed() > MIN_MOVING_SPEED
    }
}

/// The velocity around a sample's time; `None` where a sample near it is invalid.
#[derive(Debug, Clone, Copy)]
pub(super) struct VelocitySample {
    pub(super) time_s: f64,
    pub(super) velocity: Option<ImageVelocity>,
}

/// The velocities at the samples.
pub(super) fn velocities(samples: &[BearingSample], focal_px: f64) -> Vec<VelocitySample> {
    let mut velocities = Vec::with_capacity(samples.len());
    let (mut low, mut high) = (0, 0);
    for sample in samples {
        while samples[low].time_s < sample.time_s - 0.5 * INTERVAL_S {
            low += 1;
        }
        while high + 1 < samples.len() && samples[high].time_s < sample.time_s + 0.5 * INTERVAL_S {
            high += 1;
        }
        let (from, to) = (samples[low], samples[high]);
        let duration_s = to.time_s - from.time_s;
        let is_valid = duration_s > 0.8 * INTERVAL_S && samples[low..=high].iter().all(|near| near.is_valid);
        let velocity = is_valid.then(|| {
            let across = (to.azimuth - from.azimuth) * sample.depression.cos();
            ImageVelocity {
                across: focal_px * across / duration_s,
                vertical: focal_px * (to.depression - from.depression) / duration_s,
            }
        });
        velocities.push(VelocitySample { time_s: sample.time_s, velocity });
    }
    velocities
}

/// Mean speed of the samples within a range of times, pixels per second.
pub(super) fn mean_speed(velocities: &[VelocitySample], from_s: f64, to_s: f64) -> f64 {
    mean(
        velocities
            .iter()
            .filter(|sample| (from_s..to_s).contains(&sample.time_s))
            .filter_map(|sample| sample.velocity.map(ImageVelocity::speed)),
    )
}

/// Correlation of a function of the velocity with its value `lag_s` later; 0 where it is undefined.
pub(super) fn autocorrelation(
    velocities: &[VelocitySample],
    lag_s: f64,
    value: impl Fn(ImageVelocity) -> f64,
) -> f64 {
    let mut pairs = Vec::new();
    let mut later = 0;
    for VelocitySample { time_s, velocity } in velocities {
        while later < velocities.len() && velocities[later].time_s < time_s + lag_s {
            later += 1;
        }
        let Some(then) = velocities.get(later) else { break };
        if let (Some(now), Some(then)) = (velocity, then.velocity) {
            pairs.push((value(*now), value(then)));
        }
    }
    let count = pairs.len().max(1) as f64;
    let mean = pairs.iter().fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0 / count, sum.1 + pair.1 / count));
    let (mut covariance, mut variance_now, mut variance_then) = (0.0, 0.0, 0.0);
    for (now, then) in pairs {
        covariance += (now - mean.0) * (then - mean.1);
        variance_now += (now - mean.0).powi(2);
        variance_then += (then - mean.1).powi(2);
    }
    let scale = (variance_now * variance_then).sqrt();
    if scale > 0.0 { covariance / scale } else { 0.0 }
}

/// RMS acceleration over [`INTERVAL_S`], pixels per second squared.
pub(super) fn rms_acceleration(velocities: &[VelocitySample]) -> f64 {
    let mut later = 0;
    let squares = velocities.iter().filter_map(|sample| {
        while later + 1 < velocities.len() && velocities[later].time_s < sample.time_s + INTERVAL_S {
            later += 1;
        }
        let (now, then) = (sample.velocity?, velocities[later].velocity?);
        let squared = (then.across - now.across).powi(2) + (then.vertical - now.vertical).powi(2);
        Some(squared / (INTERVAL_S * INTERVAL_S))
    });
    mean(squares).sqrt()
}

/// Mean duration of the runs of samples whose speed is above a limit, seconds.
pub(super) fn mean_run_faster_than_s(velocities: &[VelocitySample], limit: f64) -> f64 {
    let mut durations = Vec::new();
    let mut since: Option<f64> = None;
    for VelocitySample { time_s, velocity } in velocities {
        match (velocity.is_some_and(|velocity| velocity.speed() > limit), since) {
            (true, None) => since = Some(*time_s),
            (false, Some(from_s)) => {
                durations.push(time_s - from_s);
                since = None;
            }
            _ => {}
        }
    }
    mean(durations.into_iter())
}
