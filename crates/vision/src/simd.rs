//! Vector kernels: the crate's binding of `barrelman-simd`.
//!
//! A function inside [`simd_kernel!`] is compiled for each vector level from the same scalar source, with
//! bit-identical results, and runs at the widest level of the machine. The tests compare all levels.

/// Compiles free functions for each vector level and runs them at [`level`].
macro_rules! simd_kernel {
    ($($function:tt)*) => { barrelman_simd::multiversion! { crate::simd::level(); $($function)* } };
}
pub(crate) use simd_kernel;

/// The level of the kernels: the widest of the machine.
#[cfg(not(test))]
#[inline(always)]
pub(crate) fn level() -> barrelman_simd::Simd {
    barrelman_simd::Simd::widest()
}

/// The level of the kernels in a test: the widest up to the cap of this thread.
#[cfg(test)]
pub(crate) fn level() -> barrelman_simd::Simd {
    barrelman_simd::Simd::at_most(LEVEL_CAP.get())
}

#[cfg(test)]
thread_local! {
    static LEVEL_CAP: core::cell::Cell<barrelman_simd::SimdLevel> =
        const { core::cell::Cell::new(barrelman_simd::SimdLevel::Avx512) };
}

// On other architectures there is one level only.
#[cfg(all(test, target_arch = "x86_64"))]
mod tests;
