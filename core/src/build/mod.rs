//! The bottom-up reducer: bricks in Morton order go in, the words of a [`Dag`] come out.
//!
//! One open node per level; a node is closed when the Morton curve leaves it, looked up among the nodes of its level and
//! stored if it is new (hash-consing; Kaempe et al. 2013, section 4, who reduces a finished octree instead). So memory is
//! bound by the DAG, not by the voxels, and the order of nodes is that of their first visit: equal voxels give equal words,
//! however they were cut into subtrees (`Reducer::append`). Two places to keep nodes in: memory that grows
//! ([`DagBuilder`], feature `alloc`) and memory that the caller lends ([`build_into`]); both give the same words.

#[cfg(feature = "alloc")]
mod grow;
#[cfg(feature = "alloc")]
mod intern;
mod lent;

#[cfg(feature = "alloc")]
pub use grow::{DagBuf, DagBuilder, Mix};
#[cfg(feature = "alloc")]
pub(crate) use intern::Interned;
pub use lent::{build_into, scratch_words, words_bound};

use crate::dag::{BRICK_LEVEL, NODE};
#[cfg(feature = "alloc")]
use crate::dag::{Dag, ONES};
use crate::morton::{BITS, Morton};

/// Why a DAG cannot be built.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BuildError {
    /// A depth above 21.
    Depth {
        /// The depth asked for.
        found: u8,
    },
    /// A brick or subtree comes before, or overlaps, one that was given earlier.
    Order {
        /// Code of its first voxel.
        code: u64,
    },
    /// A brick or subtree holds voxels outside the cube, or its code is not that of its first voxel.
    Outside {
        /// Code of its first voxel.
        code: u64,
    },
    /// The words lent for the result, or the limit set for it, are too few.
    Words {
        /// Words needed at least.
        needed: u64,
    },
    /// The scratch memory lent is too small; [`scratch_words`] says how much is always enough.
    Scratch {
        /// Words needed at least.
        needed: u64,
    },
    /// The heap refused.
    Memory {
        /// Bytes that were asked for and not given.
        bytes: u64,
    },
}

impl core::fmt::Display for BuildError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            BuildError::Depth { found } => write!(f, "depth {found} is out of range: expected 0 to {BITS}"),
            BuildError::Order { code } => {
                write!(f, "the brick at Morton code {code} comes too late: expected ascending codes without overlap")
            }
            BuildError::Outside { code } => write!(f, "the brick at Morton code {code} reaches outside the cube"),
            BuildError::Words { needed } => {
                write!(f, "what is built needs {needed} words or more, which is over the limit")
            }
            BuildError::Scratch { needed } => write!(f, "building needs {needed} words of scratch memory or more"),
            BuildError::Memory { bytes } => write!(f, "out of memory: {bytes} bytes could not be had"),
        }
    }
}

impl core::error::Error for BuildError {}

/// Keeps unique bricks and nodes: finds an equal one or adds it, and names it by its offset within its level.
pub(crate) trait Store {
    /// The brick with this mask.
    fn brick(&mut self, mask: u64) -> Result<u32, BuildError>;
    /// The node `[NODE | mask, child...]` of a level, its children named by offsets within the level below.
    fn node(&mut self, level: u8, node: &[u32]) -> Result<u32, BuildError>;
}

/// The one open node of a level: mask word and children so far.
#[derive(Clone, Copy)]
struct Open {
    words: [u32; 9],
    children: usize,
}

impl Open {
    const EMPTY: Open = Open { words: [NODE, 0, 0, 0, 0, 0, 0, 0, 0], children: 0 };

    fn add(&mut self, octant: u8, child: u32) {
        self.words[0] |= 1 << octant;
        self.children += 1;
        self.words[self.children] = child;
    }
}

/// Where the curve stands: the open nodes, and what was given last.
pub(crate) struct Reducer {
    depth: u8,
    open: [Open; 22],
    /// Code of the first voxel of what was given last, and of the first voxel after it.
    last: u64,
    end: u64,
}

impl Reducer {
    pub(crate) fn new(depth: u8) -> Result<Reducer, BuildError> {
        if u32::from(depth) > BITS {
            return Err(BuildError::Depth { found: depth });
        }
        Ok(Reducer { depth, open: [Open::EMPTY; 22], last: 0, end: 0 })
    }

    /// Takes the next brick; `code` is that of its first voxel. A brick without voxels is passed over.
    pub(crate) fn push(&mut self, store: &mut impl Store, code: Morton, mask: u64) -> Result<(), BuildError> {
        if mask == 0 {
            return Ok(());
        }
        let inside = match self.depth {
            0 => 1,
            1 => 0xff,
            _ => u64::MAX,
        };
        if mask & !inside != 0 {
            return Err(BuildError::Outside { code: code.0 });
        }
        self.check(code, BRICK_LEVEL)?;
        let brick = store.brick(mask)?;
        self.add(store, code, BRICK_LEVEL, brick)
    }

    /// Takes a whole subtree: the voxels of `dag`, moved so that its first corner is the voxel at `code`.
    ///
    /// `forward` lends one word per word of `dag`.
    #[cfg(feature = "alloc")]
    pub(crate) fn append(
        &mut self,
        store: &mut impl Store,
        code: Morton,
        dag: &Dag<'_>,
        forward: &mut [u32],
    ) -> Result<(), BuildError> {
        if dag.is_empty() {
            return Ok(());
        }
        let level = dag.depth();
        if level <= BRICK_LEVEL {
            return self.push(store, code, dag.brick_at(dag.root()));
        }
        self.check(code, level)?;
        // The nodes that the curve has left were visited before those of the subtree.
        self.leave(store, code)?;
        // Store bricks and nodes in the subtree's own order; the new ones keep it.
        let words = dag.words();
        for word in (dag.level_start(BRICK_LEVEL)..dag.level_start(3)).step_by(2) {
            forward[word] = store.brick(dag.brick_at(word))?;
        }
        for l in 3..=level {
            let (mut word, end) = (dag.level_start(l), dag.level_start(l + 1));
            while word < end {
                let children = ONES[(words[word] & 0xff) as usize] as usize;
                let mut node = Open::EMPTY.words;
                node[0] = words[word];
                for i in 1..=children {
                    node[i] = forward[words[word + i] as usize];
                }
                forward[word] = store.node(l, &node[..=children])?;
                word += 1 + children;
            }
        }
        self.add(store, code, level, forward[dag.root()])
    }

    /// Closes every open node. The last one, alone in its level, is the root.
    pub(crate) fn finish(mut self, store: &mut impl Store) -> Result<(), BuildError> {
        self.close_to(store, self.depth)
    }

    /// Refuses a cube of `level` at `code` that lies outside, or not after all that came before.
    fn check(&self, code: Morton, level: u8) -> Result<(), BuildError> {
        let top = self.depth.max(BRICK_LEVEL);
        let size = 1u64 << (3 * u32::from(level));
        if level > top || !code.0.is_multiple_of(size) || code.0 >> (3 * u32::from(top)) != 0 {
            return Err(BuildError::Outside { code: code.0 });
        }
        if code.0 < self.end {
            return Err(BuildError::Order { code: code.0 });
        }
        Ok(())
    }

    /// Hangs a finished cube of `level` into its parent, after closing what the curve has left.
    fn add(&mut self, store: &mut impl Store, code: Morton, level: u8, id: u32) -> Result<(), BuildError> {
        self.leave(store, code)?;
        self.last = code.0;
        self.end = code.0 + (1 << (3 * u32::from(level)));
        // The root has no parent.
        if level < self.depth.max(BRICK_LEVEL) {
            self.open[level as usize + 1].add(code.octant(level), id);
        }
        Ok(())
    }

    /// Closes the open nodes that do not hold the voxel at `code`, which lies after all that came before.
    fn leave(&mut self, store: &mut impl Store, code: Morton) -> Result<(), BuildError> {
        if self.end == 0 {
            return Ok(());
        }
        let apart = code.0 ^ self.last;
        self.close_to(store, ((63 - apart.leading_zeros()) / 3) as u8)
    }

    /// Closes the open nodes of levels 3 to `level`.
    fn close_to(&mut self, store: &mut impl Store, level: u8) -> Result<(), BuildError> {
        for l in 3..=level {
            let open = core::mem::replace(&mut self.open[l as usize], Open::EMPTY);
            if open.children == 0 {
                continue;
            }
            let id = store.node(l, &open.words[..=open.children])?;
            if l < self.depth {
                self.open[l as usize + 1].add(Morton(self.last).octant(l), id);
            }
        }
        Ok(())
    }
}

/// Writes the header for a depth, a number of bricks and the words of each level from 3; gives the level starts.
/// `None` if the whole has 2^31 words or more.
pub(crate) fn write_header(header: &mut [u32], depth: u8, bricks: u64, level_words: &[u64; 22]) -> Option<()> {
    header.fill(0);
    header[0] = u32::from(depth);
    header[1] = u32::try_from(bricks).ok()?;
    let mut start = crate::dag::HEADER as u64 + 2 * bricks;
    for level in 3..=22 {
        header[level - 1] = u32::try_from(start).ok().filter(|s| s & NODE == 0)?;
        if level < 22 {
            start += level_words[level];
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dag::HEADER;

    /// Offsets end at 2^31 - 1; nothing wraps, however many there are.
    #[test]
    fn more_words_than_offsets_can_name_have_no_header() {
        let mut header = [0; HEADER];
        let most = (u64::from(NODE) - 1 - HEADER as u64) / 2;
        let mut level_words = [0; 22];
        assert_eq!(write_header(&mut header, 21, most, &level_words), Some(()));
        assert_eq!(u64::from(header[21]), HEADER as u64 + 2 * most);
        assert_eq!(write_header(&mut header, 21, most + 1, &level_words), None);
        for level in [3, 20, 21] {
            level_words = [0; 22];
            for words in [u64::from(NODE), 1 << 32, 1 << 40] {
                level_words[level] = words;
                assert_eq!(write_header(&mut header, 21, 1, &level_words), None, "{words} words in level {level}");
            }
            level_words[level] = u64::from(NODE) - 1 - HEADER as u64 - 2;
            assert_eq!(write_header(&mut header, 21, 1, &level_words), Some(()));
        }
        assert_eq!(write_header(&mut header, 21, 1 << 32, &[0; 22]), None);
    }
}
