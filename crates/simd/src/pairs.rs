//! Sums of products of pairs of 16-bit integers: the inner loop of a convolution in integers.
//!
//! The only kernel of this crate. The x86 instruction for it (`pmaddwd`) multiplies twice as many values as
//! one in single precision does, and compilers do not find it in scalar source where a weight is multiplied
//! with a row. Where the machine has VNNI, one instruction multiplies and adds. Integers give the same sums
//! everywhere.

use crate::Simd;
#[cfg(any(test, not(target_arch = "x86_64")))]
use crate::SimdLevel;

/// Columns of a row.
pub const COLUMNS: usize = 16;
/// Outputs of a block.
pub const OUTPUTS: usize = 8;

/// Two integers that are multiplied with two others, and whose products are added.
pub type Pair = [i16; 2];

/// The sums of a row: for each output of a block, those of all columns.
pub type RowSums = [[i32; COLUMNS]; OUTPUTS];

/// Sums, for each row and column and each output of a block, the products of weights and inputs. Tap by tap,
/// `starts` gives the place in `map` from which the [`COLUMNS`] inputs of the first row are read, and
/// `weights` the weights of the block. The inputs of the next row lie `stride` places further.
///
/// A sum beyond 32 bits wraps around: the caller limits the values.
///
/// # Panics
/// If `weights` and `starts` differ in length, or a row ends outside `map`.
pub fn sum_pair_products(
    simd: Simd,
    weights: &[[Pair; OUTPUTS]],
    map: &[Pair],
    starts: &[usize],
    stride: usize,
    sums: &mut [RowSums],
) {
    assert_eq!(weights.len(), starts.len(), "a block of weights for each tap");
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a `Simd` of a level exists only if the machine supports it, and VNNI is detected.
    #[allow(unsafe_code)]
    unsafe {
        x86::Instructions::of(simd).sum(weights, map, starts, stride, sums);
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let (SimdLevel::Baseline | SimdLevel::Avx2 | SimdLevel::Avx512) = simd.level();
        sum_plainly(weights, map, starts, stride, sums);
    }
}

/// The same in scalar source.
#[cfg(any(test, not(target_arch = "x86_64")))]
fn sum_plainly(
    weights: &[[Pair; OUTPUTS]],
    map: &[Pair],
    starts: &[usize],
    stride: usize,
    sums: &mut [RowSums],
) {
    for (row, sums) in sums.iter_mut().enumerate() {
        *sums = [[0; COLUMNS]; OUTPUTS];
        for (&start, weights) in starts.iter().zip(weights) {
            let line = &map[start + row * stride..][..COLUMNS];
            for (sums, weight) in sums.iter_mut().zip(weights) {
                let [first, second] = weight.map(i32::from);
                for x in 0..COLUMNS {
                    let products = [i32::from(line[x][0]) * first, i32::from(line[x][1]) * second];
                    sums[x] = sums[x].wrapping_add(products[0]).wrapping_add(products[1]);
                }
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use core::arch::x86_64::*;

    use super::{COLUMNS, OUTPUTS, Pair, RowSums};
    use crate::{Simd, SimdLevel};

    /// The instructions of a level. VNNI (vector neural network instructions) multiplies and adds at once.
    #[derive(Debug, Clone, Copy)]
    pub(super) enum Instructions {
        Sse2,
        Avx2,
        Avx2Vnni,
        Avx512,
        Avx512Vnni,
    }

    impl Instructions {
        /// The fastest ones that the machine supports at this level. The detection is cached.
        pub(super) fn of(simd: Simd) -> Self {
            use std::arch::is_x86_feature_detected as has;
            match simd.level() {
                SimdLevel::Baseline => Self::Sse2,
                SimdLevel::Avx2 if has!("avxvnni") => Self::Avx2Vnni,
                SimdLevel::Avx2 => Self::Avx2,
                SimdLevel::Avx512 if has!("avx512vnni") => Self::Avx512Vnni,
                SimdLevel::Avx512 => Self::Avx512,
            }
        }

        /// The sums of all rows.
        ///
        /// # Safety
        /// The machine supports these instructions.
        #[allow(unsafe_code)]
        pub(super) unsafe fn sum(
            self,
            weights: &[[Pair; OUTPUTS]],
            map: &[Pair],
            starts: &[usize],
            stride: usize,
            sums: &mut [RowSums],
        ) {
            // SAFETY: what the caller guarantees.
            unsafe {
                match self {
                    Self::Sse2 => sse2(weights, map, starts, stride, sums),
                    Self::Avx2 => avx2(weights, map, starts, stride, sums),
                    Self::Avx2Vnni => avx2_vnni(weights, map, starts, stride, sums),
                    Self::Avx512 => avx512(weights, map, starts, stride, sums),
                    Self::Avx512Vnni => avx512_vnni(weights, map, starts, stride, sums),
                }
            }
        }
    }

    /// A function for one set of vector instructions: the type of a register, the number of pairs in one, how
    /// many outputs are summed up at once and over how many registers of a row, and the instructions. A
    /// weight is read for each of those registers together; as many totals as that takes stay in registers,
    /// because their loops have constant bounds.
    macro_rules! level {
        (
            $features:literal $name:ident: $register:ty, $pairs:literal pairs, $outputs:literal outputs of $registers:literal,
            $zero:ident, $load:ident, $store:ident, $splat:ident, $accumulate:expr
        ) => {
            #[target_feature(enable = $features)]
            pub(super) fn $name(
                weights: &[[Pair; OUTPUTS]],
                map: &[Pair],
                starts: &[usize],
                stride: usize,
                sums: &mut [RowSums],
            ) {
                const WIDTH: usize = $pairs * $registers;
                const { assert!(OUTPUTS.is_multiple_of($outputs) && COLUMNS.is_multiple_of(WIDTH)) };
                for (row, sums) in sums.iter_mut().enumerate() {
                    for column in (0..COLUMNS).step_by(WIDTH) {
                        let from = row * stride + column;
                        for first in (0..OUTPUTS).step_by($outputs) {
                            let mut totals = [[$zero(); $registers]; $outputs];
                            for (weights, &start) in weights.iter().zip(starts) {
                                let line = &map[from + start..][..WIDTH];
                                let parts: &[[Pair; $pairs]] = line.as_chunks().0;
                                let weights = &weights[first..][..$outputs];
                                let mut registers = [$zero(); $registers];
                                for r in 0..$registers {
                                    // SAFETY: the part holds as many bytes as the register; the load needs no
                                    // alignment.
                                    #[allow(unsafe_code)]
                                    let register: $register = unsafe { $load(parts[r].as_ptr().cast()) };
                                    registers[r] = register;
                                }
                                for k in 0..$outputs {
                                    let weight = $splat(joined(weights[k]));
                                    for r in 0..$registers {
                                        totals[k][r] = $accumulate(totals[k][r], registers[r], weight);
                                    }
                                }
                            }
                            for k in 0..$outputs {
                                let parts: &mut [[i32; $pairs]] = sums[first + k][column..].as_chunks_mut().0;
                                for r in 0..$registers {
                                    // SAFETY: as for the load.
                                    #[allow(unsafe_code)]
                                    unsafe {
                                        $store(parts[r].as_mut_ptr().cast(), totals[k][r])
                                    };
                                }
                            }
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
        "sse2" sse2: __m128i, 4 pairs, 8 outputs of 1,
        _mm_setzero_si128, _mm_loadu_si128, _mm_storeu_si128, _mm_set1_epi32,
        |sum, line, weight| _mm_add_epi32(sum, _mm_madd_epi16(line, weight))
    }
    level! {
        "avx2" avx2: __m256i, 8 pairs, 4 outputs of 2,
        _mm256_setzero_si256, _mm256_loadu_si256, _mm256_storeu_si256, _mm256_set1_epi32,
        |sum, line, weight| _mm256_add_epi32(sum, _mm256_madd_epi16(line, weight))
    }
    level! {
        "avx2,avxvnni" avx2_vnni: __m256i, 8 pairs, 4 outputs of 2,
        _mm256_setzero_si256, _mm256_loadu_si256, _mm256_storeu_si256, _mm256_set1_epi32,
        |sum, line, weight| _mm256_dpwssd_avx_epi32(sum, line, weight)
    }
    level! {
        "avx2,avx512f,avx512bw,avx512dq,avx512vl" avx512: __m512i, 16 pairs, 8 outputs of 1,
        _mm512_setzero_si512, _mm512_loadu_si512, _mm512_storeu_si512, _mm512_set1_epi32,
        |sum, line, weight| _mm512_add_epi32(sum, _mm512_madd_epi16(line, weight))
    }
    level! {
        "avx2,avx512f,avx512bw,avx512dq,avx512vl,avx512vnni" avx512_vnni: __m512i, 16 pairs, 8 outputs of 1,
        _mm512_setzero_si512, _mm512_loadu_si512, _mm512_storeu_si512, _mm512_set1_epi32,
        |sum, line, weight| _mm512_dpwssd_epi32(sum, line, weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map, places in it and a block of weights for each.
    fn example() -> (Vec<Pair>, Vec<usize>, Vec<[Pair; OUTPUTS]>) {
        let mut state = 7_u32;
        let mut pair = || -> Pair {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [(state >> 16) as u16 as i16, (state.rotate_left(9) >> 16) as u16 as i16]
        };
        let map = (0..300).map(|_| pair()).collect();
        let starts = vec![0, 3, 40, 41, 244, 17, 99];
        let weights = starts.iter().map(|_| core::array::from_fn(|_| pair())).collect();
        (map, starts, weights)
    }

    #[test]
    fn the_scalar_source_sums_products() {
        let (map, starts, weights) = example();
        let mut sums = [[[1; COLUMNS]; OUTPUTS]; 3];
        sum_plainly(&weights, &map, &starts, 20, &mut sums);
        let by_hand = starts.iter().zip(&weights).fold(0_i32, |sum, (start, weights)| {
            let (weight, input) = (weights[5].map(i32::from), map[start + 2 * 20 + 9].map(i32::from));
            sum.wrapping_add(weight[0] * input[0]).wrapping_add(weight[1] * input[1])
        });
        assert_eq!(sums[2][5][9], by_hand);
    }

    #[test]
    fn every_level_gives_the_sums_of_the_scalar_source() {
        let (map, starts, weights) = example();
        let mut expected = [[[1; COLUMNS]; OUTPUTS]; 3];
        sum_plainly(&weights, &map, &starts, 20, &mut expected);
        for simd in SimdLevel::ALL.map(Simd::at_most) {
            let mut sums = [[[1; COLUMNS]; OUTPUTS]; 3];
            sum_pair_products(simd, &weights, &map, &starts, 20, &mut sums);
            assert_eq!(sums, expected, "{}", simd.level());
        }
    }

    // A machine with VNNI uses it at a level. The other instructions of that level give the same sums.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn the_instructions_before_vnni_give_the_same_sums() {
        use super::x86::Instructions;

        let (map, starts, weights) = example();
        let mut expected = [[[1; COLUMNS]; OUTPUTS]; 3];
        sum_plainly(&weights, &map, &starts, 20, &mut expected);
        for (level, instructions) in
            [(SimdLevel::Avx2, Instructions::Avx2), (SimdLevel::Avx512, Instructions::Avx512)]
        {
            if Simd::widest().level() < level {
                continue;
            }
            let mut sums = [[[1; COLUMNS]; OUTPUTS]; 3];
            // SAFETY: the machine supports the level.
            #[allow(unsafe_code)]
            unsafe {
                instructions.sum(&weights, &map, &starts, 20, &mut sums);
            }
            assert_eq!(sums, expected, "{instructions:?}");
        }
    }

    #[test]
    #[should_panic(expected = "a block of weights for each tap")]
    fn missing_weights_are_refused() {
        sum_pair_products(Simd::BASELINE, &[], &[[0; 2]; COLUMNS], &[0], 0, &mut [[[0; COLUMNS]; OUTPUTS]]);
    }
}
