//! Filling a table in lent memory. Failing insertions leave it as it was; each step leaves words that
//! [`Table::new`] takes.

use super::{Entry, HEADER, MAX_PROBES, MAX_SLOTS, Table, home, join, max_len, mix, words_for};
use crate::material::MaterialId;
use crate::morton::Morton;
use crate::octahedral;

/// Keys whose home slots are loaded together: enough to keep a core's loads from memory overlapping.
pub(super) const BATCH: usize = 32;

/// A table that is being filled.
#[derive(Debug)]
pub struct TableMut<'a> {
    words: &'a mut [u32],
    slots: u64,
    stride: usize,
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

/// An entry on its way into the table.
#[derive(Clone, Copy, Default)]
struct Pending {
    key: u64,
    hash: u64,
    material: MaterialId,
    normal: u32,
}

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
        let pending = self.prepare(voxel, entry)?;
        self.put(&pending)
    }

    /// Inserts all entries in turn; several times as fast as one by one where the table is larger than the caches.
    /// After an error all entries before the refused one are in.
    pub fn insert_all(&mut self, entries: impl IntoIterator<Item = (Morton, Entry)>) -> Result<(), InsertError> {
        let mut entries = entries.into_iter();
        let mut batch = [Pending::default(); BATCH];
        loop {
            let mut count = 0;
            let mut refused = Ok(());
            for (pending, (voxel, entry)) in batch.iter_mut().zip(&mut entries) {
                match self.prepare(voxel, entry) {
                    Ok(prepared) => *pending = prepared,
                    Err(error) => {
                        refused = Err(error);
                        break;
                    }
                }
                count += 1;
            }
            self.put_all(&batch[..count])?;
            refused?;
            if count < BATCH {
                return Ok(());
            }
        }
    }

    /// Inserts the entries that another table's slots hold, in the order of their hashes.
    #[cfg(feature = "alloc")]
    pub(super) fn take_all(&mut self, slots: &[u32]) -> Result<(), InsertError> {
        for slot in slots.chunks_exact(self.stride) {
            let key = join(slot[0], slot[1]);
            if key != 0 {
                let normal = slot.get(3).copied().unwrap_or(0);
                self.put(&Pending { key, hash: mix(key), material: slot[2] as MaterialId, normal })?;
            }
        }
        Ok(())
    }

    /// Hashes a key and packs its value.
    #[inline]
    fn prepare(&self, voxel: Morton, entry: Entry) -> Result<Pending, InsertError> {
        if voxel.0 >> 63 != 0 {
            return Err(InsertError::NotACode { voxel });
        }
        let key = voxel.0 + 1;
        let normal = match entry.normal {
            Some(normal) if self.stride == 4 => octahedral::encode(normal),
            _ => 0,
        };
        Ok(Pending { key, hash: mix(key), material: entry.material, normal })
    }

    /// Inserts a batch, its home slots loaded beforehand so that the loads overlap.
    fn put_all(&mut self, batch: &[Pending]) -> Result<(), InsertError> {
        let mut touched = 0;
        for pending in batch {
            touched |= self.words.get(self.word(home(pending.hash, self.slots))).copied().unwrap_or(0);
        }
        core::hint::black_box(touched);
        batch.iter().try_for_each(|pending| self.put(pending))
    }

    /// Inserts one entry where the order of hashes puts it.
    #[inline]
    fn put(&mut self, new: &Pending) -> Result<(), InsertError> {
        let crowded = InsertError::Crowded { voxel: Morton(new.key - 1) };
        let first = home(new.hash, self.slots);

        // Find the place: behind all smaller hashes.
        let mut place = first;
        loop {
            let key = self.key(place);
            if key == new.key {
                self.write(place, new);
                return Ok(());
            }
            if key == 0 || mix(key) > new.hash {
                break;
            }
            place += 1;
            if place - first == u64::from(MAX_PROBES) {
                return Err(crowded);
            }
        }
        let len = self.len();
        if len >= max_len(self.slots) {
            return Err(InsertError::Full { missing: (8 * (len + 1)).div_ceil(7) - self.slots });
        }

        // Find the first empty slot behind it, and how far from home the entries up to there will be.
        let mut longest = place - first + 1;
        let mut end = place;
        loop {
            let key = self.key(end);
            if key == 0 {
                break;
            }
            end += 1;
            longest = longest.max(end - home(mix(key), self.slots) + 1);
            if longest > u64::from(MAX_PROBES) {
                return Err(crowded);
            }
        }

        // Move them up by one and fill the gap.
        let (from, to) = (self.word(place), self.word(end));
        self.words.copy_within(from..to, from + self.stride);
        self.write(place, new);
        self.words[1] = self.words[1].max(longest as u32);
        (self.words[4], self.words[5]) = ((len + 1) as u32, ((len + 1) >> 32) as u32);
        Ok(())
    }

    /// Offset of a slot's first word.
    #[inline]
    fn word(&self, slot: u64) -> usize {
        HEADER + slot as usize * self.stride
    }

    /// The key in a slot, 0 if it is empty. All slots that insertion asks for exist: up to the first empty one behind a
    /// home there are fewer than the slots past the last home.
    #[inline]
    fn key(&self, slot: u64) -> u64 {
        let word = self.word(slot);
        match self.words.get(word..word + 2) {
            Some(&[low, high]) => join(low, high),
            _ => 0,
        }
    }

    #[inline]
    fn write(&mut self, slot: u64, new: &Pending) {
        let word = self.word(slot);
        let values = [new.key as u32, (new.key >> 32) as u32, u32::from(new.material), new.normal];
        self.words[word..word + self.stride].copy_from_slice(&values[..self.stride]);
        self.max_material = self.max_material.max(new.material);
    }
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
