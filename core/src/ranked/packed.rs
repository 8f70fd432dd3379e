//! Material ids by rank, each in as many bits as the largest needs.
//!
//! ```text
//! word  0      bits B of an id: those of the largest one, 0 to 16
//!       1      0
//!       2, 3   number of ids (low, high)
//!       4..    ids: id i has bits i B to (i + 1) B, low bits and low words first; bits to spare are 0
//! ```

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

/// Words before the ids.
pub const HEADER: usize = 4;

/// A checked view over packed ids.
#[derive(Clone, Copy, Debug)]
pub struct Packed<'a> {
    words: &'a [u32],
    bits: u32,
    count: u64,
    max: MaterialId,
}

impl<'a> Packed<'a> {
    /// Checks words in O(ids), without heap; after `Ok` no look-up can panic.
    pub fn new(words: &'a [u32]) -> Result<Packed<'a>, RankedError> {
        let found = words.len() as u64;
        let Some(&[bits, reserved, low, high]) = words.first_chunk::<HEADER>() else {
            return Err(RankedError::Length { expected: HEADER as u64, found });
        };
        let count = u64::from(low) | u64::from(high) << 32;
        if bits > MaterialId::BITS {
            return Err(RankedError::Header { word: 0 });
        }
        if reserved != 0 {
            return Err(RankedError::Header { word: 1 });
        }
        if count > MAX_COUNT {
            return Err(RankedError::Header { word: 3 });
        }
        let expected = bits::words_for(count, bits).saturating_add(HEADER as u64);
        if found != expected {
            return Err(RankedError::Length { expected, found });
        }
        // Where ids take no bits they are all 0, however many there are.
        let mut packed = Packed { words, bits, count, max: 0 };
        packed.max = (0..if bits == 0 { 0 } else { count }).map(|rank| packed.id(rank)).max().unwrap_or(0);
        if bits::width(packed.max.into()) != bits {
            return Err(RankedError::Header { word: 0 });
        }
        let spare = 32 * (found - HEADER as u64) - count * u64::from(bits);
        if spare > 0 && words.last().is_some_and(|last| last.leading_zeros() < spare as u32) {
            return Err(RankedError::Value { word: found - 1 });
        }
        Ok(packed)
    }

    /// The words, as they stand in a file.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Bits of an id.
    pub fn bits(&self) -> u32 {
        self.bits
    }
}

impl Values for Packed<'_> {
    fn count(&self) -> u64 {
        self.count
    }

    #[inline]
    fn id(&self, rank: u64) -> MaterialId {
        if rank >= self.count {
            return 0;
        }
        bits::get(&self.words[HEADER..], rank, self.bits) as MaterialId
    }

    #[inline]
    fn normal(&self, _: u64) -> Option<[f32; 3]> {
        None
    }

    fn max_material(&self) -> MaterialId {
        self.max
    }
}

/// Packed ids that own their words, and grow. The words depend on the ids alone.
#[cfg(feature = "alloc")]
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PackedBuf {
    words: Vec<u32>,
    count: u64,
    max: MaterialId,
}

#[cfg(feature = "alloc")]
impl PackedBuf {
    /// No ids as yet.
    pub fn new() -> Result<PackedBuf, BuildError> {
        PackedBuf::with_bits(0, 0)
    }

    /// The materials of entries whose codes ascend.
    pub fn from_entries(entries: impl IntoIterator<Item = (Morton, Entry)>) -> Result<PackedBuf, BuildError> {
        let mut packed = PackedBuf::new()?;
        in_order(entries, |entry| packed.push(entry.material))?;
        Ok(packed)
    }

    fn with_bits(bits: u32, words: u64) -> Result<PackedBuf, BuildError> {
        let mut list = Vec::new();
        let missing = BuildError::Memory { bytes: 4 * words };
        list.try_reserve(usize::try_from(words).map_err(|_| missing)?).map_err(|_| missing)?;
        append(&mut list, &[bits, 0, 0, 0])?;
        Ok(PackedBuf { words: list, count: 0, max: 0 })
    }

    /// Adds the id of the voxel of the next rank. After an error the ids are those before.
    #[inline]
    pub fn push(&mut self, id: MaterialId) -> Result<(), BuildError> {
        let bits = self.words[0];
        let wider = bits::width(id.into());
        if wider > bits {
            // Pack anew; that happens at most 16 times.
            let mut wide = PackedBuf::with_bits(wider, HEADER as u64 + bits::words_for(self.count + 1, wider))?;
            let old = self.as_packed();
            (0..old.count()).try_for_each(|rank| wide.add(old.id(rank)))?;
            *self = wide;
        }
        self.add(id)
    }

    fn add(&mut self, id: MaterialId) -> Result<(), BuildError> {
        let bits = self.words[0];
        while (self.words.len() - HEADER) as u64 * 32 < (self.count + 1) * u64::from(bits) {
            append(&mut self.words, &[0])?;
        }
        bits::set(&mut self.words[HEADER..], self.count, bits, id.into());
        self.count += 1;
        self.max = self.max.max(id);
        (self.words[2], self.words[3]) = (self.count as u32, (self.count >> 32) as u32);
        Ok(())
    }

    /// The view that answers look-ups.
    pub fn as_packed(&self) -> Packed<'_> {
        Packed { words: &self.words, bits: self.words[0], count: self.count, max: self.max }
    }

    /// The words, for [`Packed::new`].
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }
}
