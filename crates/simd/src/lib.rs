//! Function multiversioning: loops compiled for several sets of vector instructions, with bit-identical
//! results.
//!
//! A function inside [`multiversion!`] is compiled from the same scalar source for the target's baseline, for
//! AVX2 and for AVX-512. No version fuses a multiplication with an addition or changes the order of a sum.
//! All versions therefore round alike, provided that the source uses only `+ - * / sqrt`, comparisons,
//! truncation and integers: no `mul_add` and no transcendental functions of the standard library.
//!
//! A [`Simd`] selects the version. It is obtained only by detecting the machine's features, so that owning
//! one proves that the call is sound. The `unsafe` blocks of the project's arithmetic are in the macro and in
//! [`sum_pair_products`]; a crate that uses the macro declares `deny(unsafe_code)` instead of `forbid`.
//!
//! This crate does not contain kernels or intrinsics but for [`sum_pair_products`], nor dispatch for other
//! architectures. ARM uses the baseline, which includes NEON.
#![deny(unsafe_code)]

use core::fmt;
use core::str::FromStr;

mod pairs;

pub use pairs::{COLUMNS, OUTPUTS, Pair, RowSums, sum_pair_products};

/// Sets of vector instructions, narrowest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SimdLevel {
    /// Available on every machine of the target: SSE2 on x86-64, NEON on ARM.
    Baseline,
    /// 256-bit vectors of x86-64.
    Avx2,
    /// 512-bit vectors of x86-64: F, BW, DQ and VL.
    Avx512,
}

impl SimdLevel {
    /// All levels, narrowest first.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Baseline => "scalar",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        })
    }
}

/// The name of a level is not one of `scalar`, `sse2`, `avx2` and `avx512`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnknownSimdLevel;

impl fmt::Display for UnknownSimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("not one of scalar, sse2, avx2 and avx512")
    }
}

impl core::error::Error for UnknownSimdLevel {}

impl FromStr for SimdLevel {
    type Err = UnknownSimdLevel;

    fn from_str(name: &str) -> Result<Self, UnknownSimdLevel> {
        match name {
            "scalar" | "sse2" => Ok(Self::Baseline),
            "avx2" => Ok(Self::Avx2),
            "avx512" => Ok(Self::Avx512),
            _ => Err(UnknownSimdLevel),
        }
    }
}

/// A level that this machine supports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Simd(SimdLevel);

impl Simd {
    /// The level that every machine supports.
    pub const BASELINE: Self = Self(SimdLevel::Baseline);

    /// The widest level that this machine supports. The detection is cached; later calls cost a load.
    #[inline]
    pub fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") {
                let wider = has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl");
                return Self(if wider { SimdLevel::Avx512 } else { SimdLevel::Avx2 });
            }
        }
        Self::BASELINE
    }

    /// The widest level that this machine supports, not wider than `cap`.
    pub fn at_most(cap: SimdLevel) -> Self {
        Self(cap.min(Self::widest().0))
    }

    /// The level.
    #[inline(always)]
    pub const fn level(self) -> SimdLevel {
        self.0
    }
}

/// Compiles a free function without a result for each level. The expression before the function gives the
/// [`Simd`] to use; it may refer to the function's arguments.
///
/// ```
/// use barrelman_simd::{Simd, multiversion};
///
/// multiversion! { simd;
///     /// Doubles every value.
///     fn double(simd: Simd, values: &mut [f32]) {
///         values.iter_mut().for_each(|value| *value *= 2.0);
///     }
/// }
///
/// let mut values = [1.0, 2.5];
/// double(Simd::widest(), &mut values);
/// assert_eq!(values, [2.0, 5.0]);
/// ```
#[macro_export]
macro_rules! multiversion {
    ($simd:expr; $(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $ty:ty),* $(,)?) $body:block) => {
        $(#[$meta])*
        #[allow(unused_variables)]
        $vis fn $name($($arg: $ty),*) {
            #[inline(always)]
            #[allow(clippy::too_many_arguments)]
            fn plain($($arg: $ty),*) $body
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                #[allow(clippy::too_many_arguments)]
                fn avx2($($arg: $ty),*) {
                    plain($($arg),*);
                }
                #[target_feature(enable = "avx2,avx512f,avx512bw,avx512dq,avx512vl")]
                #[allow(clippy::too_many_arguments)]
                fn avx512($($arg: $ty),*) {
                    plain($($arg),*);
                }
                let simd: $crate::Simd = $simd;
                match simd.level() {
                    $crate::SimdLevel::Baseline => {}
                    // SAFETY: a `Simd` of this level exists only if the machine supports it.
                    #[allow(unsafe_code)]
                    $crate::SimdLevel::Avx2 => return unsafe { avx2($($arg),*) },
                    // SAFETY: as above.
                    #[allow(unsafe_code)]
                    $crate::SimdLevel::Avx512 => return unsafe { avx512($($arg),*) },
                }
            }
            plain($($arg),*);
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    multiversion! { simd;
        #[cfg(target_arch = "x86_64")]
        fn mix(simd: Simd, values: &mut [f32]) {
            for value in values {
                *value = (*value * 1.7 + 0.3) / (*value + 2.0).sqrt();
            }
        }
    }

    // On other architectures there is one level only.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn every_level_of_the_machine_gives_the_same_bits() {
        let run = |simd| {
            let mut values: Vec<f32> = (0..1000).map(|i| i as f32 * 0.37).collect();
            mix(simd, &mut values);
            values.into_iter().map(f32::to_bits).collect::<Vec<_>>()
        };
        let baseline = run(Simd::BASELINE);
        let wider = SimdLevel::ALL.into_iter().map(Simd::at_most).filter(|&simd| simd > Simd::BASELINE);
        let mut compared = 0;
        for simd in wider {
            assert_eq!(run(simd), baseline, "{}", simd.level());
            compared += 1;
        }
        assert!(
            compared > 0,
            "nothing compared: this machine supports the baseline only; run on one with AVX2"
        );
    }

    #[test]
    fn a_cap_is_never_exceeded() {
        for level in SimdLevel::ALL {
            assert!(Simd::at_most(level).level() <= level);
        }
        assert_eq!(Simd::at_most(SimdLevel::Avx512), Simd::widest());
    }

    #[test]
    fn names_are_read_and_written() {
        for level in SimdLevel::ALL {
            assert_eq!(level.to_string().parse(), Ok(level));
        }
        assert_eq!("sse2".parse(), Ok(SimdLevel::Baseline));
        assert_eq!("neon".parse::<SimdLevel>(), Err(UnknownSimdLevel));
    }
}
