//! A table that owns its words and grows. Allocation is fallible: no room is an error, never an abort.

use alloc::vec::Vec;

use super::insert::{InsertError, TableMut, view};
use super::{Entry, HEADER, Table, words_for};
use crate::material::MaterialId;
use crate::morton::Morton;

/// A growing table. It doubles when it would be more than half full, where the mean look-up reads 1.5 slots.
///
/// Its words depend on the set of entries and on the capacity asked for at first, not on the order of insertion.
#[derive(PartialEq, Eq, Debug)]
pub struct TableBuf {
    words: Vec<u32>,
    max_material: MaterialId,
}

impl TableBuf {
    /// An empty table that takes `voxels` entries without growing.
    pub fn new(voxels: u64, normals: bool) -> Result<TableBuf, InsertError> {
        TableBuf::with_slots(Table::slots_for(voxels.max(1)), if normals { 4 } else { 3 })
    }

    fn with_slots(slots: u64, stride: usize) -> Result<TableBuf, InsertError> {
        let words_needed = words_for(slots, stride);
        let missing = InsertError::Memory { bytes: words_needed.saturating_mul(4) };
        let len = usize::try_from(words_needed).map_err(|_| missing)?;
        let mut words = Vec::new();
        words.try_reserve_exact(len).map_err(|_| missing)?;
        words.resize(len, 0);
        TableMut::in_zeroed(&mut words, slots, stride);
        Ok(TableBuf { words, max_material: 0 })
    }

    /// The table as it stands, for look-ups.
    pub fn as_table(&self) -> Table<'_> {
        view(&self.words, self.max_material)
    }

    /// The words, for [`Table::new`].
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }

    /// Lends the table to `insert`, which may fill it to 7/8 but cannot make it grow; this is the way to
    /// [`TableMut::split`].
    pub fn fill<T>(&mut self, insert: impl FnOnce(&mut TableMut<'_>) -> T) -> T {
        let mut table = TableMut::resume(&mut self.words, self.max_material);
        let result = insert(&mut table);
        self.max_material = table.max_material;
        result
    }

    /// Stores the entry of a voxel, in place of the one it has; see [`TableMut::insert`].
    pub fn insert(&mut self, voxel: Morton, entry: Entry) -> Result<(), InsertError> {
        if self.room() == 0 && self.as_table().get(voxel).is_none() {
            self.grow()?;
        }
        self.fill(|table| table.insert(voxel, entry))
    }

    /// Inserts all entries in turn; see [`TableMut::insert_all`].
    pub fn insert_all(&mut self, entries: impl IntoIterator<Item = (Morton, Entry)>) -> Result<(), InsertError> {
        let mut entries = entries.into_iter();
        loop {
            // As many as fit for certain go in at once; at the brink one by one, as a key that is there needs no room.
            let mut taken = 0;
            let room = self.room();
            let some = (&mut entries).take(usize::try_from(room).unwrap_or(usize::MAX)).inspect(|_| taken += 1);
            self.fill(|table| table.insert_all(some))?;
            if taken < room {
                return Ok(());
            }
            match entries.next() {
                Some((voxel, entry)) => self.insert(voxel, entry)?,
                None => return Ok(()),
            }
        }
    }

    /// How many entries fit until the table is half full.
    fn room(&self) -> u64 {
        let table = self.as_table();
        (table.slots() / 2).saturating_sub(table.len())
    }

    /// Twice the slots. The entries move in the order of their hashes, so both tables are walked from front to back.
    fn grow(&mut self) -> Result<(), InsertError> {
        let old = self.as_table();
        let mut grown = TableBuf::with_slots(old.slots().saturating_mul(2), old.stride)?;
        let mut table = TableMut::resume(&mut grown.words, 0);
        table.take_all(&self.words[HEADER..])?;
        grown.max_material = self.max_material;
        *self = grown;
        Ok(())
    }
}
