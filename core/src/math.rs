//! The few float helpers that every stage shares. Only `+ - * /`, square roots and `libm`: the same bits on every
//! target. Vectors are plain arrays at every public border; `glam` stays inside.

/// Square root of `x`; correctly rounded, hence the same bits with hardware (`std`) and without.
#[inline]
pub fn sqrt(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrt(x)
}

/// Square root of `x` in single precision; correctly rounded.
#[inline]
pub fn sqrt_f32(x: f32) -> f32 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrtf(x)
}

/// Component-wise `a - b`.
#[inline]
pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + b * s`.
#[inline]
pub fn add_scaled(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}

/// Dot product, summed in the order x, y, z.
#[inline]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cross product.
#[inline]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a` at unit length; `None` if it is zero or not finite.
///
/// Scaled by the largest component first, so that neither tiny nor huge vectors under- or overflow.
#[inline]
pub fn normalize(a: [f64; 3]) -> Option<[f64; 3]> {
    // Compared, not by `max`, which is a call of libm in wasm. A NaN may be dropped, so the components are asked one by one.
    let size = a.map(f64::abs);
    let larger = if size[0] < size[1] { size[1] } else { size[0] };
    let largest = if larger < size[2] { size[2] } else { larger };
    if largest == 0.0 || !(a[0].is_finite() && a[1].is_finite() && a[2].is_finite()) {
        return None;
    }
    let b = [a[0] / largest, a[1] / largest, a[2] / largest];
    let length = sqrt(dot(b, b));
    Some([b[0] / length, b[1] / length, b[2] / length])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_any_length_and_no_others_are_normalized() {
        for length in [5e-324, 1e-300, 1.0, 1e300, f64::MAX] {
            assert_eq!(normalize([0.0, -length, 0.0]), Some([0.0, -1.0, 0.0]), "{length}");
        }
        assert_eq!(normalize([3e-200, 0.0, -4e-200]), Some([0.6, 0.0, -0.8]));
        for none in [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(normalize([none, 0.0, 0.0]), None);
            if none != 0.0 {
                assert_eq!(normalize([1.0, 2.0, none]), None, "{none}");
            }
        }
    }
}
