//! Finds the blocks that come near to colours.
//!
//! In: colours in Morton order. Out: the words of [`super::blocks`]. A block takes the fewest bits a weight with which its
//! mean square error is at most [`TOLERANCE`]. Its line is the principal axis of its colours (power iteration); the two
//! ends are then fitted to the weights by least squares, and the weights to the ends, while that helps. All sums run in
//! the order of the voxels and in f64, so the words are the same on every target.

use alloc::vec::Vec;

use super::blocks::{BLOCK, GROUP, MOST_BITS, RAW_MARK, between, words_of};
use super::{RAW, to_word};
use crate::build::BuildError;
use crate::math;
use crate::ranked::{append, bits};

/// Largest mean square error of a block per channel, in steps of a byte: PSNR 39.1 dB or better.
const TOLERANCE: f64 = 8.0;
/// Rounds of fitting ends to weights and weights to ends.
const ROUNDS: usize = 3;
/// Steps of the power iteration.
const STEPS: usize = 8;

/// The words of all colours.
pub(super) fn blocks(colors: impl Iterator<Item = Option<[u8; 3]>>) -> Result<Vec<u32>, BuildError> {
    let (mut starts, mut entries, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    let (mut block, mut filled, mut count) = ([None; BLOCK], 0, 0u64);
    let mut colors = colors.fuse();
    loop {
        let color = colors.next();
        if let Some(color) = color {
            block[filled] = color;
            filled += 1;
            count += 1;
        }
        if filled == BLOCK || color.is_none() && filled > 0 {
            if entries.len() % (2 * GROUP) == 0 {
                append(&mut starts, &[weights.len() as u32])?;
            }
            let start = starts.last().copied().unwrap_or(0);
            push(&block[..filled], start, &mut entries, &mut weights)?;
            filled = 0;
        }
        if color.is_none() {
            break;
        }
    }
    let mut words = Vec::new();
    append(&mut words, &[count as u32, (count >> 32) as u32, 0, 0])?;
    for part in [starts, entries, weights] {
        append(&mut words, &part)?;
    }
    Ok(words)
}

/// Appends a block, its weights behind those of its group that `start` begins.
fn push(
    colors: &[Option<[u8; 3]>],
    start: u32,
    entries: &mut Vec<u32>,
    weights: &mut Vec<u32>,
) -> Result<(), BuildError> {
    let at = weights.len();
    let end = u32::try_from(at).map_err(|_| BuildError::Words { needed: at as u64 })?;
    let line = Line::of(colors);
    let (first, second, mark) = match line {
        Some(Line { ends: [first, second], bits, .. }) => (to_word(first), to_word(second), bits),
        None => (0, 0, RAW_MARK),
    };
    let width = if mark == RAW_MARK { RAW } else { mark };
    append(weights, &[0; words_of(RAW)][..words_of(width)])?;
    for (k, color) in (0..).zip(colors) {
        let value = match &line {
            Some(line) => line.weights[k as usize].into(),
            None => to_word(color.unwrap_or([0; 3])),
        };
        bits::set(&mut weights[at..], k, width, value);
    }
    let offset = end - start;
    append(entries, &[first | offset << 24, second | (offset >> 8) << 24 | mark << 29])
}

/// Colours between two ends.
struct Line {
    ends: [[u8; 3]; 2],
    bits: u32,
    weights: [u8; BLOCK],
}

/// A colour as a vector.
fn vector(color: [u8; 3]) -> [f64; 3] {
    color.map(f64::from)
}

/// The nearest byte.
fn byte(x: f64) -> u8 {
    (x.clamp(0.0, 255.0) + 0.5) as u8
}

/// The colours that matter, with their places.
fn known(colors: &[Option<[u8; 3]>]) -> impl Iterator<Item = (usize, [u8; 3])> + Clone {
    colors.iter().enumerate().filter_map(|(k, color)| Some((k, (*color)?)))
}

impl Line {
    /// The cheapest line that comes near enough; `None` if there is none.
    fn of(colors: &[Option<[u8; 3]>]) -> Option<Line> {
        let count = known(colors).count();
        let most = TOLERANCE * 3.0 * count as f64;
        let sum = known(colors).fold([0.0; 3], |sum, (_, c)| math::add_scaled(sum, vector(c), 1.0));
        let mean = sum.map(|x| x / count.max(1) as f64);
        let flat = Line { ends: [mean.map(byte), [0; 3]], bits: 0, weights: [0; BLOCK] };
        if flat.error(colors) <= most {
            return Some(flat);
        }
        let axis = principal_axis(colors, mean);
        let along = |c| math::dot(math::sub(vector(c), mean), axis);
        let (low, high) = known(colors).fold((0.0f64, 0.0f64), |(low, high), (_, c)| {
            let t = along(c);
            (low.min(t), high.max(t))
        });
        let ends = [low, high].map(|t| math::add_scaled(mean, axis, t).map(byte));
        (1..=MOST_BITS).find_map(|bits| {
            let mut line = Line { ends, bits, weights: [0; BLOCK] };
            let mut error = line.weigh(colors);
            for _ in 0..ROUNDS {
                if error <= most {
                    return Some(line);
                }
                let mut next = Line { ends: line.fitted(colors)?, ..line };
                let smaller = next.weigh(colors);
                if smaller >= error {
                    return None;
                }
                (line, error) = (next, smaller);
            }
            (error <= most).then_some(line)
        })
    }

    /// The colour of a weight.
    fn color(&self, weight: u8) -> [u8; 3] {
        if self.bits == 0 {
            return self.ends[0];
        }
        between(self.ends[0], self.ends[1], weight.into(), (1 << self.bits) - 1)
    }

    /// Square distance from the colours to those that stand for them.
    fn error(&self, colors: &[Option<[u8; 3]>]) -> f64 {
        known(colors).map(|(k, c)| f64::from(distance(c, self.color(self.weights[k])))).sum()
    }

    /// Gives every colour the weight that comes nearest; the square error then.
    fn weigh(&mut self, colors: &[Option<[u8; 3]>]) -> f64 {
        let most = (1u8 << self.bits) - 1;
        let mut steps = [[0; 3]; 1 << MOST_BITS];
        for weight in 0..=most {
            steps[usize::from(weight)] = self.color(weight);
        }
        let steps = &steps[..=usize::from(most)];
        let mut error = 0;
        for (k, color) in known(colors) {
            let nearest = (0..=most).map(|w| (distance(color, steps[usize::from(w)]), w)).min().unwrap_or((0, 0));
            error += nearest.0;
            self.weights[k] = nearest.1;
        }
        f64::from(error)
    }

    /// The ends with which these weights come nearest to the colours; `None` if all have one weight.
    fn fitted(&self, colors: &[Option<[u8; 3]>]) -> Option<[[u8; 3]; 2]> {
        let most = f64::from((1u32 << self.bits) - 1);
        let (mut aa, mut ab, mut bb, mut a, mut b) = (0.0, 0.0, 0.0, [0.0; 3], [0.0; 3]);
        for (k, color) in known(colors) {
            let t = f64::from(self.weights[k]) / most;
            let s = 1.0 - t;
            (aa, ab, bb) = (aa + s * s, ab + s * t, bb + t * t);
            a = math::add_scaled(a, vector(color), s);
            b = math::add_scaled(b, vector(color), t);
        }
        let determinant = aa * bb - ab * ab;
        (determinant > 0.0).then(|| {
            let first = core::array::from_fn(|i| byte((a[i] * bb - b[i] * ab) / determinant));
            let second = core::array::from_fn(|i| byte((b[i] * aa - a[i] * ab) / determinant));
            [first, second]
        })
    }
}

/// Square distance of two colours.
fn distance(a: [u8; 3], b: [u8; 3]) -> u32 {
    (0..3).map(|i| u32::from(a[i].abs_diff(b[i])).pow(2)).sum()
}

/// The direction in which colours spread most, of unit length; grey if they do not.
fn principal_axis(colors: &[Option<[u8; 3]>], mean: [f64; 3]) -> [f64; 3] {
    let mut spread = [[0.0; 3]; 3];
    for (_, color) in known(colors) {
        let d = math::sub(vector(color), mean);
        for i in 0..3 {
            spread[i] = math::add_scaled(spread[i], d, d[i]);
        }
    }
    // From the channel that spreads most: its row is never at right angles to the axis.
    let widest = (1..3).fold(0, |best, i| if spread[i][i] > spread[best][best] { i } else { best });
    let mut axis = math::normalize(spread[widest]).unwrap_or([0.577_350_269_189_625_8; 3]);
    for _ in 0..STEPS {
        axis = math::normalize(spread.map(|row| math::dot(row, axis))).unwrap_or(axis);
    }
    axis
}
