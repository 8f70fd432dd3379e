//! `voxdag thesis`: the tables and pictures of Pineda (2021), chapter 5, measured again on anyone's scenes and machine.

mod measure;
mod published;
mod report;
mod survey;
mod table;
mod view;

use std::path::{Path, PathBuf};
use std::time::Instant;

use voxdag::grid::UpAxis;

use crate::error::{Error, Result};
use crate::input;
use crate::options::{ArithmeticArg, CameraArgs, MachineArgs, NormalsArg, PictureArgs, picture_size};
use crate::output::Output;
use crate::picture::{Picture, Shown};
use crate::progress::Progress;
use crate::report::{Lines, shell_word, time, visible};
use crate::scene;
use measure::Subject;
use published::Published;
use report::Report;
use survey::{Choice, Part};
use table::Cell;

/// Measure the thesis's tables again, on your scenes and machine
///
/// Builds every mesh at every resolution in all representations, draws it in all configurations, and writes the tables
/// 5.1 to 5.8 (Markdown, CSV, JSON) with the published figures beside the thesis's five scenes (bunny, buddha, dragon,
/// sponza, conference: told by the file's name), the pictures, and the visual survey as pages for a browser.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  voxdag thesis bunny.obj                                     three resolutions, three runs
  voxdag thesis bunny.obj sponza.obj -r 256,512 -o report     two scenes into report/")]
pub struct Args {
    /// Wavefront OBJ files
    #[arg(value_name = "MESH", required = true)]
    meshes: Vec<PathBuf>,

    /// Voxels along the longest axis
    #[arg(short, long, value_name = "N,...", value_delimiter = ',', default_value = "256,512,1024",
        value_parser = clap::value_parser!(u32).range(1..=1 << 13))]
    resolution: Vec<u32>,

    /// Runs of everything that is timed; the median counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,

    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "voxdag-thesis")]
    output: PathBuf,

    /// Width and height of the pictures
    #[arg(long, value_name = "WxH", default_value = "640x480", value_parser = picture_size, help_heading = "Picture")]
    size: [u32; 2],

    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// The configurations of the survey: what they are called there, and their pictures.
const SURVEY: [(&str, &str); 5] = [
    ("triangle normals", "triangle-normals"),
    ("radius 1", "radius-1"),
    ("radius 2", "1-sample"),
    ("supersampled", "16-samples"),
    ("adaptive", "adaptive"),
];

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let pool = args.machine.pool()?;
    // Everything that can go wrong with the files does so before the work.
    std::fs::create_dir_all(&args.output).map_err(|cause| Error::write(&args.output, cause))?;
    let pictures = args.output.join("pictures");
    std::fs::create_dir_all(&pictures).map_err(|cause| Error::write(&pictures, cause))?;
    let names = names(&args.meshes)?;
    let mut report = Report::new(args.runs, pool.current_num_threads());
    let mut parts = Vec::new();

    let mut resolutions = args.resolution.clone();
    resolutions.sort_unstable();
    resolutions.dedup();
    let total = resolutions.iter().map(|n| cost(*n)).sum::<u64>() * args.meshes.len() as u64;
    let progress = Progress::stage("measuring", total);
    for (path, name) in args.meshes.iter().zip(&names) {
        let mut memory = args.machine.memory();
        let source = scene::import_file(path, input::read_mesh(path, &mut memory)?, &mut memory)?;
        let published = Published::of(name);
        let triangles = source.model.mesh().triangles.len() as f64;
        let materials = source.model.materials.len() as f64;
        report.put("5.1", name, "triangles", Cell::exact(0, triangles, published.map(|p| p.triangles)));
        report.put("5.1", name, "materials", Cell::exact(0, materials, published.map(|p| p.materials)));
        for &resolution in &resolutions {
            progress.say(visible(&format!("{name} at {resolution}")));
            let subject = Subject { name, source: &source, published, resolution, runs: args.runs };
            let view = |shown: &Shown<'_>| view(args, published, shown);
            let drawn = pool.install(|| measure::run(&subject, &mut report, &view, &memory))?;
            if resolutions.last() == Some(&resolution) {
                parts.push(keep(&mut report, &pictures, name, &drawn)?);
            }
            progress.steps(cost(resolution));
        }
    }
    write(&args.output.join("report.md"), "md", report.markdown().as_bytes())?;
    write(&args.output.join("tables.csv"), "csv", &report.csv()?)?;
    write(&args.output.join("report.json"), "json", &report.json()?)?;
    write(&args.output.join("survey.html"), "html", survey::page(&parts)?.as_bytes())?;
    write(&args.output.join("tally.html"), "html", survey::TALLY.as_bytes())?;

    let mut lines = Lines::default();
    lines
        .row("tables", args.output.join("report.md").display().to_string())
        .row("", args.output.join("tables.csv").display().to_string())
        .row("", args.output.join("report.json").display().to_string())
        .row("pictures", pictures.display().to_string())
        .row("survey", args.output.join("survey.html").display().to_string())
        .row("its answers", args.output.join("tally.html").display().to_string())
        .row("agreement", report.agreed())
        .row("time", time(start.elapsed().as_secs_f64() * 1000.0));
    crate::report::result(false, &(), &lines)?;
    crate::report::next(format_args!("render {} -o picture.png --supersample adaptive", shell_word(&args.meshes[0])));
    match report.all_equal() {
        true => Ok(()),
        false => Err(Error::new(crate::error::Kind::Failure, report.agreed()).hint("this is a defect of voxdag")),
    }
}

/// Names of the scenes: those of their files, which must differ.
fn names(meshes: &[PathBuf]) -> Result<Vec<String>> {
    let mut names: Vec<String> = Vec::new();
    for path in meshes {
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        if names.contains(&name) {
            return Err(Error::usage(format_args!("{}: there are two scenes of the name {name}", path.display()))
                .hint("tables and pictures go by the names of the files: rename one"));
        }
        names.push(name);
    }
    Ok(names)
}

/// The picture that is drawn in all configurations.
fn view(args: &Args, published: Option<&Published>, shown: &Shown<'_>) -> PictureArgs {
    let (camera, lights) = view::of(published, &shown.bounds, UpAxis::Y, &args.camera);
    PictureArgs {
        size: args.size,
        camera,
        lights,
        ambient: [0.2; 3],
        normals: NormalsArg::default(),
        samples: None,
        supersample: None,
        arithmetic: ArithmeticArg::default(),
    }
}

/// Writes the pictures of a scene, and gives its part of the survey.
fn keep(report: &mut Report, folder: &Path, name: &str, drawn: &[(&'static str, Picture)]) -> Result<Part> {
    for (configuration, picture) in drawn {
        let file = format!("{name}-{configuration}.png");
        let output = Output::create(&folder.join(&file), "png")?;
        output.finish(|out| picture.write_png(out))?;
        report.pictures.push([name.to_owned(), (*configuration).to_owned(), format!("pictures/{file}")]);
    }
    let mut pictures = Vec::new();
    for (label, configuration) in SURVEY {
        let Some((_, picture)) = drawn.iter().find(|(name, _)| *name == configuration) else { continue };
        let mut png = Vec::new();
        picture.write_middle_png(&mut png).map_err(|cause| Error::write(folder, cause))?;
        pictures.push(Choice::new(label, &png));
    }
    Ok(Part { name: name.to_owned(), pictures })
}

fn write(path: &Path, extension: &str, content: &[u8]) -> Result<()> {
    use std::io::Write as _;
    Output::create(path, extension)?.finish(|file| file.write_all(content))
}

/// What a resolution takes, in some unit: voxels grow with its square, and pictures take their time at any.
fn cost(resolution: u32) -> u64 {
    60 + u64::from(resolution).pow(2) / 4096
}
