//! Counts over the DAG as if it were the octree it stands for, each node once (memoised), in lent memory.
//!
//! Counts fit u64: a full cube of depth 21 has 2^63 voxels.

use super::{BRICK_LEVEL, Dag, ONES};

/// One level of a DAG.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct LevelStats {
    /// Unique nodes (bricks in level 2) that are stored.
    pub unique: u64,
    /// Nodes of the same level in the octree without sharing.
    pub octree: u64,
}

/// What a DAG holds, level by level.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Stats {
    /// Filled voxels.
    pub voxels: u64,
    /// By level h: 2 are the bricks, the depth is the root; 0 elsewhere.
    pub levels: [LevelStats; 22],
}

impl Stats {
    /// Unique nodes above the bricks.
    pub fn nodes(&self) -> u64 {
        self.levels[3..].iter().map(|l| l.unique).sum()
    }

    /// Nodes above the bricks in the octree without sharing.
    pub fn octree_nodes(&self) -> u64 {
        self.levels[3..].iter().map(|l| l.octree).sum()
    }
}

impl Dag<'_> {
    /// Counts voxels and nodes. `scratch` lends one `u64` per word of [`Dag::words`]; `None` if it is shorter.
    pub fn stats_into(&self, scratch: &mut [u64]) -> Option<Stats> {
        let scratch = scratch.get_mut(..self.words().len())?;
        scratch.fill(0);
        let mut stats = Stats { voxels: 0, levels: [LevelStats::default(); 22] };
        stats.levels[BRICK_LEVEL as usize].unique = u64::from(self.brick_count());
        if self.is_empty() {
            return Some(stats);
        }
        // From the root down: how many paths lead to each node.
        scratch[self.root()] = 1;
        for level in (3..=self.depth()).rev() {
            let total = &mut stats.levels[level as usize];
            let (mut word, end) = (self.level_start(level), self.level_start(level + 1));
            while word < end {
                let paths = scratch[word];
                total.unique += 1;
                total.octree += paths;
                let children = ONES[(self.words()[word] & 0xff) as usize] as usize;
                for &child in &self.words()[word + 1..word + 1 + children] {
                    scratch[child as usize] += paths;
                }
                word += 1 + children;
            }
        }
        for word in (super::HEADER..self.level_start(3)).step_by(2) {
            stats.levels[BRICK_LEVEL as usize].octree += scratch[word];
            stats.voxels += scratch[word] * u64::from(self.brick_at(word).count_ones());
        }
        Some(stats)
    }

    /// [`Dag::stats_into`] with memory from the heap; `Err` with the number of bytes that could not be had.
    #[cfg(feature = "alloc")]
    pub fn stats(&self) -> Result<Stats, usize> {
        let mut scratch = alloc::vec::Vec::new();
        scratch.try_reserve_exact(self.words().len()).map_err(|_| 8 * self.words().len())?;
        scratch.resize(self.words().len(), 0);
        Ok(self.stats_into(&mut scratch).expect("scratch is as long as the words"))
    }
}
