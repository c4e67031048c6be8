//! The model of one axis: its numbers, and the figures that are compared.

use barrelman_control::Region;
use barrelman_sim::tick::TICK_S;

/// Duration of a trial, seconds.
pub(super) const TRIAL_S: f64 = 120.0;
/// Standard deviation of the bearing's rate, rad/s, and its time constant, seconds: near those of the laboratory.
pub(super) const RATE_STD_DEV: f64 = 0.12;
pub(super) const RATE_TIME_CONSTANT_S: f64 = 2.0;
/// Dead time and lag of the axis, seconds, and its largest rate, rad/s.
pub(super) const DEAD_TIME_S: f64 = 0.3;
pub(super) const LAG_S: f64 = 0.42;
pub(super) const MAX_RATE: f64 = 0.34;

/// The laboratory's focal length, and the region's semi-axes, pixels.
pub(super) const FOCAL_PX: f64 = 330.0;
pub(super) const REGION: Region = Region { a_px: 192.0, b_px: 120.0 };
/// The region's edge, radians of pan.
pub(super) fn edge() -> f64 {
    (REGION.a_px / FOCAL_PX).atan()
}

/// What a law did, for each second.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Figures {
    /// Share of the time outside.
    outside: f64,
    /// rad²/s².
    rate_squared: f64,
    starts: f64,
    /// rad/s.
    rate: f64,
    /// Share of the time with a command.
    moving: f64,
    /// rad/s².
    variation: f64,
}

impl Figures {
    pub(super) const fn in_order(&self) -> [f64; 6] {
        [self.outside, self.rate_squared, self.starts, self.rate, self.moving, self.variation]
    }

    pub(super) const fn from_order(
        [outside, rate_squared, starts, rate, moving, variation]: [f64; 6],
    ) -> Self {
        Self { outside, rate_squared, starts, rate, moving, variation }
    }

    /// Adds a tick with a command in force.
    pub(super) fn add_tick(&mut self, is_outside: bool, rate: f64) {
        let share = TICK_S / TRIAL_S;
        self.outside += share * f64::from(u8::from(is_outside));
        self.rate_squared += share * rate * rate;
        self.rate += share * rate.abs();
        self.moving += share * f64::from(u8::from(rate != 0.0));
    }

    /// Adds a change of the command.
    pub(super) fn add_change(&mut self, before: f64, rate: f64) {
        self.variation += (rate - before).abs() / TRIAL_S;
        self.starts += f64::from(u8::from(before == 0.0 && rate != 0.0)) / TRIAL_S;
    }
}
