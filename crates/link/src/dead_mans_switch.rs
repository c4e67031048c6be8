//! The dead-man's switch: the link rests the vehicle by itself when the run loop does not renew a moving
//! command in time.

use barrelman_vocab::{LinkCommand, RENEWAL_GRACE, Timestamp, VehicleRates};

/// A command that the run loop requests: rates in the vehicle's own signs, or what is asked of a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RequestedCommand<C> {
    /// The command.
    pub command: C,
    /// The time by which a command that moves something must be renewed. Without this time it has expired
    /// already.
    pub renew_by: Option<Timestamp>,
}

/// Rates that the run loop requests, in the vehicle's own signs.
pub type RequestedRates = RequestedCommand<VehicleRates>;

impl<C: LinkCommand> RequestedCommand<C> {
    /// Rest, which needs no renewal.
    pub const REST: Self = Self { command: C::REST, renew_by: None };

    /// The time at which a command that moves something expires.
    pub fn expires_at(&self) -> Timestamp {
        self.renew_by.map_or(Timestamp::ZERO, |at| at.plus(RENEWAL_GRACE))
    }
}

/// Replaces an expired command by rest.
#[derive(Debug, Default)]
pub struct DeadMansSwitch {
    has_expired: bool,
}

impl DeadMansSwitch {
    /// The command that may be in force at `now`. Each time that a command expires, `on_expiry` is called
    /// once.
    pub fn command_in_force<C: LinkCommand>(
        &mut self,
        requested: &RequestedCommand<C>,
        now: Timestamp,
        on_expiry: impl FnOnce(),
    ) -> C {
        let has_expired = !requested.command.is_rest() && requested.expires_at() <= now;
        if has_expired && !self.has_expired {
            on_expiry();
        }
        self.has_expired = has_expired;
        if has_expired { C::REST } else { requested.command }
    }
}
