//! `voxdag render`: a mesh or a scene becomes a picture.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use voxdag::effects::Effects;
use voxdag::geometry::Geometry;

use crate::budget::{self, Calibration, Goal, Range};
use crate::error::{Error, Result};
use crate::formats;
use crate::frames::{Outputs, Shot, check_cameras, check_outputs, shots};
use crate::input::{self, Content};
use crate::memory::Memory;
use crate::options::{
    BuildArgs, MachineArgs, PictureArgs, ReportArgs, SupersampleArg, ViewArgs, duration, error, frames,
};
use crate::picture::{CostMs, Extras, Picture, Prepared, Rays, Shown};
use crate::progress::Progress;
use crate::quality::Quality;
use crate::report::{self, Lines, grouped, shell_word, time};
use crate::scene;
use crate::show::{self, Show, Spread};
use crate::source;
use crate::stats::{self, ms};
use crate::view::View;

/// Draw a mesh or a voxel scene
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  voxdag render bunny.obj -o bunny.png                          build at 512 voxels and draw
  voxdag render bunny.vxd -o bunny.png --size 1920x1080         draw what was built before
  voxdag render hall.vxd -o hall.png --eye 1,1.7,8 --target 1,1.5,0 --light 2,3,4,1,0.9,0.8
  voxdag render hall.vxd -o hall.png --view tour.toml --frames 1-48     hall_0001.png to hall_0048.png")]
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
    view: ViewArgs,

    /// Frames of the view's camera path, such as 1-48: IMG_0001.png to IMG_0048.png; without it, the view's [camera]
    #[arg(long, value_name = "A-B", value_parser = frames, allow_hyphen_values = true,
        help_heading = "Picture")]
    frames: Option<RangeInclusive<u32>>,

    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    build: BuildArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// The flags that `--budget` and `--target-error` choose.
const CHOSEN: [&str; 3] = ["samples", "supersample", "lod"];

/// What `render --json` prints; of frames, the sums.
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
    effects: Vec<&'static str>,
    /// What they took, of all threads.
    cost_ms: CostMs,
    /// The numbers behind the colours of `--show depth`, `level` and `iterations`; of frames, each has its own.
    shown: Option<Spread>,
    /// With `--frames`.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<&'a [Drawn]>,
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
    /// Of these one was asked for.
    budget_ms: Option<f64>,
    target_error: Option<f64>,
    /// Of drawing the rows: what was expected, and what came of it; of frames, the first.
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

/// A picture that is in its file.
#[derive(Serialize)]
struct Drawn {
    frame: Option<u32>,
    file: PathBuf,
    rays: Rays,
    hits: u64,
    supersampled: f64,
    trace_ms: f64,
    shown: Option<Spread>,
    /// Per pixel.
    #[serde(skip)]
    samples: u32,
    #[serde(skip)]
    effects: Effects,
    #[serde(skip)]
    cost: CostMs,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    args.build.check()?;
    let view = View::read(&args.view)?;
    let flags = &args.picture.camera;
    let shots = shots(&view, args.frames.as_ref(), flags, &args.output, args.depth_out.as_deref())?;
    let inputs: Vec<_> = std::iter::once(&args.input).chain(&view.file).cloned().collect();
    check_outputs(&shots, &inputs)?;
    // The first one's place is taken from here on.
    let first = shots[0].create()?;
    let pool = args.machine.pool()?;
    let mut memory = args.machine.memory();

    let (done, grid, is_scene) = match input::read(&args.input, &mut memory)? {
        Content::Scene(words) => {
            args.build.must_be_absent(&args.input)?;
            let scene = scene::open(&args.input, &words)?;
            (pool.install(|| draw(&Shown::of(&scene), args, &view, (&shots, first), &memory))?, scene.grid, true)
        }
        Content::Mesh(text) => {
            let source = source::import_file(&args.input, text, args.build.reads_textures(), &mut memory)?;
            check_outputs(&shots, &source.files)?;
            let built = pool.install(|| scene::build(&source, &args.build, &mut memory))?;
            memory.release(source.bytes);
            drop(source);
            (pool.install(|| draw(&built.shown(), args, &view, (&shots, first), &memory))?, built.grid, false)
        }
    };

    let Done { lit, derive, chosen, drawn } = done;
    let first = &drawn[0];
    let sum = |of: fn(&Drawn) -> u64| drawn.iter().map(of).sum::<u64>();
    let mean = |of: fn(&Drawn) -> f64| drawn.iter().map(of).sum::<f64>() / drawn.len() as f64;
    let report = Report {
        width: lit.size[0],
        height: lit.size[1],
        samples: first.samples,
        supersample: lit.supersample.unwrap_or(SupersampleArg::All).to_string(),
        supersampled: mean(|drawn| drawn.supersampled),
        resolution: grid.resolution,
        lod: lit.lod,
        rays: Rays {
            primary: sum(|drawn| drawn.rays.primary),
            shadow: sum(|drawn| drawn.rays.shadow),
            secondary: sum(|drawn| drawn.rays.secondary),
        },
        hits: sum(|drawn| drawn.hits),
        ms: Ms {
            derive: ms(derive),
            trace: drawn.iter().map(|drawn| drawn.trace_ms).sum(),
            total: ms(start.elapsed()),
        },
        effects: first.effects.names().collect(),
        cost_ms: CostMs {
            shadows: drawn.iter().map(|drawn| drawn.cost.shadows).sum(),
            secondary: drawn.iter().map(|drawn| drawn.cost.secondary).sum(),
        },
        shown: first.shown.filter(|_| args.frames.is_none()),
        frames: args.frames.is_some().then_some(&drawn),
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
    } else if args.show == Show::Shaded && lit.samples.is_none() && lit.supersample.is_none() {
        report::next(format_args!("{} --samples 16", report::typed()));
    } else {
        report::next(format_args!("info {input}"));
    }
    Ok(())
}

/// What came of a run.
struct Done {
    /// What all pictures share.
    lit: PictureArgs,
    /// Making what rays go through.
    derive: Duration,
    chosen: Option<Chosen>,
    drawn: Vec<Drawn>,
}

/// Draws what the flags ask for, and writes each picture when it is drawn, the `first` to files that are open.
fn draw(
    scene: &Shown<'_>,
    args: &Args,
    view: &View,
    (shots, first): (&[Shot], Outputs),
    memory: &Memory,
) -> Result<Done> {
    if args.show == Show::Samples && args.picture.supersample.is_none() {
        return Err(Error::usage("--show samples: without --supersample all pixels are alike")
            .hint("add --supersample near, region:X0,Y0,X1,Y1 or adaptive"));
    }
    check_cameras(shots, scene, view)?;
    let lighting = view.lighting(&args.picture.lighting);
    let effects = args.picture.effects.or(view.effects);
    let lit = PictureArgs { camera: shots[0].camera.clone(), lighting, effects, ..args.picture.clone() };
    let goal = match (args.budget, args.target_error) {
        (Some(budget), _) => Some(Goal::Seconds(budget.as_secs_f64())),
        (None, error) => error.map(Goal::Error),
    };
    let is_shaded = matches!(args.show, Show::Shaded | Show::Samples);
    let (prepared, lit, mut chosen) = match goal {
        Some(goal) => choose(scene, args, &lit, goal, memory)?,
        None if is_shaded => (Prepared::new(scene, lit.lod, memory)?, lit, None),
        None => (Prepared::without_trees(scene, lit.lod, memory)?, lit, None),
    };
    let (seen, rest) = (prepared.parts(scene).0, memory.with(prepared.bytes()));

    let extras = Extras { mark_supersampled: args.show == Show::Samples, timed: args.report.json };
    // The rows of a single picture show their own progress.
    let progress = (shots.len() > 1).then(|| Progress::stage("drawing", shots.len() as u64));
    let mut first = Some(first);
    let drawn = shots.iter().map(|shot| {
        if let (Some(progress), Some(frame)) = (&progress, shot.frame) {
            progress.say(format!("frame {frame}"));
        }
        let lit = PictureArgs { camera: shot.camera.clone(), ..lit.clone() };
        let (picture, shown) = match is_shaded {
            true => (prepared.draw(scene, &lit, extras, memory)?, None),
            false => show::draw(&seen, &lit, args.show, &rest)?,
        };
        let depths = shot.depths.as_ref().map(|_| show::depths(&seen, &lit, &rest)).transpose()?;
        let outputs = first.take().map_or_else(|| shot.create(), Ok)?;
        outputs.picture.finish(|file| picture.write_png(file))?;
        if let (Some(output), Some(depths)) = (outputs.depths, depths) {
            output.finish(|file| formats::pfm(picture.width, picture.height, &depths, file))?;
        }
        progress.iter().for_each(Progress::step);
        let Picture { samples, rays, hits, supersampled, effects, cost, trace, .. } = picture;
        let (frame, file, trace_ms) = (shot.frame, shot.picture.clone(), ms(trace));
        Ok(Drawn { frame, file, rays, hits, supersampled, trace_ms, shown, samples, effects, cost })
    });
    let drawn = drawn.collect::<Result<Vec<_>>>()?;
    if let Some(chosen) = &mut chosen {
        chosen.got_ms = drawn[0].trace_ms;
    }
    Ok(Done { lit, derive: prepared.time(), chosen, drawn })
}

/// Chooses how to draw, by the first picture.
fn choose(
    scene: &Shown<'_>,
    args: &Args,
    lit: &PictureArgs,
    goal: Goal,
    memory: &Memory,
) -> Result<(Prepared, PictureArgs, Option<Chosen>)> {
    if args.show != Show::Shaded {
        return Err(Error::usage(
            "--budget and --target-error choose samples: what --show shows has one ray per pixel",
        )
        .hint("leave --show away"));
    }
    let usual = Quality { normals: lit.normals, arithmetic: lit.arithmetic, ..Quality::default() };
    let mut calibration = Calibration::new(scene, lit, memory);
    let range = Range { usual, size: lit.size, depth: scene.geometry.depth() };
    let choice = budget::choose(&mut calibration, goal, range)?;
    let (prepared, calibrated) = calibration.finish(choice.quality)?;
    let chosen = Chosen {
        flags: choice.quality.flags(),
        budget_ms: args.budget.map(ms),
        target_error: args.target_error,
        expected_ms: 1000.0 * choice.seconds,
        got_ms: 0.0,
        expected_error: choice.error,
        calibration_ms: ms(calibrated),
        note: choice.note,
    };
    Ok((prepared, choice.quality.apply(lit), Some(chosen)))
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
    if let Some([first, .., last] | [first @ last]) = report.frames {
        let count = report.frames.map_or(0, <[_]>::len);
        lines.row("frames", format!("{count}: {} to {}", first.file.display(), last.file.display()));
    }
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
