//! The voxel scenes of all settings, each built several times, taking turns.
//!
//! Those of a textbook's overlap test have its voxels, and the materials that the exact cover found.

use std::time::Duration;

use voxdag::Grid;
use voxdag::build::{DagBuf, DagBuilder};
use voxdag::layout::AnyGeometry;

use super::plan::{Overlap, Voxels};
use crate::error::{Error, Kind, Result};
use crate::memory::Memory;
use crate::options::{BuildArgs, MaterialsArg};
use crate::overlap::{self, Brick, Near};
use crate::picture::Shown;
use crate::progress::Progress;
use crate::scene::{self, Built, Source};
use crate::stats;

/// A scene, and what it took.
pub struct Scene {
    pub voxels: Voxels,
    pub built: Built,
    textbook: Option<DagBuf>,
    /// Seconds of each time that it was built: from the mesh in memory to the scene in memory.
    pub seconds: Vec<f64>,
    /// The most memory that building it took beside what was held before.
    pub peak: u64,
}

impl Scene {
    /// As it is drawn.
    pub fn shown(&self) -> Shown<'_> {
        let shown = self.built.shown();
        match &self.textbook {
            Some(dag) => Shown { geometry: AnyGeometry::Dag(dag.dag()), ..shown },
            None => shown,
        }
    }

    /// Filled voxels, and bytes of the `.vxd` file; of a textbook's overlap test those of its geometry.
    pub fn size(&self) -> Result<[u64; 2]> {
        match &self.textbook {
            Some(dag) => Ok([scene::count(AnyGeometry::Dag(dag.dag()))?.voxels, 4 * dag.dag().words().len() as u64]),
            None => Ok([self.built.stats.voxels, self.built.bytes().file]),
        }
    }
}

/// Builds each of `wanted` `repeat` times on the threads of the current pool; the last scenes are kept, and held.
pub fn scenes(
    source: &Source,
    args: &BuildArgs,
    wanted: &[Voxels],
    repeat: usize,
    memory: &mut Memory,
    progress: &Progress,
) -> Result<Vec<Scene>> {
    let mut scenes: Vec<Scene> = Vec::new();
    for repetition in 0..repeat {
        for (i, &voxels) in wanted.iter().enumerate() {
            // The one before goes first: two at a time would need twice the memory.
            let before = (repetition > 0).then(|| scenes.remove(i));
            let mut seconds = before.map_or_else(Vec::new, |scene| {
                memory.release(scene.built.held());
                scene.seconds
            });
            let (made, peak) = stats::peak_of(|| make(source, args, voxels, memory));
            let (built, textbook, time) = made?;
            seconds.push(time.as_secs_f64());
            scenes.insert(i, Scene { voxels, built, textbook, seconds, peak });
            progress.steps(super::cost::build(voxels.resolution));
        }
    }
    Ok(scenes)
}

fn make(
    source: &Source,
    args: &BuildArgs,
    voxels: Voxels,
    memory: &mut Memory,
) -> Result<(Built, Option<DagBuf>, Duration)> {
    let args = BuildArgs {
        resolution: Some(voxels.resolution),
        cover: Some(voxels.cover),
        materials: voxels.normals.then_some(MaterialsArg::TableNormals),
        ..args.clone()
    };
    let built = scene::build(source, &args, memory)?;
    let scene::Cost { voxelize, reduce, materials, .. } = built.cost;
    let test = match voxels.overlap {
        Overlap::Exact => return Ok((built, None, voxelize + reduce + materials)),
        Overlap::F32 => Near::f32,
        Overlap::F64 => Near::f64,
    };
    let (dag, time) = stats::timed(|| {
        let near = overlap::near(&source.model.mesh(), &built.grid);
        dag(&built.grid, &overlap::bricks(&near, test))
    });
    Ok((built, Some(dag?), time + materials))
}

/// The DAG of some bricks.
fn dag(grid: &Grid, bricks: &[Brick]) -> Result<DagBuf> {
    let failed = |error| Error::new(Kind::Failure, error);
    let mut builder = DagBuilder::new(grid.depth()).map_err(failed)?;
    bricks.iter().try_for_each(|&(code, mask)| builder.push(code, mask)).map_err(failed)?;
    builder.finish().map_err(failed)
}
