//! One scene at one resolution: everything is built from the same voxels and drawn in every configuration, and the numbers
//! go into the tables. The runs of all configurations take turns, so that a machine that slows down slows all of them.

use std::collections::BTreeSet;
use std::sync::Arc;

use voxdag::grid::{Bounds, UpAxis};
use voxdag::materials::{Materials, MaterialsBuf};
use voxdag::render::Samples;
use voxdag::scene::{MaterialMode, SceneError};
use voxdag::trace::Arithmetic;
use voxdag::trees::Trees;
use voxdag::{Dag, Grid, Material, Morton, Rank, thesis, with_tracer};

use super::draw;
use super::published::Published;
use super::report::{Agreement, Report};
use super::table::Cell;
use crate::error::{Error, Kind, Result};
use crate::layout::Layout;
use crate::measure::{Arm, Spread, Times, measure};
use crate::memory::Memory;
use crate::options::{BuildArgs, GeometryArg, NormalsArg, PictureArgs};
use crate::picture::{self, Extras, Picture, Shown};
use crate::scene;
use crate::source::Source;
use crate::stats::{self, ms};
use crate::voxelize::{self, Voxels};

/// What is measured.
pub struct Subject<'a> {
    pub name: &'a str,
    pub source: &'a Source,
    pub published: Option<&'static Published>,
    pub resolution: u32,
    pub runs: u32,
    /// Whether times can stand beside the thesis's: of the same number of pixels, from where its scene is seen.
    pub usual_view: bool,
}

/// Layouts by what the tables call them.
const LAYOUTS: [(&str, GeometryArg); 5] = [
    ("sparse voxel DAG", GeometryArg::Dag),
    ("SSVDAG, packed", GeometryArg::Ssvdag),
    ("octree with pointers", GeometryArg::Svo),
    ("DAG with offsets in its pointers", GeometryArg::Offsets),
    ("moxel DAG", GeometryArg::Moxel),
];
pub const DAG: usize = 0;
pub const SSVDAG: usize = 1;
const OFFSETS: usize = 3;
pub const MOXEL_DAG: usize = 4;

/// Representations of materials by what the tables call them.
const MATERIALS: [(&str, MaterialMode); 7] = [
    ("material tree", MaterialMode::Tree),
    ("hash table", MaterialMode::Table),
    ("hash table with normals", MaterialMode::TableNormals),
    ("ids by rank, packed", MaterialMode::Ranked),
    ("palette blocks by rank", MaterialMode::Palettes),
    ("moxel table", MaterialMode::Moxels),
    ("moxel table with normals", MaterialMode::MoxelsNormals),
];
pub const TREE: usize = 0;
pub const TABLE: usize = 1;
pub const TABLE_NORMALS: usize = 2;
pub const MOXELS_NORMALS: usize = 6;

/// Everything that is made of a scene's voxels.
struct Kept {
    layouts: Vec<Layout>,
    materials: Vec<MaterialsBuf>,
    grid: Grid,
    bounds: Bounds,
}

impl Kept {
    fn bytes(&self) -> u64 {
        let layouts: usize = self.layouts.iter().map(|layout| 4 * layout.words()).sum();
        let materials: usize = self.materials.iter().map(|materials| size_of_val(materials.words())).sum();
        (layouts + materials) as u64
    }
}

/// Times of the stages of building, in ms.
#[derive(Default)]
struct Stages {
    voxelize: Vec<f64>,
    dag: Vec<f64>,
    table: Vec<f64>,
    moxel_dag: Vec<f64>,
    moxel_table: Vec<f64>,
    tree: Vec<f64>,
    ssvdag: Vec<f64>,
}

/// Measures, and gives the pictures of all configurations by name.
pub fn run(
    subject: &Subject<'_>,
    report: &mut Report,
    args: &PictureArgs,
    progress: &dyn Fn(f64),
    memory: &mut Memory,
) -> Result<Vec<(&'static str, Picture)>> {
    let kept = build(subject, report, memory)?;
    memory.hold(kept.bytes());
    progress(0.2);
    let palette: Vec<Material> = subject.source.model.materials.iter().map(|m| m.material).collect();
    let shown = |layout: usize, materials: usize| -> Result<Shown<'_>> {
        let layout = &kept.layouts[layout];
        let materials = kept.materials[materials].as_materials(layout.rank()).map_err(defect)?;
        Ok(Shown {
            grid: kept.grid,
            bounds: kept.bounds,
            up: UpAxis::Y,
            geometry: layout.geometry(),
            materials,
            colors: None,
            palette: palette.clone(),
            lod: None,
        })
    };
    sizes(subject, report, &kept)?;
    look_ups(subject, report, &kept, &shown(DAG, TREE)?, args, memory)?;
    progress(0.1);
    agree(subject, report, &shown, args, memory)?;
    progress(0.2);
    let pictures = draw::run(subject, report, &shown, args, progress, memory);
    memory.release(kept.bytes());
    pictures
}

fn defect(error: impl std::fmt::Display) -> Error {
    Error::new(Kind::Failure, format_args!("{error}: this is a defect of voxdag"))
}

/// Builds everything as often as asked for, and keeps what the last run made.
fn build(subject: &Subject<'_>, report: &mut Report, memory: &Memory) -> Result<Kept> {
    let args = BuildArgs { resolution: Some(subject.resolution), ..BuildArgs::default() };
    let mut stages = Stages::default();
    let mut kept = None;
    for run in 0..subject.runs {
        let last = run + 1 == subject.runs;
        kept = voxelize::voxelize(subject.source, &args, MaterialMode::TableNormals, memory, |voxels| {
            let Voxels { grid, bounds, dag, mut pending, voxelize, reduce } = voxels;
            stages.voxelize.push(ms(voxelize));
            stages.dag.push(ms(reduce));
            let mut timed = |times: &mut Vec<f64>, mode| -> std::result::Result<MaterialsBuf, SceneError> {
                let (made, time) = stats::timed(|| scene::voxel_materials(&pending, dag.dag(), mode));
                times.push(ms(time));
                let made = made?;
                pending.hold(size_of_val(made.words()) as u64);
                Ok(made)
            };
            let table = timed(&mut stages.table, MaterialMode::TableNormals)?;
            let moxels = timed(&mut stages.moxel_table, MaterialMode::MoxelsNormals)?;
            let tree = timed(&mut stages.tree, MaterialMode::Tree)?;
            let dag = Arc::new(dag);
            let (moxel_dag, time) = stats::timed(|| scene::layout(&pending, &dag, GeometryArg::Moxel, true));
            drop(moxel_dag?);
            stages.moxel_dag.push(ms(time) + ms(reduce));
            let (ssvdag, time) = stats::timed(|| scene::layout(&pending, &dag, GeometryArg::Ssvdag, true));
            let ssvdag = ssvdag?;
            stages.ssvdag.push(ms(time));
            if !last {
                return Ok(None);
            }
            pending.hold(4 * ssvdag.words() as u64);
            let mut materials = vec![tree];
            for (_, mode) in &MATERIALS[1..] {
                let made = match mode {
                    MaterialMode::TableNormals | MaterialMode::MoxelsNormals => continue,
                    mode => scene::voxel_materials(&pending, dag.dag(), *mode)?,
                };
                pending.hold(size_of_val(made.words()) as u64);
                materials.push(made);
            }
            materials.insert(TABLE_NORMALS, table);
            materials.insert(MOXELS_NORMALS, moxels);
            let mut layouts = Vec::new();
            for (_, kind) in &LAYOUTS {
                if *kind != GeometryArg::Ssvdag {
                    let layout = scene::layout(&pending, &dag, *kind, true)?;
                    pending.hold(4 * layout.words() as u64);
                    layouts.push(layout);
                }
            }
            layouts.insert(SSVDAG, ssvdag);
            Ok(Some(Kept { layouts, materials, grid, bounds }))
        })?;
    }

    let n = subject.resolution;
    let published = |row: fn(&Published) -> &[u32; 3]| subject.published(row);
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<_>>();
    let mut put = |number, configuration, runs: &[f64], published| {
        report.put(number, subject.name, configuration, Cell::spread(n, Spread::of(runs.iter().copied()), published));
    };
    put(
        "5.3",
        "voxelization + hash table",
        &sum(&stages.voxelize, &stages.table),
        published(|p| &p.voxelization_and_hash_table),
    );
    put("5.3", "DAG", &stages.dag, published(|p| &p.dag_construction));
    put("5.4", "voxelization", &stages.voxelize, published(|p| &p.moxel_voxelization));
    put("5.4", "moxel DAG", &stages.moxel_dag, published(|p| &p.moxel_dag_construction));
    put("5.4", "moxel table", &stages.moxel_table, published(|p| &p.moxel_table_construction));
    put("A.4", "voxelization + material tree", &sum(&stages.voxelize, &stages.tree), None);
    put("A.4", "SSVDAG from the DAG", &stages.ssvdag, None);
    kept.ok_or_else(|| Error::usage("--runs 0: expected 1 or more"))
}

impl Subject<'_> {
    /// The thesis's figure at this resolution.
    pub fn published(&self, row: fn(&Published) -> &[u32; 3]) -> Option<u32> {
        let at = super::published::RESOLUTIONS.iter().position(|n| *n == self.resolution)?;
        Some(row(self.published?)[at])
    }
}

/// Tables of memory.
fn sizes(subject: &Subject<'_>, report: &mut Report, kept: &Kept) -> Result<()> {
    let n = subject.resolution;
    let dag: Dag<'_> = kept.layouts[DAG].geometry().as_dag().ok_or_else(|| defect("no DAG"))?;
    let voxels = scene::count(dag.into())?.voxels;
    let mut put = |number, configuration, value: f64, published| {
        report.put(number, subject.name, configuration, Cell::exact(n, value, published));
    };
    let kb = |bytes: u64| bytes as f64 / 1024.0;
    let mb = |bytes: u64| bytes as f64 / (1024.0 * 1024.0);
    let bits = |bytes: u64| 8.0 * bytes as f64 / voxels.max(1) as f64;

    put("A.6", "filled voxels", voxels as f64, None);
    // By the thesis's accounting.
    put("5.2a", "sparse voxel DAG", kb(thesis::svdag_bytes(&dag)), subject.published(|p| &p.dag));
    put(
        "5.2a",
        "moxel DAG, as Williams quotes it",
        kb(thesis::moxel_dag_bytes_quoted(&dag)),
        subject.published(|p| &p.moxel_dag),
    );
    put("5.2a", "moxel DAG, done right", kb(thesis::moxel_dag_bytes(&dag)), None);
    put("5.2b", "hash table", mb(thesis::hash_table_bytes(voxels, true)), subject.published(|p| &p.hash_table));
    put("5.2b", "moxel table", mb(thesis::moxel_table_bytes(voxels, true)), subject.published(|p| &p.moxel_table));
    let without = thesis::hash_table_bytes(voxels, false);
    put("5.6", "hash table without normals", mb(without), subject.published(|p| &p.hash_table_without_normals));

    // As this program holds them.
    put("A.2", "octree without pointers, 1 byte a node", kb(thesis::svo_bytes_without_pointers(&dag)), None);
    put("A.3", "octree without pointers, 1 byte a node", bits(thesis::svo_bytes_without_pointers(&dag)), None);
    for ((name, _), layout) in LAYOUTS.iter().zip(&kept.layouts) {
        let bytes = 4 * layout.geometry().words().len() as u64;
        put("A.2", name, kb(bytes), None);
        put("A.3", name, bits(bytes), None);
    }
    let rank = kept.layouts[DAG].rank();
    let counts = rank.and_then(|rank| rank.words()).map_or(0, |words| 4 * words.len() as u64);
    put("A.2", "prefix counts beside the DAG", kb(counts), None);
    put("A.3", "prefix counts beside the DAG", bits(counts), None);
    for ((name, _), materials) in MATERIALS.iter().zip(&kept.materials) {
        let bytes = size_of_val(materials.words()) as u64;
        put("A.2", name, kb(bytes), None);
        put("A.3", name, bits(bytes), None);
    }
    Ok(())
}

/// Times of look-ups and ranks at what a picture shows.
fn look_ups(
    subject: &Subject<'_>,
    report: &mut Report,
    kept: &Kept,
    shown: &Shown<'_>,
    args: &PictureArgs,
    memory: &Memory,
) -> Result<()> {
    let voxels = hits(shown, args, memory)?;
    if voxels.is_empty() {
        return Ok(());
    }
    let n = subject.resolution;
    let runs = subject.runs.max(3);
    let ns = |times: &Times| Cell::spread(n, times.ns(voxels.len()), None);
    let mut views = Vec::new();
    for materials in &kept.materials {
        views.push(materials.as_materials(kept.layouts[DAG].rank()).map_err(defect)?);
    }
    let arms: [Arm<'_>; MATERIALS.len()] = core::array::from_fn(|i| {
        let materials = views[i];
        Arm::each(&voxels, move |voxel| u64::from(materials.id(*voxel)))
    });
    for ((name, _), times) in MATERIALS.iter().zip(&measure(runs, arms)?) {
        report.put("A.5", subject.name, name, ns(times));
    }
    let ranks = [
        ("rank by prefix counts", DAG),
        ("rank by totals of the SSVDAG", SSVDAG),
        ("rank by offsets in pointers", OFFSETS),
        ("rank by empty counts (moxel DAG)", MOXEL_DAG),
    ];
    let arms = ranks.map(|(_, layout)| {
        let rank = kept.layouts[layout].rank();
        Arm::each(&voxels, move |voxel| rank.and_then(|rank| rank.rank(*voxel)).unwrap_or(0))
    });
    for ((name, _), times) in ranks.iter().zip(&measure(runs, arms)?) {
        report.put("A.5", subject.name, name, ns(times));
    }
    Ok(())
}

/// The voxels that the middles of the pixels show, row by row.
fn hits(shown: &Shown<'_>, args: &PictureArgs, memory: &Memory) -> Result<Vec<Morton>> {
    let queries = picture::primary(shown, &args.camera, args.size)?;
    let mut hits = vec![None; queries.len()];
    let trees = Trees::new(shown.geometry, memory.left());
    with_tracer!(shown.geometry, &trees, tracer => tracer.trace_many(Arithmetic::Exact, &queries, &mut hits));
    Ok(hits.into_iter().flatten().map(|hit| hit.voxel).collect())
}

/// Equal data must give equal pictures, bit for bit, through every layout and representation.
fn agree<'a>(
    subject: &Subject<'_>,
    report: &mut Report,
    shown: &dyn Fn(usize, usize) -> Result<Shown<'a>>,
    args: &PictureArgs,
    memory: &Memory,
) -> Result<()> {
    let draw = |layout, materials, normals| -> Result<Vec<u32>> {
        let args = PictureArgs { normals, samples: Some(Samples::One), ..args.clone() };
        Ok(picture::draw(&shown(layout, materials)?, &args, Extras::default(), memory)?.pixels)
    };
    let (mut combinations, mut calculated, mut stored) = (0, BTreeSet::new(), BTreeSet::new());
    for layout in 0..LAYOUTS.len() {
        for materials in 0..MATERIALS.len() {
            calculated.insert(draw(layout, materials, NormalsArg::Plane2)?);
            combinations += 1;
        }
        for materials in [TABLE_NORMALS, MOXELS_NORMALS] {
            stored.insert(draw(layout, materials, NormalsArg::Stored)?);
            combinations += 1;
        }
    }
    let agreement = Agreement {
        scene: subject.name.to_owned(),
        resolution: subject.resolution,
        combinations,
        equal: calculated.len() == 1 && stored.len() == 1,
    };
    report.agreements.push(agreement);
    Ok(())
}
