//! The rays that are measured with: those of a picture, and those that leave its hits.

use voxdag::Geometry;
use voxdag::math::{add_scaled, dot, sqrt, sub};
use voxdag::trace::{Arithmetic, Face, Hit, Query, TopBuf, Tracer};
use voxdag_oracle::rng::Rng;

use super::Run;
use crate::error::{Error, Kind, Result};
use crate::picture::{self, Shown};

/// Of the directions of incoherent rays; any other would do as well.
const SEED: u64 = 3;

/// Cells of the top grid along an axis, as a power of two; fewer where the octree is shallow.
pub const TOP_BITS: u8 = 6;

/// The top grid of a geometry.
pub fn top_grid(geometry: impl Geometry) -> Result<TopBuf> {
    TopBuf::new(&geometry, TOP_BITS)
        .map_err(|bytes| Error::new(Kind::Failure, format_args!("no memory for a top grid of {bytes} bytes")))
}

/// What answers the rays.
pub fn tracer<G: Geometry>(geometry: G, top: &TopBuf) -> Result<Tracer<'_, G>> {
    Tracer::with_top(geometry, top.as_top())
        .ok_or_else(|| Error::new(Kind::Failure, "the top grid does not fit its geometry: this is a defect of voxdag"))
}

/// A hit and the direction of the ray that found it.
pub struct Found {
    pub hit: Hit,
    pub dir: [f64; 3],
    /// Where the ray met the voxel.
    point: [f64; 3],
}

/// What the rays of a picture hit; an error if that is nothing.
pub fn seen(run: &Run, scene: &Shown<'_>) -> Result<Vec<Found>> {
    hits(&tracer(scene.geometry, &top_grid(scene.geometry)?)?, &picture::primary(scene, &run.camera, run.size)?)
}

/// What the rays hit, in their order; an error if that is nothing.
pub fn hits<G: Geometry>(tracer: &Tracer<'_, G>, queries: &[Query]) -> Result<Vec<Found>> {
    let found: Vec<_> = queries
        .iter()
        .filter_map(|q| {
            let hit = tracer.trace(Arithmetic::Exact, q)?;
            Some(Found { hit, dir: q.dir, point: add_scaled(q.origin, q.dir, hit.t) })
        })
        .collect();
    if found.is_empty() {
        return Err(Error::usage("no ray of the picture hits a voxel: there is nothing to measure")
            .hint("see --eye, --target and --fov"));
    }
    Ok(found)
}

/// A ray that leaves each hit towards a light at centre + 3 R (0.3, 1, 0.4) / |.| of the mesh's box, R half its
/// diagonal, and ends there.
pub fn shadow(scene: &Shown<'_>, found: &[Found]) -> Vec<Query> {
    let towards = scene.up.turn([0.3, 1.0, 0.4]);
    let distance = 3.0 * scene.bounds.radius() / sqrt(dot(towards, towards));
    let light = scene.grid.to_grid(add_scaled(scene.bounds.center(), towards, distance));
    found.iter().filter_map(leaving).map(|q| Query { dir: sub(light, q.origin), t_max: 1.0, ..q }).collect()
}

/// A ray that leaves each hit in a random direction, all of the sphere alike.
pub fn random(found: &[Found]) -> Vec<Query> {
    let mut rng = Rng::new(SEED);
    let mut direction = || {
        loop {
            let d = rng.direction();
            if dot(d, d) <= 1.0 {
                return d;
            }
        }
    };
    found.iter().filter_map(leaving).map(|q| Query { dir: direction(), ..q }).collect()
}

/// A ray, still without direction, that starts in the empty voxel before a hit. Where the ray came from outside the
/// cube there is none; then it starts half a voxel out. None starts at a hit whose ray began inside it.
fn leaving(found: &Found) -> Option<Query> {
    let Found { hit, point, .. } = found;
    if hit.face == Face::Inside {
        return None;
    }
    let out = hit.face.normal().map(f64::from);
    let origin = if hit.from.is_some() { *point } else { add_scaled(*point, out, 0.5) };
    Some(Query { start: hit.from, ..Query::new(origin, [0.0; 3]) })
}
