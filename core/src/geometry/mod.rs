//! What rays, normals and walks ask of a voxel geometry, whatever its layout.
//!
//! In: a view that was checked once. Out: nodes by number, from the root down. A node of level h stands for a cube of 2^h
//! voxels a side; the lowest ones are bricks (level 2), 4^3 voxels as a mask. What a node's number means is the layout's
//! own business; renderers are generic over it, and the edge matches on the layout once per call.
//!
//! Numbers of nodes are below 2^31. Queries are total: after the view's check no number that it gave out, asked for at its
//! level, can panic. The answers depend on the voxels alone, so all layouts of the same voxels give the same pictures.

mod extent;
mod voxels;

pub(crate) use voxels::Nodes;
pub use voxels::{Bricks, Voxels};

use crate::morton::Morton;

/// Octree level of a brick.
pub const BRICK_LEVEL: u8 = 2;

/// A voxel geometry: an octree of depth L whose levels 0 and 1 are packed into bricks.
pub trait Geometry: Copy + Send + Sync + core::fmt::Debug {
    /// Octree levels L: the cube is 2^L voxels a side.
    fn depth(&self) -> u8;

    /// Whether no voxel is filled.
    fn is_empty(&self) -> bool;

    /// The root: a node of level L, or the one brick where L is at most 2. Meaningless if empty.
    fn root(&self) -> u32;

    /// Whether a number is one of a node of `level`, so that asking for it cannot panic.
    fn is_node(&self, node: u32, level: u8) -> bool;

    /// The child in `octant` (0 to 7) of a node of `level`, 3 or more; `None` if it is empty.
    fn child(&self, node: u32, level: u8, octant: u32) -> Option<u32>;

    /// Which children a node of `level`, 3 or more, has, one bit per octant.
    fn mask(&self, node: u32, level: u8) -> u8;

    /// The voxels of a brick in Morton order.
    fn brick_at(&self, brick: u32) -> u64;

    /// The words of a wide tree, if that is the layout: what packets of rays walk through.
    fn wide_words(&self) -> Option<&[u32]> {
        None
    }

    /// A number that stands for an empty node of any level: it has no children, and its brick no voxel.
    const EMPTY: u32 = u32::MAX;

    /// [`Geometry::child`] of a node or of [`Geometry::EMPTY`]; the latter if there is none.
    #[inline]
    fn child_or_empty(&self, node: u32, level: u8, octant: u32) -> u32 {
        if node == Self::EMPTY { Self::EMPTY } else { self.child(node, level, octant).unwrap_or(Self::EMPTY) }
    }

    /// [`Geometry::brick_at`] of a brick or of [`Geometry::EMPTY`].
    #[inline]
    fn brick_or_empty(&self, brick: u32) -> u64 {
        if brick == Self::EMPTY { 0 } else { self.brick_at(brick) }
    }

    /// The 4^3 voxels around `voxel` as a mask in Morton order (bit = low six bits of the code); 0 outside the cube.
    #[inline]
    fn brick(&self, voxel: Morton) -> u64 {
        let top = self.depth().max(BRICK_LEVEL);
        if self.is_empty() || voxel.0 >> (3 * u32::from(top)) != 0 {
            return 0;
        }
        let mut node = self.root();
        for level in (BRICK_LEVEL..top).rev() {
            match self.child(node, level + 1, u32::from(voxel.octant(level))) {
                Some(child) => node = child,
                None => return 0,
            }
        }
        self.brick_at(node)
    }

    /// Whether a voxel is filled; voxels outside the cube are not.
    #[inline]
    fn contains(&self, voxel: Morton) -> bool {
        self.brick(voxel) >> (voxel.0 & 63) & 1 != 0
    }

    /// Level of the largest empty cube of the octree around `voxel`: its side is 2^level voxels. `None` if the voxel is
    /// filled or outside the cube.
    fn empty_level(&self, voxel: Morton) -> Option<u8> {
        if voxel.0 >> (3 * u32::from(self.depth())) != 0 {
            return None;
        }
        if self.is_empty() {
            return Some(self.depth());
        }
        let mut node = self.root();
        for level in (BRICK_LEVEL..self.depth()).rev() {
            match self.child(node, level + 1, u32::from(voxel.octant(level))) {
                Some(child) => node = child,
                None => return Some(level),
            }
        }
        let brick = self.brick_at(node);
        if brick >> (voxel.0 & 63) & 1 != 0 {
            return None;
        }
        Some(u8::from(self.depth() > 0 && brick >> (voxel.0 & 56) & 0xff == 0))
    }

    /// The smallest box of cubes of the octree's `level` that holds all filled voxels: its first and its last voxel.
    /// Level 0 is exact; a higher one bounds the work, which grows with the area of the box's sides in such cubes where
    /// voxels are not flush with them. `None` without voxels.
    fn extent(self, level: u8) -> Option<[[u32; 3]; 2]> {
        extent::extent(self, level)
    }

    /// All filled voxels in Morton order.
    fn voxels(self) -> Voxels<Self> {
        Voxels::new(self.bricks())
    }

    /// All bricks that hold a voxel, in Morton order: the code of the brick's first voxel, and its mask.
    fn bricks(self) -> Bricks<Self> {
        Bricks::new(self)
    }
}
