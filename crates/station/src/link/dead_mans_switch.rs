//! The dead-man's switch: the link rests the camera by itself when the run loop does not renew a moving rate in time.

use barrelman_pilot::outcome::RENEWAL_GRACE;
use barrelman_vocab::{Timestamp, VehicleRates};

/// Rates that the run loop requests, in the vehicle's own signs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RequestedRates {
    pub(super) rates: VehicleRates,
    /// The time by which rates that move the camera must be renewed. Without this time they have expired already.
    pub(super) renew_by: Option<Timestamp>,
}

impl RequestedRates {
    /// Rest, which needs no renewal.
    pub(super) const REST: Self = Self { rates: VehicleRates::REST, renew_by: None };

    /// The time at which rates that move the camera expire.
    pub(super) fn expires_at(&self) -> Timestamp {
        self.renew_by.map_or(Timestamp::ZERO, |at| at.plus(RENEWAL_GRACE))
    }
}

/// Replaces expired rates by rest.
#[derive(Debug, Default)]
pub(super) struct DeadMansSwitch {
    has_expired: bool,
}

impl DeadMansSwitch {
    /// The rates that the camera may have at `now`. Logs the begin of each expiry.
    pub(super) fn rates_in_force(&mut self, requested: &RequestedRates, now: Timestamp) -> VehicleRates {
        let has_expired = !requested.rates.is_rest() && requested.expires_at() <= now;
        if has_expired && !self.has_expired {
            tracing::error!("the pilot is held up: the link rests the camera");
        }
        self.has_expired = has_expired;
        if has_expired { VehicleRates::REST } else { requested.rates }
    }
}
