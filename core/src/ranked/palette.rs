//! Material ids by rank in blocks with palettes of their own (after Dado et al. 2016; block size fixed as in
//! Dolonius et al. 2017).
//!
//! In: ids in Morton order. Out: words whose look-ups read a block's entry, an index and a palette: a block of one
//! material is its entry alone, one of a few takes as many bits a voxel as number them. Differs from the sources: ids
//! of materials, not colours, so nothing is lost, and blocks of equally many voxels, so that the block of a rank is
//! known without a search.
//!
//! ```text
//! word  0, 1   number of ids (low, high)
//!       2      largest id                            entry: 0 << 28 | id          all voxels of the block
//!       3      0                                            B << 28 | offset      B bits a voxel, 1 to 8
//!       4..    entries, one a block of 256 voxels
//!       then   at the offsets, from the end of the entries: [ 256 indices of B bits ][ palette, two ids a word ]
//! ```
//!
//! A palette's ids are in the order of their first voxels, each once; indices behind the last voxel are 0.

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

use super::{MAX_COUNT, RankedError, Values, bits};
#[cfg(feature = "alloc")]
use super::{append, in_order};
#[cfg(feature = "alloc")]
use crate::build::BuildError;
use crate::material::MaterialId;
#[cfg(feature = "alloc")]
use crate::morton::Morton;
#[cfg(feature = "alloc")]
use crate::table::Entry;

/// Words before the entries.
const HEADER: usize = 4;
/// Voxels of a block, as a power of two. Of 6 to 13 this takes the least at 1024^3 where there are many materials (bits
/// a voxel: sponza 0.69, conference 0.76; with 9 it is 0.80 and 0.85), and the bunny's few take 0.14 (0.08 with 9).
const BITS: u32 = 8;
const BLOCK: usize = 1 << BITS;
/// An entry's bits a voxel stand above its offset or id.
const SHIFT: u32 = 28;
const MOST: u64 = 1 << SHIFT;

/// A checked view over ids in blocks.
#[derive(Clone, Copy, Debug)]
pub struct Palettes<'a> {
    words: &'a [u32],
    count: u64,
    /// Where the blocks start that have more than an entry.
    blocks: usize,
}

impl<'a> Palettes<'a> {
    /// Checks words in O(ids), without heap; after `Ok` no look-up can panic. Not checked, as no answer depends on it:
    /// that a palette's ids differ.
    pub fn new(words: &'a [u32]) -> Result<Palettes<'a>, RankedError> {
        let found = words.len() as u64;
        let Some(&[low, high, max, reserved]) = words.first_chunk::<HEADER>() else {
            return Err(RankedError::Length { expected: HEADER as u64, found });
        };
        let count = u64::from(low) | u64::from(high) << 32;
        if count > MAX_COUNT {
            return Err(RankedError::Header { word: 1 });
        }
        if reserved != 0 {
            return Err(RankedError::Header { word: 3 });
        }
        let blocks = HEADER as u64 + count.div_ceil(BLOCK as u64);
        if found < blocks {
            return Err(RankedError::Length { expected: blocks, found });
        }
        let palettes = Palettes { words, count, blocks: blocks as usize };

        // Blocks follow each other, and hold indices of their palettes alone.
        let (mut next, mut largest) = (palettes.blocks, 0);
        for (i, &entry) in words[HEADER..palettes.blocks].iter().enumerate() {
            let word = (HEADER + i) as u64;
            let (width, value) = (entry >> SHIFT, u64::from(entry) & (MOST - 1));
            if width == 0 {
                largest = largest.max(value);
                continue;
            }
            let indices = BLOCK * width as usize / 32;
            if width > BITS || value != (next - palettes.blocks) as u64 {
                return Err(RankedError::Value { word });
            }
            let Some(block) = words.get(next..next + indices) else {
                return Err(RankedError::Length { expected: (next + indices) as u64, found });
            };
            let filled = (count - i as u64 * BLOCK as u64).min(BLOCK as u64);
            let mut ids = 0;
            for k in 0..BLOCK as u64 {
                let index = bits::get(block, k, width);
                if index > ids || k >= filled && index != 0 {
                    return Err(RankedError::Value { word: next as u64 + k * u64::from(width) / 32 });
                }
                ids += u32::from(index == ids);
            }
            if bits::width(ids - 1) != width {
                return Err(RankedError::Value { word });
            }
            let end = next + indices + ids.div_ceil(2) as usize;
            let Some(palette) = words.get(next + indices..end) else {
                return Err(RankedError::Length { expected: end as u64, found });
            };
            if ids % 2 != 0 && palette[palette.len() - 1] >> 16 != 0 {
                return Err(RankedError::Value { word: end as u64 - 1 });
            }
            largest = palette.iter().map(|w| u64::from((w & 0xffff).max(w >> 16))).fold(largest, u64::max);
            next = end;
        }
        if next as u64 != found {
            return Err(RankedError::Length { expected: next as u64, found });
        }
        if largest != u64::from(max) || max > MaterialId::MAX.into() {
            return Err(RankedError::Header { word: 2 });
        }
        Ok(palettes)
    }

    /// The words; `Palettes::new(palettes.words())` is the same view.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }
}

impl Values for Palettes<'_> {
    fn count(&self) -> u64 {
        self.count
    }

    #[inline]
    fn id(&self, rank: u64) -> MaterialId {
        if rank >= self.count {
            return 0;
        }
        let entry = self.words[HEADER + (rank >> BITS) as usize];
        let (width, value) = (entry >> SHIFT, entry & (MOST as u32 - 1));
        if width == 0 {
            return value as MaterialId;
        }
        let block = &self.words[self.blocks + value as usize..];
        let index = bits::get(block, rank & (BLOCK as u64 - 1), width) as usize;
        (block[BLOCK * width as usize / 32 + index / 2] >> (16 * (index % 2))) as MaterialId
    }

    #[inline]
    fn normal(&self, _: u64) -> Option<[f32; 3]> {
        None
    }

    fn max_material(&self) -> MaterialId {
        self.words[2] as MaterialId
    }
}

/// Ids in blocks that own their words. The words depend on the ids alone.
#[cfg(feature = "alloc")]
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PalettesBuf {
    words: Vec<u32>,
}

#[cfg(feature = "alloc")]
impl PalettesBuf {
    /// The materials of entries whose codes ascend. Blocks of more than one material may take 2^28 words (1 GiB)
    /// together.
    pub fn from_entries(entries: impl IntoIterator<Item = (Morton, Entry)>) -> Result<PalettesBuf, BuildError> {
        let mut open = Open { ids: [0; BLOCK], filled: 0, count: 0, entries: Vec::new(), blocks: Vec::new(), max: 0 };
        in_order(entries, |entry| open.push(entry.material))?;
        open.close()?;
        let mut words = Vec::new();
        append(&mut words, &[open.count as u32, (open.count >> 32) as u32, open.max.into(), 0])?;
        append(&mut words, &open.entries)?;
        append(&mut words, &open.blocks)?;
        Ok(PalettesBuf { words })
    }

    /// The view that answers look-ups.
    pub fn as_palettes(&self) -> Palettes<'_> {
        let count = u64::from(self.words[0]) | u64::from(self.words[1]) << 32;
        Palettes { words: &self.words, count, blocks: HEADER + count.div_ceil(BLOCK as u64) as usize }
    }

    /// The words, for [`Palettes::new`].
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }
}

/// Closed blocks, and the ids of the one that is open.
#[cfg(feature = "alloc")]
struct Open {
    ids: [MaterialId; BLOCK],
    filled: usize,
    count: u64,
    entries: Vec<u32>,
    blocks: Vec<u32>,
    max: MaterialId,
}

#[cfg(feature = "alloc")]
impl Open {
    fn push(&mut self, id: MaterialId) -> Result<(), BuildError> {
        if self.filled == BLOCK {
            self.close()?;
        }
        self.ids[self.filled] = id;
        self.filled += 1;
        self.count += 1;
        self.max = self.max.max(id);
        Ok(())
    }

    /// Writes the open block, if it holds anything.
    fn close(&mut self) -> Result<(), BuildError> {
        let ids = &self.ids[..core::mem::take(&mut self.filled)];
        let Some(&first) = ids.first() else { return Ok(()) };
        // Number the ids in the order of their first voxels; neighbours are mostly equal.
        let (mut palette, mut len, mut indices, mut last) = ([0; BLOCK], 1, [0u32; BLOCK], 0);
        palette[0] = first;
        for (index, &id) in indices.iter_mut().zip(ids) {
            if palette[last] != id {
                last = palette[..len].iter().position(|p| *p == id).unwrap_or(len);
                if last == len {
                    palette[len] = id;
                    len += 1;
                }
            }
            *index = last as u32;
        }
        if len == 1 {
            return append(&mut self.entries, &[first.into()]);
        }
        let width = bits::width(len as u32 - 1);
        let start = self.blocks.len();
        if start as u64 >= MOST {
            return Err(BuildError::Words { needed: start as u64 });
        }
        append(&mut self.entries, &[width << SHIFT | start as u32])?;
        append(&mut self.blocks, &[0; BLOCK * BITS as usize / 32][..BLOCK * width as usize / 32])?;
        for (k, &index) in (0..).zip(&indices) {
            bits::set(&mut self.blocks[start..], k, width, index);
        }
        for two in palette[..len.next_multiple_of(2)].chunks_exact(2) {
            append(&mut self.blocks, &[u32::from(two[0]) | u32::from(two[1]) << 16])?;
        }
        Ok(())
    }
}
