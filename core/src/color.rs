//! Colours: linear light inside, sRGB at both ends (IEC 61966-2-1).
//!
//! In: linear f32 samples, or sRGB values of a file. Out: exact means as sRGB bytes. Samples become integers before
//! they are summed, so the mean depends neither on their order nor on how they are shared out, and it saturates after
//! averaging: a sample may be up to 16 times as bright as white. The curve's only power, u^(12/5), is a fifth root by
//! Newton's method, so that the table of thresholds is made by the compiler.

/// Quantised white.
pub const WHITE: u32 = 65_535;
/// Brightest sample, as a multiple of white. 4096 samples of this brightness still fit a u32.
pub const BRIGHTEST: f32 = 16.0;

/// `ENCODE[i]`: the smallest quantised linear value whose sRGB byte is above i.
const ENCODE: [u16; 255] = {
    let mut thresholds = [0; 255];
    let mut i = 0;
    while i < 255 {
        let linear = srgb_to_linear((i as f64 + 0.5) / 255.0) * WHITE as f64;
        // Rounded up; no threshold is a whole number.
        thresholds[i] = linear as u16 + 1;
        i += 1;
    }
    thresholds
};

/// The linear value of an sRGB value (0 to 1, larger ones go on along the curve), in full f64 accuracy.
pub const fn srgb_to_linear(s: f64) -> f64 {
    if s <= 0.040_45 {
        return s / 12.92;
    }
    let u = (s + 0.055) / 1.055;
    let square = u * u;
    // Newton's steps fall to the fifth root from above, until rounding stops them.
    let (mut root, mut next) = (f64::INFINITY, if square > 1.0 { square } else { 1.0 });
    while next < root {
        root = next;
        next = 0.8 * root + square / (5.0 * root * root * root * root);
    }
    square * root
}

/// The quantised linear value of each sRGB byte.
pub const LINEAR: [u16; 256] = {
    let mut linear = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        linear[byte] = (srgb_to_linear(byte as f64 / 255.0) * WHITE as f64 + 0.5) as u16;
        byte += 1;
    }
    linear
};

/// The sRGB byte of a quantised linear value; [`WHITE`] and everything above it is 255.
#[inline]
pub fn linear_to_srgb8(linear: u32) -> u8 {
    ENCODE.partition_point(|&threshold| u32::from(threshold) <= linear) as u8
}

/// A linear sample as an integer: 1 becomes [`WHITE`]; below 0 and NaN become 0, above [`BRIGHTEST`] saturates.
#[inline]
pub fn quantize(sample: f32) -> u32 {
    // NaN passes through `clamp` and is converted to 0.
    (sample.clamp(0.0, BRIGHTEST) * WHITE as f32 + 0.5) as u32
}

/// The linear value of each sRGB byte.
const DECODE: [f64; 256] = {
    let mut table = [0.0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = srgb_to_linear(i as f64 / 255.0);
        i += 1;
    }
    table
};

/// How far a picture is from another one of as many pixels: the root of the mean square difference of red, green and blue
/// in linear light, 0 to 1. Pixels are RGBA8, red in the lowest byte; alpha is ignored. The same bits wherever it runs; NaN
/// if there are no pixels or not as many.
pub fn rmse(reference: &[u32], picture: &[u32]) -> f64 {
    if reference.len() != picture.len() {
        return f64::NAN;
    }
    let mut sum = 0.0;
    for (a, b) in reference.iter().zip(picture).map(|(a, b)| (a.to_le_bytes(), b.to_le_bytes())) {
        for i in 0..3 {
            let error = DECODE[usize::from(a[i])] - DECODE[usize::from(b[i])];
            sum += error * error;
        }
    }
    crate::math::sqrt(sum / (3 * reference.len()) as f64)
}

/// The mean of linear samples.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Mean {
    sums: [u32; 3],
    count: u32,
}

impl Mean {
    /// Adds a quantised sample; up to 4096 of them fit.
    #[inline]
    pub fn add(&mut self, sample: [u32; 3]) {
        for i in 0..3 {
            self.sums[i] = self.sums[i].saturating_add(sample[i]);
        }
        self.count += 1;
    }

    /// The exact mean, rounded once, saturated and encoded: sRGB bytes red, green, blue. Black without samples.
    #[inline]
    pub fn srgb8(&self) -> [u8; 3] {
        let n = self.count.max(1);
        self.sums.map(|sum| linear_to_srgb8((sum.saturating_add(n / 2)) / n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_become_integers_without_surprises() {
        let cases = [0.0, -0.0, -3.0, 1.0, 0.5, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 16.0, 1e-6];
        let brightest = 16 * WHITE;
        assert_eq!(cases.map(quantize), [0, 0, 0, WHITE, 32_768, 0, brightest, 0, brightest, 0]);
    }

    #[test]
    fn the_mean_saturates_last() {
        let mut mean = Mean::default();
        assert_eq!(mean.srgb8(), [0; 3]);
        mean.add([2.0, 1.0, 0.0].map(quantize));
        mean.add([0.0, 1.0, 0.0].map(quantize));
        assert_eq!(mean.srgb8(), [255, 255, 0]);
    }
}
