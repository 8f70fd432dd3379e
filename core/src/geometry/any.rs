//! Any geometry, for code that learns at run time which one a scene has.
//!
//! Queries match on the layout at every step; what traces many rays matches once, with [`match_geometry`](crate::match_geometry).

use super::Geometry;
use crate::dag::{Dag, Stats};

/// Every layout of voxels.
#[derive(Clone, Copy, Debug)]
pub enum AnyGeometry<'a> {
    /// The sparse voxel DAG.
    Dag(Dag<'a>),
}

/// Runs the same expression for whatever layout an [`AnyGeometry`] has, compiled once for each.
///
/// ```
/// # use voxdag::{build::DagBuilder, geometry::{AnyGeometry, Geometry}, match_geometry, Morton};
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
            $crate::geometry::AnyGeometry::Dag($g) => $body,
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
        let AnyGeometry::Dag(dag) = *self;
        Some(dag)
    }

    /// Its words: what a file holds of it.
    pub fn words(&self) -> &'a [u32] {
        match_geometry!(self, g => g.words())
    }

    /// Bytes of its words that hold bricks.
    pub fn brick_bytes(&self) -> u64 {
        match_geometry!(self, g => g.brick_bytes())
    }

    /// Counts voxels and nodes with memory from the heap; `Err` with the number of bytes that could not be had.
    #[cfg(feature = "alloc")]
    pub fn stats(&self) -> Result<Stats, usize> {
        match_geometry!(self, g => g.stats())
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
