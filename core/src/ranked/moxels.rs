//! Williams's moxel table: what every filled voxel is made of, in Morton order (Williams 2015; Pineda 2021, section
//! 3.3).
//!
//! Differs from the source: a normal takes 4 bytes (octahedral), where he has three floats; without normals entries are
//! those of the thesis, 4 bytes an id.
//!
//! ```text
//! word  0      words of an entry: 1, or 2 with normals      entry: [ material id ]
//!       1      largest id                                          and with normals [ octahedral normal, 0 = none ]
//!       2, 3   number of entries (low, high)
//!       4..    entries
//! ```

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

use super::{RankedError, Values};
#[cfg(feature = "alloc")]
use super::{append, in_order};
#[cfg(feature = "alloc")]
use crate::build::BuildError;
use crate::material::MaterialId;
#[cfg(feature = "alloc")]
use crate::morton::Morton;
use crate::octahedral;
#[cfg(feature = "alloc")]
use crate::table::Entry;

/// Words before the entries.
const HEADER: usize = 4;

/// A checked view over a moxel table.
#[derive(Clone, Copy, Debug)]
pub struct Moxels<'a> {
    words: &'a [u32],
    stride: usize,
    count: u64,
}

impl<'a> Moxels<'a> {
    /// Checks words in O(entries), without heap; after `Ok` no look-up can panic.
    pub fn new(words: &'a [u32]) -> Result<Moxels<'a>, RankedError> {
        let found = words.len() as u64;
        let Some(&[stride, max, low, high]) = words.first_chunk::<HEADER>() else {
            return Err(RankedError::Length { expected: HEADER as u64, found });
        };
        if !(1..=2).contains(&stride) {
            return Err(RankedError::Header { word: 0 });
        }
        let count = u64::from(low) | u64::from(high) << 32;
        let expected = count.saturating_mul(stride.into()).saturating_add(HEADER as u64);
        if found != expected {
            return Err(RankedError::Length { expected, found });
        }
        let mut largest = 0;
        for (i, entry) in words[HEADER..].chunks_exact(stride as usize).enumerate() {
            let normal = entry.get(1).copied().unwrap_or(0);
            if entry[0] > MaterialId::MAX.into() || normal != 0 && !octahedral::is_valid(normal) {
                return Err(RankedError::Value { word: (HEADER + i * stride as usize) as u64 });
            }
            largest = largest.max(entry[0]);
        }
        if largest != max {
            return Err(RankedError::Header { word: 1 });
        }
        Ok(Moxels { words, stride: stride as usize, count })
    }

    /// The words; `Moxels::new(moxels.words())` is the same view.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Whether entries have room for a normal.
    pub fn has_normals(&self) -> bool {
        self.stride == 2
    }

    /// The entry of a rank.
    #[inline]
    fn entry(&self, rank: u64) -> Option<&'a [u32]> {
        let first = HEADER + usize::try_from(rank.min(self.count)).ok()? * self.stride;
        self.words.get(first..first + self.stride)
    }
}

impl Values for Moxels<'_> {
    fn count(&self) -> u64 {
        self.count
    }

    #[inline]
    fn id(&self, rank: u64) -> MaterialId {
        self.entry(rank).map_or(0, |entry| entry[0] as MaterialId)
    }

    #[inline]
    fn normal(&self, rank: u64) -> Option<[f32; 3]> {
        octahedral::decode(*self.entry(rank)?.get(1)?)
    }

    fn max_material(&self) -> MaterialId {
        self.words[1] as MaterialId
    }
}

/// A moxel table that owns its words.
#[cfg(feature = "alloc")]
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MoxelsBuf {
    words: Vec<u32>,
}

#[cfg(feature = "alloc")]
impl MoxelsBuf {
    /// The materials, and if asked for the normals, of entries whose codes ascend.
    pub fn from_entries(
        entries: impl IntoIterator<Item = (Morton, Entry)>,
        normals: bool,
    ) -> Result<MoxelsBuf, BuildError> {
        let stride = if normals { 2 } else { 1 };
        let mut words = Vec::new();
        append(&mut words, &[stride, 0, 0, 0])?;
        let mut count = 0u64;
        in_order(entries, |entry| {
            let normal = entry.normal.map_or(0, octahedral::encode);
            words[1] = words[1].max(entry.material.into());
            count += 1;
            append(&mut words, &[entry.material.into(), normal][..stride as usize])
        })?;
        (words[2], words[3]) = (count as u32, (count >> 32) as u32);
        Ok(MoxelsBuf { words })
    }

    /// The view that answers look-ups.
    pub fn as_moxels(&self) -> Moxels<'_> {
        let stride = self.words[0] as usize;
        Moxels { words: &self.words, stride, count: ((self.words.len() - HEADER) / stride) as u64 }
    }

    /// The words, for [`Moxels::new`].
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }
}
