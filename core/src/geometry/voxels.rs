//! Walks over all bricks and voxels of a geometry in Morton order, with a fixed stack.

use super::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::morton::Morton;

/// Iterator over the nodes of one level, in Morton order: the code of their first voxel, and their number.
#[derive(Clone, Debug)]
pub(crate) struct Nodes<G> {
    geometry: G,
    bottom: u8,
    /// Per level above `bottom`: the open node and its octants that are still to come.
    open: [(u32, u8); 23],
    level: u8,
    code: u64,
}

impl<G: Geometry> Nodes<G> {
    /// The nodes of level `bottom`, from the bricks (2) to the root.
    pub(crate) fn new(geometry: G, bottom: u8) -> Self {
        let top = geometry.depth().max(BRICK_LEVEL);
        let mut open = [(0, 0); 23];
        if !geometry.is_empty() {
            let root = geometry.root();
            // Where the root itself is asked for, it gets a parent in thought: one octant, the root.
            open[top as usize] = if bottom < top { (root, geometry.mask(root, top)) } else { (0, 1) };
        }
        Nodes { geometry, bottom, open, level: top, code: 0 }
    }
}

impl<G: Geometry> Iterator for Nodes<G> {
    type Item = (Morton, u32);

    #[inline]
    fn next(&mut self) -> Option<(Morton, u32)> {
        let top = self.geometry.depth().max(BRICK_LEVEL);
        loop {
            let (node, left) = self.open[self.level as usize];
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
                return Some((Morton(0), self.geometry.root()));
            }
            let child = self.geometry.child(node, self.level, octant)?;
            let level = self.level - 1;
            let shift = 3 * u32::from(level);
            self.code = (self.code >> shift & !7 | u64::from(octant)) << shift;
            if level == self.bottom {
                return Some((Morton(self.code), child));
            }
            // Go down.
            self.level = level;
            self.open[level as usize] = (child, self.geometry.mask(child, level));
        }
    }
}

/// Iterator over the bricks that hold a voxel: the code of their first voxel, and their mask. See [`Geometry::bricks`].
#[derive(Clone, Debug)]
pub struct Bricks<G>(Nodes<G>);

impl<G: Geometry> Bricks<G> {
    pub(crate) fn new(geometry: G) -> Self {
        Bricks(Nodes::new(geometry, BRICK_LEVEL))
    }
}

impl<G: Geometry> Iterator for Bricks<G> {
    type Item = (Morton, u64);

    #[inline]
    fn next(&mut self) -> Option<(Morton, u64)> {
        self.0.next().map(|(code, brick)| (code, self.0.geometry.brick_at(brick)))
    }
}

/// Iterator over all filled voxels. See [`Geometry::voxels`].
#[derive(Clone, Debug)]
pub struct Voxels<G> {
    bricks: Bricks<G>,
    code: u64,
    mask: u64,
}

impl<G: Geometry> Voxels<G> {
    pub(crate) fn new(bricks: Bricks<G>) -> Self {
        Voxels { bricks, code: 0, mask: 0 }
    }
}

impl<G: Geometry> Iterator for Voxels<G> {
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
