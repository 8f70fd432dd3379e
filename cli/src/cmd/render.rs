//! `voxdag render`: a mesh or a scene becomes a picture.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::detail::Detail;
use crate::error::{Error, Result};
use crate::formats;
use crate::frames::{self, Shot};
use crate::input::{self, Content};
use crate::memory::Memory;
use crate::options::{BuildArgs, MachineArgs, PictureArgs, ReportArgs, SupersampleArg, ViewArgs};
use crate::output::Output;
use crate::picture::{Picture, Prepared, Rays, Shown};
use crate::progress::Progress;
use crate::report::{self, Lines, grouped, shell_word, time};
use crate::scene;
use crate::show::{self, Show, Spread};
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

    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    view: ViewArgs,

    /// Frames of the view's camera path, such as 1-48: IMG_0001.png to IMG_0048.png; without it, the view's [camera]
    #[arg(long, value_name = "A-B", value_parser = crate::options::frames, allow_hyphen_values = true,
        help_heading = "Picture")]
    frames: Option<RangeInclusive<u32>>,

    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    build: BuildArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

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
    effects: &'a [&'static str],
    /// The numbers behind the colours of `--show depth`, `level` and `iterations`; of frames, each has its own.
    shown: Option<Spread>,
    /// With `--frames`.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<&'a [Drawn]>,
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
    effects: Vec<&'static str>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    args.build.check()?;
    let view = View::read(&args.view)?;
    let flags = &args.picture.camera;
    let shots = frames::shots(&view, args.frames.as_ref(), flags, &args.output, args.depth_out.as_deref())?;
    let inputs: Vec<_> = std::iter::once(&args.input).chain(&view.file).cloned().collect();
    frames::check_outputs(&shots, &inputs)?;
    let pool = args.machine.pool()?;
    let mut memory = args.machine.memory();

    let ((derive, drawn), grid, is_scene) = match input::read(&args.input, &mut memory)? {
        Content::Scene(words) => {
            args.build.must_be_absent(&args.input)?;
            let scene = scene::open(&args.input, &words)?;
            (pool.install(|| draw(&Shown::of(&scene), args, &view, &shots, &memory))?, scene.grid, true)
        }
        Content::Mesh(text) => {
            let source = scene::import_file(&args.input, text, &mut memory)?;
            frames::check_outputs(&shots, &source.files)?;
            let built = pool.install(|| scene::build(&source, &args.build, &mut memory))?;
            memory.release(source.bytes);
            drop(source);
            (pool.install(|| draw(&built.shown(), args, &view, &shots, &memory))?, built.grid, false)
        }
    };

    let first = &drawn[0];
    let sum = |of: fn(&Drawn) -> u64| drawn.iter().map(of).sum::<u64>();
    let mean = |of: fn(&Drawn) -> f64| drawn.iter().map(of).sum::<f64>() / drawn.len() as f64;
    let report = Report {
        width: args.picture.size[0],
        height: args.picture.size[1],
        samples: first.samples,
        supersample: args.picture.supersample.unwrap_or(SupersampleArg::All).to_string(),
        supersampled: mean(|drawn| drawn.supersampled),
        resolution: grid.resolution,
        lod: args.picture.lod,
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
        effects: &first.effects,
        shown: first.shown.filter(|_| args.frames.is_none()),
        frames: args.frames.is_some().then_some(&drawn),
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

/// Draws what the flags ask for and writes it, and says how long it took to derive what all pictures are drawn with.
fn draw(
    scene: &Shown<'_>,
    args: &Args,
    view: &View,
    shots: &[Shot],
    memory: &Memory,
) -> Result<(Duration, Vec<Drawn>)> {
    if args.show == Show::Samples && args.picture.supersample.is_none() {
        return Err(Error::usage("--show samples: without --supersample all pixels are alike")
            .hint("add --supersample near, region:X0,Y0,X1,Y1 or adaptive"));
    }
    frames::check_cameras(shots, scene, view)?;
    let start = Instant::now();
    let detail = Detail::new(scene, args.picture.lod, memory)?;
    let (scene, memory) = (&detail.of(scene), &memory.with(detail.bytes()));
    let is_shaded = matches!(args.show, Show::Shaded | Show::Samples);
    let prepared = is_shaded.then(|| Prepared::new(scene, 0, memory)).transpose()?;
    let derive = start.elapsed();

    // The rows of a single picture show their own progress.
    let progress = (shots.len() > 1).then(|| Progress::stage("drawing", shots.len() as u64));
    let drawn = shots.iter().map(|shot| {
        if let (Some(progress), Some(frame)) = (&progress, shot.frame) {
            progress.say(format!("frame {frame}"));
        }
        let lighting = view.lighting(&args.picture.lighting);
        let picture = PictureArgs { camera: shot.camera.clone(), lighting, ..args.picture.clone() };
        let (drawn, shown) = match &prepared {
            Some(prepared) => (prepared.draw(scene, &picture, args.show == Show::Samples, memory)?, None),
            None => show::draw(scene, &picture, args.show, memory)?,
        };
        let depths = shot.depths.as_ref().map(|path| Ok((path, show::depths(scene, &picture, memory)?))).transpose()?;
        Output::create(&shot.picture, "png")?.finish(|file| drawn.write_png(file))?;
        if let Some((path, depths)) = depths {
            Output::create(path, "pfm")?.finish(|file| formats::pfm(drawn.width, drawn.height, &depths, file))?;
        }
        progress.iter().for_each(Progress::step);
        let Picture { samples, rays, hits, supersampled, effects, trace, .. } = drawn;
        let (frame, file, trace_ms) = (shot.frame, shot.picture.clone(), ms(trace));
        Ok(Drawn { frame, file, rays, hits, supersampled, trace_ms, shown, samples, effects })
    });
    Ok((derive, drawn.collect::<Result<_>>()?))
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
    lines
        .row(
            "time",
            format!("{}: derive {}, trace {}", time(report.ms.total), time(report.ms.derive), time(report.ms.trace)),
        )
        .row("memory", report::peak(report.peak_rss_bytes))
        .row("threads", report.threads.to_string());
    lines
}
