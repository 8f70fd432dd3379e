//! Voxels in cubes of 8^3: what windows are cut from.
//!
//! In: a tracer. Out: cubes with their voxels in plain order, where the bricks they come from have Morton order, so that
//! windows are cut out by shifts. What lies outside the geometry is empty. A [`Cache`] keeps the last cubes: hits that follow
//! each other are neighbours, and their windows meet the same few.
//!
//! ```text
//! cube  eight slices z, bit 8 y + x            brick, a byte per octant  zz yy xx -> zyx zyx (bit of the code)
//! ```

use crate::dag::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::morton::Morton;
use crate::trace::Tracer;

/// 8^3 voxels: slices z with bit `8 y + x`.
pub(super) type Cube = [u64; 8];

/// The bricks, one bit per octant, of the cube at `place` (in cubes) that hold a voxel between `lo` and `hi`.
pub(super) fn bricks_between(place: [i32; 3], lo: [i32; 3], hi: [i32; 3]) -> u8 {
    // Of each axis, the octants of the lower and of the upper half.
    let halves = [[0x55, 0xaa], [0x33, 0xcc], [0x0f, 0xf0]];
    (0..3).fold(0xff, |bricks, i| {
        let middle = 8 * place[i] + 4;
        bricks & (if lo[i] < middle { halves[i][0] } else { 0 } | if hi[i] >= middle { halves[i][1] } else { 0 })
    })
}

/// The cube at `place` (in cubes): of its bricks those in `wanted`, one bit per octant.
#[inline]
pub(super) fn read<G: Geometry>(tracer: &Tracer<'_, G>, place: [i32; 3], wanted: u8) -> Cube {
    let geometry = tracer.geometry();
    let mut cube = [0; 8];
    // A negative place is far outside.
    let corner = place.map(|c| (c as u32) << 3);
    if corner.iter().any(|&c| c >> geometry.depth() != 0) {
        return cube;
    }

    // Descend to the cube's node; without any above the bricks, search for each of them.
    let top = tracer.entry_level() as u8;
    let code = Morton::encode_masked(corner);
    let mut node = G::EMPTY;
    let mut left = wanted;
    if top > BRICK_LEVEL {
        node = tracer.entry(corner).unwrap_or(G::EMPTY);
        for level in (BRICK_LEVEL + 1..top).rev() {
            node = geometry.child_or_empty(node, level + 1, u32::from(code.octant(level)));
        }
        if node == G::EMPTY {
            return cube;
        }
        left &= geometry.mask(node, BRICK_LEVEL + 1);
    }

    while left != 0 {
        let octant = left.trailing_zeros() as usize;
        left &= left - 1;
        let half = [octant & 1, octant >> 1 & 1, octant >> 2];
        let brick = if top > BRICK_LEVEL {
            geometry.child_or_empty(node, BRICK_LEVEL + 1, octant as u32)
        } else {
            let corner: [u32; 3] = core::array::from_fn(|i| corner[i] + 4 * half[i] as u32);
            if corner.iter().any(|&c| c >> geometry.depth() != 0) {
                continue;
            }
            tracer.entry(corner).unwrap_or(G::EMPTY)
        };
        let rows = rows(geometry.brick_or_empty(brick));
        for (z, rows) in rows.into_iter().enumerate() {
            cube[4 * half[2] + z] |= u64::from(rows) << (32 * half[1] + 4 * half[0]);
        }
    }
    cube
}

/// A brick's slices: a byte for each of the four rows, bit x.
#[inline]
fn rows(brick: u64) -> [u32; 4] {
    // Where z is even, and where it is odd: a byte holds two rows of two voxels, the next one those with x + 2.
    let [even, odd] = [brick, brick >> 4].map(|half| {
        let rows = half & 0x0f0f_0f0f_0f0f_0f0f;
        (rows & 0x0003_0003_0003_0003)
            | (rows & 0x0300_0300_0300_0300) >> 6
            | (rows & 0x000c_000c_000c_000c) << 6
            | (rows & 0x0c00_0c00_0c00_0c00)
    });
    [even as u32, odd as u32, (even >> 32) as u32, (odd >> 32) as u32]
}

/// Number of cubes that are kept.
const KEPT: usize = 256;

/// The cubes that were read last.
pub(super) struct Cache {
    /// Place of the cube in each slot, 21 bits for an axis.
    places: [u64; KEPT],
    cubes: [Cube; KEPT],
}

impl Cache {
    pub(super) fn new() -> Cache {
        Cache { places: [u64::MAX; KEPT], cubes: [[0; 8]; KEPT] }
    }

    /// The cube at `place`.
    #[inline]
    pub(super) fn cube<G: Geometry>(&mut self, tracer: &Tracer<'_, G>, place: [i32; 3]) -> &Cube {
        let [x, y, z] = place.map(|c| u64::from(c as u32 & 0x1f_ffff));
        let slot = (x + 11 * y + 121 * z) as usize % KEPT;
        let place_word = x | y << 21 | z << 42;
        if self.places[slot] != place_word {
            self.places[slot] = place_word;
            self.cubes[slot] = read(tracer, place, 0xff);
        }
        &self.cubes[slot]
    }
}
