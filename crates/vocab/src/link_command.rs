//! What every command to a vehicle has in common, for the link that carries it.

use core::fmt::Debug;

use crate::profile::VehicleRates;
use crate::vessel::VesselOrder;

/// A command that a link carries: the rates of a camera, or what is asked of a vessel.
pub trait LinkCommand: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The command that a vehicle may keep: nothing moves.
    const REST: Self;

    /// Whether nothing moves by this command: it needs no renewal.
    fn is_rest(self) -> bool;
}

impl LinkCommand for VehicleRates {
    const REST: Self = Self::REST;

    fn is_rest(self) -> bool {
        Self::is_rest(self)
    }
}

impl LinkCommand for VesselOrder {
    const REST: Self = Self::NEUTRAL;

    fn is_rest(self) -> bool {
        self.command().is_neutral()
    }
}
