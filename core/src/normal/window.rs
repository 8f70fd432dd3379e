//! The filled voxels around a voxel, gathered as brick masks, and their moments.
//!
//! In: a geometry, a voxel and a radius r. Out: number, sums and sums of products of the coordinates of the filled voxels in
//! the (2 r + 1)^3 window around it. Exact integers, counted from the window's first brick, so where the window lies
//! does not matter; voxels outside the cube are absent.
//!
//! Bricks are reached from the tracer's top grid, or from the lowest node that holds the whole window. Masks are summed by octants of 2^3 voxels
//! (one byte each in Morton order), whose moments stand in a table as packed numbers that are added as they are: no
//! population counts, which baseline x86-64 and wasm32 lack or emulate, and no look-up per voxel.

use crate::dag::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::morton::Morton;
use crate::trace::Tracer;

/// Exact moments of a set of voxels.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Moments {
    /// Number of voxels.
    pub count: i64,
    /// Sums of x, y, z.
    pub first: [i64; 3],
    /// Sums of xx, yy, zz.
    pub squares: [i64; 3],
    /// Sums of yz, xz, xy: the axis that is missing gives the index.
    pub products: [i64; 3],
}

/// Moments of an octant of 2^3 voxels: count, x, y, z in ten bits each, then yz, xz, xy in eight bits each.
const OCTANT: [u64; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut bit = 0;
        while bit < 8 {
            if mask >> bit & 1 != 0 {
                let (x, y, z) = (bit & 1, bit >> 1 & 1, bit >> 2);
                table[mask] += 1 | x << 10 | y << 20 | z << 30 | (y & z) << 40 | (x & z) << 48 | (x & y) << 56;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

/// The lowest ten bits.
const TEN: u64 = 0x3ff;

/// `SLABS[axis][from][to]`: the voxels of a brick with `from <= coordinate <= to`.
const SLABS: [[[u64; 4]; 4]; 3] = {
    let mut slabs = [[[0; 4]; 4]; 3];
    let mut bit = 0;
    while bit < 64 {
        let mut axis = 0;
        while axis < 3 {
            let coordinate = bit >> axis & 1 | (bit >> (axis + 3) & 1) << 1;
            let mut from = 0;
            while from <= coordinate {
                let mut to = coordinate;
                while to < 4 {
                    slabs[axis][from][to] |= 1 << bit;
                    to += 1;
                }
                from += 1;
            }
            axis += 1;
        }
        bit += 1;
    }
    slabs
};

/// Packed moments of a window. A coordinate is c + 2 h + 4 b with bits c and h and the brick's place b from 0 to 2, so
/// that sums of squares and products come apart; all weighted sums of a window seven voxels wide fit their ten bits.
/// (Weighted sums of products do not; they come last, and are read from the plain sums only.)
#[derive(Default)]
struct Sums {
    /// Moments of the c: plain, and weighted by h + 2 b along each axis.
    cells: u64,
    cells_by: [u64; 3],
    /// Moments of the h: plain, and weighted by b along each axis.
    halves: u64,
    halves_by: [u64; 3],
    /// Counts weighted by bb, ten bits each: xx, yy, zz, yz, xz, xy.
    bricks: u64,
}

impl Sums {
    /// Adds the voxels of the brick at place `b` from the window's first one.
    fn add(&mut self, b: [u32; 3], mask: u64) {
        let p = mask.to_le_bytes().map(|octant| OCTANT[octant as usize]);
        // Octants with h = 1 along two axes, along one, and all of them.
        let two = [p[6] + p[7], p[5] + p[7], p[3] + p[7]];
        let one = [p[1] + p[5] + two[2], p[2] + p[6] + two[2], p[4] + p[5] + two[0]];
        let all = p[0] + p[2] + p[4] + p[6] + one[0];

        let b = b.map(u64::from);
        let n = all & TEN;
        let halves = n
            | (one[0] & TEN) << 10
            | (one[1] & TEN) << 20
            | (one[2] & TEN) << 30
            | (two[0] & TEN) << 40
            | (two[1] & TEN) << 48
            | (two[2] & TEN) << 56;
        let [x, y, z] = b;
        let weights = (x * x) | (y * y) << 10 | (z * z) << 20 | (y * z) << 30 | (x * z) << 40 | (x * y) << 50;
        self.cells = self.cells.wrapping_add(all);
        self.halves = self.halves.wrapping_add(halves);
        self.bricks += n * weights;
        for i in 0..3 {
            self.cells_by[i] = self.cells_by[i].wrapping_add(one[i]).wrapping_add(all.wrapping_mul(2 * b[i]));
            self.halves_by[i] = self.halves_by[i].wrapping_add(halves.wrapping_mul(b[i]));
        }
    }

    /// Takes the sums apart.
    fn moments(&self) -> Moments {
        let ten = |packed: u64, place: usize| (packed >> (10 * place) & TEN) as i64;
        let product = |packed: u64, i: usize| (packed >> (40 + 8 * i) & 0xff) as i64;
        let mut m = Moments { count: ten(self.cells, 0), ..Moments::default() };
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            // With p = h + 2 b: c + 2 p; cc + 4 cp + 4 pp, where cc = c; c c' + 2 (c p' + p c') + 4 p p'.
            let c = ten(self.cells, 1 + i);
            let pp = ten(self.halves, 1 + i) + 4 * (ten(self.halves_by[i], 1 + i) + ten(self.bricks, i));
            let mixed = ten(self.halves_by[j], 1 + k) + ten(self.halves_by[k], 1 + j);
            let products = product(self.halves, i) + 2 * mixed + 4 * ten(self.bricks, 3 + i);
            m.first[i] = c + 2 * ten(self.cells_by[i], 0);
            m.squares[i] = c + 4 * (ten(self.cells_by[i], 1 + i) + pp);
            let mixed = ten(self.cells_by[j], 1 + k) + ten(self.cells_by[k], 1 + j);
            m.products[i] = product(self.cells, i) + 2 * mixed + 4 * products;
        }
        m
    }
}

impl Moments {
    /// Moments of the filled voxels at most `radius` (0 to 3) away from `voxel` along each axis.
    pub(super) fn around<G: Geometry>(tracer: &Tracer<'_, G>, voxel: Morton, radius: u32) -> Moments {
        let mut sums = Sums::default();
        each_brick(tracer, voxel.decode(), radius, |place, mask| sums.add(place, mask));
        sums.moments()
    }

    /// From the centre of the filled voxels to `voxel`, where these are the moments around it.
    pub(super) fn out_of_center(&self, voxel: Morton, radius: u32) -> [f64; 3] {
        let own = voxel.decode().map(|c| i64::from(c - first_corner(c, radius)));
        core::array::from_fn(|i| (own[i] * self.count - self.first[i]) as f64 / self.count as f64)
    }
}

/// Where the first brick of a window starts, along one axis.
fn first_corner(center: u32, radius: u32) -> u32 {
    center.saturating_sub(radius) & !3
}

/// Calls `each` for every brick that holds a voxel of the window: with its place, in bricks from the window's first
/// one, and its mask, clipped to the window.
#[inline]
fn each_brick<G: Geometry>(tracer: &Tracer<'_, G>, center: [u32; 3], radius: u32, mut each: impl FnMut([u32; 3], u64)) {
    let geometry = tracer.geometry();
    let last = (1 << geometry.depth()) - 1;
    if geometry.is_empty() || center.iter().any(|&c| c > last) {
        return;
    }
    let lo = center.map(|c| c.saturating_sub(radius));
    let hi = center.map(|c| (c + radius).min(last));

    let child =
        |node, level, code: u64| geometry.child_or_empty(node, level as u8 + 1, (code >> (3 * level)) as u32 & 7);

    // Without a top grid, descend while one node holds the whole window.
    let mut top = tracer.entry_level();
    let mut root = None;
    let code = Morton::encode_masked(lo).0;
    if !tracer.has_top() {
        let spread = (lo[0] ^ hi[0]) | (lo[1] ^ hi[1]) | (lo[2] ^ hi[2]);
        let mut node = geometry.root();
        while top > u32::from(BRICK_LEVEL) && spread >> (top - 1) == 0 {
            top -= 1;
            node = child(node, top, code);
        }
        root = Some(node);
    }

    // Along each axis the window meets one to three bricks: their slabs of it, and the axis's bits of their codes.
    let bricks: [u32; 3] = core::array::from_fn(|i| hi[i] / 4 - lo[i] / 4 + 1);
    let mut along = [[(0, 0); 3]; 3];
    for i in 0..3 {
        let axis = AXIS << i & !63;
        let (mut code, mut corner) = (code & axis, first_corner(center[i], radius));
        for entry in along[i].iter_mut().take(bricks[i] as usize) {
            let (from, to) = (lo[i].saturating_sub(corner), (hi[i] - corner).min(3));
            *entry = (code, SLABS[i][(from & 3) as usize][to as usize]);
            // With all other bits set, a carry runs over them to the axis's next bit.
            code = (code | !axis).wrapping_add(1) & axis;
            corner += 4;
        }
    }
    // Neighbours share ancestors: of the last brick's path all is kept above where the codes part.
    let mut path = [G::EMPTY; 23];
    let mut last = None;
    for (z, &(code_z, slab_z)) in (0..bricks[2]).zip(&along[2]) {
        for (y, &(code_y, slab_y)) in (0..bricks[1]).zip(&along[1]) {
            for (x, &(code_x, slab_x)) in (0..bricks[0]).zip(&along[0]) {
                let code = code_x | code_y | code_z;
                let parting = last.map_or(top, |last: u64| (66 - (code ^ last).leading_zeros()) / 3);
                last = Some(code);
                let (parting, mut node) = if parting < top {
                    (parting, path[parting as usize])
                } else {
                    let corner = [lo[0] / 4 + x, lo[1] / 4 + y, lo[2] / 4 + z].map(|b| 4 * b);
                    (top, root.or_else(|| tracer.entry(corner)).unwrap_or(G::EMPTY))
                };
                for level in (u32::from(BRICK_LEVEL)..parting).rev() {
                    node = child(node, level, code);
                    path[level as usize] = node;
                }
                let mask = geometry.brick_or_empty(node) & slab_x & slab_y & slab_z;
                if mask != 0 {
                    each([x, y, z], mask);
                }
            }
        }
    }
}

/// The bits of a code that are x's.
const AXIS: u64 = 0x1249_2492_4924_9249;

#[cfg(test)]
mod tests {
    use super::*;

    /// Voxel by voxel.
    fn naive(mask: u64, corner: [u32; 3]) -> Moments {
        let mut m = Moments::default();
        for bit in (0..64u64).filter(|bit| mask >> bit & 1 != 0) {
            let p = Morton(bit).decode();
            let p: [i64; 3] = core::array::from_fn(|i| i64::from(p[i] + corner[i]));
            m.count += 1;
            for i in 0..3 {
                m.first[i] += p[i];
                m.squares[i] += p[i] * p[i];
                m.products[i] += p[(i + 1) % 3] * p[(i + 2) % 3];
            }
        }
        m
    }

    #[test]
    fn moments_of_a_brick_are_the_sums_over_its_voxels() {
        let mut masks = [0, u64::MAX, 1, 1 << 63, 0];
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for _ in 0..if cfg!(miri) { 2 } else { 200 } {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            masks[4] = state ^ state >> 29;
            for mask in masks {
                let mut sums = Sums::default();
                sums.add([0, 2, 1], mask);
                assert_eq!(sums.moments(), naive(mask, [0, 8, 4]), "mask {mask:#x}");
            }
        }
    }

    #[test]
    fn the_fullest_windows_fit() {
        for start in [[0u32; 3], [1, 2, 3], [3, 3, 3], [2, 3, 0]] {
            let (mut sums, mut expected) = (Sums::default(), Moments::default());
            for brick in 0..27u32 {
                let place = [brick % 3, brick / 3 % 3, brick / 9];
                let inside = |bit: &u64| {
                    let p = Morton(*bit).decode();
                    (0..3).all(|i| (start[i]..start[i] + 7).contains(&(p[i] + 4 * place[i])))
                };
                let mask = (0..64u64).filter(inside).map(|bit| 1 << bit).sum();
                sums.add(place, mask);
                let m = naive(mask, place.map(|b| 4 * b));
                expected.count += m.count;
                for i in 0..3 {
                    expected.first[i] += m.first[i];
                    expected.squares[i] += m.squares[i];
                    expected.products[i] += m.products[i];
                }
            }
            assert_eq!(sums.moments(), expected, "window from {start:?}");
        }
    }

    #[test]
    fn slabs_hold_the_coordinates_they_name() {
        for bit in 0..64u64 {
            let p = Morton(bit).decode().map(|c| c as usize);
            for axis in 0..3 {
                for from in 0..4 {
                    for to in 0..4 {
                        let inside = from <= p[axis] && p[axis] <= to;
                        assert_eq!(SLABS[axis][from][to] >> bit & 1 != 0, inside);
                    }
                }
            }
        }
    }
}
