//! Walks over all bricks and voxels of a DAG in Morton order, with a fixed stack.

use super::{BRICK_LEVEL, Dag};
use crate::morton::Morton;

/// Iterator over the bricks that hold a voxel: the code of their first voxel, and their mask. See [`Dag::bricks`].
#[derive(Clone, Debug)]
pub struct Bricks<'a> {
    dag: Dag<'a>,
    /// Per level above the bricks: the open node and its octants that are still to come.
    open: [(u32, u8); 22],
    level: u8,
    code: u64,
}

impl<'a> Bricks<'a> {
    pub(super) fn new(dag: Dag<'a>) -> Self {
        let level = dag.depth().max(BRICK_LEVEL);
        let mut open = [(0, 0); 22];
        if !dag.is_empty() {
            let root = dag.root();
            // A DAG that is one brick gets a root above it in thought: one octant, the brick.
            open[level as usize] =
                if level == BRICK_LEVEL { (root as u32, 1) } else { (root as u32, dag.words()[root] as u8) };
        }
        Bricks { dag, open, level, code: 0 }
    }
}

impl Iterator for Bricks<'_> {
    type Item = (Morton, u64);

    fn next(&mut self) -> Option<(Morton, u64)> {
        let top = self.dag.depth().max(BRICK_LEVEL);
        loop {
            let (word, left) = self.open[self.level as usize];
            // Go up where a node has no octant left.
            if left == 0 {
                if self.level == top {
                    return None;
                }
                self.level += 1;
                continue;
            }
            // Take the next octant.
            let octant = left.trailing_zeros();
            self.open[self.level as usize].1 = left & (left - 1);
            if top == BRICK_LEVEL {
                return Some((Morton(0), self.dag.brick_at(word as usize)));
            }
            let child = self.dag.child(word as usize, octant)?;
            let level = self.level - 1;
            let shift = 3 * u32::from(level);
            self.code = (self.code >> shift & !7 | u64::from(octant)) << shift;
            if level == BRICK_LEVEL {
                return Some((Morton(self.code), self.dag.brick_at(child)));
            }
            // Go down.
            self.level = level;
            self.open[level as usize] = (child as u32, self.dag.words()[child] as u8);
        }
    }
}

/// Iterator over all filled voxels. See [`Dag::voxels`].
#[derive(Clone, Debug)]
pub struct Voxels<'a> {
    bricks: Bricks<'a>,
    code: u64,
    mask: u64,
}

impl<'a> Voxels<'a> {
    pub(super) fn new(bricks: Bricks<'a>) -> Self {
        Voxels { bricks, code: 0, mask: 0 }
    }
}

impl Iterator for Voxels<'_> {
    type Item = Morton;

    fn next(&mut self) -> Option<Morton> {
        while self.mask == 0 {
            let (code, mask) = self.bricks.next()?;
            (self.code, self.mask) = (code.0, mask);
        }
        let bit = self.mask.trailing_zeros();
        self.mask &= self.mask - 1;
        Some(Morton(self.code | u64::from(bit)))
    }
}
