//! Random numbers by seed, stream and index only ([`barrelman_vocab::rng::hash`]), the same on every machine
//! and in any order.

use barrelman_vocab::rng::{hash, to_unit};

/// Uniform sample in [0, 1).
pub fn unit(seed: u64, stream: u64, index: u64) -> f64 {
    to_unit(hash(seed, stream, index))
}

/// Sample of the standard normal distribution.
pub fn normal(seed: u64, stream: u64, index: u64) -> f64 {
    // Box-Muller transform; the first number lies in (0, 1], so that its logarithm is finite.
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - unit(seed, stream, 2 * index)));
    radius * libm::cos(core::f64::consts::TAU * unit(seed, stream, 2 * index + 1))
}

/// Sample of the exponential distribution of mean 1.
pub fn exponential(seed: u64, stream: u64, index: u64) -> f64 {
    -libm::log(1.0 - unit(seed, stream, index))
}

/// Side of the tile that [`tile`] makes, pixels.
pub const TILE_SIDE: usize = 512;

/// A square, periodic tile of value noise, 0 to 255: cells of `cell` pixels (a divisor of [`TILE_SIDE`]) and
/// two finer octaves.
pub fn tile(seed: u64, cell: usize) -> Vec<u8> {
    let octaves = [(cell, 0.57), ((cell / 2).max(1), 0.29), ((cell / 4).max(1), 0.14)];
    let value = |cell: usize, octave: u64, column: usize, row: usize| {
        let cells = TILE_SIDE / cell;
        unit(seed, octave, ((row % cells) * cells + column % cells) as u64)
    };
    let mut samples = Vec::with_capacity(TILE_SIDE * TILE_SIDE);
    for y in 0..TILE_SIDE {
        for x in 0..TILE_SIDE {
            let mut sum = 0.0;
            for (octave, (cell, weight)) in octaves.iter().enumerate() {
                let (column, row) = (x / cell, y / cell);
                let ease = |t: f64| t * t * (3.0 - 2.0 * t);
                let fx = ease((x % cell) as f64 / *cell as f64);
                let fy = ease((y % cell) as f64 / *cell as f64);
                let at = |dx: usize, dy: usize| value(*cell, octave as u64, column + dx, row + dy);
                let upper = at(0, 0) * (1.0 - fx) + at(1, 0) * fx;
                let lower = at(0, 1) * (1.0 - fx) + at(1, 1) * fx;
                sum += weight * (upper * (1.0 - fy) + lower * fy);
            }
            samples.push((sum * 255.0) as u8);
        }
    }
    samples
}
