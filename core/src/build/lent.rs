//! The reducer over lent memory, for machines without a heap.
//!
//! Scratch memory holds records in the order of their first visit, and a set of their offsets in its last quarter:
//!
//! ```text
//! [ next record of the level ][ final offset ][ level << 8 | child mask ][ brick's two words | children's records ]...
//! ```

use super::{BuildError, Reducer, Store, write_header};
use crate::dag::{BRICK_LEVEL, HEADER, NODE, ONES};
use crate::morton::Morton;

/// Builds a DAG of `2^depth` voxels a side from bricks in ascending Morton order (code of the first voxel, mask) into
/// `words`, and says how many of them it used; the rest is untouched. Allocates nothing.
///
/// [`words_bound`] and [`scratch_words`] say how much memory is enough for any set of bricks.
pub fn build_into(
    bricks: impl IntoIterator<Item = (Morton, u64)>,
    depth: u8,
    words: &mut [u32],
    scratch: &mut [u32],
) -> Result<usize, BuildError> {
    let mut reducer = Reducer::new(depth)?;
    let mut store = Lent::new(scratch);
    for (code, mask) in bricks {
        reducer.push(&mut store, code, mask)?;
    }
    reducer.finish(&mut store)?;
    store.lay_out(depth, words)
}

/// Words that are enough for the DAG of any `bricks` bricks at a depth.
pub const fn words_bound(bricks: usize, depth: u8) -> usize {
    // Each level has at most as many nodes as bricks, and as many child words as the level below has nodes.
    HEADER + 2 * bricks + 2 * bricks * depth.saturating_sub(BRICK_LEVEL) as usize
}

/// Words of scratch memory that are enough for building any `bricks` bricks at a depth.
pub const fn scratch_words(bricks: usize, depth: u8) -> usize {
    let levels = depth.saturating_sub(BRICK_LEVEL) as usize;
    let records = 5 * bricks + 4 * bricks * levels;
    // A quarter of the memory is the set: at least four slots for three records, of four words or more each.
    records + records.div_ceil(3) + 16
}

const NONE: u32 = u32::MAX;
/// Words of a record before its payload.
const HEAD: usize = 3;

struct Lent<'a> {
    records: &'a mut [u32],
    /// Open addressing over offsets of records; [`NONE`] is free.
    set: &'a mut [u32],
    used: usize,
    in_set: usize,
    /// First and last record of each level, and their words in the final layout.
    lists: [(u32, u32, u64); 22],
}

impl<'a> Lent<'a> {
    fn new(scratch: &'a mut [u32]) -> Self {
        // Offsets must fit child words.
        let len = scratch.len().min(NODE as usize);
        let (records, set) = scratch[..len].split_at_mut(len - len / 4);
        set.fill(NONE);
        Lent { records, set, used: 0, in_set: 0, lists: [(NONE, NONE, 0); 22] }
    }

    /// Finds or adds the record with this head and payload.
    fn intern(&mut self, head: u32, payload: &[u32]) -> Result<u32, BuildError> {
        let mut hash = u64::from(head);
        for &word in payload {
            hash = (hash ^ u64::from(word)).wrapping_mul(0x9fb2_1c65_1e98_df25);
            hash ^= hash >> 29;
        }
        // Probe from the hash's place on; the set is never full, so a free slot ends the search.
        let slots = self.set.len();
        if (self.in_set + 1) * 4 > slots * 3 {
            return Err(self.too_small(payload.len()));
        }
        let mut slot = ((u128::from(hash.wrapping_mul(0x9e37_79b9_7f4a_7c15)) * slots as u128) >> 64) as usize;
        while self.set[slot] != NONE {
            let record = self.set[slot] as usize;
            let end = record + HEAD + payload.len();
            if self.records[record + 2] == head && self.records.get(record + HEAD..end) == Some(payload) {
                return Ok(record as u32);
            }
            slot = if slot + 1 == slots { 0 } else { slot + 1 };
        }
        // Add it, and hang it behind the last record of its level.
        let (record, end) = (self.used, self.used + HEAD + payload.len());
        if end > self.records.len() {
            return Err(self.too_small(payload.len()));
        }
        self.records[record..record + HEAD].copy_from_slice(&[NONE, NONE, head]);
        self.records[record + HEAD..end].copy_from_slice(payload);
        self.set[slot] = record as u32;
        self.in_set += 1;
        self.used = end;
        let (first, last, words) = &mut self.lists[(head >> 8) as usize];
        if *first == NONE {
            *first = record as u32;
        } else {
            self.records[*last as usize] = record as u32;
        }
        *last = record as u32;
        *words += if head >> 8 == u32::from(BRICK_LEVEL) { 2 } else { 1 + payload.len() as u64 };
        Ok(record as u32)
    }

    fn too_small(&self, payload: usize) -> BuildError {
        let records = (self.used + HEAD + payload) as u64;
        BuildError::Scratch { needed: (records + records / 3).max((self.records.len() + self.set.len()) as u64) + 1 }
    }

    /// Writes header, bricks and nodes, level by level.
    fn lay_out(self, depth: u8, words: &mut [u32]) -> Result<usize, BuildError> {
        let level_words: [u64; 22] = core::array::from_fn(|level| self.lists[level].2);
        let total = HEADER as u64 + level_words.iter().sum::<u64>();
        if total > words.len() as u64 {
            return Err(BuildError::Words { needed: total });
        }
        let bricks = level_words[BRICK_LEVEL as usize] / 2;
        write_header(&mut words[..HEADER], depth, bricks, &level_words).ok_or(BuildError::Words { needed: total })?;
        let mut at = HEADER;
        for level in usize::from(BRICK_LEVEL)..22 {
            let mut record = self.lists[level].0;
            while record != NONE {
                let r = record as usize;
                let head = self.records[r + 2];
                self.records[r + 1] = at as u32;
                if level == usize::from(BRICK_LEVEL) {
                    words[at..at + 2].copy_from_slice(&self.records[r + HEAD..r + HEAD + 2]);
                    at += 2;
                } else {
                    let children = ONES[(head & 0xff) as usize] as usize;
                    words[at] = NODE | head & 0xff;
                    for i in 0..children {
                        words[at + 1 + i] = self.records[self.records[r + HEAD + i] as usize + 1];
                    }
                    at += 1 + children;
                }
                record = self.records[r];
            }
        }
        Ok(at)
    }
}

impl Store for Lent<'_> {
    fn brick(&mut self, mask: u64) -> Result<u32, BuildError> {
        self.intern(u32::from(BRICK_LEVEL) << 8, &[mask as u32, (mask >> 32) as u32])
    }

    fn node(&mut self, level: u8, node: &[u32]) -> Result<u32, BuildError> {
        self.intern(u32::from(level) << 8 | node[0] & 0xff, &node[1..])
    }
}
