//! A link, whatever lies at its other end.

use barrelman_vocab::{Timestamp, VehicleRates};

use super::camera_link::CameraLink;
use super::worker::LinkHandle;

/// A link to a vehicle or to a simulated camera.
#[derive(Debug)]
pub enum Link {
    /// A ground station at a port.
    Port(LinkHandle),
    /// A simulated world's camera.
    World(CameraLink),
}

impl Link {
    /// Asks for rates, in the vehicle's own signs, that are renewed by `renew_by`.
    pub fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        match self {
            Self::Port(link) => link.send(rates, renew_by),
            Self::World(link) => link.send(rates, renew_by),
        }
    }

    /// Ends the link with zeros. Returns whether they were sent.
    pub fn close(self) -> bool {
        match self {
            Self::Port(link) => link.close(),
            Self::World(link) => link.close(),
        }
    }
}
