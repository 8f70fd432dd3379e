//! Filling a table in lent memory. Failing insertions leave it as it was; each step leaves words that
//! [`Table::new`] takes.

use super::range::{Pending, Placed, Range};
use super::{Entry, HEADER, MAX_PROBES, MAX_SLOTS, Table, join, max_len, words_for};
use crate::material::MaterialId;
use crate::morton::Morton;

/// Keys whose home slots are loaded together: enough to keep a core's loads from memory overlapping.
const BATCH: usize = 32;

/// A table that is being filled.
#[derive(Debug)]
pub struct TableMut<'a> {
    words: &'a mut [u32],
    pub(super) slots: u64,
    pub(super) stride: usize,
    pub(super) max_material: MaterialId,
}

/// Why an entry cannot be inserted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum InsertError {
    /// The table is 7/8 full.
    Full {
        /// Slots that are missing for one entry more.
        missing: u64,
    },
    /// An entry would stand more than [`MAX_PROBES`] slots from its home, which only keys made to collide bring about.
    Crowded {
        /// The key that was to be inserted.
        voxel: Morton,
    },
    /// The key has bit 63 set: it is no Morton code.
    NotACode {
        /// The key.
        voxel: Morton,
    },
    /// The heap (or the address space) has no room for the slots.
    Memory {
        /// Bytes asked for.
        bytes: u64,
    },
}

impl core::fmt::Display for InsertError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            InsertError::Full { missing } => {
                write!(f, "the material table is full: at least {missing} more slots are needed")
            }
            InsertError::Crowded { voxel } => {
                write!(f, "voxel {:?} collides with {MAX_PROBES} others in the material table", voxel.decode())
            }
            InsertError::NotACode { voxel } => {
                write!(f, "{:#x} is no Morton code: expected bit 63 to be clear", voxel.0)
            }
            InsertError::Memory { bytes } => write!(f, "no memory for a material table of {bytes} bytes"),
        }
    }
}

impl core::error::Error for InsertError {}

impl<'a> TableMut<'a> {
    /// An empty table in as many of the words as make whole slots; what they held is lost.
    /// [`Table::words_for`] says how many a number of slots takes.
    pub fn new(words: &'a mut [u32], normals: bool) -> Result<TableMut<'a>, InsertError> {
        let stride = if normals { 4 } else { 3 };
        let Some(total) = words.len().checked_sub(HEADER).map(|room| (room / stride) as u64) else {
            return Err(InsertError::Full { missing: 1 });
        };
        let slots = (total / 2).max(total.saturating_sub(u64::from(MAX_PROBES))).min(MAX_SLOTS);
        let words = &mut words[..words_for(slots, stride) as usize];
        words.fill(0);
        Ok(TableMut::in_zeroed(words, slots, stride))
    }

    /// An empty table in exactly the words that its slots take, all of them 0.
    pub(super) fn in_zeroed(words: &'a mut [u32], slots: u64, stride: usize) -> TableMut<'a> {
        debug_assert_eq!(words.len() as u64, words_for(slots, stride));
        (words[0], words[2], words[3]) = (stride as u32, slots as u32, (slots >> 32) as u32);
        TableMut { words, slots, stride, max_material: 0 }
    }

    /// Goes on filling words that a `TableMut` left.
    #[cfg(feature = "alloc")]
    pub(super) fn resume(words: &'a mut [u32], max_material: MaterialId) -> TableMut<'a> {
        let (stride, slots) = (words[0] as usize, join(words[2], words[3]));
        TableMut { words, slots, stride, max_material }
    }

    /// Number of entries.
    pub fn len(&self) -> u64 {
        join(self.words[4], self.words[5])
    }

    /// Whether there is no entry.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of home slots; 7/8 of them can be filled.
    pub fn slots(&self) -> u64 {
        self.slots
    }

    /// The table as it stands, for look-ups.
    pub fn as_table(&self) -> Table<'_> {
        view(self.words, self.max_material)
    }

    /// The filled table.
    pub fn finish(self) -> Table<'a> {
        view(self.words, self.max_material)
    }

    /// Stores the entry of a voxel, in place of the one it has. A table without normals drops the normal.
    pub fn insert(&mut self, voxel: Morton, entry: Entry) -> Result<(), InsertError> {
        self.put(&Pending::new(voxel, entry, self.stride)?)
    }

    /// Inserts all entries in turn; several times as fast as one by one where the table is larger than the caches.
    /// After an error all entries before the refused one are in.
    pub fn insert_all(&mut self, entries: impl IntoIterator<Item = (Morton, Entry)>) -> Result<(), InsertError> {
        in_batches(entries, self.stride, |_| true, |batch| self.put_all(batch))
    }

    /// Inserts the entries that another table's slots hold, in the order of their hashes.
    #[cfg(feature = "alloc")]
    pub(super) fn take_all(&mut self, slots: &[u32]) -> Result<(), InsertError> {
        slots.chunks_exact(self.stride).filter_map(Pending::of_slot).try_for_each(|pending| self.put(&pending))
    }

    /// All slots.
    #[inline]
    pub(super) fn range(&mut self) -> Range<'_> {
        Range { words: &mut self.words[HEADER..], first: 0, slots: self.slots, stride: self.stride }
    }

    fn put_all(&mut self, batch: &[Pending]) -> Result<(), InsertError> {
        self.range().touch(batch);
        batch.iter().try_for_each(|pending| self.put(pending))
    }

    #[inline]
    pub(super) fn put(&mut self, new: &Pending) -> Result<(), InsertError> {
        let len = self.len();
        let full = len >= max_len(self.slots);
        match self.range().place(new, full) {
            Placed::Replaced => {}
            Placed::Added { longest } => self.count(1, longest),
            Placed::Full => return Err(full_by(len + 1, self.slots)),
            Placed::Crowded | Placed::End => return Err(InsertError::Crowded { voxel: new.voxel() }),
        }
        self.max_material = self.max_material.max(new.material);
        Ok(())
    }

    /// Keeps the header in step with entries that were added.
    #[inline]
    pub(super) fn count(&mut self, added: u64, longest: u32) {
        let len = self.len() + added;
        self.words[1] = self.words[1].max(longest);
        (self.words[4], self.words[5]) = (len as u32, (len >> 32) as u32);
    }
}

/// How many slots are missing for `len` entries.
pub(super) fn full_by(len: u64, slots: u64) -> InsertError {
    InsertError::Full { missing: (8 * len).div_ceil(7) - slots }
}

/// Hands entries on in batches, those of them that are said to be wanted. Those before a refused one are handed on too.
#[inline]
pub(super) fn in_batches(
    entries: impl IntoIterator<Item = (Morton, Entry)>,
    stride: usize,
    wanted: impl Fn(&Pending) -> bool,
    mut put_all: impl FnMut(&[Pending]) -> Result<(), InsertError>,
) -> Result<(), InsertError> {
    let mut batch = [Pending::default(); BATCH];
    let mut count = 0;
    for (voxel, entry) in entries {
        match Pending::new(voxel, entry, stride) {
            Ok(pending) => {
                // What is not wanted is overwritten by the next: no branch, as nothing could predict it.
                batch[count] = pending;
                count += usize::from(wanted(&pending));
            }
            Err(error) => {
                put_all(&batch[..count])?;
                return Err(error);
            }
        }
        if count == BATCH {
            put_all(&batch)?;
            count = 0;
        }
    }
    put_all(&batch[..count])
}

/// The view of words that a `TableMut` wrote, without checking them once more.
pub(super) fn view(words: &[u32], max_material: MaterialId) -> Table<'_> {
    Table {
        words,
        slots: join(words[2], words[3]),
        stride: words[0] as usize,
        longest: words[1],
        len: join(words[4], words[5]),
        max_material,
    }
}
