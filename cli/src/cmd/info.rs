//! `voxdag info`: what is in a `.vxd` file.

use std::path::PathBuf;

use serde::Serialize;
use voxdag::Geometry;
use voxdag::colors::Colors;
use voxdag::dag::{BRICK_LEVEL, LevelStats};
use voxdag::grid::UpAxis;
use voxdag::material::MaterialId;

use crate::error::Result;
use crate::input;
use crate::options::ReportArgs;
use crate::report::{self, Lines, grouped, number, shell_word, size, triple};
use crate::scene::{self, Bytes};

/// Show what a voxel scene holds
#[derive(clap::Args)]
pub struct Args {
    /// A scene from `voxdag build`
    #[arg(value_name = "F.vxd")]
    scene: PathBuf,

    #[command(flatten)]
    report: ReportArgs,
}

/// What `info --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    depth: u8,
    origin: [f64; 3],
    voxel_size: f64,
    /// The mesh's box.
    #[serde(rename = "box")]
    bounds: Box,
    up_axis: &'static str,
    /// As `--geometry` and `--materials` name them.
    geometry: &'static str,
    voxel_materials: &'static str,
    /// How the colours of textures are kept, if there are any.
    voxel_colors: Option<&'static str>,
    voxels: u64,
    nodes: u64,
    bricks: u64,
    /// From the root down to the bricks.
    levels: Vec<Level>,
    bytes: Bytes,
    bits_per_voxel: BitsPerVoxel,
    materials: Vec<Named>,
}

#[derive(Serialize)]
struct Box {
    min: [f64; 3],
    max: [f64; 3],
}

#[derive(Serialize)]
struct Level {
    /// 2 are the bricks.
    level: u8,
    /// Voxels along an edge.
    side: u64,
    /// Nodes that are stored.
    unique: u64,
    /// Nodes of the octree without sharing.
    octree: u64,
}

#[derive(Serialize)]
struct BitsPerVoxel {
    /// Nodes and bricks.
    dag: f64,
    /// The colours of textures.
    colors: f64,
    /// The whole file.
    file: f64,
}

#[derive(Serialize)]
struct Named {
    id: usize,
    name: String,
    /// Whether its voxels have colours of their own.
    textured: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let words = input::read_scene(&args.scene)?;
    let scene = scene::open(&args.scene, &words)?;
    let stats = scene::count(scene.geometry)?;
    let grid = scene.grid;
    let bytes = Bytes::of(scene.geometry, &stats, scene.looks(), 4 * words.len() as u64);
    let per_voxel = |bytes: u64| 8.0 * bytes as f64 / stats.voxels.max(1) as f64;
    let levels = (BRICK_LEVEL..=scene.geometry.depth().max(BRICK_LEVEL)).rev().map(|level| {
        let LevelStats { unique, octree } = stats.levels[usize::from(level)];
        Level { level, side: 1 << level, unique, octree }
    });
    let report = Report {
        resolution: grid.resolution,
        depth: grid.depth(),
        origin: grid.origin,
        voxel_size: grid.voxel_size,
        bounds: Box { min: scene.bounds.min, max: scene.bounds.max },
        up_axis: match scene.up {
            UpAxis::Y => "y",
            UpAxis::Z => "z",
        },
        geometry: report::geometry_kind(scene.geometry),
        voxel_materials: report::materials_kind(scene.materials),
        voxel_colors: scene.colors.map(|colored| match colored.colors() {
            Colors::Blocks(_) => "blocks",
            Colors::Raw(_) => "raw",
        }),
        voxels: stats.voxels,
        nodes: stats.nodes(),
        bricks: stats.levels[usize::from(BRICK_LEVEL)].unique,
        levels: levels.collect(),
        bits_per_voxel: BitsPerVoxel {
            dag: per_voxel(bytes.nodes + bytes.bricks),
            colors: per_voxel(bytes.colors),
            file: per_voxel(bytes.file),
        },
        bytes,
        materials: (0..scene.material_count())
            .map(|id| Named {
                id,
                name: scene.name(id as MaterialId).to_string(),
                textured: scene.material(id as MaterialId).textured,
            })
            .collect(),
    };
    report::result(args.report.json, &report, &lines(&report))?;
    let picture = args.scene.with_extension("png");
    report::next(format_args!("render {} -o {}", shell_word(&args.scene), shell_word(&picture)));
    Ok(())
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    lines
        .row("resolution", report.resolution.to_string())
        .row("depth", report.depth.to_string())
        .row("origin", triple(report.origin))
        .row("voxel size", number(report.voxel_size))
        .row("box", format!("{} to {}", triple(report.bounds.min), triple(report.bounds.max)))
        .row("up axis", report.up_axis)
        .row("geometry", report.geometry)
        .row("materials", report.voxel_materials)
        .row("colors", report.voxel_colors.unwrap_or("none"))
        .row("voxels", grouped(report.voxels))
        .row("", "");

    let header = ["side".to_owned(), "unique".to_owned(), "full octree".to_owned()];
    let cells = report.levels.iter().map(|l| [l.side, l.unique, l.octree].map(grouped));
    let table: Vec<_> = std::iter::once(header).chain(cells).collect();
    let widths: [usize; 3] = std::array::from_fn(|i| table.iter().map(|row| row[i].len()).max().unwrap_or(0));
    let names = report.levels.iter().map(|l| match l.level {
        BRICK_LEVEL => "bricks".to_owned(),
        level => format!("level {level}"),
    });
    for (name, row) in std::iter::once("nodes".to_owned()).chain(names).zip(&table) {
        let row: Vec<_> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
        lines.row(name, row.join("  "));
    }

    let Bytes { nodes, bricks, materials, colors, other, file } = report.bytes;
    let mut parts = vec![("nodes", nodes), ("bricks", bricks), ("materials", materials)];
    if report.voxel_colors.is_some() {
        parts.push(("colors", colors));
    }
    parts.extend([("other", other), ("file", file)]);
    let width = grouped(file).len();
    lines.row("", "");
    for (part, bytes) in parts {
        lines.row(format!("{part} bytes"), format!("{:>width$}  {}", grouped(bytes), size(bytes)));
    }
    let BitsPerVoxel { dag, colors, file } = report.bits_per_voxel;
    let colors = if report.voxel_colors.is_some() { format!("{colors:.3} (colors), ") } else { String::new() };
    lines.row("bits per voxel", format!("{dag:.3} (nodes and bricks), {colors}{file:.3} (file)")).row("", "");
    for (i, material) in report.materials.iter().enumerate() {
        let texture = if material.textured { "  (textured)" } else { "" };
        lines.row(if i == 0 { "materials" } else { "" }, format!("{:>3}  {}{texture}", material.id, material.name));
    }
    lines
}
