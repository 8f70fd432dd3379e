//! `voxdag verify`: the full check of a `.vxd` file, and what it consisted of.

use std::path::{Path, PathBuf};

use serde::Serialize;
use voxdag::colors::Colors;
use voxdag::dag::{BRICK_LEVEL, Stats};
use voxdag::materials::AnyMaterials;
use voxdag::ranked::Values;
use voxdag::{Geometry, Morton, Table};

use crate::error::{Error, Result};
use crate::input;
use crate::options::ReportArgs;
use crate::progress::Progress;
use crate::report::{self, Lines, grouped, shell_word, size};
use crate::scene;

/// Check every word of a voxel scene
#[derive(clap::Args)]
pub struct Args {
    /// A scene from `voxdag build`
    #[arg(value_name = "F.vxd")]
    scene: PathBuf,

    #[command(flatten)]
    report: ReportArgs,
}

/// What `verify --json` prints for a scene without fault.
#[derive(Serialize)]
struct Report {
    ok: bool,
    checks: Vec<Check>,
}

/// Something that was looked at and is right.
#[derive(Serialize)]
struct Check {
    name: &'static str,
    found: String,
}

/// What it prints for any other, besides the message on stderr and exit code 3.
#[derive(Serialize)]
struct Fault<'a> {
    ok: bool,
    error: &'a str,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let result = check(args);
    if let (Err(error), true) = (&result, args.report.json) {
        report::result(true, &Fault { ok: false, error: error.message() }, &Lines::default())?;
    }
    result
}

fn check(args: &Args) -> Result<()> {
    let words = input::read_scene(&args.scene)?;
    let scene = scene::open(&args.scene, &words)?;
    let stats = scene::count(scene.geometry)?;
    let (geometry, unique) = (scene.geometry, stats.nodes() + stats.levels[usize::from(BRICK_LEVEL)].unique);
    let mut checks = vec![
        Check { name: "header", found: format!("{}, every checksum right", size(4 * words.len() as u64)) },
        Check {
            name: report::geometry_kind(geometry),
            found: format!("{} nodes and bricks, every child one level below its parent", grouped(unique)),
        },
        Check {
            name: "materials",
            found: format!("{}, every number in range, every id in use exists", scene.material_count()),
        },
    ];
    if let AnyMaterials::Table(table) = scene.materials {
        each_voxel_has_its_entry(&args.scene, geometry, table, &stats)?;
        let found = format!("{} entries: one for every voxel and no more", grouped(table.len()));
        checks.push(Check { name: "table", found });
    }
    if let AnyMaterials::Ranked(ids) = scene.materials {
        let found = format!(
            "{} ids of {} bits, every count that finds them right",
            grouped(ids.values().count()),
            ids.values().bits()
        );
        checks.push(Check { name: "ranked", found });
    }
    if let AnyMaterials::Tree(tree) = scene.materials {
        let found = format!("{}, every entry names what is there", size(4 * tree.words().len() as u64));
        checks.push(Check { name: "tree", found });
    }

    if let Some(colored) = scene.colors {
        let colors = colored.colors();
        let kind = match colors {
            Colors::Blocks(_) => "in blocks",
            Colors::Raw(_) => "as they are",
        };
        let found =
            format!("{} {kind}: one for every voxel, every count that finds them right", grouped(colors.count()));
        checks.push(Check { name: "colors", found });
    }

    let mut lines = Lines::default();
    for check in &checks {
        lines.row(check.name, check.found.as_str());
    }
    lines.row("", "").row(args.scene.display().to_string(), "is sound");
    report::result(args.report.json, &Report { ok: true, checks }, &lines)?;
    report::next(format_args!("info {}", shell_word(&args.scene)));
    Ok(())
}

/// Loading makes sure that the table is one; only here is it held against the voxels.
fn each_voxel_has_its_entry(path: &Path, geometry: impl Geometry, table: Table<'_>, stats: &Stats) -> Result<()> {
    // Counted first: that bounds the walk by the size of the file, whatever the DAG claims.
    if table.len() != stats.voxels {
        return Err(damaged(path, format_args!("{} voxels, but {} entries", stats.voxels, table.len())));
    }
    let progress = Progress::stage("checking", stats.levels[usize::from(BRICK_LEVEL)].octree);
    for (first, mut mask) in geometry.bricks() {
        while mask != 0 {
            let voxel = Morton(first.0 | u64::from(mask.trailing_zeros()));
            if table.get(voxel).is_none() {
                let [x, y, z] = voxel.decode();
                return Err(damaged(path, format_args!("voxel ({x}, {y}, {z}) has no entry")));
            }
            mask &= mask - 1;
        }
        progress.step();
    }
    Ok(())
}

fn damaged(path: &Path, what: impl std::fmt::Display) -> Error {
    Error::input(path, format_args!("the material table does not fit the voxels: {what}")).hint("build it again")
}
