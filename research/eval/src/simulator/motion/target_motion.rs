//! The motion of one trial's target: bearings, velocities, and what the statistics are computed from.

use barrelman_sim::Scenario;
use barrelman_trial::logs::TrialLog;

use super::bearings::{BearingSample, bearings};
use super::direction_changes::DirectionChanges;
use super::displacements::{displacements, set_off_s};
use super::legs::Legs;
use super::pauses::{Pause, find_pauses};
use super::summary::{SortedValues, mean};
use super::velocities::{ImageVelocity, MIN_MOVING_SPEED, VelocitySample, mean_speed, velocities};

/// The least length of a leg across, and of one up and down, pixels.
pub(super) const MIN_LEG_ACROSS_PX: f64 = 40.0;
const MIN_LEG_VERTICAL_PX: f64 = 25.0;

/// The motion of one trial's target.
pub(super) struct TargetMotion {
    pub(super) duration_s: f64,
    pub(super) focal_px: f64,
    pub(super) samples: Vec<BearingSample>,
    pub(super) velocities: Vec<VelocitySample>,
    /// Of the velocities, pixels per second.
    pub(super) speeds: SortedValues,
    pub(super) speeds_across: SortedValues,
    pub(super) speeds_vertical: SortedValues,
    /// Azimuths of all samples, pixels.
    pub(super) azimuths_px: SortedValues,
    /// Depressions of the valid samples, degrees.
    pub(super) depressions_deg: SortedValues,
    /// From the start, seconds.
    pub(super) set_off_s: f64,
    pub(super) pauses: Vec<Pause>,
    /// How long the target stands at the end, seconds.
    pub(super) standing_at_end_s: f64,
    pub(super) direction_changes: DirectionChanges,
    pub(super) legs_across: Legs,
    pub(super) legs_vertical: Legs,
}

impl TargetMotion {
    /// Reconstructs the motion from a trial. The plant is the scenario's nominal one.
    pub(super) fn from_log(log: &TrialLog, scenario: &Scenario) -> Self {
        let focal_px = scenario.camera.optics.focal_px;
        let samples = bearings(log, scenario);
        let velocities = velocities(&samples, focal_px);
        let valid: Vec<ImageVelocity> = velocities.iter().filter_map(|sample| sample.velocity).collect();
        let set_off_s = set_off_s(&samples, focal_px);
        let (pauses, standing_at_end_s) = find_pauses(&velocities, set_off_s);
        Self {
            duration_s: log.duration_s(),
            focal_px,
            speeds: SortedValues::new(valid.iter().map(|velocity| velocity.speed())),
            speeds_across: SortedValues::new(valid.iter().map(|velocity| velocity.across.abs())),
            speeds_vertical: SortedValues::new(valid.iter().map(|velocity| velocity.vertical.abs())),
            azimuths_px: SortedValues::new(samples.iter().map(|sample| focal_px * sample.azimuth)),
            depressions_deg: SortedValues::new(
                samples.iter().filter(|sample| sample.is_valid).map(|sample| sample.depression.to_degrees()),
            ),
            set_off_s,
            pauses,
            standing_at_end_s,
            direction_changes: DirectionChanges::from_velocities(&velocities),
            legs_across: Legs::from_samples(&samples, MIN_LEG_ACROSS_PX, |sample| {
                focal_px * sample.azimuth * sample.depression.cos()
            }),
            legs_vertical: Legs::from_samples(&samples, MIN_LEG_VERTICAL_PX, |sample| {
                focal_px * sample.depression
            }),
            samples,
            velocities,
        }
    }

    pub(super) fn per_minute(&self, count: f64) -> f64 {
        count / (self.duration_s / 60.0)
    }

    /// RMS change of a bearing within a time, pixels.
    pub(super) fn rms_displacement_px(&self, interval_s: f64, bearing: fn(&BearingSample) -> f64) -> f64 {
        let squares = displacements(&self.samples, interval_s, bearing).map(|change| change * change);
        mean(squares).sqrt() * self.focal_px
    }

    /// A quantile of the absolute change of azimuth within a time, pixels.
    pub(super) fn azimuth_change_quantile_px(&self, interval_s: f64, share: f64) -> f64 {
        let changes = displacements(&self.samples, interval_s, |sample| sample.azimuth);
        SortedValues::new(changes.map(|change| self.focal_px * change.abs())).quantile(share)
    }

    /// Mean speed within a time before the end, pixels per second.
    pub(super) fn mean_speed_at_end(&self, interval_s: f64) -> f64 {
        let end_s = self.samples.last().map_or(0.0, |sample| sample.time_s);
        mean_speed(&self.velocities, end_s - interval_s, end_s)
    }
}

/// A sample of a target that does not stand still.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovingSample {
    pub(crate) depression_rad: f64,
    pub(crate) speed_px_per_s: f64,
}

/// The samples of a trial in which the target moves.
pub(crate) fn moving_samples(log: &TrialLog, scenario: &Scenario) -> Vec<MovingSample> {
    let samples = bearings(log, scenario);
    let velocities = velocities(&samples, scenario.camera.optics.focal_px);
    let pairs = samples.iter().zip(velocities).filter_map(|(sample, velocity)| {
        let speed_px_per_s = velocity.velocity?.speed();
        Some(MovingSample { depression_rad: sample.depression, speed_px_per_s })
    });
    pairs.filter(|sample| sample.speed_px_per_s > MIN_MOVING_SPEED).collect()
}
