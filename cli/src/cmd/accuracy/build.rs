//! The voxel scenes of all settings, each built several times, taking turns.
//!
//! Those of a textbook's overlap test have its voxels, and the materials that the exact cover found.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use voxdag::Grid;
use voxdag::build::{DagBuf, DagBuilder};
use voxdag::layout::AnyGeometry;

use super::plan::{Overlap, Voxels};
use crate::error::{Error, Kind, Result};
use crate::memory::Memory;
use crate::options::{BuildArgs, MaterialsArg};
use crate::output::Scratch;
use crate::overlap::{self, Brick, Near};
use crate::picture::Shown;
use crate::progress::Progress;
use crate::scene::{self, Built};
use crate::source::Source;
use crate::stats;

/// A scene, and what it took.
pub struct Scene {
    pub voxels: Voxels,
    pub built: Built,
    textbook: Option<DagBuf>,
    /// Seconds of each time that it was built: from the mesh in memory to the scene in memory.
    pub seconds: Vec<f64>,
    /// The most memory that a `voxdag build` of its own holds, from the file on; `None` where the system does not tell, and
    /// where there is no file or no flag for it.
    pub peak: Option<u64>,
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

/// Builds each of `wanted` `repeat` times on the threads of the current pool; the last scenes are kept, and held. `file` is
/// the mesh's, if it has one.
pub fn scenes(
    source: &Source,
    file: Option<&Path>,
    args: &BuildArgs,
    wanted: &[Voxels],
    repeat: usize,
    memory: &mut Memory,
    progress: &Progress,
) -> Result<Vec<Scene>> {
    let mut scenes: Vec<Scene> = Vec::new();
    for repetition in 0..repeat {
        for (i, &voxels) in wanted.iter().enumerate() {
            let args = flags(args, voxels);
            // The one before goes first: two at a time would need twice the memory.
            let before = (repetition > 0).then(|| scenes.remove(i));
            let (mut seconds, peak) = match before {
                None => {
                    (Vec::new(), file.filter(|_| voxels.overlap == Overlap::Exact).and_then(|file| peak(file, &args)))
                }
                Some(scene) => {
                    memory.release(scene.built.held());
                    (scene.seconds, scene.peak)
                }
            };
            let (built, textbook, time) = make(source, &args, voxels.overlap, memory)?;
            seconds.push(time.as_secs_f64());
            scenes.insert(i, Scene { voxels, built, textbook, seconds, peak });
            progress.steps(super::cost::build(voxels.resolution));
        }
    }
    Ok(scenes)
}

/// The flags that build some voxels.
fn flags(args: &BuildArgs, voxels: Voxels) -> BuildArgs {
    BuildArgs {
        resolution: Some(voxels.resolution),
        cover: Some(voxels.cover),
        materials: voxels.normals.then_some(MaterialsArg::TableNormals),
        ..args.clone()
    }
}

fn make(
    source: &Source,
    args: &BuildArgs,
    overlap: Overlap,
    memory: &mut Memory,
) -> Result<(Built, Option<DagBuf>, Duration)> {
    let built = scene::build(source, args, memory)?;
    let scene::Cost { voxelize, reduce, materials, .. } = built.cost;
    let test = match overlap {
        Overlap::Exact => return Ok((built, None, voxelize + reduce + materials)),
        Overlap::F32 => Near::f32,
        Overlap::F64 => Near::f64,
    };
    let mesh = source.model.mesh();
    memory.afford(overlap::bytes(&mesh, &built.grid), "the textbook's overlap test", overlap::HINT)?;
    let (dag, time) = stats::timed(|| {
        let near = overlap::near(&mesh, &built.grid);
        dag(&built.grid, &overlap::bricks(&near, test))
    });
    Ok((built, Some(dag?), time + materials))
}

/// The peak of memory of this program when it builds the file and nothing else, as it says itself.
fn peak(file: &Path, args: &BuildArgs) -> Option<u64> {
    let folder = Scratch::create().ok()?;
    let output = Command::new(std::env::current_exe().ok()?)
        .arg("build")
        .arg(file)
        .arg("-o")
        .arg(folder.path("scene.vxd"))
        .args(args.typed().split_whitespace())
        .args(["--json", "--threads", &rayon::current_num_threads().to_string()])
        .stderr(Stdio::null())
        .output()
        .ok()?;
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
    report.get("peak_rss_bytes")?.as_u64()
}

/// The DAG of some bricks.
fn dag(grid: &Grid, bricks: &[Brick]) -> Result<DagBuf> {
    let failed = |error| Error::new(Kind::Failure, error);
    let mut builder = DagBuilder::new(grid.depth()).map_err(failed)?;
    bricks.iter().try_for_each(|&(code, mask)| builder.push(code, mask)).map_err(failed)?;
    builder.finish().map_err(failed)
}
