//! The table of statistics of a target's motion.

use barrelman_sim::Scenario;
use barrelman_trial::logs::TrialLog;

use super::direction_changes::share_of_pauses_at_turns;
use super::displacements::first_leg_px;
use super::summary::mean;
use super::target_motion::{MIN_LEG_ACROSS_PX, TargetMotion};
use super::velocities::{
    ImageVelocity, MIN_MOVING_SPEED, autocorrelation, mean_run_faster_than_s, rms_acceleration,
};

/// The speed that the camera can follow, pixels per second.
const CAMERA_SPEED: f64 = 98.0;

/// Statistics that say nearly the same in different ways, such as the quantiles of the speed. In the fit a
/// group counts as one statistic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    Duration,
    Speed,
    SpeedByAxis,
    /// The share of time in motion, and faster than the camera.
    ShareOfTime,
    DirectionChanges,
    Pauses,
    /// Standing before and after the way.
    Standing,
    SpeedAtEnd,
    /// Acceleration, and correlation of the velocity over time.
    Smoothness,
    Legs,
    AzimuthChange,
    DepressionChange,
    Extent,
    LargeAzimuthChange,
    /// The spreads of statistics over the trials.
    SpreadOverTrials,
}

/// A statistic of the motion in one trial.
pub(crate) struct Statistic {
    pub(crate) name: &'static str,
    pub(crate) group: Group,
    /// The name of the statistic's spread over the trials, where the fit compares the spread, too.
    pub(crate) spread: Option<&'static str>,
    value: fn(&TargetMotion) -> f64,
}

impl Statistic {
    const fn new(group: Group, name: &'static str, value: fn(&TargetMotion) -> f64) -> Self {
        Self { name, group, spread: None, value }
    }

    const fn with_spread(mut self, name: &'static str) -> Self {
        self.spread = Some(name);
        self
    }
}

/// All statistics, in the order of the tables. Those of a group follow each other.
pub(crate) const STATISTICS: [Statistic; 57] = [
    Statistic::new(Group::Duration, "length, s", |m| m.duration_s).with_spread("spread of length"),
    Statistic::new(Group::Speed, "speed, 10 %, px/s", |m| m.speeds.quantile(0.10)),
    Statistic::new(Group::Speed, "speed, 25 %", |m| m.speeds.quantile(0.25)),
    Statistic::new(Group::Speed, "speed, 50 %", |m| m.speeds.quantile(0.50))
        .with_spread("spread of speed, 50 %"),
    Statistic::new(Group::Speed, "speed, 75 %", |m| m.speeds.quantile(0.75)),
    Statistic::new(Group::Speed, "speed, 90 %", |m| m.speeds.quantile(0.90))
        .with_spread("spread of speed, 90 %"),
    Statistic::new(Group::Speed, "speed, 95 %", |m| m.speeds.quantile(0.95)),
    Statistic::new(Group::Speed, "speed, 99 %", |m| m.speeds.quantile(0.99)),
    Statistic::new(Group::SpeedByAxis, "speed across, 50 %", |m| m.speeds_across.quantile(0.50)),
    Statistic::new(Group::SpeedByAxis, "speed across, 90 %", |m| m.speeds_across.quantile(0.90))
        .with_spread("spread of speed across, 90 %"),
    Statistic::new(Group::SpeedByAxis, "speed across, 95 %", |m| m.speeds_across.quantile(0.95)),
    Statistic::new(Group::SpeedByAxis, "speed up and down, 50 %", |m| m.speeds_vertical.quantile(0.50)),
    Statistic::new(Group::SpeedByAxis, "speed up and down, 90 %", |m| m.speeds_vertical.quantile(0.90)),
    Statistic::new(Group::SpeedByAxis, "speed up and down, 95 %", |m| m.speeds_vertical.quantile(0.95)),
    Statistic::new(Group::ShareOfTime, "moving share", |m| m.speeds.share_above(MIN_MOVING_SPEED)),
    Statistic::new(Group::ShareOfTime, "faster than the camera, share", |m| {
        m.speeds.share_above(CAMERA_SPEED)
    }),
    Statistic::new(Group::ShareOfTime, "faster than the camera, mean s", |m| {
        mean_run_faster_than_s(&m.velocities, CAMERA_SPEED)
    }),
    Statistic::new(Group::DirectionChanges, "direction changes per minute", |m| {
        m.per_minute(m.direction_changes.count)
    }),
    Statistic::new(Group::DirectionChanges, "speed where the direction changes", |m| {
        m.direction_changes.mean_speed
    }),
    Statistic::new(Group::Pauses, "pauses per minute", |m| m.per_minute(m.pauses.len() as f64)),
    Statistic::new(Group::Pauses, "mean pause, s", |m| mean(m.pauses.iter().map(|pause| pause.duration_s()))),
    Statistic::new(Group::Pauses, "pauses where it turns, share", |m| {
        share_of_pauses_at_turns(&m.samples, m.focal_px, &m.pauses)
    }),
    Statistic::new(Group::Standing, "setting off after, s", |m| m.set_off_s),
    Statistic::new(Group::Standing, "standing after, s", |m| m.standing_at_end_s),
    Statistic::new(Group::SpeedAtEnd, "speed in the last 1 s", |m| m.mean_speed_at_end(1.0)),
    Statistic::new(Group::SpeedAtEnd, "speed in the last 3 s", |m| m.mean_speed_at_end(3.0)),
    Statistic::new(Group::Smoothness, "acceleration, RMS, px/s2", |m| rms_acceleration(&m.velocities)),
    Statistic::new(Group::Smoothness, "correlation of speed over 1 s", |m| {
        autocorrelation(&m.velocities, 1.0, ImageVelocity::speed)
    }),
    Statistic::new(Group::Smoothness, "correlation of speed over 2 s", |m| {
        autocorrelation(&m.velocities, 2.0, ImageVelocity::speed)
    }),
    Statistic::new(Group::Smoothness, "correlation of speed over 4 s", |m| {
        autocorrelation(&m.velocities, 4.0, ImageVelocity::speed)
    }),
    Statistic::new(Group::Smoothness, "correlation of speed over 6 s", |m| {
        autocorrelation(&m.velocities, 6.0, ImageVelocity::speed)
    }),
    Statistic::new(Group::Smoothness, "persistence across over 1 s", |m| {
        autocorrelation(&m.velocities, 1.0, |velocity| velocity.across)
    }),
    Statistic::new(Group::Smoothness, "persistence across over 2 s", |m| {
        autocorrelation(&m.velocities, 2.0, |velocity| velocity.across)
    }),
    Statistic::new(Group::Smoothness, "persistence up, down over 0.5 s", |m| {
        autocorrelation(&m.velocities, 0.5, |velocity| velocity.vertical)
    }),
    Statistic::new(Group::Smoothness, "persistence up, down over 1 s", |m| {
        autocorrelation(&m.velocities, 1.0, |velocity| velocity.vertical)
    }),
    Statistic::new(Group::Legs, "legs across per minute", |m| m.per_minute(m.legs_across.count)),
    Statistic::new(Group::Legs, "legs across, RMS, px", |m| m.legs_across.rms_px),
    Statistic::new(Group::Legs, "speed on long legs across", |m| m.legs_across.long_px_per_s),
    Statistic::new(Group::Legs, "legs up and down per minute", |m| m.per_minute(m.legs_vertical.count)),
    Statistic::new(Group::Legs, "legs up and down, RMS, px", |m| m.legs_vertical.rms_px),
    Statistic::new(Group::Legs, "speed on long legs up, down", |m| m.legs_vertical.long_px_per_s),
    Statistic::new(Group::AzimuthChange, "azimuth over 1 s, RMS, px", |m| {
        m.rms_displacement_px(1.0, |sample| sample.azimuth)
    }),
    Statistic::new(Group::AzimuthChange, "azimuth over 2 s", |m| {
        m.rms_displacement_px(2.0, |sample| sample.azimuth)
    }),
    Statistic::new(Group::AzimuthChange, "azimuth over 4 s", |m| {
        m.rms_displacement_px(4.0, |sample| sample.azimuth)
    })
    .with_spread("spread of azimuth over 4 s"),
    Statistic::new(Group::AzimuthChange, "azimuth over 8 s", |m| {
        m.rms_displacement_px(8.0, |sample| sample.azimuth)
    }),
    Statistic::new(Group::DepressionChange, "depression over 1 s, RMS, px", |m| {
        m.rms_displacement_px(1.0, |sample| sample.depression)
    }),
    Statistic::new(Group::DepressionChange, "depression over 2 s", |m| {
        m.rms_displacement_px(2.0, |sample| sample.depression)
    }),
    Statistic::new(Group::DepressionChange, "depression over 4 s", |m| {
        m.rms_displacement_px(4.0, |sample| sample.depression)
    }),
    Statistic::new(Group::DepressionChange, "depression over 8 s", |m| {
        m.rms_displacement_px(8.0, |sample| sample.depression)
    }),
    Statistic::new(Group::Extent, "azimuth, from end to end, px", |m| {
        m.azimuths_px.quantile(1.0) - m.azimuths_px.quantile(0.0)
    }),
    Statistic::new(Group::Extent, "azimuth, its first leg, px", |m| {
        first_leg_px(&m.samples, m.focal_px, m.set_off_s, MIN_LEG_ACROSS_PX)
    }),
    Statistic::new(Group::Extent, "depression, 10 to 50 %, degrees", |m| {
        m.depressions_deg.quantile(0.50) - m.depressions_deg.quantile(0.10)
    }),
    Statistic::new(Group::Extent, "depression, 50 to 90 %", |m| {
        m.depressions_deg.quantile(0.90) - m.depressions_deg.quantile(0.50)
    }),
    Statistic::new(Group::LargeAzimuthChange, "azimuth over 1 s, 95 %, px", |m| {
        m.azimuth_change_quantile_px(1.0, 0.95)
    }),
    Statistic::new(Group::LargeAzimuthChange, "azimuth over 2 s, 95 %", |m| {
        m.azimuth_change_quantile_px(2.0, 0.95)
    }),
    Statistic::new(Group::LargeAzimuthChange, "azimuth over 2 s, 99 %", |m| {
        m.azimuth_change_quantile_px(2.0, 0.99)
    }),
    Statistic::new(Group::LargeAzimuthChange, "azimuth over 4 s, 95 %", |m| {
        m.azimuth_change_quantile_px(4.0, 0.95)
    }),
];

/// The statistics of one trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MotionStatistics {
    /// In the order of [`STATISTICS`].
    pub(crate) values: [f64; STATISTICS.len()],
}

impl MotionStatistics {
    /// Measures a trial. The plant is the scenario's nominal one.
    pub(crate) fn from_log(log: &TrialLog, scenario: &Scenario) -> Self {
        let motion = TargetMotion::from_log(log, scenario);
        Self { values: STATISTICS.each_ref().map(|statistic| (statistic.value)(&motion)) }
    }
}
