//! Normals at many hits.
//!
//! In: hits in any order; neighbours together are faster. Out: what [`normal`](super::normal) gives, bit for bit. Windows
//! are cut from cubes that neighbours share, and planes are fitted in lanes where there are any.

use super::cubes::Cache;
use super::lanes::{self, BLOCK, Block};
use super::window::Window;
use super::{Confidence, Normal, NormalKind, entry_face, shaded};
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
    let count = hits.len().min(dirs.len()).min(out.len());
    let mut cache = Cache::new();
    let (mut block, mut windows) = (Block::new(), [Window::default(); BLOCK]);
    let fitted = match kind {
        NormalKind::Plane1 => Some(1),
        NormalKind::Plane2 => Some(2),
        NormalKind::Plane3 => Some(3),
        _ => None,
    };
    let blocks = hits[..count].chunks(BLOCK).zip(dirs[..count].chunks(BLOCK)).zip(out[..count].chunks_mut(BLOCK));
    for ((hits, dirs), out) in blocks {
        let (Some(level), Some(radius)) = (level, fitted) else {
            for ((hit, &dir), out) in hits.iter().zip(dirs).zip(out) {
                *out = shaded(materials, hit, dir, kind, |radius| {
                    Window::around(hit.voxel.decode(), radius, |place| *cache.cube(tracer, place))
                });
            }
            continue;
        };
        for (i, (hit, &dir)) in hits.iter().zip(dirs).enumerate() {
            windows[i] = Window::around(hit.voxel.decode(), radius, |place| *cache.cube(tracer, place));
            let (sums, face) = (windows[i].sums(radius).0, entry_face(hit.face, dir));
            for k in 0..6 {
                block.sums[k][i] = sums[k];
            }
            for k in 0..3 {
                block.face[k][i] = face[k];
                block.dir[k][i] = dir[k];
            }
        }
        lanes::fit(level, &mut block, hits.len(), radius);
        for (i, (hit, &dir)) in hits.iter().zip(dirs).enumerate() {
            let ratio = block.ratio[i];
            out[i] = if ratio < 0.0 {
                shaded(materials, hit, dir, kind, |_| windows[i])
            } else {
                Normal {
                    direction: [0, 1, 2].map(|k| block.normal[k][i] as f32),
                    confidence: Confidence::Plane { ratio: ratio as f32 },
                }
            };
        }
    }
}
