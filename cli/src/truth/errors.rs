//! How far the shape of voxels is off, pixel by pixel: one ray through each pixel's centre, by the camera of the
//! picture.
//!
//! In: what the rays meet in truth ([`look`](super::look)), and the voxels. Out: pixels that show something where there
//! is nothing or nothing where there is something; and of those that show something in both, how far its distance and
//! its direction are off. Where a silhouette lets one ray pass another surface is seen, far behind: that counts as what
//! it is, so the largest depth error tells of silhouettes and the mean and the 95 % of surfaces.

use serde::Serialize;
use voxdag::camera::{Camera, Rays};
use voxdag::geometry::Geometry;
use voxdag::math;
use voxdag::normal::{self, NormalKind};
use voxdag::render::Counters;
use voxdag::trace::{Arithmetic, Hit, Tile, Tracer};
use voxdag::trees::Trees;
use voxdag::with_tracer;

use super::Met;
use crate::error::{Error, Result};
use crate::memory::Memory;
use crate::picture::{Shown, in_bands, room};

/// How a set of deviations spreads.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Deviations {
    /// Half of them are at most this.
    pub median: f64,
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
        let median = values[values.len().div_ceil(2) - 1];
        Some(Deviations { median, mean: values.iter().sum::<f64>() / values.len() as f64, p95, max })
    }
}

#[cfg(test)]
mod tests {
    use super::super::look;
    use super::super::shapes::Closed;
    use super::*;
    use crate::options::BuildArgs;
    use crate::scene;
    use crate::source::Source;
    use voxdag::obj::Model;
    use voxdag_oracle::scenes;

    /// A floor a quarter of a voxel above the border between two layers fills the upper one: seen from above the voxels
    /// are three quarters of one nearer.
    #[test]
    fn a_floor_is_off_by_what_it_lies_below_its_voxels() {
        let (mut memory, size) = (Memory::new(None), [40, 30]);
        let (voxel_size, height) = (0.25, 10.25 * 0.25);
        let scenes::Shape { positions, triangles } = scenes::tilted_plane(16.0, 0.0, height);
        let source = Source::of("floor", Model { positions, triangles, ..Model::default() });
        let args = BuildArgs {
            origin: Some([0.0; 3]),
            voxel_size: Some(voxel_size),
            resolution: Some(64),
            ..BuildArgs::default()
        };
        let built = scene::build(&source, &args, &mut memory).unwrap();

        // Some pixels look past it.
        let camera = Camera { eye: [8.0, 8.0, 20.0], target: [8.0, 8.0, 0.0], up: [0.0, 1.0, 0.0], fov_y: 60.0 };
        let floor = Closed::Sheet { center: [8.0, 8.0, height], edges: [[8.0, 0.0, 0.0], [0.0, 8.0, 0.0]] };
        let truth = look(&floor, &camera, size, &memory).unwrap();
        let rays = camera.rays(size[0], size[1]).unwrap();
        let mut expected: Vec<f64> = (0..size[0] * size[1])
            .filter(|&i| truth[i as usize].is_some())
            .map(|i| rays.direction(f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5))
            .map(|dir| 0.75 * math::sqrt(math::dot(dir, dir)))
            .collect();
        expected.sort_unstable_by(f64::total_cmp);
        let count = expected.len();
        assert!(count > 400 && count < 1200, "{count}");

        for arithmetic in [Arithmetic::Exact, Arithmetic::F64, Arithmetic::F32] {
            let how = (NormalKind::Plane2, arithmetic);
            let shown = built.shown();
            let trees = Trees::new(shown.geometry, memory.left());
            let errors = shape_errors(&truth, (&shown, &trees), &camera, size, how, &memory).unwrap();
            assert_eq!((errors.silhouette, errors.both), (0, count as u64));
            let (depth, normal) = (errors.depth.unwrap(), errors.normal.unwrap());
            let mean = expected.iter().sum::<f64>() / count as f64;
            let p95 = expected[(0.95 * count as f64).ceil() as usize - 1];
            let near = |a: f64, b: f64| (a - b).abs() < if arithmetic == Arithmetic::F32 { 1e-3 } else { 1e-9 };
            assert!(
                near(depth.mean, mean) && near(depth.p95, p95) && near(depth.max, expected[count - 1]),
                "{depth:?}"
            );
            assert_eq!((normal.mean, normal.max), (0.0, 0.0));
        }
    }

    #[test]
    fn pixels_are_compared_one_by_one() {
        let (size, camera) =
            ([4, 1], Camera { eye: [0.0; 3], target: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], fov_y: 1e-6 });
        let met = |t| Some(Met { t, normal: [0.0, 0.0, 1.0], side: [0.0, 0.0, 1.0], material: 0 });
        let truth = [met(2.0), met(3.0), None, None];
        let seen = [Some((2.5, [0.0, 0.0, 1.0])), None, Some((1.0, [1.0, 0.0, 0.0])), None];
        let rays = camera.rays(size[0], size[1]).unwrap();
        let errors = compare(&truth, &seen, &rays, size, 0.25);
        assert_eq!((errors.silhouette, errors.both, errors.normal.unwrap().max), (2, 1, 0.0));
        assert!((errors.depth.unwrap().mean - 2.0).abs() < 1e-12);
        assert!((degrees([0.0, 2.0, 0.0], [0.0, 1.0, -1.0]) - 45.0).abs() < 1e-12);
        assert_eq!(degrees([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]), 180.0);
        assert_eq!(compare(&[None], &[None], &rays, [1, 1], 1.0).depth, None);

        let spread = Deviations::of((1..=100).rev().map(f64::from).collect()).unwrap();
        assert_eq!((spread.mean, spread.p95, spread.max), (50.5, 95.0, 100.0));
        assert_eq!(Deviations::of(vec![3.0]).unwrap().p95, 3.0);
    }
}
