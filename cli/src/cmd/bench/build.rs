//! `voxdag bench build`: voxels per second, by stage of building a mesh.
//!
//! Every stage but the first works on what the one before it left, made once and kept. Materials are the exception: who
//! owns a voxel is found while voxelising, so their time is what parts take longer with materials than without, and
//! the filling of the table.

use serde::Serialize;
use voxdag::Morton;
use voxdag::build::{BuildError, DagBuf, DagBuilder};
use voxdag::scene::{Build, MaterialMode, Options, PendingMaterials, SceneError};
use voxdag::voxelize::{VoxelizeError, Voxelizer};

use super::Run;
use crate::error::{Error, Kind, Result};
use crate::measure::{Arm, Spread, Times, measure};
use crate::report::{self, Lines, grouped};
use crate::scene;
use crate::source::Source;
use crate::voxelize;

/// What `bench build --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    triangles: usize,
    voxels: u64,
    repeat: u32,
    threads: u16,
    /// Vertices to the grid, triangles into subtrees.
    snap_sort: Stage,
    /// Subtrees to bricks.
    voxelize: Stage,
    /// Bricks to DAGs of subtrees.
    reduce: Stage,
    /// DAGs of subtrees to one.
    join: Stage,
    /// Owners of voxels, and their table; where there are materials.
    materials: Option<Stage>,
    /// All of it, from the mesh in memory to the scene in memory.
    total: Stage,
}

/// CPU time of a stage, and the voxels of the scene by it.
#[derive(Serialize)]
struct Stage {
    mvoxels_per_s: f64,
    ms: f64,
    ms_min: f64,
    ms_max: f64,
}

impl Stage {
    fn of(seconds: impl IntoIterator<Item = f64>, voxels: u64) -> Stage {
        let Spread { median, min, max } = Spread::of(seconds.into_iter().map(|s| 1e3 * s));
        Stage { mvoxels_per_s: voxels as f64 / median / 1e3, ms: median, ms_min: min, ms_max: max }
    }

    fn text(&self) -> String {
        let Stage { mvoxels_per_s, ms, ms_min, ms_max } = self;
        format!("{mvoxels_per_s:8.1} Mvoxels/s, {ms:8.1} ms ({ms_min:.1} to {ms_max:.1})")
    }
}

/// Runs the command.
pub fn run(run: &Run, source: &Source) -> Result<()> {
    let mesh = source.model.mesh();
    // Built once as `build` does it: every complaint about mesh and flags comes from there.
    let built = scene::build(source, &run.build, &mut run.machine().memory())?;
    let (grid, voxels) = (built.grid, built.stats.voxels);
    drop(built);
    let options = voxelize::options(&run.build, scene::mode(&run.build), None);
    let defect = |error: &dyn std::fmt::Display| Error::new(Kind::Failure, error);

    // What the stages leave: a voxeliser, bricks and DAGs of its subtrees, and the same with materials.
    let voxelizer = Voxelizer::new(&mesh, &grid, options.cover).map_err(|e| defect(&e))?;
    let parts = voxelizer.subtrees();
    let bricks: std::result::Result<Vec<_>, _> = (0..parts).map(|part| bricks(&voxelizer, part)).collect();
    let bricks = bricks.map_err(|e| defect(&e))?;
    let depth = voxelizer.subtree_depth();
    let dags: std::result::Result<Vec<_>, _> = bricks.iter().map(|bricks| reduce(depth, bricks)).collect();
    let dags = dags.map_err(|e| defect(&e))?;
    let plain = Options { materials: MaterialMode::None, ..options };
    let plain = Build::new(&mesh, &grid, &plain).map_err(|e| defect(&e))?;
    let build = Build::new(&mesh, &grid, &options).map_err(|e| defect(&e))?;
    let (dag, pending) = joined(&build).map_err(|e| defect(&e))?;

    // Errors, which cannot come any more, would change the checksums.
    let ok = u64::from;
    let part = |build: &Build<'_>, i| ok(build.part(i).is_ok());
    let [snap_sort, voxelize, reduce, join, without, with, table, total] = measure(
        run.repeat,
        [
            Arm::pieces(1, |_| Voxelizer::new(&mesh, &grid, options.cover).map_or(0, |v| v.subtrees() as u64)),
            Arm::pieces(parts, |part| voxelized(&voxelizer, part)),
            Arm::pieces(parts, |part| reduce(depth, &bricks[part]).map_or(0, |dag| dag.words().len() as u64)),
            Arm::pieces(1, |_| join(&voxelizer, &dags).map_or(0, |dag| dag.words().len() as u64)),
            Arm::pieces(parts, |i| part(&plain, i)),
            Arm::pieces(parts, |i| part(&build, i)),
            Arm::pieces(1, |_| ok(pending.materials(&dag.dag(), options.materials).is_ok())),
            Arm::pieces(1, |_| {
                let built = Build::new(&mesh, &grid, &options).and_then(|build| build.run());
                built.map_or(0, |built| built.dag.words().len() as u64)
            }),
        ],
    )?;

    let stage = |times: Times| Stage::of(times.seconds, voxels);
    let owners = with
        .seconds
        .iter()
        .zip(&without.seconds)
        .zip(&table.seconds)
        .map(|((with, without), table)| with - without + table);
    let report = Report {
        resolution: grid.resolution,
        triangles: mesh.triangles.len(),
        voxels,
        repeat: run.repeat,
        threads: run.threads,
        materials: (options.materials != MaterialMode::None).then(|| Stage::of(owners, voxels)),
        snap_sort: stage(snap_sort),
        voxelize: stage(voxelize),
        reduce: stage(reduce),
        join: stage(join),
        total: stage(total),
    };
    report::result(run.report.json, &report, &lines(&report))
}

/// Voxelises a subtree and gives a checksum.
pub fn voxelized(voxelizer: &Voxelizer<'_>, part: usize) -> u64 {
    let mut sum = 0u64;
    let done = voxelizer.voxelize::<VoxelizeError>(part, |brick| {
        sum = sum.wrapping_add(brick.mask ^ brick.code.0);
        Ok(())
    });
    sum ^ u64::from(done.is_ok())
}

/// The bricks of a subtree: their codes and masks.
fn bricks(voxelizer: &Voxelizer<'_>, part: usize) -> std::result::Result<Vec<(Morton, u64)>, VoxelizeError> {
    let mut bricks = Vec::new();
    voxelizer.voxelize(part, |brick| {
        bricks.push((brick.code, brick.mask));
        Ok(())
    })?;
    Ok(bricks)
}

/// The DAG of a subtree.
fn reduce(depth: u8, bricks: &[(Morton, u64)]) -> std::result::Result<DagBuf, BuildError> {
    let mut builder = DagBuilder::new(depth)?;
    bricks.iter().try_for_each(|&(code, mask)| builder.push(code, mask))?;
    builder.finish()
}

/// The DAG of all subtrees.
fn join(voxelizer: &Voxelizer<'_>, parts: &[DagBuf]) -> std::result::Result<DagBuf, BuildError> {
    let mut builder = DagBuilder::new(voxelizer.grid().depth())?;
    for (part, dag) in parts.iter().enumerate() {
        builder.append(voxelizer.subtree_code(part), &dag.dag())?;
    }
    builder.finish()
}

/// The whole DAG, and what its table is filled from.
fn joined<'b, 'm>(build: &'b Build<'m>) -> std::result::Result<(DagBuf, PendingMaterials<'b, 'm>), SceneError> {
    let mut join = build.join()?;
    (0..build.parts()).try_for_each(|part| join.add(build.part(part)?))?;
    join.finish()
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    lines
        .row("resolution", format!("{} voxels along the longest axis", grouped(report.resolution.into())))
        .row("triangles", grouped(report.triangles as u64))
        .row("voxels", grouped(report.voxels))
        .row("snap and sort", report.snap_sort.text())
        .row("voxelize", report.voxelize.text())
        .row("reduce", report.reduce.text())
        .row("join", report.join.text());
    if let Some(materials) = &report.materials {
        lines.row("materials", materials.text());
    }
    lines.row("total", report.total.text());
    lines
}
