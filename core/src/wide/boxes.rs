//! How far the space ahead is empty in a grid of 4^3 cells or voxels, for all of them at once.
//!
//! Sets of cells are masks in the order x + 4 y + 16 z; a step to the neighbours is a shift.

use super::BRICK_WORDS;
use crate::morton::Morton;

/// Bits of the cells that have a neighbour in negative and in positive direction along each axis.
const INNER: [[u64; 2]; 3] = {
    let mut inner = [[0; 2]; 3];
    let mut cell = 0;
    while cell < 64 {
        let mut axis = 0;
        while axis < 3 {
            let at = cell >> (2 * axis) & 3;
            inner[axis][0] |= ((at > 0) as u64) << cell;
            inner[axis][1] |= ((at < 3) as u64) << cell;
            axis += 1;
        }
        cell += 1;
    }
    inner
};

/// Which cells have a neighbour in a set along an axis.
#[inline(always)]
fn beside(set: u64, axis: usize, up: usize) -> u64 {
    let shift = 1 << (2 * axis);
    (if up != 0 { set >> shift } else { set << shift }) & INNER[axis][up]
}

/// Shapes of boxes in the order of how much they are liked: the largest, of equal ones those nearest to a cube.
const SHAPES: [u8; 64] = {
    let mut shapes = [0; 64];
    let mut shape = 0;
    while shape < 64 {
        shapes[shape] = shape as u8;
        // Insertion sort.
        let mut at = shape;
        while at > 0 && worth(shapes[at - 1]) < worth(shapes[at]) {
            (shapes[at - 1], shapes[at]) = (shapes[at], shapes[at - 1]);
            at -= 1;
        }
        shape += 1;
    }
    shapes
};

const fn worth(shape: u8) -> u32 {
    let [x, y, z] = [(shape & 3) as u32 + 1, (shape >> 2 & 3) as u32 + 1, (shape >> 4) as u32 + 1];
    64 * x * y * z - (x + y + z)
}

/// For rays to an octant the box of every cell of the set `empty`, in the words' code: the most empty cells ahead.
pub(super) fn boxes(empty: u64, octant: usize) -> [u8; 64] {
    // Which cells begin an empty box of each shape: one that is a cell longer follows from its neighbour's.
    let mut begins = [0; 64];
    for shape in 0..64usize {
        let axis = match shape {
            0 => None,
            _ if shape >> 4 != 0 => Some(2),
            _ if shape >> 2 != 0 => Some(1),
            _ => Some(0),
        };
        begins[shape] = match axis {
            None => empty,
            Some(axis) => {
                let shorter = begins[shape - (1 << (2 * axis))];
                let flat = begins[shape & !(3 << (2 * axis))];
                flat & beside(shorter, axis, octant >> axis & 1)
            }
        };
    }
    let (mut boxes, mut left) = ([0; 64], empty);
    for shape in SHAPES {
        let mut cells = begins[usize::from(shape)] & left;
        left &= !cells;
        while cells != 0 {
            boxes[cells.trailing_zeros() as usize] = shape;
            cells &= cells - 1;
        }
    }
    boxes
}

/// Where the voxels of a mask in Morton order lie in the order of cells.
const CELLS: [u8; 64] = {
    let mut cells = [0; 64];
    let mut bit = 0;
    while bit < 64 {
        let [x, y, z] = Morton(bit).decode();
        cells[bit as usize] = (x + 4 * y + 16 * z) as u8;
        bit += 1;
    }
    cells
};

/// A brick's words, for voxels in Morton order.
pub(super) fn brick_words(voxels: u64) -> [u32; BRICK_WORDS] {
    let (mut filled, mut codes) = (0, [0u16; 64]);
    for (bit, &cell) in CELLS.iter().enumerate() {
        filled |= (voxels >> bit & 1) << cell;
        // Alike for all octants: 2 where the 2^3 around are empty, else 1.
        let alike = if voxels >> (bit & 0o70) & 0xff == 0 { 0xaaaa } else { 0x5555 };
        codes[usize::from(cell)] = if voxels >> bit & 1 != 0 { 0 } else { alike };
    }
    for octant in 0..8 {
        // Whatever lies behind a filled voxel on some way to the octant has it ahead.
        let mut ahead = filled;
        for axis in 0..3 {
            for _ in 0..3 {
                ahead |= beside(ahead, axis, octant >> axis & 1);
            }
        }
        for (cell, code) in codes.iter_mut().enumerate() {
            *code |= (if ahead >> cell & 1 == 0 { 3 } else { 0 }) << (2 * octant);
        }
    }
    core::array::from_fn(|pair| u32::from(codes[2 * pair]) | u32::from(codes[2 * pair + 1]) << 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg_attr(miri, ignore = "minutes, and nothing but shifts")]
    fn boxes_are_empty_and_the_largest() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for round in 0..60 {
            // Sets of all densities.
            let mut empty = u64::MAX;
            for _ in 0..round % 4 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                empty &= state ^ state >> 29;
            }
            for octant in 0..8usize {
                let boxes = boxes(empty, octant);
                for cell in (0..64usize).filter(|cell| empty >> cell & 1 != 0) {
                    let c = [cell & 3, cell >> 2 & 3, cell >> 4];
                    let holds = |size: [usize; 3]| {
                        (0..64usize).filter(|at| (0..3).all(|i| at >> (2 * i) & 3 < size[i])).all(|at| {
                            let place: [Option<usize>; 3] = core::array::from_fn(|i| {
                                let step = at >> (2 * i) & 3;
                                let x = if octant >> i & 1 != 0 { c[i] + step } else { c[i].wrapping_sub(step) };
                                (x < 4).then_some(x)
                            });
                            matches!(place, [Some(x), Some(y), Some(z)] if empty >> (x + 4 * y + 16 * z) & 1 != 0)
                        })
                    };
                    let found = [boxes[cell] & 3, boxes[cell] >> 2 & 3, boxes[cell] >> 4].map(|k| usize::from(k) + 1);
                    assert!(holds(found), "{empty:x} {octant} {cell}");
                    let volume = |size: [usize; 3]| size[0] * size[1] * size[2];
                    let largest = (0..64usize).map(|s| [1 + (s & 3), 1 + (s >> 2 & 3), 1 + (s >> 4)]);
                    let largest = largest.filter(|size| holds(*size)).map(volume).max();
                    assert_eq!(Some(volume(found)), largest, "{empty:x} {octant} {cell}");
                }
            }
        }
    }

    #[test]
    #[cfg_attr(miri, ignore = "minutes, and nothing but shifts")]
    fn bricks_say_what_is_empty() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for round in 0..100 {
            let mut voxels = u64::MAX;
            for _ in 0..round % 6 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                voxels &= state ^ state >> 29;
            }
            let filled = |p: [u32; 3]| voxels >> Morton::encode(p).unwrap().0 & 1 != 0;
            let words = brick_words(voxels);
            for cell in 0..64u32 {
                let p = [cell & 3, cell >> 2 & 3, cell >> 4];
                let among = |inside: &dyn Fn(usize, u32) -> bool| {
                    (0..64u32)
                        .map(|c| [c & 3, c >> 2 & 3, c >> 4])
                        .filter(|q| (0..3).all(|i| inside(i, q[i])))
                        .any(filled)
                };
                for octant in 0..8u32 {
                    let code = words[cell as usize / 2] >> (16 * (cell & 1) + 2 * octant) & 3;
                    let ahead = among(&|i, x| if octant >> i & 1 != 0 { x >= p[i] } else { x <= p[i] });
                    let around = among(&|i, x| x / 2 == p[i] / 2);
                    let expected = match (filled(p), ahead, around) {
                        (true, ..) => 0,
                        (_, false, _) => 3,
                        (_, _, false) => 2,
                        _ => 1,
                    };
                    assert_eq!(code, expected, "{voxels:x}, cell {cell}, octant {octant}");
                }
            }
        }
    }
}
