//! `voxdag bench trace`: rays per second.

use serde::Serialize;
use voxdag::trace::{Arithmetic, Hit, Query};

use super::{Run, checksum, rays};
use crate::error::Result;
use crate::measure::{Arm, Times, measure};
use crate::picture::Shown;
use crate::report::{self, Lines, grouped};

/// What `bench trace --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    size: [u32; 2],
    repeat: u32,
    threads: u16,
    /// The first voxel along the rays of a picture.
    primary: Rate,
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
    /// Time of exact by time of f64 tracing of the primary rays.
    exact_to_f64: f64,
    /// Time of any-hit by time of nearest-hit tracing of the primary rays.
    any_to_nearest: f64,
    /// The primary rays' time measured twice: how far from 1 a ratio is by chance.
    noise: f64,
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
    let dag = scene.dag;
    let primary = rays::primary(run, scene)?;
    let found = rays::hits(scene, &primary)?;
    let (shadow, random) = (rays::shadow(scene, &found), rays::random(&found));

    let nearest = |rays, arithmetic| Arm::each(rays, move |q: &Query| fold(dag.trace_with(arithmetic, q)));
    let any = |rays| Arm::each(rays, move |q: &Query| u64::from(dag.occluded(q)));
    let [exact, again, f64, any_hit, shadowed, scattered] = measure(
        run.repeat,
        [
            nearest(&primary, Arithmetic::Exact),
            nearest(&primary, Arithmetic::Exact),
            nearest(&primary, Arithmetic::F64),
            any(&primary),
            any(&shadow),
            nearest(&random, Arithmetic::Exact),
        ],
    )?;

    let rounds: u64 = primary.iter().map(|q| u64::from(dag.trace_counted(Arithmetic::Exact, q).1)).sum();
    let hits_of = |rays: &[Query], hit: &dyn Fn(&Query) -> bool| rays.iter().filter(|q| hit(q)).count();
    let f64_hits = hits_of(&primary, &|q| dag.trace_with(Arithmetic::F64, q).is_some());
    let random_hits = hits_of(&random, &|q| dag.trace(q).is_some());
    let report = Report {
        resolution: scene.grid.resolution,
        size: run.size,
        repeat: run.repeat,
        threads: run.threads,
        primary: Rate::of(&exact, primary.len(), found.len()),
        primary_f64: Rate::of(&f64, primary.len(), f64_hits),
        primary_any: Rate::of(&any_hit, primary.len(), any_hit.checksum as usize),
        shadow: Rate::of(&shadowed, shadow.len(), shadowed.checksum as usize),
        random: Rate::of(&scattered, random.len(), random_hits),
        iterations_per_ray: rounds as f64 / primary.len() as f64,
        exact_to_f64: exact.ratio(&f64),
        any_to_nearest: any_hit.ratio(&exact),
        noise: again.ratio(&exact),
    };
    report::result(run.report.json, &report, &lines(&report))
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    lines
        .row("resolution", format!("{} voxels along the longest axis", grouped(report.resolution.into())))
        .row("primary", report.primary.text())
        .row("  by f64 alone", report.primary_f64.text())
        .row("  any hit", report.primary_any.text())
        .row("shadow", report.shadow.text())
        .row("random", report.random.text())
        .row("iterations", format!("{:6.2} per primary ray", report.iterations_per_ray))
        .row("exact to f64", format!("{:6.3} of the time", report.exact_to_f64))
        .row("any to nearest", format!("{:6.3} of the time", report.any_to_nearest))
        .row("noise", format!("{:6.3}: the primary rays' time, measured twice", report.noise));
    lines
}
