//! `voxdag bench trace`: rays per second.

use serde::Serialize;
use voxdag::trace::{Arithmetic, Hit, Query, Steps, Top, Tracer};
use voxdag::{Geometry, match_geometry};

use super::{Run, checksum, rays};
use crate::error::Result;
use crate::measure::{Arm, Times, measure};
use crate::picture::{self, Shown};
use crate::report::{self, Lines, grouped, size};

/// What `bench trace --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    size: [u32; 2],
    repeat: u32,
    threads: u16,
    /// The first voxel along the rays of a picture.
    primary: Rate,
    /// The same rays without the top grid.
    primary_no_top: Rate,
    /// The same rays by rounded f64 alone.
    primary_f64: Rate,
    /// The same rays, only whether they hit.
    primary_any: Rate,
    /// Whether the way from a hit to the light is blocked.
    shadow: Rate,
    /// The first voxel along random directions from the hits.
    random: Rate,
    /// Rounds of the tracer's loop per primary ray.
    iterations_per_ray: f64,
    /// The same without the top grid.
    iterations_per_ray_no_top: f64,
    /// Rounds per primary ray that f64 could not decide, so that exact arithmetic did.
    close_per_ray: f64,
    /// Time of exact by time of f64 tracing of the primary rays.
    exact_to_f64: f64,
    /// Time of any-hit by time of nearest-hit tracing of the primary rays.
    any_to_nearest: f64,
    /// The primary rays' time measured twice: how far from 1 a ratio is by chance.
    noise: f64,
    top_grid: TopGrid,
}

/// The top grid, and what it takes to make.
#[derive(Serialize)]
struct TopGrid {
    /// Along an axis.
    cells: u32,
    bytes: usize,
    ms: f64,
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

/// Runs the command.
pub fn run(run: &Run, scene: &Shown<'_>) -> Result<()> {
    match_geometry!(scene.geometry, geometry => with(run, scene, geometry))
}

fn with<G: Geometry>(run: &Run, scene: &Shown<'_>, geometry: G) -> Result<()> {
    let plain = Tracer::new(geometry);
    let top = rays::top_grid(geometry)?;
    let tracer = rays::tracer(geometry, &top)?;
    let primary = picture::primary(scene, &run.camera, run.size)?;
    let found = rays::hits(&tracer, &primary)?;
    let (shadow, random) = (rays::shadow(scene, &found), rays::random(&found));

    let nearest = |tracer, arithmetic, rays| Arm::each(rays, move |q| fold(Tracer::trace(&tracer, arithmetic, q)));
    let any = |rays| Arm::each(rays, move |q| u64::from(tracer.occluded(Arithmetic::Exact, q)));
    let [exact, again, no_top, f64, any_hit, shadowed, scattered, made] = measure(
        run.repeat,
        [
            nearest(tracer, Arithmetic::Exact, &primary),
            nearest(tracer, Arithmetic::Exact, &primary),
            nearest(plain, Arithmetic::Exact, &primary),
            nearest(tracer, Arithmetic::F64, &primary),
            any(&primary),
            any(&shadow),
            nearest(tracer, Arithmetic::Exact, &random),
            Arm::pieces(1, |_| rays::top_grid(geometry).is_ok().into()),
        ],
    )?;

    let hits = |rays: &[Query], arithmetic| rays.iter().filter(|q| tracer.trace(arithmetic, q).is_some()).count();
    let per_ray = |tracer: Tracer<'_, G>, of: fn(Steps) -> u32| {
        let all: u64 = primary.iter().map(|q| u64::from(of(tracer.trace_counted(Arithmetic::Exact, q).1))).sum();
        all as f64 / primary.len() as f64
    };
    let all = primary.len();
    let bits = rays::TOP_BITS.min(Top::most_bits(&geometry));
    let report = Report {
        resolution: scene.grid.resolution,
        size: run.size,
        repeat: run.repeat,
        threads: run.threads,
        primary: Rate::of(&exact, all, hits(&primary, Arithmetic::Exact)),
        primary_no_top: Rate::of(
            &no_top,
            all,
            primary.iter().filter(|q| plain.trace(Arithmetic::Exact, q).is_some()).count(),
        ),
        primary_f64: Rate::of(&f64, all, hits(&primary, Arithmetic::F64)),
        primary_any: Rate::of(&any_hit, all, any_hit.checksum as usize),
        shadow: Rate::of(&shadowed, shadow.len(), shadowed.checksum as usize),
        random: Rate::of(&scattered, random.len(), hits(&random, Arithmetic::Exact)),
        iterations_per_ray: per_ray(tracer, |steps| steps.rounds),
        iterations_per_ray_no_top: per_ray(plain, |steps| steps.rounds),
        close_per_ray: per_ray(tracer, |steps| steps.close),
        exact_to_f64: exact.ratio(&f64),
        any_to_nearest: any_hit.ratio(&exact),
        noise: again.ratio(&exact),
        top_grid: TopGrid { cells: 1 << bits, bytes: 4 * Top::words_for(bits), ms: made.ns(1).median / 1e6 },
    };
    report::result(run.report.json, &report, &lines(&report))
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    lines
        .row("resolution", format!("{} voxels along the longest axis", grouped(report.resolution.into())))
        .row("primary", report.primary.text())
        .row("  without top grid", report.primary_no_top.text())
        .row("  by f64 alone", report.primary_f64.text())
        .row("  any hit", report.primary_any.text())
        .row("shadow", report.shadow.text())
        .row("random", report.random.text())
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
    lines
}
