//! The surface of the water for rendering: slopes on three tiles of increasing fineness.
//!
//! Tile 0 carries the waves of the [`Sea`], the same that move the boat, on the sea's own lattice. Tiles 1
//! and 2 carry ripples: random waves with a flat curvature spectrum, `S(k) = B D(angle) / k^4` (the
//! saturation range, as in `elfouhaily1997`), with B such that all slopes together have the variance measured
//! by `cox1954` under this wind. Waves shorter than tile 2's grid are unresolved variance. Each tile is
//! rotated by a different angle, so that the repetition does not show.
//!
//! In each frame, the spectrum at its tick goes through one inverse Fourier transform for both slopes (as
//! real and imaginary part), and tile 0 through two more: elevation with the crests that break now, and
//! crests that broke earlier, from which whitecaps come. Nothing carries over from frame to frame: any tick
//! can be rendered.

use barrelman_simd::{Simd, multiversion};
use barrelman_vocab::rng;

use super::fourier::{Fourier, Map};
use super::phase::sin_cos;
use super::quad_map::{QuadMap, Texel};
use crate::sea::{Sea, Wave, deep_water};

/// Upper bound of a tile's levels.
pub(super) const LEVELS: usize = 16;
/// Ages of earlier crests whose foam is still visible, ticks.
const EARLIER_CREST_TICKS: [u64; 2] = [70, 190];
/// Sea states from this number on have breaking waves.
const MIN_BREAKING_STATE: u8 = 2;
/// Share of the ripples' variance that stays unresolved.
const UNRESOLVED_SHARE: f64 = 0.22;
/// Largest lattice number on a tile of 128.
const MAX_LATTICE: f64 = 58.0;

/// One tile.
#[derive(Debug)]
pub(super) struct WaveTile {
    /// Side, metres.
    pub(super) side_m: f64,
    /// Grid points along the side.
    pub(super) n: usize,
    /// Cosine and sine of the tile's rotation against the world, anticlockwise.
    pub(super) turn: (f64, f64),
    /// Slopes along the world's x and y.
    pub(super) slopes: QuadMap,
    /// Slope of one step of a byte.
    pub(super) slope_step: f32,
    /// Variance of slope along one axis that each level has lost; flat levels have lost all.
    pub(super) lost: [f32; LEVELS],
    /// Levels from here on count as flat.
    pub(super) flat_level: usize,
    spectrum: Spectrum,
    fourier: Fourier,
    maps: [Map; 2],
}

#[derive(Debug)]
enum Spectrum {
    Sea(Box<Swell>),
    Ripples(Ripples),
}

/// Further data of tile 0.
#[derive(Debug)]
pub(super) struct Swell {
    sea: Sea,
    /// Elevation, in steps of `step_m`.
    pub(super) elevation: QuadMap,
    pub(super) step_m: f32,
    /// Elevation on the grid, metres: row by row along the tile's x.
    pub(super) grid_m: Vec<f32>,
    /// Foam of breaking crests, 0 to 127 in the lower byte; `None` where no waves break.
    pub(super) foam: Option<QuadMap>,
    /// Standard deviation of the measure of crests.
    crest_std_dev: f32,
    crests: Vec<f32>,
}

#[derive(Debug, Default)]
struct Ripples {
    /// For each lattice point and its opposite: half amplitude (m), phase and rate.
    ahead: (Vec<f32>, Vec<u32>, Vec<u32>),
    back: (Vec<f32>, Vec<u32>, Vec<u32>),
    /// Wave vector in the world, rad/m.
    vector: (Vec<f32>, Vec<f32>),
}

/// The three tiles of a sea, and the unresolved variance of slope.
pub(super) fn tiles(sea: &Sea, n: usize) -> ([WaveTile; 3], f32) {
    let side = sea.tile_side_m();
    let ratio = libm::sqrt(side / 1.3).clamp(3.6, 9.0);
    let wind = sea.wind();
    let of_swell: f64 = sea
        .waves()
        .iter()
        .map(|wave| {
            let k2 = wave.vector.0 * wave.vector.0 + wave.vector.1 * wave.vector.1;
            0.5 * wave.amplitude * wave.amplitude * k2
        })
        .sum();
    let measured = 0.003 + 0.005_12 * wind.speed_mps;
    let short = (measured - of_swell).max(0.45 * measured);
    let tile = |index: u64| {
        let scale = libm::pow(ratio, index as f64);
        let range = (MAX_LATTICE / ratio, MAX_LATTICE);
        ripples(sea, side / scale, n, index, range, 0.5 * (1.0 - UNRESOLVED_SHARE) * short)
    };
    ([swell(sea, n), tile(1), tile(2)], (0.5 * UNRESOLVED_SHARE * short) as f32)
}

fn swell(sea: &Sea, n: usize) -> WaveTile {
    let mut lost = [0.0_f64; LEVELS];
    let (mut sx2, mut sy2, mut crest2) = (0.0, 0.0, 0.0);
    for wave in sea.waves() {
        let a2 = 0.5 * wave.amplitude * wave.amplitude;
        sx2 += a2 * wave.vector.0 * wave.vector.0;
        sy2 += a2 * wave.vector.1 * wave.vector.1;
        let k2 = wave.vector.0 * wave.vector.0 + wave.vector.1 * wave.vector.1;
        crest2 += a2 * k2;
        add_lost(&mut lost, 0.5 * a2 * k2, (wave.lattice.0, wave.lattice.1), n);
    }
    let significant = sea.state().significant_height_m();
    let (flat_level, lost) = flattened(lost, 0.5 * crest2, n);
    let foam = (sea.state().number() >= MIN_BREAKING_STATE).then(|| QuadMap::new(n));
    WaveTile {
        side_m: sea.tile_side_m(),
        n,
        turn: (1.0, 0.0),
        slopes: QuadMap::new(n),
        slope_step: (4.5 * libm::sqrt(f64::max(sx2, sy2)) / 127.0) as f32,
        lost,
        flat_level,
        spectrum: Spectrum::Sea(Box::new(Swell {
            sea: sea.clone(),
            elevation: QuadMap::new(n),
            step_m: (1.5 * significant / 32_767.0) as f32,
            grid_m: vec![0.0; n * n],
            foam,
            crest_std_dev: libm::sqrt(crest2) as f32,
            crests: vec![0.0; n * n],
        })),
        fourier: Fourier::new(n),
        maps: [Map::zeros(n), Map::zeros(n)],
    }
}

/// Adds what each level loses of a wave's variance; a level averages squares of 2^l grid points.
fn add_lost(lost: &mut [f64; LEVELS], variance: f64, lattice: (i32, i32), n: usize) {
    for (level, slot) in lost.iter_mut().enumerate() {
        let width = (1_u32 << level) as f64 / n as f64;
        let pass = |waves: i32| {
            let x = core::f64::consts::PI * f64::from(waves) * width;
            if level == 0 || x == 0.0 { 1.0 } else { libm::sin(x) / x }
        };
        let kept = pass(lattice.0) * pass(lattice.1);
        *slot += variance * (1.0 - kept * kept);
    }
}

/// A level that keeps less than this share of the variance is flat.
const MIN_KEPT_SHARE: f64 = 0.01;

/// The first flat level, and what each level has lost; `all` is the variance along one axis.
fn flattened(lost: [f64; LEVELS], all: f64, n: usize) -> (usize, [f32; LEVELS]) {
    let coarsest = n.ilog2() as usize;
    let flat = (0..=coarsest).find(|&level| all - lost[level] < MIN_KEPT_SHARE * all).unwrap_or(coarsest);
    let flat_or_lost = |level| if level < flat { lost[level] } else { all } as f32;
    (flat, core::array::from_fn(flat_or_lost))
}

impl Ripples {
    /// Gives each wave its amplitude, scaled, and what runs against it.
    fn set_amplitudes(&mut self, amplitudes: &[f64], scale: f64, n: usize) {
        for (at, amplitude) in amplitudes.iter().enumerate() {
            let (i, j) = (at / n, at % n);
            let opposite = ((n - i) % n) * n + (n - j) % n;
            self.ahead.0.push((0.5 * (scale * amplitude)) as f32);
            self.back.0.push((0.5 * scale * amplitudes[opposite]) as f32);
            self.back.1.push(self.ahead.1[opposite]);
            self.back.2.push(self.ahead.2[opposite]);
        }
    }
}

/// Amplitude of a ripple times the square of its wave number, by its direction from the wind's; the finer
/// tile spreads wider.
fn ripple_amplitude(from_wind: f64, index: u64, random: u64) -> f64 {
    let along = libm::cos(from_wind).max(0.0);
    let spread = along * along + 0.05 + 0.07 * index as f64;
    let u = ((random >> 40) as f64 + 0.5) / 16_777_216.0;
    libm::sqrt(2.0 * spread * -libm::log(u))
}

fn ripples(sea: &Sea, side_m: f64, n: usize, index: u64, range: (f64, f64), variance: f64) -> WaveTile {
    let angle = [0.0, 0.61, -0.47][index as usize % 3];
    let turn = (libm::cos(angle), libm::sin(angle));
    let unit = core::f64::consts::TAU / side_m;
    let wind = sea.wind().towards.radians();
    let wrap_angle = |at: usize| if at <= n / 2 { at as i32 } else { at as i32 - n as i32 };
    let finest = range.1.min(0.46 * n as f64);
    let mut amplitudes = vec![0.0_f64; n * n];
    let mut all = Ripples::default();
    let mut total = 0.0;
    for i in 0..n {
        for j in 0..n {
            let (a, b) = (f64::from(wrap_angle(i)), f64::from(wrap_angle(j)));
            let (x, y) = (unit * (a * turn.0 - b * turn.1), unit * (a * turn.1 + b * turn.0));
            all.vector.0.push(x as f32);
            all.vector.1.push(y as f32);
            let waves = libm::hypot(a, b);
            let k = unit * waves;
            let random = rng::hash(sea.seed(), 0x1A7 + index, (i * n + j) as u64);
            let inside = waves >= range.0 && waves <= finest;
            let towards = libm::atan2(y, x) - wind;
            let amplitude = if inside { ripple_amplitude(towards, index, random) / (k * k) } else { 0.0 };
            amplitudes[i * n + j] = amplitude;
            total += 0.5 * amplitude * amplitude * k * k;
            all.ahead.1.push(random as u32);
            all.ahead.2.push(if k > 0.0 { deep_water(k).1 } else { 0 });
        }
    }
    let scale = libm::sqrt(variance / total.max(1e-12));
    let mut lost = [0.0; LEVELS];
    let (mut sx2, mut sy2) = (0.0, 0.0);
    for i in 0..n {
        for j in 0..n {
            let at = i * n + j;
            let amplitude = scale * amplitudes[at];
            let (x, y) = (f64::from(all.vector.0[at]), f64::from(all.vector.1[at]));
            sx2 += 0.5 * amplitude * amplitude * x * x;
            sy2 += 0.5 * amplitude * amplitude * y * y;
            if amplitude > 0.0 {
                let half = 0.25 * amplitude * amplitude * (x * x + y * y);
                add_lost(&mut lost, half, (wrap_angle(i), wrap_angle(j)), n);
            }
        }
    }
    all.set_amplitudes(&amplitudes, scale, n);
    let (flat_level, lost) = flattened(lost, 0.5 * (sx2 + sy2), n);
    WaveTile {
        side_m,
        n,
        turn,
        slopes: QuadMap::new(n),
        slope_step: (4.0 * libm::sqrt(f64::max(sx2, sy2)) / 127.0) as f32,
        lost,
        flat_level,
        spectrum: Spectrum::Ripples(all),
        fourier: Fourier::new(n),
        maps: [Map::zeros(n), Map::zeros(n)],
    }
}

impl WaveTile {
    /// Advances the tile to a tick.
    pub(super) fn advance(&mut self, simd: Simd, tick: u64) {
        let [map, other] = &mut self.maps;
        match &mut self.spectrum {
            Spectrum::Ripples(ripples) => {
                ripple_spectrum(simd, ripples, tick as u32, map);
            }
            Spectrum::Sea(swell) => {
                add_waves(&swell.sea, self.n, [tick, tick], map, |wave| {
                    [(0.0, wave.vector.0), (0.0, wave.vector.1)]
                });
            }
        }
        self.fourier.inverse(simd, map, other);
        self.slopes.fill(simd, &mut map.re, &mut map.im, Texel::Pair(self.slope_step));
        if let Spectrum::Sea(swell) = &mut self.spectrum {
            swell.advance(simd, self.n, tick, &self.fourier, map, other);
        }
    }

    /// The further data of tile 0.
    pub(super) fn swell(&self) -> Option<&Swell> {
        match &self.spectrum {
            Spectrum::Sea(swell) => Some(swell),
            Spectrum::Ripples(_) => None,
        }
    }
}

impl Swell {
    fn advance(
        &mut self,
        simd: Simd,
        n: usize,
        tick: u64,
        fourier: &Fourier,
        map: &mut Map,
        other: &mut Map,
    ) {
        // The crest measure is the sum of a |k| cos(phase).
        let crest = |wave: &Wave| (libm::hypot(wave.vector.0, wave.vector.1), 0.0);
        add_waves(&self.sea, n, [tick, tick], map, |wave| [(1.0, 0.0), crest(wave)]);
        fourier.inverse(simd, map, other);
        self.grid_m.copy_from_slice(&map.re);
        self.crests.copy_from_slice(&map.im);
        self.elevation.fill(simd, &mut map.re, &mut map.im, Texel::Single(self.step_m));
        let Some(foam) = &mut self.foam else { return };
        let before = EARLIER_CREST_TICKS.map(|ticks| tick.wrapping_sub(ticks));
        add_waves(&self.sea, n, before, map, |wave| [crest(wave), crest(wave)]);
        fourier.inverse(simd, map, other);
        let wind = self.sea.wind().speed_mps as f32;
        // Crests above this many standard deviations break; more of them in stronger wind.
        let threshold = self.crest_std_dev * (3.05 - 0.12 * wind);
        whitecaps(simd, threshold, self.crest_std_dev, &self.crests, &mut map.re, &mut map.im);
        foam.fill(simd, &mut map.re, &mut map.im, Texel::Pair(1.0));
    }
}

/// Writes waves into a spectrum, indexed [i][j]: two real fields, as real and imaginary part of their
/// transform. For each, `fields` gives (c, d) of `a (c cos(phase) - d sin(phase))`, at its own tick.
fn add_waves(sea: &Sea, n: usize, ticks: [u64; 2], map: &mut Map, fields: impl Fn(&Wave) -> [(f64, f64); 2]) {
    map.re.fill(0.0);
    map.im.fill(0.0);
    let wrap = |waves: i32| waves.rem_euclid(n as i32) as usize;
    for wave in sea.waves() {
        let at = wrap(wave.lattice.0) * n + wrap(wave.lattice.1);
        let opposite = wrap(-wave.lattice.0) * n + wrap(-wave.lattice.1);
        for (field, ((c, d), tick)) in fields(wave).into_iter().zip(ticks).enumerate() {
            let (sin, cos) = sin_cos(wave.phase.wrapping_sub(wave.rate.wrapping_mul(tick as u32)));
            let half = 0.5 * wave.amplitude as f32;
            let (c, d) = (half * c as f32, half * d as f32);
            let (re, im) = (c * cos - d * sin, c * sin + d * cos);
            // The second field is multiplied by i; the opposite point has the conjugate before that.
            let (here, there) = if field == 0 { ((re, im), (re, -im)) } else { ((-im, re), (im, re)) };
            map.re[at] += here.0;
            map.im[at] += here.1;
            map.re[opposite] += there.0;
            map.im[opposite] += there.1;
        }
    }
}

multiversion! { simd;
    /// The spectrum of both slopes: `(i kx - ky) H`, with H the spectrum of the elevation.
    fn ripple_spectrum(simd: Simd, ripples: &Ripples, tick: u32, map: &mut Map) {
        let count = map.re.len();
        let (re, im) = (&mut map.re[..count], &mut map.im[..count]);
        let (aa, ap, ar) = (&ripples.ahead.0[..count], &ripples.ahead.1[..count], &ripples.ahead.2[..count]);
        let (ba, bp, br) = (&ripples.back.0[..count], &ripples.back.1[..count], &ripples.back.2[..count]);
        let (kx, ky) = (&ripples.vector.0[..count], &ripples.vector.1[..count]);
        for i in 0..count {
            let (sin, cos) = sin_cos(ap[i].wrapping_sub(ar[i].wrapping_mul(tick)));
            let (sin_back, cos_back) = sin_cos(bp[i].wrapping_sub(br[i].wrapping_mul(tick)));
            let h_re = aa[i] * cos + ba[i] * cos_back;
            let h_im = aa[i] * sin - ba[i] * sin_back;
            re[i] = -ky[i] * h_re - kx[i] * h_im;
            im[i] = kx[i] * h_re - ky[i] * h_im;
        }
    }
}

multiversion! { simd;
    /// Foam from crests now and at two earlier ticks (`first`, `second`): writes its cover, 0 to 127, into
    /// `first`, and its freshness into `second`.
    fn whitecaps(
        simd: Simd,
        threshold: f32,
        std_dev: f32,
        crests: &[f32],
        first: &mut [f32],
        second: &mut [f32],
    ) {
        let per_std_dev = 1.0 / (0.5 * std_dev);
        for i in 0..crests.len().min(first.len()).min(second.len()) {
            let now = ((crests[i] - threshold) * per_std_dev).clamp(0.0, 1.0);
            let a_while_ago = ((first[i] - threshold) * per_std_dev).clamp(0.0, 1.0);
            let long_ago = ((second[i] - threshold) * per_std_dev).clamp(0.0, 1.0);
            let cover = now.max(0.75 * a_while_ago).max(0.5 * long_ago);
            first[i] = 127.0 * cover;
            second[i] = 127.0 * now;
        }
    }
}

#[cfg(test)]
mod tests {
    use barrelman_simd::Simd;
    use barrelman_vocab::Angle;

    use super::tiles;
    use crate::sea::{Sea, SeaState, Wind};

    #[test]
    fn the_grid_shows_the_sea_that_moves_the_boat() {
        for (state, n) in [(0, 128), (1, 256), (3, 128), (4, 128)] {
            let state = SeaState::ALL[state];
            let wind = Wind { speed_mps: state.wind_mps(), towards: Angle::from_degrees(130.0) };
            let sea = Sea::new(state, wind, 17);
            let ([mut tile, _, _], _) = tiles(&sea, n);
            for tick in [0, 1, 777, 100_000_000_003] {
                tile.advance(Simd::widest(), tick);
                let grid = &tile.swell().expect("tile 0 carries the sea").grid_m;
                for (row, column) in [(0, 0), (3, 100), (77, 12), (127, 127)] {
                    let at = |index: usize| index as f64 * tile.side_m / n as f64;
                    let exact = sea.surface_at(at(column), at(row), tick).elevation;
                    let rendered = f64::from(grid[row * n + column]);
                    // Single precision against double: millionths of the wave height.
                    let tolerance = 2e-5 * state.significant_height_m();
                    assert!((rendered - exact).abs() < tolerance, "{state:?} {tick}: {rendered} and {exact}");
                }
            }
        }
    }
}
