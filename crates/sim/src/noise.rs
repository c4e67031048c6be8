//! Random numbers from an integer hash: a function of seed, stream and index only, the same on every machine and in
//! any order.
//!
//! The hash is the finaliser of SplitMix64 (Steele, Lea and Flood, 2014) over the sum of the seed and odd multiples
//! of stream and index.

/// A well-mixed 64-bit number for a seed, a stream and an index.
pub fn hash(seed: u64, stream: u64, index: u64) -> u64 {
    let mut z = seed
        .wrapping_add(stream.wrapping_mul(0x9E37_79B9_7F4A_7C15))
        .wrapping_add(index.wrapping_mul(0xD1B5_4A32_D192_ED03));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Uniform sample in [0, 1).
pub fn unit(seed: u64, stream: u64, index: u64) -> f64 {
    (hash(seed, stream, index) >> 11) as f64 / (1_u64 << 53) as f64
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

/// A square, periodic tile of value noise, 0 to 255: cells of `cell` pixels (a divisor of [`TILE_SIDE`]) and two
/// finer octaves.
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
