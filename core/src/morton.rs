//! Morton codes of 3 x 21 bits, the thesis's *voxel index* (Pineda 2021, section 2.4).
//!
//! Bit `3 i` of a code is bit `i` of x, bit `3 i + 1` of y, bit `3 i + 2` of z. The order of codes is the order of the
//! octree's leaves, and three bits of a code are an octant `x + 2 y + 4 z`. Unlike the usual masks, encoding is checked:
//! a coordinate of 2^21 is refused, it never aliases to 0. Bit 63 is always clear, so `u64::MAX` is no code.

/// A voxel's place: its coordinates, interleaved.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Morton(pub u64);

/// Bits per axis, and the greatest depth of an octree.
pub const BITS: u32 = 21;
/// The greatest resolution: coordinates are below it.
pub const MAX_RESOLUTION: u32 = 1 << BITS;

impl Morton {
    /// The code of voxel `[x, y, z]`; `None` if a coordinate is 2^21 or more.
    #[inline]
    pub const fn encode([x, y, z]: [u32; 3]) -> Option<Morton> {
        if (x | y | z) >> BITS != 0 {
            return None;
        }
        Some(Morton(spread(x) | spread(y) << 1 | spread(z) << 2))
    }

    /// The code of a voxel whose coordinates are known to be below 2^21; higher bits are dropped.
    #[inline]
    pub(crate) const fn encode_masked([x, y, z]: [u32; 3]) -> Morton {
        let m = MAX_RESOLUTION - 1;
        Morton(spread(x & m) | spread(y & m) << 1 | spread(z & m) << 2)
    }

    /// The coordinates `[x, y, z]`, each below 2^21.
    #[inline]
    pub const fn decode(self) -> [u32; 3] {
        [compact(self.0), compact(self.0 >> 1), compact(self.0 >> 2)]
    }

    /// The octant `x + 2 y + 4 z` (0 to 7) that the voxel takes within its ancestor cube of side `2^(level + 1)`.
    #[inline]
    pub const fn octant(self, level: u8) -> u8 {
        (self.0 >> (3 * level as u32) & 7) as u8
    }

    /// The voxel `offset` away; `None` outside 0..2^21.
    #[inline]
    pub const fn neighbour(self, offset: [i32; 3]) -> Option<Morton> {
        let [x, y, z] = self.decode();
        match (x.checked_add_signed(offset[0]), y.checked_add_signed(offset[1]), z.checked_add_signed(offset[2])) {
            (Some(x), Some(y), Some(z)) => Morton::encode([x, y, z]),
            _ => None,
        }
    }
}

/// Moves bit `i` of a 21-bit number to bit `3 i`.
#[inline]
const fn spread(x: u32) -> u64 {
    let x = x as u64;
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Moves bit `3 i` to bit `i` and drops the others.
#[inline]
const fn compact(x: u64) -> u32 {
    let x = x & 0x1249_2492_4924_9249;
    let x = (x | x >> 2) & 0x10c3_0c30_c30c_30c3;
    let x = (x | x >> 4) & 0x100f_00f0_0f00_f00f;
    let x = (x | x >> 8) & 0x001f_0000_ff00_00ff;
    let x = (x | x >> 16) & 0x001f_0000_0000_ffff;
    ((x | x >> 32) & 0x001f_ffff) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_refused_not_aliased() {
        let max = MAX_RESOLUTION - 1;
        assert_eq!(Morton::encode([max; 3]), Some(Morton(0x7fff_ffff_ffff_ffff)));
        for axis in 0..3 {
            let mut p = [0; 3];
            p[axis] = MAX_RESOLUTION;
            assert_eq!(Morton::encode(p), None);
            p[axis] = u32::MAX;
            assert_eq!(Morton::encode(p), None);
        }
    }

    #[test]
    fn octants_and_neighbours() {
        const CODE: Option<Morton> = Morton::encode([5, 2, 7]);
        let code = CODE.unwrap();
        assert_eq!(code.decode(), [5, 2, 7]);
        assert_eq!([code.octant(0), code.octant(1), code.octant(2), code.octant(3)], [1 + 4, 2 + 4, 1 + 4, 0]);
        assert_eq!(code.neighbour([-5, 1, 0]).unwrap().decode(), [0, 3, 7]);
        assert_eq!(code.neighbour([-6, 0, 0]), None);
        assert_eq!(Morton::encode([MAX_RESOLUTION - 1, 0, 0]).unwrap().neighbour([1, 0, 0]), None);
    }
}
