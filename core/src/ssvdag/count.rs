//! Counts over an SSVDAG as if it were the octree it stands for, each node once, in lent memory.
//!
//! A mirror changes no count: one number a stored node is enough. Counts fit u64: a full cube of depth 21 has 2^63 voxels.

use super::Ssvdag;
use crate::dag::{BRICK_LEVEL, Stats};
use crate::geometry::Geometry;
use crate::morton::BITS;

impl Ssvdag<'_> {
    /// Stored bricks and nodes of all levels.
    pub fn stored(&self) -> usize {
        self.first(BITS as u8 + 1)
    }

    /// Stored bricks and nodes below a level: where its own begin among all of them.
    fn first(&self, level: u8) -> usize {
        (BRICK_LEVEL..level).map(|below| self.node_count(below) as usize).sum()
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
                    for child in (0..8).filter_map(|octant| self.child(number, level, octant)) {
                        scratch[below + Ssvdag::number(child) as usize] += paths;
                    }
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
