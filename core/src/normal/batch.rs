//! Normals at many hits.
//!
//! In: hits, best in an order in which neighbours follow each other, and the directions of their rays. Out: what
//! [`normal`](super::normal()) gives, bit for bit. Windows are cut from cubes that neighbours share; planes are fitted
//! block by block, and what is no plane is decided one by one.

use super::cubes::{Kept, Windows};
use super::lanes::{BLOCK, Block};
use super::window::Window;
use super::{Confidence, Normal, NormalKind, View, one, plane};
use crate::geometry::Geometry;
use crate::materials::Materials;
use crate::simd::Level;
use crate::trace::{Hit, Tracer};

/// The normals at `hits`, which rays along `dirs` found: `out[i]` becomes what [`normal`](super::normal()) gives for
/// `hits[i]` and `dirs[i]`, bit for bit, as far as all three reach. Fastest where hits that follow each other are
/// neighbours.
///
/// `level` says with which vectors planes are fitted (`Plane1`, `Plane2`, `Plane3`); `None`: one by one. Takes 20 KiB
/// of stack.
pub fn normals<G: Geometry, M: Materials>(
    level: Option<Level>,
    tracer: &Tracer<'_, G>,
    materials: M,
    hits: &[Hit],
    dirs: &[[f64; 3]],
    kind: NormalKind,
    out: &mut [Normal],
) {
    let mut windows = Kept::new(tracer);
    match (kind, Level::possible(level)) {
        (NormalKind::Plane1, Some(level)) => planes::<1>(level, &mut windows, hits, dirs, out),
        (NormalKind::Plane2, Some(level)) => planes::<2>(level, &mut windows, hits, dirs, out),
        (NormalKind::Plane3, Some(level)) => planes::<3>(level, &mut windows, hits, dirs, out),
        _ => {
            for ((hit, &dir), out) in hits.iter().zip(dirs).zip(out) {
                *out = one(&mut windows, materials, hit, dir, kind);
            }
        }
    }
}

/// Planes in windows of this radius.
fn planes<const RADIUS: usize>(
    level: Level,
    windows: &mut impl Windows,
    hits: &[Hit],
    dirs: &[[f64; 3]],
    out: &mut [Normal],
) {
    let mut block = Block::new();
    let mut around = [Window::<RADIUS>::default(); BLOCK];
    for ((hits, dirs), out) in hits.chunks(BLOCK).zip(dirs.chunks(BLOCK)).zip(out.chunks_mut(BLOCK)) {
        let count = hits.len().min(dirs.len());
        for (i, ((hit, &dir), window)) in hits.iter().zip(dirs).zip(&mut around).enumerate() {
            *window = windows.window(hit.voxel.decode());
            block.set(i, window.sums(), super::entry_face(hit.face, dir), dir);
        }
        block.fit(level, count, RADIUS);
        for (i, ((hit, &dir), out)) in hits.iter().zip(dirs).zip(out).enumerate() {
            *out = match block.plane(i) {
                Some((n, ratio)) => {
                    Normal { direction: n.map(|x| x as f32), confidence: Confidence::Plane { ratio: ratio as f32 } }
                }
                None => {
                    let view = View::new(hit.face, dir);
                    view.plane(&around[i], plane::fit).unwrap_or_else(|| view.entry())
                }
            };
        }
    }
}
