//! Symmetry-aware sparse voxel DAG: nodes and bricks that are mirror images of each other are stored once.
//!
//! In: flat words, checked once. Out: [`Geometry`], the same answers as the plain [`Dag`](crate::Dag) of the same voxels.
//! Source: Villanueva et al. (2016, sections 3 and 4). Differs: bricks of 4^3 are merged, too; nodes are numbered level by
//! level in the order of first visit, so that a child which comes for the first time needs no pointer: it is the next one,
//! as it is, without a mirror. Its number is a count of bits, as is the place of a pointer.
//!
//! ```text
//! word  0       depth L, 0 to 21; then 0, 0, 0
//!       4..     a row for each level from 2 (the bricks) to max(L, 2), the root's:
//!               [ nodes n ][ word of its blocks ][ word of its pointers ][ bits b of a number in the level below ]
//!               of level 2: [ bricks ][ word of the first ][ 0 ][ 0 ]
//!       then    from the root's level down to 3: its blocks, 6 words for 8 nodes, and its pointers, b + 3 bits each,
//!               packed from the lowest bit on, 0 to a whole word; then the bricks: [ low 32 voxels ][ high 32 voxels ]
//! block         [ child masks, a byte a node ][   ][ which of these are new ][   ][ pointers before ][ new before ]
//!               byte i is node i of the block, its bit c octant c; the last two count within the level
//! pointer       number of a node in the level below | mirror << b: bit 0 turns x round, 1 y, 2 z
//! ```
//!
//! The children that are not new have pointers, in order; the k-th new one is node (brick) k of the level below.

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

/// Words of a row of the header. Row `level - 1` is that of a level, row 0 the depth.
const ROW: usize = 4;
/// Words of a block, and its nodes.
const BLOCK: usize = 6;
const NODES: u32 = 8;
/// A node's number is its number within its level, below [`MOST`], and above it the mirror that it is seen in.
const PLACE: u32 = 28;
const MOST: u32 = 1 << PLACE;

/// A checked view over an SSVDAG's words.
#[derive(Clone, Copy, Debug)]
pub struct Ssvdag<'a> {
    words: &'a [u32],
    depth: u8,
}

/// A level's row of the header.
struct Row {
    nodes: u32,
    blocks: u32,
    pointers: u32,
    /// Bits of a pointer without its mirror.
    bits: u32,
}

impl Row {
    /// All but the number of nodes, which follows from the numbers of nodes of all levels.
    fn place(&self) -> [u64; 3] {
        [self.blocks, self.pointers, self.bits].map(u64::from)
    }
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
        let depth = words.first().copied().unwrap_or(0);
        if depth > BITS {
            return Err(SsvdagError::Header { word: 0 });
        }
        let root = (depth as u8).max(BRICK_LEVEL);
        let header = ROW * usize::from(root);
        if words.len() < header {
            return Err(SsvdagError::Length { expected: header as u64, found });
        }
        if let Some(word) = (1..ROW).find(|&word| words[word] != 0) {
            return Err(SsvdagError::Header { word: word as u32 });
        }
        let dag = Ssvdag { words, depth: depth as u8 };

        // There is one root, and something in every level below it; or nothing at all.
        for level in BRICK_LEVEL..=root {
            let expected = match level {
                _ if dag.is_empty() => 0..=0,
                _ if level == root => 1..=1,
                _ => 1..=MOST,
            };
            if !expected.contains(&dag.row(level).nodes) {
                return Err(SsvdagError::Header { word: row_start(level) as u32 });
            }
        }
        // The levels lie one after the other, from the root's down to the bricks.
        let mut end = header as u64;
        for level in (3..=root).rev() {
            end = dag.check(level, end)?;
        }
        let bricks = dag.node_count(BRICK_LEVEL);
        if dag.row(BRICK_LEVEL).place() != [end, 0, 0] {
            return Err(SsvdagError::Header { word: row_start(BRICK_LEVEL) as u32 + 1 });
        }
        end = dag.reaches(end + 2 * u64::from(bricks))?;
        if end != found {
            return Err(SsvdagError::Length { expected: end, found });
        }

        // Every brick holds a voxel, and none outside the cube.
        let inside = match depth {
            0 => 1,
            1 => 0xff,
            _ => u64::MAX,
        };
        for brick in 0..bricks {
            let mask = dag.brick_at(brick);
            if mask == 0 || mask & !inside != 0 {
                return Err(SsvdagError::Brick { word: dag.row(BRICK_LEVEL).blocks + 2 * brick });
            }
        }
        Ok(dag)
    }

    /// That there are words up to `end`, which is given back.
    fn reaches(&self, end: u64) -> Result<u64, SsvdagError> {
        let found = self.words.len() as u64;
        if end > found { Err(SsvdagError::Length { expected: end, found }) } else { Ok(end) }
    }

    /// Checks the row, blocks and pointers of a level that begins at word `start`, and says where it ends: the counts are
    /// those of the bits before, and all children exist.
    fn check(&self, level: u8, start: u64) -> Result<u64, SsvdagError> {
        let (row, below) = (self.row(level), self.node_count(level - 1));
        let pointers = start + BLOCK as u64 * u64::from(row.nodes.div_ceil(NODES));
        if row.place() != [start, pointers, bits_of(below).into()] {
            return Err(SsvdagError::Header { word: row_start(level) as u32 + 1 });
        }
        self.reaches(pointers)?;

        // Sum up the blocks.
        let (mut old_before, mut new_before) = (0u64, 0u64);
        for (i, word) in (0..).zip((start..pointers).step_by(BLOCK)) {
            let block = self.block(word as usize);
            let here = (row.nodes - NODES * i).min(NODES);
            let shape = block.children.to_le_bytes().iter().zip(0..).all(|(mask, k)| (*mask != 0) == (k < here));
            let counts = [block.old_before, block.new_before].map(u64::from) == [old_before, new_before];
            if !shape || !counts || block.new & !block.children != 0 {
                return Err(SsvdagError::Block { word: word as u32 });
            }
            new_before += u64::from(block.new.count_ones());
            old_before += u64::from((block.children & !block.new).count_ones());
        }
        if new_before != u64::from(below) {
            return Err(SsvdagError::Header { word: row_start(level - 1) as u32 });
        }

        // Follow the pointers. The bricks are behind them, so that there is always one word more.
        let width = row.bits + 3;
        let bits = old_before * u64::from(width);
        let end = pointers + bits.div_ceil(32);
        self.reaches(end + 2 * u64::from(self.node_count(BRICK_LEVEL)))?;
        let at = |bit: u64| SsvdagError::Pointer { word: (pointers + bit / 32) as u32 };
        for i in 0..old_before {
            if self.pointer(&row, i as u32) % (1 << row.bits) >= below {
                return Err(at(i * u64::from(width)));
            }
        }
        if !bits.is_multiple_of(32) && self.words[end as usize - 1] >> (bits % 32) != 0 {
            return Err(at(bits));
        }
        Ok(end)
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
        if (BRICK_LEVEL..=self.depth.max(BRICK_LEVEL)).contains(&level) { self.row(level).nodes } else { 0 }
    }

    /// The number of a stored node or brick within its level, below [`Ssvdag::node_count`]: the same in whatever mirror it is
    /// seen. What is kept for each stored node (rank's totals) is found by it.
    #[inline]
    pub fn number(node: u32) -> u32 {
        node % MOST
    }

    /// The header's row of a level from 2 to the root's.
    #[inline(always)]
    fn row(&self, level: u8) -> Row {
        let start = row_start(level);
        let row = &self.words[start..start + ROW];
        Row { nodes: row[0], blocks: row[1], pointers: row[2], bits: row[3] }
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

    /// A pointer of a level, of `bits + 3` bits. There is a word behind the one that it ends in.
    #[inline(always)]
    fn pointer(&self, row: &Row, index: u32) -> u32 {
        let width = row.bits + 3;
        let bit = u64::from(index) * u64::from(width);
        let word = row.pointers as usize + (bit / 32) as usize;
        let two = wide(self.words[word], self.words[word + 1]);
        (two >> (bit % 32)) as u32 & ((1 << width) - 1)
    }
}

/// Eight nodes: which children they have and which of these are new, bit `8 node + octant`; and the level's counts before.
struct Block {
    children: u64,
    new: u64,
    old_before: u32,
    new_before: u32,
}

/// Offset of the header's row of a level from 2.
const fn row_start(level: u8) -> usize {
    ROW * (level as usize - 1)
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
        self.row(BRICK_LEVEL).nodes == 0
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
        let row = self.row(level);
        let block = self.block(row.blocks as usize + BLOCK * (number / NODES) as usize);
        let bit = (8 * (number % NODES)) | (octant ^ mirror) & 7;
        if block.children >> bit & 1 == 0 {
            return None;
        }
        let before = (1 << bit) - 1;
        let child = if block.new >> bit & 1 != 0 {
            block.new_before + (block.new & before).count_ones()
        } else {
            let old = block.children & !block.new;
            let pointer = self.pointer(&row, block.old_before + (old & before).count_ones());
            (pointer >> row.bits << PLACE) | (pointer % (1 << row.bits))
        };
        Some(child ^ mirror << PLACE)
    }

    #[inline]
    fn mask(&self, node: u32, level: u8) -> u8 {
        let (mirror, number) = (node >> PLACE, node % MOST);
        let block = self.block(self.row(level).blocks as usize + BLOCK * (number / NODES) as usize);
        mirror::octants((block.children >> (8 * (number % NODES))) as u8, mirror)
    }

    #[inline]
    fn brick_at(&self, brick: u32) -> u64 {
        let (mirror, number) = (brick >> PLACE, brick % MOST);
        let word = self.row(BRICK_LEVEL).blocks as usize + 2 * number as usize;
        mirror::brick(wide(self.words[word], self.words[word + 1]), mirror)
    }
}
