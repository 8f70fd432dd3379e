//! The filled voxels around a voxel, gathered as brick masks, and their moments.
//!
//! In: a DAG, a voxel and a radius r. Out: number, sums and sums of products of the coordinates, relative to the voxel, of
//! the filled voxels in the (2 r + 1)^3 window around it. Exact integers; voxels outside the cube are absent.
//!
//! The descent is shared: at each level every node that the window meets is looked up once. Masks are summed by octants
//! of 2^3 voxels (one byte each in Morton order), whose moments stand in a table: no population counts, which baseline
//! x86-64 and wasm32 targets lack or emulate, and no look-up per voxel.

use crate::dag::{BRICK_LEVEL, Dag};
use crate::morton::Morton;

/// Exact moments of a set of voxels.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Moments {
    /// Number of voxels.
    pub count: i32,
    /// Sums of x, y, z.
    pub first: [i32; 3],
    /// Sums of xx, yy, zz.
    pub squares: [i32; 3],
    /// Sums of yz, xz, xy: the axis that is missing gives the index.
    pub products: [i32; 3],
}

/// Moments of an octant of 2^3 voxels, a byte each: count, x, y, z, yz, xz, xy. Sums over a brick fit their bytes.
const OCTANT: [u64; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut bit = 0;
        while bit < 8 {
            if mask >> bit & 1 != 0 {
                let (x, y, z) = (bit & 1, bit >> 1 & 1, bit >> 2);
                table[mask] += 1 | x << 8 | y << 16 | z << 24 | (y & z) << 32 | (x & z) << 40 | (x & y) << 48;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

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

impl Moments {
    /// Moments of a brick's voxels, relative to its corner.
    fn of_brick(mask: u64) -> Moments {
        let p = mask.to_le_bytes().map(|octant| OCTANT[octant as usize]);
        // The halves with x, y, z >= 2, and the whole.
        let [yz, xz, xy] = [p[6] + p[7], p[5] + p[7], p[3] + p[7]];
        let half = [p[1] + p[5] + xy, p[2] + p[6] + xy, p[4] + p[5] + yz].map(u64::to_le_bytes);
        let quarter = [yz, xz, xy].map(|q| i32::from(q as u8));
        let all = (p[0] + p[1] + p[2] + p[3] + p[4] + p[5] + yz).to_le_bytes();
        let byte = |bytes: [u8; 8], i: usize| i32::from(bytes[i]);

        // A coordinate is c + 2 h with the bits c within the octant and h of the half; bits are their own squares.
        let mut m = Moments { count: byte(all, 0), ..Moments::default() };
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            m.first[i] = byte(all, 1 + i) + 2 * byte(half[i], 0);
            m.squares[i] = byte(all, 1 + i) + 4 * (byte(half[i], 1 + i) + byte(half[i], 0));
            m.products[i] = byte(all, 4 + i) + 2 * (byte(half[j], 1 + k) + byte(half[k], 1 + j)) + 4 * quarter[i];
        }
        m
    }

    /// Adds the moments of the same voxels as `m`, moved by `offset`.
    fn add_moved(&mut self, m: &Moments, offset: [i32; 3]) {
        self.count += m.count;
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let moved = m.first[i] + offset[i] * m.count;
            self.first[i] += moved;
            self.squares[i] += m.squares[i] + offset[i] * (m.first[i] + moved);
            self.products[i] += m.products[i] + offset[j] * m.first[k] + offset[k] * (m.first[j] + offset[j] * m.count);
        }
    }

    /// Moments of the filled voxels at most `radius` (0 to 3) away from `voxel` along each axis, relative to it.
    pub(super) fn around(dag: Dag<'_>, voxel: Morton, radius: u32) -> Moments {
        let center = voxel.decode();
        let mut moments = Moments::default();
        each_brick(dag, center, radius, |corner, mask| {
            let offset = core::array::from_fn(|i| corner[i] as i32 - center[i] as i32);
            moments.add_moved(&Moments::of_brick(mask), offset);
        });
        moments
    }
}

/// Calls `each` with the corner and the mask, clipped to the window, of every brick that holds a voxel of it.
fn each_brick(dag: Dag<'_>, center: [u32; 3], radius: u32, mut each: impl FnMut([u32; 3], u64)) {
    let last = (1 << dag.depth()) - 1;
    if dag.is_empty() || center.iter().any(|&c| c > last) {
        return;
    }
    let lo = center.map(|c| c.saturating_sub(radius));
    let hi = center.map(|c| (c + radius).min(last));
    let mut clipped = |brick: [u32; 3], word: usize| {
        let corner = brick.map(|b| 4 * b);
        let mut mask = dag.brick_at(word);
        for i in 0..3 {
            mask &= SLABS[i][lo[i].saturating_sub(corner[i]) as usize][(hi[i] - corner[i]).min(3) as usize];
        }
        if mask != 0 {
            each(corner, mask);
        }
    };

    // Descend while one node holds the whole window.
    let (mut level, mut word) = (dag.depth().max(BRICK_LEVEL), dag.root());
    while level > BRICK_LEVEL && (0..3).all(|i| lo[i] >> (level - 1) == hi[i] >> (level - 1)) {
        level -= 1;
        let Some(child) = dag.child(word, octant(lo.map(|c| c >> level))) else { return };
        word = child;
    }
    if level == BRICK_LEVEL {
        return clipped(lo.map(|c| c >> level), word);
    }

    // Then level by level with all nodes that the window meets: at most two along an axis, as it is at most seven wide.
    // Word 0 belongs to the header, so it stands for an empty node.
    let mut nodes = [0; 8];
    nodes[0] = word;
    while level > BRICK_LEVEL {
        let first = lo.map(|c| c >> level);
        level -= 1;
        let (from, to) = (lo.map(|c| c >> level), hi.map(|c| c >> level));
        let mut below = [0; 8];
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let parent = nodes[slot([x >> 1, y >> 1, z >> 1], first)];
                    if parent == 0 {
                        continue;
                    }
                    let Some(child) = dag.child(parent, octant([x, y, z])) else { continue };
                    if level == BRICK_LEVEL {
                        clipped([x, y, z], child);
                    } else {
                        below[slot([x, y, z], from)] = child;
                    }
                }
            }
        }
        nodes = below;
    }
}

/// The octant that a node takes in its parent.
fn octant([x, y, z]: [u32; 3]) -> u32 {
    x & 1 | (y & 1) << 1 | (z & 1) << 2
}

/// Place of a node among the up to 2^3 from `first` on.
fn slot(node: [u32; 3], first: [u32; 3]) -> usize {
    ((node[0] - first[0]) | (node[1] - first[1]) << 1 | (node[2] - first[2]) << 2) as usize & 7
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Voxel by voxel.
    fn naive(mask: u64, offset: [i32; 3]) -> Moments {
        let mut m = Moments::default();
        for bit in (0..64u64).filter(|bit| mask >> bit & 1 != 0) {
            let p = Morton(bit).decode();
            let p: [i32; 3] = core::array::from_fn(|i| p[i] as i32 + offset[i]);
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
                let offset = [-3, 5, -6];
                let mut moved = Moments::default();
                moved.add_moved(&Moments::of_brick(mask), offset);
                assert_eq!(moved, naive(mask, offset), "mask {mask:#x}");
            }
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
