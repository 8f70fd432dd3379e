//! How far a picture is from a reference of the same size: one number each for the amount of light, for structure, and
//! for what people see when the two alternate. Pixels are sRGB of 8 bits a channel; alpha is ignored.
//!
//! - RMSE: in linear light (each byte decoded), over all pixels and channels; 0 to 1. PSNR: `-20 log10(RMSE)`, the peak
//!   being 1.
//! - SSIM: [`ssim`], of the sRGB values, the mean of the three channels; 1 is equal.
//! - FLIP: [`flip`], of the sRGB values, the mean over the pixels as its authors recommend; 0 is equal, 1 the most.
//!
//! SSIM is our own: `image-compare` 0.5 adds variances up where the definition averages them, and finds errors a third too
//! large. docs/numerics.md, "Errors of pictures", has all comparisons.

#[cfg_attr(not(feature = "flip"), path = "no_flip.rs")]
mod flip;
mod ssim;

use std::iter::zip;

use serde::Serialize;
use voxdag::color;

/// A picture to compare: rows of sRGB pixels from the top, red in the lowest byte (as `Picture::pixels`); alpha is ignored.
#[derive(Clone, Copy)]
pub struct View<'a> {
    pub width: u32,
    pub height: u32,
    pub pixels: &'a [u32],
}

impl View<'_> {
    /// Both have the same width and height, not 0, and every pixel of that.
    pub fn same_size(self, other: View<'_>) -> bool {
        let pixels = u64::from(self.width) * u64::from(self.height);
        (self.width, self.height) == (other.width, other.height)
            && pixels > 0
            && [self, other].iter().all(|view| view.pixels.len() as u64 == pixels)
    }
}

/// How far a picture is from its reference.
#[derive(Clone, Copy, Serialize, Debug)]
pub struct Errors {
    /// In linear light, 0 to 1.
    pub rmse: f64,
    /// In dB; none for equal pictures.
    pub psnr: Option<f64>,
    /// 1 for equal pictures.
    pub ssim: f64,
    /// 0 for equal pictures, up to 1; none without the feature `flip` or beyond [`MOST_PIXELS`].
    pub flip: Option<f64>,
    /// Pixels of another colour, by however little.
    pub differing: u64,
}

/// Bytes that FLIP holds for each pixel.
pub const FLIP_BYTES: usize = 80;

/// Most pixels that FLIP looks at.
pub const MOST_PIXELS: usize = 1 << 26;

/// The RMSE alone, in the same bits wherever it runs; NaN unless both have the [same size](View::same_size).
pub fn rmse(reference: View<'_>, picture: View<'_>) -> f64 {
    if !reference.same_size(picture) {
        return f64::NAN;
    }
    color::rmse(reference.pixels, picture.pixels)
}

/// All errors; NaN and none unless both have the [same size](View::same_size).
pub fn errors(reference: View<'_>, picture: View<'_>) -> Errors {
    if !reference.same_size(picture) {
        return Errors { rmse: f64::NAN, psnr: None, ssim: f64::NAN, flip: None, differing: 0 };
    }
    let rmse = rmse(reference, picture);
    Errors {
        rmse,
        psnr: (rmse > 0.0).then(|| -20.0 * libm::log10(rmse)),
        ssim: ssim::mean(reference, picture),
        flip: flip::mean(reference, picture),
        differing: zip(reference.pixels, picture.pixels).filter(|&(&a, &b)| rgb(a) != rgb(b)).count() as u64,
    }
}

/// FLIP's error per pixel in its authors' colours (magma: black is equal, light yellow the most), opaque; none where there
/// is no FLIP, and unless both have the [same size](View::same_size).
pub fn flip_map(reference: View<'_>, picture: View<'_>) -> Option<Vec<u32>> {
    if reference.same_size(picture) { flip::colours(reference, picture) } else { None }
}

/// Red, green and blue of a pixel.
fn rgb(pixel: u32) -> [u8; 3] {
    let [red, green, blue, _] = pixel.to_le_bytes();
    [red, green, blue]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture whose pixel at (x, y) is red, green and blue of `colour`.
    fn picture(width: u32, height: u32, colour: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u32> {
        let at = |i| {
            let [r, g, b] = colour(i % width, i / width);
            u32::from_le_bytes([r, g, b, (i % 251) as u8]) // alpha must not matter
        };
        (0..width * height).map(at).collect()
    }

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
    }

    #[test]
    fn equal_pictures_have_no_error() {
        for (width, height) in [(1, 1), (3, 40), (40, 23)] {
            let a = picture(width, height, |x, y| [(x * 37 + y * 11) as u8, (x * y) as u8, 200]);
            let b: Vec<u32> = a.iter().map(|p| p ^ 0x5500_0000).collect();
            let [a, b] = [&a, &b].map(|pixels| View { width, height, pixels });
            let Errors { rmse, psnr, ssim, flip, differing } = errors(a, b);
            assert_eq!((rmse, psnr, ssim, differing), (0.0, None, 1.0, 0));
            assert_eq!(flip, cfg!(feature = "flip").then_some(0.0));
            let map = flip_map(a, b);
            assert_eq!(map.is_some(), cfg!(feature = "flip"));
            // The first colour of the map.
            assert!(map.is_none_or(|map| map.len() == a.pixels.len() && map.iter().all(|&p| p == 0xff04_0000)));
        }
    }

    #[test]
    fn black_and_white_are_known() {
        let [black, white] = [0, 255].map(|grey| picture(30, 20, |_, _| [grey; 3]));
        let [black, white] = [&black, &white].map(|pixels| View { width: 30, height: 20, pixels });
        let Errors { rmse, psnr, ssim, flip, differing } = errors(black, white);
        assert_eq!((rmse, psnr, differing), (1.0, Some(0.0), 600));
        // Without variance only the means stay: C1 / (255^2 + C1).
        near(ssim, 6.5025 / 65031.5025, 1e-9);
        // By hand: 100 apart in lightness, ^0.7 = 25.12; the most is 41.28 (green to blue), of which 0.4 make 0.95 and the
        // rest fills up to 1; no edges.
        assert!(flip.is_none_or(|flip| (flip - 0.9674).abs() < 1e-4), "{flip:?}");
    }

    #[test]
    fn one_pixel_counts_as_one_of_all_channels() {
        let a = picture(2, 2, |_, _| [0, 10, 20]);
        let b = picture(2, 2, |x, y| [if (x, y) == (1, 0) { 188 } else { 0 }, 10, 20]);
        let [a, b] = [&a, &b].map(|pixels| View { width: 2, height: 2, pixels });
        let light = libm::pow((188.0 / 255.0 + 0.055) / 1.055, 2.4);
        let Errors { rmse, psnr, differing, .. } = errors(a, b);
        assert_eq!(differing, 1);
        near(rmse, light / 12f64.sqrt(), 1e-15);
        near(psnr.unwrap(), 10.0 * libm::log10(12.0 / (light * light)), 1e-12);
    }

    #[test]
    fn pictures_of_different_sizes_are_not_compared() {
        let pixels = [0; 6];
        let view = |width, height, n| View { width, height, pixels: &pixels[..n] };
        for (a, b) in [
            (view(2, 3, 6), view(3, 2, 6)),
            (view(2, 3, 5), view(2, 3, 5)),
            (view(0, 3, 0), view(0, 3, 0)),
            (view(u32::MAX, u32::MAX, 6), view(u32::MAX, u32::MAX, 6)),
        ] {
            assert!(!a.same_size(b) && rmse(a, b).is_nan() && flip_map(a, b).is_none());
            let Errors { rmse, psnr, ssim, flip, .. } = errors(a, b);
            assert!(rmse.is_nan() && ssim.is_nan() && psnr.is_none() && flip.is_none());
        }
    }

    /// What scikit-image and FLIP's authors' tool say of these two pictures.
    #[test]
    fn others_find_the_same() {
        let a = picture(64, 48, |x, y| [(4 * x) as u8, (5 * y) as u8, ((x * x + y * y) / 26) as u8]);
        let b = picture(64, 48, |x, y| [(4 * x) as u8 ^ (y % 8) as u8, (5 * y) as u8, ((x * x + x * y) / 29) as u8]);
        let [a, b] = [&a, &b].map(|pixels| View { width: 64, height: 48, pixels });
        let Errors { ssim, flip, .. } = errors(a, b);
        near(ssim, SCIKIT_IMAGE, 1e-12);
        assert!(flip.is_none_or(|flip| (flip - FLIP_EVALUATOR).abs() < 1e-5), "{flip:?}");
    }
    const SCIKIT_IMAGE: f64 = 0.943_281_525_832_091_5;
    const FLIP_EVALUATOR: f64 = 0.126_219_6;
}
