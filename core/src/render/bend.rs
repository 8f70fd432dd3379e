//! Where rays go on from a surface: mirrored, straight through it, or bent (Snell's law).
//!
//! In: what a ray met. Out: a ray. All in grid coordinates, directions of unit length. A ray that is mirrored starts where
//! shadow rays do ([`super::shadow`]): above the steps where the way is free, else on the step, in the empty voxel before the
//! hit. A ray that goes through starts in the first voxel behind the surface: by index, too, so that no surface is met twice.
//!
//! What is one surface: voxels of the same material that follow each other along the ray, and, across gaps, those whose
//! middles lie at the hit's height, `|nx| + |ny| + |nz|` more or less: all voxels that a plane with the unit normal n passes
//! through are so close. So a sheet is one surface however thick it is in voxels, and however flat one looks at its steps.

use super::batch::Met;
use super::shadow;
use crate::geometry::Geometry;
use crate::material::MaterialId;
use crate::materials::Materials;
use crate::math;
use crate::morton::Morton;
use crate::shade::LightKind;
use crate::trace::{Arithmetic, Face, Hit, Query, Tracer};

/// The direction in which a mirror with the unit normal `n` sends on a ray along `dir`. Where the normal leans away from the
/// viewer (a voxel behind the horizon that sticks out) the ray is led along the surface, not into it.
pub(super) fn reflected(dir: [f64; 3], n: [f64; 3]) -> [f64; 3] {
    let along = math::dot(dir, n);
    math::add_scaled(dir, n, if along < 0.0 { -2.0 * along } else { -along })
}

/// The direction behind a surface with the unit normal `n` towards the viewer, where light is `ratio` times as fast as behind
/// it; `None` if nothing gets through (total internal reflection). Where the normal leans away nothing bends.
pub(super) fn refracted(dir: [f64; 3], n: [f64; 3], ratio: f64) -> Option<[f64; 3]> {
    let cosine = -math::dot(dir, n);
    if cosine <= 0.0 {
        return Some(dir);
    }
    let square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    // Also refuses NaN.
    (square >= 0.0)
        .then(|| math::add_scaled(dir.map(|x| x * ratio), n, ratio * cosine - math::sqrt(square)))
        .and_then(math::normalize)
}

/// The ray along `dir` back from a surface; `None` if it meets nothing. Where it starts on a step, what of it leads into the
/// step's side is taken away.
pub(super) fn back(met: &Met<'_>, dir: [f64; 3], lift: f32) -> Option<Query> {
    match shadow::above(&met.hit, met.point, &met.normal, lift) {
        Some(above) if met.above => Some(Query::new(above, dir)),
        _ => {
            let side = met.hit.face.normal().map(f64::from);
            let out = math::add_scaled(dir, side, -math::dot(dir, side).min(0.0));
            shadow::from_hit(&met.hit, met.point, &LightKind::Directional(out))
        }
    }
}

/// How much farther off, in voxels, a surface's voxels may be, as normals are fitted.
const SLACK: f64 = 0.5;

/// How a ray comes out behind a surface.
pub(super) struct Behind {
    /// The first voxel that is not the surface's; if something else fills it, the surface's last one.
    pub start: Morton,
    /// Whether the surface is the skin of a filled body: deeper than sheets of up to three voxels are.
    pub is_body: bool,
}

/// Follows `ray` from a voxel that it `hit` through a surface of this material and unit normal; `None` if there is nothing
/// behind it before the ray's end.
pub(super) fn behind<M: Materials, G: Geometry>(
    tracer: &Tracer<'_, G>,
    materials: &M,
    (hit, id, n): (&Hit, MaterialId, [f64; 3]),
    ray: &Query,
) -> Option<Behind> {
    let geometry = tracer.geometry();
    let first = hit.voxel.decode().map(f64::from);
    let height = |voxel: Morton| math::dot(math::sub(voxel.decode().map(f64::from), first), n);
    let most = n[0].abs() + n[1].abs() + n[2].abs();
    let (mut last, mut gap) = (hit.voxel, None);
    for voxel in (Query { start: Some(hit.voxel), ..*ray }).voxels(geometry.depth()).skip(1) {
        let filled = geometry.contains(voxel);
        let off = height(voxel).abs();
        let near = off <= most + SLACK;
        if filled && materials.id(voxel) == id && (near || gap.is_none()) {
            (last, gap) = (voxel, None);
            continue;
        }
        gap = gap.or(Some(if filled { last } else { voxel }));
        // From here the ray meets none that is near any more: it is in both voxels, and only goes down.
        if filled || off > 2.0 * most + SLACK {
            break;
        }
    }
    gap.map(|start| Behind { start, is_body: -height(last) > most + 2.0 })
}

/// Where `ray` enters a voxel.
pub(super) fn entry(ray: &Query, voxel: Morton) -> [f64; 3] {
    let low = voxel.decode().map(f64::from);
    let times = [0, 1, 2].map(|i| match ray.dir[i] {
        0.0 => 0.0,
        d => (low[i] + f64::from(u8::from(d < 0.0)) - ray.origin[i]) / d,
    });
    math::add_scaled(ray.origin, ray.dir, times[0].max(times[1]).max(times[2]))
}

/// What a ray meets that goes on from a surface. One that starts in a filled voxel leaves that out.
pub(super) fn trace<G: Geometry>(tracer: &Tracer<'_, G>, arithmetic: Arithmetic, ray: &Query) -> Option<Hit> {
    left(tracer, ray, tracer.trace(arithmetic, ray))
}

/// The same of many rays.
pub(super) fn trace_many<G: Geometry>(
    tracer: &Tracer<'_, G>,
    arithmetic: Arithmetic,
    rays: &[Query],
    met: &mut [Option<Hit>],
) {
    tracer.trace_many(arithmetic, rays, met);
    rays.iter().zip(met).for_each(|(ray, met)| *met = left(tracer, ray, *met));
}

/// What a ray meets without the voxel that it starts in.
#[inline]
fn left<G: Geometry>(tracer: &Tracer<'_, G>, ray: &Query, met: Option<Hit>) -> Option<Hit> {
    let starts_inside = ray.start.is_some() && met.is_some_and(|hit| hit.face == Face::Inside);
    if starts_inside { tracer.hits(ray).nth(1) } else { met }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_obey_snell_and_come_back_the_way_they_went() {
        let n = [0.0, 1.0, 0.0];
        let down = [0.6, -0.8, 0.0];
        let is = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-15);
        assert!(is(reflected(down, n), [0.6, 0.8, 0.0]));
        // Into glass of 1.5 the sine shrinks from 0.6 to 0.4, and grows again on the way out.
        let inside = refracted(down, n, 1.0 / 1.5).unwrap();
        assert!(is(inside, [0.4, -math::sqrt(1.0 - 0.16), 0.0]));
        assert!(is(refracted(inside, n, 1.5).unwrap(), down));
        assert!(is(refracted(down, n, 1.0).unwrap(), down));
        // 0.6 times 1.7 is above 1.
        assert_eq!(refracted(down, n, 1.7), None);
        assert_eq!(refracted(down, n, f64::INFINITY), None);
        // Normals that lean away.
        assert!(is(reflected(down, [0.0, -1.0, 0.0]), [0.6, 0.0, 0.0]));
        assert_eq!(refracted(down, [0.0, -1.0, 0.0], 0.5), Some(down));
    }
}
