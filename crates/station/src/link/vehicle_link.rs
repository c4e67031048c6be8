//! The link of a run: to a port or to a simulated camera.

use barrelman_vocab::{Timestamp, VehicleRates};

use super::camera_link::CameraLink;
use super::handle::LinkHandle;

/// Sends camera rates to a vehicle.
pub trait VehicleLink {
    /// Requests rates, in the vehicle's own signs, and replaces the rates requested before. Rates that move the camera
    /// are in force until `renew_by`: without a renewal by then, the link rests the camera (dead-man's switch). Does
    /// not block.
    fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>);
}

/// A link to a vehicle or to a simulated camera.
#[derive(Debug)]
pub enum Link {
    /// A ground station at a port.
    Port(LinkHandle),
    /// The camera of a simulated world.
    SimulatedCamera(CameraLink),
}

impl VehicleLink for Link {
    fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        match self {
            Self::Port(link) => link.send(rates, renew_by),
            Self::SimulatedCamera(link) => link.send(rates, renew_by),
        }
    }
}

impl Link {
    /// Ends the link with zeros. Returns whether the zeros were sent.
    pub fn close(self) -> bool {
        match self {
            Self::Port(link) => link.close(),
            Self::SimulatedCamera(link) => link.close(),
        }
    }
}
