//! Windows cut from cubes of 8^3 voxels.
//!
//! In: a tracer and a voxel. Out: the window around it. Bricks, whose voxels stand in Morton order, are first put into
//! cubes where each axis has its own bits, so that windows are cut out by shifts. What lies outside the geometry is
//! empty. For a single window ([`Alone`]) only its own bricks are read, at most 27. Windows of hits that follow each
//! other ([`Kept`]) are cut from cubes that are kept: neighbours meet the same few.
//!
//! ```text
//! cube   eight slices z, bit 8 y + x             brick  bit z1 y1 x1 z0 y0 x0 (Morton)
//! ```

use super::window::Window;
use crate::dag::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::trace::Tracer;

/// 8^3 voxels: slices z with bit `8 y + x`.
pub(super) type Cube = [u64; 8];

/// Adds to `cube`, which lies at `place` (in cubes), the voxels of its bricks in `wanted`, one bit per octant.
#[inline]
fn read<G: Geometry>(tracer: &Tracer<'_, G>, place: [i32; 3], wanted: u8, cube: &mut Cube) {
    let geometry = tracer.geometry();
    // A negative place is far outside.
    let corner = place.map(|c| (c as u32) << 3);
    if corner.iter().any(|&c| c >> geometry.depth() != 0) {
        return;
    }

    // Descend to the cube's node; if the search begins at bricks, there is none.
    let top = tracer.entry_level() as u8;
    let mut node = G::EMPTY;
    let mut left = wanted;
    if top > BRICK_LEVEL {
        node = tracer.entry(corner).unwrap_or(G::EMPTY);
        for level in (BRICK_LEVEL + 1..top).rev() {
            let octant = (0..3).fold(0, |octant, i| octant | (corner[i] >> level & 1) << i);
            node = geometry.child_or_empty(node, level + 1, octant);
        }
        if node == G::EMPTY {
            return;
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

/// What windows come from.
pub(super) trait Windows {
    /// The window around a voxel.
    fn window<const RADIUS: usize>(&mut self, center: [u32; 3]) -> Window<RADIUS>;
}

/// Windows that have nothing in common: only their own bricks are read.
pub(super) struct Alone<'t, 'a, G>(pub &'t Tracer<'a, G>);

impl<G: Geometry> Windows for Alone<'_, '_, G> {
    #[inline]
    fn window<const RADIUS: usize>(&mut self, center: [u32; 3]) -> Window<RADIUS> {
        let (place, first) = Window::<RADIUS>::start(center);
        let mut cubes = [[0; 8]; 8];
        let mut met = Window::<RADIUS>::cubes(first);
        while met != 0 {
            let next = met.trailing_zeros() as usize;
            met &= met - 1;
            read(self.0, after(place, next), Window::<RADIUS>::bricks(first, next), &mut cubes[next]);
        }
        Window::cut(first, cubes.each_ref())
    }
}

/// Number of cubes that are kept.
const KEPT: usize = 64;

/// Windows of neighbours: the cubes that were read last are kept.
pub(super) struct Kept<'t, 'a, G> {
    tracer: &'t Tracer<'a, G>,
    /// Place of the cube in each slot.
    places: [u64; KEPT],
    cubes: [Cube; KEPT],
    /// Place of the cube where the last window started, the slots of those around it, and one bit each if it is there.
    last: u64,
    slots: [usize; 8],
    found: u8,
}

impl<'t, 'a, G: Geometry> Kept<'t, 'a, G> {
    pub(super) fn new(tracer: &'t Tracer<'a, G>) -> Self {
        Kept { tracer, places: [u64::MAX; KEPT], cubes: [[0; 8]; KEPT], last: u64::MAX, slots: [0; 8], found: 0 }
    }

    /// Finds the cubes that begin at `place`, of which one bit each is set in `missing`.
    #[inline(never)]
    fn find(&mut self, place: [i32; 3], mut missing: u8) {
        self.found |= missing;
        while missing != 0 {
            let next = missing.trailing_zeros() as usize;
            missing &= missing - 1;
            let place = after(place, next);
            // The eight cubes of a window have eight slots.
            let slot = (place[0] + 11 * place[1] + 121 * place[2]) as usize % KEPT;
            let word = word(place);
            self.slots[next] = slot;
            if self.places[slot] != word {
                self.places[slot] = word;
                self.cubes[slot] = [0; 8];
                read(self.tracer, place, 0xff, &mut self.cubes[slot]);
            }
        }
    }
}

impl<G: Geometry> Windows for Kept<'_, '_, G> {
    #[inline(always)]
    fn window<const RADIUS: usize>(&mut self, center: [u32; 3]) -> Window<RADIUS> {
        let (place, first) = Window::<RADIUS>::start(center);
        let word = word(place);
        if self.last != word {
            self.last = word;
            self.found = 0;
        }
        let missing = Window::<RADIUS>::cubes(first) & !self.found;
        if missing != 0 {
            self.find(place, missing);
        }
        Window::cut(first, self.slots.map(|slot| &self.cubes[slot % KEPT]))
    }
}

/// The cube that follows one along the axes whose bits are set.
#[inline(always)]
fn after(place: [i32; 3], axes: usize) -> [i32; 3] {
    core::array::from_fn(|i| place[i] + (axes >> i & 1) as i32)
}

/// A place in one word, 21 bits for an axis.
#[inline(always)]
fn word(place: [i32; 3]) -> u64 {
    let [x, y, z] = place.map(|c| u64::from(c as u32 & 0x1f_ffff));
    x | y << 21 | z << 42
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morton::Morton;

    #[test]
    fn a_bricks_rows_are_its_voxels() {
        for bit in 0..64 {
            let [x, y, z] = Morton(bit).decode();
            let expected = core::array::from_fn(|slice| if slice == z as usize { 1 << (8 * y + x) } else { 0 });
            assert_eq!(rows(1 << bit), expected, "bit {bit}");
        }
    }
}
