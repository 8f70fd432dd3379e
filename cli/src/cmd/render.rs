//! `voxdag render`: a mesh or a scene becomes a picture.

use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::input::{self, Content};
use crate::options::{BuildArgs, MachineArgs, PictureArgs, ReportArgs};
use crate::output::Output;
use crate::picture::{self, Picture, Rays, Shown};
use crate::report::{self, Lines, grouped, shell_word, time};
use crate::scene;
use crate::stats::{self, ms};

/// Draw a mesh or a voxel scene
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  voxdag render bunny.obj -o bunny.png                          build at 512 voxels and draw
  voxdag render bunny.vxd -o bunny.png --size 1920x1080         draw what was built before
  voxdag render hall.vxd -o hall.png --eye 1,1.7,8 --target 1,1.5,0 --light 2,3,4,1,0.9,0.8")]
pub struct Args {
    /// Wavefront OBJ file, or a scene from `voxdag build`
    #[arg(value_name = "MESH_OR_VXD")]
    input: PathBuf,

    /// The picture to write
    #[arg(short, long, value_name = "IMG.png")]
    output: PathBuf,

    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    build: BuildArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// What `render --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    width: u32,
    height: u32,
    /// Per pixel.
    samples: u32,
    /// Of the voxels.
    resolution: u32,
    rays: Rays,
    /// Primary rays that hit a voxel.
    hits: u64,
    ms: Ms,
    /// What the scene called for.
    effects: &'a [&'static str],
    peak_rss_bytes: Option<u64>,
    threads: usize,
}

#[derive(Serialize)]
struct Ms {
    /// Following rays and shading.
    trace: f64,
    /// From the start of the program to the finished file.
    total: f64,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    args.build.check()?;
    let output = Output::create(&args.output, "png")?;
    output.must_not_replace(std::slice::from_ref(&args.input))?;
    let pool = args.machine.pool()?;
    let mut memory = args.machine.memory();

    let (picture, grid, is_scene) = match input::read(&args.input, &mut memory)? {
        Content::Scene(words) => {
            if let Some(flag) = args.build.given() {
                return Err(Error::usage(format_args!("{flag}: {} is built already", args.input.display()))
                    .hint("leave the flag away, or name the mesh instead of the scene"));
            }
            let scene = scene::open(&args.input, &words)?;
            (pool.install(|| picture::draw(&Shown::of(&scene), &args.picture, &memory))?, scene.grid, true)
        }
        Content::Mesh(text) => {
            let source = scene::import_file(&args.input, text, &mut memory)?;
            output.must_not_replace(&source.files)?;
            let built = pool.install(|| scene::build(&source, &args.build, &mut memory))?;
            memory.release(source.bytes);
            drop(source);
            (pool.install(|| picture::draw(&built.shown(), &args.picture, &memory))?, built.grid, false)
        }
    };
    output.finish(|file| picture.write_png(file))?;

    let Picture { width, height, rays, hits, ref effects, trace, .. } = picture;
    let report = Report {
        width,
        height,
        samples: picture.samples,
        resolution: grid.resolution,
        rays,
        hits,
        ms: Ms { trace: ms(trace), total: ms(start.elapsed()) },
        effects,
        peak_rss_bytes: stats::peak_rss_bytes(),
        threads: pool.current_num_threads(),
    };
    report::result(args.report.json, &report, &lines(&report))?;
    let input = shell_word(&args.input);
    if !is_scene {
        let scene = shell_word(&args.output.with_extension("vxd"));
        report::next(format_args!("build {input} -o {scene}{}", args.build.typed()));
    } else if args.picture.samples.is_none() {
        report::next(format_args!("{} --samples 16", report::typed()));
    } else {
        report::next(format_args!("info {input}"));
    }
    Ok(())
}

/// The report for people.
fn lines(report: &Report<'_>) -> Lines {
    let mut lines = Lines::default();
    let share = 100.0 * report.hits as f64 / report.rays.primary as f64;
    lines
        .row("picture", format!("{}x{}, {} samples per pixel", report.width, report.height, report.samples))
        .row("resolution", format!("{} voxels along the longest axis", grouped(report.resolution.into())))
        .row("rays", report.rays.text())
        .row("hits", format!("{} ({share:.1} %)", grouped(report.hits)))
        .row("effects", if report.effects.is_empty() { "none".to_owned() } else { report.effects.join(", ") })
        .row("time", format!("{}: trace {}", time(report.ms.total), time(report.ms.trace)))
        .row("memory", report::peak(report.peak_rss_bytes))
        .row("threads", report.threads.to_string());
    lines
}
