//! Planes at many hits at once, one hit in every lane of a vector: [`super::plane`] and the side that `View` chooses.
//!
//! In: sums over windows, faces and directions, in columns. Out: unit normals and their quality, bit for bit those one
//! by one; nothing where a hit needs more than a plane (points, lines, solids, planes that show no side). What is i64
//! there is f64 here, and exact as well: up to 2^39 but for the determinant, whose terms reach 2^58. It is added in two
//! parts, each exact, and so rounded once, as a conversion from i64 does.

use fearless_simd::{Simd, prelude::*};

use super::plane::PLANAR;
use super::window::Sums;
use crate::simd::{Level, dispatch};

/// Hits in a block: a multiple of every vector's length.
pub(super) const BLOCK: usize = 32;

/// A number of each hit.
type Column<T> = [T; BLOCK];

/// Hits in columns, and the planes there.
pub(super) struct Block {
    sums: [Column<u64>; 6],
    /// Unit normal of the side of entry.
    face: [Column<f64>; 3],
    /// The ray's direction.
    dir: [Column<f64>; 3],
    normal: [Column<f64>; 3],
    /// l0 / l1, or -1 where there is no plane.
    ratio: Column<f64>,
}

impl Block {
    pub(super) fn new() -> Block {
        let columns = [[0.0; BLOCK]; 3];
        Block { sums: [[0; BLOCK]; 6], face: columns, dir: columns, normal: columns, ratio: columns[0] }
    }

    /// Puts hit `i` in: the sums over the window around it, the side of entry, and the ray's direction.
    #[inline]
    pub(super) fn set(&mut self, i: usize, sums: Sums, face: [f64; 3], dir: [f64; 3]) {
        for (column, sum) in self.sums.iter_mut().zip(sums.0) {
            column[i] = sum;
        }
        for k in 0..3 {
            (self.face[k][i], self.dir[k][i]) = (face[k], dir[k]);
        }
    }

    /// The plane at hit `i`, if there is one: its unit normal, out of the surface, and l0 / l1.
    #[inline]
    pub(super) fn plane(&self, i: usize) -> Option<([f64; 3], f64)> {
        let [x, y, z] = &self.normal;
        (self.ratio[i] >= 0.0).then(|| ([x[i], y[i], z[i]], self.ratio[i]))
    }

    /// Fits the planes at the first `count` hits, around which the windows have this radius.
    pub(super) fn fit(&mut self, level: Level, count: usize, radius: usize) {
        dispatch!(level, simd => {
            for start in (0..count).step_by(lanes(simd)) {
                fit(simd, self, start, radius as f64);
            }
        });
    }
}

/// Numbers in a vector.
#[inline(always)]
fn lanes<S: Simd>(_: S) -> usize {
    S::f64s::LEN
}

/// Fits the planes at one vector of hits.
#[inline(always)]
fn fit<S: Simd>(simd: S, block: &mut Block, start: usize, radius: f64) {
    let lanes = start..start + S::f64s::LEN;
    let splat = |x: f64| S::f64s::splat(simd, x);

    // Take the sums apart, see `Sums::moments`.
    let sum = |i: usize, bit: u32| -> S::f64s {
        let column: &Column<u64> = &block.sums[i];
        ((S::u64s::from_slice(simd, &column[lanes.clone()]) >> bit) & 0xffff).to_float()
    };
    let [plain, by_z, by_zz, by_y, by_yz, by_yy] = [0, 1, 2, 3, 4, 5];
    let n = sum(plain, 0);
    let first = [sum(plain, 16), sum(by_y, 0), sum(by_z, 0)];
    let squares = [sum(plain, 32), sum(by_yy, 0) * 2.0 - first[1], sum(by_zz, 0) * 2.0 - first[2]];
    let products = [sum(by_yz, 0), sum(by_z, 16), sum(by_y, 16)];

    // The scatter, its adjugate, and the characteristic polynomial.
    let (j, k) = ([1, 2, 0], [2, 0, 1]);
    let d = each(|i| n * squares[i] - first[i] * first[i]);
    let o = each(|i| n * products[i] - first[j[i]] * first[k[i]]);
    let adj_d = each(|i| d[j[i]] * d[k[i]] - o[i] * o[i]);
    let adj_o = each(|i| o[j[i]] * o[k[i]] - o[i] * d[i]);
    let t = d[0] + d[1] + d[2];
    let e2 = adj_d[0] + adj_d[1] + adj_d[2];
    let e3 = {
        // Adding 1.5 * 2^72 rounds to multiples of 2^20.
        let round = splat((3u128 << 71) as f64);
        let column = [adj_d[0], adj_o[2], adj_o[1]];
        let high = each(|i| column[i] + round - round);
        let low = each(|i| column[i] - high[i]);
        let row = [d[0], o[2], o[1]];
        dot::<S>(row, high) + dot::<S>(row, low)
    };

    // The eigenvalues l0 <= l1, and the eigenvector of l0. All voxels on a line: l0 / l1 is 0 / 0, no plane.
    let l0 = smallest_root(simd, t, e2, e3);
    let sum = t - l0;
    let product = e2 - l0 * sum;
    let l1 = product * 2.0 / (sum + (sum * sum - product * 4.0).max(splat(0.0)).sqrt());
    let ratio = l0 / l1;
    let square = l0 * l0;
    let diagonal = each(|i| adj_d[i] + l0 * (d[i] - t) + square);
    let normal = longest_column::<S>(diagonal, each(|i| adj_o[i] + l0 * o[i]));

    // Out of the surface: the face, less the ray's unit direction, and away from the centre.
    let load = |column: &Column<f64>| S::f64s::from_slice(simd, &column[lanes.clone()]);
    let (face, dir) = (each(|i| load(&block.face[i])), each(|i| load(&block.dir[i])));
    let largest = dir[0].abs().max(dir[1].abs()).max(dir[2].abs());
    let is_ray = largest.simd_gt(splat(0.0)) & dir[0].is_finite() & dir[1].is_finite() & dir[2].is_finite();
    let scaled = each(|i| dir[i] / largest);
    let length = dot::<S>(scaled, scaled).sqrt();
    let unit = each(|i| is_ray.select(scaled[i] / length, splat(0.0)));
    let outwards = each(|i| face[i] - unit[i] + (n * radius - first[i]) / n);

    // Turn the normal there.
    let side = dot::<S>(normal, outwards);
    let (front, back) = (side.simd_gt(splat(0.0)), side.simd_lt(splat(0.0)));
    let scale = front.select(splat(1.0), splat(-1.0)) / dot::<S>(normal, normal).sqrt();
    for (column, x) in block.normal.iter_mut().zip(normal) {
        (x * scale).store_slice(&mut column[lanes.clone()]);
    }
    let is_plane = ratio.simd_le(splat(PLANAR)) & (front | back);
    is_plane.select(ratio, splat(-1.0)).store_slice(&mut block.ratio[lanes]);
}

/// [`super::plane::smallest_root`]; each lane stops by itself.
#[inline(always)]
fn smallest_root<S: Simd>(simd: S, t: S::f64s, e2: S::f64s, e3: S::f64s) -> S::f64s {
    let zero = S::f64s::splat(simd, 0.0);
    let mut l = zero;
    let mut climbing = S::mask64s::splat(simd, true);
    for _ in 0..8 {
        let value = ((l - t) * l + e2) * l - e3;
        let slope = (l * 3.0 - t * 2.0) * l + e2;
        let step = -value / slope;
        climbing &= slope.simd_gt(zero) & step.simd_gt(zero);
        l = climbing.select(l + step, l);
        climbing &= !step.simd_lt(l * 1e-6);
        if climbing.all_false() {
            break;
        }
    }
    l
}

/// [`super::plane::longest_column`].
#[inline(always)]
fn longest_column<S: Simd>(d: [S::f64s; 3], o: [S::f64s; 3]) -> [S::f64s; 3] {
    let x = d[0].simd_ge(d[1]) & d[0].simd_ge(d[2]);
    let y = d[1].simd_ge(d[2]);
    let columns = [[d[0], o[2], o[1]], [o[2], d[1], o[0]], [o[1], o[0], d[2]]];
    each(|i| x.select(columns[0][i], y.select(columns[1][i], columns[2][i])))
}

/// Dot product, summed in the order x, y, z.
#[inline(always)]
fn dot<S: Simd>(a: [S::f64s; 3], b: [S::f64s; 3]) -> S::f64s {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// What `f` gives for each axis; always inlined, as vectors must be.
#[inline(always)]
fn each<V>(f: impl Fn(usize) -> V) -> [V; 3] {
    [f(0), f(1), f(2)]
}
