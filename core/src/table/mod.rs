//! The thesis's material map (Pineda 2021, section 4.2): Morton code of a voxel -> material id, with or without a normal.
//!
//! In: entries in any order. Out: flat words whose look-ups neither allocate, panic nor spin.
//!
//! ```text
//! word  0      words per slot: 3, or 4 with normals    slot:  [ code + 1, low ][ code + 1, high ][ material id ]
//!       1      longest probe sequence, 0 to 256               and with normals [ octahedral normal, 0 = none ]
//!       2, 3   slots S (low, high)                            all words 0: empty
//!       4, 5   entries (low, high), at most 7/8 S
//!       6, 7   0
//!       8..    S + min(S, 256) slots
//! ```
//!
//! Ordered linear probing (Amble and Knuth 1974): entries stand in order of their hash, each in the first slot that is
//! neither before its home `hash * S >> 64` nor before its predecessor. The hash (splitmix64's finaliser of code + 1) is
//! one to one and the home grows with it, so the words depend on the set of entries alone, not on the order of insertion.
//! Nothing wraps around: the slots run past the last home by as much as one may be away from it.
//! Differs from the thesis: one flat array that is filled once and then read, where it has a concurrent chained map.

#[cfg(feature = "alloc")]
mod buf;
mod insert;
mod range;
mod split;

#[cfg(feature = "alloc")]
pub use buf::TableBuf;
pub use insert::{InsertError, TableMut};
pub use split::{FilledPart, TablePart};

use crate::material::MaterialId;
use crate::morton::Morton;
use crate::octahedral;

/// Words before the first slot.
pub const HEADER: usize = 8;
/// No entry is further from its home than this many slots, its home counted; only keys made to collide come near.
pub const MAX_PROBES: u32 = 256;
/// More slots than any memory holds; keeps sums of offsets within u64.
const MAX_SLOTS: u64 = 1 << 48;

/// What a voxel's slot holds.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Entry {
    /// Index into the scene's materials.
    pub material: MaterialId,
    /// Outward unit normal, to within [`octahedral::MAX_ERROR`]; `None` if none is stored.
    pub normal: Option<[f32; 3]>,
}

/// A checked view over a table's words.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    words: &'a [u32],
    slots: u64,
    stride: usize,
    longest: u32,
    len: u64,
    max_material: MaterialId,
}

/// Why words are no table. Offsets count words from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TableError {
    /// Fewer words than the header or its slots need.
    Truncated {
        /// Words needed.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// More words than the slots take.
    Trailing {
        /// Words accounted for.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// A header word is out of range or does not agree with the slots.
    Header {
        /// Offset of the word.
        word: u64,
    },
    /// A slot holds no Morton code, no material id, no normal, or is empty but for some bits.
    Slot {
        /// Offset of its first word.
        word: u64,
    },
    /// An entry is not where the order of hashes puts it.
    Order {
        /// Offset of its first word.
        word: u64,
    },
}

impl core::fmt::Display for TableError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            TableError::Truncated { expected, found } => {
                write!(f, "the material table is cut short: expected {expected} words, found {found}")
            }
            TableError::Trailing { expected, found } => {
                write!(f, "the material table has words to spare: expected {expected}, found {found}")
            }
            TableError::Header { word } => {
                write!(f, "word {word} of the material table's header is out of range or disagrees with the slots")
            }
            TableError::Slot { word } => write!(f, "the slot at word {word} of the material table is no entry"),
            TableError::Order { word } => {
                write!(f, "the entry at word {word} of the material table is not where its hash belongs")
            }
        }
    }
}

impl core::error::Error for TableError {}

impl<'a> Table<'a> {
    /// Checks every slot in O(slots), without heap. After `Ok` no look-up can panic, nor read more than
    /// [`Table::longest_probe`] slots.
    pub fn new(words: &'a [u32]) -> Result<Table<'a>, TableError> {
        let found = words.len() as u64;
        let Some(header) = words.first_chunk::<HEADER>() else {
            return Err(TableError::Truncated { expected: HEADER as u64, found });
        };
        let stride = match header[0] {
            3 | 4 => header[0] as usize,
            _ => return Err(TableError::Header { word: 0 }),
        };
        let (slots, len) = (join(header[2], header[3]), join(header[4], header[5]));
        if slots > MAX_SLOTS {
            return Err(TableError::Header { word: 2 });
        }
        if let Some(word) = (6..HEADER).find(|&i| header[i] != 0) {
            return Err(TableError::Header { word: word as u64 });
        }
        let expected = words_for(slots, stride);
        if found < expected {
            return Err(TableError::Truncated { expected, found });
        }
        if found > expected {
            return Err(TableError::Trailing { expected, found });
        }

        // Every entry must stand where the order puts it; that is also what makes look-ups find it.
        let mut table = Table { words, slots, stride, longest: 0, len: 0, max_material: 0 };
        let (mut last_hash, mut first_free) = (0, 0);
        for (at, slot) in words[HEADER..].chunks_exact(stride).enumerate() {
            let word = (HEADER + at * stride) as u64;
            let key = join(slot[0], slot[1]);
            let normal = slot.get(3).copied().unwrap_or(0);
            if key == 0 {
                if slot[2] | normal != 0 {
                    return Err(TableError::Slot { word });
                }
                continue;
            }
            let material = MaterialId::try_from(slot[2]).map_err(|_| TableError::Slot { word })?;
            if key > 1 << 63 || (normal != 0 && !octahedral::is_valid(normal)) {
                return Err(TableError::Slot { word });
            }
            let hash = mix(key);
            let (at, home) = (at as u64, home(hash, slots));
            if hash <= last_hash || at != home.max(first_free) || at - home >= u64::from(MAX_PROBES) {
                return Err(TableError::Order { word });
            }
            (last_hash, first_free) = (hash, at + 1);
            table.longest = table.longest.max((at - home) as u32 + 1);
            table.len += 1;
            table.max_material = table.max_material.max(material);
        }
        if table.longest != header[1] {
            return Err(TableError::Header { word: 1 });
        }
        if table.len != len || len > max_len(slots) {
            return Err(TableError::Header { word: 4 });
        }
        Ok(table)
    }

    /// Slots that hold `voxels` entries at a load of one half, where a look-up reads 1.5 slots on average.
    pub const fn slots_for(voxels: u64) -> u64 {
        voxels.saturating_mul(2)
    }

    /// Words of a table with this many slots.
    pub const fn words_for(slots: u64, normals: bool) -> u64 {
        words_for(slots, if normals { 4 } else { 3 })
    }

    /// The words themselves; `Table::new(table.words())` is the same view.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Number of entries.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Whether there is no entry.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of home slots; those past the last home do not count.
    pub fn slots(&self) -> u64 {
        self.slots
    }

    /// Whether slots have room for a normal.
    pub fn has_normals(&self) -> bool {
        self.stride == 4
    }

    /// The most slots that any look-up reads.
    pub fn longest_probe(&self) -> u32 {
        self.longest
    }

    /// No material id in the table is above this one.
    pub fn max_material(&self) -> MaterialId {
        self.max_material
    }

    /// The entry of a voxel; `None` if there is none.
    #[inline]
    pub fn get(&self, voxel: Morton) -> Option<Entry> {
        let slot = self.find(voxel).0?;
        Some(Entry { material: slot[2] as MaterialId, normal: slot.get(3).and_then(|&n| octahedral::decode(n)) })
    }

    /// How many slots the look-up of a voxel reads, whether it is there or not; for statistics.
    pub fn probes(&self, voxel: Morton) -> u32 {
        self.find(voxel).1
    }

    /// The slot of a voxel, and how many slots were read.
    #[inline]
    fn find(&self, voxel: Morton) -> (Option<&'a [u32]>, u32) {
        let key = voxel.0.wrapping_add(1);
        let first = HEADER + home(mix(key), self.slots) as usize * self.stride;
        let slots = self.words.get(first..).unwrap_or(&[]).chunks_exact(self.stride);
        let mut probes = 0;
        for slot in slots.take(self.longest as usize) {
            probes += 1;
            match join(slot[0], slot[1]) {
                0 => break, // asked before equality: the key of u64::MAX, which is no code, is 0 too
                stored if stored == key => return (Some(slot), probes),
                _ => {}
            }
        }
        (None, probes)
    }
}

/// splitmix64's finaliser (Steele, Lea and Flood 2014, in Stafford's variant 13): one to one, and every bit of the key
/// reaches the high bits, which choose the home.
#[inline]
const fn mix(key: u64) -> u64 {
    let z = (key ^ key >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// The first slot for a hash: range reduction by a product (Lemire 2019), for any number of slots.
#[inline]
const fn home(hash: u64, slots: u64) -> u64 {
    ((hash as u128 * slots as u128) >> 64) as u64
}

/// Slots past the last home. As many as there are homes always suffice.
const fn slack(slots: u64) -> u64 {
    if slots < MAX_PROBES as u64 { slots } else { MAX_PROBES as u64 }
}

const fn words_for(slots: u64, stride: usize) -> u64 {
    slots.saturating_add(slack(slots)).saturating_mul(stride as u64).saturating_add(HEADER as u64)
}

/// The most entries that a number of slots takes: 7/8.
const fn max_len(slots: u64) -> u64 {
    slots - slots.div_ceil(8)
}

#[inline]
const fn join(low: u32, high: u32) -> u64 {
    low as u64 | (high as u64) << 32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First outputs of the SplitMix64 generator with seed 0, as published with it.
    #[test]
    fn mix_is_splitmix64() {
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        let outputs = [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f];
        for (i, output) in outputs.into_iter().enumerate() {
            assert_eq!(mix(GOLDEN.wrapping_mul(i as u64 + 1)), output);
        }
    }

    #[test]
    fn homes_cover_all_slots_and_no_more() {
        for slots in [1, 3, 1000, MAX_SLOTS] {
            assert_eq!(home(0, slots), 0);
            assert_eq!(home(u64::MAX, slots), slots - 1);
        }
        assert_eq!([0, 1, 2, 8, 9, 16].map(max_len), [0, 0, 1, 7, 7, 14]);
    }

    #[test]
    fn sizes_that_no_memory_holds_do_not_wrap() {
        assert_eq!(Table::words_for(Table::slots_for(u64::MAX), true), u64::MAX);
        let mut words = [0; HEADER];
        (words[0], words[3]) = (3, 1 << 16);
        assert!(matches!(Table::new(&words), Err(TableError::Truncated { found: 8, .. })));
        words[3] = u32::MAX;
        assert_eq!(Table::new(&words).unwrap_err(), TableError::Header { word: 2 });
    }
}
