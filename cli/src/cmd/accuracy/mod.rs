//! `voxdag accuracy`: what each choice of accuracy costs and what it buys, for anyone's scene on anyone's machine.
//!
//! ```text
//! mesh -> plan of settings -> measure (builds, truth, pictures, errors, wrong voxels) -> report -> page, plots, CSV, JSON
//! ```

mod build;
mod cost;
mod crops;
mod front;
mod measure;
mod page;
mod plan;
mod plot;
mod report;
mod wrong;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::demo::{self, DemoScene};
use crate::error::{Error, Result};
use crate::input;
use crate::memory::Memory;
use crate::options::{
    BuildArgs, CameraArgs, LightingArgs, MachineArgs, ReportArgs, UpAxisArg, ViewArgs, name_of, picture_size,
    resolution,
};
use crate::output::{Folder, Output, Scratch};
use crate::picture;
use crate::report::{Lines, file_name, grouped, shell_word, time};
use crate::source::{self, Source};
use crate::truth::{Known, MeshTruth, Truth};
use crate::view::View;
use measure::{Found, Subject};
use plan::Setting;
use report::{Advice, Head, Report};

/// Measure what accuracy costs in time, on your scene and machine
///
/// Draws the scene in many settings, one axis at a time from the default and in combinations: resolution, level of detail,
/// overlap and traversal arithmetic, cover, normals and samples. Each picture is compared with one of the mesh itself, each
/// setting is timed, and a page shows which ones are worth their time.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  voxdag accuracy bunny.obj                        the whole sweep, some minutes: voxdag-accuracy/report.html
  voxdag accuracy bunny.obj --quick -o quick       fewer settings, within a minute
  voxdag accuracy --scene sphere --quick           against a closed form")]
pub struct Args {
    /// Wavefront OBJ file [default: the scene that comes along]
    #[arg(value_name = "MESH", conflicts_with = "scene")]
    mesh: Option<PathBuf>,

    /// A shape that needs no file and is compared with its closed form
    #[arg(long, value_name = "NAME", value_enum)]
    scene: Option<Known>,

    /// Voxels along the longest axis [default: 256,512,1024,2048; 512,1024 with --quick]
    #[arg(short, long, value_name = "N,...", value_delimiter = ',', value_parser = resolution, allow_negative_numbers = true)]
    resolution: Vec<u32>,

    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "voxdag-accuracy")]
    output: PathBuf,

    /// Fewer settings and repetitions
    #[arg(long)]
    quick: bool,

    /// How often each setting is drawn; the median counts [default: 5; 3 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), allow_negative_numbers = true)]
    repeat: Option<u32>,

    /// Width and height of the pictures [default: 640x360; 320x180 with --quick]
    #[arg(long, value_name = "WxH", value_parser = picture_size, help_heading = "Picture")]
    size: Option<[u32; 2]>,

    /// The axis that points up
    #[arg(long, value_name = "AXIS", value_enum, help_heading = "Picture")]
    up_axis: Option<UpAxisArg>,

    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    lighting: LightingArgs,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

const QUICK: [u32; 2] = [512, 1024];
const FULL: [u32; 4] = [256, 512, 1024, 2048];

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let pool = args.machine.pool()?;
    let _folder = Folder::create(&args.output)?;
    let report = pool.install(|| write_all(args))?;

    crate::report::result(args.report.json, &report, &lines(args, &report, start))?;
    if let Some(mesh) = &args.mesh {
        let flags = &report.knee().flags;
        crate::report::next(format_args!("render {} -o picture.png {} {flags}", shell_word(mesh), report.view));
    }
    Ok(())
}

/// Measures everything, and writes what came of it once all of it is known.
fn write_all(args: &Args) -> Result<Report> {
    let output = |name: &str, extension: &str| Output::create(&args.output.join(name), extension);
    let (page, plot) = (output("report.html", "html")?, output("front.svg", "svg")?);
    let (csv, json) = (output("accuracy.csv", "csv")?, output("accuracy.json", "json")?);

    let view = View::read(&args.view)?;
    let (camera, lighting) = (view.camera(&args.camera), view.lighting(&args.lighting));
    let files = [&page, &plot, &csv, &json];
    files.iter().try_for_each(|output| output.must_not_replace(view.file.as_slice()))?;
    if let (Some(file), Some(_)) = (&args.view.view, view.effects) {
        let why =
            "the picture of the surfaces themselves has highlights and shadows, and so have those that are compared";
        crate::report::warning(format_args!("{}: its effects are left out: {why}", file.display()));
    }
    let pictures = args.output.join("pictures");
    let _folder = Folder::create(&pictures)?;

    let mut memory = args.machine.memory();
    let (report, found, settings) = match (&args.mesh, args.scene) {
        (_, Some(known)) => {
            let (source, truth) = (known.source(), known.closed());
            measure(args, &source, None, (&truth, "the closed form"), (&camera, &lighting), &mut memory)?
        }
        (Some(path), None) => {
            let source = source::import_file(path, input::read_mesh(path, &mut memory)?, false, &mut memory)?;
            files.iter().try_for_each(|output| output.must_not_replace(&source.files))?;
            against_mesh(args, &source, path, (&camera, &lighting), &mut memory)?
        }
        (None, None) => {
            // A file like any other, so that its build can be watched.
            let folder = Scratch::create()?;
            let path = folder.path("demo.obj");
            let texts = [
                (path.clone(), voxdag::demo::obj()),
                (path.with_file_name(voxdag::demo::MTL_NAME), voxdag::demo::mtl()),
            ];
            for (path, text) in texts {
                std::fs::write(&path, text).map_err(|cause| Error::write(&path, cause))?;
            }
            let source = source::import_file(&path, input::read_mesh(&path, &mut memory)?, false, &mut memory)?;
            let usual = demo::view(DemoScene::Hall);
            let (camera, lighting) = (camera.or(&usual.camera), lighting.or(&usual.lighting));
            against_mesh(args, &source, &path, (&camera, &lighting), &mut memory)?
        }
    };

    let (crops, whole) = crops::crops(&report, &settings, &found)?;
    let picture = |name: &str, pixels: &[u32]| {
        let output = Output::create(&pictures.join(format!("{name}.png")), "png")?;
        output.finish(|file| picture::png(report.size, pixels.iter(), file))
    };
    picture("truth", &found.truth)?;
    for (setting, row) in settings.iter().zip(&found.rows) {
        picture(&file_name(&setting.label), &row.pixels)?;
    }
    let write = |output: Output, content: &[u8]| output.finish(|file| file.write_all(content));
    write(csv, &report.csv()?)?;
    write(json, &report.json()?)?;
    write(plot, page::front_plot(&report)?.as_bytes())?;
    write(page, page::page(&report, &crops, &whole)?.as_bytes())?;
    Ok(report)
}

/// Measures with the mesh itself as the truth.
fn against_mesh(
    args: &Args,
    source: &Source,
    file: &Path,
    view: (&CameraArgs, &LightingArgs),
    memory: &mut Memory,
) -> Result<(Report, Found, Vec<Setting>)> {
    let truth = MeshTruth::new(source.model.mesh(), memory)?;
    measure(args, source, Some(file), (&truth, "the mesh itself"), view, memory)
}

fn measure(
    args: &Args,
    source: &Source,
    file: Option<&Path>,
    (truth, truth_name): (&impl Truth, &'static str),
    (camera, lighting): (&CameraArgs, &LightingArgs),
    memory: &mut Memory,
) -> Result<(Report, Found, Vec<Setting>)> {
    let mut resolutions = match (&args.resolution[..], args.quick) {
        ([], true) => QUICK.to_vec(),
        ([], false) => FULL.to_vec(),
        (given, _) => given.to_vec(),
    };
    resolutions.sort_unstable();
    resolutions.dedup();
    let settings = plan::settings(&resolutions, args.quick);
    let build = BuildArgs { up_axis: args.up_axis, ..BuildArgs::default() };
    let repeat = args.repeat.unwrap_or(if args.quick { 3 } else { 5 });
    let slow_repeat = if args.quick { 1 } else { repeat.min(3) };
    let size = args.size.unwrap_or(if args.quick { [320, 180] } else { [640, 360] });
    let subject = Subject { source, file, truth, build: &build, size, camera, lighting, repeat, slow_repeat };
    let found = measure::run(&subject, &settings, memory)?;
    // A view file's lights may be such as no flags give.
    let lights = match &args.view.view {
        Some(file) => format!("--view {} {}", shell_word(file), args.lighting.typed()),
        None => lighting.typed(),
    };
    let shading = "--effects phong,+shadows";
    let view = [format!("--size {}x{} {shading}", size[0], size[1]), CameraArgs::typed_of(&found.camera), lights];
    let head = Head {
        scene: args.scene_name(),
        triangles: source.model.mesh().triangles.len(),
        truth: truth_name,
        size,
        view: view.join(" ").trim_end().to_owned(),
        repeat: [repeat, slow_repeat],
        threads: rayon::current_num_threads(),
    };
    Ok((Report::new(head, &settings, &found)?, found, settings))
}

impl Args {
    /// What reports call the scene.
    fn scene_name(&self) -> String {
        match (&self.mesh, self.scene) {
            (Some(path), _) => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
            (None, Some(known)) => name_of(known),
            (None, None) => "the scene that comes along".to_owned(),
        }
    }
}

/// The report for people.
fn lines(args: &Args, report: &Report, start: Instant) -> Lines {
    let mut lines = Lines::default();
    let place = |name: &str| args.output.join(name).display().to_string();
    lines
        .row("report", place("report.html"))
        .row("", place("accuracy.csv"))
        .row("", place("accuracy.json"))
        .row("pictures", place("pictures"))
        .row("settings", format!("{}, each drawn {} times", report.settings.len(), report.repeat[0]));
    for step in report.advice() {
        let Advice { setting, below, .. } = step;
        let mark = if std::ptr::eq(setting, report.knee()) { "  <- worth its time" } else { "" };
        let label = format!("error < {below}");
        lines.row(label, format!("{:>8}  {}{mark}", time(setting.render_ms.median), setting.flags));
    }
    for wrong in &report.wrong {
        let count = grouped(wrong.missing + wrong.extra);
        lines.row(
            wrong.method,
            format!("{:>8}, {count} wrong of {}, judged by {}", time(wrong.ms), grouped(wrong.compared), wrong.against),
        );
    }
    lines.row("time", time(start.elapsed().as_secs_f64() * 1000.0));
    lines
}
