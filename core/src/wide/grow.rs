//! Making a wide tree from a geometry, level by level from the root.

use alloc::vec::Vec;

use super::{EMPTY_CELL, Wide, place};
use crate::geometry::{BRICK_LEVEL, Geometry};

/// A wide tree that owns its words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct WideBuf {
    words: Vec<u32>,
    depth: u8,
}

/// Room for `len` items, or the number of bytes that could not be had.
fn room<T>(len: usize) -> Result<Vec<T>, usize> {
    let mut list = Vec::new();
    list.try_reserve_exact(len).map_err(|_| len.saturating_mul(size_of::<T>()))?;
    Ok(list)
}

impl WideBuf {
    /// The wide tree of a geometry; `Err` with the number of bytes that it needs if they are more than `limit`, or cannot
    /// be had.
    pub fn new<G: Geometry>(geometry: &G, limit: usize) -> Result<WideBuf, usize> {
        let depth = geometry.depth();
        let mut tree = WideBuf { words: Vec::new(), depth };
        if geometry.is_empty() {
            return Ok(tree);
        }
        // The nodes of each level that becomes one of the tree's, in the order of their numbers.
        let top = depth.max(BRICK_LEVEL).next_multiple_of(2);
        let mut nodes = room(1)?;
        nodes.push(geometry.root());
        let mut level = top;
        let mut used = 0;
        while level > BRICK_LEVEL {
            used += 256 * nodes.len();
            let mut below = Vec::new();
            for &node in &nodes {
                let mut children = [geometry.root(); 64];
                let count = grandchildren(geometry, node, level, |i, _, child| {
                    children[i] = child;
                });
                below.try_reserve(count).map_err(|_| used + 4 * (below.len() + count))?;
                below.extend_from_slice(&children[..count]);
            }
            below.sort_unstable();
            below.dedup();
            if used > limit {
                return Err(used);
            }
            let first = tree.words.len();
            tree.words.try_reserve(64 * nodes.len()).map_err(|_| used)?;
            let next = (first + 64 * nodes.len()) as u32;
            if next >= EMPTY_CELL - 64 {
                return Err(used);
            }
            for &node in &nodes {
                let mut cells = [EMPTY_CELL | 1 << (level - 1); 64];
                for octant in 0..8 {
                    let filled = if level > depth { octant == 0 } else { geometry.child(node, level, octant).is_some() };
                    if filled {
                        for c in 0..8 {
                            cells[(place(octant, 2) + place(c, 1)) as usize] = EMPTY_CELL | 1 << (level - 2);
                        }
                    }
                }
                grandchildren(geometry, node, level, |_, cell, child| {
                    let at = below.binary_search(&child).unwrap_or(0) as u32;
                    cells[cell] = next + if level - 2 == BRICK_LEVEL { 2 * at } else { 64 * at };
                });
                tree.words.extend_from_slice(&cells);
            }
            nodes = below;
            level -= 2;
        }
        used += 8 * nodes.len();
        if used > limit {
            return Err(used);
        }
        tree.words.try_reserve(2 * nodes.len()).map_err(|_| used)?;
        tree.words.extend(nodes.iter().map(|&brick| geometry.brick_at(brick)).flat_map(|b| [b as u32, (b >> 32) as u32]));
        Ok(tree)
    }

    /// The view that a tracer takes.
    pub fn as_wide(&self) -> Wide<'_> {
        Wide { words: &self.words, depth: self.depth }
    }
}

/// Calls `each` with the number, the cell and the node of every child two levels below a node of `level`, which may be one
/// above the root; returns how many there are.
fn grandchildren<G: Geometry>(geometry: &G, node: u32, level: u8, mut each: impl FnMut(usize, usize, u32)) -> usize {
    let mut count = 0;
    for octant in 0..8 {
        let child = if level > geometry.depth() {
            (octant == 0).then_some(node)
        } else {
            geometry.child(node, level, octant)
        };
        let Some(child) = child else { continue };
        for c in 0..8 {
            if let Some(grandchild) = geometry.child(child, level - 1, c) {
                each(count, (place(octant, 2) + place(c, 1)) as usize, grandchild);
                count += 1;
            }
        }
    }
    count
}
