//! The link to the boat of a simulated world: the world reads the requested command at each tick.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use barrelman_link::{DeadMansSwitch, RequestedCommand};
use barrelman_vocab::{Timestamp, VesselOrder};

/// The boat of a simulated world: the world reads the order at each tick. Clones are the same boat. The link
/// has the dead-man's switch of a real link.
#[derive(Debug, Clone, Default)]
pub struct SimulatedBoat(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    requested: RequestedCommand<VesselOrder>,
    switch: DeadMansSwitch,
}

impl SimulatedBoat {
    fn state(&self) -> MutexGuard<'_, State> {
        // Plain data, whole at any time: a panic elsewhere does not spoil it.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Requests a command, which will be renewed by `renew_by`.
    pub fn send(&self, order: VesselOrder, renew_by: Option<Timestamp>) {
        self.state().requested = RequestedCommand { command: order, renew_by };
    }

    /// Requests a command that lasts until the next one.
    pub fn send_latched(&self, order: VesselOrder) {
        self.send(order, Some(Timestamp::from_nanos(u64::MAX)));
    }

    /// For the world: the order of this tick.
    pub fn order(&self, now: Timestamp) -> VesselOrder {
        let mut state = self.state();
        let requested = state.requested;
        state.switch.command_in_force(&requested, now, || {
            tracing::error!("the pilot is held up: the link makes the boat neutral");
        })
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::VesselCommand;

    use super::*;

    #[test]
    fn a_command_that_is_not_renewed_ends_in_neutral() {
        let at = |ms: u64| Timestamp::from_nanos(ms * 1_000_000);
        let boat = SimulatedBoat::default();
        assert_eq!(boat.order(at(0)), VesselOrder::Released);
        let ahead = VesselOrder::Commanded(VesselCommand { throttle: 0.5, rudder: 0.0 });
        boat.send(ahead, Some(at(100)));
        assert_eq!([boat.order(at(149)), boat.order(at(150))], [ahead, VesselOrder::NEUTRAL]);
        boat.send_latched(ahead);
        assert_eq!(boat.order(at(1_000_000)), ahead);
    }
}
