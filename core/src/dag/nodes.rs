//! The DAG as a geometry: a node's number is the word offset of its mask, a brick's that of its low word.

use super::{BRICK_LEVEL, Dag, HEADER, NODE, ONES};
use crate::geometry::Geometry;

impl Geometry for Dag<'_> {
    #[inline]
    fn depth(&self) -> u8 {
        self.depth()
    }

    #[inline]
    fn is_empty(&self) -> bool {
        self.is_empty()
    }

    #[inline]
    fn root(&self) -> u32 {
        self.root() as u32
    }

    fn is_node(&self, node: u32, level: u8) -> bool {
        level <= self.depth().max(BRICK_LEVEL)
            && (self.level_start(level)..self.level_start(level + 1)).contains(&(node as usize))
            && match level {
                BRICK_LEVEL => node.is_multiple_of(2),
                _ => self.words()[node as usize] & NODE != 0,
            }
    }

    #[inline]
    fn child(&self, node: u32, _: u8, octant: u32) -> Option<u32> {
        self.child(node as usize, octant).map(|child| child as u32)
    }

    #[inline]
    fn mask(&self, node: u32, _: u8) -> u8 {
        self.words()[node as usize] as u8
    }

    #[inline]
    fn brick_at(&self, brick: u32) -> u64 {
        self.brick_at(brick as usize)
    }

    /// The two words at the end of the header, which are 0, as a node and as a brick.
    const EMPTY: u32 = HEADER as u32 - 2;

    /// Without a branch, as occupancy is hard to predict.
    #[inline]
    fn child_or_empty(&self, node: u32, _: u8, octant: u32) -> u32 {
        let words = self.words();
        let mask = words[node as usize] as usize;
        let before = usize::from(ONES[mask << (8 - octant) & 0xff]);
        let filled = mask >> octant & 1;
        // Without a child this is word 0, the depth, which is below EMPTY as no child is.
        let place = (node as usize + 1 + before) & filled.wrapping_neg();
        words[place].max(Self::EMPTY)
    }

    #[inline]
    fn brick_or_empty(&self, brick: u32) -> u64 {
        self.brick_at(brick as usize)
    }
}
