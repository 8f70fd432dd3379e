//! The thin cover, 6-separating: Laine's crosshair target (2013, section 4), by the same rational clipping as [`clip`].
//!
//! A voxel is in if the closed triangle pierces one of the three axis-parallel segments through the voxel's centre; each
//! is half-open along its axis, `[k, k+1)`, so that a segment's end belongs to one voxel. A segment is a box without
//! extent in two axes, and nothing more is needed. A triangle does not pierce a segment that it is parallel to: where a
//! closed surface is left through such a triangle, the line runs on within parallel triangles until it meets, in a shared
//! edge, one that is not; so separation needs no more, and triangles without area mark nothing.

use std::collections::BTreeSet;

use crate::clip::{self, Aabb, Cell, SUB, Triangle};

/// Whether the voxel is in the thin cover of the triangle.
pub fn meets_voxel(triangle: &Triangle, voxel: [i64; 3]) -> bool {
    let [a, b, c] = triangle.map(|p| p.map(i128::from));
    (0..3).any(|axis| {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        if (b[u] - a[u]) * (c[v] - a[v]) == (b[v] - a[v]) * (c[u] - a[u]) {
            return false;
        }
        let centre = voxel.map(|k| k * SUB + SUB / 2);
        let mut aabb = Aabb { lo: centre, hi: centre, open: [false; 3] };
        aabb.lo[axis] = voxel[axis] * SUB;
        aabb.hi[axis] = (voxel[axis] + 1) * SUB;
        aabb.open[axis] = true;
        clip::meets(triangle, &aabb)
    })
}

/// The thin cover of the triangles in the cube of side 2^`depth`: a part of the exact cover, since the crosshair is a
/// part of the half-open voxel.
pub fn cover(triangles: &[Triangle], depth: u8) -> BTreeSet<[u32; 3]> {
    let mut thin = BTreeSet::new();
    for triangle in triangles {
        let exact = clip::cover(core::slice::from_ref(triangle), depth, Cell::HalfOpen);
        thin.extend(exact.into_iter().filter(|v| meets_voxel(triangle, v.map(i64::from))));
    }
    thin
}
