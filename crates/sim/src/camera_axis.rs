//! One axis of a camera: dead time, first-order lag, end stops.
//!
//! ```text
//! command --> dead time --> clip to limit --> lag: w' = (u - w)/tau, |w'| limited --> angle' = w --> end stops
//! ```
//! The dead times of a start and of a stop differ, as on the recorded vehicle. Time advances in ticks of
//! [`TICK_S`]; dead times are rounded to whole ticks.

use std::collections::VecDeque;

use barrelman_vocab::{Angle, AngularRate};

use crate::tick::{TICK_S, lag_share};

/// Dynamics of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisPlant {
    /// From a non-zero command to the start of its effect, seconds.
    pub start_dead_time_s: f64,
    /// From a zero command to the start of its effect, seconds.
    pub stop_dead_time_s: f64,
    /// Time constant of the rate, seconds.
    pub lag_s: f64,
    /// Largest rate.
    pub max_rate: AngularRate,
    /// Lower and upper end stop; `None` where the axis turns freely.
    pub end_stops: Option<(Angle, Angle)>,
    /// Deviations from an ideal axis.
    pub imperfections: AxisImperfections,
}

/// Deviations of a real axis from an ideal one; none by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisImperfections {
    /// Largest change of the rate, rad/s²; `None`: limited by the lag only.
    pub max_acceleration_rad_per_s2: Option<f64>,
    /// Commands smaller than this have no effect, rad/s.
    pub dead_band_rad_per_s: f64,
    /// Achieved share of the commanded rate.
    pub gain: f64,
}

impl Default for AxisImperfections {
    fn default() -> Self {
        Self { max_acceleration_rad_per_s2: None, dead_band_rad_per_s: 0.0, gain: 1.0 }
    }
}

/// An axis with its state.
#[derive(Debug, Clone)]
pub struct CameraAxis {
    plant: AxisPlant,
    /// Commands that have not taken effect, each with the tick at which it will.
    pending: VecDeque<(u64, AngularRate)>,
    active_rate: AngularRate,
    rate: AngularRate,
    angle: Angle,
}

impl CameraAxis {
    /// An axis at rest at `angle`.
    pub fn at_rest(plant: AxisPlant, angle: Angle) -> Self {
        Self {
            plant,
            pending: VecDeque::new(),
            active_rate: AngularRate::ZERO,
            rate: AngularRate::ZERO,
            angle,
        }
    }

    /// Passes a command at `tick`; it is clipped to the largest rate.
    pub fn command(&mut self, rate: AngularRate, tick: u64) {
        let rate = rate.clamped(self.plant.max_rate);
        let newest = self.pending.back().map_or(self.active_rate, |(_, rate)| *rate);
        if rate == newest {
            return;
        }
        let dead_time_s =
            if rate.is_zero() { self.plant.stop_dead_time_s } else { self.plant.start_dead_time_s };
        let effective = tick + (dead_time_s / TICK_S + 0.5) as u64;
        // A later command replaces earlier ones that have not taken effect by then.
        while self.pending.back().is_some_and(|(at, _)| *at >= effective) {
            self.pending.pop_back();
        }
        self.pending.push_back((effective, rate));
    }

    /// Advances by a tick.
    pub fn advance(&mut self, tick: u64) {
        self.advance_with_disturbance(tick, 0.0);
    }

    /// Advances by a tick, with an additional rate of `disturbance` rad/s from elsewhere.
    pub fn advance_with_disturbance(&mut self, tick: u64, disturbance: f64) {
        while let Some((_, rate)) = self.pending.pop_front_if(|(at, _)| *at <= tick) {
            self.active_rate = rate;
        }
        let share = lag_share(self.plant.lag_s);
        let (asked, had) = (self.active_rate.radians_per_second(), self.rate.radians_per_second());
        let imperfections = &self.plant.imperfections;
        let asked =
            if asked.abs() < imperfections.dead_band_rad_per_s { 0.0 } else { asked * imperfections.gain };
        let change = share * (asked - had);
        let change = imperfections
            .max_acceleration_rad_per_s2
            .map_or(change, |max| change.clamp(-max * TICK_S, max * TICK_S));
        let rate = had + change;
        let angle = self.angle.radians() + (rate + disturbance) * TICK_S;
        let stopped = self.plant.end_stops.map(|(low, high)| angle.clamp(low.radians(), high.radians()));
        match stopped {
            Some(held) if held != angle => {
                self.rate = AngularRate::ZERO;
                self.angle = Angle::from_radians(held);
            }
            _ => {
                self.rate = AngularRate::from_radians_per_second(rate);
                self.angle = Angle::from_radians(angle);
            }
        }
    }

    /// Whether a non-zero command is in effect.
    pub fn is_commanded(&self) -> bool {
        !self.active_rate.is_zero()
    }

    /// Present angle.
    pub const fn angle(&self) -> Angle {
        self.angle
    }

    /// Present rate.
    pub const fn rate(&self) -> AngularRate {
        self.rate
    }
}
