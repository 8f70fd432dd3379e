//! Rank over an SSVDAG by the number of voxels of each stored node (after Dolonius et al. 2017, section 3).
//!
//! In: an SSVDAG, and words made for it. Out: ranks. A mirror changes no number of voxels, but the order of the children:
//! so a step down adds up the totals of the children before, in the order that the mirror gives them. Bricks are counted
//! where they are.
//!
//! ```text
//! word  i        low 32 bits of the voxels of node i, counted on from level 3 upwards; N nodes
//!       N + i    high bits of the same for node i, counted on from level 11 upwards
//! ```

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

use super::{NARROW, Rank, RankError, in_brick};
#[cfg(feature = "alloc")]
use crate::build::BuildError;
use crate::dag::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::morton::{BITS, Morton};
use crate::ssvdag::Ssvdag;

/// A checked view over an SSVDAG's totals.
#[derive(Clone, Copy, Debug)]
pub struct Totals<'a> {
    ssvdag: Ssvdag<'a>,
    words: &'a [u32],
    /// By level from 3 on, where its nodes begin among all.
    starts: [usize; 22],
    /// Nodes of level 3 and above, and of those up to level 10.
    nodes: usize,
    narrow: usize,
    voxels: u64,
}

impl<'a> Totals<'a> {
    /// Words that the totals of an SSVDAG take: one for each node, two above level 10.
    pub fn words_for(ssvdag: &Ssvdag<'_>) -> usize {
        let (nodes, narrow) = counts(ssvdag);
        2 * nodes - narrow
    }

    /// Checks that the words are the totals of this SSVDAG, in O(words), without heap.
    pub fn new(ssvdag: Ssvdag<'a>, words: &'a [u32]) -> Result<Totals<'a>, RankError> {
        let mut totals = Totals::over(ssvdag, words)?;
        for level in BRICK_LEVEL + 1..=BITS as u8 {
            for node in 0..ssvdag.node_count(level) {
                if totals.total(node, level) != totals.sum(node, level) {
                    return Err(RankError::Count { word: totals.place(node, level) as u32 });
                }
            }
        }
        totals.voxels = totals.all();
        Ok(totals)
    }

    /// Counts the voxels of an SSVDAG into words from the heap, for [`Totals::new`].
    #[cfg(feature = "alloc")]
    pub fn build(ssvdag: &Ssvdag<'_>) -> Result<Vec<u32>, BuildError> {
        let len = Totals::words_for(ssvdag);
        let mut words = Vec::new();
        words.try_reserve_exact(len).map_err(|_| BuildError::Memory { bytes: 4 * len as u64 })?;
        words.resize(len, 0);
        for level in BRICK_LEVEL + 1..=BITS as u8 {
            for node in 0..ssvdag.node_count(level) {
                let totals = Totals::over(*ssvdag, &words).expect("as many words as the SSVDAG asks for");
                let (sum, place, nodes, narrow) =
                    (totals.sum(node, level), totals.place(node, level), totals.nodes, totals.narrow);
                words[place] = sum as u32;
                if place >= narrow {
                    words[nodes + place - narrow] = (sum >> 32) as u32;
                }
            }
        }
        Ok(words)
    }

    fn over(ssvdag: Ssvdag<'a>, words: &'a [u32]) -> Result<Totals<'a>, RankError> {
        let (expected, found) = (Totals::words_for(&ssvdag), words.len());
        if expected != found {
            return Err(RankError::Length { expected: expected as u64, found: found as u64 });
        }
        let (nodes, narrow) = counts(&ssvdag);
        let mut starts = [0; 22];
        for level in usize::from(BRICK_LEVEL) + 2..starts.len() {
            starts[level] = starts[level - 1] + ssvdag.node_count(level as u8 - 1) as usize;
        }
        Ok(Totals { ssvdag, words, starts, nodes, narrow, voxels: 0 })
    }

    /// The SSVDAG whose voxels are counted.
    pub fn ssvdag(&self) -> Ssvdag<'a> {
        self.ssvdag
    }

    /// The words, as they stand in a file.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Where a node's total stands.
    #[inline]
    fn place(&self, node: u32, level: u8) -> usize {
        self.starts[usize::from(level)] + Ssvdag::number(node) as usize
    }

    /// Voxels of a brick or node, as they are counted.
    #[inline]
    fn total(&self, node: u32, level: u8) -> u64 {
        if level == BRICK_LEVEL {
            return self.ssvdag.brick_at(node).count_ones().into();
        }
        let place = self.place(node, level);
        let high = if place < self.narrow { 0 } else { self.words[self.nodes + place - self.narrow] };
        u64::from(self.words[place]) | u64::from(high) << 32
    }

    /// The same by the totals of the children.
    fn sum(&self, node: u32, level: u8) -> u64 {
        let child = |octant| self.ssvdag.child(node, level, octant).map_or(0, |child| self.total(child, level - 1));
        // Hostile totals may be too large for a sum; they are refused, as is any other that they are not equal to.
        (0..8).map(child).fold(0, u64::wrapping_add)
    }

    fn all(&self) -> u64 {
        let top = self.ssvdag.depth().max(BRICK_LEVEL);
        if self.ssvdag.is_empty() { 0 } else { self.total(self.ssvdag.root(), top) }
    }
}

/// Nodes of level 3 and above, and of those up to level 10.
fn counts(ssvdag: &Ssvdag<'_>) -> (usize, usize) {
    let nodes = |levels: core::ops::RangeInclusive<u8>| levels.map(|level| ssvdag.node_count(level) as usize).sum();
    (nodes(BRICK_LEVEL + 1..=BITS as u8), nodes(BRICK_LEVEL + 1..=NARROW))
}

impl Rank for Totals<'_> {
    fn count(&self) -> u64 {
        self.voxels
    }

    fn rank(&self, voxel: Morton) -> Option<u64> {
        let ssvdag = &self.ssvdag;
        let top = ssvdag.depth().max(BRICK_LEVEL);
        if ssvdag.is_empty() || voxel.0 >> (3 * u32::from(top)) != 0 {
            return None;
        }
        let (mut node, mut before) = (ssvdag.root(), 0);
        for level in (BRICK_LEVEL..top).rev() {
            let octant = u32::from(voxel.octant(level));
            let next = ssvdag.child(node, level + 1, octant)?;
            for earlier in (0..octant).filter_map(|octant| ssvdag.child(node, level + 1, octant)) {
                before += self.total(earlier, level);
            }
            node = next;
        }
        Some(before + in_brick(ssvdag.brick_at(node), voxel)?)
    }
}
