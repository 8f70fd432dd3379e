//! Normals at many hits.
//!
//! In: hits in any order; neighbours together are faster. Out: what [`normal`](super::normal) gives, bit for bit. Windows
//! are cut from cubes that neighbours share, and planes are fitted in lanes where there are any.

use super::cubes::{Kept, Windows};
use super::lanes::{self, BLOCK, Block};
use super::window::Window;
use super::{Confidence, Normal, NormalKind, View, entry_face, one, plane};
use crate::geometry::Geometry;
use crate::materials::Materials;
use crate::simd::Level;
use crate::trace::{Hit, Tracer};

/// The normals at `hits`, which rays along `dirs` found: `out[i]` becomes [`normal`](super::normal) at `hits[i]` along
/// `dirs[i]`, bit for bit, as far as all three slices reach. Fastest where hits that follow each other are neighbours.
/// `level` says in which vectors planes are fitted; `None` is one by one.
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
    match (level, kind) {
        (Some(level), NormalKind::Plane1) => planes::<1>(level, &mut windows, hits, dirs, out),
        (Some(level), NormalKind::Plane2) => planes::<2>(level, &mut windows, hits, dirs, out),
        (Some(level), NormalKind::Plane3) => planes::<3>(level, &mut windows, hits, dirs, out),
        _ => {
            for ((hit, &dir), out) in hits.iter().zip(dirs).zip(out) {
                *out = one(&mut windows, materials, hit, dir, kind);
            }
        }
    }
}

/// Planes of the window's radius.
fn planes<const RADIUS: usize>(
    level: Level,
    windows: &mut impl Windows,
    hits: &[Hit],
    dirs: &[[f64; 3]],
    out: &mut [Normal],
) {
    let mut block = Block::new();
    let mut kept = [Window::<RADIUS>::default(); BLOCK];
    for ((hits, dirs), out) in hits.chunks(BLOCK).zip(dirs.chunks(BLOCK)).zip(out.chunks_mut(BLOCK)) {
        for (i, (hit, &dir)) in hits.iter().zip(dirs).enumerate() {
            kept[i] = windows.window(hit.voxel.decode());
            let (sums, face) = (kept[i].sums().0, entry_face(hit.face, dir));
            for k in 0..6 {
                block.sums[k][i] = sums[k];
            }
            for k in 0..3 {
                block.face[k][i] = face[k];
                block.dir[k][i] = dir[k];
            }
        }
        lanes::fit(level, &mut block, hits.len(), RADIUS);
        for (i, ((hit, &dir), out)) in hits.iter().zip(dirs).zip(out).enumerate() {
            let ratio = block.ratio[i];
            *out = if ratio < 0.0 {
                let view = View::new(hit.face, dir);
                view.plane(&kept[i], plane::fit).unwrap_or_else(|| view.entry())
            } else {
                Normal {
                    direction: [0, 1, 2].map(|k| block.normal[k][i] as f32),
                    confidence: Confidence::Plane { ratio: ratio as f32 },
                }
            };
        }
    }
}
