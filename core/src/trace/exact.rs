//! Sums of products of f64 without rounding, and quotients with one.
//!
//! [`Sum`] is a fixed-point number wide enough for every product of two f64 (Kulisch 1971), so that the sign of a sum of
//! products is exact for any finite numbers, subnormal or huge. Slow (some 100 ns), and asked only where f64 cannot tell.

use core::cmp::Ordering;

/// Products of two numbers between these neither under- nor overflow, and neither do their rounding errors.
pub(super) const TINY: f64 = f64::from_bits((1023 - 400) << 52); // 2^-400
pub(super) const HUGE: f64 = f64::from_bits((1023 + 400) << 52); // 2^400

/// `(a - b) / d`, to within one unit in the last place: the difference with its rounding error (two-sum), divided, with
/// the remainder put back once.
pub(super) fn quotient(a: f64, b: f64, d: f64) -> f64 {
    let high = a - b;
    let bb = high - a;
    let low = (a - (high - bb)) - (b + bb);
    let q = high / d;
    // Near the ends of the range the correction itself under- or overflows.
    let tame = |x: f64| x.abs() >= TINY && x.abs() <= HUGE;
    if tame(high) && tame(q) && tame(d) { q + (exact_remainder(high, q, d) + low) / d } else { q }
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
pub(super) struct Sum {
    positive: [u64; Sum::WORDS],
    negative: [u64; Sum::WORDS],
}

impl Sum {
    /// Products reach from 2^-2148 to 2^2048; four of them need two bits more.
    const WORDS: usize = 66;
    pub(super) const ZERO: Sum = Sum { positive: [0; Sum::WORDS], negative: [0; Sum::WORDS] };

    /// Adds `a b`; both are finite.
    pub(super) fn add(&mut self, a: f64, b: f64) {
        let (ma, ea) = parts(a);
        let (mb, eb) = parts(b);
        let product = u128::from(ma) * u128::from(mb);
        if product == 0 {
            return;
        }
        // Positive and negative terms are summed apart, so that only carries run, never borrows.
        let sum = if (a < 0.0) != (b < 0.0) { &mut self.negative } else { &mut self.positive };
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
    pub(super) fn sign(&self) -> Ordering {
        self.positive.iter().rev().cmp(self.negative.iter().rev())
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
        sum.add(a, a);
        sum.add(-two_to(104), 1.0);
        sum.add(-two_to(53), 1.0);
        assert_eq!(sum.sign(), Ordering::Greater);
        sum.add(-1.0, 1.0);
        assert_eq!(sum.sign(), Ordering::Equal);
        sum.add(-5e-324, 5e-324);
        assert_eq!(sum.sign(), Ordering::Less);
        sum.add(f64::MAX, f64::MAX);
        assert_eq!(sum.sign(), Ordering::Greater);
    }

    fn two_to(n: i32) -> f64 {
        (0..n).fold(1.0, |x, _| x * 2.0)
    }

    #[test]
    fn quotients_are_rounded_once() {
        // The difference alone would round to 1.
        assert_eq!(quotient(1.0, 1e-17, 1.0), 1.0);
        assert_eq!(quotient(1.0, 1e-17, 1e-300), (1.0 - 1e-17) / 1e-300);
        assert_eq!(quotient(3.0, 0.1, 0.7), 2.9 / 0.7);
        assert_eq!(quotient(2.0, 3.0, -0.5), 2.0);
        assert_eq!(quotient(1.0, 0.0, 5e-324), f64::INFINITY);
    }
}
