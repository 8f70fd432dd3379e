//! The wide tree: two octree levels to a node, all 4^3 children named, for rays that go down many at a time.
//!
//! In: a geometry of any layout. Out: the same voxels, derived when a scene is loaded, not stored, and optional. What was
//! shared stays shared. Each child has a word of its own, so that a step down is one look-up without a count of bits, and
//! an empty one says how far the space ahead is empty, for each octant that a ray may head to: the largest box of cells of
//! the node that begins there. Where the depth is odd, the root is the first octant of a node one level higher.
//!
//! ```text
//! node n   of even level h: words n .. n + 64, one per child cell x + 4 y + 16 z of level h - 2, for rays with dz < 0,
//!          and words n + 64 .. n + 128, the same for the others
//!          filled: the child's first word        empty: 1 << 31 | 1 << 24 if all of the octant is | box << 6 o
//!          o = (dx >= 0) + 2 (dy >= 0), box = cells along x | y << 2 | z << 4, less one each
//! brick b  words b .. b + 32, one per pair of voxels x / 2 + 2 y + 8 z, 16 bits for each, the even one first,
//!          of these two for each octant o = (dx >= 0) + 2 (dy >= 0) + 4 (dz >= 0) at bit 2 o:
//!          0 filled, 1 empty, 2 the 2^3 around are empty, 3 all of the brick ahead is
//! masks    after the bricks, in their order: 64 voxels in Morton order, low word first
//! ```
//! As a [`Geometry`] a node of odd level h is the first of the eight cells of its octant in the node of level h + 1.

#[cfg(feature = "alloc")]
mod boxes;
#[cfg(feature = "alloc")]
mod grow;

#[cfg(feature = "alloc")]
pub use grow::WideBuf;

use crate::geometry::{BRICK_LEVEL, Geometry};

/// Marks an empty cell.
const EMPTY_CELL: u32 = 1 << 31;
/// Marks a cell of an empty octant.
const EMPTY_OCTANT: u32 = 1 << 24;
/// Words of a node, and of a brick without its mask.
const NODE_WORDS: usize = 128;
const BRICK_WORDS: usize = 32;

/// The view of a `WideBuf` that answers queries.
///
/// ```
/// use voxdag::{Geometry, Morton, build::DagBuilder, wide::WideBuf};
/// let mut builder = DagBuilder::new(4)?;
/// builder.push(Morton(0), 0b11)?;
/// builder.push(Morton(64), 0b11)?;
/// let wide = WideBuf::new(&builder.finish()?.dag(), usize::MAX).unwrap();
/// assert!(wide.as_wide().contains(Morton(65)));
/// assert_eq!(wide.as_wide().bytes(), 4 * (128 + 32 + 2)); // a node, and one brick for both
/// # Ok::<(), voxdag::build::BuildError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Wide<'a> {
    words: &'a [u32],
    depth: u8,
    /// Where the nodes of level 2 k begin, the bricks at k = 1 and the masks at 0; those of the level above end there.
    starts: &'a [u32; 13],
}

impl Wide<'_> {
    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.words)
    }

    fn word(&self, at: u32) -> u32 {
        self.words.get(at as usize).copied().unwrap_or(EMPTY_CELL)
    }
}

/// The first cell of an octant of a node, for `scale` 2; the cell of an octant of an octant, for 1.
#[inline(always)]
fn place(octant: u32, scale: u32) -> u32 {
    ((octant & 1) | (octant & 2) << 1 | (octant & 4) << 2) * scale
}

impl Geometry for Wide<'_> {
    #[inline]
    fn depth(&self) -> u8 {
        self.depth
    }

    #[inline]
    fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    #[inline]
    fn root(&self) -> u32 {
        0
    }

    /// Also of what would be a node if its octant were not empty: asking for that is as safe.
    fn is_node(&self, node: u32, level: u8) -> bool {
        if level > self.depth.max(BRICK_LEVEL) || level < BRICK_LEVEL {
            return false;
        }
        let k = usize::from(level.div_ceil(2));
        if !(self.starts[k]..self.starts[k - 1]).contains(&node) {
            return false;
        }
        match node - self.starts[k] {
            at if level == BRICK_LEVEL => at.is_multiple_of(BRICK_WORDS as u32),
            at if level.is_multiple_of(2) => at.is_multiple_of(NODE_WORDS as u32),
            at => (0..8).any(|octant| at % NODE_WORDS as u32 == place(octant, 2)),
        }
    }

    #[inline]
    fn child(&self, node: u32, level: u8, octant: u32) -> Option<u32> {
        if level.is_multiple_of(2) {
            // An octant that is empty says so in all of its cells.
            let child = node + place(octant, 2);
            (self.word(child) & (EMPTY_CELL | EMPTY_OCTANT) != EMPTY_CELL | EMPTY_OCTANT).then_some(child)
        } else {
            let word = self.word(node + place(octant, 1));
            (word & EMPTY_CELL == 0).then_some(word)
        }
    }

    fn mask(&self, node: u32, level: u8) -> u8 {
        (0..8).filter(|&octant| self.child(node, level, octant).is_some()).fold(0, |mask, octant| mask | 1 << octant)
    }

    #[inline]
    fn brick_at(&self, brick: u32) -> u64 {
        let number = brick.saturating_sub(self.starts[1]) as usize / BRICK_WORDS;
        let pair = self.words.get(self.starts[0] as usize + 2 * number..).and_then(|rest| rest.first_chunk());
        pair.map_or(0, |&[low, high]| u64::from(low) | u64::from(high) << 32)
    }

    #[inline]
    fn wide_words(&self) -> Option<&[u32]> {
        Some(self.words)
    }
}
