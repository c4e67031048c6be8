//! What an emulator has to know of a vehicle: its end of the protocol, without port and camera.

use barrelman_vocab::{Timestamp, VehicleProfile, VehicleRates};

use super::log::VehicleState;
use crate::camera_link::Pointing;

/// A vehicle's end of a protocol.
pub trait EmulatedVehicle {
    /// How the vehicle is called.
    const NAME: &'static str;

    /// The profile whose signs the vehicle has.
    fn profile(&self) -> &VehicleProfile;

    /// The vehicle is switched off and on.
    fn reboot(&mut self, now: Timestamp);

    /// Another commander takes the control.
    fn take_over(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>);

    /// Takes received bytes, appends the answers to `out`, and passes the text of each message to
    /// `on_message`, with the state after it.
    fn receive(
        &mut self,
        bytes: &[u8],
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
        on_message: &mut dyn FnMut(String, VehicleState),
    );

    /// Appends what the vehicle sends by itself to `out`.
    fn advance(&mut self, pointing: Pointing, now: Timestamp, out: &mut Vec<Vec<u8>>);

    /// The rates in force and the vehicle's state.
    fn state(&self) -> VehicleState;

    /// The rates in force, in the vehicle's own signs.
    fn rates(&self) -> VehicleRates {
        self.state().rates
    }

    /// The texts of a packet that is sent, for the log.
    fn texts(&self, packet: &[u8]) -> Vec<String>;
}
