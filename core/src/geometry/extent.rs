//! The box around all filled voxels, by a walk that passes over what lies in the box already.

use super::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::morton::Morton;

/// Nodes that wait, at most: each level adds at most seven to the one taken.
const WAITING: usize = 7 * 21 + 1;

/// See [`Geometry::extent`].
pub(super) fn extent<G: Geometry>(geometry: G, level: u8) -> Option<[[u32; 3]; 2]> {
    if geometry.is_empty() {
        return None;
    }
    let level = level.min(geometry.depth());
    let mut found = Extent { first: [u32::MAX; 3], last: [0; 3] };
    // Each with its level and its first voxel.
    let mut waiting = [(0, 0, 0); WAITING];
    waiting[0] = (geometry.root(), geometry.depth().max(BRICK_LEVEL), 0);
    let mut count = 1;
    while count > 0 {
        count -= 1;
        let (node, at, code) = waiting[count];
        if found.holds(code, at) {
            continue;
        }
        if at == level {
            found.add(code, at);
        } else if at == BRICK_LEVEL {
            let mut voxels = geometry.brick_at(node);
            while voxels != 0 {
                let cube = u64::from(voxels.trailing_zeros()) >> (3 * level) << (3 * level);
                found.add(code | cube, level);
                voxels &= voxels - 1;
            }
        } else {
            let mut octants = geometry.mask(node, at);
            while octants != 0 {
                let octant = octants.trailing_zeros();
                if let Some(child) = geometry.child(node, at, octant) {
                    waiting[count] = (child, at - 1, code | u64::from(octant) << (3 * (at - 1)));
                    count += 1;
                }
                octants &= octants - 1;
            }
        }
    }
    Some([found.first, found.last])
}

struct Extent {
    first: [u32; 3],
    last: [u32; 3],
}

impl Extent {
    /// First and last voxel of a cube, given by its first voxel's code and its level.
    fn cube(code: u64, level: u8) -> ([u32; 3], [u32; 3]) {
        let first = Morton(code).decode();
        (first, first.map(|x| x + (1 << level) - 1))
    }

    fn holds(&self, code: u64, level: u8) -> bool {
        let (first, last) = Extent::cube(code, level);
        (0..3).all(|i| self.first[i] <= first[i] && last[i] <= self.last[i])
    }

    fn add(&mut self, code: u64, level: u8) {
        let (first, last) = Extent::cube(code, level);
        for i in 0..3 {
            self.first[i] = self.first[i].min(first[i]);
            self.last[i] = self.last[i].max(last[i]);
        }
    }
}
