//! The structural similarity of two pictures, 1 where they are equal.
//!
//! Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE
//! Transactions on Image Processing 13(4), 2004, with their constants: windows of 11 x 11 pixels weighted by a Gaussian of
//! 1.5 pixels, K1 = 0.01, K2 = 0.03, the mean over all windows that lie within the picture. Theirs is of grey pictures; here
//! it is the mean of red, green and blue, so that a wrong colour of the right brightness counts. A picture narrower than a
//! window has windows of its own width. The result is that of scikit-image's
//! `structural_similarity(a, b, channel_axis=2, gaussian_weights=True, use_sample_covariance=False)`.

use std::iter::zip;

use rayon::prelude::*;

use super::View;

const SIDE: usize = 11;
const SIGMA: f64 = 1.5;
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// The mean over windows and channels of two pictures of the same size. Rows run on the current pool; the sum does not
/// depend on it.
pub fn mean(reference: View<'_>, picture: View<'_>) -> f64 {
    let (width, height) = (reference.width as usize, reference.height as usize);
    let (across, down) = (weights(width), weights(height));
    let rows = height - down.len() + 1;
    let row = |y: usize| {
        let lines = y * width..(y + down.len()) * width;
        row_sum(&reference.pixels[lines.clone()], &picture.pixels[lines], &across, &down)
    };
    let sums: Vec<f64> = (0..rows).into_par_iter().map(row).collect();
    sums.iter().sum::<f64>() / (3 * rows * (width - across.len() + 1)) as f64
}

/// A Gaussian as long as a window's side, its sum 1.
fn weights(side: usize) -> Vec<f64> {
    let n = side.min(SIDE);
    let weight = |i| {
        let x = i as f64 - (n - 1) as f64 / 2.0;
        libm::exp(-x * x / (2.0 * SIGMA * SIGMA))
    };
    let sum: f64 = (0..n).map(weight).sum();
    (0..n).map(|i| weight(i) / sum).collect()
}

/// The similarities of all windows over as many lines as there are weights `down`, channels added up.
fn row_sum(reference: &[u32], picture: &[u32], across: &[f64], down: &[f64]) -> f64 {
    let width = reference.len() / down.len();
    let mut sum = 0.0;
    let mut columns = vec![[0.0; 5]; width];
    for shift in [0, 8, 16] {
        // Means of a, b, a^2, b^2 and ab down each column, then across.
        columns.fill([0.0; 5]);
        for (weight, (a, b)) in zip(down, zip(reference.chunks(width), picture.chunks(width))) {
            for (column, (a, b)) in zip(&mut columns, zip(a, b)) {
                let [a, b] = [a, b].map(|pixel| f64::from((pixel >> shift) as u8));
                add(column, *weight, [a, b, a * a, b * b, a * b]);
            }
        }
        for window in columns.windows(across.len()) {
            let mut means = [0.0; 5];
            for (weight, column) in zip(across, window) {
                add(&mut means, *weight, *column);
            }
            sum += similarity(means);
        }
    }
    sum
}

fn add(sums: &mut [f64; 5], weight: f64, values: [f64; 5]) {
    for (sum, value) in zip(sums, values) {
        *sum += weight * value;
    }
}

/// Exactly 1 where both have the same means.
fn similarity([a, b, aa, bb, ab]: [f64; 5]) -> f64 {
    let (variances, covariance) = ((aa - a * a) + (bb - b * b), ab - a * b);
    (2.0 * a * b + C1) * (2.0 * covariance + C2) / ((a * a + b * b + C1) * (variances + C2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the definition: every window alone, deviations from its mean, no separation into rows and columns.
    fn by_definition(a: View<'_>, b: View<'_>) -> f64 {
        let (width, height) = (a.width as usize, a.height as usize);
        let (n, m) = (width.min(11), height.min(11));
        let weight = |i: usize, n: usize| {
            let x = i as f64 - (n as f64 - 1.0) / 2.0;
            libm::exp(-(x * x) / 4.5)
        };
        let mut similarities = Vec::new();
        for (left, top, channel) in
            (0..=width - n).flat_map(|x| (0..=height - m).flat_map(move |y| [0, 1, 2].map(|c| (x, y, c))))
        {
            let inside = || (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
            let value = |v: View<'_>, i: usize, j: usize| {
                f64::from(v.pixels[(top + j) * width + left + i].to_le_bytes()[channel])
            };
            let total: f64 = inside().map(|(i, j)| weight(i, n) * weight(j, m)).sum();
            let mean = |f: &dyn Fn(usize, usize) -> f64| {
                inside().map(|(i, j)| weight(i, n) * weight(j, m) * f(i, j)).sum::<f64>() / total
            };
            let (ma, mb) = (mean(&|i, j| value(a, i, j)), mean(&|i, j| value(b, i, j)));
            let cov = |p: View<'_>, mp: f64, q: View<'_>, mq: f64| {
                mean(&|i, j| (value(p, i, j) - mp) * (value(q, i, j) - mq))
            };
            let luminance = (2.0 * ma * mb + 6.5025) / (ma * ma + mb * mb + 6.5025);
            let structure = (2.0 * cov(a, ma, b, mb) + 58.5225) / (cov(a, ma, a, ma) + cov(b, mb, b, mb) + 58.5225);
            similarities.push(luminance * structure);
        }
        similarities.iter().sum::<f64>() / similarities.len() as f64
    }

    #[test]
    fn is_what_the_definition_says() {
        let mut state = 7_u32;
        for (width, height) in [(1, 1), (2, 30), (17, 10), (11, 11), (19, 23)] {
            let mut noise = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                state >> 8
            };
            let a: Vec<u32> = (0..width * height).map(|_| noise()).collect();
            let b: Vec<u32> = a.iter().map(|p| if noise() % 3 == 0 { noise() } else { *p }).collect();
            let [a, b] = [&a, &b].map(|pixels| View { width, height, pixels });
            let (found, expected) = (mean(a, b), by_definition(a, b));
            assert!((found - expected).abs() < 1e-11, "{width}x{height}: {found} instead of {expected}");
        }
    }
}
