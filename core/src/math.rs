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
    let largest = a[0].abs().max(a[1].abs()).max(a[2].abs());
    // `max` drops NaN, so the components are asked one by one.
    if largest == 0.0 || !(a[0].is_finite() && a[1].is_finite() && a[2].is_finite()) {
        return None;
    }
    let b = [a[0] / largest, a[1] / largest, a[2] / largest];
    let length = sqrt(dot(b, b));
    Some([b[0] / length, b[1] / length, b[2] / length])
}
