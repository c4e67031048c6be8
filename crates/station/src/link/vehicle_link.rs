//! The link of a run: to a port or to a simulated camera.

use barrelman_emulators::camera_link::CameraLink;
use barrelman_link::{GuardedLink, LinkHandle};
use barrelman_vocab::{Timestamp, VehicleRates};

/// Sends camera rates to a vehicle.
pub trait VehicleLink {
    /// Requests rates, in the vehicle's own signs, and replaces the rates requested before. Rates that move
    /// the camera are in force until `renew_by`: without a renewal by then, the link rests the camera
    /// (dead-man's switch). Does not block.
    fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>);

    /// The operator takes the control of the vehicle back, if another client has taken it. Does not block.
    fn take_control(&self) {}
}

/// A link to a vehicle or to a simulated camera.
#[derive(Debug)]
pub enum Link {
    /// A ground station at a port that a thread of this process serves.
    Port(LinkHandle),
    /// A ground station at a port that a guard serves.
    Guarded(GuardedLink),
    /// A vehicle whose commands expire by themselves, which a thread of this process asks over HTTP.
    Expiring(LinkHandle),
    /// The camera of a simulated world.
    SimulatedCamera(CameraLink),
}

impl VehicleLink for Link {
    fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        match self {
            Self::Port(link) | Self::Expiring(link) => link.send(rates, renew_by),
            Self::Guarded(link) => link.send(rates, renew_by),
            Self::SimulatedCamera(link) => link.send(rates, renew_by),
        }
    }

    fn take_control(&self) {
        match self {
            Self::Port(link) | Self::Expiring(link) => link.take_control(),
            Self::Guarded(link) => link.take_control(),
            Self::SimulatedCamera(_) => {}
        }
    }
}

impl Link {
    /// Whether there is a vehicle at the other end, or an emulated one, and no camera of this process.
    pub const fn reaches_vehicle(&self) -> bool {
        matches!(self, Self::Port(_) | Self::Guarded(_) | Self::Expiring(_))
    }

    /// Ends the link with zeros. Returns whether the camera rests: the zeros were sent, or its motion ends
    /// without them.
    pub fn close(self) -> bool {
        match self {
            Self::Port(link) => link.close(),
            Self::Guarded(link) => link.close(),
            Self::Expiring(link) => {
                if !link.close() {
                    tracing::warn!(
                        "the last zeros could not be sent, as the link was down; the camera's motion has ended by itself"
                    );
                }
                true
            }
            Self::SimulatedCamera(link) => link.close(),
        }
    }
}
