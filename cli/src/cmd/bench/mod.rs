//! `voxdag bench`: how fast the stages are on this machine, and how accurate.
//!
//! One file per subject. They share the input, the camera and the rays: primary rays of a picture, and the hits that
//! they find. All of it is prepared first; only the work inside [`measure`](crate::measure::measure) is timed.

mod accuracy;
mod build;
mod effects;
mod materials;
mod normals;
mod packets;
mod ranks;
mod rays;
mod textures;
mod trace;

use std::path::{Path, PathBuf};

use clap::{Subcommand, ValueEnum};
use serde::Serialize;
use voxdag::{Geometry, Morton};
use voxdag_oracle::rng::Rng;

use super::demo::{self, DemoScene};
use crate::error::{Error, Kind, Result};
use crate::input::{self, Content};
use crate::measure::Times;
use crate::options::{BuildArgs, CameraArgs, MachineArgs, ReportArgs, ViewArgs, picture_size};
use crate::picture::Shown;
use crate::report::grouped;
use crate::scene;
use crate::source::{self, Source};
use crate::view::View;

/// Measure how fast this machine traces, shades and builds
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  voxdag bench trace bunny.vxd             rays per second
  voxdag bench build bunny.obj -r 1024     voxels per second, stage by stage
  voxdag bench accuracy bunny.obj          what exactness costs, and what its lack costs

Rates are per core: work by the CPU time of the threads that did it. Each is the median of the repetitions,
which are interleaved with those of everything it is compared with; the slowest and the fastest follow it.")]
pub struct Args {
    #[command(subcommand)]
    subject: Subject,
}

#[derive(Subcommand)]
enum Subject {
    /// Rays per second: from the camera, from hits to a light, from hits to everywhere; many at once, one by one
    Trace(trace::Args),
    /// Time per normal, by kind
    Normals(Run),
    /// Time per look-up of a voxel's material
    Materials(Run),
    /// Time per rank of a voxel, and per look-up of its material by rank, by scheme
    Ranks(Run),
    /// Voxels per second, by stage of building a mesh
    Build(Run),
    /// Time and errors of the textbook methods beside the exact ones
    Accuracy(Run),
    /// Size, loss and time of the colours of textures, in blocks and as they are
    Textures(Run),
    /// Time of a picture with each effect and without, by each kernel, and of its shadow rays alone
    Effects(effects::Args),
}

/// What is measured, and how often.
#[derive(clap::Args)]
struct Run {
    /// Wavefront OBJ file, or `hall` or `studio`, which come along; where no mesh is needed, a scene from `voxdag build`, too
    #[arg(value_name = "MESH_OR_VXD")]
    input: PathBuf,

    #[command(flatten)]
    report: ReportArgs,

    /// Repetitions; the median counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,

    /// Width and height of the picture whose rays are traced
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = picture_size, help_heading = "Picture")]
    size: [u32; 2],

    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    build: BuildArgs,

    /// Threads that measure at the same time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024),
        help_heading = "Machine")]
    threads: u16,
}

/// Runs the command.
pub fn run(mut args: Args) -> Result<()> {
    let (Subject::Trace(trace::Args { run, .. })
    | Subject::Normals(run)
    | Subject::Materials(run)
    | Subject::Ranks(run)
    | Subject::Build(run)
    | Subject::Accuracy(run)
    | Subject::Textures(run)
    | Subject::Effects(effects::Args { run, .. })) = &mut args.subject;
    run.build.check()?;
    let view = View::read(&run.view)?;
    run.camera = view.camera(&run.camera);
    let (input, pool) = (Input::read(run)?, run.machine().pool()?);
    if let Input::Embedded(scene, _) = &input {
        run.camera = run.camera.or(&demo::view(*scene).camera);
    }
    pool.install(|| match &args.subject {
        Subject::Trace(args) => input.with_scene(&args.run, |scene| trace::run(args, scene)),
        Subject::Normals(run) => input.with_scene(run, |scene| normals::run(run, scene)),
        Subject::Materials(run) => input.with_scene(run, |scene| materials::run(run, scene)),
        Subject::Ranks(run) => input.with_scene(run, |scene| ranks::run(run, scene)),
        Subject::Build(run) => build::run(run, input.mesh(&run.input)?),
        Subject::Textures(run) => textures::run(run, input.mesh(&run.input)?),
        Subject::Accuracy(run) => input.with_scene(run, |scene| accuracy::run(run, scene, input.mesh(&run.input).ok())),
        Subject::Effects(args) => {
            let mut lighting = view.lighting(&args.lighting);
            if let Input::Embedded(scene, _) = &input {
                lighting = lighting.or(&demo::view(*scene).lighting);
            }
            input.with_scene(&args.run, |scene| effects::run(args, scene, &lighting))
        }
    })
}

impl Run {
    fn machine(&self) -> MachineArgs {
        MachineArgs { threads: Some(self.threads), memory_limit: None }
    }
}

/// The file to measure on.
enum Input {
    Mesh(Box<Source>),
    /// A scene that comes along, where there is no file of its name.
    Embedded(DemoScene, Box<Source>),
    Scene(Vec<u32>),
}

impl Input {
    fn read(run: &Run) -> Result<Input> {
        let mut memory = run.machine().memory();
        let embedded = run.input.to_str().and_then(|name| DemoScene::from_str(name, false).ok());
        if let Some(scene) = embedded.filter(|_| !run.input.is_file()) {
            return Ok(Input::Embedded(scene, Box::new(demo::source(scene, &mut memory)?)));
        }
        match input::read(&run.input, &mut memory)? {
            Content::Mesh(text) => Ok(Input::Mesh(Box::new(source::import_file(
                &run.input,
                text,
                run.build.reads_textures(),
                &mut memory,
            )?))),
            Content::Scene(words) => {
                run.build.must_be_absent(&run.input)?;
                Ok(Input::Scene(words))
            }
        }
    }

    /// The mesh, or an error that asks for one.
    fn mesh(&self, path: &Path) -> Result<&Source> {
        match self {
            Input::Mesh(source) | Input::Embedded(_, source) => Ok(source),
            Input::Scene(_) => Err(Error::usage(format_args!("{}: is built already", path.display()))
                .hint("name the mesh that it was built from")),
        }
    }

    /// The scene, built first if need be.
    fn with_scene<T>(&self, run: &Run, use_scene: impl FnOnce(&Shown<'_>) -> Result<T>) -> Result<T> {
        match self {
            Input::Mesh(source) | Input::Embedded(_, source) => {
                use_scene(&scene::build(source, &run.build, &mut run.machine().memory())?.shown())
            }
            Input::Scene(words) => use_scene(&Shown::of(&scene::open(&run.input, words)?)),
        }
    }
}

/// Voxels of the scattered look-ups, at most.
const SCATTERED: u64 = 1 << 20;
/// Most voxels that are counted off: minutes. A file of a kilobyte can stand for 2^63.
const MOST_VISITED: u64 = 1 << 32;

/// Voxels from everywhere, in random order, and the number of all of them; an error if they are too many to visit.
fn scattered(run: &Run, scene: &Shown<'_>) -> Result<(Vec<Morton>, u64)> {
    let voxels = scene::count(scene.geometry)?.voxels;
    if voxels > MOST_VISITED {
        let (found, most) = (grouped(voxels), grouped(MOST_VISITED));
        let message = format_args!("{}: {found} voxels, this visits at most {most}", run.input.display());
        return Err(Error::new(Kind::Limit, message).hint("build the scene again with a smaller -r"));
    }
    let mut some: Vec<_> = scene.geometry.voxels().step_by(voxels.div_ceil(SCATTERED).max(1) as usize).collect();
    Rng::new(3).shuffle(&mut some);
    Ok((some, voxels))
}

/// Nanoseconds per item, as reports have them.
#[derive(Serialize)]
struct Cost {
    ns: f64,
    ns_min: f64,
    ns_max: f64,
    checksum: String,
}

impl Cost {
    fn of(times: &Times, items: usize) -> Cost {
        let spread = times.ns(items);
        Cost { ns: spread.median, ns_min: spread.min, ns_max: spread.max, checksum: checksum(times) }
    }

    /// For people.
    fn text(&self) -> String {
        format!("{:8.1} ns ({:.1} to {:.1})", self.ns, self.ns_min, self.ns_max)
    }
}

/// The sum of a kernel's results, as reports have it.
fn checksum(times: &Times) -> String {
    format!("{:016x}", times.checksum)
}
