//! What the guard accepts of the program: a command within the limits, a time to live that is not too long,
//! and a sign of life.
//!
//! A plain struct without clock and pipe.

use std::time::Duration;

use barrelman_vocab::profile::MAX_COAST_MOTION;
use barrelman_vocab::{LinkCommand, Timestamp, VehicleRates, VesselOrder};

use crate::dead_mans_switch::RequestedCommand;

/// The guard closes the link after this time without a message.
pub const SILENCE: Duration = Duration::from_secs(1);
/// The program sends a message at least this often.
pub const HEARTBEAT: Duration = Duration::from_millis(200);
/// Longest time to live of rates that move the camera: no licence to move lasts longer without a renewal.
pub const MAX_TIME_TO_LIVE: Duration = MAX_COAST_MOTION;
/// Room for the rounding of a rate at its limit, rad/s, and of a share.
const ROUNDING: f64 = 1e-6;

/// A command that a guard lets pass.
pub trait GuardedCommand: LinkCommand {
    /// Whether no part of the command is above that of the limits, or no number.
    fn is_within(self, limits: Self) -> bool;
}

impl GuardedCommand for VehicleRates {
    fn is_within(self, limits: Self) -> bool {
        let is_within = |(rate, limit): (f64, f64)| rate.abs() <= limit + ROUNDING;
        self.parts().into_iter().zip(limits.parts()).all(is_within)
    }
}

impl GuardedCommand for VesselOrder {
    fn is_within(self, limits: Self) -> bool {
        let (command, limits) = (self.command(), limits.command());
        command.throttle.abs() <= limits.throttle + ROUNDING
            && command.rudder.abs() <= limits.rudder + ROUNDING
    }
}

/// The guard's own check of what the program requests.
#[derive(Debug, Clone)]
pub struct Gate<C = VehicleRates> {
    limits: C,
    last_heard: Timestamp,
}

impl<C: GuardedCommand> Gate<C> {
    /// A gate with the largest command that may pass, in the vehicle's own axes; every part at least zero.
    pub const fn new(limits: C, now: Timestamp) -> Self {
        Self { limits, last_heard: now }
    }

    /// A message arrived.
    pub fn heard(&mut self, now: Timestamp) {
        self.last_heard = now;
    }

    /// Whether the program has been silent for too long.
    pub fn is_silent(&self, now: Timestamp) -> bool {
        now.since(self.last_heard) >= SILENCE
    }

    /// What passes of a request. A command that is not a number or above its limit is a fault of the program:
    /// the vehicle rests. A time to live that is too long is shortened.
    pub fn pass(&self, requested: RequestedCommand<C>, now: Timestamp) -> RequestedCommand<C> {
        if !requested.command.is_within(self.limits) {
            return RequestedCommand::REST;
        }
        let latest = now.plus(MAX_TIME_TO_LIVE);
        RequestedCommand { renew_by: requested.renew_by.map(|at| at.min(latest)), ..requested }
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{AngularRate, VesselCommand};

    use super::*;

    fn rates(yaw: f64, pitch: f64) -> VehicleRates {
        let rate = AngularRate::from_radians_per_second;
        VehicleRates::turning(rate(yaw), rate(pitch))
    }

    #[track_caller]
    fn check(requested: VehicleRates, lives_ms: u64, expected: VehicleRates, expected_ms: u64) {
        let at = |ms: u64| Timestamp::from_nanos(ms * 1_000_000);
        let gate = Gate::new(rates(0.4, 0.3).zooming(1.0), at(0));
        let passed = gate
            .pass(RequestedCommand { command: requested, renew_by: Some(at(1_000 + lives_ms)) }, at(1_000));
        assert_eq!(passed.command, expected);
        if !expected.is_rest() {
            assert_eq!(passed.renew_by, Some(at(1_000 + expected_ms)));
        }
    }

    #[test]
    fn rates_within_the_limits_pass_with_a_short_time_to_live() {
        check(rates(0.4, -0.3), 250, rates(0.4, -0.3), 250);
        check(rates(0.1, 0.0), 60_000, rates(0.1, 0.0), 500);
        check(rates(0.41, 0.0), 250, VehicleRates::REST, 0);
        check(rates(0.1, -0.31), 250, VehicleRates::REST, 0);
        let zooming = |speed| rates(0.1, 0.0).zooming(speed);
        check(zooming(-1.0), 250, zooming(-1.0), 250);
        check(zooming(1.01), 250, VehicleRates::REST, 0);
        check(zooming(f64::NAN), 250, VehicleRates::REST, 0);
        check(rates(f64::NAN, 0.0), 250, VehicleRates::REST, 0);
        check(rates(0.0, f64::INFINITY), 250, VehicleRates::REST, 0);
    }

    #[test]
    fn what_is_asked_of_a_vessel_passes_within_the_limits() {
        let order = |throttle, rudder| VesselOrder::Commanded(VesselCommand { throttle, rudder });
        let gate = Gate::new(order(0.6, 1.0), Timestamp::ZERO);
        let passed = |wanted| {
            let requested = RequestedCommand { command: wanted, renew_by: Some(Timestamp::from_nanos(9)) };
            gate.pass(requested, Timestamp::ZERO).command
        };
        for wanted in [order(0.6, -1.0), order(-0.6, 0.0), VesselOrder::Released] {
            assert_eq!(passed(wanted), wanted);
        }
        for wanted in [order(0.7, 0.0), order(0.0, 1.1), order(f64::NAN, 0.0)] {
            assert_eq!(passed(wanted), VesselOrder::NEUTRAL);
        }
    }
}
