//! Angles within a turn.

/// The same angle within -pi to pi, radians.
pub(crate) fn wrapped(radians: f64) -> f64 {
    let turn = core::f64::consts::TAU;
    radians - turn * libm::floor(radians / turn + 0.5)
}
