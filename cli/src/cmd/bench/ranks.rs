//! `voxdag bench ranks`: what it takes to number the filled voxels, and to look materials up by number.

use serde::Serialize;
use voxdag::build::{BuildError, DagBuilder};
use voxdag::rank::{MoxelDagBuf, OffsetsBuf, Prefix};
use voxdag::ranked::{MoxelsBuf, PackedBuf, PalettesBuf, Ranked};
use voxdag::table::Entry;
use voxdag::{Geometry, Materials, Morton, Rank};
use voxdag_oracle::rng::Rng;

use super::{Cost, Run, rays};
use crate::error::{Error, Kind, Result};
use crate::measure::{Arm, measure};
use crate::picture::Shown;
use crate::report::{self, Lines, grouped, size};
use crate::stats;

/// Voxels of the scattered look-ups, at most.
const SCATTERED: u64 = 1 << 20;

/// What `bench ranks --json` prints.
#[derive(Serialize)]
struct Report {
    voxels: u64,
    repeat: u32,
    threads: u16,
    rows: Vec<Row>,
}

/// One scheme.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    /// Words of its own, in bytes: beside the DAG, or of geometry and counts together for those that are a geometry.
    bytes: u64,
    bits_per_voxel: f64,
    build_seconds: f64,
    /// Of the voxels that a picture shows, in the order of its pixels.
    hits: Cost,
    /// Of voxels from everywhere, in random order.
    scattered: Cost,
}

/// Builds a scheme and takes the time.
fn built<T, E: std::fmt::Display>(build: impl FnOnce() -> std::result::Result<T, E>) -> Result<(T, f64)> {
    let (built, time) = stats::timed(build);
    Ok((built.map_err(|e| Error::new(Kind::Failure, e))?, time.as_secs_f64()))
}

/// Runs the command.
pub fn run(run: &Run, scene: &Shown<'_>) -> Result<()> {
    let materials = scene.materials;
    let (dag, _) = built(|| -> std::result::Result<_, BuildError> {
        let mut builder = DagBuilder::new(scene.geometry.depth())?;
        scene.geometry.bricks().try_for_each(|(code, mask)| builder.push(code, mask))?;
        builder.finish()
    })?;
    let dag = dag.dag();
    let entries = || {
        dag.voxels().map(move |voxel| (voxel, Entry { material: materials.id(voxel), normal: materials.normal(voxel) }))
    };
    let (counts, counts_time) = built(|| Prefix::build(&dag))?;
    let (prefix, _) = built(|| Prefix::new(dag, &counts))?;
    let (offsets, offsets_time) = built(|| OffsetsBuf::build(&dag))?;
    let (moxel_dag, moxel_dag_time) = built(|| MoxelDagBuf::build(&dag))?;
    let (offsets, moxel_dag) = (offsets.as_offsets(), moxel_dag.as_moxel_dag());
    let (packed, packed_time) = built(|| PackedBuf::from_entries(entries()))?;
    let (palettes, palettes_time) = built(|| PalettesBuf::from_entries(entries()))?;
    let (moxels, moxels_time) = built(|| MoxelsBuf::from_entries(entries(), materials.has_normals()))?;
    let (by_ids, _) = built(|| Ranked::new(prefix, packed.as_packed()))?;
    let (by_palettes, _) = built(|| Ranked::new(prefix, palettes.as_palettes()))?;
    let (by_moxels, _) = built(|| Ranked::new(moxel_dag, moxels.as_moxels()))?;
    let schemes = [
        ("rank: prefix counts", counts.len(), counts_time),
        ("rank: offsets in pointers", offsets.words().len(), offsets_time),
        ("rank: moxel DAG", moxel_dag.words().len(), moxel_dag_time),
        ("ids by prefix counts", packed.as_packed().words().len(), packed_time),
        ("palettes by prefix counts", palettes.as_palettes().words().len(), palettes_time),
        ("moxel table by moxel DAG", moxels.as_moxels().words().len(), moxels_time),
        ("as the scene keeps them", materials.words().len(), 0.0),
    ];

    let hits: Vec<_> = rays::seen(run, scene)?.iter().map(|f| f.hit.voxel).collect();
    let voxels = prefix.count();
    let mut scattered: Vec<_> = dag.voxels().step_by(voxels.div_ceil(SCATTERED).max(1) as usize).collect();
    Rng::new(3).shuffle(&mut scattered);
    let arms = |voxels| {
        [
            Arm::each(voxels, move |v: &Morton| prefix.rank(*v).unwrap_or(0)),
            Arm::each(voxels, move |v: &Morton| offsets.rank(*v).unwrap_or(0)),
            Arm::each(voxels, move |v: &Morton| moxel_dag.rank(*v).unwrap_or(0)),
            Arm::each(voxels, move |v: &Morton| by_ids.id(*v).into()),
            Arm::each(voxels, move |v: &Morton| by_palettes.id(*v).into()),
            Arm::each(voxels, move |v: &Morton| by_moxels.id(*v).into()),
            Arm::each(voxels, move |v: &Morton| materials.id(*v).into()),
        ]
    };
    let near = measure(run.repeat, arms(&hits))?;
    let far = measure(run.repeat, arms(&scattered))?;

    let rows = schemes.into_iter().zip(near.iter().zip(&far)).map(|((name, words, build_seconds), (near, far))| Row {
        name,
        bytes: 4 * words as u64,
        bits_per_voxel: 32.0 * words as f64 / voxels.max(1) as f64,
        build_seconds,
        hits: Cost::of(near, hits.len()),
        scattered: Cost::of(far, scattered.len()),
    });
    let report = Report { voxels, repeat: run.repeat, threads: run.threads, rows: rows.collect() };
    let mut lines = Lines::default();
    lines.row("voxels", grouped(report.voxels));
    for row in &report.rows {
        let bytes = format!("{}, {:.3} bits/voxel", size(row.bytes), row.bits_per_voxel);
        let times = format!("hits {:6.1} ns, scattered {:6.1} ns", row.hits.ns, row.scattered.ns);
        lines.row(row.name, format!("{times}; {bytes}; built in {:.1} ms", 1e3 * row.build_seconds));
    }
    report::result(run.report.json, &report, &lines)
}
