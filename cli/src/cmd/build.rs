//! `voxdag build`: a mesh becomes a `.vxd` file.

use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use crate::error::Result;
use crate::input;
use crate::options::{BuildArgs, MachineArgs, ReportArgs};
use crate::output::Output;
use crate::report::{self, Lines, grouped, number, shell_word, time};
use crate::scene::{self, Bytes, Cost};
use crate::source;
use crate::stats::{self, ms};

/// Turn a mesh into a voxel scene
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  voxdag build bunny.obj -o bunny.vxd                      512 voxels along the longest axis
  voxdag build bunny.obj -o bunny.vxd -r 4096              finer
  voxdag build house.obj -o house.vxd --voxel-size 0.05    5 cm, if the mesh is in metres")]
pub struct Args {
    /// Wavefront OBJ file; its .mtl files are looked for beside it
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    /// The scene to write
    #[arg(short, long, value_name = "F.vxd")]
    output: PathBuf,

    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    build: BuildArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// What `build --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    depth: u8,
    origin: [f64; 3],
    voxel_size: f64,
    triangles: usize,
    voxels: u64,
    /// Nodes above the bricks without sharing.
    octree_nodes: u64,
    /// Bricks without sharing.
    octree_bricks: u64,
    /// Unique nodes above the bricks.
    nodes: u64,
    /// Unique bricks of 4^3 voxels.
    bricks: u64,
    bytes: Bytes,
    ms: Ms,
    peak_rss_bytes: Option<u64>,
    threads: usize,
}

#[derive(Serialize)]
struct Ms {
    parse: f64,
    voxelize: f64,
    reduce: f64,
    materials: f64,
    write: f64,
    total: f64,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    args.build.check()?;
    args.build.must_be_for_files()?;
    let output = Output::create(&args.output, "vxd")?;
    output.must_not_replace(std::slice::from_ref(&args.mesh))?;
    let pool = args.machine.pool()?;
    let mut memory = args.machine.memory();

    let source = source::import_file(
        &args.mesh,
        input::read_mesh(&args.mesh, &mut memory)?,
        args.build.reads_textures(),
        &mut memory,
    )?;
    output.must_not_replace(&source.files)?;
    let built = pool.install(|| scene::build(&source, &args.build, &mut memory))?;
    let (written, write) = stats::timed(|| output.finish(|file| built.write(file)));
    written?;

    let Cost { parse, voxelize, reduce, materials } = built.cost;
    let grid = built.grid;
    let report = Report {
        resolution: grid.resolution,
        depth: grid.depth(),
        origin: grid.origin,
        voxel_size: grid.voxel_size,
        triangles: built.triangles,
        voxels: built.stats.voxels,
        octree_nodes: built.stats.octree_nodes(),
        octree_bricks: built.stats.levels[2].octree,
        nodes: built.stats.nodes(),
        bricks: built.stats.levels[2].unique,
        bytes: built.bytes(),
        ms: Ms {
            parse: ms(parse),
            voxelize: ms(voxelize),
            reduce: ms(reduce),
            materials: ms(materials),
            write: ms(write),
            total: ms(start.elapsed()),
        },
        peak_rss_bytes: stats::peak_rss_bytes(),
        threads: pool.current_num_threads(),
    };
    report::result(args.report.json, &report, &lines(&report))?;
    let picture = args.output.with_extension("png");
    report::next(format_args!("render {} -o {}", shell_word(&args.output), shell_word(&picture)));
    Ok(())
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    let Ms { parse, voxelize, reduce, materials, write, total } = report.ms;
    lines
        .row("triangles", grouped(report.triangles as u64))
        .row(
            "resolution",
            format!("{} (depth {}), voxel size {}", report.resolution, report.depth, number(report.voxel_size)),
        )
        .row("voxels", grouped(report.voxels))
        .row("nodes", report::sharing(report.octree_nodes + report.octree_bricks, report.nodes + report.bricks))
        .row("bytes", report.bytes.text())
        .row(
            "time",
            format!(
                "{}: parse {}, voxelize {}, reduce {}, materials {}, write {}",
                time(total),
                time(parse),
                time(voxelize),
                time(reduce),
                time(materials),
                time(write)
            ),
        )
        .row("memory", report::peak(report.peak_rss_bytes))
        .row("threads", report.threads.to_string());
    lines
}
