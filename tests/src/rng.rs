//! A seeded generator of numbers: splitmix64 (Steele, Lea and Flood 2014), and the draws that the tests need.
//!
//! In: a seed. Out: the same sequence on every target, without a dependency whose next version would change it.

/// A sequence of random numbers.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// The sequence of a seed; every seed is good.
    pub fn new(seed: u64) -> Rng {
        Rng(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        crate::table::splitmix(self.0)
    }

    /// A uniform integer of `0..n`; the bias of at most n / 2^64 is no matter here.
    pub fn below(&mut self, n: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(n)) >> 64) as u64
    }

    /// A uniform integer of `lo..=hi`.
    pub fn between(&mut self, lo: i64, hi: i64) -> i64 {
        lo + self.below((hi - lo) as u64 + 1) as i64
    }

    /// A uniform multiple of 2^-53 of `0..1`.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A uniform number of `lo..hi`.
    pub fn uniform(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// A number of either sign and of a uniform exponent `lo..=hi`, so that every magnitude gets its share
    /// (pbrt's `pExp`, shapes_test.cpp, in powers of two).
    pub fn spread(&mut self, lo: i64, hi: i64) -> f64 {
        let sign = if self.bits() & 1 == 0 { 1.0 } else { -1.0 };
        let exponent = self.between(lo, hi);
        sign * (1.0 + self.unit()) * libm::scalbn(1.0, exponent as i32)
    }

    /// A direction, uniform in the cube; never zero.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let d = [(); 3].map(|()| self.uniform(-1.0, 1.0));
            if d != [0.0; 3] {
                return d;
            }
        }
    }

    /// A permutation of the slice (Fisher and Yates).
    pub fn shuffle<T>(&mut self, slice: &mut [T]) {
        for i in (1..slice.len()).rev() {
            slice.swap(i, self.below(i as u64 + 1) as usize);
        }
    }

    /// One of the slice's elements.
    pub fn pick<T: Copy>(&mut self, slice: &[T]) -> T {
        slice[self.below(slice.len() as u64) as usize]
    }
}
