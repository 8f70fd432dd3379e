//! The filled voxels around a voxel, gathered as brick masks, and their moments.
//!
//! In: a DAG, a voxel and a radius r. Out: number, sums and sums of products of the coordinates of the filled voxels in
//! the (2 r + 1)^3 window around it. Exact integers, counted from the window's first brick, so where the window lies does
//! not matter; voxels outside the cube are absent.
//!
//! All bricks of a window are reached from the lowest node that holds it. Masks are summed by octants of 2^3 voxels (one
//! byte each in Morton order), whose moments stand in a table as packed numbers that are added as they are: no population
//! counts, which baseline x86-64 and wasm32 lack or emulate, and no look-up per voxel.

use crate::dag::{BRICK_LEVEL, Dag};
use crate::morton::Morton;

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

/// The count of packed moments.
fn count(packed: u64) -> i64 {
    (packed & 0x3ff) as i64
}

/// The sum along an axis of packed moments.
fn sum(packed: u64, axis: usize) -> i64 {
    count(packed >> (10 * (axis + 1)))
}

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

/// Moments of the octants of a window, weighted by the octants' places (x, y, z in steps of two voxels).
///
/// The packed sums of a window seven voxels wide fit: at most 343 voxels, and at most 931 weighted by a place of 0 to 5.
/// (Products overflow where they are weighted; they come last, and are read from the plain sum only.)
#[derive(Default)]
struct Sums {
    plain: u64,
    by_place: [u64; 3],
    /// Counts, weighted by squares of places and by products; the axis that is missing gives the index.
    squares: [i64; 3],
    products: [i64; 3],
}

impl Sums {
    /// Adds the voxels of the brick at `place` (in bricks) from the window's first one.
    fn add(&mut self, place: [u32; 3], mask: u64) {
        let p = mask.to_le_bytes().map(|octant| OCTANT[octant as usize]);
        // The octants whose place within the brick is odd along two axes, along one, and all.
        let quarter = [p[6] + p[7], p[5] + p[7], p[3] + p[7]];
        let half = [p[1] + p[5] + quarter[2], p[2] + p[6] + quarter[2], p[4] + p[5] + quarter[0]];
        let all = p[0] + p[2] + p[4] + p[6] + half[0];

        let even = place.map(|b| 2 * u64::from(b));
        let (n, h, e) = (count(all), half.map(count), even.map(|e| e as i64));
        self.plain = self.plain.wrapping_add(all);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.by_place[i] = self.by_place[i].wrapping_add(half[i].wrapping_add(even[i].wrapping_mul(all)));
            self.squares[i] += h[i] + e[i] * (2 * h[i] + e[i] * n);
            self.products[i] += count(quarter[i]) + e[j] * (h[k] + e[k] * n) + e[k] * h[j];
        }
    }

    /// A coordinate is c + 2 p with the place p and the bit c, which is its own square.
    fn moments(&self) -> Moments {
        let mut m = Moments { count: count(self.plain), ..Moments::default() };
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let bits = sum(self.plain, i);
            m.first[i] = bits + 2 * count(self.by_place[i]);
            m.squares[i] = bits + 4 * (sum(self.by_place[i], i) + self.squares[i]);
            let both = (self.plain >> (40 + 8 * i) & 0xff) as i64;
            m.products[i] = both + 2 * (sum(self.by_place[j], k) + sum(self.by_place[k], j)) + 4 * self.products[i];
        }
        m
    }
}

impl Moments {
    /// Moments of the filled voxels at most `radius` (0 to 3) away from `voxel` along each axis.
    pub(super) fn around(dag: Dag<'_>, voxel: Morton, radius: u32) -> Moments {
        let mut sums = Sums::default();
        each_brick(dag, voxel.decode(), radius, |place, mask| sums.add(place, mask));
        sums.moments()
    }
}

/// Calls `each` with the place (in bricks from the window's first one) and the mask, clipped to the window, of every brick
/// that holds a voxel of it.
#[inline]
fn each_brick(dag: Dag<'_>, center: [u32; 3], radius: u32, mut each: impl FnMut([u32; 3], u64)) {
    let last = (1 << dag.depth()) - 1;
    if dag.is_empty() || center.iter().any(|&c| c > last) {
        return;
    }
    let lo = center.map(|c| c.saturating_sub(radius));
    let hi = center.map(|c| (c + radius).min(last));

    // Descend while one node holds the whole window.
    let (mut top, mut root) = (dag.depth().max(BRICK_LEVEL), dag.root());
    let spread = (lo[0] ^ hi[0]) | (lo[1] ^ hi[1]) | (lo[2] ^ hi[2]);
    while top > BRICK_LEVEL && spread >> (top - 1) == 0 {
        top -= 1;
        let Some(child) = dag.child(root, octant(lo, top)) else { return };
        root = child;
    }

    // Along each axis the window meets one to three bricks.
    let (first, end) = (lo.map(|c| c / 4), hi.map(|c| c / 4));
    let slab = |axis: usize, brick: u32| {
        let (from, to) = (lo[axis].saturating_sub(4 * brick), (hi[axis] - 4 * brick).min(3));
        SLABS[axis][(from & 3) as usize][to as usize]
    };
    for z in first[2]..=end[2] {
        let in_z = slab(2, z);
        for y in first[1]..=end[1] {
            let in_zy = in_z & slab(1, y);
            for x in first[0]..=end[0] {
                let corner = [4 * x, 4 * y, 4 * z];
                let (mut level, mut word) = (top, Some(root));
                while let (Some(node), true) = (word, level > BRICK_LEVEL) {
                    level -= 1;
                    word = dag.child(node, octant(corner, level));
                }
                let mask = word.map_or(0, |word| dag.brick_at(word)) & in_zy & slab(0, x);
                if mask != 0 {
                    each([x - first[0], y - first[1], z - first[2]], mask);
                }
            }
        }
    }
}

/// The octant of the node of a level that holds the voxel, in its parent.
fn octant([x, y, z]: [u32; 3], level: u8) -> u32 {
    x >> level & 1 | (y >> level & 1) << 1 | (z >> level & 1) << 2
}

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
        for _ in 0..200 {
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
