//! Counts over an SSVDAG as if it were the octree it stands for, each node once, in lent memory.
//!
//! A mirror changes no count: one number a stored node is enough. Counts fit u64: a full cube of depth 21 has 2^63 voxels.

use super::{PLACE, Ssvdag};
use crate::dag::{BRICK_LEVEL, Stats};
use crate::geometry::Geometry;
use crate::morton::BITS;

impl Ssvdag<'_> {
    /// Stored bricks and nodes of all levels.
    pub fn stored(&self) -> usize {
        self.first(BITS as u8 + 1)
    }

    /// The place of a node of a level (2 for bricks) among all stored ones, from the bricks upwards: below [`Ssvdag::stored`],
    /// and the same for a node in whatever mirror.
    #[inline]
    pub fn index(&self, node: u32, level: u8) -> usize {
        self.first(level) + (node % (1 << PLACE)) as usize
    }

    /// The place of the first node of a level.
    #[inline]
    fn first(&self, level: u8) -> usize {
        (BRICK_LEVEL..level).map(|below| self.node_count(below) as usize).sum()
    }

    /// The children of a stored node, in no particular order.
    fn children(self, number: u32, level: u8) -> impl Iterator<Item = u32> {
        (0..8).filter_map(move |octant| self.child(number, level, octant))
    }

    /// Counts the voxels of every stored brick and node: the base of ranks. `totals` takes one number each, placed by
    /// [`Ssvdag::index`]; `None` if it is not [`Ssvdag::stored`] long.
    pub fn totals_into(&self, totals: &mut [u64]) -> Option<()> {
        if totals.len() != self.stored() {
            return None;
        }
        for brick in 0..self.node_count(BRICK_LEVEL) {
            totals[brick as usize] = u64::from(self.brick_at(brick).count_ones());
        }
        for level in 3..=BITS as u8 {
            let (below, first) = (self.first(level - 1), self.first(level));
            for number in 0..self.node_count(level) {
                let of = |child: u32| totals[below + (child % (1 << PLACE)) as usize];
                totals[first + number as usize] = self.children(number, level).map(of).sum();
            }
        }
        Some(())
    }

    /// Counts voxels and nodes. `scratch` lends one `u64` per stored brick and node; `None` if it is not [`Ssvdag::stored`]
    /// long.
    pub fn stats_into(&self, scratch: &mut [u64]) -> Option<Stats> {
        if scratch.len() != self.stored() {
            return None;
        }
        scratch.fill(0);
        let mut stats = Stats { voxels: 0, levels: Default::default() };
        // From the root down: how many paths lead to each node.
        if let Some(root) = scratch.last_mut() {
            *root = 1;
        }
        for level in (BRICK_LEVEL..=BITS as u8).rev() {
            let (nodes, first) = (self.node_count(level), self.first(level));
            stats.levels[usize::from(level)].unique = u64::from(nodes);
            for number in 0..nodes {
                let paths = scratch[first + number as usize];
                stats.levels[usize::from(level)].octree += paths;
                if level == BRICK_LEVEL {
                    stats.voxels += paths * u64::from(self.brick_at(number).count_ones());
                } else {
                    let below = self.first(level - 1);
                    self.children(number, level)
                        .for_each(|child| scratch[below + (child % (1 << PLACE)) as usize] += paths);
                }
            }
        }
        Some(stats)
    }

    /// [`Ssvdag::stats_into`] with memory from the heap; `Err` with the number of bytes that could not be had.
    #[cfg(feature = "alloc")]
    pub fn stats(&self) -> Result<Stats, usize> {
        let mut scratch = alloc::vec::Vec::new();
        scratch.try_reserve_exact(self.stored()).map_err(|_| 8 * self.stored())?;
        scratch.resize(self.stored(), 0);
        Ok(self.stats_into(&mut scratch).expect("scratch is as long as it says"))
    }
}
