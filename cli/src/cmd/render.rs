//! `voxdag render`: a mesh or a scene becomes a picture.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use voxdag::geometry::Geometry;

use crate::budget::{self, Calibration, Goal, Range};
use crate::error::{Error, Result};
use crate::formats;
use crate::input::{self, Content};
use crate::memory::Memory;
use crate::options::{BuildArgs, MachineArgs, PictureArgs, ReportArgs, SupersampleArg, duration, error};
use crate::output::Output;
use crate::picture::{self, Picture, Rays, Shown};
use crate::quality::Quality;
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

    /// The most accurate picture that takes about this long to draw here, such as 100ms or 1.5s
    ///
    /// Chooses samples and level of detail after a calibration of a second, or of twice the time if that is more.
    #[arg(long, value_name = "TIME", value_parser = duration, conflicts_with_all = CHOSEN)]
    budget: Option<Duration>,

    /// The cheapest picture here with at most this error, 0.001 to 1
    ///
    /// That is the RMSE in linear light against 64 samples of the same voxels, on a part of the rows.
    #[arg(long, value_name = "E", value_parser = error, conflicts_with_all = CHOSEN, conflicts_with = "budget")]
    target_error: Option<f64>,

    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    build: BuildArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// The flags that `--budget` and `--target-error` choose.
const CHOSEN: [&str; 3] = ["samples", "supersample", "lod"];

/// What `render --json` prints.
#[derive(Serialize)]
struct Report<'a> {
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
    effects: &'a [&'static str],
    /// The numbers behind the colours of `--show depth`, `level` and `iterations`.
    shown: Option<Spread>,
    #[serde(skip)]
    show: Show,
    /// What `--budget` or `--target-error` chose.
    chosen: Option<Chosen>,
    peak_rss_bytes: Option<u64>,
    threads: usize,
}

/// A choice, and what it was expected to give.
#[derive(Serialize)]
struct Chosen {
    /// As they can be typed.
    flags: String,
    #[serde(skip)]
    quality: Quality,
    /// Of these one was asked for.
    budget_ms: Option<f64>,
    target_error: Option<f64>,
    /// Of drawing the rows: what was expected, and what came of it.
    expected_ms: f64,
    got_ms: f64,
    /// On the rows that were looked at.
    expected_error: f64,
    /// Calibrating, without what it derived.
    calibration_ms: f64,
    /// Why it is not closer to what was asked for.
    note: Option<String>,
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
    let Drawn { picture, shown, depths, chosen } = drawn;
    let quality = chosen.as_ref().map(|chosen| chosen.quality);
    let drawn = quality.map_or(args.picture.clone(), |quality| quality.apply(&args.picture));
    output.finish(|file| picture.write_png(file))?;
    if let (Some(output), Some(depths)) = (depth_output, depths) {
        output.finish(|file| formats::pfm(picture.width, picture.height, &depths, file))?;
    }

    let Picture { width, height, rays, hits, ref effects, derive, trace, .. } = picture;
    let report = Report {
        width,
        height,
        samples: picture.samples,
        supersample: drawn.supersample.unwrap_or(SupersampleArg::All).to_string(),
        supersampled: picture.supersampled,
        resolution: grid.resolution,
        lod: drawn.lod,
        rays,
        hits,
        ms: Ms { derive: ms(derive), trace: ms(trace), total: ms(start.elapsed()) },
        effects,
        shown,
        show: args.show,
        chosen,
        peak_rss_bytes: stats::peak_rss_bytes(),
        threads: pool.current_num_threads(),
    };
    report::result(args.report.json, &report, &lines(&report))?;
    let input = shell_word(&args.input);
    if !is_scene {
        let scene = shell_word(&args.output.with_extension("vxd"));
        report::next(format_args!("build {input} -o {scene}{}", args.build.typed()));
    } else if args.show == Show::Shaded && drawn.samples.is_none() && drawn.supersample.is_none() {
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
    chosen: Option<Chosen>,
}

/// Draws what the flags ask for.
fn draw(scene: &Shown<'_>, args: &Args, memory: &Memory) -> Result<Drawn> {
    let goal = match (args.budget, args.target_error) {
        (Some(budget), _) => Some(Goal::Seconds(budget.as_secs_f64())),
        (None, error) => error.map(Goal::Error),
    };
    if let Some(goal) = goal {
        return choose(scene, args, goal, memory);
    }
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
    Ok(Drawn { picture, shown, depths, chosen: None })
}

/// Chooses how to draw, and draws.
fn choose(scene: &Shown<'_>, args: &Args, goal: Goal, memory: &Memory) -> Result<Drawn> {
    if args.show != Show::Shaded {
        return Err(Error::usage(
            "--budget and --target-error choose samples: what --show shows has one ray per pixel",
        )
        .hint("leave --show away"));
    }
    let usual = Quality { normals: args.picture.normals, arithmetic: args.picture.arithmetic, ..Quality::default() };
    let mut calibration = Calibration::new(scene, &args.picture, memory);
    let range = Range { usual, size: args.picture.size, depth: scene.geometry.depth() };
    let choice = budget::choose(&mut calibration, goal, range)?;
    let (prepared, calibrated) = calibration.finish(choice.quality)?;
    let drawn = choice.quality.apply(&args.picture);
    let picture = prepared.draw(scene, &drawn, false, memory)?;
    let depths = args.depth_out.as_ref().map(|_| show::depths(scene, &drawn, memory)).transpose()?;
    let chosen = Chosen {
        flags: choice.quality.flags(),
        quality: choice.quality,
        budget_ms: args.budget.map(ms),
        target_error: args.target_error,
        expected_ms: 1000.0 * choice.seconds,
        got_ms: ms(picture.trace),
        expected_error: choice.error,
        calibration_ms: ms(calibrated),
        note: choice.note,
    };
    Ok(Drawn { picture, shown: None, depths, chosen: Some(chosen) })
}

/// The report for people.
fn lines(report: &Report<'_>) -> Lines {
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
    if let Some(chosen) = &report.chosen {
        let Chosen { expected_ms, got_ms, expected_error, calibration_ms, .. } = *chosen;
        let asked = match (chosen.budget_ms, chosen.target_error) {
            (Some(budget), _) => format!("for {}", time(budget)),
            (None, error) => format!("for an error of {}", error.unwrap_or_default()),
        };
        let note = chosen.note.as_ref().map_or(String::new(), |note| format!("; {note}"));
        lines
            .row("chosen", format!("{} {asked}{note}", chosen.flags))
            .row("expected", format!("{}, error {expected_error:.4}; got {}", time(expected_ms), time(got_ms)))
            .row("calibration", time(calibration_ms));
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
