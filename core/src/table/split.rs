//! Several threads fill one table: each takes the entries of one range of homes, hence of one range of slots.
//!
//! A part never writes behind its slots: an entry that would push something out waits in the part, and [`TableMut::join`]
//! inserts those few at the end. So parts share nothing, and the words are those that one thread writes.

use super::insert::{InsertError, TableMut, full_by, in_batches};
use super::range::{Pending, Placed, Range};
use super::{Entry, MAX_PROBES, home, max_len};
use crate::material::MaterialId;
use crate::morton::Morton;

/// The slots of one range of homes, for one thread.
pub struct TablePart<'a> {
    range: Range<'a>,
    homes_end: u64,
    filled: FilledPart,
}

/// What a thread did to its part; [`TableMut::join`] needs all of them.
#[derive(Clone, Copy, Debug)]
pub struct FilledPart {
    added: u64,
    longest: u32,
    max_material: MaterialId,
    waiting: [Pending; MAX_PROBES as usize],
    waiting_len: usize,
}

impl<'a> TablePart<'a> {
    /// Inserts those of the entries that belong to this part and passes over the others; see
    /// [`TableMut::insert_all`]. Every part is to be given all entries.
    pub fn insert_all(&mut self, entries: impl IntoIterator<Item = (Morton, Entry)>) -> Result<(), InsertError> {
        let (stride, slots, first, end) = (self.range.stride, self.range.slots, self.range.first, self.homes_end);
        let mine = |pending: &Pending| {
            let home = home(pending.hash, slots);
            (first <= home) & (home < end)
        };
        in_batches(entries, stride, mine, |batch| {
            self.range.touch(batch);
            batch.iter().try_for_each(|pending| self.put(pending))
        })
    }

    /// Gives the slots back.
    pub fn finish(self) -> FilledPart {
        self.filled
    }

    #[inline]
    fn put(&mut self, new: &Pending) -> Result<(), InsertError> {
        let filled = &mut self.filled;
        match self.range.place(new, false) {
            Placed::Replaced => {}
            Placed::Added { longest } => {
                filled.added += 1;
                filled.longest = filled.longest.max(longest);
            }
            Placed::End => return filled.wait(new),
            Placed::Crowded | Placed::Full => return Err(InsertError::Crowded { voxel: new.voxel() }),
        }
        filled.max_material = filled.max_material.max(new.material);
        Ok(())
    }
}

impl FilledPart {
    /// Keeps an entry for the end, in place of one with the same key.
    fn wait(&mut self, new: &Pending) -> Result<(), InsertError> {
        let known = self.waiting[..self.waiting_len].iter().position(|old| old.key == new.key);
        let at = known.unwrap_or(self.waiting_len);
        *self.waiting.get_mut(at).ok_or(InsertError::Crowded { voxel: new.voxel() })? = *new;
        self.waiting_len = self.waiting_len.max(at + 1);
        Ok(())
    }
}

impl TableMut<'_> {
    /// Cuts the slots into parts that threads can fill at the same time; give what they finish with to
    /// [`TableMut::join`], or nothing that they inserted counts.
    pub fn split(&mut self, parts: u32) -> impl Iterator<Item = TablePart<'_>> {
        let (slots, stride) = (self.slots, self.stride);
        let mut rest = self.range().words;
        let start = move |part: u32| (u128::from(slots) * u128::from(part) / u128::from(parts.max(1))) as u64;
        (0..parts).map(move |part| {
            // The last part has the slots past the last home too. It also takes what a table without slots must refuse.
            let last = part + 1 == parts;
            let (first, homes_end) = (start(part), if last { slots.max(1) } else { start(part + 1) });
            let words = if last { rest.len() } else { (homes_end - first) as usize * stride };
            let taken;
            (taken, rest) = core::mem::take(&mut rest).split_at_mut(words);
            let filled = FilledPart {
                added: 0,
                longest: 0,
                max_material: 0,
                waiting: [Pending::default(); MAX_PROBES as usize],
                waiting_len: 0,
            };
            TablePart { range: Range { words: taken, first, slots, stride }, homes_end, filled }
        })
    }

    /// Takes in what parts did. After an error the table is of no use: its parts may hold more than it may.
    pub fn join(&mut self, parts: impl IntoIterator<Item = FilledPart>) -> Result<(), InsertError> {
        for part in parts {
            self.count(part.added, part.longest);
            self.max_material = self.max_material.max(part.max_material);
            if self.len() > max_len(self.slots) {
                return Err(full_by(self.len(), self.slots));
            }
            part.waiting[..part.waiting_len].iter().try_for_each(|pending| self.put(pending))?;
        }
        Ok(())
    }
}
