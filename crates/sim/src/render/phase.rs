//! Sine and cosine of a phase in turns of 2^32, by polynomials: the same bits everywhere.

/// Sine and cosine of `turns / 2^32` turns, to 2e-6.
///
/// The phase is folded into the quarter turn about the nearest multiple of a half turn, where the Taylor
/// series of the sine to x^9 and of the cosine to x^10 are used.
#[inline(always)]
pub(super) fn sin_cos(turns: u32) -> (f32, f32) {
    // Nearest half turn, and what is left of it, in -1/4..1/4 turn.
    let half = turns.wrapping_add(0x4000_0000) & 0x8000_0000;
    let x = (turns.wrapping_sub(half) as i32) as f32 * (core::f32::consts::TAU / 4_294_967_296.0);
    let y = x * x;
    let sin = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5_040.0 + y * (1.0 / 362_880.0)))));
    let cos = 1.0
        + y * (-0.5
            + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0 + y * (-1.0 / 3_628_800.0)))));
    // A half turn changes both signs.
    (f32::from_bits(sin.to_bits() ^ half), f32::from_bits(cos.to_bits() ^ half))
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    #[test]
    fn is_the_sine_and_the_cosine() {
        for step in 0..10_000_u32 {
            let turns = step.wrapping_mul(429_497);
            let exact = libm::sincos(f64::from(turns) * core::f64::consts::TAU / 4_294_967_296.0);
            let (sin, cos) = sin_cos(turns);
            assert!((f64::from(sin) - exact.0).abs() < 5e-6, "{turns}: {sin} and {}", exact.0);
            assert!((f64::from(cos) - exact.1).abs() < 5e-6, "{turns}: {cos} and {}", exact.1);
        }
    }
}
