//! `voxdag demo`: the main job on the scenes that come along, on the way that a user's own mesh takes.

use std::path::Path;
use std::time::Instant;

use clap::ValueEnum;
use serde::Serialize;
use voxdag::demo::{self, DemoView, studio};
use voxdag::shade::LightKind;

use crate::error::{Error, Result};
use crate::memory::Memory;
use crate::options::{
    ArithmeticArg, BuildArgs, CameraArgs, LightArg, LightingArgs, MachineArgs, NormalsArg, PictureArgs, ReportArgs,
    SupersampleArg,
};
use crate::output::Output;
use crate::picture::{self, Extras, Rays};
use crate::report::{self, Lines, grouped, time};
use crate::scene::{self, Bytes, Cost};
use crate::source::{self, Source};
use crate::stats::{self, ms};

/// Build and draw a scene that comes along, into voxdag-demo.png or voxdag-studio.png
#[derive(clap::Args)]
pub struct Args {
    /// Which one
    #[arg(value_enum, default_value_t)]
    scene: DemoScene,

    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// A scene that comes along.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum DemoScene {
    /// A columned hall: highlights alone; takes seconds
    #[default]
    Hall,
    /// A studio with mirrors, glass and several lights: all effects but textures; takes 20 s to a minute
    Studio,
}

impl DemoScene {
    /// The file that its picture goes to.
    fn picture(self) -> &'static str {
        match self {
            DemoScene::Hall => "voxdag-demo.png",
            DemoScene::Studio => "voxdag-studio.png",
        }
    }
}

/// What `demo --json` prints.
#[derive(Serialize)]
struct Report {
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
    rays: Rays,
    picture: &'static str,
}

#[derive(Serialize)]
struct Ms {
    parse: f64,
    voxelize: f64,
    reduce: f64,
    materials: f64,
    trace: f64,
    total: f64,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let elsewhere = |error: Error| error.hint("run it in a folder you may write to");
    let output = Output::create(Path::new(args.scene.picture()), "png").map_err(elsewhere)?;
    let pool = args.machine.pool()?;
    let mut memory = args.machine.memory();
    let source = source(args.scene, &mut memory)?;
    let building = BuildArgs { resolution: Some(demo::RESOLUTION), ..BuildArgs::default() };
    let built = pool.install(|| scene::build(&source, &building, &mut memory))?;
    memory.release(source.bytes);
    drop(source);
    let picture = pool.install(|| picture::draw(&built.shown(), &view(args.scene), Extras::default(), &memory))?;
    output.finish(|file| picture.write_png(file)).map_err(elsewhere)?;

    let Cost { parse, voxelize, reduce, materials } = built.cost;
    let report = Report {
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
            trace: ms(picture.derive + picture.trace),
            total: ms(start.elapsed()),
        },
        peak_rss_bytes: stats::peak_rss_bytes(),
        threads: pool.current_num_threads(),
        rays: picture.rays,
        picture: args.scene.picture(),
    };
    report::result(args.report.json, &report, &lines(&report))?;
    report::next("render your.obj -o your.png");
    Ok(())
}

/// The scene's mesh, as if it had been read; it is held.
pub fn source(scene: DemoScene, memory: &mut Memory) -> Result<Source> {
    let (text, library, library_name) = match scene {
        DemoScene::Hall => (demo::obj(), demo::mtl(), demo::MTL_NAME),
        DemoScene::Studio => (studio::obj(), studio::mtl(), studio::MTL_NAME),
    };
    let text_bytes = (text.len() + library.len()) as u64;
    source::afford_import(Path::new("demo"), text.as_bytes(), &memory.with(text_bytes))?;
    let source = source::import(Path::new("demo"), text.as_bytes(), |name| {
        (name == library_name).then(|| library.clone().into_bytes())
    })?;
    memory.hold(source.bytes);
    Ok(source)
}

/// The view that suits the scene, as if it had been typed.
pub fn view(scene: DemoScene) -> PictureArgs {
    let (view, size): (DemoView, _) = match scene {
        DemoScene::Hall => (demo::view(), [1280, 720]),
        DemoScene::Studio => (studio::view(), [1120, 630]),
    };
    // What is mirrored shows each normal's error twice, and has edges of its own.
    let (normals, supersample) = match scene {
        DemoScene::Hall => (NormalsArg::default(), None),
        DemoScene::Studio => (NormalsArg::Plane3, Some(SupersampleArg::Adaptive(2.0))),
    };
    let light = |position, color| LightArg { kind: LightKind::Point(position), color, shadow: false };
    PictureArgs {
        size,
        camera: CameraArgs {
            eye: Some(view.eye),
            target: Some(view.target),
            view_up: Some(view.up),
            fov: Some(view.fov_y),
        },
        lighting: LightingArgs {
            lights: view.lights.iter().map(|&(position, color)| light(position, color)).collect(),
            shadows: view.shadows,
            ambient: Some(view.ambient),
            ..LightingArgs::default()
        },
        normals,
        samples: None,
        supersample,
        arithmetic: ArithmeticArg::default(),
        effects: None,
        lift: None,
        lod: 0,
    }
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    let Ms { parse, trace, total, .. } = report.ms;
    let build = report.ms.voxelize + report.ms.reduce + report.ms.materials;
    lines
        .row("triangles", grouped(report.triangles as u64))
        .row("voxels", grouped(report.voxels))
        .row("nodes", report::sharing(report.octree_nodes + report.octree_bricks, report.nodes + report.bricks))
        .row("bytes", report.bytes.text())
        .row(
            "time",
            format!(
                "{} on {} threads: parse {}, build {}, draw {}",
                time(total),
                report.threads,
                time(parse),
                time(build),
                time(trace)
            ),
        )
        .row("memory", report::peak(report.peak_rss_bytes))
        .row("rays", report.rays.text())
        .row("picture", report.picture);
    lines
}
