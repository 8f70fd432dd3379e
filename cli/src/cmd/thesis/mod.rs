//! `voxdag thesis`: the tables and pictures of Pineda (2021), chapter 5, measured again on anyone's scenes and machine.

mod draw;
mod measure;
mod published;
mod report;
mod survey;
mod table;
mod view;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use voxdag::effects::Effects;
use voxdag::grid::UpAxis;

use crate::error::{Error, Kind, Result};
use crate::input;
use crate::options::{ArithmeticArg, CameraArgs, LightingArgs, MachineArgs, NormalsArg, PictureArgs, picture_size};
use crate::output::{Folder, Output};
use crate::picture::Picture;
use crate::progress::Progress;
use crate::report::{Lines, file_name, shell_word, time, visible};
use crate::source;
use measure::Subject;
use published::Published;
use report::{Report, Seen};
use survey::{Choice, Part};
use table::Cell;
use view::View;

/// Measure the thesis's tables again, on your scenes and machine
///
/// Builds every mesh at every resolution in all representations, draws it in all configurations, and writes the tables
/// 5.1 to 5.8 (Markdown, CSV, JSON), the pictures, and the visual survey as pages for a browser. Files of the names
/// bunny, buddha, buddha_room, dragon_box, sponza, sponza_328131 and conference with about as many triangles as the
/// thesis's scenes are read as these: the published figures stand beside them, and without --eye, --target, --view-up
/// and --fov they are seen as in its figure 5.1.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  voxdag thesis bunny.obj                                     three resolutions, three runs
  voxdag thesis bunny.obj sponza.obj -r 256,512 -o report     two scenes into report/")]
pub struct Args {
    /// Wavefront OBJ files
    #[arg(value_name = "MESH", required = true)]
    meshes: Vec<PathBuf>,

    /// Voxels along the longest axis, 1 to 8192 each
    #[arg(short, long, value_name = "N,...", value_delimiter = ',', default_value = "256,512,1024", value_parser = resolution,
        allow_negative_numbers = true)]
    resolution: Vec<u32>,

    /// Runs of everything that is timed; the median counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000),
        allow_negative_numbers = true)]
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

/// Reads one of the resolutions.
fn resolution(text: &str) -> Result<u32, String> {
    let found = text.trim().parse().ok().filter(|n| (1..=1 << 13).contains(n));
    found.ok_or_else(|| "expected whole numbers from 1 to 8192 with commas between them, such as 256,512".to_owned())
}

/// The configurations of the survey: what they are called there, and their pictures.
const SURVEY: [(&str, &str); 5] = [
    ("triangle normals", "triangle-normals"),
    ("radius 1", "radius-1"),
    ("radius 2", "1-sample"),
    ("supersampled", "16-samples"),
    ("adaptive", "adaptive"),
];

/// Size of the thesis's pictures.
const SIZE: [u32; 2] = [640, 480];

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let pool = args.machine.pool()?;
    // What can go wrong with the files does so before the work.
    let names = names(&args.meshes)?;
    for mesh in &args.meshes {
        std::fs::File::open(mesh).map_err(|cause| input::unreadable(mesh, &cause))?;
    }
    let _folder = Folder::create(&args.output)?;
    let report = write_all(args, &names, &pool)?;

    let mut lines = Lines::default();
    let place = |name: &str| args.output.join(name).display().to_string();
    lines
        .row("tables", place("report.md"))
        .row("", place("tables.csv"))
        .row("", place("report.json"))
        .row("pictures", place("pictures"))
        .row("survey", place("survey.html"))
        .row("its answers", place("tally.html"))
        .row("agreement", report.agreed())
        .row("time", time(start.elapsed().as_secs_f64() * 1000.0));
    crate::report::result(false, &(), &lines)?;
    crate::report::next(format_args!("render {} -o picture.png --supersample adaptive", shell_word(&args.meshes[0])));
    match report.all_equal() {
        true => Ok(()),
        false => Err(Error::new(Kind::Failure, report.agreed()).hint("this is a defect of voxdag")),
    }
}

/// Measures everything, and writes what came of it once all of it is known.
fn write_all(args: &Args, names: &[String], pool: &rayon::ThreadPool) -> Result<Report> {
    let folder = &args.output;
    let create = |folder: &Path| std::fs::create_dir_all(folder).map_err(|cause| Error::write(folder, cause));
    let output = |name: &str| {
        let path = folder.join(name);
        let extension = path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
        Output::create(&path, &extension)
    };
    let [markdown, table, json, survey, tally] =
        ["report.md", "tables.csv", "report.json", "survey.html", "tally.html"].map(output);
    let (markdown, table, json, survey, tally) = (markdown?, table?, json?, survey?, tally?);

    let mut report = Report::new(args.runs, pool.current_num_threads(), args.size);
    let (mut pictures, mut parts) = (Vec::new(), Vec::new());
    let mut resolutions = args.resolution.clone();
    resolutions.sort_unstable();
    resolutions.dedup();
    let total = resolutions.iter().map(|n| cost(*n)).sum::<u64>() * args.meshes.len() as u64;
    let progress = Progress::stage("measuring", total);
    for (path, name) in args.meshes.iter().zip(names) {
        let mut memory = args.machine.memory();
        let source = source::import_file(path, input::read_mesh(path, &mut memory)?, false, &mut memory)?;
        let mesh = source.model.mesh();
        let published = Published::of(name, mesh.triangles.len());
        let (triangles, materials) = (mesh.triangles.len() as f64, source.model.materials.len() as f64);
        report.put("5.1", name, "triangles", Cell::exact(0, triangles, published.map(|p| p.triangles)));
        report.put("5.1", name, "materials", Cell::exact(0, materials, published.map(|p| p.materials)));
        let bounds = mesh.validate().map_err(|error| Error::input(path, error))?;
        let view = View::of(published, &bounds, UpAxis::Y, &args.camera);
        let read_as = published.map(|scene| scene.name);
        report.views.push(Seen { scene: name.clone(), read_as, flags: view.flags(args.size) });
        let usual_view = view.built_in && args.size == SIZE;
        let drawing = PictureArgs {
            size: args.size,
            camera: view.camera,
            lighting: LightingArgs { lights: view.lights, ..LightingArgs::default() },
            normals: NormalsArg::default(),
            samples: None,
            supersample: None,
            arithmetic: ArithmeticArg::default(),
            effects: Some(Effects::PHONG),
            lift: None,
            lod: 0,
        };
        for &resolution in &resolutions {
            progress.say(visible(&format!("{name} at {resolution}")));
            let subject = Subject { name, source: &source, published, resolution, runs: args.runs, usual_view };
            let step = |part: f64| progress.steps((part * cost(resolution) as f64) as u64);
            let drawn = pool.install(|| measure::run(&subject, &mut report, &drawing, &step, &mut memory))?;
            if resolutions.last() == Some(&resolution) {
                parts.push(keep(&mut report, &mut pictures, name, read_as.unwrap_or(name), &drawn)?);
            }
        }
    }
    drop(progress);

    create(&folder.join("pictures"))?;
    for (file, png) in &pictures {
        write(Output::create(&folder.join(file), "png")?, png)?;
    }
    write(table, &report.csv()?)?;
    write(json, &report.json()?)?;
    write(survey, survey::page(&parts)?.as_bytes())?;
    write(tally, survey::TALLY.as_bytes())?;
    write(markdown, report.markdown().as_bytes())?;
    Ok(report)
}

/// Names of the scenes: those of their files, which must differ, also in what is left of them in file names.
fn names(meshes: &[PathBuf]) -> Result<Vec<String>> {
    let mut names: Vec<String> = Vec::new();
    for path in meshes {
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        if names.iter().any(|other| file_name(other) == file_name(&name)) {
            return Err(Error::usage(format_args!("{}: there are two scenes of the name {name}", path.display()))
                .hint("tables and pictures go by the names of the files: rename one"));
        }
        names.push(name);
    }
    Ok(names)
}

/// Encodes the pictures of a scene, and gives its part of the survey.
fn keep(
    report: &mut Report,
    pictures: &mut Vec<(String, Vec<u8>)>,
    name: &str,
    called: &str,
    drawn: &[(&'static str, Picture)],
) -> Result<Part> {
    let failed = |cause: std::io::Error| Error::new(Kind::Failure, cause);
    for (configuration, picture) in drawn {
        let file = format!("pictures/{}-{configuration}.png", file_name(name));
        let mut png = Vec::new();
        picture.write_png(&mut png).map_err(failed)?;
        report.pictures.push([name.to_owned(), (*configuration).to_owned(), file.clone()]);
        pictures.push((file, png));
    }
    let mut choices = Vec::new();
    for (label, configuration) in SURVEY {
        let Some((_, picture)) = drawn.iter().find(|(name, _)| *name == configuration) else { continue };
        let mut png = Vec::new();
        picture.write_middle_png(&mut png).map_err(failed)?;
        choices.push(Choice::new(label, &png));
    }
    Ok(Part { name: called.to_owned(), pictures: choices })
}

fn write(output: Output, content: &[u8]) -> Result<()> {
    output.finish(|file| file.write_all(content))
}

/// What a resolution takes, in some unit: voxels grow with its square, and pictures take their time at any.
fn cost(resolution: u32) -> u64 {
    60 + u64::from(resolution).pow(2) / 4096
}
