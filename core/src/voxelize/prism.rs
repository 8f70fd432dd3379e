//! A snapped triangle as linear inequalities over cells: the 13-axis overlap test, ready for whole cubes of cells.
//!
//! In: a triangle in 1/256 voxels. Out: for any cube of cells whether it can hold a marked one, and the mask of a brick.
//! The separating axes (Akenine-Moeller 2001) are the box's three, the triangle's normal, and nine edge crosses. In each
//! coordinate plane a triangle and a box are convex polygons, so of an edge only the outer side can separate
//! (Schwarz and Seidel 2010, section 3): nine inequalities, two for the plane, and the range of cells for the box's axes.
//! Each reads `a . k + c >= 0` for the integer cell `k`: with the voxel's best corner put in and divided by 256, rounded
//! down, it is still exact. Half-open boxes take 1 off where the best corner is not part of the box. Exact bounds:
//! edges stay within 2^53, the plane within i64 unless triangle and subtree are huge, else it is evaluated in i128.

use super::Cover;
use crate::grid::SUB;

/// The other two axes of each axis, in cyclic order.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];
/// Bits of [`Prism::active`]: 9 edges, then the two sides of the plane.
const PLANE: u32 = 0b11 << 9;
const EDGES_OF_AXIS: [u32; 3] = [0b111, 0b111 << 3, 0b111 << 6];

/// The inequalities of one triangle, for cells relative to a subtree's first cell.
pub(super) struct Prism {
    /// First and last cell that the triangle's box touches.
    lo: [i32; 3],
    hi: [i32; 3],
    /// Inequalities that the range of cells does not imply already.
    pub(super) active: u32,
    /// Whether the plane needs i128.
    wide: bool,
    /// For axis w and edge e at 3 w + e: `a[0] k[u] + a[1] k[v] + a[2] >= 0` with (u, v) = OTHERS[w].
    edges: [[i64; 3]; 9],
    /// `plane . k + from >= 0` and `to - plane . k >= 0`.
    plane: [i64; 3],
    from: i128,
    to: i128,
}

/// What a cube of cells means to a triangle.
pub(super) enum Verdict {
    /// No cell of it is marked.
    Apart,
    /// Some may be; these inequalities are still open.
    Open(u32),
}

/// The best corner of a voxel's box for a direction, in units of 1/512 voxel, and what is taken off if it is not part
/// of the box.
struct Reach {
    low: i64,
    high: i64,
    open: i64,
}

impl Reach {
    fn of(cover: Cover) -> Reach {
        match cover {
            // Thin cells are among the exact ones, so the same cubes are searched.
            Cover::Exact | Cover::Thin => Reach { low: 0, high: 2 * SUB, open: 1 },
            Cover::Inflated => Reach { low: -1, high: 2 * SUB + 1, open: 0 },
        }
    }

    /// The constant of `a . k + c >= 0` for a box that reaches the half space `a . x >= b` (x, b in 1/256 voxels).
    fn constant(&self, a: &[i64], b: i128) -> i128 {
        let mut c = -2 * b;
        let mut open = false;
        for &a in a {
            c += i128::from(a) * i128::from(if a > 0 { self.high } else { self.low });
            open |= a > 0;
        }
        (c - i128::from(if open { self.open } else { 0 })).div_euclid(2 * i128::from(SUB))
    }

    /// First and last cell whose box reaches the interval from `min` to `max` (1/256 voxels).
    fn cells(&self, min: i64, max: i64) -> (i64, i64) {
        let first = -self.constant(&[1], i128::from(min)) as i64;
        let last = self.constant(&[-1], -i128::from(max)) as i64;
        (first, last)
    }
}

fn cross(a: [i64; 3], b: [i64; 3]) -> [i64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [i64; 3], b: [i64; 3]) -> i128 {
    (0..3).map(|i| i128::from(a[i]) * i128::from(b[i])).sum()
}

/// Twice the area's normal of a snapped triangle; exact.
pub(super) fn normal(v: &[[i64; 3]; 3]) -> [i64; 3] {
    let edge = |i: usize, j: usize| core::array::from_fn(|k| v[j][k] - v[i][k]);
    cross(edge(0, 1), edge(0, 2))
}

impl Prism {
    /// Sets up a triangle for the cells from `base` on, `2^level` a side, in a grid of `resolution` cells.
    pub(super) fn new(v: &[[i64; 3]; 3], cover: Cover, base: [i64; 3], level: u8, resolution: u32) -> Prism {
        let reach = Reach::of(cover);
        // Move the origin to the first cell; nothing but the offset of the cells changes.
        let v = v.map(|p| core::array::from_fn(|i| p[i] - SUB * base[i]));
        let size = 1i64 << level;
        let (mut lo, mut hi) = ([0; 3], [0; 3]);
        for i in 0..3 {
            let (first, last) = reach.cells(v[0][i].min(v[1][i]).min(v[2][i]), v[0][i].max(v[1][i]).max(v[2][i]));
            lo[i] = first.clamp(0, size) as i32;
            hi[i] = last.clamp(-1, size - 1).min(i64::from(resolution) - 1 - base[i]) as i32;
        }

        let n = normal(&v);
        let mut active = 0;
        let mut edges = [[0; 3]; 9];
        for w in 0..3 {
            let [u, t] = OTHERS[w];
            let mut add = |at: usize, from: usize, to: usize, side: i64| {
                let a = [-side * (v[to][t] - v[from][t]), side * (v[to][u] - v[from][u])];
                // An edge along an axis says no more than the range of cells does.
                if a[0] != 0 && a[1] != 0 {
                    let b = i128::from(a[0]) * i128::from(v[from][u]) + i128::from(a[1]) * i128::from(v[from][t]);
                    edges[3 * w + at] = [a[0], a[1], reach.constant(&a, b) as i64];
                    active |= 1 << (3 * w + at);
                }
            };
            if n[w] != 0 {
                for e in 0..3 {
                    add(e, e, (e + 1) % 3, n[w].signum());
                }
            } else if let Some(e) = (0..3).find(|&e| v[e][u] != v[(e + 1) % 3][u] || v[e][t] != v[(e + 1) % 3][t]) {
                // Seen edge on, the triangle is a segment: both sides of its line can separate.
                add(0, e, (e + 1) % 3, 1);
                add(1, e, (e + 1) % 3, -1);
            }
        }

        let distance = dot(n, v[0]);
        let from = reach.constant(&n, distance);
        let to = reach.constant(&n.map(|x| -x), -distance);
        // Seen edge on along an axis, the two sides of the segment there are those of the plane.
        if n.iter().all(|x| *x != 0) {
            active |= PLANE;
        }
        let largest = n.iter().map(|x| i128::from(x.abs()) * i128::from(size)).sum::<i128>();
        let wide = largest + from.abs().max(to.abs()) >= 1 << 62;
        Prism { lo, hi, active, wide, edges, plane: n, from, to }
    }

    /// First and last cell that can be marked, per axis.
    pub(super) fn range(&self) -> [(i32, i32); 3] {
        core::array::from_fn(|i| (self.lo[i], self.hi[i]))
    }

    /// Tests the cube of `size` cells a side from cell `k` on against the inequalities in `open`.
    #[inline]
    pub(super) fn cube(&self, k: [i32; 3], size: i32, open: u32) -> Verdict {
        let m = size - 1;
        for i in 0..3 {
            if k[i] > self.hi[i] || k[i] + m < self.lo[i] {
                return Verdict::Apart;
            }
        }
        let m = i64::from(m);
        let mut still = open;
        let mut left = open & !PLANE;
        while left != 0 {
            let at = left.trailing_zeros() as usize;
            left &= left - 1;
            let [u, t] = OTHERS[at / 3];
            let a = &self.edges[at];
            let here = a[0] * i64::from(k[u]) + a[1] * i64::from(k[t]) + a[2];
            if here + (a[0].max(0) + a[1].max(0)) * m < 0 {
                return Verdict::Apart;
            }
            if here + (a[0].min(0) + a[1].min(0)) * m >= 0 {
                still &= !(1 << at);
            }
        }
        if open & PLANE != 0 {
            let sides = if self.wide { self.plane_sides_wide(k, m) } else { self.plane_sides(k, m) };
            match sides {
                None => return Verdict::Apart,
                Some(settled) => still &= !settled,
            }
        }
        Verdict::Open(still)
    }

    /// Which sides of the plane all cells of the cube pass; `None` if one of them no cell passes.
    #[inline]
    fn plane_sides(&self, k: [i32; 3], m: i64) -> Option<u32> {
        let n = self.plane;
        let here = n[0] * i64::from(k[0]) + n[1] * i64::from(k[1]) + n[2] * i64::from(k[2]);
        let up = (n[0].max(0) + n[1].max(0) + n[2].max(0)) * m;
        let down = (n[0].min(0) + n[1].min(0) + n[2].min(0)) * m;
        let (from, to) = (self.from as i64, self.to as i64);
        if here + up + from < 0 || to - here - down < 0 {
            return None;
        }
        Some(u32::from(here + down + from >= 0) << 9 | u32::from(to - here - up >= 0) << 10)
    }

    #[cold]
    fn plane_sides_wide(&self, k: [i32; 3], m: i64) -> Option<u32> {
        let n = self.plane.map(i128::from);
        let here = (0..3).map(|i| n[i] * i128::from(k[i])).sum::<i128>();
        let up = n.iter().map(|x| *x.max(&0)).sum::<i128>() * i128::from(m);
        let down = n.iter().map(|x| *x.min(&0)).sum::<i128>() * i128::from(m);
        if here + up + self.from < 0 || self.to - here - down < 0 {
            return None;
        }
        Some(u32::from(here + down + self.from >= 0) << 9 | u32::from(self.to - here - up >= 0) << 10)
    }

    /// The marked cells of the brick from cell `k` on, given the inequalities that are still open there.
    #[inline]
    pub(super) fn brick(&self, k: [i32; 3], open: u32) -> u64 {
        let mut mask = u64::MAX;
        for i in 0..3 {
            mask &= range_mask(i, self.lo[i] - k[i], self.hi[i] - k[i]);
        }
        for w in 0..3 {
            if open & EDGES_OF_AXIS[w] != 0 {
                let [u, t] = OTHERS[w];
                let mut e = [[0; 3]; 3];
                for i in 0..3 {
                    let a = &self.edges[3 * w + i];
                    e[i] = [a[0], a[1], a[0] * i64::from(k[u]) + a[1] * i64::from(k[t]) + a[2]];
                }
                mask &= columns_mask(w, &e);
            }
        }
        if open & PLANE != 0 {
            // Within a brick the sums fit i64 wherever they matter; beyond, only the sign does.
            let here = (0..3).map(|i| i128::from(self.plane[i]) * i128::from(k[i])).sum::<i128>();
            let narrow = |x: i128| x.clamp(-(1 << 62), 1 << 62) as i64;
            mask &= slab_mask(self.plane, narrow(here + self.from), narrow(self.to - here));
        }
        mask
    }
}

/// Cells of a brick whose coordinate on `axis` is within `first..=last`.
#[inline]
fn range_mask(axis: usize, first: i32, last: i32) -> u64 {
    const UP_TO: [[u64; 5]; 3] = {
        let mut table = [[0; 5]; 3];
        let mut bit = 0;
        while bit < 64 {
            let mut axis = 0;
            while axis < 3 {
                let x = cell_of(bit)[axis];
                let mut end = x + 1;
                while end < 5 {
                    table[axis][end] |= 1 << bit;
                    end += 1;
                }
                axis += 1;
            }
            bit += 1;
        }
        table
    };
    let (first, end) = (first.clamp(0, 4), (last.saturating_add(1)).clamp(0, 4));
    UP_TO[axis][end as usize] & !UP_TO[axis][first as usize]
}

/// Cell of a bit of a brick mask.
pub(super) const fn cell_of(bit: usize) -> [usize; 3] {
    [bit & 1 | bit >> 2 & 2, bit >> 1 & 1 | bit >> 3 & 2, bit >> 2 & 1 | bit >> 4 & 2]
}

/// Cells whose column along axis `w` passes three inequalities `e[0] u + e[1] v + e[2] >= 0`.
#[inline]
fn columns_mask(w: usize, e: &[[i64; 3]; 3]) -> u64 {
    /// Per axis, for u + 4 v: the four cells of the column.
    const COLUMN: [[u64; 16]; 3] = {
        let mut table = [[0; 16]; 3];
        let mut bit = 0;
        while bit < 64 {
            let mut w = 0;
            while w < 3 {
                let cell = cell_of(bit);
                table[w][cell[OTHERS[w][0]] + 4 * cell[OTHERS[w][1]]] |= 1 << bit;
                w += 1;
            }
            bit += 1;
        }
        table
    };
    let mut mask = 0;
    for v in 0..4 {
        for u in 0..4 {
            let at = |i: usize| e[i][0] * u + e[i][1] * v + e[i][2];
            // The sign bit of an `or` is set if any of them is negative.
            let apart = (at(0) | at(1) | at(2)) >> 63;
            mask |= COLUMN[w][(u + 4 * v) as usize] & !apart as u64;
        }
    }
    mask
}

/// Cells with `n . k + from >= 0` and `to - n . k >= 0`.
#[inline]
fn slab_mask(n: [i64; 3], from: i64, to: i64) -> u64 {
    let mut mask = 0;
    for bit in 0..64 {
        let [x, y, z] = cell_of(bit);
        let here = n[0] * x as i64 + n[1] * y as i64 + n[2] * z as i64;
        mask |= (!((here + from) | (to - here)) as u64 >> 63) << bit;
    }
    mask
}

/// The inequalities of the 6-separating cover: an axis-parallel segment through the voxel's centre, half-open like the
/// voxel, pierces the triangle (Laine 2013, section 3.3, the crosshair). Triangles without area are not pierced.
pub(super) struct Crosshair {
    /// Per axis along which the triangle has an area: three edges at the centre of the column, and the plane.
    axes: [Option<Piercing>; 3],
    plane: [i64; 3],
}

struct Piercing {
    edges: [[i64; 3]; 3],
    from: i128,
    to: i128,
    /// Sign of the normal along the axis.
    side: i64,
}

impl Crosshair {
    /// Sets up a triangle for cells relative to `base`.
    pub(super) fn new(v: &[[i64; 3]; 3], base: [i64; 3]) -> Crosshair {
        let v = v.map(|p| core::array::from_fn::<i64, 3, _>(|i| p[i] - SUB * base[i]));
        let n = normal(&v);
        let half = i128::from(SUB / 2);
        let sub = i128::from(SUB);
        let axes = core::array::from_fn(|w| {
            if n[w] == 0 {
                return None;
            }
            let [u, t] = OTHERS[w];
            let side = n[w].signum();
            let edges = core::array::from_fn(|e| {
                let (p, q) = (v[e], v[(e + 1) % 3]);
                let a = [-side * (q[t] - p[t]), side * (q[u] - p[u])];
                let at_center =
                    i128::from(a[0]) * (half - i128::from(p[u])) + i128::from(a[1]) * (half - i128::from(p[t]));
                [a[0], a[1], at_center.div_euclid(sub) as i64]
            });
            // Along the axis the plane must lie at or beyond the voxel's near side, and before its far one.
            let s = i128::from(side);
            let near = s * (i128::from(n[u]) * half + i128::from(n[t]) * half - dot(n, v[0]));
            let far = near + s * i128::from(n[w]) * sub;
            Some(Piercing { edges, from: (far - 1).div_euclid(sub), to: (-near).div_euclid(sub), side })
        });
        Crosshair { axes, plane: n }
    }

    /// The marked cells of the brick from cell `k` on.
    pub(super) fn brick(&self, k: [i32; 3]) -> u64 {
        let mut mask = 0;
        for (w, piercing) in self.axes.iter().enumerate() {
            let Some(p) = piercing else { continue };
            let [u, t] = OTHERS[w];
            let edges = p.edges.map(|a| [a[0], a[1], a[0] * i64::from(k[u]) + a[1] * i64::from(k[t]) + a[2]]);
            let n = self.plane.map(|x| x * p.side);
            let here = (0..3).map(|i| i128::from(n[i]) * i128::from(k[i])).sum::<i128>();
            let narrow = |x: i128| x.clamp(-(1 << 62), 1 << 62) as i64;
            mask |= columns_mask(w, &edges) & slab_mask(n, narrow(here + p.from), narrow(p.to - here));
        }
        mask
    }
}
