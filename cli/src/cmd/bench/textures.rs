//! `voxdag bench textures`: what the colours of a mesh's textures take and lose, as blocks and as they are.

use serde::Serialize;
use voxdag::colors::{ColorMode, Colored, Colors};
use voxdag::rank::{AnyRank, Prefix};
use voxdag::scene::{Build, MaterialMode};
use voxdag::{Dag, Materials, Morton};

use super::{Cost, Run, rays};
use crate::error::{Error, Kind, Result};
use crate::measure::{Arm, Spread, Times, measure};
use crate::report::{self, Lines, grouped};
use crate::scene;
use crate::source::Source;
use crate::voxelize;

/// What `bench textures --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    voxels: u64,
    /// Voxels whose material has a texture.
    textured: u64,
    repeat: u32,
    threads: u16,
    /// Owners of voxels without their colours, and with them; for all voxels.
    owners_ms: f64,
    colors_ms: f64,
    /// Bytes of the counts of ranks, which both ways look colours up by.
    rank_bytes: u64,
    blocks: Kept,
    raw: Kept,
    /// Of blocks against the colours as they are, of textured voxels.
    psnr: f64,
    /// The largest difference of a channel, in steps of a byte.
    worst: u8,
}

#[derive(Serialize)]
struct Kept {
    bytes: u64,
    /// Of all voxels.
    bits_per_voxel: f64,
    /// Making them of the colours.
    ms: f64,
    /// A colour of a voxel that a picture shows, its rank included.
    look_up: Cost,
}

/// Runs the command.
pub fn run(run: &Run, source: &Source) -> Result<()> {
    let defect = |error: &dyn std::fmt::Display| Error::new(Kind::Failure, error);
    // Built once as `build` does it: every complaint about mesh and flags comes from there.
    let built = scene::build(source, &run.build, &mut run.machine().memory())?;
    let (grid, voxels, shown) = (built.grid, built.stats.voxels, built.shown());
    if shown.colors.is_none() {
        return Err(Error::usage("no voxel has a texture: there is nothing to measure")
            .hint("name a mesh whose materials have map_Kd, and whose faces have texture coordinates"));
    }
    let hits: Vec<_> = rays::seen(run, &shown)?.iter().map(|found| found.hit.voxel).collect();

    // The same voxels again, and their colours in both ways.
    let (mesh, options) = (source.model.mesh(), voxelize::options(&run.build, MaterialMode::Tree, None));
    let plain = Build::new(&mesh, &grid, &options).map_err(|e| defect(&e))?;
    let painted = Build::new(&mesh, &grid, &options).map_err(|e| defect(&e))?.with_textures(&source.model.textures);
    let mut join = painted.join().map_err(|e| defect(&e))?;
    for part in 0..painted.parts() {
        painted.part(part).and_then(|part| join.add(part)).map_err(|e| defect(&e))?;
    }
    let (dag, pending) = join.finish().map_err(|e| defect(&e))?;
    let dag = dag.dag();
    let counts = Prefix::build(&dag).map_err(|e| defect(&e))?;
    let rank = AnyRank::Prefix(Prefix::new(dag, &counts).map_err(|e| defect(&e))?);
    let made = |mode| pending.colors(&dag, mode).map(|colors| colors.map_or(0, |c| c.as_colors().words().len() as u64));
    let kept = |mode| pending.colors(&dag, mode).map_err(|e| defect(&e));
    let (blocks, raw) = (kept(ColorMode::Blocks)?, kept(ColorMode::Raw)?);
    let [Some(blocks), Some(raw)] = [&blocks, &raw] else {
        return Err(Error::new(Kind::Failure, "the colours were there and are gone: this is a defect of voxdag"));
    };
    let (blocks, raw) = (blocks.as_colors(), raw.as_colors());

    let part = |build: &Build<'_>, i| u64::from(build.part(i).is_ok());
    let fit = |mode| Arm::pieces(1, move |_| made(mode).unwrap_or(0));
    let of = |colors| {
        let colored = Colored::new(rank, colors).ok();
        let color = move |v: &Morton| colored.and_then(|c| c.color(*v)).map_or(0, |[r, ..]| r.into());
        Arm::each(&hits, color)
    };
    let [owners, colors, fit_blocks, fit_raw, from_blocks, from_raw] = measure(
        run.repeat,
        [
            Arm::pieces(plain.parts(), |i| part(&plain, i)),
            Arm::pieces(painted.parts(), |i| part(&painted, i)),
            fit(ColorMode::Blocks),
            fit(ColorMode::Raw),
            of(blocks),
            of(raw),
        ],
    )?;

    let ms = |times: &Times| 1e3 * Spread::of(times.seconds.iter().copied()).median;
    let kept = |colors: Colors<'_>, fit: &Times, look_up: &Times| {
        let bytes = size_of_val(colors.words()) as u64;
        let bits_per_voxel = 8.0 * bytes as f64 / voxels.max(1) as f64;
        Kept { bytes, bits_per_voxel, ms: ms(fit), look_up: Cost::of(look_up, hits.len()) }
    };
    let looks = shown.looks();
    let textured = |voxel| shown.palette.get(usize::from(looks.id(voxel))).is_some_and(|m| m.textured);
    let (count, squares, worst) = differences(dag, blocks, raw, textured);
    report(
        run,
        Report {
            resolution: grid.resolution,
            voxels,
            textured: count,
            repeat: run.repeat,
            threads: run.threads,
            owners_ms: ms(&owners),
            colors_ms: ms(&colors),
            rank_bytes: size_of_val(&counts[..]) as u64,
            blocks: kept(blocks, &fit_blocks, &from_blocks),
            raw: kept(raw, &fit_raw, &from_raw),
            psnr: 10.0 * libm::log10(255.0 * 255.0 * 3.0 * count as f64 / squares as f64),
            worst,
        },
    )
}

/// Textured voxels, the sum of the squares by which the channels of their colours differ, and the largest difference.
fn differences(dag: Dag<'_>, blocks: Colors<'_>, raw: Colors<'_>, textured: impl Fn(Morton) -> bool) -> (u64, u64, u8) {
    let (mut count, mut squares, mut worst) = (0, 0, 0);
    for (rank, _) in (0..).zip(dag.voxels()).filter(|(_, voxel)| textured(*voxel)) {
        count += 1;
        for (a, b) in blocks.get(rank).into_iter().zip(raw.get(rank)) {
            let off = a.abs_diff(b);
            worst = worst.max(off);
            squares += u64::from(off) * u64::from(off);
        }
    }
    (count, squares, worst)
}

fn report(run: &Run, report: Report) -> Result<()> {
    let mut lines = Lines::default();
    let Report { voxels, textured, owners_ms, colors_ms, rank_bytes, ref blocks, ref raw, .. } = report;
    let share = 100.0 * textured as f64 / voxels.max(1) as f64;
    lines
        .row("resolution", report.resolution.to_string())
        .row("voxels", format!("{}, {} of them textured ({share:.1} %)", grouped(voxels), grouped(textured)))
        .row("owners of voxels", format!("{owners_ms:8.1} ms"))
        .row("with their colors", format!("{colors_ms:8.1} ms"));
    for (name, kept) in [("blocks", blocks), ("raw", raw)] {
        let Kept { bytes, bits_per_voxel, ms, ref look_up } = *kept;
        lines
            .row(name, format!("{} bytes, {bits_per_voxel:.3} bits per voxel, made in {ms:.1} ms", grouped(bytes)))
            .row("  look-up", look_up.text());
    }
    lines.row("counts of ranks", format!("{} bytes", grouped(rank_bytes)));
    lines.row("PSNR of blocks", format!("{:.2} dB; at most {} of 255 off", report.psnr, report.worst));
    report::result(run.report.json, &report, &lines)
}
