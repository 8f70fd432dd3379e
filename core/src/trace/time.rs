//! When a ray crosses a plane, and which of two crossings comes first: exactly.
//!
//! A crossing's time is the real number `(k - o) / d` for the plane k and one axis of the ray's origin and direction. Its
//! f64 value carries three roundings, so it is off by at most `3.01 * 2^-53` of itself; two values that are further apart
//! than a bound on both errors are in the right order ([`Clock::SLACK`]). The rest is decided by the sign of
//! `(k - o) d' - (k' - o') d`, summed without rounding in a fixed-point number that holds every product of two f64
//! (Kulisch 1971). The bound needs no absolute epsilon; where it could fail (numbers near the ends of the f64 range) it is
//! infinite, and every order is decided exactly.

use core::cmp::Ordering;

/// A time along a ray as a fraction: `(plane - origin) / dir`. A plain time t is `(t - 0) / 1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Time {
    pub plane: f64,
    pub origin: f64,
    pub dir: f64,
}

impl Time {
    pub(super) fn plain(t: f64) -> Time {
        Time { plane: t, origin: 0.0, dir: 1.0 }
    }

    /// The exact order of two finite times.
    #[cold]
    #[inline(never)]
    pub(super) fn cmp(&self, other: &Time) -> Ordering {
        let mut sum = Sum::ZERO;
        sum.add(self.plane, other.dir, false);
        sum.add(self.origin, other.dir, true);
        sum.add(other.plane, self.dir, true);
        sum.add(other.origin, self.dir, false);
        let order = sum.sign();
        if (self.dir < 0.0) != (other.dir < 0.0) { order.reverse() } else { order }
    }

    /// The time as f64, to within one unit in the last place.
    pub(super) fn value(&self) -> f64 {
        // The difference with its rounding error (two-sum), divided with the remainder put back once.
        let (a, b) = (self.plane, -self.origin);
        let high = a + b;
        let bb = high - a;
        let low = (a - (high - bb)) + (b - bb);
        let q = high / self.dir;
        let remainder = exact_remainder(high, q, self.dir) + low;
        let corrected = q + remainder / self.dir;
        // Near the ends of the range the correction itself under- or overflows.
        if corrected.is_finite() { corrected } else { q }
    }
}

/// `a - q b` for `q` near `a / b`, exact where nothing under- or overflows (two-product by Dekker's split).
fn exact_remainder(a: f64, q: f64, b: f64) -> f64 {
    let split = |x: f64| {
        let c = 134_217_729.0 * x;
        let high = c - (c - x);
        (high, x - high)
    };
    let p = q * b;
    let ((qh, ql), (bh, bl)) = (split(q), split(b));
    let error = ((qh * bh - p) + qh * bl + ql * bh) + ql * bl;
    (a - p) - error
}

/// A fixed-point number with room for sums of products of any f64: bit 0 weighs 2^-2148.
struct Sum {
    words: [u64; Sum::WORDS],
    negative: [u64; Sum::WORDS],
}

impl Sum {
    /// Products reach from 2^-2148 to 2^2048; four of them need two bits more.
    const WORDS: usize = 66;
    const ZERO: Sum = Sum { words: [0; Sum::WORDS], negative: [0; Sum::WORDS] };

    /// Adds `a b`, or subtracts it.
    fn add(&mut self, a: f64, b: f64, minus: bool) {
        let (ma, ea) = parts(a);
        let (mb, eb) = parts(b);
        let product = u128::from(ma) * u128::from(mb);
        if product == 0 {
            return;
        }
        // Positive and negative terms are summed apart, so that only carries run, never borrows.
        let sum = if (a < 0.0) ^ (b < 0.0) ^ minus { &mut self.negative } else { &mut self.words };
        let shift = ea + eb;
        let (word, bit) = ((shift / 64) as usize, shift % 64);
        let low = (product as u64) as u128;
        let high = product >> 64;
        let mut pieces = [0u64; 3];
        let shifted = low << bit;
        pieces[0] = shifted as u64;
        let middle = (shifted >> 64) + (high << bit);
        pieces[1] = middle as u64;
        pieces[2] = (middle >> 64) as u64;
        let mut carry = false;
        for (i, slot) in sum[word..].iter_mut().enumerate() {
            let piece = pieces.get(i).copied().unwrap_or(0);
            if i >= 3 && !carry {
                break;
            }
            let (s, c1) = slot.overflowing_add(piece);
            let (s, c2) = s.overflowing_add(u64::from(carry));
            *slot = s;
            carry = c1 | c2;
        }
    }

    /// The order of the positive and the negative terms' sums.
    fn sign(&self) -> Ordering {
        self.words.iter().rev().cmp(self.negative.iter().rev())
    }
}

/// Mantissa and exponent of a finite number's size: `|x| = m 2^(e - 1074)`, `e` 0 to 2045.
fn parts(x: f64) -> (u64, u32) {
    let bits = x.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as u32;
    let fraction = bits & ((1 << 52) - 1);
    if exponent == 0 { (fraction, 0) } else { (fraction | 1 << 52, exponent - 1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_that_cancel_to_one_unit_are_seen() {
        // (2^52 + 1)^2 against 2^104 + 2^53 + 1: the last bit decides.
        let a = 4_503_599_627_370_497.0;
        let mut sum = Sum::ZERO;
        sum.add(a, a, false);
        sum.add(2f64.powi_exact(104), 1.0, true);
        sum.add(2f64.powi_exact(53), 1.0, true);
        assert_eq!(sum.sign(), Ordering::Greater);
        sum.add(1.0, 1.0, true);
        assert_eq!(sum.sign(), Ordering::Equal);
        sum.add(5e-324, 5e-324, true);
        assert_eq!(sum.sign(), Ordering::Less);
        sum.add(f64::MAX, f64::MAX, false);
        assert_eq!(sum.sign(), Ordering::Greater);
    }

    trait PowiExact {
        fn powi_exact(self, n: i32) -> f64;
    }
    impl PowiExact for f64 {
        fn powi_exact(self, n: i32) -> f64 {
            (0..n).fold(1.0, |x, _| x * self)
        }
    }

    #[test]
    fn times_are_ordered_across_signs() {
        let time = |plane, origin, dir| Time { plane, origin, dir };
        assert_eq!(time(1.0, 0.0, 3.0).cmp(&time(-1.0, 0.0, -3.0)), Ordering::Equal);
        assert_eq!(time(1.0, 0.0, 3.0).cmp(&Time::plain(1.0 / 3.0)), Ordering::Greater);
        assert_eq!(time(1.0, 1e-320, 1.0).cmp(&Time::plain(1.0)), Ordering::Less);
        assert_eq!(time(3.0, 2.5, -5e-324).cmp(&time(3.0, 2.5, -1e300)), Ordering::Less);
    }
}
