//! `voxdag bench trace`: rays per second.

use clap::builder::PossibleValuesParser;
use serde::Serialize;
use voxdag::simd::Level;
use voxdag::trace::{Arithmetic, Hit, Steps, Top, Tracer};
use voxdag::{Geometry, match_geometry, trees};

use super::packets::{self, Tiles};
use super::{Run, checksum, rays};
use crate::error::Result;
use crate::measure::{Arm, Times, measure};
use crate::picture::{self, Shown};
use crate::report::{self, Lines, grouped, size};

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub run: Run,

    /// Vector instructions by which many rays are traced at once; this machine has those below [default: the widest]
    #[arg(long, value_name = "SET", value_parser = PossibleValuesParser::new(levels()), help_heading = "Machine")]
    level: Option<String>,
}

/// Rays that are traced one by one.
const SCALAR: &str = "scalar";

/// What `--level` can be, from the narrowest to the widest.
fn levels() -> impl Iterator<Item = &'static str> {
    std::iter::once(SCALAR).chain(Level::all().map(Level::name))
}

impl Args {
    fn level(&self) -> Option<Level> {
        match &self.level {
            Some(name) => Level::all().find(|level| level.name() == name),
            None => Level::best(),
        }
    }
}

/// What `bench trace --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    size: [u32; 2],
    repeat: u32,
    threads: u16,
    /// What many rays at once are traced by; `scalar` where they are traced one by one.
    level: &'static str,
    /// The first voxel along the rays of a picture, tile by tile.
    primary: Rate,
    /// The same rays by f32 alone; `None` where rays are traced one by one.
    primary_f32: Option<Preview>,
    /// The same rays, one by one.
    primary_one: Rate,
    /// The same without the top grid.
    primary_no_top: Rate,
    /// The same by rounded f64 alone.
    primary_f64: Rate,
    /// The same, only whether they hit.
    primary_any: Rate,
    /// Whether the way from a hit to the light is blocked.
    shadow: Rate,
    /// The same, one by one.
    shadow_one: Rate,
    /// The first voxel along random directions from the hits.
    random: Rate,
    /// The same, one by one.
    random_one: Rate,
    /// Rounds of the tracer's loop per primary ray, one by one.
    iterations_per_ray: f64,
    /// The same without the top grid.
    iterations_per_ray_no_top: f64,
    /// Rounds per primary ray that f64 could not decide, so that exact arithmetic did.
    close_per_ray: f64,
    /// Time of exact by time of f64 tracing of the primary rays, one by one.
    exact_to_f64: f64,
    /// Time of any-hit by time of nearest-hit tracing of the primary rays, one by one.
    any_to_nearest: f64,
    /// The primary rays' time measured twice: how far from 1 a ratio is by chance.
    noise: f64,
    /// That of rays one by one.
    top_grid: TopGrid,
    /// What many rays at once are traced over.
    wide_tree: Option<WideTree>,
}

/// The top grid, and what it takes to make.
#[derive(Serialize)]
struct TopGrid {
    /// Along an axis.
    cells: u32,
    bytes: usize,
    ms: f64,
}

/// The wide tree, and what it takes to make.
#[derive(Serialize)]
struct WideTree {
    bytes: usize,
    ms: f64,
}

/// Rays that may miss what they are to hit.
#[derive(Serialize)]
struct Preview {
    #[serde(flatten)]
    rate: Rate,
    /// Share of the rays that meet another voxel than by exact arithmetic, or none where that does, or one where that
    /// does not.
    differing_fraction: f64,
}

/// Rays of one kind.
#[derive(Serialize)]
struct Rate {
    rays: usize,
    /// Share of the rays that meet a voxel.
    hit_fraction: f64,
    /// Per core.
    mrays_per_s: f64,
    mrays_per_s_min: f64,
    mrays_per_s_max: f64,
    checksum: String,
}

impl Rate {
    fn of(times: &Times, rays: usize, hits: usize) -> Rate {
        let rate = times.millions_per_second(rays as u64);
        Rate {
            rays,
            hit_fraction: if rays == 0 { 0.0 } else { hits as f64 / rays as f64 },
            mrays_per_s: rate.median,
            mrays_per_s_min: rate.min,
            mrays_per_s_max: rate.max,
            checksum: checksum(times),
        }
    }

    /// For people.
    fn text(&self) -> String {
        format!(
            "{:6.2} Mrays/s ({:.2} to {:.2}), {:6.2} % of {} hit",
            self.mrays_per_s,
            self.mrays_per_s_min,
            self.mrays_per_s_max,
            100.0 * self.hit_fraction,
            grouped(self.rays as u64)
        )
    }
}

/// What a hit adds to the checksum: where and when.
fn fold(hit: Option<Hit>) -> u64 {
    hit.map_or(1, |hit| hit.voxel.0 ^ hit.t.to_bits())
}

/// What it adds to the number of hits.
fn is_hit(hit: Option<Hit>) -> u64 {
    hit.is_some().into()
}

/// Runs the command.
pub fn run(args: &Args, scene: &Shown<'_>) -> Result<()> {
    match_geometry!(scene.geometry, geometry => with(args, scene, geometry))
}

/// Makes what many rays at once are traced over.
fn with<G: Geometry>(args: &Args, scene: &Shown<'_>, geometry: G) -> Result<()> {
    let top = rays::top_grid(geometry)?;
    let one = rays::tracer(geometry, &top)?;
    let Some((level, wide)) = args.level().and_then(|level| Some((level, trees::wide(&geometry, None)?))) else {
        return compare(&args.run, scene, &one, &one);
    };
    let top = trees::top_within(&wide.as_wide(), rays::TOP_BITS, None);
    compare(&args.run, scene, &one, &trees::tracer(wide.as_wide(), top.as_ref()).with_level(Some(level)))
}

/// Traces rays one by one, and many at once.
fn compare<G: Geometry, W: Geometry>(
    run: &Run,
    scene: &Shown<'_>,
    one: &Tracer<'_, G>,
    many: &Tracer<'_, W>,
) -> Result<()> {
    let geometry = one.geometry();
    let plain = Tracer::new(geometry);
    let tiles = Tiles::new(scene, &run.camera, run.size)?;
    let primary = picture::primary(scene, &run.camera, run.size)?;
    let found = rays::hits(one, &primary)?;
    let (shadow, random) = (rays::shadow(scene, &found), rays::random(&found));

    let each = |tracer, arithmetic, rays, of: fn(_) -> u64| {
        Arm::each(rays, move |ray| of(Tracer::trace(&tracer, arithmetic, ray)))
    };
    let each_any = |rays| Arm::each(rays, move |ray| u64::from(one.occluded(Arithmetic::Exact, ray)));
    let is_wide = many.geometry().wide_words().is_some();
    let [
        tiled,
        again,
        tiled_f32,
        exact,
        no_top,
        f64,
        any_hit,
        many_shadow,
        each_shadow,
        many_random,
        each_random,
        grid,
        tree,
    ] = measure(
        run.repeat,
        [
            tiles.nearest(many, Arithmetic::Exact, fold),
            tiles.nearest(many, Arithmetic::Exact, fold),
            tiles.nearest(many, Arithmetic::F32, fold),
            each(*one, Arithmetic::Exact, &primary, fold),
            each(plain, Arithmetic::Exact, &primary, fold),
            each(*one, Arithmetic::F64, &primary, fold),
            each_any(&primary),
            packets::any(many, &shadow),
            each_any(&shadow),
            packets::nearest(many, &random, fold),
            each(*one, Arithmetic::Exact, &random, fold),
            Arm::pieces(1, |_| rays::top_grid(geometry).is_ok().into()),
            Arm::pieces(is_wide.into(), |_| trees::wide(&geometry, None).is_some().into()),
        ],
    )?;

    // Hits are counted apart from the time.
    let rate = |times, arm: Arm<'_>| Rate::of(times, arm.items(), arm.sum() as usize);
    let rate_of_pixels = |times, arm: Arm<'_>| Rate::of(times, primary.len(), arm.sum() as usize);
    let per_ray = |tracer: Tracer<'_, G>, of: fn(Steps) -> u32| {
        let all: u64 = primary.iter().map(|q| u64::from(of(tracer.trace_counted(Arithmetic::Exact, q).1))).sum();
        all as f64 / primary.len() as f64
    };
    let bits = rays::TOP_BITS.min(Top::most_bits(&geometry));
    let preview = || Preview {
        rate: rate_of_pixels(&tiled_f32, tiles.nearest(many, Arithmetic::F32, is_hit)),
        differing_fraction: tiles.differing(many, Arithmetic::F32) as f64 / primary.len() as f64,
    };
    let report = Report {
        resolution: scene.grid.resolution,
        size: run.size,
        repeat: run.repeat,
        threads: run.threads,
        level: many.packet_level().map_or(SCALAR, Level::name),
        primary: rate_of_pixels(&tiled, tiles.nearest(many, Arithmetic::Exact, is_hit)),
        primary_f32: many.packet_level().map(|_| preview()),
        primary_one: rate(&exact, each(*one, Arithmetic::Exact, &primary, is_hit)),
        primary_no_top: rate(&no_top, each(plain, Arithmetic::Exact, &primary, is_hit)),
        primary_f64: rate(&f64, each(*one, Arithmetic::F64, &primary, is_hit)),
        primary_any: rate(&any_hit, each_any(&primary)),
        shadow: rate(&many_shadow, packets::any(many, &shadow)),
        shadow_one: rate(&each_shadow, each_any(&shadow)),
        random: rate(&many_random, packets::nearest(many, &random, is_hit)),
        random_one: rate(&each_random, each(*one, Arithmetic::Exact, &random, is_hit)),
        iterations_per_ray: per_ray(*one, |steps| steps.rounds),
        iterations_per_ray_no_top: per_ray(plain, |steps| steps.rounds),
        close_per_ray: per_ray(*one, |steps| steps.close),
        exact_to_f64: exact.ratio(&f64),
        any_to_nearest: any_hit.ratio(&exact),
        noise: again.ratio(&tiled),
        top_grid: TopGrid { cells: 1 << bits, bytes: 4 * Top::words_for(bits), ms: grid.ns(1).median / 1e6 },
        wide_tree: many
            .geometry()
            .wide_words()
            .map(|words| WideTree { bytes: size_of_val(words), ms: tree.ns(1).median / 1e6 }),
    };
    report::result(run.report.json, &report, &lines(&report))
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    lines
        .row("resolution", format!("{} voxels along the longest axis", grouped(report.resolution.into())))
        .row("level", report.level)
        .row("primary", report.primary.text());
    if let Some(preview) = &report.primary_f32 {
        let differing = format!("{:.4} % otherwise than exact", 100.0 * preview.differing_fraction);
        lines.row("  by f32 alone", format!("{}, {differing}", preview.rate.text()));
    }
    lines
        .row("  one by one", report.primary_one.text())
        .row("    without top grid", report.primary_no_top.text())
        .row("    by f64 alone", report.primary_f64.text())
        .row("    any hit", report.primary_any.text())
        .row("shadow", report.shadow.text())
        .row("  one by one", report.shadow_one.text())
        .row("random", report.random.text())
        .row("  one by one", report.random_one.text())
        .row(
            "iterations",
            format!(
                "{:6.2} per primary ray, {:.2} without top grid",
                report.iterations_per_ray, report.iterations_per_ray_no_top
            ),
        )
        .row("too close for f64", format!("{:6.4} iterations per primary ray", report.close_per_ray))
        .row("exact to f64", format!("{:6.3} of the time", report.exact_to_f64))
        .row("any to nearest", format!("{:6.3} of the time", report.any_to_nearest))
        .row("noise", format!("{:6.3}: the primary rays' time, measured twice", report.noise))
        .row(
            "top grid",
            format!(
                "{:6.1} ms to make, {}^3 cells, {}",
                report.top_grid.ms,
                report.top_grid.cells,
                size(report.top_grid.bytes as u64)
            ),
        );
    if let Some(tree) = &report.wide_tree {
        lines.row("wide tree", format!("{:6.1} ms to make, {}", tree.ms, size(tree.bytes as u64)));
    }
    lines
}
