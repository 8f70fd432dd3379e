//! Symmetry-aware sparse voxel DAG: nodes and bricks that are mirror images of each other are stored once.
//!
//! In: flat words, checked once. Out: [`Geometry`], the same answers as the plain [`Dag`](crate::Dag) of the same voxels.
//! Source: Villanueva et al. (2016, sections 3 and 4). Differs: bricks of 4^3 are merged, too; nodes are numbered level by
//! level in the order of first visit, so that a child which comes for the first time needs no pointer: it is the next one,
//! as it is, without a mirror. Its number is a count of bits, as is the place of a pointer.
//!
//! ```text
//! word  0        depth L, 0 to 21                    then, from level L down to 3:
//!       1        bricks B                                blocks    6 words for 8 nodes
//!       2..=20   nodes of level 3, 4, .. 21              pointers  packed without gaps; 0 to a whole word
//!       21..=39  pointers of level 3, 4, .. 21       then the bricks: [ low 32 voxels ][ high 32 voxels ]
//! block     [ child masks, a byte a node, 2 words ][ which of these are new, 2 words ][ pointers before ][ new before ]
//!           byte i = node i of the block, its bit c = octant c; the last two count within the level
//! pointer   number of a node in the level below (as few bits as its count needs) | mirror << those bits (3 bits)
//! ```
//!
//! The children of a level that are not new have pointers, in order; the k-th new child is node (in level 3 brick) k of the
//! level below. Level L has one node, the root. Mirrors are those of `mirror`: bit 0 turns x round, 1 y, 2 z.

mod count;
#[cfg(feature = "alloc")]
mod merge;
mod mirror;
#[cfg(feature = "alloc")]
mod pack;

#[cfg(feature = "alloc")]
pub use pack::SsvdagBuf;

use crate::dag::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::morton::BITS;

/// Words before the first block.
pub const HEADER: usize = 40;
/// Words of a block, and its nodes.
const BLOCK: usize = 6;
const NODES: u32 = 8;
/// A node's number is its number within its level, below [`MOST`], and above it the mirror that it is seen in.
const PLACE: u32 = 28;
const MOST: u32 = 1 << PLACE;

/// Where a level's words lie.
#[derive(Clone, Copy, Debug, Default)]
struct Level {
    nodes: u32,
    blocks: usize,
    pointers: usize,
    /// Bits of a pointer without its mirror.
    bits: u32,
}

/// A checked view over an SSVDAG's words.
#[derive(Clone, Copy, Debug)]
pub struct Ssvdag<'a> {
    words: &'a [u32],
    depth: u8,
    /// By level; of level 2 only how many bricks there are and where (`blocks`).
    levels: [Level; 22],
}

/// Why words are no SSVDAG. Offsets count words from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SsvdagError {
    /// Another number of words than the header says.
    Length {
        /// Words that the header says.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// A number in the header that is out of range, or not what the blocks add up to.
    Header {
        /// Offset of the word.
        word: u32,
    },
    /// A block of nodes that have no child, of more nodes than there are, or whose counts are wrong.
    Block {
        /// Offset of its first word.
        word: u32,
    },
    /// A pointer to a node that is not there, or bits behind the last one.
    Pointer {
        /// Offset of the word in which it begins.
        word: u32,
    },
    /// A brick has no voxel, or one outside the cube.
    Brick {
        /// Offset of its low word.
        word: u32,
    },
}

impl core::fmt::Display for SsvdagError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            SsvdagError::Length { expected, found } => {
                write!(f, "the SSVDAG has {found} words: expected {expected}")
            }
            SsvdagError::Header { word } => {
                write!(f, "word {word} of the SSVDAG's header is out of range, or not what follows adds up to")
            }
            SsvdagError::Block { word } => {
                write!(f, "the block of nodes at word {word} is malformed: expected a child in each node, and counts")
            }
            SsvdagError::Pointer { word } => {
                write!(f, "the pointer at word {word} leads out of the level below, or is none")
            }
            SsvdagError::Brick { word } => write!(f, "the brick at word {word} is empty or reaches outside the cube"),
        }
    }
}

impl core::error::Error for SsvdagError {}

impl<'a> Ssvdag<'a> {
    /// Checks all that queries rely on in O(words), without heap. After `Ok` no query can panic or loop. Not checked, as no
    /// answer depends on it: that no node is a mirror image of another one.
    pub fn new(words: &'a [u32]) -> Result<Ssvdag<'a>, SsvdagError> {
        let found = words.len() as u64;
        if words.len() < HEADER {
            return Err(SsvdagError::Length { expected: HEADER as u64, found });
        }
        if words[0] > BITS {
            return Err(SsvdagError::Header { word: 0 });
        }
        let depth = words[0] as u8;
        let root = depth.max(BRICK_LEVEL);

        // Find where each level lies; one node at the root, none above, some below.
        let mut levels = [Level::default(); 22];
        let mut end = HEADER as u64;
        for level in (BRICK_LEVEL..=BITS as u8).rev() {
            let word = usize::from(level) - 1;
            let nodes = words[word];
            let expected = match level {
                _ if words[1] == 0 || level > root => 0..=0,
                _ if level == root => 1..=1,
                _ => 1..=MOST,
            };
            if !expected.contains(&nodes) {
                return Err(SsvdagError::Header { word: word as u32 });
            }
            let blocks = end as usize;
            if level == BRICK_LEVEL {
                end += 2 * u64::from(nodes);
                levels[usize::from(level)] = Level { nodes, blocks, ..Level::default() };
                break;
            }
            end += BLOCK as u64 * u64::from(nodes.div_ceil(NODES));
            let bits = bits_of(words[word - 1]);
            levels[usize::from(level)] = Level { nodes, blocks, pointers: end as usize, bits };
            end += (u64::from(words[pointers_word(level)]) * u64::from(bits + 3)).div_ceil(32);
        }
        if end != found {
            return Err(SsvdagError::Length { expected: end, found });
        }
        let dag = Ssvdag { words, depth, levels };
        for level in 3..=BITS as u8 {
            dag.check(level)?;
        }

        // Every brick holds a voxel, and none outside the cube.
        let inside = match depth {
            0 => 1,
            1 => 0xff,
            _ => u64::MAX,
        };
        for brick in 0..dag.levels[usize::from(BRICK_LEVEL)].nodes {
            let mask = dag.brick_at(brick);
            if mask == 0 || mask & !inside != 0 {
                let word = dag.levels[usize::from(BRICK_LEVEL)].blocks as u32 + 2 * brick;
                return Err(SsvdagError::Brick { word });
            }
        }
        Ok(dag)
    }

    /// Checks the blocks and pointers of a level: the counts are those of the bits before, and all children exist.
    fn check(&self, level: u8) -> Result<(), SsvdagError> {
        let Level { nodes, blocks, pointers, bits } = self.levels[usize::from(level)];
        let below = self.levels[usize::from(level) - 1].nodes;
        let expected = self.words[pointers_word(level)];
        let (mut old_before, mut new_before) = (0u64, 0u64);
        for i in 0..nodes.div_ceil(NODES) {
            let word = blocks + BLOCK * i as usize;
            let block = self.block(word);
            let filled = (nodes - NODES * i).min(NODES);
            let shape = block.children.to_le_bytes().iter().zip(0..).all(|(mask, k)| (*mask != 0) == (k < filled));
            let counts = [block.old_before, block.new_before].map(u64::from) == [old_before, new_before];
            if !shape || !counts || block.new & !block.children != 0 {
                return Err(SsvdagError::Block { word: word as u32 });
            }
            new_before += u64::from(block.new.count_ones());
            old_before += u64::from((block.children & !block.new).count_ones());
        }
        if old_before != u64::from(expected) {
            return Err(SsvdagError::Header { word: pointers_word(level) as u32 });
        }
        if nodes > 0 && new_before != u64::from(below) {
            return Err(SsvdagError::Header { word: u32::from(level) - 2 });
        }
        let width = bits + 3;
        let word = |bit: u64| (pointers as u64 + bit / 32) as u32;
        for i in 0..expected {
            if self.bits_at(pointers, i, width) & ((1 << bits) - 1) >= below {
                return Err(SsvdagError::Pointer { word: word(u64::from(i) * u64::from(width)) });
            }
        }
        let end = u64::from(expected) * u64::from(width);
        if !end.is_multiple_of(32) && self.words[pointers + (end / 32) as usize] >> (end % 32) != 0 {
            return Err(SsvdagError::Pointer { word: word(end) });
        }
        Ok(())
    }

    /// The words themselves; `Ssvdag::new(dag.words())` is the same view.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Octree levels L: the cube is 2^L voxels a side.
    pub fn depth(&self) -> u8 {
        self.depth
    }

    /// Stored nodes of a level, 3 or more; bricks for 2; otherwise 0.
    pub fn node_count(&self, level: u8) -> u32 {
        self.levels.get(usize::from(level)).map_or(0, |level| level.nodes)
    }

    /// The block that begins at a word.
    #[inline(always)]
    fn block(&self, word: usize) -> Block {
        let words = &self.words[word..word + BLOCK];
        Block {
            children: wide(words[0], words[1]),
            new: wide(words[2], words[3]),
            old_before: words[4],
            new_before: words[5],
        }
    }

    /// Number `index` of a list of numbers of `width` bits, 1 to 31, that begins at a word and is not the last of the words.
    #[inline(always)]
    fn bits_at(&self, start: usize, index: u32, width: u32) -> u32 {
        let bit = u64::from(index) * u64::from(width);
        let word = start + (bit / 32) as usize;
        let two = wide(self.words[word], self.words[word + 1]);
        (two >> (bit % 32)) as u32 & ((1 << width) - 1)
    }
}

/// Eight nodes.
struct Block {
    children: u64,
    new: u64,
    old_before: u32,
    new_before: u32,
}

/// The header's word for the pointers of a level.
const fn pointers_word(level: u8) -> usize {
    level as usize + 18
}

/// How many bits numbers below `count` take.
const fn bits_of(count: u32) -> u32 {
    u32::BITS - count.saturating_sub(1).leading_zeros()
}

#[inline(always)]
fn wide(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

impl Geometry for Ssvdag<'_> {
    #[inline]
    fn depth(&self) -> u8 {
        self.depth
    }

    #[inline]
    fn is_empty(&self) -> bool {
        self.words[1] == 0
    }

    #[inline]
    fn root(&self) -> u32 {
        0
    }

    #[inline]
    fn is_node(&self, node: u32, level: u8) -> bool {
        node < 8 << PLACE && node % MOST < self.node_count(level)
    }

    #[inline]
    fn child(&self, node: u32, level: u8, octant: u32) -> Option<u32> {
        let (mirror, number) = (node >> PLACE, node % MOST);
        let level = &self.levels[usize::from(level)];
        let block = self.block(level.blocks + BLOCK * (number / NODES) as usize);
        let bit = (8 * (number % NODES)) | (octant ^ mirror) & 7;
        if block.children >> bit & 1 == 0 {
            return None;
        }
        let before = (1 << bit) - 1;
        let child = if block.new >> bit & 1 != 0 {
            block.new_before + (block.new & before).count_ones()
        } else {
            let old = block.old_before + (block.children & !block.new & before).count_ones();
            let pointer = self.bits_at(level.pointers, old, level.bits + 3);
            pointer >> level.bits << PLACE | pointer & ((1 << level.bits) - 1)
        };
        Some(child ^ mirror << PLACE)
    }

    #[inline]
    fn mask(&self, node: u32, level: u8) -> u8 {
        let (mirror, number) = (node >> PLACE, node % MOST);
        let block = self.block(self.levels[usize::from(level)].blocks + BLOCK * (number / NODES) as usize);
        mirror::octants((block.children >> (8 * (number % NODES))) as u8, mirror)
    }

    #[inline]
    fn brick_at(&self, brick: u32) -> u64 {
        let (mirror, number) = (brick >> PLACE, brick % MOST);
        let word = self.levels[usize::from(BRICK_LEVEL)].blocks + 2 * number as usize;
        mirror::brick(wide(self.words[word], self.words[word + 1]), mirror)
    }
}
