//! `voxdag bench materials`: time per look-up of a voxel's material.

use serde::Serialize;
use voxdag::materials::{AnyMaterials, Materials};
use voxdag::{Geometry, Morton, Rank};

use super::{Cost, Run, rays, scattered};
use crate::error::Result;
use crate::measure::{Arm, measure};
use crate::picture::Shown;
use crate::report::{self, Lines, grouped};

/// What `bench materials --json` prints.
#[derive(Serialize)]
struct Report {
    /// How the scene keeps materials.
    kind: &'static str,
    voxels: u64,
    repeat: u32,
    threads: u16,
    /// Of the voxels that a picture shows, in the order of its pixels.
    hits: Cost,
    /// Of voxels from everywhere, in random order.
    scattered: Cost,
    /// Of these the rank alone, of the hits; where there is one.
    rank: Option<Cost>,
    /// What says which material a voxel has, counts of ranks included.
    bytes: u64,
    bits_per_voxel: f64,
    /// Slots that look-ups of all voxels read.
    probes: Option<Probes>,
}

#[derive(Serialize)]
struct Probes {
    mean: f64,
    max: u32,
}

/// Runs the command.
pub fn run(run: &Run, scene: &Shown<'_>) -> Result<()> {
    match scene.materials {
        AnyMaterials::Single(single) => with(run, scene, single, "single"),
        AnyMaterials::Tree(tree) => with(run, scene, tree, "tree"),
        AnyMaterials::Ranked(ids) => with(run, scene, ids, "ranked"),
        AnyMaterials::Palettes(ids) => with(run, scene, ids, "palette"),
        AnyMaterials::Moxels(moxels) => with(run, scene, moxels, "moxel"),
        AnyMaterials::Table(table) => with(run, scene, table, "table"),
    }
}

fn with<M: Materials>(run: &Run, scene: &Shown<'_>, materials: M, kind: &'static str) -> Result<()> {
    let (scattered, voxels) = scattered(run, scene)?;
    let hits: Vec<_> = rays::seen(run, scene)?.iter().map(|f| f.hit.voxel).collect();
    let probes = match scene.materials {
        AnyMaterials::Table(table) => {
            let probes: u64 = scene.geometry.voxels().map(|v| u64::from(table.probes(v))).sum();
            Some(Probes { mean: probes as f64 / voxels.max(1) as f64, max: table.longest_probe() })
        }
        _ => None,
    };

    let look_up = |voxels| Arm::each(voxels, move |v: &Morton| u64::from(materials.id(*v)));
    let rank = scene.materials.rank();
    let ranks = |voxels| Arm::each(voxels, move |v: &Morton| rank.and_then(|rank| rank.rank(*v)).unwrap_or(0));
    let [near, far, ranked] = measure(run.repeat, [look_up(&hits), look_up(&scattered), ranks(&hits)])?;
    let bytes = (size_of_val(scene.materials.words()) + size_of_val(scene.materials.count_words())) as u64;
    let report = Report {
        kind,
        voxels,
        repeat: run.repeat,
        threads: run.threads,
        hits: Cost::of(&near, hits.len()),
        scattered: Cost::of(&far, scattered.len()),
        rank: rank.map(|_| Cost::of(&ranked, hits.len())),
        bytes,
        bits_per_voxel: 8.0 * bytes as f64 / voxels.max(1) as f64,
        probes,
    };
    let mut lines = Lines::default();
    lines.row("kind", report.kind).row("voxels", grouped(report.voxels)).row("hits of a picture", report.hits.text());
    if let Some(rank) = &report.rank {
        lines.row("  of these the rank", rank.text());
    }
    lines.row("scattered", report.scattered.text());
    lines.row("bytes", format!("{} ({:.3} bits per voxel)", grouped(report.bytes), report.bits_per_voxel));
    if let Some(probes) = &report.probes {
        lines.row("probes", format!("{:8.3} on average, {} at most", probes.mean, probes.max));
    }
    report::result(run.report.json, &report, &lines)
}
