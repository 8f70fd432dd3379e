//! Walks over all bricks and voxels of a DAG in Morton order, with a fixed stack.

use super::{BRICK_LEVEL, Dag};
use crate::morton::Morton;

/// Iterator over the nodes of one level, in Morton order: the code of their first voxel, and their word offset.
#[derive(Clone, Debug)]
pub(crate) struct Nodes<'a> {
    dag: Dag<'a>,
    bottom: u8,
    /// Per level above `bottom`: the open node and its octants that are still to come.
    open: [(u32, u8); 23],
    level: u8,
    code: u64,
}

impl<'a> Nodes<'a> {
    /// The nodes of level `bottom`, from the bricks (2) to the root.
    pub(crate) fn new(dag: Dag<'a>, bottom: u8) -> Self {
        let top = dag.depth().max(BRICK_LEVEL);
        let mut open = [(0, 0); 23];
        if !dag.is_empty() {
            let root = dag.root();
            // Where the root itself is asked for, it gets a parent in thought: one octant, the root.
            open[top as usize] = if bottom < top { (root as u32, dag.words()[root] as u8) } else { (0, 1) };
        }
        Nodes { dag, bottom, open, level: top, code: 0 }
    }
}

impl Iterator for Nodes<'_> {
    type Item = (Morton, usize);

    #[inline]
    fn next(&mut self) -> Option<(Morton, usize)> {
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
            if self.bottom >= top {
                return Some((Morton(0), self.dag.root()));
            }
            let child = self.dag.child(word as usize, octant)?;
            let level = self.level - 1;
            let shift = 3 * u32::from(level);
            self.code = (self.code >> shift & !7 | u64::from(octant)) << shift;
            if level == self.bottom {
                return Some((Morton(self.code), child));
            }
            // Go down.
            self.level = level;
            self.open[level as usize] = (child as u32, self.dag.words()[child] as u8);
        }
    }
}

/// Iterator over the bricks that hold a voxel: the code of their first voxel, and their mask. See [`Dag::bricks`].
#[derive(Clone, Debug)]
pub struct Bricks<'a>(Nodes<'a>);

impl<'a> Bricks<'a> {
    pub(super) fn new(dag: Dag<'a>) -> Self {
        Bricks(Nodes::new(dag, BRICK_LEVEL))
    }
}

impl Iterator for Bricks<'_> {
    type Item = (Morton, u64);

    #[inline]
    fn next(&mut self) -> Option<(Morton, u64)> {
        self.0.next().map(|(code, word)| (code, self.0.dag.brick_at(word)))
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
