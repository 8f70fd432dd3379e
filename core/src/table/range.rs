//! One insertion into a range of a table's slots: the invariant of the layout is kept here and nowhere else.

use super::{Entry, InsertError, MAX_PROBES, home, join, mix};
use crate::material::MaterialId;
use crate::morton::Morton;
use crate::octahedral;

/// An entry on its way into the table.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pending {
    pub key: u64,
    pub hash: u64,
    pub material: MaterialId,
    pub normal: u32,
}

/// What became of an entry. Only the first two change a word.
pub(super) enum Placed {
    /// Its key was there: the value was replaced.
    Replaced,
    /// It was added; the longest probe sequence among the entries that moved.
    Added { longest: u32 },
    /// It is not there, and no entry may be added.
    Full,
    /// An entry would be too far from its home.
    Crowded,
    /// An entry would leave the range.
    End,
}

/// Slots that follow each other, from the slot `first` of a table on.
pub(super) struct Range<'a> {
    pub words: &'a mut [u32],
    pub first: u64,
    /// Home slots of the whole table.
    pub slots: u64,
    pub stride: usize,
}

impl Pending {
    /// Hashes a key and packs its value.
    #[inline]
    pub fn new(voxel: Morton, entry: Entry, stride: usize) -> Result<Pending, InsertError> {
        if voxel.0 >> 63 != 0 {
            return Err(InsertError::NotACode { voxel });
        }
        let key = voxel.0 + 1;
        let normal = match entry.normal {
            Some(normal) if stride == 4 => octahedral::encode(normal),
            _ => 0,
        };
        Ok(Pending { key, hash: mix(key), material: entry.material, normal })
    }

    /// The entry in a slot.
    #[cfg(feature = "alloc")]
    pub fn of_slot(slot: &[u32]) -> Option<Pending> {
        let key = join(slot[0], slot[1]);
        let normal = slot.get(3).copied().unwrap_or(0);
        (key != 0).then(|| Pending { key, hash: mix(key), material: slot[2] as MaterialId, normal })
    }

    pub fn voxel(&self) -> Morton {
        Morton(self.key - 1)
    }
}

impl Range<'_> {
    /// Loads the home slots of a batch, so that the loads overlap and the insertions that follow find them in the caches.
    #[inline]
    pub fn touch(&self, batch: &[Pending]) {
        let mut touched = 0;
        for pending in batch {
            let word = (home(pending.hash, self.slots) - self.first) as usize * self.stride;
            touched |= self.words.get(word).copied().unwrap_or(0);
        }
        core::hint::black_box(touched);
    }

    /// Places an entry whose home lies in the range where the order of hashes puts it.
    #[inline]
    pub fn place(&mut self, new: &Pending, full: bool) -> Placed {
        let first = home(new.hash, self.slots);

        // Find the place: behind all smaller hashes.
        let mut place = first;
        loop {
            match self.key(place) {
                None => return if full { Placed::Full } else { Placed::End },
                Some(key) if key == new.key => {
                    self.write(place, new);
                    return Placed::Replaced;
                }
                Some(key) if key == 0 || mix(key) > new.hash => break,
                Some(_) => place += 1,
            }
            if place - first == u64::from(MAX_PROBES) {
                return Placed::Crowded;
            }
        }
        if full {
            return Placed::Full;
        }

        // Find the first empty slot behind it, and how far from home the entries up to there will be.
        let mut longest = place - first + 1;
        let mut end = place;
        loop {
            match self.key(end) {
                None => return Placed::End,
                Some(0) => break,
                Some(key) => {
                    end += 1;
                    longest = longest.max(end - home(mix(key), self.slots) + 1);
                    if longest > u64::from(MAX_PROBES) {
                        return Placed::Crowded;
                    }
                }
            }
        }

        // Move them up by one and fill the gap.
        if place != end {
            let (from, to) = (self.word(place), self.word(end));
            self.words.copy_within(from..to, from + self.stride);
        }
        self.write(place, new);
        Placed::Added { longest: longest as u32 }
    }

    /// Offset of a slot's first word in the range.
    #[inline]
    fn word(&self, slot: u64) -> usize {
        (slot - self.first) as usize * self.stride
    }

    /// The key in a slot, 0 if it is empty; `None` behind the range.
    #[inline]
    fn key(&self, slot: u64) -> Option<u64> {
        let word = self.word(slot);
        match self.words.get(word..word + 2) {
            Some(&[low, high]) => Some(join(low, high)),
            _ => None,
        }
    }

    #[inline]
    fn write(&mut self, slot: u64, new: &Pending) {
        let word = self.word(slot);
        // Four stores are faster than a copy of a length known only when it runs.
        if let [low, high, material, normal @ ..] = &mut self.words[word..word + self.stride] {
            (*low, *high, *material) = (new.key as u32, (new.key >> 32) as u32, u32::from(new.material));
            if let [normal] = normal {
                *normal = new.normal;
            }
        }
    }
}
