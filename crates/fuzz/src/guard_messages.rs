//! The messages between the program and its guard.

use std::fmt::Debug;

use barrelman_link::guard::Gate;
use barrelman_link::guard::message::{FromGuard, MessageError, ToGuard};
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};

/// A message is read or refused. One that is read is written so that it is read again, and no rate passes the guard's gate that is
/// above the limits.
pub fn decode(bytes: &[u8]) {
    if let Ok(message) = ToGuard::decode(bytes) {
        check_again(&message, message.encode(), |again| ToGuard::decode(again).map(|again| again.encode()));
        if let ToGuard::Request(requested) = message {
            let limit = AngularRate::from_radians_per_second(0.3);
            let gate = Gate::new(VehicleRates { yaw: limit, pitch: limit }, Timestamp::ZERO);
            let passed = gate.pass(requested, Timestamp::from_secs_f64(1.0)).rates;
            for rate in [passed.yaw, passed.pitch] {
                assert!(rate.radians_per_second().abs() <= 0.300_002, "{rate:?}");
            }
        }
    }
    if let Ok(message) = FromGuard::decode(bytes) {
        check_again(&message, message.encode(), |again| FromGuard::decode(again).map(|again| again.encode()));
    }
}

/// The packet of a message that was read, read and written once more. A rate that is not a number equals no other one, so
/// that the packets are compared.
fn check_again(
    message: &impl Debug,
    packet: Vec<u8>,
    read_and_written: impl Fn(&[u8]) -> Result<Vec<u8>, MessageError>,
) {
    assert_eq!(read_and_written(&packet), Ok(packet.clone()), "{message:?}");
}
