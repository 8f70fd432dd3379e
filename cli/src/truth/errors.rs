//! How far the shape of voxels is off, pixel by pixel: one ray through each pixel's centre, by the camera of the picture.
//!
//! In: what the rays meet in truth ([`look`](super::look)), and the voxels. Out: pixels that show something where there is
//! nothing or nothing where there is something; and of those that show something in both, how far its distance and its
//! direction are off. Where a silhouette lets one ray pass another surface is seen, far behind: that counts as what it is,
//! so the largest depth error tells of silhouettes and the mean and the 95 % of surfaces.

use serde::Serialize;
use voxdag::camera::{Camera, Rays};
use voxdag::geometry::Geometry;
use voxdag::math;
use voxdag::normal::{self, NormalKind};
use voxdag::render::Counters;
use voxdag::trace::{Arithmetic, Hit, Tile, Tracer};

use super::Met;
use crate::error::{Error, Result};
use crate::memory::Memory;
use crate::picture::{Shown, in_bands, room};
use crate::trees::{Trees, with_tracer};

/// How a set of deviations spreads.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Deviations {
    pub mean: f64,
    /// 95 % of them are at most this.
    pub p95: f64,
    pub max: f64,
}

/// How far a picture's shapes are off.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct ShapeErrors {
    /// Pixels of which one shows a surface and the other nothing.
    pub silhouette: u64,
    /// Pixels that show a surface in both; the rest is about these.
    pub both: u64,
    /// Between the surfaces along the ray, in voxels; `None` where no pixel shows both.
    pub depth: Option<Deviations>,
    /// Between the normals, in degrees.
    pub normal: Option<Deviations>,
}

/// What a pixel shows of the voxels: the distance in units of the camera's direction, in the world, and the normal.
type Seen = Option<(f64, [f32; 3])>;

/// Compares what `truth` says of each pixel with what voxels show by this kind of normals and arithmetic.
pub fn shape_errors(
    truth: &[Option<Met>],
    (shown, trees): (&Shown<'_>, &Trees),
    camera: &Camera,
    size: [u32; 2],
    (kind, arithmetic): (NormalKind, Arithmetic),
    memory: &Memory,
) -> Result<ShapeErrors> {
    let mut seen: Vec<Seen> = room(size, (size_of::<Seen>() + 2 * size_of::<f64>()) as u64, memory)?;
    let rays = camera.rays(size[0], size[1]).map_err(Error::usage)?;
    let eye = shown.grid.to_grid(camera.eye);
    with_tracer!(shown.geometry, trees, tracer => in_bands("comparing", size, &mut seen, |rows, out| {
        for (y, row) in rows.zip(out.chunks_exact_mut(size[0] as usize)) {
            for (piece, out) in row.chunks_mut(PIECE).enumerate() {
                let x = |i: usize| (piece * PIECE + i) as f64 + 0.5;
                let places: [_; PIECE] = core::array::from_fn(|i| [x(i), f64::from(y) + 0.5]);
                let rays = rays.tile(eye, &places[..out.len()]);
                see(&tracer, shown, &rays, (kind, arithmetic), out);
            }
        }
        Ok(Counters::default())
    })?);
    Ok(compare(truth, &seen, &rays, size, shown.grid.voxel_size))
}

/// Rays that are traced together.
const PIECE: usize = 64;

/// What at most [`PIECE`] rays show.
fn see<G: Geometry>(
    tracer: &Tracer<'_, G>,
    shown: &Shown<'_>,
    rays: &Tile<'_>,
    (kind, arithmetic): (NormalKind, Arithmetic),
    out: &mut [Seen],
) {
    let mut hits = [None; PIECE];
    tracer.trace_tile(arithmetic, rays, &mut hits);
    for ((place, hit), out) in rays.places.iter().zip(hits).zip(out) {
        *out = hit.map(|hit: Hit| {
            let normal = normal::normal(tracer, shown.looks(), &hit, rays.direction(*place), kind);
            (hit.t * shown.grid.voxel_size, normal.direction)
        });
    }
}

/// Compares what pixels show.
fn compare(truth: &[Option<Met>], seen: &[Seen], rays: &Rays, size: [u32; 2], voxel_size: f64) -> ShapeErrors {
    let (mut silhouette, mut depth, mut normal) = (0, Vec::new(), Vec::new());
    let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y].map(|k| f64::from(k) + 0.5)));
    for ((met, seen), [x, y]) in truth.iter().zip(seen).zip(places) {
        match (met, seen) {
            (Some(met), Some((t, direction))) => {
                let dir = rays.direction(x, y);
                depth.push((t - met.t).abs() * math::sqrt(math::dot(dir, dir)) / voxel_size);
                normal.push(degrees(direction.map(f64::from), met.normal));
            }
            (None, None) => {}
            _ => silhouette += 1,
        }
    }
    let both = depth.len() as u64;
    ShapeErrors { silhouette, both, depth: Deviations::of(depth), normal: Deviations::of(normal) }
}

/// Between two vectors.
fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    let across = math::cross(a, b);
    libm::atan2(math::sqrt(math::dot(across, across)), math::dot(a, b)).to_degrees()
}

impl Deviations {
    /// Of some values, none of which is NaN; `None` of none.
    fn of(mut values: Vec<f64>) -> Option<Deviations> {
        values.sort_unstable_by(f64::total_cmp);
        let max = *values.last()?;
        // The smallest value that 95 % do not exceed.
        let p95 = values[(values.len() * 19).div_ceil(20) - 1];
        Some(Deviations { mean: values.iter().sum::<f64>() / values.len() as f64, p95, max })
    }
}
