//! The eight mirrors of a cube: bit i of a mirror turns axis i round. They commute, and each undoes itself.

/// Per axis: how far apart its two bits of an index stand that differ in both, and in opposite ways; the bits of a brick
/// whose index has neither set, and of those that have the low one only.
const AXES: [(u32, u32, u64, u64); 3] = {
    let mut axes = [(0, 0, 0, 0); 3];
    let mut axis = 0;
    while axis < 3 {
        let (low, high) = (1u32 << axis, 8u32 << axis);
        let (mut neither, mut only_low) = (0u64, 0u64);
        let mut index = 0;
        while index < 64 {
            if index & high == 0 {
                if index & low == 0 {
                    neither |= 1 << index;
                } else {
                    only_low |= 1 << index;
                }
            }
            index += 1;
        }
        axes[axis] = (high + low, high - low, neither, only_low);
        axis += 1;
    }
    axes
};

/// The 4^3 voxels of a brick, mirrored. A voxel at index i goes to i with both bits of each mirrored axis turned.
#[inline]
pub(super) fn brick(mut voxels: u64, mirror: u32) -> u64 {
    for (axis, (both, one, neither, only_low)) in AXES.into_iter().enumerate() {
        let turned = voxels >> both & neither
            | (voxels & neither) << both
            | voxels >> one & only_low
            | (voxels & only_low) << one;
        voxels = if mirror >> axis & 1 != 0 { turned } else { voxels };
    }
    voxels
}

/// The octants of a node, mirrored.
#[inline]
pub(super) fn octants(mask: u8, mirror: u32) -> u8 {
    let x = if mirror & 1 != 0 { mask >> 1 & 0x55 | (mask & 0x55) << 1 } else { mask };
    let y = if mirror & 2 != 0 { x >> 2 & 0x33 | (x & 0x33) << 2 } else { x };
    if mirror & 4 != 0 { y.rotate_left(4) } else { y }
}

#[cfg(test)]
mod tests {
    /// Bit by bit, every mirror of every single voxel and octant.
    #[test]
    fn mirrors_turn_the_bits_of_indices() {
        for mirror in 0..8u32 {
            for index in 0..64 {
                assert_eq!(super::brick(1 << index, mirror), 1 << (index ^ (mirror | mirror << 3)));
            }
            for octant in 0..8 {
                assert_eq!(super::octants(1 << octant, mirror), 1 << (octant ^ mirror));
            }
        }
    }
}
