//! Values that follow others with a time constant.

/// Share of a difference that is made up in `seconds` with this time constant, seconds.
pub(super) fn share_in(seconds: f64, time_s: f64) -> f64 {
    1.0 - libm::exp(-seconds / time_s)
}

/// The same in single precision.
pub(super) fn rate_in(seconds: f64, time_s: f64) -> f32 {
    share_in(seconds, time_s) as f32
}
