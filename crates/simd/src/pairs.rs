//! Sums of products of pairs of 16-bit integers: the inner loop of a convolution in integers.
//!
//! The only kernel of this crate. The x86 instruction for it (`pmaddwd`) multiplies twice as many values as one in single
//! precision does, and compilers do not find it in scalar source where a weight is multiplied with a row. Integers give the
//! same sums at every level.

use crate::{Simd, SimdLevel};

/// Columns of a row.
pub const COLUMNS: usize = 16;
/// The number of outputs must be a multiple of this.
pub const OUTPUTS: usize = 8;

/// Two integers that are multiplied with two others, and whose products are added.
pub type Pair = [i16; 2];

/// Sums, for each output and each column, the products of weights and inputs. Tap by tap, `starts` gives the place in
/// `map` from which a row of [`COLUMNS`] inputs is read, and `weights` the weights of all outputs.
///
/// A sum beyond 32 bits wraps around: the caller limits the values.
///
/// # Panics
/// If the number of outputs, `sums.len()`, is not a multiple of [`OUTPUTS`], or a row ends outside `map`.
pub fn sum_pair_products(
    simd: Simd,
    weights: &[Pair],
    map: &[Pair],
    starts: &[usize],
    sums: &mut [[i32; COLUMNS]],
) {
    assert!(sums.len().is_multiple_of(OUTPUTS), "{} outputs are not a multiple of {OUTPUTS}", sums.len());
    #[cfg(target_arch = "x86_64")]
    match simd.level() {
        // SAFETY: every x86-64 machine has SSE2.
        #[allow(unsafe_code)]
        SimdLevel::Baseline => unsafe { x86::sse2(weights, map, starts, sums) },
        // SAFETY: a `Simd` of this level exists only if the machine supports it.
        #[allow(unsafe_code)]
        SimdLevel::Avx2 => unsafe { x86::avx2(weights, map, starts, sums) },
        // SAFETY: as above.
        #[allow(unsafe_code)]
        SimdLevel::Avx512 => unsafe { x86::avx512(weights, map, starts, sums) },
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let (SimdLevel::Baseline | SimdLevel::Avx2 | SimdLevel::Avx512) = simd.level();
        sum_plainly(weights, map, starts, sums);
    }
}

/// The same in scalar source.
#[cfg(any(test, not(target_arch = "x86_64")))]
fn sum_plainly(weights: &[Pair], map: &[Pair], starts: &[usize], sums: &mut [[i32; COLUMNS]]) {
    let outputs = sums.len();
    sums.fill([0; COLUMNS]);
    for (&start, weights) in starts.iter().zip(weights.chunks_exact(outputs)) {
        let line = &map[start..][..COLUMNS];
        for (sums, weight) in sums.iter_mut().zip(weights) {
            let [first, second] = weight.map(i32::from);
            for x in 0..COLUMNS {
                let products = [i32::from(line[x][0]) * first, i32::from(line[x][1]) * second];
                sums[x] = sums[x].wrapping_add(products[0]).wrapping_add(products[1]);
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use core::arch::x86_64::*;

    use super::{COLUMNS, OUTPUTS, Pair};

    /// A function for one set of vector instructions: the type of a register, the number of pairs in one, and the instructions.
    /// The totals of eight outputs are separate variables, since an array of them would be kept in memory.
    macro_rules! level {
        (
            $features:literal $name:ident: $register:ty, $pairs:literal pairs,
            $zero:ident, $load:ident, $store:ident, $splat:ident, $multiply:ident, $add:ident
        ) => {
            #[target_feature(enable = $features)]
            pub(super) fn $name(
                weights: &[Pair],
                map: &[Pair],
                starts: &[usize],
                sums: &mut [[i32; COLUMNS]],
            ) {
                let outputs = sums.len();
                for (block, sums) in sums.as_chunks_mut::<OUTPUTS>().0.iter_mut().enumerate() {
                    for column in (0..COLUMNS).step_by($pairs) {
                        let [mut a, mut b, mut c, mut d, mut e, mut f, mut g, mut h] = [$zero(); OUTPUTS];
                        for (tap, &start) in starts.iter().enumerate() {
                            let line: &[Pair] = &map[start..][..COLUMNS][column..][..$pairs];
                            // SAFETY: the slice holds as many bytes as the register; the load needs no alignment.
                            #[allow(unsafe_code)]
                            let line: $register = unsafe { $load(line.as_ptr().cast()) };
                            let weights: &[Pair] = &weights[tap * outputs + block * OUTPUTS..][..OUTPUTS];
                            a = $add(a, $multiply(line, $splat(joined(weights[0]))));
                            b = $add(b, $multiply(line, $splat(joined(weights[1]))));
                            c = $add(c, $multiply(line, $splat(joined(weights[2]))));
                            d = $add(d, $multiply(line, $splat(joined(weights[3]))));
                            e = $add(e, $multiply(line, $splat(joined(weights[4]))));
                            f = $add(f, $multiply(line, $splat(joined(weights[5]))));
                            g = $add(g, $multiply(line, $splat(joined(weights[6]))));
                            h = $add(h, $multiply(line, $splat(joined(weights[7]))));
                        }
                        for (sums, total) in sums.iter_mut().zip([a, b, c, d, e, f, g, h]) {
                            let part: &mut [i32] = &mut sums[column..][..$pairs];
                            // SAFETY: as for the load.
                            #[allow(unsafe_code)]
                            unsafe {
                                $store(part.as_mut_ptr().cast(), total)
                            };
                        }
                    }
                }
            }
        };
    }

    /// A pair in 32 bits, the first integer in the lower half.
    #[inline(always)]
    fn joined([first, second]: Pair) -> i32 {
        i32::from(second) << 16 | i32::from(first) & 0xffff
    }

    level! {
        "sse2" sse2: __m128i, 4 pairs,
        _mm_setzero_si128, _mm_loadu_si128, _mm_storeu_si128, _mm_set1_epi32, _mm_madd_epi16, _mm_add_epi32
    }
    level! {
        "avx2" avx2: __m256i, 8 pairs,
        _mm256_setzero_si256, _mm256_loadu_si256, _mm256_storeu_si256, _mm256_set1_epi32, _mm256_madd_epi16, _mm256_add_epi32
    }
    level! {
        "avx2,avx512f,avx512bw,avx512dq,avx512vl" avx512: __m512i, 16 pairs,
        _mm512_setzero_si512, _mm512_loadu_si512, _mm512_storeu_si512, _mm512_set1_epi32, _mm512_madd_epi16, _mm512_add_epi32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_gives_the_sums_of_the_scalar_source() {
        let mut state = 7_u32;
        let mut pair = || -> Pair {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [(state >> 16) as u16 as i16, (state.rotate_left(9) >> 16) as u16 as i16]
        };
        let map: Vec<Pair> = (0..300).map(|_| pair()).collect();
        let starts = [0, 3, 40, 41, 284, 17, 99];
        for outputs in [8, 24, 48] {
            let weights: Vec<Pair> = (0..outputs * starts.len()).map(|_| pair()).collect();
            let mut expected = vec![[1; COLUMNS]; outputs];
            sum_plainly(&weights, &map, &starts, &mut expected);
            let by_hand = starts.iter().enumerate().fold(0_i32, |sum, (tap, &start)| {
                let (weight, input) =
                    (weights[tap * outputs + 5].map(i32::from), map[start + 9].map(i32::from));
                sum.wrapping_add(weight[0] * input[0]).wrapping_add(weight[1] * input[1])
            });
            assert_eq!(expected[5][9], by_hand);
            for simd in SimdLevel::ALL.map(Simd::at_most) {
                let mut sums = vec![[1; COLUMNS]; outputs];
                sum_pair_products(simd, &weights, &map, &starts, &mut sums);
                assert_eq!(sums, expected, "{}, {outputs} outputs", simd.level());
            }
        }
    }

    #[test]
    #[should_panic(expected = "12 outputs are not a multiple of 8")]
    fn other_numbers_of_outputs_are_refused() {
        sum_pair_products(Simd::BASELINE, &[], &[], &[], &mut [[0; COLUMNS]; 12]);
    }
}
