//! Unit vectors in 32 bits: the octahedral map with 16 bits a coordinate (Meyer et al. 2010; survey by Cigolle et al.
//! 2014).
//!
//! In: a direction of any length. Out: one word, `(u + 32768) | (v + 32768) << 16` with u and v from -32767 to 32767, so
//! that 0 is no direction. The sphere is pressed onto the octahedron `|x| + |y| + |z| = 1`; its lower half (z < 0) is
//! folded outwards into the corners of the square `[-1, 1]^2`. The six axes are exact.
//!
//! Error: rounding moves u and v by at most 0.5 / 32767 each, hence the point by at most `sqrt(6)` times that at a
//! distance of at least `1 / sqrt(3)` from the centre: 6.5e-5 radians, [`MAX_ERROR`] with the rounding of f32.
//! Differs from the sources: an odd number of steps with 0 in the middle, a word for "none", no search for the best
//! of four neighbours.

use crate::math;

/// Bound of the angle between a direction and what comes back, in radians (0.004 degrees).
pub const MAX_ERROR: f64 = 7e-5;

/// Steps between 0 and 1.
const STEPS: f64 = 32767.0;
/// Added to a coordinate's steps, so that no half of a word is 0.
const BIAS: i32 = 32768;

/// The word of a direction; 0 if it is zero or not finite.
pub fn encode(direction: [f32; 3]) -> u32 {
    let [x, y, z] = direction.map(f64::from);
    let sum = x.abs() + y.abs() + z.abs();
    if !(sum > 0.0 && sum.is_finite()) {
        return 0;
    }
    let (mut u, mut v) = (x / sum, y / sum);
    if z < 0.0 {
        (u, v) = (outward(u, v), outward(v, u));
    }
    let half = |c: f64| (libm::rint(c * STEPS) as i32 + BIAS) as u32;
    half(u) | half(v) << 16
}

/// The unit vector of a word; `None` for 0.
#[inline]
pub fn decode(word: u32) -> Option<[f32; 3]> {
    if !is_valid(word) {
        return None;
    }
    let half = |h: u32| (h as i32 - BIAS) as f32 / STEPS as f32;
    let (u, v) = (half(word & 0xffff), half(word >> 16));
    let z = 1.0 - u.abs() - v.abs();
    let fold = (-z).max(0.0);
    let x = if u < 0.0 { u + fold } else { u - fold };
    let y = if v < 0.0 { v + fold } else { v - fold };
    let length = math::sqrt_f32(x * x + y * y + z * z);
    Some([x / length, y / length, z / length])
}

/// Whether a word is one that [`encode`] gives for a direction.
#[inline]
pub(crate) fn is_valid(word: u32) -> bool {
    word & 0xffff != 0 && word >> 16 != 0
}

/// Folds a coordinate of the lower half over the square's diagonal.
fn outward(this: f64, other: f64) -> f64 {
    let folded = 1.0 - other.abs();
    if this < 0.0 { -folded } else { folded }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_exact_and_nothing_is_zero() {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut n = [0.0; 3];
                n[axis] = sign;
                assert_eq!(decode(encode(n)), Some(n));
                assert_eq!(encode(n.map(|c| c * 1e30)), encode(n));
            }
        }
        for none in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(encode(none), 0);
        }
        assert_eq!(decode(0), None);
    }

    /// The angle is measured by the cross product in f64; the cosine could not resolve it.
    #[test]
    fn error_is_within_the_bound_and_the_bound_is_near() {
        let mut state = 1u64;
        let mut worst = 0.0f64;
        for _ in 0..if cfg!(miri) { 100 } else { 300_000 } {
            let n: [f64; 3] = core::array::from_fn(|_| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 40) as f64 / (1u64 << 23) as f64 - 1.0
            });
            let Some(n) = math::normalize(n.map(|c| f64::from(c as f32))) else { continue };
            let back = decode(encode(n.map(|c| c as f32))).unwrap().map(f64::from);
            let length = math::sqrt(math::dot(back, back));
            assert!((length - 1.0).abs() < 2e-7, "length {length} of {back:?}");
            assert!(math::dot(n, back) > 0.0);
            let cross = math::cross(n, back);
            worst = worst.max(math::sqrt(math::dot(cross, cross)) / length);
        }
        assert!(worst < MAX_ERROR, "{worst}");
        assert!(cfg!(miri) || worst > 0.8 * MAX_ERROR, "the documented bound is too pessimistic: {worst}");
    }
}
