//! Wrong voxels: what the rounding methods of voxelising and of tracing cost and get wrong, beside the exact ones, which
//! are checked against the integer oracles in turn.

use rayon::prelude::*;
use serde::Serialize;
use voxdag::camera::Camera;
use voxdag::geometry::Geometry;
use voxdag::render::Samples;
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::{Grid, Mesh, Morton};
use voxdag_oracle::ray;

use crate::error::{Error, Kind, Result};
use crate::measure::Spread;
use crate::memory::Memory;
use crate::overlap::{self, Brick, Near};
use crate::stats;

/// A method beside what is right.
#[derive(Clone, Copy, Serialize)]
pub struct Wrong {
    /// What it is called.
    pub method: &'static str,
    /// What it was compared with.
    pub against: &'static str,
    /// Milliseconds, the median of the repetitions.
    pub ms: f64,
    /// Voxels or rays that were compared.
    pub compared: u64,
    /// Voxels that are not filled but should be, or rays that miss.
    pub missing: u64,
    /// Voxels that are filled but should not be, or rays that hit another voxel, or one where there is none.
    pub extra: u64,
}

/// Bricks, and rays, that the oracles are asked about: they take up to a millisecond each.
const BRICKS: usize = 128;
const RAYS: usize = 2000;

const EXACT: &str = "the exact method";
const ORACLE: &str = "the integer oracle";

/// Methods of voxelising: by f32, by f64 and exactly, from the triangles to the bricks of a grid, without materials.
pub fn voxelizing(mesh: &Mesh<'_>, grid: &Grid, repeat: u32, memory: &Memory) -> Result<[Wrong; 3]> {
    memory.afford(overlap::bytes(mesh, grid), "the textbook's overlap test", overlap::HINT)?;
    let exactly = || overlap::exact(mesh, grid).map_err(|error| Error::new(Kind::Failure, error));
    let by = |test: fn(&Near) -> u64| overlap::bricks(&overlap::near(mesh, grid), test);
    let (mut exact, mut found) = (Vec::new(), [const { Vec::new() }; 2]);
    let mut ms = [const { Vec::new() }; 3];
    for _ in 0..repeat {
        for (i, test) in [Near::f32, Near::f64].into_iter().enumerate() {
            let (bricks, time) = stats::timed(|| by(test));
            found[i] = bricks;
            ms[i].push(stats::ms(time));
        }
        let (bricks, time) = stats::timed(exactly);
        exact = bricks?;
        ms[2].push(stats::ms(time));
    }
    let [f32_ms, f64_ms, exact_ms] = ms.map(|ms| Spread::of(ms).median);
    let voxels = exact.iter().map(|brick| u64::from(brick.1.count_ones())).sum();
    let beside = |method, ms, found: &[Brick]| {
        let [missing, extra] = overlap::differing(&exact, found);
        Wrong { method, against: EXACT, ms, compared: voxels, missing, extra }
    };

    // The oracle judges bricks all over the scene by all triangles near them.
    let mut near = overlap::near(mesh, grid);
    near.sort_unstable_by_key(Near::code);
    let groups: Vec<_> = near.chunk_by(|a, b| a.brick == b.brick).collect();
    let asked: Vec<_> = groups.iter().step_by(groups.len().div_ceil(BRICKS).max(1)).copied().collect();
    let truth = overlap::bricks(&asked.concat(), Near::oracle);
    let is_asked = |brick: &&Brick| asked.binary_search_by_key(&brick.0, |group| group[0].code()).is_ok();
    let ours: Vec<_> = exact.iter().filter(is_asked).copied().collect();
    let [missing, extra] = overlap::differing(&truth, &ours);
    let compared = 64 * asked.len() as u64;
    Ok([
        beside("f32 overlap", f32_ms, &found[0]),
        beside("f64 overlap", f64_ms, &found[1]),
        Wrong { method: "exact overlap", against: ORACLE, ms: exact_ms, compared, missing, extra },
    ])
}

/// Methods of tracing: by f32, by f64 and exactly, four rays a pixel as `render` takes them.
pub fn tracing<G: Geometry>(
    tracer: &Tracer<'_, G>,
    grid: &Grid,
    camera: &Camera,
    [width, height]: [u32; 2],
    repeat: u32,
    memory: &Memory,
) -> Result<[Wrong; 3]> {
    // Four rays: where each starts, what three methods found, and the two together for the oracle.
    let bytes = 4 * 5 * 16 * u64::from(width) * u64::from(height);
    memory.afford(bytes, "counting rays that are wrong", "make --size smaller or --memory-limit larger")?;
    let rays = camera.rays(width, height).map_err(Error::usage)?;
    let eye = grid.to_grid(camera.eye);
    let places = |y: u32| -> Vec<[f64; 2]> {
        let samples = (0..Samples::Four.count()).map(|i| Samples::Four.position(i));
        let samples: Vec<_> = samples.collect();
        (0..width).flat_map(|x| samples.iter().map(move |[u, v]| [f64::from(x) + u, f64::from(y) + v])).collect()
    };
    let rows: Vec<_> = (0..height).map(places).collect();
    let by = |arithmetic| -> Vec<Vec<Option<Morton>>> {
        let row = |places: &Vec<[f64; 2]>| {
            let mut hits = vec![None; places.len()];
            tracer.trace_tile(arithmetic, &rays.tile(eye, places), &mut hits);
            hits.into_iter().map(|hit| hit.map(|hit| hit.voxel)).collect()
        };
        rows.par_iter().map(row).collect()
    };
    const METHODS: [Arithmetic; 3] = [Arithmetic::F32, Arithmetic::F64, Arithmetic::Exact];
    let mut found = [const { Vec::new() }; 3];
    let mut ms = [const { Vec::new() }; 3];
    for _ in 0..repeat {
        for (i, arithmetic) in METHODS.into_iter().enumerate() {
            let (voxels, time) = stats::timed(|| by(arithmetic));
            found[i] = voxels;
            ms[i].push(stats::ms(time));
        }
    }
    let [f32_ms, f64_ms, exact_ms] = ms.map(|ms| Spread::of(ms).median);
    let exact = &found[2];
    let beside = |method, ms, found: &[Vec<Option<Morton>>]| {
        let pairs = || exact.iter().flatten().zip(found.iter().flatten());
        let missing = pairs().filter(|(truth, found)| truth.is_some() && found.is_none()).count() as u64;
        let extra = pairs().filter(|(truth, found)| found.is_some() && truth != found).count() as u64;
        Wrong { method, against: EXACT, ms, compared: pairs().count() as u64, missing, extra }
    };

    // The oracle judges rays all over the picture.
    let (geometry, depth) = (tracer.geometry(), tracer.geometry().depth());
    let filled = |level: u8, corner: [u32; 3]| {
        Morton::encode(corner).is_some_and(|voxel| geometry.empty_level(voxel).is_none_or(|empty| empty < level))
    };
    let all: Vec<_> = rows.iter().flatten().zip(exact.iter().flatten()).collect();
    let asked: Vec<_> = all.iter().step_by(all.len().div_ceil(RAYS).max(1)).collect();
    let judged: Vec<[u64; 2]> = asked
        .par_iter()
        .map(|&&(&[x, y], &found)| {
            let query = Query::new(eye, rays.direction(x, y));
            let truth = ray::first(&ray::Ray::new(query.origin, query.dir), depth, 0, &filled);
            let truth = truth.and_then(|hit| Morton::encode(hit.voxel));
            [u64::from(truth.is_some() && found.is_none()), u64::from(found.is_some() && truth != found)]
        })
        .collect();
    let sum = |i: usize| judged.iter().map(|wrong| wrong[i]).sum();
    Ok([
        beside("f32 rays", f32_ms, &found[0]),
        beside("f64 rays", f64_ms, &found[1]),
        Wrong {
            method: "exact rays",
            against: ORACLE,
            ms: exact_ms,
            compared: asked.len() as u64,
            missing: sum(0),
            extra: sum(1),
        },
    ])
}
