//! The sparse voxel octree without sharing: child masks and pointers to contiguous children (Laine and Karras 2010;
//! Pineda 2021, section 3.1.1). What DAGs are measured against.
//!
//! In: a DAG, and a limit. Out: a geometry of the same voxels in which every cube has a node of its own, in Morton
//! order level by level. As all nodes and bricks take two words, a child is found by counting the filled octants before
//! it. Differs from the source: no contours, one width of pointers, and bricks of 4^3 voxels at the bottom as in
//! [`crate::Dag`].
//!
//! ```text
//! word  0 .. 23   as in a DAG: depth, bricks, starts of the levels
//!       24..      bricks, two words each, in Morton order
//!       then      nodes of level 3, of level 4, .. of level L (the root), in Morton order:
//!                 [ 1 << 31 | child mask ][ word of the first child ]
//! ```

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

#[cfg(feature = "alloc")]
use crate::build::{BuildError, write_header};
use crate::dag::{BRICK_LEVEL, HEADER, ONES, Stats};
#[cfg(feature = "alloc")]
use crate::dag::{Dag, NODE};
use crate::geometry::Geometry;
#[cfg(feature = "alloc")]
use crate::geometry::Nodes;

/// The view of an `SvoBuf` that answers queries.
#[derive(Clone, Copy, Debug)]
pub struct Svo<'a> {
    words: &'a [u32],
}

/// An octree that owns its words.
///
/// ```
/// use voxdag::{Geometry, Morton, build::DagBuilder, svo::SvoBuf};
/// let mut builder = DagBuilder::new(3)?;
/// builder.push(Morton(0), 0b11)?;
/// builder.push(Morton(64), 0b11)?;
/// let svo = SvoBuf::build(&builder.finish()?.dag(), 1000)?;
/// assert!(svo.as_svo().contains(Morton(65)));
/// assert_eq!(svo.as_svo().words().len(), 24 + 2 * 2 + 2); // two equal bricks, and the root
/// # Ok::<(), voxdag::build::BuildError>(())
/// ```
#[cfg(feature = "alloc")]
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SvoBuf {
    words: Vec<u32>,
}

#[cfg(feature = "alloc")]
impl SvoBuf {
    /// Unfolds a DAG. Refuses with [`BuildError::Words`], before it takes the memory, what needs more than `limit`
    /// words, or 2^31 and more.
    pub fn build(dag: &Dag<'_>, limit: u32) -> Result<SvoBuf, BuildError> {
        let stats = dag.stats().map_err(|bytes| BuildError::Memory { bytes: bytes as u64 })?;
        let needed = Svo::words_for(&stats);
        if needed > limit.into() {
            return Err(BuildError::Words { needed });
        }
        let mut words = Vec::new();
        words.try_reserve_exact(needed as usize).map_err(|_| BuildError::Memory { bytes: 4 * needed })?;
        words.resize(HEADER, 0);
        let mut level_words = stats.levels.map(|level| 2 * level.octree);
        let bricks = core::mem::take(&mut level_words[usize::from(BRICK_LEVEL)]) / 2;
        write_header(&mut words, dag.depth(), bricks, &level_words).ok_or(BuildError::Words { needed })?;

        words.extend(dag.bricks().flat_map(|(_, mask)| [mask as u32, (mask >> 32) as u32]));
        // In Morton order the children of a level's nodes follow each other in the level below.
        for level in BRICK_LEVEL + 1..=dag.depth() {
            let mut child = Svo { words: &words }.level_start(level - 1) as u32;
            for (_, node) in Nodes::new(*dag, level) {
                let mask = Geometry::mask(dag, node, level);
                words.extend([NODE | u32::from(mask), child]);
                child += 2 * u32::from(ONES[usize::from(mask)]);
            }
        }
        Ok(SvoBuf { words })
    }

    /// The view that answers queries.
    pub fn as_svo(&self) -> Svo<'_> {
        Svo { words: &self.words }
    }
}

impl<'a> Svo<'a> {
    /// Words of the octree of a DAG with these counts.
    pub fn words_for(stats: &Stats) -> u64 {
        let nodes: u64 = stats.levels.iter().map(|level| level.octree).fold(0, u64::saturating_add);
        nodes.saturating_mul(2).saturating_add(HEADER as u64)
    }

    /// The words: header, bricks and nodes.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    #[inline]
    fn level_start(&self, level: u8) -> usize {
        if level <= BRICK_LEVEL { HEADER } else { self.words[usize::from(level) - 1] as usize }
    }
}

impl Geometry for Svo<'_> {
    #[inline]
    fn depth(&self) -> u8 {
        self.words[0] as u8
    }

    #[inline]
    fn is_empty(&self) -> bool {
        self.words[1] == 0
    }

    #[inline]
    fn root(&self) -> u32 {
        self.level_start(self.depth().max(BRICK_LEVEL)) as u32
    }

    fn is_node(&self, node: u32, level: u8) -> bool {
        node.is_multiple_of(2) && (self.level_start(level)..self.level_start(level + 1)).contains(&(node as usize))
    }

    #[inline]
    fn child(&self, node: u32, _: u8, octant: u32) -> Option<u32> {
        let mask = self.words[node as usize];
        let before = ONES[(mask & ((1 << octant) - 1) & 0xff) as usize];
        (mask >> octant & 1 != 0).then(|| self.words[node as usize + 1] + 2 * u32::from(before))
    }

    #[inline]
    fn mask(&self, node: u32, _: u8) -> u8 {
        self.words[node as usize] as u8
    }

    #[inline]
    fn brick_at(&self, brick: u32) -> u64 {
        u64::from(self.words[brick as usize]) | u64::from(self.words[brick as usize + 1]) << 32
    }
}
