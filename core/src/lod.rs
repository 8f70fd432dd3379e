//! Level of detail: a scene at 1/2^k of its resolution, derived from its geometry when it is loaded, without the mesh.
//!
//! In: a geometry, its grid and materials, and a level k. Out: the DAG whose voxels are the non-empty cubes of the octree's
//! level k (exactly `{v >> k}` of the voxels v, so rays hit what [`Query::min_level`](crate::trace::Query::min_level) has
//! them hit, at the same t), the grid that it lies in, and materials that answer one of its voxels with what the first
//! filled voxel of the cube has, in Morton order. Cutting an octree off at a level is as old as octrees (Meagher 1982,
//! section 4); a DAG of its own, instead of a walk that stops early, lets everything that is made for voxels (bricks,
//! packets of rays, normals) work on the coarse ones unchanged.
//!
//! ```text
//! fine    level  depth .. k + 3   k + 2    k + 1   k      below: where materials look for a filled voxel
//! coarse  level  .. 3             bricks (2 .. 0)
//! ```

#[cfg(feature = "alloc")]
use crate::build::{BuildError, DagBuf, DagBuilder};
use crate::geometry::{BRICK_LEVEL, Geometry};
use crate::grid::{Grid, GridError};
use crate::material::MaterialId;
use crate::materials::Materials;
use crate::morton::Morton;

/// A geometry seen at a level of detail: what is derived from it.
///
/// ```
/// use voxdag::{Geometry, Morton, build::DagBuilder, lod::Lod};
/// let mut builder = DagBuilder::new(3)?;
/// builder.push(Morton(64), 0b1000_0001)?; // voxels (4, 0, 0) and (5, 1, 1)
/// let fine = builder.finish()?;
/// let lod = Lod::new(fine.dag(), 1).unwrap();
/// let coarse = lod.build(u32::MAX)?;
/// assert!(coarse.dag().voxels().eq([Morton(64 >> 3)])); // voxel (2, 0, 0) of 4^3
/// assert_eq!(lod.first(Morton(64 >> 3)), Some(Morton(64)));
/// # Ok::<(), voxdag::build::BuildError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Lod<G> {
    geometry: G,
    level: u8,
}

impl<G: Geometry> Lod<G> {
    /// At the octree's `level`: 0 is the voxels themselves, the geometry's depth the whole cube. `None` above that.
    pub fn new(geometry: G, level: u8) -> Option<Lod<G>> {
        (level <= geometry.depth()).then_some(Lod { geometry, level })
    }

    /// The grid of the coarser voxels, for a geometry in `grid`: 2^level times their size, and so many fewer of them,
    /// rounded up. An error where the size overflows.
    pub fn grid(&self, grid: &Grid) -> Result<Grid, GridError> {
        let side = 1u32 << self.level;
        let Grid { origin, voxel_size, resolution } = *grid;
        Grid { origin, voxel_size: voxel_size * f64::from(side), resolution: resolution.div_ceil(side) }.checked()
    }

    /// The coarser voxels: a DAG of `level` levels fewer, of at most `limit` words. O(cubes of the level).
    #[cfg(feature = "alloc")]
    pub fn build(&self, limit: u32) -> Result<DagBuf, BuildError> {
        let Lod { geometry, level } = *self;
        let mut builder = DagBuilder::new(geometry.depth() - level)?;
        builder.limit(limit);
        // Where the root is no whole brick of the coarse cubes, it is what there is of one.
        let brick_level = (level + BRICK_LEVEL).min(geometry.depth().max(BRICK_LEVEL));
        for (code, node) in crate::geometry::Nodes::new(geometry, brick_level) {
            builder.push(Morton(code.0 >> (3 * level)), self.brick(node, brick_level))?;
        }
        builder.finish()
    }

    /// The cubes of a node of `at`, at most two levels above them, as a mask.
    #[cfg(feature = "alloc")]
    fn brick(&self, node: u32, at: u8) -> u64 {
        match at - self.level {
            0 => 1,
            1 => self.octants(node, at).into(),
            _ if self.level == 0 => self.geometry.brick_at(node),
            _ => (0..8).fold(0, |mask, octant| {
                let child = self.geometry.child(node, at, octant);
                mask | child.map_or(0, |child| u64::from(self.octants(child, at - 1))) << (8 * octant)
            }),
        }
    }

    /// Which octants of a node of `level`, 2 or more, hold a voxel.
    #[cfg(feature = "alloc")]
    fn octants(&self, node: u32, level: u8) -> u8 {
        if level > BRICK_LEVEL {
            return self.geometry.mask(node, level);
        }
        let octants = self.geometry.brick_at(node).to_le_bytes();
        (0..8).filter(|&octant| octants[octant] != 0).fold(0, |mask, octant| mask | 1 << octant)
    }

    /// The first filled voxel, in Morton order, of a coarser voxel; `None` if that is empty or outside. O(depth).
    pub fn first(&self, coarse: Morton) -> Option<Morton> {
        let Lod { geometry, level } = *self;
        if geometry.is_empty() || coarse.0 >> (3 * (geometry.depth() - level)) != 0 {
            return None;
        }
        // Down to the cube, then down the first octants that there are.
        let mut code = coarse.0 << (3 * level);
        let mut node = geometry.root();
        for at in (BRICK_LEVEL + 1..=geometry.depth()).rev() {
            let below = at - 1;
            let octant = if below >= level {
                u32::from(Morton(code).octant(below))
            } else {
                let octant = geometry.mask(node, at).trailing_zeros();
                code |= u64::from(octant) << (3 * below);
                octant
            };
            node = geometry.child(node, at, octant)?;
        }
        // The cube's part of the brick, or all of it.
        let part = u64::MAX >> (64 - (1u32 << (3 * level.min(BRICK_LEVEL))));
        let voxels = geometry.brick_at(node) & part << (code & 63);
        (voxels != 0).then(|| Morton(code & !63 | u64::from(voxels.trailing_zeros())))
    }

    /// The materials of the coarser voxels, from those of the fine ones.
    pub fn materials<M>(self, fine: M) -> LodMaterials<G, M> {
        LodMaterials { lod: self, fine }
    }
}

/// Materials of coarser voxels: each has what the first filled voxel of its cube has. See [`Lod::materials`].
#[derive(Clone, Copy, Debug)]
pub struct LodMaterials<G, M> {
    lod: Lod<G>,
    fine: M,
}

impl<G: Geometry, M: Materials> Materials for LodMaterials<G, M> {
    #[inline]
    fn id(&self, voxel: Morton) -> MaterialId {
        self.lod.first(voxel).map_or(0, |first| self.fine.id(first))
    }

    #[inline]
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        self.lod.first(voxel).and_then(|first| self.fine.normal(first))
    }

    #[inline]
    fn color(&self, voxel: Morton) -> Option<[u8; 3]> {
        self.lod.first(voxel).and_then(|first| self.fine.color(first))
    }
}
