//! Exact rationals, just enough for the ray oracle: from f64, difference, quotient, order, floor, and back to f64.
//!
//! Fractions are not reduced: the oracles divide at most twice in a row, and a comparison multiplies across anyway.

use core::cmp::Ordering;

use num_bigint::{BigInt, Sign};
use num_traits::{Signed, ToPrimitive, Zero};

/// A rational number.
#[derive(Clone, Debug)]
pub struct Rational {
    num: BigInt,
    /// Greater than 0.
    den: BigInt,
}

impl Rational {
    /// `num / den`; `den` must not be 0.
    pub fn new(num: BigInt, den: BigInt) -> Rational {
        assert!(!den.is_zero(), "a fraction over zero");
        if den.is_negative() { Rational { num: -num, den: -den } } else { Rational { num, den } }
    }

    /// The number that the float is; `None` if it is NaN or infinite.
    pub fn from_f64(x: f64) -> Option<Rational> {
        if !x.is_finite() {
            return None;
        }
        let exponent = (x.to_bits() >> 52 & 0x7ff) as i64;
        let fraction = (x.to_bits() & ((1 << 52) - 1)) as i64;
        // Subnormals have no hidden bit and the exponent of the smallest normal numbers.
        let (mantissa, exponent) =
            if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
        let zeros = if mantissa == 0 { 0 } else { i64::from(mantissa.trailing_zeros()) };
        let (mantissa, exponent) = (mantissa >> zeros, exponent + zeros);
        let mantissa = BigInt::from(if x.is_sign_negative() { -mantissa } else { mantissa });
        let power = BigInt::from(1) << exponent.unsigned_abs();
        Some(if exponent >= 0 { Rational::new(mantissa * power, 1.into()) } else { Rational::new(mantissa, power) })
    }

    /// The nearest f64, ties to even; infinite beyond the largest.
    pub fn to_f64(&self) -> f64 {
        let magnitude = self.num.abs();
        if magnitude.is_zero() {
            return 0.0;
        }
        // The quotient lies in 2^(bits-1) .. 2^(bits+1): start with the finer unit and take the coarser if 53 bits do
        // not hold it.
        let bits = magnitude.bits() as i64 - self.den.bits() as i64;
        let mut unit = (bits - 53).max(-1074);
        let (quotient, rest, divisor) = loop {
            let (n, d) = if unit < 0 {
                (&magnitude << unit.unsigned_abs(), self.den.clone())
            } else {
                (magnitude.clone(), &self.den << unit.unsigned_abs())
            };
            let q = (&n / &d).to_u64().expect("at most 55 bits");
            if q < 1 << 53 {
                break (q, n - &d * q, d);
            }
            unit += 1;
        };
        let rounded = match (&rest + &rest).cmp(&divisor) {
            Ordering::Less => quotient,
            Ordering::Equal => quotient + (quotient & 1),
            Ordering::Greater => quotient + 1,
        };
        if unit > 971 {
            return if self.num.is_negative() { f64::NEG_INFINITY } else { f64::INFINITY };
        }
        // Both factors are floats and so is the product, so that the multiplication is exact.
        let unit = if unit >= -1022 {
            f64::from_bits(((unit + 1023) as u64) << 52)
        } else {
            f64::from_bits(1 << (unit + 1074))
        };
        let value = rounded as f64 * unit;
        if self.num.is_negative() { -value } else { value }
    }

    /// -1, 0 or 1.
    pub fn sign(&self) -> i32 {
        match self.num.sign() {
            Sign::Minus => -1,
            Sign::NoSign => 0,
            Sign::Plus => 1,
        }
    }

    /// `self * factor`.
    pub fn times(&self, factor: &Rational) -> Rational {
        Rational::new(&self.num * &factor.num, &self.den * &factor.den)
    }

    /// `self / divisor`.
    pub fn over(&self, divisor: &Rational) -> Rational {
        Rational::new(&self.num * &divisor.den, &self.den * &divisor.num)
    }

    /// `self + other`.
    pub fn plus(&self, other: &Rational) -> Rational {
        Rational::new(&self.num * &other.den + &other.num * &self.den, &self.den * &other.den)
    }

    /// `k - self`.
    pub fn from_int(&self, k: i64) -> Rational {
        Rational { num: k * &self.den - &self.num, den: self.den.clone() }
    }

    /// The greatest integer not above it; `None` beyond i64.
    pub fn floor(&self) -> Option<i64> {
        let q = &self.num / &self.den;
        let below = self.num.is_negative() && &q * &self.den != self.num;
        (q - i32::from(below)).to_i64()
    }

    /// The least integer not below it; `None` beyond i64.
    pub fn ceil(&self) -> Option<i64> {
        let negated = Rational { num: -&self.num, den: self.den.clone() };
        Some(-negated.floor()?)
    }

    /// Without its sign.
    pub fn abs(&self) -> Rational {
        Rational { num: self.num.abs(), den: self.den.clone() }
    }
}

impl From<i64> for Rational {
    fn from(k: i64) -> Rational {
        Rational { num: k.into(), den: 1.into() }
    }
}

impl Ord for Rational {
    fn cmp(&self, other: &Rational) -> Ordering {
        match self.sign().cmp(&other.sign()) {
            Ordering::Equal => (&self.num * &other.den).cmp(&(&other.num * &self.den)),
            decided => decided,
        }
    }
}

impl PartialOrd for Rational {
    fn partial_cmp(&self, other: &Rational) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Rational {
    fn eq(&self, other: &Rational) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Rational {}
