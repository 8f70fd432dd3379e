//! Whether a triangle meets a box, by clipping (Sutherland and Hodgman 1974) in exact rationals; and, by descent, the
//! set of voxels that triangles meet. The core decides the same by separating axes in machine integers.
//!
//! In: corners as integers in 1/256 voxel; degenerate triangles (segments, points) are as good as others. The triangle
//! is closed. Out: the truth, for half-open voxels, closed voxels, and voxels inflated by half a snapped unit.
//!
//! A list of points stands for its convex hull. Clipping a closed polyline a, b, c, a keeps the hull equal to the
//! intersection, also where the points are collinear or equal: whenever a step of the polyline crosses the plane, the
//! crossing point is added, and a segment or point is its own polyline run through there and back.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_traits::Signed;

/// Snapped units per voxel.
pub const SUB: i64 = 256;

/// A triangle's corners in 1/256 voxel.
pub type Triangle = [[i64; 3]; 3];

/// What a voxel is, to the question of what meets it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cell {
    /// `[k, k+1)` in every axis: each point belongs to one voxel. The core's exact cover.
    HalfOpen,
    /// `[k, k+1]`: touching counts.
    Closed,
    /// `[k - 1/512, k+1 + 1/512]`: whatever moved by at most half a snapped unit is still met. The inflated cover.
    Inflated,
}

/// An axis-parallel box with integer corners; `open[i]` excludes the points at `hi[i]`.
#[derive(Clone, Copy, Debug)]
pub struct Aabb {
    /// Smallest coordinates, part of the box.
    pub lo: [i64; 3],
    /// Largest coordinates.
    pub hi: [i64; 3],
    /// Axes whose upper face is not part of the box.
    pub open: [bool; 3],
}

impl Aabb {
    /// The cube of `side` voxels at voxel `corner`, and the factor by which its units are finer than 1/256 voxel.
    pub fn of_voxels(corner: [i64; 3], side: i64, cell: Cell) -> (Aabb, i64) {
        let lo = corner.map(|k| k * SUB);
        let hi = corner.map(|k| (k + side) * SUB);
        match cell {
            Cell::HalfOpen => (Aabb { lo, hi, open: [true; 3] }, 1),
            Cell::Closed => (Aabb { lo, hi, open: [false; 3] }, 1),
            Cell::Inflated => (Aabb { lo: lo.map(|x| 2 * x - 1), hi: hi.map(|x| 2 * x + 1), open: [false; 3] }, 2),
        }
    }
}

/// A point as numerators over one common denominator greater than 0.
#[derive(Clone, Debug)]
struct Point {
    num: [BigInt; 3],
    den: BigInt,
}

impl Point {
    /// `(coordinate - plane) * den`: the sign says on which side of the plane the point lies.
    fn above(&self, axis: usize, plane: i64) -> BigInt {
        &self.num[axis] - &self.den * plane
    }
}

/// The part of the polygon where `side * (coordinate - plane) >= 0`; `side` is 1 or -1.
fn clip(polygon: &[Point], axis: usize, plane: i64, side: i64) -> Vec<Point> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (da, db) = (a.above(axis, plane) * side, b.above(axis, plane) * side);
        if !da.is_negative() {
            kept.push(a.clone());
        }
        if da.is_negative() && db.is_positive() || da.is_positive() && db.is_negative() {
            // With heights ha = da / a.den and hb = db / b.den the crossing is (ha b - hb a) / (ha - hb); multiplied by
            // both denominators every term is an integer.
            let mut den = &da * &b.den - &db * &a.den;
            let mut num: [BigInt; 3] = core::array::from_fn(|k| &da * &b.num[k] - &db * &a.num[k]);
            if den.is_negative() {
                den = -den;
                num = num.map(|x| -x);
            }
            kept.push(Point { num, den });
        }
    }
    kept
}

/// Whether the closed triangle has a point in the box.
///
/// Let P be the triangle clipped to the closed box: convex, and the box lacks the faces `x_i = hi_i` of its open axes.
/// If for each open axis i some point p_i of P has `x_i < hi_i`, then the average of the p_i (one to three points) lies
/// in P, and in each open axis at least one of the averaged numbers is below hi_i and none above: it lies in the box.
/// Conversely a point in the box is such a p_i for every axis. So the axes can be asked one by one, and each by the
/// points that P is the hull of: if all of those have `x_i = hi_i`, so has all of P.
pub fn meets(triangle: &Triangle, aabb: &Aabb) -> bool {
    let mut polygon: Vec<Point> =
        triangle.iter().map(|corner| Point { num: corner.map(BigInt::from), den: 1.into() }).collect();
    for axis in 0..3 {
        polygon = clip(&polygon, axis, aabb.lo[axis], 1);
        polygon = clip(&polygon, axis, aabb.hi[axis], -1);
    }
    !polygon.is_empty() && (0..3).all(|i| !aabb.open[i] || polygon.iter().any(|p| p.above(i, aabb.hi[i]).is_negative()))
}

/// Whether the closed triangle meets the cube of `side` voxels at voxel `corner`.
pub fn meets_cube(triangle: &Triangle, corner: [i64; 3], side: i64, cell: Cell) -> bool {
    let (aabb, finer) = Aabb::of_voxels(corner, side, cell);
    // Most cubes are far away: the box of the corners is part of the truth, and cheap.
    for i in 0..3 {
        let min = triangle.iter().map(|p| p[i]).min().unwrap_or(0) * finer;
        let max = triangle.iter().map(|p| p[i]).max().unwrap_or(0) * finer;
        if max < aabb.lo[i] || min > aabb.hi[i] {
            return false;
        }
    }
    meets(&triangle.map(|p| p.map(|x| x * finer)), &aabb)
}

/// Whether the closed triangle meets a voxel.
pub fn meets_voxel(triangle: &Triangle, voxel: [i64; 3], cell: Cell) -> bool {
    meets_cube(triangle, voxel, 1, cell)
}

/// The voxels of the cube of side 2^`depth` that any of the triangles meets, and that lie in the window `lo..hi`
/// (voxel coordinates), by descent: a cube that a triangle misses holds no voxel that it meets.
pub fn cover_in(triangles: &[Triangle], depth: u8, cell: Cell, lo: [i64; 3], hi: [i64; 3]) -> BTreeSet<[u32; 3]> {
    let mut found = BTreeSet::new();
    let meets = |corner, side| move |t: &&Triangle| meets_cube(t, corner, side, cell);
    descend(&triangles.iter().collect::<Vec<_>>(), [0; 3], 1 << depth, (lo, hi), &meets, &mut found);
    found
}

/// The voxels of the cube of side 2^`depth` that any of the triangles meets.
pub fn cover(triangles: &[Triangle], depth: u8, cell: Cell) -> BTreeSet<[u32; 3]> {
    cover_in(triangles, depth, cell, [0; 3], [1 << depth; 3])
}

fn descend<F: Fn(&&Triangle) -> bool>(
    triangles: &[&Triangle],
    corner: [i64; 3],
    side: i64,
    window: ([i64; 3], [i64; 3]),
    meets: &impl Fn([i64; 3], i64) -> F,
    found: &mut BTreeSet<[u32; 3]>,
) {
    if (0..3).any(|i| corner[i] >= window.1[i] || corner[i] + side <= window.0[i]) {
        return;
    }
    let here: Vec<&Triangle> = triangles.iter().copied().filter(|t| meets(corner, side)(t)).collect();
    if here.is_empty() {
        return;
    }
    if side == 1 {
        found.insert(corner.map(|k| k as u32));
        return;
    }
    let half = side / 2;
    for octant in 0..8 {
        let child = core::array::from_fn(|i| corner[i] + if octant >> i & 1 == 1 { half } else { 0 });
        descend(&here, child, half, window, meets, found);
    }
}
