//! Rank by offsets in pointers: a DAG with a count beside each child pointer (after Dado et al. 2016).
//!
//! In: a DAG. Out: a geometry of the same voxels whose ranks are sums of offsets along the path, each on the line of
//! memory that the step down reads in any case. The offset is the number of filled voxels in the children before.
//! Differs from the source: offsets count voxels, not nodes of the octree, and take whole words.
//!
//! ```text
//! node  [ 1 << 31 | child mask ][ child ][ offset ]...                               up to level 10
//!       [ 1 << 31 | child mask ][ child ][ offset, low 31 bits ][ high bits ]...     above
//! ```
//!
//! Header and bricks are those of [`crate::Dag`].

use super::copy::Nodes;
#[cfg(feature = "alloc")]
use super::copy::NodesBuf;
use super::{NARROW, Rank, in_brick};
#[cfg(feature = "alloc")]
use crate::build::BuildError;
use crate::dag::BRICK_LEVEL;
#[cfg(feature = "alloc")]
use crate::dag::Dag;
use crate::geometry::Geometry;
use crate::morton::Morton;

/// Words of a child in a node of a level.
#[inline]
const fn stride(level: u8) -> usize {
    if level > NARROW { 3 } else { 2 }
}

/// The view of `OffsetsBuf` that answers queries.
#[derive(Clone, Copy, Debug)]
pub struct Offsets<'a>(Nodes<'a>);

/// A DAG with offsets that owns its words.
///
/// ```
/// use voxdag::{Geometry, Morton, Rank, build::DagBuilder, rank::OffsetsBuf};
/// let mut builder = DagBuilder::new(3)?;
/// builder.push(Morton(0), 0b11)?;
/// builder.push(Morton(64), 0b100)?;
/// let built = OffsetsBuf::build(&builder.finish()?.dag())?;
/// assert_eq!(built.as_offsets().rank(Morton(66)), Some(2));
/// assert!(built.as_offsets().contains(Morton(66)));
/// # Ok::<(), voxdag::build::BuildError>(())
/// ```
#[cfg(feature = "alloc")]
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct OffsetsBuf(NodesBuf);

#[cfg(feature = "alloc")]
impl OffsetsBuf {
    /// Copies a DAG and counts its voxels. Takes 12 bytes a word of the DAG while it works.
    pub fn build(dag: &Dag<'_>) -> Result<OffsetsBuf, BuildError> {
        let nodes = NodesBuf::copy(
            dag,
            |level, children| stride(level) * children,
            |level, children, words| {
                let mut before = 0u64;
                for (child, words) in children.iter().zip(words.chunks_exact_mut(stride(level))) {
                    words[0] = child.word;
                    match words {
                        [_, offset] => *offset = before as u32,
                        [_, low, high] => (*low, *high) = (before as u32 & !(1 << 31), (before >> 31) as u32),
                        _ => {}
                    }
                    before += child.voxels;
                }
            },
        )?;
        Ok(OffsetsBuf(nodes))
    }

    /// The view that answers queries.
    pub fn as_offsets(&self) -> Offsets<'_> {
        Offsets(self.0.nodes())
    }
}

impl<'a> Offsets<'a> {
    /// The words: header, bricks and nodes.
    pub fn words(&self) -> &'a [u32] {
        self.0.words
    }
}

impl Geometry for Offsets<'_> {
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
    fn child(&self, node: u32, level: u8, octant: u32) -> Option<u32> {
        let child = self.0.child(node as usize, octant)?;
        Some(self.0.words[node as usize + 1 + stride(level) * child])
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

impl Rank for Offsets<'_> {
    fn count(&self) -> u64 {
        self.0.voxels
    }

    #[inline]
    fn rank(&self, voxel: Morton) -> Option<u64> {
        let top = self.0.depth().max(BRICK_LEVEL);
        if self.0.is_empty() || voxel.0 >> (3 * u32::from(top)) != 0 {
            return None;
        }
        let words = self.0.words;
        let (mut node, mut before) = (self.0.root(), 0);
        for level in (NARROW..top).rev() {
            let place = node + 1 + 3 * self.0.child(node, voxel.octant(level).into())?;
            before += u64::from(words[place + 1]) | u64::from(words[place + 2]) << 31;
            node = words[place] as usize;
        }
        for level in (BRICK_LEVEL..top.min(NARROW)).rev() {
            let place = node + 1 + 2 * self.0.child(node, voxel.octant(level).into())?;
            before += u64::from(words[place + 1]);
            node = words[place] as usize;
        }
        Some(before + in_brick(self.0.brick_at(node), voxel)?)
    }
}
