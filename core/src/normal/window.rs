//! The filled voxels around a voxel, and their moments.
//!
//! In: cubes of 8^3 voxels, a voxel and a radius r. Out: the (2 r + 1)^3 window around the voxel; number, sums and sums of
//! products of the coordinates of its filled voxels. Exact integers, counted from the window's first voxel, so where the
//! window lies does not matter; voxels outside the cube are absent.
//!
//! Moments are summed row by row from a table: no population counts, which baseline x86-64 and wasm32 lack or emulate, and
//! no look-up per voxel.

use super::cubes::{self, Cube};
use crate::geometry::Geometry;
use crate::trace::Tracer;

/// The greatest radius.
pub(super) const MAX_RADIUS: usize = 3;

/// The voxels around a voxel.
#[derive(Clone, Copy, Default)]
pub(super) struct Window {
    /// Slices z with bit `8 y + x`.
    slices: [u64; 2 * MAX_RADIUS + 1],
}

/// Sums over a window: with weights 1, z, z (z + 1) / 2, y, y z, y (y + 1) / 2 those of 1, x and xx, 16 bits each.
#[derive(Clone, Copy, Default)]
pub(super) struct Sums(pub [u64; 6]);

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

/// Sums of 1, x and xx of a row, 16 bits each.
const ROWS: [u64; 128] = {
    let mut table = [0; 128];
    let mut row = 0;
    while row < 128 {
        let mut x = 0;
        while x < 7 {
            if row >> x & 1 != 0 {
                table[row] += 1 | x << 16 | (x * x) << 32;
            }
            x += 1;
        }
        row += 1;
    }
    table
};

impl Window {
    /// The window around a voxel that has no neighbours: only its own bricks are read.
    pub(super) fn alone<G: Geometry>(tracer: &Tracer<'_, G>, center: [u32; 3], radius: usize) -> Window {
        let [lo, hi] = [-1, 1].map(|side| center.map(|c| c as i32 + side * radius as i32));
        Window::around(center, radius, |place| cubes::read(tracer, place, cubes::bricks_between(place, lo, hi)))
    }

    /// The voxels at most `radius` away from `center` along each axis, from what `cube` says the cubes (numbered in cubes) hold.
    #[inline(always)]
    pub(super) fn around(center: [u32; 3], radius: usize, mut cube: impl FnMut([i32; 3]) -> Cube) -> Window {
        let side = 2 * radius as i32 + 1;
        let lo = center.map(|c| c as i32 - radius as i32);
        let last = lo.map(|c| (c + side - 1) >> 3);
        let mut window = Window::default();
        for z in lo[2] >> 3..=last[2] {
            for y in lo[1] >> 3..=last[1] {
                for x in lo[0] >> 3..=last[0] {
                    window.place(&cube([x, y, z]), [8 * x - lo[0], 8 * y - lo[1], 8 * z - lo[2]], side);
                }
            }
        }
        // Clear what lies beyond the window.
        let square = (0x0101_0101_0101_0101 & ((1u64 << (8 * side)) - 1)) * ((1 << side) - 1);
        for slice in &mut window.slices {
            *slice &= square;
        }
        window
    }

    /// Adds a cube that begins at `at`, at least -7, counted from the window's first voxel.
    #[inline(always)]
    fn place(&mut self, cube: &Cube, at: [i32; 3], side: i32) {
        // The columns that stay within their rows.
        let columns = 0x0101_0101_0101_0101 * if at[0] < 0 { 0xff << -at[0] & 0xff } else { 0xff >> at[0] };
        let shift = 8 * at[1] + at[0];
        let (left, right) = (shift.max(0) as u32, (-shift).max(0) as u32);
        let (from, to) = ((-at[2]).max(0) as usize, (side - at[2]).min(8) as usize);
        let first = (at[2].max(0)) as usize;
        for (slice, &voxels) in self.slices.iter_mut().skip(first).zip(&cube[from..to]) {
            *slice |= (voxels & columns) << left >> right;
        }
    }

    /// Whether the voxel at `at` from the window's first one is filled.
    pub(super) fn contains(&self, [x, y, z]: [usize; 3]) -> bool {
        self.slices[z] >> (8 * y + x) & 1 != 0
    }

    /// The sums over a window of this radius.
    #[inline(always)]
    pub(super) fn sums(&self, radius: usize) -> Sums {
        let side = 2 * radius + 1;
        let mut sums = [0; 6];
        for &slice in self.slices[..side].iter().rev() {
            // By y: what is added last of all counts once, what was added first y times.
            let row = |y: usize| ROWS[(slice >> (8 * y) & 0x7f) as usize];
            let (mut plain, mut by_y, mut by_yy) = (0, 0, 0);
            for y in (1..side).rev() {
                plain += row(y);
                by_y += plain;
                by_yy += by_y;
            }
            plain += row(0);
            // By z, of the sums so far, which are those of the slices above.
            sums[1] += sums[0];
            sums[2] += sums[1];
            sums[4] += sums[3];
            sums[0] += plain;
            sums[3] += by_y;
            sums[5] += by_yy;
        }
        Sums(sums)
    }
}

impl Sums {
    /// Takes them apart.
    #[inline]
    pub(super) fn moments(&self) -> Moments {
        let [plain, z, zz, y, yz, yy] = self.0.map(|sum| [0, 16, 32].map(|bit| (sum >> bit & 0xffff) as i64));
        Moments {
            count: plain[0],
            first: [plain[1], y[0], z[0]],
            squares: [plain[2], 2 * yy[0] - y[0], 2 * zz[0] - z[0]],
            products: [yz[0], z[1], y[1]],
        }
    }
}

impl Moments {
    /// From the centre of the filled voxels to the voxel in the window's middle.
    pub(super) fn out_of_center(&self, radius: usize) -> [f64; 3] {
        self.first.map(|sum| (radius as i64 * self.count - sum) as f64 / self.count as f64)
    }
}
