//! `voxdag bench normals`: time per normal at the hits of a picture, one by one and in batches.

use serde::Serialize;
use voxdag::Geometry;
use voxdag::match_geometry;
use voxdag::normal::{Confidence, Normal, NormalKind, normal, normals};
use voxdag::simd::Level;

use super::rays::Found;
use super::{Cost, Run, rays};
use crate::error::Result;
use crate::measure::{Arm, measure};
use crate::picture::Shown;
use crate::report::{self, Lines, grouped};

/// What `bench normals --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    /// Normals per repetition.
    hits: usize,
    repeat: u32,
    threads: u16,
    face: Cost,
    gradient: Cost,
    plane1: Cost,
    plane2: Cost,
    plane3: Cost,
    ernerfeldt1: Cost,
    ernerfeldt2: Cost,
    /// Where the scene keeps normals.
    stored: Option<Cost>,
    /// In batches, without vectors and with the widest ones.
    batches: [Batches; 2],
}

/// Normals at many hits at once.
#[derive(Serialize)]
struct Batches {
    /// Name of the vectors.
    level: &'static str,
    gradient: Cost,
    plane1: Cost,
    plane2: Cost,
    plane3: Cost,
}

/// Hits of a batch: what a tile of a picture has.
const BATCH: usize = 64;

/// Runs the command.
pub fn run(run: &Run, scene: &Shown<'_>) -> Result<()> {
    match_geometry!(scene.geometry, geometry => with(run, scene, geometry, &rays::seen(run, scene)?))
}

fn with<G: Geometry>(run: &Run, scene: &Shown<'_>, geometry: G, found: &[Found]) -> Result<()> {
    let top = rays::top_grid(geometry)?;
    let (tracer, materials) = (rays::tracer(geometry, &top)?, scene.materials);
    let checksum = |n: Normal| n.direction.iter().fold(0, |sum: u64, x| sum.rotate_left(21) ^ u64::from(x.to_bits()));
    let kind = |kind| Arm::each(found, move |f: &Found| checksum(normal(&tracer, materials, &f.hit, f.dir, kind)));
    let (hits, dirs): (Vec<_>, Vec<_>) = found.iter().map(|f| (f.hit, f.dir)).unzip();
    let batches: Vec<_> = hits.chunks(BATCH).zip(dirs.chunks(BATCH)).collect();
    let best = Level::best();
    let many = |level, kind| {
        Arm::batches(&batches, BATCH, move |(hits, dirs)| {
            let mut found = [Normal { direction: [0.0; 3], confidence: Confidence::Face }; BATCH];
            normals(level, &tracer, materials, hits, dirs, kind, &mut found);
            found[..hits.len()].iter().fold(0, |sum: u64, n| sum.wrapping_add(checksum(*n)))
        })
    };
    let [
        face,
        gradient,
        plane1,
        plane2,
        plane3,
        ernerfeldt1,
        ernerfeldt2,
        stored,
        gradients,
        planes1,
        planes2,
        planes3,
        wide_gradients,
        wide_planes1,
        wide_planes2,
        wide_planes3,
    ] = measure(
        run.repeat,
        [
            kind(NormalKind::Face),
            kind(NormalKind::Gradient),
            kind(NormalKind::Plane1),
            kind(NormalKind::Plane2),
            kind(NormalKind::Plane3),
            kind(NormalKind::Ernerfeldt1),
            kind(NormalKind::Ernerfeldt2),
            kind(if scene.has_normals() { NormalKind::Stored } else { NormalKind::Face }),
            many(None, NormalKind::Gradient),
            many(None, NormalKind::Plane1),
            many(None, NormalKind::Plane2),
            many(None, NormalKind::Plane3),
            many(best, NormalKind::Gradient),
            many(best, NormalKind::Plane1),
            many(best, NormalKind::Plane2),
            many(best, NormalKind::Plane3),
        ],
    )?;
    let cost = |times| Cost::of(times, found.len());
    let report = Report {
        resolution: scene.grid.resolution,
        hits: found.len(),
        repeat: run.repeat,
        threads: run.threads,
        face: cost(&face),
        gradient: cost(&gradient),
        plane1: cost(&plane1),
        plane2: cost(&plane2),
        plane3: cost(&plane3),
        ernerfeldt1: cost(&ernerfeldt1),
        ernerfeldt2: cost(&ernerfeldt2),
        stored: scene.has_normals().then(|| cost(&stored)),
        batches: [
            Batches {
                level: "none",
                gradient: cost(&gradients),
                plane1: cost(&planes1),
                plane2: cost(&planes2),
                plane3: cost(&planes3),
            },
            Batches {
                level: best.map_or("none", Level::name),
                gradient: cost(&wide_gradients),
                plane1: cost(&wide_planes1),
                plane2: cost(&wide_planes2),
                plane3: cost(&wide_planes3),
            },
        ],
    };
    report::result(run.report.json, &report, &lines(&report))
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    lines.row("hits", grouped(report.hits as u64));
    let kinds = [
        ("face", &report.face),
        ("gradient", &report.gradient),
        ("plane1", &report.plane1),
        ("plane2", &report.plane2),
        ("plane3", &report.plane3),
        ("ernerfeldt1", &report.ernerfeldt1),
        ("ernerfeldt2", &report.ernerfeldt2),
    ];
    for (name, cost) in kinds.into_iter().chain(report.stored.as_ref().map(|cost| ("stored", cost))) {
        lines.row(name, cost.text());
    }
    for Batches { level, gradient, plane1, plane2, plane3 } in &report.batches {
        for (name, cost) in [("gradient", gradient), ("plane1", plane1), ("plane2", plane2), ("plane3", plane3)] {
            lines.row(format!("{name}, {BATCH} at once, vectors: {level}"), cost.text());
        }
    }
    lines
}
