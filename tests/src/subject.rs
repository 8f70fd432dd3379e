//! The core under test, one call per stage, with the answers in the oracles' terms.

use std::collections::BTreeSet;

use voxdag::build::{BuildError, DagBuf, DagBuilder};
use voxdag::voxelize::{Cover, VoxelizeError, Voxelizer};
use voxdag::{Grid, Mesh, Morton};

use crate::clip::Cell;
use crate::scenes::Shape;

/// What the core can refuse.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Refused {
    /// By the voxeliser.
    Voxelize(VoxelizeError),
    /// By the builder.
    Build(BuildError),
}

impl From<VoxelizeError> for Refused {
    fn from(e: VoxelizeError) -> Refused {
        Refused::Voxelize(e)
    }
}

impl From<BuildError> for Refused {
    fn from(e: BuildError) -> Refused {
        Refused::Build(e)
    }
}

/// The grid of `n` voxels of side 1 at the origin, in which scenes in voxel units lie as they are.
pub fn unit_grid(n: u32) -> Grid {
    Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: n }
}

/// The grid that the core fits to a shape.
pub fn fitted(shape: &Shape, n: u32) -> Grid {
    Grid::fit(&shape.mesh().validate().expect("a good mesh"), n).expect("a good grid")
}

/// Mesh to DAG, all subtrees through one builder.
pub fn build(mesh: &Mesh<'_>, grid: &Grid, cover: Cover) -> Result<DagBuf, Refused> {
    let voxelizer = Voxelizer::new(mesh, grid, cover)?;
    let mut builder = DagBuilder::new(grid.depth())?;
    for subtree in 0..voxelizer.subtrees() {
        let base = voxelizer.subtree_code(subtree).0;
        voxelizer
            .voxelize(subtree, |brick| builder.push(Morton(base | brick.code.0), brick.mask).map_err(Refused::Build))?;
    }
    Ok(builder.finish()?)
}

/// Mesh to DAG the other way: a DAG per subtree, built in the order that `order` gives, then joined.
pub fn build_apart(mesh: &Mesh<'_>, grid: &Grid, cover: Cover, order: &[usize]) -> Result<DagBuf, Refused> {
    let voxelizer = Voxelizer::new(mesh, grid, cover)?;
    let mut parts: Vec<Option<DagBuf>> = vec![None; voxelizer.subtrees()];
    for &subtree in order {
        let mut builder = DagBuilder::new(voxelizer.subtree_depth())?;
        voxelizer.voxelize(subtree, |brick| builder.push(brick.code, brick.mask).map_err(Refused::Build))?;
        parts[subtree] = Some(builder.finish()?);
    }
    let mut builder = DagBuilder::new(grid.depth())?;
    for (subtree, part) in parts.iter().enumerate() {
        builder
            .append(voxelizer.subtree_code(subtree), &part.as_ref().expect("every subtree is in the order").dag())?;
    }
    Ok(builder.finish()?)
}

/// The voxels of a DAG.
pub fn voxels(built: &DagBuf) -> BTreeSet<[u32; 3]> {
    built.dag().voxels().map(Morton::decode).collect()
}

/// The voxels that the core marks.
pub fn cover(shape: &Shape, grid: &Grid, cover: Cover) -> BTreeSet<[u32; 3]> {
    voxels(&build(&shape.mesh(), grid, cover).expect("a good scene"))
}

/// The voxels that the oracle marks.
pub fn true_cover(shape: &Shape, grid: &Grid, cover: Cover) -> BTreeSet<[u32; 3]> {
    let triangles = shape.snapped(grid.origin, grid.voxel_size, grid.resolution);
    let depth = grid.depth();
    let mut truth = match cover {
        Cover::Exact => crate::clip::cover(&triangles, depth, Cell::HalfOpen),
        // Its guarantee is about the original floats, so nothing is pulled in.
        Cover::Inflated => crate::clip::cover(&shape.rounded(grid.origin, grid.voxel_size), depth, Cell::Inflated),
        Cover::Thin => crate::thin::cover(&triangles, depth),
    };
    // An inflated voxel beyond the grid is none.
    truth.retain(|v| v.iter().all(|&k| k < grid.resolution));
    truth
}
