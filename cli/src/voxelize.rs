//! From a mesh to its voxels, subtrees on all cores, and why there are none.

use std::time::{Duration, Instant};

use voxdag::build::{BuildError, DagBuf};
use voxdag::grid::{Bounds, Grid, GridError};
use voxdag::mesh::MeshError;
use voxdag::scene::{Build, MaterialMode, Options, PendingMaterials, SceneError};
use voxdag::voxelize::{Cover, VoxelizeError};

use crate::error::{Error, Kind, Result};
use crate::memory::{Memory, round_up};
use crate::options::{BuildArgs, CoverArg};
use crate::ordered::in_order;
use crate::progress::Progress;
use crate::report::triple;
use crate::source::Source;
use crate::stats;

/// Voxels along the longest axis where nobody says otherwise.
const DEFAULT_RESOLUTION: u32 = 512;

/// How to build, as the flags say but for the materials; at most `memory_limit` bytes at one time.
pub fn options(args: &BuildArgs, materials: MaterialMode, memory_limit: Option<u64>) -> Options {
    let cover = match args.cover.unwrap_or_default() {
        CoverArg::Exact => Cover::Exact,
        CoverArg::Thin => Cover::Thin,
        CoverArg::Inflated => Cover::Inflated,
    };
    let colors = args.textures.unwrap_or_default().mode().unwrap_or_default();
    Options { cover, materials, colors, memory_limit, parts_at_once: rayon::current_num_threads() }
}

/// Lays the grid out as the flags say.
fn grid(bounds: &Bounds, args: &BuildArgs) -> std::result::Result<Grid, GridError> {
    // A given origin stands for the box's minimum: the grid reaches from there to the mesh's far side.
    let reach =
        args.origin.map_or(*bounds, |min| Bounds { min, max: std::array::from_fn(|i| bounds.max[i].max(min[i])) });
    match (args.voxel_size, args.resolution) {
        (Some(voxel_size), Some(resolution)) => Grid { origin: reach.min, voxel_size, resolution }.checked(),
        (Some(voxel_size), None) => Grid::with_voxel_size(&reach, voxel_size),
        (None, resolution) => Grid::fit(&reach, resolution.unwrap_or(DEFAULT_RESOLUTION)),
    }
}

/// Voxels of a mesh before anything keeps their materials.
pub struct Voxels<'b, 'm> {
    pub grid: Grid,
    pub bounds: Bounds,
    pub dag: DagBuf,
    /// What material maps are made from.
    pub pending: PendingMaterials<'b, 'm>,
    /// Triangles to bricks, and bricks to subtrees.
    pub voxelize: Duration,
    /// Joining the subtrees.
    pub reduce: Duration,
}

/// Voxelises the mesh on the threads of the current pool, as the flags say but for the materials, and lets `keep` make of
/// the voxels what is to be kept.
pub fn voxelize<T>(
    source: &Source,
    args: &BuildArgs,
    materials: MaterialMode,
    memory: &Memory,
    keep: impl FnOnce(Voxels<'_, '_>) -> std::result::Result<T, SceneError>,
) -> Result<T> {
    let mesh = source.model.mesh();
    let bounds = mesh.validate().map_err(|error| refused(source, SceneError::Voxelize(VoxelizeError::Mesh(error))))?;
    let grid = grid(&bounds, args).map_err(|error| grid_error(source, error))?;
    contains(source, &grid, &bounds)?;
    let refused = |error| match error {
        SceneError::Limit { needed, enough, coarser, .. } => {
            over_limit(source, memory, needed, enough, coarser.then_some(&grid))
        }
        SceneError::Reduce(BuildError::Words { .. }) => {
            let what = format!("{} at resolution {}", source.path.display(), grid.resolution);
            Error::new(Kind::Limit, format_args!("{what} has more nodes than a file can number")).hint(advice(
                source,
                &grid,
                "make the mesh smaller",
            ))
        }
        error => refused(source, error),
    };

    // Sort the triangles into parts, build the parts on all threads and join them as they come.
    let options = options(args, materials, memory.left());
    let start = Instant::now();
    let build = Build::new(&mesh, &grid, &options).map_err(refused)?.with_textures(&source.model.textures);
    let mut join = build.join().map_err(refused)?;
    let mut reduce = Duration::ZERO;
    let progress = Progress::stage("voxelizing", build.parts() as u64);
    let joined = in_order(
        build.parts(),
        |part| build.part(part),
        |parts| {
            for part in parts {
                let part = part?;
                let (added, time) = stats::timed(|| join.add(part));
                added?;
                reduce += time;
                progress.step();
            }
            Ok(())
        },
    );
    drop(progress);
    joined.map_err(refused)?;
    let (finished, time) = stats::timed(|| join.finish());
    let (dag, pending) = finished.map_err(refused)?;
    reduce += time;
    let voxelize = start.elapsed().saturating_sub(reduce);
    keep(Voxels { grid, bounds, dag, pending, voxelize, reduce }).map_err(refused)
}

/// Refuses a mesh that reaches out of a grid that was chosen by hand.
fn contains(source: &Source, grid: &Grid, bounds: &Bounds) -> Result<()> {
    if grid.snap(bounds.min).is_some() && grid.snap(bounds.max).is_some() {
        return Ok(());
    }
    let end = grid.to_world([f64::from(grid.resolution); 3]);
    Err(Error::usage(format_args!(
        "{}: the mesh spans {} to {}, the grid only {} to {}",
        source.path.display(),
        triple(bounds.min),
        triple(bounds.max),
        triple(grid.origin),
        triple(end)
    ))
    .hint("move --origin, or raise --resolution or --voxel-size"))
}

fn grid_error(source: &Source, error: GridError) -> Error {
    match error {
        GridError::Resolution { .. } => {
            Error::new(Kind::Limit, format_args!("{}: {error}", source.path.display())).hint("make --voxel-size larger")
        }
        _ => Error::input(&source.path, error),
    }
}

/// The memory limit is passed; `grid` where a coarser one needs less.
fn over_limit(source: &Source, memory: &Memory, needed: u64, enough: u64, grid: Option<&Grid>) -> Error {
    let limit = format!("--memory-limit {}", round_up(memory.held().saturating_add(enough)));
    let (what, hint) = match grid {
        Some(grid) => {
            (format!("{} at resolution {}", source.path.display(), grid.resolution), advice(source, grid, &limit))
        }
        None => (format!("the mesh {}", source.path.display()), format!("try {limit}")),
    };
    memory.afford(needed, &what, &hint).err().unwrap_or_else(|| Error::new(Kind::Limit, what).hint(hint))
}

/// What to try: a coarser grid where the user can choose it, or what else there is.
fn advice(source: &Source, grid: &Grid, otherwise: &str) -> String {
    if source.files.is_empty() {
        return format!("try {otherwise}");
    }
    format!("try -r {}, or {otherwise}", (grid.resolution / 2).max(1))
}

/// Why the core builds nothing, in this program's words.
fn refused(source: &Source, error: SceneError) -> Error {
    let path = &source.path;
    match error {
        SceneError::Voxelize(VoxelizeError::Grid(error)) => grid_error(source, error),
        SceneError::Voxelize(VoxelizeError::Mesh(MeshError::Empty)) => Error::input(path, "there are no faces in it")
            .hint("expected lines such as `f 1 2 3`; points and lines are not made into voxels"),
        SceneError::Voxelize(VoxelizeError::Mesh(error)) => Error::input(path, error),
        error => Error::new(Kind::Failure, format_args!("{}: {error}", path.display())).hint("try a smaller -r"),
    }
}
