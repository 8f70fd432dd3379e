//! Any layout of voxels, for code that learns at run time which one a scene has.
//!
//! Queries match on the layout at every step; what traces many rays matches once, with [`match_geometry`](crate::match_geometry).

use crate::dag::Dag;
#[cfg(feature = "alloc")]
use crate::dag::{BRICK_LEVEL, LevelStats, Stats};
use crate::geometry::Geometry;
#[cfg(feature = "alloc")]
use crate::geometry::Nodes;
use crate::rank::{MoxelDag, Offsets};
use crate::ssvdag::Ssvdag;
use crate::svo::Svo;

/// Every layout of voxels. The first two may stand in a file.
#[derive(Clone, Copy, Debug)]
pub enum AnyGeometry<'a> {
    /// The sparse voxel DAG.
    Dag(Dag<'a>),
    /// The symmetry-aware DAG, packed.
    Ssvdag(Ssvdag<'a>),
    /// The octree without sharing.
    Svo(Svo<'a>),
    /// The DAG with offsets in its pointers.
    Offsets(Offsets<'a>),
    /// Williams's moxel DAG.
    MoxelDag(MoxelDag<'a>),
}

/// Runs the same expression for whatever layout an [`AnyGeometry`](crate::layout::AnyGeometry) has, compiled once for
/// each.
///
/// ```
/// # use voxdag::{build::DagBuilder, layout::AnyGeometry, match_geometry, Geometry, Morton};
/// # let mut builder = DagBuilder::new(2).unwrap();
/// # builder.push(Morton(0), 0b101).unwrap();
/// # let built = builder.finish().unwrap();
/// let geometry = AnyGeometry::Dag(built.dag());
/// assert_eq!(match_geometry!(geometry, g => g.voxels().count()), 2);
/// ```
#[macro_export]
macro_rules! match_geometry {
    ($geometry:expr, $g:ident => $body:expr) => {
        match $geometry {
            $crate::layout::AnyGeometry::Dag($g) => $body,
            $crate::layout::AnyGeometry::Ssvdag($g) => $body,
            $crate::layout::AnyGeometry::Svo($g) => $body,
            $crate::layout::AnyGeometry::Offsets($g) => $body,
            $crate::layout::AnyGeometry::MoxelDag($g) => $body,
        }
    };
}

impl<'a> From<Dag<'a>> for AnyGeometry<'a> {
    fn from(dag: Dag<'a>) -> Self {
        AnyGeometry::Dag(dag)
    }
}

impl<'a> AnyGeometry<'a> {
    /// The plain DAG, if it is one.
    pub fn as_dag(&self) -> Option<Dag<'a>> {
        match self {
            AnyGeometry::Dag(dag) => Some(*dag),
            _ => None,
        }
    }

    /// Its words.
    pub fn words(&self) -> &'a [u32] {
        match_geometry!(self, g => g.words())
    }

    /// Counts voxels and nodes with memory from the heap; `Err` with the number of bytes that could not be had. O(words) for
    /// what may stand in a file, O(nodes of the octree) for the others.
    #[cfg(feature = "alloc")]
    pub fn stats(&self) -> Result<Stats, usize> {
        match self {
            AnyGeometry::Dag(dag) => dag.stats(),
            AnyGeometry::Ssvdag(ssvdag) => ssvdag.stats(),
            _ => Ok(self.walk_stats()),
        }
    }

    /// Counts by a walk over the octree.
    #[cfg(feature = "alloc")]
    fn walk_stats(&self) -> Stats {
        let mut stats = Stats {
            voxels: self.bricks().map(|(_, mask)| u64::from(mask.count_ones())).sum(),
            levels: [LevelStats::default(); 22],
        };
        let numbers = 0..self.words().len() as u32;
        for level in BRICK_LEVEL..=self.depth().max(BRICK_LEVEL) {
            stats.levels[usize::from(level)] = LevelStats {
                unique: numbers.clone().filter(|&number| self.is_node(number, level)).count() as u64,
                octree: Nodes::new(*self, level).count() as u64,
            };
        }
        stats
    }
}

impl Geometry for AnyGeometry<'_> {
    #[inline]
    fn depth(&self) -> u8 {
        match_geometry!(self, g => g.depth())
    }

    #[inline]
    fn is_empty(&self) -> bool {
        match_geometry!(self, g => g.is_empty())
    }

    #[inline]
    fn root(&self) -> u32 {
        match_geometry!(self, g => Geometry::root(g))
    }

    fn is_node(&self, node: u32, level: u8) -> bool {
        match_geometry!(self, g => g.is_node(node, level))
    }

    #[inline]
    fn child(&self, node: u32, level: u8, octant: u32) -> Option<u32> {
        match_geometry!(self, g => Geometry::child(g, node, level, octant))
    }

    #[inline]
    fn mask(&self, node: u32, level: u8) -> u8 {
        match_geometry!(self, g => g.mask(node, level))
    }

    #[inline]
    fn brick_at(&self, brick: u32) -> u64 {
        match_geometry!(self, g => Geometry::brick_at(g, brick))
    }
}
