//! The messages between the program and its guard.

use std::fmt::Debug;

use barrelman_link::guard::message::{FromGuard, MessageCommand, MessageError, ToGuard};
use barrelman_link::guard::{Gate, GuardedCommand};
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates, VesselCommand, VesselOrder};

/// A message is read or refused. One that is read is written so that it is read again, and nothing passes the
/// guard's gate that is above the limits.
pub fn decode(bytes: &[u8]) {
    let limit = AngularRate::from_radians_per_second(0.3);
    let rates = VehicleRates::turning(limit, limit).zooming(1.0);
    check_to_guard(bytes, rates, |passed: VehicleRates| {
        let [yaw, pitch, zoom] = passed.parts();
        [yaw.abs() / 0.3, pitch.abs() / 0.3, zoom.abs()]
    });
    let largest = VesselCommand { throttle: 0.6, rudder: 1.0 };
    check_to_guard(bytes, VesselOrder::Commanded(largest), |passed: VesselOrder| {
        let command = passed.command();
        [command.throttle.abs() / largest.throttle, command.rudder.abs() / largest.rudder]
    });
    if let Ok(message) = FromGuard::decode(bytes) {
        check_again(&message, message.encode(), |again| FromGuard::decode(again).map(|again| again.encode()));
    }
}

/// The same for one kind of commands; `shares` gives what passes in shares of the limits.
fn check_to_guard<C: GuardedCommand + MessageCommand, const N: usize>(
    bytes: &[u8],
    limits: C,
    shares: impl Fn(C) -> [f64; N],
) {
    let Ok(message) = ToGuard::<C>::decode(bytes) else { return };
    check_again(&message, message.encode(), |again| ToGuard::<C>::decode(again).map(|again| again.encode()));
    if let ToGuard::Request(requested) = message {
        let gate = Gate::new(limits, Timestamp::ZERO);
        let passed = shares(gate.pass(requested, Timestamp::from_secs_f64(1.0)).command);
        assert!(passed.iter().all(|share| *share <= 1.000_01), "{passed:?}");
    }
}

/// The packet of a message that was read, read and written once more. A rate that is not a number equals no
/// other one, so that the packets are compared.
fn check_again(
    message: &impl Debug,
    packet: Vec<u8>,
    read_and_written: impl Fn(&[u8]) -> Result<Vec<u8>, MessageError>,
) {
    assert_eq!(read_and_written(&packet), Ok(packet.clone()), "{message:?}");
}
