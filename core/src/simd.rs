//! Which vector instructions the kernels for many rays and many normals use.
//!
//! One source for all widths: kernels are generic over the instruction set, and a [`Level`], which is proof that the
//! machine has it, chooses the copy that runs. Only operations that give the same bits in every lane of every set are used
//! (+ - * / sqrt, comparisons, integers; never a fused or an approximate one), so results do not depend on the level.

use fearless_simd::{Simd, SimdFloat, prelude::*};

/// A set of vector instructions that this machine has.
#[derive(Clone, Copy, Debug)]
pub struct Level(fearless_simd::Level);

impl Level {
    /// Whether there can be any on this target: where there cannot, the kernels are not even linked.
    const POSSIBLE: bool = cfg!(any(
        all(any(target_arch = "x86", target_arch = "x86_64"), target_feature = "sse2"),
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    ));

    /// The level that was asked for, where the target can have one at all.
    #[inline(always)]
    pub(crate) fn possible(level: Option<Level>) -> Option<Level> {
        if Level::POSSIBLE { level } else { None }
    }

    /// The widest set: with feature `std` what the machine has, else what the program is compiled for. `None` if there is
    /// none that pays: on microcontrollers, and with SSE2 alone, which must imitate too much.
    pub fn best() -> Option<Level> {
        let level = fearless_simd::Level::try_detect().unwrap_or(fearless_simd::Level::baseline());
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let pays = level.as_sse4_2().is_some();
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let pays = !level.is_fallback();
        pays.then_some(Level(level))
    }

    /// All sets that kernels can be told to use here, from the narrowest to the widest.
    pub fn all() -> impl Iterator<Item = Level> {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        use fearless_simd::Simd;
        let narrower = |level: fearless_simd::Level| -> [Option<fearless_simd::Level>; 3] {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            return [
                level.as_sse4_2().map(|set| set.level()),
                level.as_avx2().map(|set| set.level()),
                level.as_avx512().map(|set| set.level()),
            ];
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            return [Some(level), None, None];
        };
        Level::best().map(|level| narrower(level.0)).into_iter().flatten().flatten().map(Level)
    }

    /// Its name: `sse4.2`, `avx2`, `avx512`, `neon`, `simd128`.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Sse4_2(_) => "sse4.2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Avx2(_) => "avx2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Avx512(_) => "avx512",
            #[cfg(target_arch = "aarch64")]
            fearless_simd::Level::Neon(_) => "neon",
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            fearless_simd::Level::WasmSimd128(_) => "simd128",
            _ => "none",
        }
    }

    /// What kernels are dispatched by.
    pub(crate) fn token(self) -> fearless_simd::Level {
        self.0
    }
}

/// The smaller of two, lane by lane; `b` if one is NaN. WebAssembly's own minimum keeps NaN, which takes processors seven
/// instructions, and comparing four.
#[inline(always)]
pub(crate) fn least<S: Simd, V: SimdFloat<S>>(a: V, b: V) -> V {
    if cfg!(target_arch = "wasm32") { a.simd_lt(b).select(a, b) } else { a.min(b) }
}

/// The larger of two, lane by lane; `b` if one is NaN.
#[inline(always)]
pub(crate) fn most<S: Simd, V: SimdFloat<S>>(a: V, b: V) -> V {
    if cfg!(target_arch = "wasm32") { a.simd_gt(b).select(a, b) } else { a.max(b) }
}

/// Runs an expression of type `()` with the token of a level's instructions, compiled for each that the target can have.
macro_rules! dispatch {
    ($level:expr, $simd:ident => $kernel:expr) => {{
        // On x86 without vector registers dispatch would compile what LLVM cannot.
        #[cfg(not(all(any(target_arch = "x86", target_arch = "x86_64"), not(target_feature = "sse2"))))]
        fearless_simd::dispatch!($level.token(), $simd => $kernel);
        #[cfg(all(any(target_arch = "x86", target_arch = "x86_64"), not(target_feature = "sse2")))]
        if let fearless_simd::Level::Fallback($simd) = $level.token() {
            $kernel
        }
    }};
}
pub(crate) use dispatch;
