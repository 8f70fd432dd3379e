//! Colours in blocks of 64, each between two of its own (after Dolonius et al. 2017).
//!
//! In: checked words. Out: colours; a look-up reads a start, an entry of two words, and a weight. Differs from the source:
//! blocks are of equally many voxels, so that a rank's block is known without a search, their two colours have all their
//! bits, and a block that no line fits keeps its colours as they are.
//!
//! ```text
//! word  4..    starts: one a group of 64 blocks, the sum of the weights' words before it
//!       then   entries: two words a block     bits 0 to 23     bits 24 to 31
//!                                       [0]   first colour     offset, low 8 bits
//!                                       [1]   second colour    offset, high 5 bits; bits 5 to 7: B, or 7 for raw
//!       then   at start + offset, in words: 64 weights of B bits, 0 to 4; or 64 colours of 24 bits (B = 7)
//!
//! colour = first + (second - first) weight / (2^B - 1), rounded per channel, B = 0: first
//! ```
//!
//! What a block has no use for is 0: the second colour if B is 0, both if it is raw, weights behind the last voxel.

use super::{HEADER, RAW, WHITE, from_word};
use crate::ranked::{RankedError, bits};

/// Voxels of a block, as a power of two.
const BITS: u32 = 6;
pub(super) const BLOCK: usize = 1 << BITS;
/// Blocks of a group, as a power of two.
const GROUP_BITS: u32 = 6;
pub(super) const GROUP: usize = 1 << GROUP_BITS;
/// Most bits of a weight.
pub(super) const MOST_BITS: u32 = 4;
/// What stands for colours as they are.
pub(super) const RAW_MARK: u32 = 7;

/// A checked view over colours in blocks.
#[derive(Clone, Copy, Debug)]
pub struct Blocks<'a> {
    words: &'a [u32],
    count: u64,
    /// Where the entries and the weights begin.
    entries: usize,
    weights: usize,
}

/// A block's entry.
#[derive(Clone, Copy)]
struct Entry {
    first: u32,
    second: u32,
    offset: u32,
    mark: u32,
}

impl Entry {
    fn new([a, b]: [u32; 2]) -> Entry {
        let mask = (1 << RAW) - 1;
        Entry { first: a & mask, second: b & mask, offset: a >> 24 | (b >> 24 & 31) << 8, mark: b >> 29 }
    }

    /// Bits a voxel.
    fn width(self) -> u32 {
        if self.mark == RAW_MARK { RAW } else { self.mark }
    }
}

/// Words of a block's weights.
pub(super) const fn words_of(width: u32) -> usize {
    BLOCK * width as usize / 32
}

/// Groups and blocks of so many colours.
fn shape(count: u64) -> (u64, u64) {
    let blocks = count.div_ceil(BLOCK as u64);
    (blocks.div_ceil(GROUP as u64), blocks)
}

/// A colour `weight / most` of the way from one to another, rounded; they are equally far apart however it is told.
#[inline]
pub(super) fn between(first: [u8; 3], second: [u8; 3], weight: u32, most: u32) -> [u8; 3] {
    core::array::from_fn(|i| {
        let sum = u32::from(first[i]) * (most - weight) + u32::from(second[i]) * weight;
        ((sum + most / 2) / most) as u8
    })
}

impl<'a> Blocks<'a> {
    /// Checks what follows the header of so many colours.
    pub(super) fn new(words: &'a [u32], count: u64) -> Result<Blocks<'a>, RankedError> {
        let found = words.len() as u64;
        let (groups, blocks) = shape(count);
        let front = HEADER as u64 + groups + 2 * blocks;
        if found < front {
            return Err(RankedError::Length { expected: front, found });
        }
        let view = Blocks::trusted(words, count);
        let mut next = 0;
        for block in 0..blocks as usize {
            let at = view.entries + 2 * block;
            let (word, entry) = (at as u64, view.entry(block));
            let start = HEADER + block / GROUP;
            if block % GROUP == 0 && words[start] as usize != next {
                return Err(RankedError::Value { word: start as u64 });
            }
            let width = entry.width();
            let unused = match entry.mark {
                RAW_MARK => entry.first | entry.second,
                0 => entry.second,
                _ => 0,
            };
            if words[start] as usize + entry.offset as usize != next {
                return Err(RankedError::Value { word });
            }
            if width > MOST_BITS && width != RAW || unused != 0 {
                return Err(RankedError::Value { word: word + 1 });
            }
            let from = view.weights + next;
            next += words_of(width);
            let Some(weights) = words.get(from..from + words_of(width)) else {
                return Err(RankedError::Length { expected: (from + words_of(width)) as u64, found });
            };
            // Only the last block may have voxels to spare.
            let filled = count - (block as u64) * BLOCK as u64;
            for k in filled..BLOCK as u64 {
                if bits::get(weights, k, width) != 0 {
                    return Err(RankedError::Value { word: from as u64 + k * u64::from(width) / 32 });
                }
            }
        }
        let expected = (view.weights + next) as u64;
        if found != expected {
            return Err(RankedError::Length { expected, found });
        }
        Ok(view)
    }

    /// The view over words that are known to be right.
    pub(super) fn trusted(words: &'a [u32], count: u64) -> Blocks<'a> {
        let (groups, blocks) = shape(count);
        let entries = HEADER + groups as usize;
        Blocks { words, count, entries, weights: entries + 2 * blocks as usize }
    }

    pub(super) fn words(&self) -> &'a [u32] {
        self.words
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    fn entry(&self, block: usize) -> Entry {
        let at = self.entries + 2 * block;
        Entry::new([self.words[at], self.words[at + 1]])
    }

    /// The colour of the voxel of a rank; white beyond the last.
    #[inline]
    pub(super) fn get(&self, rank: u64) -> [u8; 3] {
        if rank >= self.count {
            return WHITE;
        }
        let block = (rank >> BITS) as usize;
        let entry = self.entry(block);
        let first = from_word(entry.first);
        if entry.mark == 0 {
            return first;
        }
        let at = self.weights + self.words[HEADER + (block >> GROUP_BITS)] as usize + entry.offset as usize;
        let value = bits::get(&self.words[at..], rank & (BLOCK as u64 - 1), entry.width());
        if entry.mark == RAW_MARK {
            return from_word(value);
        }
        between(first, from_word(entry.second), value, (1 << entry.mark) - 1)
    }
}
