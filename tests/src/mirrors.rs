//! Naive twins of the SSVDAG: sets of voxels up to mirrors, and a reader that knows nothing but the documentation.
//!
//! In: a set of voxels, or words. Out: how many subtrees of a level remain if mirror images count once, and the voxels that
//! words stand for. The twin mirrors coordinates, one voxel at a time; it knows no nodes, no bit tricks and no hashes.

use std::collections::BTreeSet;

use crate::octree::{VoxelSet, deinterleave, interleave};

/// Different subtrees of a level if mirror images of each other count as one.
pub fn classes(set: &VoxelSet, level: u8) -> usize {
    let shift = 3 * u32::from(level);
    let pieces = set.codes().chunk_by(|a, b| a >> shift == b >> shift);
    let side = 1u32 << level;
    let least = |piece: &[u64]| {
        let forms = (0..8).map(|mirror: u32| {
            let mirrored = |code: &u64| {
                let voxel = deinterleave(code & ((1 << shift) - 1));
                std::array::from_fn(|k| if mirror >> k & 1 != 0 { side - 1 - voxel[k] } else { voxel[k] })
            };
            let mut form: Vec<[u32; 3]> = piece.iter().map(mirrored).collect();
            form.sort_unstable();
            form
        });
        forms.min().expect("there are eight mirrors")
    };
    pieces.map(least).collect::<BTreeSet<_>>().len()
}

/// The voxels of an SSVDAG's words, read by the documentation alone. The words must be valid.
pub fn voxels(words: &[u32]) -> VoxelSet {
    let mut found = Vec::new();
    let root = words[0].max(2);
    let mut reader = Reader { words, found: &mut found };
    if words[4] > 0 {
        reader.walk(root, 0, 0, [0; 3]);
    }
    VoxelSet::new(found)
}

struct Reader<'a> {
    words: &'a [u32],
    found: &'a mut Vec<[u32; 3]>,
}

impl Reader<'_> {
    /// A bit behind a word.
    fn bit(&self, word: u32, bit: u64) -> bool {
        self.words[word as usize + (bit / 32) as usize] >> (bit % 32) & 1 != 0
    }

    fn number(&self, word: u32, first: u64, bits: u32) -> u32 {
        (0..bits).map(|i| u32::from(self.bit(word, first + u64::from(i))) << i).sum()
    }

    /// Walks the node or brick, seen in a mirror, whose cube has its first corner here.
    fn walk(&mut self, level: u32, node: u32, mirror: u32, corner: [u32; 3]) {
        let row = 4 * (level - 1) as usize;
        let [_, blocks, pointers, bits] = [0, 1, 2, 3].map(|i| self.words[row + i]);
        let turned = |v: [u32; 3], side: u32| -> [u32; 3] {
            std::array::from_fn(|k| corner[k] + if mirror >> k & 1 != 0 { side - 1 - v[k] } else { v[k] })
        };
        if level == 2 {
            for code in 0..64 {
                if self.bit(blocks + 2 * node, code) {
                    self.found.push(turned(deinterleave(code), 4));
                }
            }
            return;
        }
        // Go through all children of the level up to this node's, counting new ones and pointers.
        let (mut new, mut old) = (0u32, 0u32);
        for n in 0..=node {
            let block = blocks + 6 * (n / 8);
            for octant in 0..8u32 {
                let at = u64::from(8 * (n % 8) + octant);
                if !self.bit(block, at) {
                    continue;
                }
                let (child, its_mirror) = if self.bit(block, 64 + at) {
                    new += 1;
                    (new - 1, 0)
                } else {
                    let first = u64::from(old) * u64::from(bits + 3);
                    old += 1;
                    (self.number(pointers, first, bits), self.number(pointers, first + u64::from(bits), 3))
                };
                if n == node {
                    let half = 1 << (level - 1);
                    let place = turned([octant & 1, octant >> 1 & 1, octant >> 2], 2);
                    let place = std::array::from_fn(|k| corner[k] + (place[k] - corner[k]) * half);
                    self.walk(level - 1, child, mirror ^ its_mirror, place);
                }
            }
        }
    }
}

/// The set, and its mirror images on these axes within the cube of side 2^`depth`.
pub fn with_images(set: &VoxelSet, depth: u8, axes: u32) -> VoxelSet {
    let last = (1u32 << depth) - 1;
    let images = (0..8u32).filter(|mirror| mirror & !axes == 0);
    let voxels = |mirror: u32| {
        let turned = move |k: usize, x: u32| if mirror >> k & 1 != 0 { last - x } else { x };
        set.codes().iter().map(move |code| {
            let voxel = deinterleave(*code);
            std::array::from_fn(|k| turned(k, voxel[k]))
        })
    };
    VoxelSet::new(images.flat_map(voxels))
}

/// Code of a voxel mirrored on these axes within the cube of side 2^`depth`.
pub fn image(code: u64, depth: u8, axes: u32) -> u64 {
    let (voxel, last) = (deinterleave(code), (1u32 << depth) - 1);
    interleave(std::array::from_fn(|k| if axes >> k & 1 != 0 { last - voxel[k] } else { voxel[k] }))
}
