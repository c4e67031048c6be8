//! The link to a boat: to a port, behind a guard, or to the boat of a simulated world.

use barrelman_emulators::simulated_boat::SimulatedBoat;
use barrelman_link::{GuardedLink, LinkHandle};
use barrelman_vocab::{Timestamp, VesselOrder};

/// Sends commands to a boat.
pub trait VesselLink {
    /// Requests a command, and replaces the one requested before. A command that is not neutral is in force
    /// until `renew_by`: without a renewal by then, the link makes the boat neutral (dead-man's switch). Does
    /// not block.
    fn send(&self, order: VesselOrder, renew_by: Option<Timestamp>);

    /// The operator wants the boat, which another program or a person steers. Does not block.
    fn take_control(&self) {}
}

/// A link to a boat or to a simulated boat.
#[derive(Debug)]
pub enum Boat {
    /// A boat at a port that a thread of this process serves.
    Port(LinkHandle<VesselOrder>),
    /// A boat at a port that a guard serves.
    Guarded(GuardedLink<VesselOrder>),
    /// The boat of a simulated world.
    Simulated(SimulatedBoat),
}

impl VesselLink for Boat {
    fn send(&self, order: VesselOrder, renew_by: Option<Timestamp>) {
        match self {
            Self::Port(link) => link.send(order, renew_by),
            Self::Guarded(link) => link.send(order, renew_by),
            Self::Simulated(boat) => boat.send(order, renew_by),
        }
    }

    fn take_control(&self) {
        match self {
            Self::Port(link) => link.take_control(),
            Self::Guarded(link) => link.take_control(),
            Self::Simulated(_) => {}
        }
    }
}

impl Boat {
    /// Ends the link with neutral commands. Returns whether they were sent.
    pub fn close(self) -> bool {
        match self {
            Self::Port(link) => link.close(),
            Self::Guarded(link) => link.close(),
            Self::Simulated(boat) => {
                boat.send(VesselOrder::NEUTRAL, None);
                true
            }
        }
    }
}
