//! The simulation's fixed time step.

/// Ticks of simulated time per second.
pub const TICKS_PER_SECOND: u32 = 120;
/// Duration of a tick, seconds.
pub const TICK_S: f64 = 1.0 / TICKS_PER_SECOND as f64;

/// Share of the difference to its input that a first-order lag closes in one tick. `lag_s` is the time
/// constant, seconds; without lag the share is 1.
pub(crate) fn lag_share(lag_s: f64) -> f64 {
    if lag_s > 0.0 { 1.0 - libm::exp(-TICK_S / lag_s) } else { 1.0 }
}
