//! How many zeros a shut-down sends: until telemetry shows that the camera rests.

use core::time::Duration;

use barrelman_vocab::AngularRate;

use crate::session::RestEvidence;

/// Interval between the zeros of the shut-down while telemetry still shows motion.
pub const UNREST_SPACING: Duration = Duration::from_millis(100);
/// Least number of zeros of the shut-down of a camera that rests.
pub const ZEROS_AT_REST: u32 = 3;
/// Least number of zeros of the shut-down of a camera that may be turning: over one second, so that a line
/// that loses half of all packets loses all of them once in 4,096 times. A slow rate is below what telemetry
/// shows as motion.
pub const ZEROS_IN_MOTION: u32 = 12;
/// Largest number of zeros of the shut-down of a camera that may only sway: for two seconds, in which every
/// camera that obeys comes to rest.
pub const MAX_ZEROS: u32 = 22;
/// A camera that turns faster than this does more than to sway with its kite: zeros go on.
pub(crate) const SWAY: AngularRate = AngularRate::from_radians_per_second(0.15);

/// What a shut-down knows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClosingZeros {
    /// Number of zeros that were sent.
    pub(crate) sent: u32,
    /// Least number of zeros.
    pub(crate) least: u32,
    /// The fastest rate at which a camera at rest may seem to turn: [`SWAY`], or none where a gimbal holds
    /// it.
    pub(crate) sway: AngularRate,
    /// What telemetry shows since the first zeros.
    pub(crate) evidence: RestEvidence,
    /// Whether telemetry showed motion, or rest, before.
    pub(crate) has_seen: bool,
    /// Whether nothing was heard since the first zeros, of a vehicle that was heard before or must be heard.
    pub(crate) is_missing: bool,
}

impl ClosingZeros {
    /// Whether the shut-down has to send zeros once more.
    pub(crate) fn needs_more(self) -> bool {
        if self.sent < self.least {
            return true;
        }
        match self.evidence {
            RestEvidence::AtRest => false,
            // A vehicle that reported before, or must answer, has to be heard again: nothing may have reached
            // it.
            _ if self.is_missing => true,
            // The link bounds the time: a vehicle that reports such a motion has not heard the zeros.
            RestEvidence::Moving { rate } if rate > self.sway => true,
            RestEvidence::Moving { .. } => self.sent < MAX_ZEROS,
            RestEvidence::NoTelemetry => self.has_seen && self.sent < MAX_ZEROS,
        }
    }
}
