//! `voxdag render`: a mesh or a scene becomes a picture.

use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::formats;
use crate::input::{self, Content};
use crate::memory::Memory;
use crate::options::{BuildArgs, MachineArgs, PictureArgs, ReportArgs, SupersampleArg};
use crate::output::Output;
use crate::picture::{self, Picture, Rays, Shown};
use crate::report::{self, Lines, grouped, shell_word, time};
use crate::scene;
use crate::show::{self, Show, Spread};
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

    /// What the picture shows; all but shaded and samples take one ray per pixel
    #[arg(long, value_enum, value_name = "WHAT", default_value_t)]
    show: Show,

    /// Also write the distance along the ray through each pixel's middle: PFM, world units, inf for nothing
    #[arg(long, value_name = "F.pfm")]
    depth_out: Option<PathBuf>,

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
struct Report {
    width: u32,
    height: u32,
    /// Per pixel.
    samples: u32,
    /// Which pixels take all of them.
    supersample: String,
    /// Their share, where they take more than one.
    supersampled: f64,
    /// Of the scene's voxels.
    resolution: u32,
    /// How often it was halved to draw.
    lod: u8,
    rays: Rays,
    /// Primary rays that hit a voxel.
    hits: u64,
    ms: Ms,
    /// What the scene called for.
    effects: Vec<&'static str>,
    /// The numbers behind the colours of `--show depth`, `level` and `iterations`.
    shown: Option<Spread>,
    #[serde(skip)]
    show: Show,
    peak_rss_bytes: Option<u64>,
    threads: usize,
}

#[derive(Serialize)]
struct Ms {
    /// Making what rays go through: the level of detail, trees.
    derive: f64,
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
    let depth_output = args.depth_out.as_deref().map(|path| Output::create(path, "pfm")).transpose()?;
    let outputs = || std::iter::once(&output).chain(&depth_output);
    outputs().try_for_each(|output| output.must_not_replace(std::slice::from_ref(&args.input)))?;
    let pool = args.machine.pool()?;
    let mut memory = args.machine.memory();

    let (drawn, grid, is_scene) = match input::read(&args.input, &mut memory)? {
        Content::Scene(words) => {
            args.build.must_be_absent(&args.input)?;
            let scene = scene::open(&args.input, &words)?;
            (pool.install(|| draw(&Shown::of(&scene), args, &memory))?, scene.grid, true)
        }
        Content::Mesh(text) => {
            let source = scene::import_file(&args.input, text, &mut memory)?;
            outputs().try_for_each(|output| output.must_not_replace(&source.files))?;
            let built = pool.install(|| scene::build(&source, &args.build, &mut memory))?;
            memory.release(source.bytes);
            drop(source);
            (pool.install(|| draw(&built.shown(), args, &memory))?, built.grid, false)
        }
    };
    let Drawn { picture, shown, depths } = drawn;
    output.finish(|file| picture.write_png(file))?;
    if let (Some(output), Some(depths)) = (depth_output, depths) {
        output.finish(|file| formats::pfm(picture.width, picture.height, &depths, file))?;
    }

    let Picture { width, height, rays, hits, effects, derive, trace, .. } = picture;
    let report = Report {
        width,
        height,
        samples: picture.samples,
        supersample: args.picture.supersample.unwrap_or(SupersampleArg::All).to_string(),
        supersampled: picture.supersampled,
        resolution: grid.resolution,
        lod: args.picture.lod,
        rays,
        hits,
        ms: Ms { derive: ms(derive), trace: ms(trace), total: ms(start.elapsed()) },
        effects: effects.names().collect(),
        shown,
        show: args.show,
        peak_rss_bytes: stats::peak_rss_bytes(),
        threads: pool.current_num_threads(),
    };
    report::result(args.report.json, &report, &lines(&report))?;
    let input = shell_word(&args.input);
    if !is_scene {
        let scene = shell_word(&args.output.with_extension("vxd"));
        report::next(format_args!("build {input} -o {scene}{}", args.build.typed()));
    } else if args.show == Show::Shaded && args.picture.samples.is_none() && args.picture.supersample.is_none() {
        report::next(format_args!("{} --samples 16", report::typed()));
    } else {
        report::next(format_args!("info {input}"));
    }
    Ok(())
}

/// A picture, and what else was asked for.
struct Drawn {
    picture: Picture,
    shown: Option<Spread>,
    depths: Option<Vec<f32>>,
}

/// Draws what the flags ask for.
fn draw(scene: &Shown<'_>, args: &Args, memory: &Memory) -> Result<Drawn> {
    let (picture, shown) = match args.show {
        Show::Samples if args.picture.supersample.is_none() => {
            return Err(Error::usage("--show samples: without --supersample all pixels are alike")
                .hint("add --supersample near, region:X0,Y0,X1,Y1 or adaptive"));
        }
        Show::Shaded | Show::Samples => {
            (picture::draw(scene, &args.picture, args.show == Show::Samples, memory)?, None)
        }
        show => show::draw(scene, &args.picture, show, memory)?,
    };
    let depths = args.depth_out.as_ref().map(|_| show::depths(scene, &args.picture, memory)).transpose()?;
    Ok(Drawn { picture, shown, depths })
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    let effects = if report.effects.is_empty() { "none".to_owned() } else { report.effects.join(", ") };
    let pixels = match report.supersample.as_str() {
        "all" => "pixel".to_owned(),
        which => format!("pixel in {:.1} % of them ({which})", 100.0 * report.supersampled),
    };
    let mut resolution = format!("{} voxels along the longest axis", grouped(report.resolution.into()));
    if report.lod > 0 {
        resolution += &format!(", drawn as {}", grouped(report.resolution.div_ceil(1 << report.lod).into()));
    }
    let share = 100.0 * report.hits as f64 / report.rays.primary as f64;
    lines
        .row("picture", format!("{}x{}, {} samples per {pixels}", report.width, report.height, report.samples))
        .row("resolution", resolution)
        .row("rays", report.rays.text())
        .row("hits", format!("{} ({share:.1} %)", grouped(report.hits)))
        .row("effects", effects);
    if let Some(Spread { min, mean, max }) = report.shown {
        let (label, colours) = match report.show {
            Show::Iterations => ("iterations", "dark is 0, red, yellow, white the most"),
            Show::Level => ("level", "dark is 0, red, yellow, white the whole cube"),
            _ => ("depth", "white is the nearest, dark grey the farthest, black nothing"),
        };
        let [min, mean, max] = [min, mean, max].map(|x| x as f32);
        lines.row(label, format!("{min} to {max}, mean {mean}: {colours}"));
    }
    lines
        .row(
            "time",
            format!("{}: derive {}, trace {}", time(report.ms.total), time(report.ms.derive), time(report.ms.trace)),
        )
        .row("memory", report::peak(report.peak_rss_bytes))
        .row("threads", report.threads.to_string());
    lines
}
