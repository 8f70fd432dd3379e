//! `voxdag bench normals`: time per normal at the hits of a picture.

use serde::Serialize;
use voxdag::Geometry;
use voxdag::match_geometry;
use voxdag::normal::{NormalKind, normal};

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
}

/// Runs the command.
pub fn run(run: &Run, scene: &Shown<'_>) -> Result<()> {
    match_geometry!(scene.geometry, geometry => with(run, scene, geometry, &rays::seen(run, scene)?))
}

fn with<G: Geometry>(run: &Run, scene: &Shown<'_>, geometry: G, found: &[Found]) -> Result<()> {
    let top = rays::top_grid(geometry)?;
    let (tracer, materials) = (rays::tracer(geometry, &top)?, scene.materials);
    let kind = |kind| {
        Arm::each(found, move |f: &Found| {
            let n = normal(&tracer, materials, &f.hit, f.dir, kind).direction;
            n.iter().fold(0, |sum: u64, x| sum.rotate_left(21) ^ u64::from(x.to_bits()))
        })
    };
    let (hits, dirs): (Vec<_>, Vec<_>) = found.iter().map(|f| (f.hit, f.dir)).unzip();
    let many = |level: Option<voxdag::simd::Level>, kind, chunk: usize| {
        let (hits, dirs) = (&hits, &dirs);
        Arm::blocks(hits.len(), move |range| {
            let mut out = vec![voxdag::normal::Normal { direction: [0.0; 3], confidence: voxdag::normal::Confidence::Face }; chunk];
            let mut sum = 0u64;
            for (h, d) in hits[range.clone()].chunks(chunk).zip(dirs[range].chunks(chunk)) {
                voxdag::normal::normals(level, &tracer, materials, h, d, kind, &mut out);
                sum = out[..h.len()].iter().fold(sum, |sum, n| sum.wrapping_add(n.direction.iter().fold(0, |sum: u64, x| sum.rotate_left(21) ^ u64::from(x.to_bits()))));
            }
            sum
        })
    };
    let levels: Vec<_> = [None].into_iter().chain(voxdag::simd::Level::all().map(Some)).collect();
    for (kind2, name) in [(NormalKind::Gradient, "gradient"), (NormalKind::Plane1, "plane1"), (NormalKind::Plane2, "plane2"), (NormalKind::Plane3, "plane3")] {
        for chunk in [256, 4096, 16384] {
        for &level in &levels {
            let [a, b] = measure(run.repeat, [many(level, kind2, chunk), kind(kind2)])?;
            println!("{name} {chunk} {:?} {} single {} {}", level.map(|l| l.name()), Cost::of(&a, found.len()).text(), Cost::of(&b, found.len()).text(), a.checksum == b.checksum);
        }}
    }
    let [face, gradient, plane1, plane2, plane3, ernerfeldt1, ernerfeldt2, stored] = measure(
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
    lines
}
