//! Hexadecimal floating-point numbers as C99 writes them (section 6.4.4.2, `%a`): `0x1.8p3` is 12.
//!
//! In: an optional sign, `0x`, hexadecimal digits with at most one point, and an optional `p` with a binary exponent in
//! decimal. Out: the nearest f64, ties to even, also among subnormals. A number that rounds to infinity is refused.

/// Why a text is no such number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum HexFloatError {
    /// It does not follow the grammar.
    Syntax,
    /// It is beyond the largest f64.
    Overflow,
}

/// Whether a text means to be a hexadecimal number.
pub fn is_hex(text: &str) -> bool {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    digits.starts_with("0x") || digits.starts_with("0X")
}

/// Reads a number.
pub fn parse(text: &str) -> Result<f64, HexFloatError> {
    let (negative, rest) = match text.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let [b'0', b'x' | b'X', rest @ ..] = rest else { return Err(HexFloatError::Syntax) };
    let (digits, exponent) = match rest.iter().position(|b| matches!(b, b'p' | b'P')) {
        Some(at) => (&rest[..at], decimal(&rest[at + 1..]).ok_or(HexFloatError::Syntax)?),
        None => (rest, 0),
    };
    let (mantissa, shift, more) = significant(digits).ok_or(HexFloatError::Syntax)?;
    let magnitude = round(mantissa, exponent.saturating_add(shift), more).ok_or(HexFloatError::Overflow)?;
    Ok(if negative { -magnitude } else { magnitude })
}

/// A decimal exponent; beyond what any text can make up for, it saturates.
fn decimal(text: &[u8]) -> Option<i64> {
    let (sign, digits) = match text {
        [b'-', digits @ ..] => (-1, digits),
        [b'+', digits @ ..] => (1, digits),
        digits => (1, digits),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value =
        digits.iter().fold(0i64, |value, digit| value.saturating_mul(10).saturating_add(i64::from(digit - b'0')));
    Some(sign * value)
}

/// The first 16 digits from the first that is not 0, the power of two that they count, and whether any later digit is
/// not 0; `None` unless there is a digit and at most one point.
fn significant(text: &[u8]) -> Option<(u64, i64, bool)> {
    let (mut mantissa, mut shift, mut more) = (0u64, 0, false);
    let (mut digits, mut point) = (0, false);
    for &byte in text {
        if byte == b'.' && !point {
            point = true;
            continue;
        }
        let digit = char::from(byte).to_digit(16)?;
        digits += 1;
        if mantissa >> 60 == 0 {
            mantissa = mantissa << 4 | u64::from(digit);
            shift -= 4 * i64::from(point);
        } else {
            more |= digit != 0;
            shift += 4 * i64::from(!point);
        }
    }
    (digits > 0).then_some((mantissa, shift, more))
}

/// The f64 nearest to `mantissa * 2^exponent`, plus a little if there is `more`; `None` for infinity.
fn round(mantissa: u64, exponent: i64, more: bool) -> Option<f64> {
    if mantissa == 0 {
        return Some(0.0);
    }
    // Bit 63 is the highest bit and counts 2^top.
    let zeros = mantissa.leading_zeros();
    let mantissa = u128::from(mantissa << zeros);
    let top = exponent.saturating_add(63 - i64::from(zeros));
    // A normal number keeps 53 bits; below 2^-1022 each power of two costs one more.
    let lost = (-1022i64).saturating_sub(top).clamp(0, 54) as u32;
    let dropped = 11 + lost;
    let (kept, rest) = (mantissa >> dropped, mantissa & ((1 << dropped) - 1));
    let half = 1 << (dropped - 1);
    let up = rest > half || rest == half && (more || kept & 1 != 0);
    // The highest bit of a normal number adds 1 to the exponent's field, and so does a carry.
    let field = top.clamp(-1022, 1024) + 1022;
    let bits = ((field as u64) << 52) + kept as u64 + u64::from(up);
    let value = f64::from_bits(bits);
    (top <= 1023 && value.is_finite()).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values by the standard library's decimal parser, which is correctly rounded.
    #[test]
    fn known_numbers() {
        for (text, value) in [
            ("0x1.8p3", 12.0),
            ("0x10", 16.0),
            ("0X.8", 0.5),
            ("0xf.", 15.0),
            ("-0x1.999999999999ap-4", -0.1),
            ("+0x1.5555555555555P-2", 1.0 / 3.0),
            ("0x0p0", 0.0),
            ("0x0.0p99999999999999999999", 0.0),
            ("0x1.fffffffffffffp1023", f64::MAX),
            ("0x1p-1022", f64::MIN_POSITIVE),
            ("0x0.fffffffffffffp-1022", f64::from_bits((1 << 52) - 1)),
            ("0x1p-1074", 5e-324),
            ("0x1p-1075", 0.0),
            ("0x1.0000000000000000000000001p-1075", 5e-324),
            ("0x1.8p-1074", 1e-323),
            ("0x1p-1076", 0.0),
            ("0x1p-99999999999999999999", 0.0),
            // Ties to even, and just above a tie.
            ("0x1.00000000000008p0", 1.0),
            ("0x1.00000000000018p0", 1.000_000_000_000_000_4),
            ("0x1.000000000000080000000000000000001p0", 1.000_000_000_000_000_2),
            ("0x1.fffffffffffff8p0", 2.0),
            // Digits before the point beyond the 16 that are kept.
            ("0x10000000000000000000000p-88", 1.0),
            ("0x0.0000000000000000000000001p100", 1.0),
        ] {
            assert_eq!(parse(text).map(f64::to_bits), Ok(value.to_bits()), "{text}");
            assert!(is_hex(text));
        }
        assert_eq!(parse("-0x0").map(f64::to_bits), Ok((-0.0f64).to_bits()));
    }

    #[test]
    fn every_f64_comes_back() {
        let mut bits = 0x9e37_79b9_7f4a_7c15u64;
        for _ in 0..20_000 {
            bits = bits.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
            let x = f64::from_bits(bits);
            if !x.is_finite() {
                continue;
            }
            // As `%a` prints it: subnormal numbers keep the smallest exponent.
            let (sign, field) = (if x.is_sign_negative() { "-" } else { "" }, bits >> 52 & 0x7ff);
            let text = format!(
                "{sign}0x{}.{:013x}p{}",
                u8::from(field > 0),
                bits & ((1 << 52) - 1),
                field.max(1) as i64 - 1023
            );
            assert_eq!(parse(&text).map(f64::to_bits), Ok(bits), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in ["", "0x", "0x.", "0x.p1", "0x1p", "0x1p+", "0x1.2.3", "0xg", "x1", "1", "--0x1", "0x1 ", "0x1p1.5"]
        {
            assert_eq!(parse(text), Err(HexFloatError::Syntax), "{text:?}");
        }
        for text in ["0x1p1024", "-0x1.fffffffffffff8p1023", "0x1p99999999999999999999"] {
            assert_eq!(parse(text), Err(HexFloatError::Overflow), "{text}");
        }
    }
}
