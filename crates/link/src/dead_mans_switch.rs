//! The dead-man's switch: the link rests the camera by itself when the run loop does not renew a moving rate in time.

use barrelman_vocab::{RENEWAL_GRACE, Timestamp, VehicleRates};

/// Rates that the run loop requests, in the vehicle's own signs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RequestedRates {
    /// The rates.
    pub rates: VehicleRates,
    /// The time by which rates that move the camera must be renewed. Without this time they have expired already.
    pub renew_by: Option<Timestamp>,
}

impl RequestedRates {
    /// Rest, which needs no renewal.
    pub const REST: Self = Self { rates: VehicleRates::REST, renew_by: None };

    /// The time at which rates that move the camera expire.
    pub fn expires_at(&self) -> Timestamp {
        self.renew_by.map_or(Timestamp::ZERO, |at| at.plus(RENEWAL_GRACE))
    }
}

/// Replaces expired rates by rest.
#[derive(Debug, Default)]
pub struct DeadMansSwitch {
    has_expired: bool,
}

impl DeadMansSwitch {
    /// The rates that the camera may have at `now`. Each time that rates expire, `on_expiry` is called once.
    pub fn rates_in_force(
        &mut self,
        requested: &RequestedRates,
        now: Timestamp,
        on_expiry: impl FnOnce(),
    ) -> VehicleRates {
        let has_expired = !requested.rates.is_rest() && requested.expires_at() <= now;
        if has_expired && !self.has_expired {
            on_expiry();
        }
        self.has_expired = has_expired;
        if has_expired { VehicleRates::REST } else { requested.rates }
    }
}
