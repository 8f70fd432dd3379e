//! Records that are kept once and named by their number, in the order of first appearance.

use alloc::vec::Vec;
use core::hash::{BuildHasher, Hasher};
use hashbrown::HashTable;

use super::{BuildError, Mix};

/// Records of one list are fewer: their numbers leave four bits of a word free.
const MOST: u32 = 1 << 28;

/// A list of different records of `N` words.
pub(crate) struct Interned<const N: usize> {
    pub list: Vec<[u32; N]>,
    set: HashTable<u32>,
}

impl<const N: usize> Interned<N> {
    pub(crate) const fn new() -> Interned<N> {
        Interned { list: Vec::new(), set: HashTable::new() }
    }

    /// The number of this record, which is added if it is new.
    pub(crate) fn number(&mut self, record: [u32; N]) -> Result<u32, BuildError> {
        let hash = |record: &[u32; N]| {
            let mut hasher = Mix(0).build_hasher();
            record.iter().for_each(|word| hasher.write_u32(*word));
            hasher.finish()
        };
        let key = hash(&record);
        if let Some(found) = self.set.find(key, |&i| self.list[i as usize] == record) {
            return Ok(*found);
        }
        let number = u32::try_from(self.list.len())
            .ok()
            .filter(|n| *n < MOST)
            .ok_or(BuildError::Words { needed: u64::from(MOST) * N as u64 })?;
        let len = self.list.len() as u64 + 1;
        self.list.try_reserve(1).map_err(|_| BuildError::Memory { bytes: len * 4 * N as u64 })?;
        let list = &self.list;
        self.set.try_reserve(1, |&i| hash(&list[i as usize])).map_err(|_| BuildError::Memory { bytes: 5 * len })?;
        self.list.push(record);
        let list = &self.list;
        self.set.insert_unique(key, number, |&i| hash(&list[i as usize]));
        Ok(number)
    }

    /// Bytes of the list and the set.
    pub(crate) fn bytes(&self) -> u64 {
        self.list.capacity() as u64 * 4 * N as u64 + self.set.capacity() as u64 * 6
    }
}
