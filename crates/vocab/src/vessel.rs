//! Commands to a vessel.

/// The commanded throttle and rudder of a vessel. The signs are independent of the vehicle's own; the vehicle boundary
/// applies those.
///
/// ```
/// use barrelman_vocab::VesselCommand;
///
/// let command = VesselCommand { throttle: f64::NAN, rudder: 1.7 }.clamped();
/// assert_eq!(command, VesselCommand { throttle: 0.0, rudder: 1.0 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VesselCommand {
    /// -1 (full astern) to 1 (full ahead).
    pub throttle: f64,
    /// -1 (full left) to 1 (full right).
    pub rudder: f64,
}

impl VesselCommand {
    /// No thrust, rudder amidships.
    pub const NEUTRAL: Self = Self { throttle: 0.0, rudder: 0.0 };

    /// Whether both are zero.
    pub fn is_neutral(self) -> bool {
        self.throttle == 0.0 && self.rudder == 0.0
    }

    /// Both clamped to -1..=1. NaN becomes 0: an invalid command must not move a vessel.
    #[must_use]
    pub const fn clamped(self) -> Self {
        const fn share(value: f64) -> f64 {
            if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) }
        }
        Self { throttle: share(self.throttle), rudder: share(self.rudder) }
    }
}
