//! Material tree: which material a voxel has, by where it is. No keys and no ranks, and empty voxels do not matter.
//!
//! In: materials of the filled voxels, brick by brick along the Morton curve. Out: flat words. A cube whose filled voxels
//! are of one material is one entry, however large; below a cube of two materials only bits are left, in nodes that equal
//! ones share, also mirrored in value (the two swapped); whatever an empty voxel says is chosen so that more is equal.
//! An empty voxel answers with a material of the smallest cube around it (a brick or more) that holds any, so coarser levels
//! can be asked.
//! Ours; don't-care compression of a tree over space as in van der Laan et al. (2020, section 5), two-valued subtrees are new.
//!
//! ```text
//! word  0      depth                      8..26  ends of levels 3 to 21 among the halves
//!       1      t: top table of 8^t        27     0
//!       2      nodes                      28..   top table: an entry a cell of 2^(L-t), x fastest; L = max(depth, 2)
//!       3      pairs                             nodes:     8 entries, by octant
//!       4      bricks of up to 4 ids             pairs:     [ id 0 | id 1 << 16 ][ place of its bits ]
//!       5      of up to 16                       bricks:    ids in halves, then 64 indices of 2 or 4 bits; or 64 ids
//!       6      of up to 64                       patterns:  64 bits, low word first
//!       7      patterns                          halves:    [ inner octants | bits of the others << 8 ][ place ]...
//! entry        kind << 29 | value: 0 material id, 1 pair, 2 node, 3 to 5 brick of up to 4, 16, 64 ids
//! place        swap << 31 | offset: within the level's halves, or the number of a pattern. Among the halves it is
//!              swap << 15 | offset, or two halves (low first) where the level below has more than 2^15 halves
//! ```

#[cfg(feature = "alloc")]
mod grow;
#[cfg(feature = "alloc")]
mod pack;

#[cfg(feature = "alloc")]
pub use grow::{TreeBuf, TreeBuilder};

use crate::dag::{BRICK_LEVEL, ONES};
use crate::material::MaterialId;
use crate::materials::Materials;
use crate::morton::{BITS, Morton};

/// Words before the top table.
pub const HEADER: usize = 28;
/// Word of the end of level 3 among the halves.
const ENDS: usize = 8;
/// Words of a brick of up to 4, 16 and 64 ids, and of their ids.
const BRICK_WORDS: [usize; 3] = [6, 16, 32];
const BRICK_IDS: [usize; 3] = [2, 8, 32];
/// More halves in a level, or more patterns, need wide places.
const NARROW: u32 = 1 << 15;

/// An entry's kind stands above its value, which is below [`MOST`].
const SHIFT: u32 = 29;
const MOST: u32 = 1 << SHIFT;
const ID: u32 = 0;
const PAIR: u32 = 1;
const INNER: u32 = 2;
const BRICK: u32 = 3;

/// A checked view over a tree's words.
#[derive(Clone, Copy, Debug)]
pub struct Tree<'a> {
    words: &'a [u32],
    /// Level of the root, and of the top table's cells.
    root: u8,
    top: u8,
    nodes: &'a [u32],
    pairs: &'a [u32],
    bricks: [&'a [u32]; 3],
    patterns: &'a [u32],
    halves: &'a [u32],
    /// Where each level's halves start; index 0 is level 3.
    starts: [u32; 20],
    /// Bit l: places in level l take two halves.
    wide: u32,
    max_material: MaterialId,
}

/// Why words are not a tree.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TreeError {
    /// Another number of words than the header says.
    Length {
        /// Words that the header says.
        expected: u64,
        /// Words that are there.
        found: u64,
    },
    /// A number in the header that is out of range.
    Header {
        /// Its word.
        word: u32,
    },
    /// An entry of a kind that is none, or of something that is not there.
    Entry {
        /// Its word.
        word: u32,
    },
}

impl core::fmt::Display for TreeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            TreeError::Length { expected, found } => {
                write!(f, "the material tree has {found} words: expected {expected}")
            }
            TreeError::Header { word } => write!(f, "word {word} of the material tree is out of range"),
            TreeError::Entry { word } => {
                write!(f, "word {word} of the material tree names something that is not there")
            }
        }
    }
}

impl core::error::Error for TreeError {}

impl<'a> Tree<'a> {
    /// Checks words and borrows the tree in them: whatever they are, no look-up panics or spins, and no id is above
    /// [`Tree::max_material`]. O(words).
    pub fn new(words: &'a [u32]) -> Result<Tree<'a>, TreeError> {
        let found = words.len() as u64;
        if words.len() < HEADER {
            return Err(TreeError::Length { expected: HEADER as u64, found });
        }
        let depth = words[0];
        if depth > BITS {
            return Err(TreeError::Header { word: 0 });
        }
        let root = (depth as u8).max(BRICK_LEVEL);
        if words[1] > u32::from(root - BRICK_LEVEL).min(8) {
            return Err(TreeError::Header { word: 1 });
        }
        let mut starts = [0; 20];
        for (i, end) in words[ENDS..ENDS + 19].iter().enumerate() {
            if *end < starts[i] {
                return Err(TreeError::Header { word: (ENDS + i) as u32 });
            }
            starts[i + 1] = *end;
            if i + 3 > usize::from(root) && *end != starts[i] {
                return Err(TreeError::Header { word: (ENDS + i) as u32 });
            }
        }
        if words[HEADER - 1] != 0 {
            return Err(TreeError::Header { word: HEADER as u32 - 1 });
        }

        // Cut the words into their parts.
        let count = |word: usize, each: u64| u64::from(words[word]) * each;
        let lengths = [
            1 << (3 * words[1]),
            count(2, 8),
            count(3, 2),
            count(4, BRICK_WORDS[0] as u64),
            count(5, BRICK_WORDS[1] as u64),
            count(6, BRICK_WORDS[2] as u64),
            count(7, 2),
            u64::from(starts[19].div_ceil(2)),
        ];
        let expected = lengths.iter().fold(HEADER as u64, |sum, len| sum + len);
        if found != expected {
            return Err(TreeError::Length { expected, found });
        }
        let mut rest = &words[HEADER..];
        let [table, nodes, pairs, few, some, many, patterns, halves] = lengths.map(|len| {
            let (part, behind) = rest.split_at(len as usize);
            rest = behind;
            part
        });
        if starts[19] % 2 != 0 && halves[halves.len() - 1] >> 16 != 0 {
            return Err(TreeError::Entry { word: words.len() as u32 - 1 });
        }
        let mut wide = 0;
        for level in BRICK_LEVEL..root {
            let places = match level {
                BRICK_LEVEL => words[7],
                _ => starts[level as usize - 2] - starts[level as usize - 3],
            };
            wide |= u32::from(places > NARROW) << level;
        }

        // Every entry names something that is there; ids are gathered.
        let counts = [1 << 16, words[3], words[2], words[4], words[5], words[6], 0, 0];
        let mut max = 0;
        for (i, &entry) in table.iter().chain(nodes).enumerate() {
            let (kind, value) = (entry >> SHIFT, entry & (MOST - 1));
            if value >= counts[kind as usize] {
                return Err(TreeError::Entry { word: (HEADER + i) as u32 });
            }
            if kind == ID {
                max = max.max(value);
            }
        }
        let ids = |words: &[u32]| words.iter().map(|w| (w & 0xffff).max(w >> 16)).fold(0, u32::max);
        for pair in pairs.chunks_exact(2) {
            max = max.max(ids(&pair[..1]));
        }
        for (kind, bricks) in [few, some, many].into_iter().enumerate() {
            for brick in bricks.chunks_exact(BRICK_WORDS[kind]) {
                max = max.max(ids(&brick[..BRICK_IDS[kind]]));
            }
        }
        let top = root - words[1] as u8;
        let bricks = [few, some, many];
        Ok(Tree { words, root, top, nodes, pairs, bricks, patterns, halves, starts, wide, max_material: max as u16 })
    }

    /// The words, as they stand in a file.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Where its parts begin, in words from its first one: nodes, pairs, bricks of up to 4, 16 and 64 ids, patterns, halves.
    pub(crate) fn parts(&self) -> [u32; 7] {
        let [few, some, many] = self.bricks;
        let mut end = HEADER + (1 << (3 * (self.root - self.top)));
        [self.nodes, self.pairs, few, some, many, self.patterns, self.halves].map(|part| {
            let start = end as u32;
            end += part.len();
            start
        })
    }

    /// Bit l is set if places in level l take two halves.
    pub(crate) fn wide(&self) -> u32 {
        self.wide
    }

    /// No voxel's material id is above this one.
    pub fn max_material(&self) -> MaterialId {
        self.max_material
    }

    /// Levels of the octree.
    pub fn depth(&self) -> u8 {
        self.words[0] as u8
    }

    /// The material of a voxel; of an empty one that of some voxel in the smallest cube of the octree around it, from bricks
    /// upwards, that holds any. 0 outside the cube.
    #[inline]
    pub fn get(&self, voxel: Morton) -> MaterialId {
        if voxel.0 >> (3 * u32::from(self.root)) != 0 {
            return 0;
        }
        let bits = self.root - self.top;
        let [x, y, z] = voxel.decode().map(|k| (k >> self.top) as usize);
        let mut entry = self.words[HEADER + (((z << bits | y) << bits) | x)];
        let mut level = self.top;
        loop {
            let value = (entry & (MOST - 1)) as usize;
            match entry >> SHIFT {
                ID => return value as MaterialId,
                PAIR => {
                    let ids = self.pairs[2 * value];
                    let second = self.bit(self.pairs[2 * value + 1], level, voxel);
                    return (ids >> (16 * second)) as MaterialId;
                }
                INNER if level > BRICK_LEVEL => {
                    level -= 1;
                    entry = self.nodes[8 * value + usize::from(voxel.octant(level))];
                }
                kind @ BRICK..=5 => return self.brick((kind - BRICK) as usize, value, voxel),
                _ => return 0,
            }
        }
    }

    /// Which of a pair's two a voxel is: 0 or 1. Offsets that lead nowhere find zeros.
    #[inline]
    fn bit(&self, place: u32, mut level: u8, voxel: Morton) -> u32 {
        let (mut swap, mut at) = (place >> 31, place & 0x7fff_ffff);
        while level > BRICK_LEVEL {
            let start = self.starts[level as usize - 3];
            let node = self.half(start, at);
            level -= 1;
            let octant = u32::from(voxel.octant(level));
            if node >> octant & 1 == 0 {
                return node >> (8 + octant) & 1 ^ swap;
            }
            let before = u32::from(ONES[(node & ((1 << octant) - 1)) as usize]);
            let place = if self.wide >> level & 1 == 0 {
                let narrow = self.half(start, at + 1 + before);
                narrow >> 15 << 31 | narrow & 0x7fff
            } else {
                self.half(start, at + 1 + 2 * before) | self.half(start, at + 2 + 2 * before) << 16
            };
            swap ^= place >> 31;
            at = place & 0x7fff_ffff;
        }
        let bit = (voxel.0 & 63) as usize;
        let word = self.patterns.get(2 * at as usize + bit / 32).copied().unwrap_or(0);
        word >> (bit % 32) & 1 ^ swap
    }

    #[inline]
    fn half(&self, start: u32, at: u32) -> u32 {
        let i = start as usize + at as usize;
        self.halves.get(i / 2).map_or(0, |word| word >> (16 * (i % 2)) & 0xffff)
    }

    /// The id of a voxel in a brick of three ids and more.
    fn brick(&self, kind: usize, number: usize, voxel: Morton) -> MaterialId {
        let brick = &self.bricks[kind][number * BRICK_WORDS[kind]..];
        let bit = (voxel.0 & 63) as usize;
        let index = match kind {
            0 => brick[BRICK_IDS[0] + bit / 16] >> (2 * (bit % 16)) & 3,
            1 => brick[BRICK_IDS[1] + bit / 8] >> (4 * (bit % 8)) & 15,
            _ => bit as u32,
        } as usize;
        (brick[index / 2] >> (16 * (index % 2))) as MaterialId
    }
}

impl Materials for Tree<'_> {
    #[inline]
    fn id(&self, voxel: Morton) -> MaterialId {
        self.get(voxel)
    }

    #[inline]
    fn normal(&self, _: Morton) -> Option<[f32; 3]> {
        None
    }
}
