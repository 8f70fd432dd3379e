//! Making a wide tree: from the root down, two levels at a time, each node once.

use alloc::vec::Vec;

use super::boxes::{boxes, brick_words};
use super::{BRICK_WORDS, EMPTY_CELL, EMPTY_OCTANT, NODE_WORDS, Wide, place};
use crate::geometry::{BRICK_LEVEL, Geometry};

/// A wide tree that owns its words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct WideBuf {
    words: Vec<u32>,
    depth: u8,
    starts: [u32; 13],
}

impl WideBuf {
    /// The wide tree of a geometry; `Err` with a number of bytes that it needs at least, if they are more than `limit`,
    /// cannot be had, or are beyond 2^33. While it is made, it takes up to twice as much, and beside that a list of nodes.
    pub fn new<G: Geometry>(geometry: &G, limit: usize) -> Result<WideBuf, usize> {
        let depth = geometry.depth();
        let mut tree = WideBuf { words: Vec::new(), depth, starts: [0; 13] };
        if geometry.is_empty() {
            return Ok(tree);
        }
        // The nodes of a level, in the order of their numbers.
        let mut nodes = Vec::new();
        nodes.try_reserve(1).map_err(|_| size_of::<u32>())?;
        nodes.push(geometry.root());
        for level in (BRICK_LEVEL + 2..=depth.max(BRICK_LEVEL).next_multiple_of(2)).rev().step_by(2) {
            // Find the nodes two levels below.
            let (mut below, mut known) = (Vec::<u32>::new(), 1 << 16);
            for &node in &nodes {
                let needed = tree.bytes() + size_of::<u32>() * (below.len() + 64);
                below.try_reserve(64).map_err(|_| needed)?;
                each_cell(geometry, node, level, |_, child| below.extend(child));
                // Neighbours often share what is below; keep the list short.
                if below.len() >= 2 * known {
                    below.sort_unstable();
                    below.dedup();
                    known = below.len().max(1 << 16);
                }
            }
            below.sort_unstable();
            below.dedup();

            // Write the nodes; those below them follow in their order.
            let words = if level - 2 == BRICK_LEVEL { BRICK_WORDS } else { NODE_WORDS };
            let first = tree.words.len() + NODE_WORDS * nodes.len();
            let needed = size_of::<u32>() * (first + words * below.len());
            if needed > limit || first + words * below.len() > EMPTY_CELL as usize {
                return Err(needed);
            }
            tree.words.try_reserve_exact(NODE_WORDS * nodes.len()).map_err(|_| needed)?;
            for &node in &nodes {
                let mut cells = [EMPTY_CELL | EMPTY_OCTANT; 64];
                each_cell(geometry, node, level, |cell, child| {
                    cells[cell] = match child {
                        Some(child) => (first + words * below.partition_point(|&other| other < child)) as u32,
                        None => EMPTY_CELL,
                    };
                });
                let empty = (0..64).fold(0, |set, cell| set | u64::from(cells[cell] >= EMPTY_CELL) << cell);
                for half in 0..2 {
                    let mut words = cells;
                    for o in 0..4 {
                        let boxes = boxes(empty, 4 * half + o);
                        words.iter_mut().zip(boxes).for_each(|(word, shape)| *word |= u32::from(shape) << (6 * o));
                    }
                    tree.words.extend_from_slice(&words);
                }
            }
            nodes = below;
            tree.starts[usize::from(level / 2 - 1)] = first as u32;
        }
        let needed = tree.bytes() + size_of::<u32>() * (BRICK_WORDS + 2) * nodes.len();
        let words = (BRICK_WORDS + 2) * nodes.len();
        if needed > limit
            || tree.words.len() + words > EMPTY_CELL as usize
            || tree.words.try_reserve_exact(words).is_err()
        {
            return Err(needed);
        }
        for &brick in &nodes {
            tree.words.extend_from_slice(&brick_words(geometry.brick_at(brick)));
        }
        tree.starts[0] = tree.words.len() as u32;
        for brick in nodes {
            let voxels = geometry.brick_at(brick);
            tree.words.extend([voxels as u32, (voxels >> 32) as u32]);
        }
        Ok(tree)
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.words[..])
    }

    /// The view that a tracer takes.
    pub fn as_wide(&self) -> Wide<'_> {
        Wide { words: &self.words, depth: self.depth, starts: &self.starts }
    }
}

/// Calls `each` with every cell in the filled octants of a node of `level`, and the node that it holds. The level may be
/// one above the root: its node is the first octant then.
fn each_cell<G: Geometry>(geometry: &G, node: u32, level: u8, mut each: impl FnMut(usize, Option<u32>)) {
    for octant in 0..8 {
        let child = match level > geometry.depth() {
            true => (octant == 0).then_some(node),
            false => geometry.child(node, level, octant),
        };
        let Some(child) = child else { continue };
        for c in 0..8 {
            each((place(octant, 2) + place(c, 1)) as usize, geometry.child(child, level - 1, c));
        }
    }
}
