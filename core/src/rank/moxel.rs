//! The moxel DAG: a DAG with the number of empty voxels of each child (Williams 2015; Pineda 2021, section 3.3).
//!
//! In: a DAG. Out: a geometry of the same voxels, and their ranks: the Morton code less the empty voxels along the
//! path. At each step down these are the counts of the filled children before, and all of the empty octants before. The
//! last child's count is never asked for, and not kept. Differs from the source: whole words, where he packs counts
//! beside the mask.
//!
//! ```text
//! node  [ 1 << 31 | child mask ][ child ]...[ empty voxels of each child but the last ]...       up to level 11
//!       the same with two words a count: [ low 31 bits ][ high bits ]                           above
//! ```
//!
//! Header and bricks are those of [`crate::Dag`].

use super::copy::Nodes;
#[cfg(feature = "alloc")]
use super::copy::NodesBuf;
use super::{NARROW, Rank, in_brick};
#[cfg(feature = "alloc")]
use crate::build::BuildError;
#[cfg(feature = "alloc")]
use crate::dag::Dag;
use crate::dag::{BRICK_LEVEL, ONES};
use crate::geometry::Geometry;
use crate::morton::Morton;

/// Words of a count in a node of a level, whose children are a level lower.
#[inline]
const fn stride(level: u8) -> usize {
    if level > NARROW + 1 { 2 } else { 1 }
}

/// Voxels of a cube of a level, filled or not.
#[inline]
const fn volume(level: u8) -> u64 {
    1 << (3 * level)
}

/// The view of `MoxelDagBuf` that answers queries.
#[derive(Clone, Copy, Debug)]
pub struct MoxelDag<'a>(Nodes<'a>);

/// A moxel DAG that owns its words.
#[cfg(feature = "alloc")]
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MoxelDagBuf(NodesBuf);

#[cfg(feature = "alloc")]
impl MoxelDagBuf {
    /// Copies a DAG and counts its empty voxels. Takes 12 bytes a word of the DAG while it works.
    pub fn build(dag: &Dag<'_>) -> Result<MoxelDagBuf, BuildError> {
        let nodes = NodesBuf::copy(
            dag,
            |level, children| children + stride(level) * (children - 1),
            |level, children, words| {
                let (pointers, counts) = words.split_at_mut(children.len());
                for (pointer, child) in pointers.iter_mut().zip(children) {
                    *pointer = child.word;
                }
                for (count, child) in counts.chunks_exact_mut(stride(level)).zip(children) {
                    let empty = volume(level - 1) - child.voxels;
                    count[0] = empty as u32 & !(1 << 31);
                    if let Some(high) = count.get_mut(1) {
                        *high = (empty >> 31) as u32;
                    }
                }
            },
        )?;
        Ok(MoxelDagBuf(nodes))
    }

    /// The view that answers queries.
    pub fn as_moxel_dag(&self) -> MoxelDag<'_> {
        MoxelDag(self.0.nodes())
    }
}

impl<'a> MoxelDag<'a> {
    /// The words: header, bricks and nodes.
    pub fn words(&self) -> &'a [u32] {
        self.0.words
    }
}

impl Geometry for MoxelDag<'_> {
    #[inline]
    fn depth(&self) -> u8 {
        self.0.depth()
    }

    #[inline]
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[inline]
    fn root(&self) -> u32 {
        self.0.root() as u32
    }

    fn is_node(&self, node: u32, level: u8) -> bool {
        self.0.is_node(node, level)
    }

    #[inline]
    fn child(&self, node: u32, _: u8, octant: u32) -> Option<u32> {
        let child = self.0.child(node as usize, octant)?;
        Some(self.0.words[node as usize + 1 + child])
    }

    #[inline]
    fn mask(&self, node: u32, _: u8) -> u8 {
        self.0.words[node as usize] as u8
    }

    #[inline]
    fn brick_at(&self, brick: u32) -> u64 {
        self.0.brick_at(brick as usize)
    }
}

impl Rank for MoxelDag<'_> {
    fn count(&self) -> u64 {
        self.0.voxels
    }

    fn rank(&self, voxel: Morton) -> Option<u64> {
        let top = self.0.depth().max(BRICK_LEVEL);
        if self.0.is_empty() || voxel.0 >> (3 * u32::from(top)) != 0 {
            return None;
        }
        let words = self.0.words;
        let (mut node, mut empty) = (self.0.root(), 0);
        for level in (BRICK_LEVEL..top).rev() {
            let octant = u32::from(voxel.octant(level));
            let child = self.0.child(node, octant)?;
            let counts = &words[node + 1 + usize::from(ONES[(words[node] & 0xff) as usize])..];
            for count in counts.chunks_exact(stride(level + 1)).take(child) {
                empty += u64::from(count[0]) | count.get(1).map_or(0, |high| u64::from(*high) << 31);
            }
            empty += (u64::from(octant) - child as u64) * volume(level);
            node = words[node + 1 + child] as usize;
        }
        let before = in_brick(self.0.brick_at(node), voxel)?;
        Some(voxel.0 - (empty + (voxel.0 & 63) - before))
    }
}
