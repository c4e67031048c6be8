//! Cameras that zoom: by command, or in and out by themselves.

use std::collections::VecDeque;

use barrelman_vocab::{ZoomDynamics, ZoomRate};

use crate::tick::TICK_S;

/// A zoom that follows commands. It starts at the widest view, which is the scenario's.
#[derive(Debug, Clone)]
pub struct CommandedZoom {
    dynamics: ZoomDynamics,
    /// Commands that have not taken effect, each with the tick at which it will.
    pending: VecDeque<(u64, ZoomRate)>,
    rate: ZoomRate,
    /// Logarithm of the focal length over the widest one.
    exponent: f64,
}

impl CommandedZoom {
    /// At rest, at the widest view.
    pub const fn at_rest(dynamics: ZoomDynamics) -> Self {
        Self { dynamics, pending: VecDeque::new(), rate: ZoomRate::ZERO, exponent: 0.0 }
    }

    /// Passes a command at `tick`; it is clipped to the largest rate.
    pub fn command(&mut self, rate: ZoomRate, tick: u64) {
        let rate = rate.clamped(self.dynamics.max_rate);
        let newest = self.pending.back().map_or(self.rate, |(_, rate)| *rate);
        if rate != newest {
            let effective = tick + (self.dynamics.dead_time.as_secs_f64() / TICK_S + 0.5) as u64;
            self.pending.push_back((effective, rate));
        }
    }

    /// Advances by a tick.
    pub fn advance(&mut self, tick: u64) {
        while let Some((_, rate)) = self.pending.pop_front_if(|(at, _)| *at <= tick) {
            self.rate = rate;
        }
        let exponent = self.exponent + self.rate.per_second() * TICK_S;
        self.exponent = exponent.clamp(0.0, libm::log(self.dynamics.ratio));
    }

    /// The focal length over the widest one.
    pub fn factor(&self) -> f64 {
        libm::exp(self.exponent)
    }
}

/// A zoom that goes on for the whole trial: the logarithm of the focal length swings like a cosine, from the
/// scenario's focal length to a multiple of it and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zoom {
    /// The largest focal length over the scenario's, above 0.
    pub ratio: f64,
    /// From one time at the scenario's focal length to the next, seconds, above 0.
    pub period_s: f64,
}

impl Zoom {
    /// The focal length at a tick over the scenario's.
    pub fn factor_at(&self, tick: u64) -> f64 {
        let phase = core::f64::consts::TAU * (tick as f64 * TICK_S) / self.period_s;
        libm::pow(self.ratio, 0.5 * (1.0 - libm::cos(phase)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tick::TICKS_PER_SECOND;

    #[test]
    fn a_zoom_follows_commands_after_its_dead_time_up_to_its_ends() {
        let dynamics = ZoomDynamics {
            ratio: 2.0,
            max_rate: ZoomRate::from_per_second(0.5),
            dead_time: core::time::Duration::from_millis(250),
        };
        let mut zoom = CommandedZoom::at_rest(dynamics);
        zoom.command(ZoomRate::from_per_second(9.0), 0);
        let at = |zoom: &mut CommandedZoom, from: u64, to: u64| {
            (from..to).for_each(|tick| zoom.advance(tick));
            zoom.factor()
        };
        assert_eq!(at(&mut zoom, 0, 30), 1.0, "a quarter of a second");
        assert!((at(&mut zoom, 30, 90) - libm::exp(0.25)).abs() < 1e-9);
        assert!((at(&mut zoom, 90, 900) - 2.0).abs() < 1e-12, "the end");
        zoom.command(-dynamics.max_rate, 900);
        assert_eq!(at(&mut zoom, 900, 1800), 1.0, "the other end");
    }

    #[test]
    fn a_zoom_goes_to_its_ratio_and_back_within_a_period() {
        let zoom = Zoom { ratio: 2.0, period_s: 20.0 };
        for (at_s, expected) in [(0, 1.0), (5, core::f64::consts::SQRT_2), (10, 2.0), (20, 1.0)] {
            let factor = zoom.factor_at(at_s * u64::from(TICKS_PER_SECOND));
            assert!((factor - expected).abs() < 1e-9, "{at_s} s: {factor}");
        }
    }
}
