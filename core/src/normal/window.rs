//! The filled voxels around a voxel, and their moments.
//!
//! In: cubes of 8^3 voxels, a voxel and a radius r. Out: the (2 r + 1)^3 window around the voxel; number, sums and sums
//! of products of the coordinates of its filled voxels. Exact integers, counted from the window's first voxel, so where
//! the window lies does not matter; voxels outside the cube are absent.
//!
//! Sums are added row by row from a table: no population counts, which baseline x86-64 and wasm32 lack or emulate, and
//! no look-up per voxel.

use super::cubes::Cube;

/// The voxels at most `RADIUS` (1 to 3) away from a voxel along each axis.
#[derive(Clone, Copy, Default)]
pub(super) struct Window<const RADIUS: usize> {
    /// Slices z with bit `8 y + x`.
    slices: [u64; 7],
}

/// Sums over a window: with weights 1, z, z (z + 1) / 2, y, y z, y (y + 1) / 2 those of 1, x and xx, 16 bits each. None
/// of a window of 7^3 is above 40,131.
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

impl<const RADIUS: usize> Window<RADIUS> {
    /// Voxels along a side.
    const SIDE: usize = 2 * RADIUS + 1;

    /// The cube, in cubes, that holds the first voxel of the window around `center`, and that voxel's place in it.
    #[inline(always)]
    pub(super) fn start(center: [u32; 3]) -> ([i32; 3], [u32; 3]) {
        let first = center.map(|c| c as i32 - RADIUS as i32);
        (first.map(|c| c >> 3), first.map(|c| (c & 7) as u32))
    }

    /// The bricks, one bit per octant, that a window which starts at `first` of a cube meets: those of that cube or,
    /// along axes whose bit is set in `next`, of the one after it.
    #[inline(always)]
    pub(super) fn bricks(first: [u32; 3], next: usize) -> u8 {
        // By axis: the octants of neither half, of the lower one, of the upper one, and of both.
        let octants = [[0, 0x55, 0xaa, 0xff], [0, 0x33, 0xcc, 0xff], [0, 0x0f, 0xf0, 0xff]];
        (0..3).fold(0xff, |bricks, i| {
            let (from, to) = (first[i] / 4, (first[i] + Self::SIDE as u32 - 1) / 4);
            let met = (2 << to) - (1usize << from);
            bricks & octants[i][met >> (2 * (next >> i & 1)) & 3]
        })
    }

    /// The cubes that a window which starts at `first` of the cube 0 meets, one bit each; the others follow it along x
    /// (1), y (2) and z (4).
    #[inline(always)]
    pub(super) fn cubes(first: [u32; 3]) -> u8 {
        let axes = (0..3).fold(0, |axes, i| axes | usize::from(first[i] + Self::SIDE as u32 > 8) << i);
        [0x01, 0x03, 0x05, 0x0f, 0x11, 0x33, 0x55, 0xff][axes]
    }

    /// Cuts out the window that starts at `first` of the cube 0; the others follow it along x (1), y (2) and z (4).
    #[inline(always)]
    pub(super) fn cut([x, y, z]: [u32; 3], cubes: [&Cube; 8]) -> Self {
        let left = 0x0101_0101_0101_0101 * (0xff >> x);
        // The window's rows and columns.
        let square = (u64::MAX >> (64 - 8 * Self::SIDE)) & (0x0101_0101_0101_0101 * ((1 << Self::SIDE) - 1));
        let mut slices = [0; 7];
        for (slice, z) in slices[..Self::SIDE].iter_mut().zip(z as usize..) {
            let row = |cube: usize| {
                let slice = |next: usize| cubes[cube + next + (z >> 3 & 1) * 4][z & 7];
                (slice(0) >> x & left) | (slice(1) << (8 - x) & !left)
            };
            *slice = (row(0) >> (8 * y) | row(2) << 1 << (63 - 8 * y)) & square;
        }
        Window { slices }
    }

    /// Whether the voxel at `at` from the window's first one is filled.
    pub(super) fn contains(&self, [x, y, z]: [usize; 3]) -> bool {
        self.slices[z] >> (8 * y + x) & 1 != 0
    }

    /// The sums over the window.
    #[inline(always)]
    pub(super) fn sums(&self) -> Sums {
        let mut sums = [0; 6];
        for &slice in self.slices[..Self::SIDE].iter().rev() {
            // By y: a row counts as often as it is there when sums are added, that is y times, or 1 + .. + y times.
            let row = |y: usize| ROWS[(slice >> (8 * y) & 0x7f) as usize];
            let (mut plain, mut by_y, mut by_yy) = (0, 0, 0);
            for y in (1..Self::SIDE).rev() {
                plain += row(y);
                by_y += plain;
                by_yy += by_y;
            }
            plain += row(0);
            // By z: the sums so far, which are those of the slices above, count once more.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::cubes::Cube;

    /// Numbers that look random.
    struct Noise(u64);

    impl Noise {
        fn next(&mut self) -> u64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            self.0 ^ self.0 >> 29
        }
    }

    /// Every voxel of a window, from its first one.
    fn places(side: usize) -> impl Iterator<Item = [usize; 3]> {
        (0..side * side * side).map(move |i| [i % side, i / side % side, i / side / side])
    }

    /// A window of every radius where it starts at `first`, against the cubes voxel by voxel.
    fn compare<const RADIUS: usize>(first: [u32; 3], cubes: &[Cube; 8]) {
        let window = Window::<RADIUS>::cut(first, cubes.each_ref());
        let (mut m, mut slices, mut met, mut bricks) = (Moments::default(), [0; 7], 0, [0; 8]);
        for p in places(2 * RADIUS + 1) {
            let at: [usize; 3] = core::array::from_fn(|i| first[i] as usize + p[i]);
            let [cube, octant] = [8, 4].map(|side| (0..3).fold(0, |n, i| n | ((at[i] / side) & 1) << i));
            met |= 1 << cube;
            bricks[cube] |= 1 << octant;
            let filled = cubes[cube][at[2] & 7] >> (8 * (at[1] & 7) + (at[0] & 7)) & 1 != 0;
            assert_eq!(window.contains(p), filled, "{p:?} from {first:?}");
            if filled {
                let x = p.map(|x| x as i64);
                m.count += 1;
                slices[p[2]] |= 1u64 << (8 * p[1] + p[0]);
                for i in 0..3 {
                    m.first[i] += x[i];
                    m.squares[i] += x[i] * x[i];
                    m.products[i] += x[(i + 1) % 3] * x[(i + 2) % 3];
                }
            }
        }
        assert_eq!((window.slices, window.sums().moments()), (slices, m), "from {first:?}");
        assert_eq!(Window::<RADIUS>::cubes(first), met, "from {first:?}");
        for next in (0..8).filter(|next| met >> next & 1 != 0) {
            assert_eq!(Window::<RADIUS>::bricks(first, next), bricks[next], "cube {next} from {first:?}");
        }
    }

    #[test]
    fn windows_are_cut_and_summed_voxel_by_voxel() {
        let mut noise = Noise(1);
        let mut random: [Cube; 8] = core::array::from_fn(|_| core::array::from_fn(|_| noise.next()));
        for first in places(8).step_by(if cfg!(miri) { 219 } else { 1 }) {
            let first = first.map(|x| x as u32);
            for cubes in [&random, &[[u64::MAX; 8]; 8]] {
                compare::<1>(first, cubes);
                compare::<2>(first, cubes);
                compare::<3>(first, cubes);
            }
            random[noise.next() as usize % 8][noise.next() as usize % 8] = noise.next() & noise.next();
        }
    }
}
