//! Paints in red, green and blue, and their samples (BT.709, limited range).

use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::video::ColourMatrix;

use super::script::TargetPaint;

/// Y, U and V as samples, not yet rounded.
pub(super) type Yuv = [f32; 3];

/// From gamma-coded red, green and blue of 0..=255.
pub(super) fn yuv(rgb: [f64; 3]) -> Yuv {
    let [r, g, b] = rgb.map(|sample| sample / 255.0);
    let weights = ColourMatrix::Bt709.luma_weights();
    let y = weights.red * r + weights.green * g + weights.blue * b;
    let u = 128.0 + 224.0 * (b - y) / weights.cb_divisor();
    let v = 128.0 + 224.0 * (r - y) / weights.cr_divisor();
    [(16.0 + 219.0 * y) as f32, u as f32, v as f32]
}

/// The same colour under light of another brightness.
pub(super) fn lit(colour: Yuv, gain: f32) -> Yuv {
    let [y, u, v] = colour;
    [16.0 + (y - 16.0) * gain, 128.0 + (u - 128.0) * gain, 128.0 + (v - 128.0) * gain]
}

/// Red, green and blue of the hull, slightly different each time.
pub(super) fn hull(paint: TargetPaint, rng: &mut SplitMix64) -> [f64; 3] {
    let (rgb, spread) = match paint {
        TargetPaint::Red => ([190.0, 38.0, 40.0], 14.0),
        TargetPaint::Orange => ([226.0, 104.0, 32.0], 14.0),
        TargetPaint::White => ([222.0, 224.0, 222.0], 6.0),
        TargetPaint::Grey => ([128.0, 132.0, 136.0], 6.0),
    };
    rgb.map(|sample| sample + rng.between(-spread, spread))
}

/// Paints that differ from the hull's colour: hues at least 50 degrees from red and orange; beside hulls
/// without a hue, paints with one.
pub(super) const OTHER_PAINTS: [[f64; 3]; 5] = [
    [38.0, 78.0, 160.0],
    [150.0, 196.0, 60.0],
    [40.0, 120.0, 70.0],
    [30.0, 130.0, 150.0],
    [70.0, 60.0, 130.0],
];

/// Wood and stone: grey beside hulls with a hue, brown beside hulls without.
pub(super) fn timber(paint: TargetPaint) -> [f64; 3] {
    match paint {
        TargetPaint::Red | TargetPaint::Orange => [104.0, 108.0, 98.0],
        TargetPaint::White | TargetPaint::Grey => [112.0, 84.0, 56.0],
    }
}
