//! Planes for many hits at once: [`super::plane`] and the side that [`super::View`] chooses, a hit in every lane.
//!
//! In: sums over windows, faces and directions, in columns. Out: unit normals with their quality, the same bits as one by
//! one; or, where a hit needs anything but a plane (points, lines, solids, planes that show no side), nothing. All integers
//! are exact f64: up to 2^39, and the determinant's terms, up to 2^58, are added in two parts, rounded once.

use fearless_simd::{Simd, dispatch, prelude::*};

use super::plane::PLANAR;
use crate::simd::Level;

/// Hits in a block.
pub(super) const BLOCK: usize = 32;

/// A number for each hit.
pub(super) type Column<T> = [T; BLOCK];

/// Hits in columns.
pub(super) struct Block {
    /// What [`super::window::Sums`] holds.
    pub sums: [Column<u64>; 6],
    /// The unit normal of the side of entry.
    pub face: [Column<f64>; 3],
    /// Direction of the ray.
    pub dir: [Column<f64>; 3],
    /// The answers: unit normals,
    pub normal: [Column<f64>; 3],
    /// and l0 / l1; -1 where there is no plane.
    pub ratio: Column<f64>,
}

impl Block {
    pub(super) fn new() -> Block {
        let column = [0.0; BLOCK];
        Block { sums: [[0; BLOCK]; 6], face: [column; 3], dir: [column; 3], normal: [column; 3], ratio: column }
    }
}

/// Fits planes to the first `count` hits of the block.
pub(super) fn fit(level: Level, block: &mut Block, count: usize, radius: usize) {
    dispatch!(level.token(), simd => kernel(simd, block, count, radius));
}

#[inline(always)]
fn kernel<S: Simd>(simd: S, block: &mut Block, count: usize, radius: usize) {
    let width = S::f64s::LEN;
    for start in (0..count.min(BLOCK)).step_by(width) {
        let lanes = start..start + width;
        let splat = |x: f64| S::f64s::splat(simd, x);
        let load = |column: &Column<f64>| S::f64s::from_slice(simd, &column[lanes.clone()]);
        let three = |columns: &[Column<f64>; 3]| [load(&columns[0]), load(&columns[1]), load(&columns[2])];

        // Take the sums apart.
        let field = |i: usize, bit: u32| -> S::f64s {
            ((S::u64s::from_slice(simd, &block.sums[i][lanes.clone()]) >> bit) & 0xffff).to_float()
        };
        let n = field(0, 0);
        let first = [field(0, 16), field(3, 0), field(1, 0)];
        let squares = [field(0, 32), field(5, 0) * 2.0 - first[1], field(2, 0) * 2.0 - first[2]];
        let products = [field(4, 0), field(1, 16), field(3, 16)];

        // The scatter and its adjugate.
        let next = |i: usize| ((i + 1) % 3, (i + 2) % 3);
        let each = |f: &dyn Fn(usize) -> S::f64s| [f(0), f(1), f(2)];
        let d = each(&|i| n * squares[i] - first[i] * first[i]);
        let o = each(&|i| n * products[i] - first[next(i).0] * first[next(i).1]);
        let adj_d = each(&|i| d[next(i).0] * d[next(i).1] - o[i] * o[i]);
        let adj_o = each(&|i| o[next(i).0] * o[next(i).1] - o[i] * d[i]);
        let t = d[0] + d[1] + d[2];
        let e2 = adj_d[0] + adj_d[1] + adj_d[2];
        let e3 = {
            // Multiples of 2^20, and the rest.
            let round = splat(1.5 * (1u64 << 52) as f64 * (1u64 << 20) as f64);
            let row = [adj_d[0], adj_o[2], adj_o[1]];
            let high = row.map(|x| (x + round) - round);
            let low = [row[0] - high[0], row[1] - high[1], row[2] - high[2]];
            let times = |x: [S::f64s; 3]| d[0] * x[0] + o[2] * x[1] + o[1] * x[2];
            times(high) + times(low)
        };

        // The smallest eigenvalue, and its quotient with the middle one.
        let mut l0 = splat(0.0);
        let mut climbing = e2.simd_gt(splat(0.0));
        let known = climbing;
        for _ in 0..8 {
            let value = ((l0 - t) * l0 + e2) * l0 - e3;
            let slope = (l0 * 3.0 - t * 2.0) * l0 + e2;
            let step = -value / slope;
            climbing &= slope.simd_gt(splat(0.0)) & step.simd_gt(splat(0.0));
            l0 = climbing.select(l0 + step, l0);
            climbing &= !step.simd_lt(l0 * 1e-6);
            if climbing.all_false() {
                break;
            }
        }
        let sum = t - l0;
        let product = e2 - l0 * sum;
        let l1 = product * 2.0 / (sum + (sum * sum - product * 4.0).max(splat(0.0)).sqrt());
        let ratio = l0 / l1;
        let flat = ratio.simd_le(splat(PLANAR));

        // The eigenvector.
        let square = l0 * l0;
        let diagonal = each(&|i| adj_d[i] + l0 * (d[i] - t) + square);
        let off = each(&|i| adj_o[i] + l0 * o[i]);
        let x_longest = diagonal[0].simd_ge(diagonal[1]) & diagonal[0].simd_ge(diagonal[2]);
        let y_longest = diagonal[1].simd_ge(diagonal[2]);
        let choose = |x: S::f64s, y: S::f64s, z: S::f64s| x_longest.select(x, y_longest.select(y, z));
        let normal = [
            choose(diagonal[0], off[2], off[1]),
            choose(off[2], diagonal[1], off[0]),
            choose(off[1], off[0], diagonal[2]),
        ];

        // Out of the surface: the face, less the ray's unit direction, and away from the centre.
        let (face, dir) = (three(&block.face), three(&block.dir));
        let dot = |a: [S::f64s; 3], b: [S::f64s; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let largest = dir[0].abs().max(dir[1].abs()).max(dir[2].abs());
        let is_ray = largest.simd_gt(splat(0.0)) & dir[0].is_finite() & dir[1].is_finite() & dir[2].is_finite();
        let scaled = dir.map(|x| x / largest);
        let length = dot(scaled, scaled).sqrt();
        let out = each(&|i| {
            let unit = is_ray.select(scaled[i] / length, splat(0.0));
            (face[i] - unit) + (n * radius as f64 - first[i]) / n
        });

        // Turn it there.
        let side = dot(normal, out);
        let (front, back) = (side.simd_gt(splat(0.0)), side.simd_lt(splat(0.0)));
        let scale = front.select(splat(1.0), splat(-1.0)) / dot(normal, normal).sqrt();
        for (column, x) in block.normal.iter_mut().zip(normal) {
            (x * scale).store_slice(&mut column[lanes.clone()]);
        }
        (known & flat & (front | back)).select(ratio, splat(-1.0)).store_slice(&mut block.ratio[lanes]);
    }
}
