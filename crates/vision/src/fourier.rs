//! Two-dimensional Fourier transform of small square maps, with the same bits on every machine.
//!
//! The side is a power of two, [`SIDE`]. Both directions are radix-2 passes over whole rows: each pass is a
//! loop over independent columns, which the compiler can vectorise without changing a bit. The forward
//! transform decimates in frequency; its output is transposed and in bit-reversed order along both
//! dimensions. The inverse transform expects that order. Products of spectra, value by value, do not depend
//! on the order.
//!
//! Two real maps share one complex transform, as its real and imaginary parts. [`Fourier::forward_pair`]
//! separates them by the symmetry of the spectra of real maps.

use crate::simd::simd_kernel;

/// Side of a map, values.
pub(crate) const SIDE: usize = 32;
/// Number of values in a map.
pub(crate) const AREA: usize = SIDE * SIDE;

/// A real map, row by row.
pub(crate) type Map = [f32; AREA];

/// A complex number: real and imaginary part; as a twiddle factor, cosine and sine.
type Complex = (f32, f32);

/// Hann window over a map: 1 at the centre, 0 at the border, where shifts wrap around.
pub(crate) fn hann_window() -> Box<Map> {
    let hann = |k: usize| 0.5 - 0.5 * libm::cos(core::f64::consts::TAU * (k as f64 + 0.5) / SIDE as f64);
    let mut window: Box<Map> = Box::new([0.0; AREA]);
    for (index, value) in window.iter_mut().enumerate() {
        *value = (hann(index / SIDE) * hann(index % SIDE)) as f32;
    }
    window
}

/// The spectrum of a map, in the order given by [`Fourier::forward_pair`].
#[derive(Debug, Clone)]
pub(crate) struct Spectrum {
    pub(crate) re: Box<Map>,
    pub(crate) im: Box<Map>,
}

impl Default for Spectrum {
    fn default() -> Self {
        Self { re: Box::new([0.0; AREA]), im: Box::new([0.0; AREA]) }
    }
}

/// Twiddle factors and buffers of the transform.
#[derive(Debug, Clone)]
pub(crate) struct Fourier {
    /// cos and sin of -2 pi k / SIDE, for k below SIDE / 2.
    twiddle: [Complex; SIDE / 2],
    work: Spectrum,
}

impl Fourier {
    pub(crate) fn new() -> Self {
        let mut twiddle = [(0.0, 0.0); SIDE / 2];
        for (k, factor) in twiddle.iter_mut().enumerate() {
            let angle = -core::f64::consts::TAU * k as f64 / SIDE as f64;
            *factor = (libm::cos(angle) as f32, libm::sin(angle) as f32);
        }
        Self { twiddle, work: Spectrum::default() }
    }

    /// Computes the spectra of two real maps.
    pub(crate) fn forward_pair(&mut self, maps: (&Map, &Map), spectra: (&mut Spectrum, &mut Spectrum)) {
        forward_pair(self, maps, spectra);
    }

    /// Computes the two real maps that have these spectra.
    pub(crate) fn inverse_pair(&mut self, spectra: (&Spectrum, &Spectrum), maps: (&mut Map, &mut Map)) {
        inverse_pair(self, spectra, maps);
    }

    /// Computes the real map that has this spectrum.
    pub(crate) fn inverse(&mut self, spectrum: &Spectrum, map: &mut Map) {
        inverse(self, spectrum, map);
    }
}

simd_kernel! {
fn forward_pair(fourier: &mut Fourier, maps: (&Map, &Map), spectra: (&mut Spectrum, &mut Spectrum)) {
    fourier.work.re.copy_from_slice(maps.0);
    fourier.work.im.copy_from_slice(maps.1);
    decimate_in_frequency(&fourier.twiddle, &mut fourier.work);
    transpose(&mut fourier.work.re);
    transpose(&mut fourier.work.im);
    decimate_in_frequency(&fourier.twiddle, &mut fourier.work);
    let (first, second) = spectra;
    let Spectrum { re, im } = &fourier.work;
    for row in 0..SIDE {
        let (here, mirror) = (row * SIDE, negative(row) * SIDE);
        let (z_re, z_im) = (&re[here..][..SIDE], &im[here..][..SIDE]);
        let (n_re, n_im) = (negated(&re[mirror..][..SIDE]), negated(&im[mirror..][..SIDE]));
        let (first_re, first_im) = (&mut first.re[here..][..SIDE], &mut first.im[here..][..SIDE]);
        let (second_re, second_im) = (&mut second.re[here..][..SIDE], &mut second.im[here..][..SIDE]);
        for column in 0..SIDE {
            first_re[column] = 0.5 * (z_re[column] + n_re[column]);
            first_im[column] = 0.5 * (z_im[column] - n_im[column]);
            second_re[column] = 0.5 * (z_im[column] + n_im[column]);
            second_im[column] = 0.5 * (n_re[column] - z_re[column]);
        }
    }
}
}

/// Position of the negative frequency, in bit-reversed order: from each power of two to the next, the order
/// is reversed.
#[inline(always)]
fn negative(position: usize) -> usize {
    match position.checked_ilog2() {
        None => 0,
        Some(power) => (3 << power) - 1 - position,
    }
}

/// A row of a spectrum with each value at the position of its negative frequency.
#[inline(always)]
fn negated(row: &[f32]) -> [f32; SIDE] {
    let mut out = [row[0]; SIDE];
    let mut from = 1;
    while from < SIDE {
        for k in from..2 * from {
            out[k] = row[3 * from - 1 - k];
        }
        from *= 2;
    }
    out
}

simd_kernel! {
fn inverse_pair(fourier: &mut Fourier, spectra: (&Spectrum, &Spectrum), maps: (&mut Map, &mut Map)) {
    let (first, second) = spectra;
    for position in 0..AREA {
        fourier.work.re[position] = first.re[position] - second.im[position];
        fourier.work.im[position] = first.im[position] + second.re[position];
    }
    invert(fourier);
    let scale = 1.0 / AREA as f32;
    for position in 0..AREA {
        maps.0[position] = fourier.work.re[position] * scale;
        maps.1[position] = fourier.work.im[position] * scale;
    }
}
}

simd_kernel! {
fn inverse(fourier: &mut Fourier, spectrum: &Spectrum, map: &mut Map) {
    fourier.work.re.copy_from_slice(&spectrum.re[..]);
    fourier.work.im.copy_from_slice(&spectrum.im[..]);
    invert(fourier);
    let scale = 1.0 / AREA as f32;
    for (value, &work) in map.iter_mut().zip(fourier.work.re.iter()) {
        *value = work * scale;
    }
}
}

#[inline(always)]
fn invert(fourier: &mut Fourier) {
    decimate_in_time(&fourier.twiddle, &mut fourier.work);
    transpose(&mut fourier.work.re);
    transpose(&mut fourier.work.im);
    decimate_in_time(&fourier.twiddle, &mut fourier.work);
}

#[inline(always)]
/// Forward transform along the columns: natural order in, bit-reversed order out.
fn decimate_in_frequency(twiddle: &[Complex; SIDE / 2], data: &mut Spectrum) {
    let mut half = SIDE / 2;
    while half > 0 {
        combine_rows(twiddle, data, half, forward_butterfly);
        half /= 2;
    }
}

#[inline(always)]
/// Inverse transform along the columns: bit-reversed order in, natural order out; not divided by the side.
fn decimate_in_time(twiddle: &[Complex; SIDE / 2], data: &mut Spectrum) {
    let mut half = 1;
    while half < SIDE {
        combine_rows(twiddle, data, half, inverse_butterfly);
        half *= 2;
    }
}

#[inline(always)]
/// One pass over all rows: the butterfly combines each row with the row `half` rows below.
fn combine_rows(
    twiddle: &[Complex; SIDE / 2],
    data: &mut Spectrum,
    half: usize,
    butterfly: impl Fn(Complex, Complex, Complex) -> (Complex, Complex),
) {
    let stride = SIDE / (2 * half);
    for (re, im) in data.re.chunks_exact_mut(2 * half * SIDE).zip(data.im.chunks_exact_mut(2 * half * SIDE)) {
        let ((a_re, b_re), (a_im, b_im)) = (re.split_at_mut(half * SIDE), im.split_at_mut(half * SIDE));
        for k in 0..half {
            let factor = twiddle[k * stride];
            let rows = k * SIDE..(k + 1) * SIDE;
            let (a_re, a_im) = (&mut a_re[rows.clone()], &mut a_im[rows.clone()]);
            let (b_re, b_im) = (&mut b_re[rows.clone()], &mut b_im[rows]);
            for column in 0..SIDE {
                let (a, b) = butterfly((a_re[column], a_im[column]), (b_re[column], b_im[column]), factor);
                (a_re[column], a_im[column]) = a;
                (b_re[column], b_im[column]) = b;
            }
        }
    }
}

#[inline(always)]
fn forward_butterfly(a: Complex, b: Complex, (cos, sin): Complex) -> (Complex, Complex) {
    let difference = (a.0 - b.0, a.1 - b.1);
    let turned = (difference.0 * cos - difference.1 * sin, difference.0 * sin + difference.1 * cos);
    ((a.0 + b.0, a.1 + b.1), turned)
}

#[inline(always)]
/// With the conjugate factor.
fn inverse_butterfly(a: Complex, b: Complex, (cos, sin): Complex) -> (Complex, Complex) {
    let turned = (b.0 * cos + b.1 * sin, b.1 * cos - b.0 * sin);
    ((a.0 + turned.0, a.1 + turned.1), (a.0 - turned.0, a.1 - turned.1))
}

#[inline(always)]
fn transpose(map: &mut Map) {
    for row in 0..SIDE {
        for column in row + 1..SIDE {
            map.swap(row * SIDE + column, column * SIDE + row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(seed: u32) -> Box<Map> {
        let mut state = seed;
        let mut map = Box::new([0.0; AREA]);
        for value in map.iter_mut() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *value = (state >> 8) as f32 / 16_777_216.0 - 0.5;
        }
        map
    }

    /// Frequency of a position along one dimension, in the order of the forward transform.
    fn frequency(position: usize) -> usize {
        position.reverse_bits() >> (usize::BITS - SIDE.trailing_zeros())
    }

    /// One value of the spectrum by definition: `across` waves to the right, `down` waves downwards.
    fn by_definition(map: &Map, across: usize, down: usize) -> (f64, f64) {
        let (mut re, mut im) = (0.0, 0.0);
        for (index, &value) in map.iter().enumerate() {
            let waves = (down * (index / SIDE) + across * (index % SIDE)) % SIDE;
            let angle = -core::f64::consts::TAU * waves as f64 / SIDE as f64;
            re += f64::from(value) * libm::cos(angle);
            im += f64::from(value) * libm::sin(angle);
        }
        (re, im)
    }

    fn forward(maps: [&Map; 2]) -> [Spectrum; 2] {
        let [mut first, mut second] = [Spectrum::default(), Spectrum::default()];
        Fourier::new().forward_pair((maps[0], maps[1]), (&mut first, &mut second));
        [first, second]
    }

    #[test]
    fn both_spectra_of_a_pair_are_what_the_definition_gives() {
        let maps = [map(1), map(2)];
        let spectra = forward([&maps[0], &maps[1]]);
        for (map, spectrum) in maps.iter().zip(&spectra) {
            // Every third position covers all rows and columns.
            for position in (0..AREA).step_by(3) {
                // Transposed: a row of the spectrum is a frequency to the right.
                let (across, down) = (frequency(position / SIDE), frequency(position % SIDE));
                let (re, im) = by_definition(map, across, down);
                let (seen_re, seen_im) = (f64::from(spectrum.re[position]), f64::from(spectrum.im[position]));
                assert!((seen_re - re).abs() < 1e-4, "{across},{down}: {seen_re} against {re}");
                assert!((seen_im - im).abs() < 1e-4, "{across},{down}: {seen_im} against {im}");
            }
        }
    }

    fn assert_close(seen: &Map, expected: &Map) {
        for (index, (seen, expected)) in seen.iter().zip(expected).enumerate() {
            // Single precision over ten passes of values up to 0.5.
            assert!((seen - expected).abs() < 1e-6, "{index}: {seen} against {expected}");
        }
    }

    #[test]
    fn a_map_comes_back_from_its_spectrum_alone_and_as_one_of_a_pair() {
        let maps = [map(3), map(4)];
        let [first, second] = forward([&maps[0], &maps[1]]);
        let mut fourier = Fourier::new();
        let (mut a, mut b) = (map(5), map(6));
        fourier.inverse_pair((&first, &second), (&mut a, &mut b));
        assert_close(&a, &maps[0]);
        assert_close(&b, &maps[1]);
        fourier.inverse(&second, &mut a);
        assert_close(&a, &maps[1]);
    }

    #[test]
    fn a_map_does_not_change_the_spectrum_of_the_other_one_of_its_pair() {
        let zero = [0.0; AREA];
        let [alone, nothing] = forward([&map(7), &zero]);
        assert!(nothing.re.iter().chain(nothing.im.iter()).all(|value| value.abs() < 1e-5));
        let [beside, _] = forward([&map(7), &map(8)]);
        for index in 0..AREA {
            assert!((alone.re[index] - beside.re[index]).abs() < 1e-4);
            assert!((alone.im[index] - beside.im[index]).abs() < 1e-4);
        }
    }
}
