//! The sparse voxel DAG: a borrowed view over flat words, checked once (after Kaempe et al. 2013, section 4).
//!
//! In: little-endian `u32` words. Out: total queries that cannot panic, loop or allocate. The DAG knows geometry only.
//!
//! ```text
//! word  0        depth L, 0 to 21                    node:  [ 1 << 31 | child mask ][ child ]...  one per set bit
//!       1        number of bricks B                  child: word offset of a node in the level below,
//!       2..=21   start of level 3, 4, .. 21, end            in level 3 of a brick; bit 31 clear
//!       22, 23   0                                   brick: [ low 32 voxels ][ high 32 voxels ]
//!       24..     bricks, two words each                     bit = Morton code within the 4^3 voxels
//!       then     nodes of level 3, of level 4, .. of level L (one node: the root)
//! ```
//!
//! Level h spans 2^h voxels a side; a brick is level 2, and the root too where L < 2. Children lie below their parents,
//! so no cycle can be written. Bricks and nodes are unique and stand in the order of first visit along the Morton curve,
//! so equal voxels give equal words. Differs from Kaempe: bricks of 4^3 (his leaves are 2^3), words instead of bytes.

mod count;
mod nodes;

pub use crate::geometry::BRICK_LEVEL;
pub use count::{LevelStats, Stats};

use crate::geometry::{Bricks, Geometry, Voxels};
use crate::morton::{BITS, Morton};

/// Words before the first brick.
pub const HEADER: usize = 24;
/// Marks a mask word.
pub(crate) const NODE: u32 = 1 << 31;

/// Number of set bits of every child mask; a look-up is faster than `count_ones` where the target has no such instruction.
pub(crate) const ONES: [u8; 256] = {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = (i as u8).count_ones() as u8;
        i += 1;
    }
    table
};

/// A checked view over a DAG's words.
#[derive(Clone, Copy, Debug)]
pub struct Dag<'a> {
    words: &'a [u32],
    depth: u8,
}

/// Why words are no DAG. Offsets count words from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DagError {
    /// Fewer words than the header and its sections need.
    Truncated {
        /// Words needed.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// More words than the header accounts for.
    Trailing {
        /// Words accounted for.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// The depth is above 21.
    Depth {
        /// The depth named.
        found: u32,
    },
    /// A header word is out of order: a level starts before the one below ends, or a reserved word is not 0.
    Header {
        /// Offset of the word.
        word: u32,
    },
    /// A brick has no voxel, or one outside the cube.
    Brick {
        /// Offset of its low word.
        word: u32,
    },
    /// A mask word lacks bit 31, has no child or has bits that mean nothing, or its children run past the level's end.
    Node {
        /// Offset of the word.
        word: u32,
    },
    /// A child is not a brick or node of the level below.
    Child {
        /// Offset of the child word.
        word: u32,
        /// What it points at.
        target: u32,
    },
    /// The top level holds no node or several, or a DAG of depth 2 or less several bricks.
    Root,
}

impl core::fmt::Display for DagError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            DagError::Truncated { expected, found } => {
                write!(f, "the DAG is cut short: expected {expected} words, found {found}")
            }
            DagError::Trailing { expected, found } => {
                write!(f, "the DAG has words to spare: expected {expected}, found {found}")
            }
            DagError::Depth { found } => write!(f, "depth {found} is out of range: expected 0 to {BITS}"),
            DagError::Header { word } => write!(f, "word {word} of the DAG's header is out of order"),
            DagError::Brick { word } => write!(f, "the brick at word {word} is empty or reaches outside the cube"),
            DagError::Node { word } => {
                write!(f, "word {word} is no node: expected bit 31 and a child mask of 1 to 255")
            }
            DagError::Child { word, target } => {
                write!(f, "the child at word {word} points at {target}, which is not in the level below")
            }
            DagError::Root => write!(f, "the DAG has no single root"),
        }
    }
}

impl core::error::Error for DagError {}

impl<'a> Dag<'a> {
    /// Checks all that queries rely on in O(words), without heap. After `Ok` no query can panic or loop. Not checked, as no
    /// answer depends on it: that nodes are unique, in use, and in the order of first visit, as builders make them.
    pub fn new(words: &'a [u32]) -> Result<Dag<'a>, DagError> {
        let found = words.len() as u64;
        if words.len() < HEADER {
            return Err(DagError::Truncated { expected: HEADER as u64, found });
        }
        if words[0] > BITS {
            return Err(DagError::Depth { found: words[0] });
        }
        let depth = words[0] as u8;

        // The sections must follow each other and end with the words.
        let bricks_end = HEADER as u64 + 2 * u64::from(words[1]);
        if words[2] as u64 != bricks_end {
            return Err(DagError::Header { word: 2 });
        }
        if let Some(word) = (2..21).find(|&i| words[i + 1] < words[i]) {
            return Err(DagError::Header { word: word as u32 + 1 });
        }
        if let Some(word) = (22..HEADER).find(|&i| words[i] != 0) {
            return Err(DagError::Header { word: word as u32 });
        }
        let end = u64::from(words[21]);
        if end > found {
            return Err(DagError::Truncated { expected: end, found });
        }
        if end < found {
            return Err(DagError::Trailing { expected: end, found });
        }

        // Every brick holds a voxel, and none outside the cube.
        let inside = match depth {
            0 => 1,
            1 => 0xff,
            _ => u64::MAX,
        };
        let dag = Dag { words, depth };
        for word in (HEADER..dag.level_start(3)).step_by(2) {
            let mask = dag.brick_at(word);
            if mask == 0 || mask & !inside != 0 {
                return Err(DagError::Brick { word: word as u32 });
            }
        }

        // Every child lies in the level below and points at the start of something.
        let mut nodes_at_top = 0;
        for level in 3..=BITS as u8 {
            let (mut word, end) = (dag.level_start(level), dag.level_start(level + 1));
            let below = dag.level_start(level - 1)..dag.level_start(level);
            nodes_at_top = 0;
            while word < end {
                let mask = words[word];
                let children = ONES[(mask & 0xff) as usize] as usize;
                if mask & !0xff != NODE || children == 0 || children >= end - word {
                    return Err(DagError::Node { word: word as u32 });
                }
                for (child, &target) in words.iter().enumerate().skip(word + 1).take(children) {
                    let starts = if level == 3 {
                        target % 2 == 0
                    } else {
                        words.get(target as usize).is_some_and(|w| w & NODE != 0)
                    };
                    if target & NODE != 0 || !below.contains(&(target as usize)) || !starts {
                        return Err(DagError::Child { word: child as u32, target });
                    }
                }
                word += 1 + children;
                nodes_at_top += 1;
            }
            if level == depth {
                break;
            }
        }
        let empty = words[1] == 0;
        let above = dag.level_start(depth.max(BRICK_LEVEL) + 1) as u64;
        let roots = if depth <= BRICK_LEVEL { words[1] } else { nodes_at_top };
        if above != end || roots > 1 || (roots == 0) != (empty && end == HEADER as u64) {
            return Err(DagError::Root);
        }
        Ok(dag)
    }

    /// The words themselves; `Dag::new(dag.words())` is the same view.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Octree levels L: the cube is 2^L voxels a side.
    #[inline]
    pub fn depth(&self) -> u8 {
        self.depth
    }

    /// Whether no voxel is filled.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.words[1] == 0
    }

    /// Number of unique bricks.
    pub fn brick_count(&self) -> u32 {
        self.words[1]
    }

    /// Word offset of the root: a node, or the one brick where the depth is at most 2. Meaningless if empty.
    #[inline]
    pub(crate) fn root(&self) -> usize {
        if self.depth <= BRICK_LEVEL { HEADER } else { self.level_start(self.depth) }
    }

    /// Offset of the first word of a level, 3 to 22; of the first brick for 2.
    #[inline]
    pub(crate) fn level_start(&self, level: u8) -> usize {
        if level <= BRICK_LEVEL { HEADER } else { self.words[level as usize - 1] as usize }
    }

    /// The stored nodes of a level from 3: the offset of each one's mask word, and its children.
    pub(crate) fn stored(&self, level: u8) -> impl Iterator<Item = (usize, &'a [u32])> {
        let (words, end) = (self.words, self.level_start(level + 1));
        let mut next = self.level_start(level);
        core::iter::from_fn(move || {
            let word = next;
            if word >= end {
                return None;
            }
            next += 1 + ONES[(words[word] & 0xff) as usize] as usize;
            Some((word, &words[word + 1..next]))
        })
    }

    /// The mask of the brick whose low word is at `word`.
    #[inline]
    pub(crate) fn brick_at(&self, word: usize) -> u64 {
        u64::from(self.words[word]) | u64::from(self.words[word + 1]) << 32
    }

    /// The child in `octant` of the node at `word`; `None` if it is empty.
    #[inline]
    pub(crate) fn child(&self, word: usize, octant: u32) -> Option<usize> {
        let mask = self.words[word];
        if mask >> octant & 1 == 0 {
            return None;
        }
        let before = ONES[(mask & ((1 << octant) - 1) & 0xff) as usize];
        Some(self.words[word + 1 + before as usize] as usize)
    }

    /// See [`Geometry::brick`].
    #[inline]
    pub fn brick(&self, voxel: Morton) -> u64 {
        Geometry::brick(self, voxel)
    }

    /// See [`Geometry::empty_level`].
    pub fn empty_level(&self, voxel: Morton) -> Option<u8> {
        Geometry::empty_level(self, voxel)
    }

    /// Whether a voxel is filled; voxels outside the cube are not.
    #[inline]
    pub fn contains(&self, voxel: Morton) -> bool {
        Geometry::contains(self, voxel)
    }

    /// All filled voxels in Morton order.
    pub fn voxels(&self) -> Voxels<Dag<'a>> {
        Geometry::voxels(*self)
    }

    /// All bricks that hold a voxel, in Morton order: the code of the brick's first voxel, and its mask.
    pub fn bricks(&self) -> Bricks<Dag<'a>> {
        Geometry::bricks(*self)
    }
}
