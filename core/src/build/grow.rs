//! The reducer over memory that grows: one list of nodes and one set of their offsets per level.

use alloc::vec::Vec;
use core::hash::{BuildHasher, Hasher};
use hashbrown::HashTable;

use super::{BuildError, Reducer, Store, write_header};
use crate::dag::{BRICK_LEVEL, Dag, HEADER, NODE, ONES};
use crate::morton::Morton;

/// A DAG that owns its words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DagBuf {
    words: Vec<u32>,
}

impl DagBuf {
    /// The view that answers queries.
    pub fn dag(&self) -> Dag<'_> {
        Dag::new(&self.words).expect("a builder's words are a DAG")
    }

    /// The words, as [`Dag::words`] lays them out.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The words, without a copy.
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }
}

/// Builds a DAG from bricks and subtrees in Morton order, in memory that grows as needed and never aborts.
///
/// ```
/// use voxdag::{Morton, build::DagBuilder};
/// let mut builder = DagBuilder::new(3)?; // 8^3 voxels
/// builder.push(Morton::encode([0, 0, 0]).unwrap(), 1)?; // voxel (0, 0, 0) of the first brick
/// builder.push(Morton::encode([4, 0, 0]).unwrap(), 1)?; // voxel (4, 0, 0)
/// let built = builder.finish()?;
/// assert!(built.dag().contains(Morton::encode([4, 0, 0]).unwrap()));
/// assert_eq!(built.dag().brick_count(), 1); // both bricks are the same
/// # Ok::<(), voxdag::build::BuildError>(())
/// ```
pub struct DagBuilder<H = Mix> {
    reducer: Reducer,
    store: Grown<H>,
    depth: u8,
    forward: Vec<u32>,
    /// The first failure that left something half done: all that follows fails with it.
    failed: Option<BuildError>,
}

impl DagBuilder {
    /// An empty cube of `2^depth` voxels a side, depth 0 to 21.
    pub fn new(depth: u8) -> Result<DagBuilder, BuildError> {
        DagBuilder::with_hasher(depth, Mix(0))
    }
}

impl<H: BuildHasher> DagBuilder<H> {
    /// [`DagBuilder::new`] with another hash function; the words do not depend on it.
    pub fn with_hasher(depth: u8, hasher: H) -> Result<DagBuilder<H>, BuildError> {
        let store = Grown {
            bricks: Vec::new(),
            nodes: [const { Vec::new() }; 22],
            sets: [const { HashTable::new() }; 22],
            hasher,
            words: HEADER as u64,
            limit: u64::from(NODE),
        };
        Ok(DagBuilder { reducer: Reducer::new(depth)?, store, depth, forward: Vec::new(), failed: None })
    }

    /// Sets the most words that the DAG may have (at most 2^31 - 1); beyond, building ends with [`BuildError::Words`].
    pub fn limit(&mut self, words: u32) {
        self.store.limit = u64::from(words.min(NODE - 1)) + 1;
    }

    /// Adds the next brick: `code` is that of its first voxel (a multiple of 64, ascending), `mask` its 4^3 voxels in
    /// Morton order. What is out of order or outside is refused and changes nothing; after any other error the builder
    /// is of no more use, and says so.
    #[inline]
    pub fn push(&mut self, code: Morton, mask: u64) -> Result<(), BuildError> {
        self.failed.map_or(Ok(()), Err)?;
        let pushed = self.reducer.push(&mut self.store, code, mask);
        self.keep(pushed)
    }

    /// Adds the voxels of a whole DAG that a builder made, its first corner at the voxel `at` (a multiple of its size,
    /// ascending). Errors as in [`DagBuilder::push`].
    pub fn append(&mut self, at: Morton, dag: &Dag<'_>) -> Result<(), BuildError> {
        self.failed.map_or(Ok(()), Err)?;
        let more = dag.words().len().saturating_sub(self.forward.len());
        self.forward.try_reserve(more).map_err(|_| BuildError::Memory { bytes: 4 * more as u64 })?;
        self.forward.resize(self.forward.len() + more, 0);
        let appended = self.reducer.append(&mut self.store, at, dag, &mut self.forward);
        self.keep(appended)
    }

    /// Remembers an error that left nodes half done.
    #[inline]
    fn keep(&mut self, result: Result<(), BuildError>) -> Result<(), BuildError> {
        match result {
            Ok(()) | Err(BuildError::Order { .. } | BuildError::Outside { .. }) => result,
            Err(error) => {
                self.failed = Some(error);
                result
            }
        }
    }

    /// Words of the DAG so far, without the nodes that are still open.
    pub fn words(&self) -> u64 {
        self.store.words
    }

    /// Closes the open nodes and lays the words out.
    pub fn finish(mut self) -> Result<DagBuf, BuildError> {
        self.failed.map_or(Ok(()), Err)?;
        self.reducer.finish(&mut self.store)?;
        let Grown { bricks, nodes, words: total, .. } = self.store;
        drop(self.store.sets);
        let mut words = Vec::new();
        words.try_reserve_exact(total as usize).map_err(|_| BuildError::Memory { bytes: 4 * total })?;
        words.resize(HEADER, 0);
        let level_words = core::array::from_fn(|level| nodes[level].len() as u64);
        write_header(&mut words, self.depth, bricks.len() as u64, &level_words)
            .ok_or(BuildError::Words { needed: total })?;
        words.extend(bricks.iter().flat_map(|b| [*b as u32, (*b >> 32) as u32]));
        // Children are named by offsets within their level until here.
        for (level, nodes) in nodes.into_iter().enumerate().skip(3) {
            let below = if level == 3 { HEADER as u32 } else { words[level - 2] };
            let mut left = 0;
            for word in nodes {
                if left == 0 {
                    left = ONES[(word & 0xff) as usize];
                    words.push(word);
                } else {
                    left -= 1;
                    words.push(word + below);
                }
            }
        }
        Ok(DagBuf { words })
    }
}

/// Unique bricks, and the nodes of each level, with a set of offsets for each.
struct Grown<H> {
    bricks: Vec<u64>,
    nodes: [Vec<u32>; 22],
    sets: [HashTable<u32>; 22],
    hasher: H,
    words: u64,
    limit: u64,
}

impl<H> Grown<H> {
    /// Accounts for `more` words, or refuses.
    fn take(&mut self, more: usize) -> Result<(), BuildError> {
        self.words += more as u64;
        if self.words >= self.limit { Err(BuildError::Words { needed: self.words }) } else { Ok(()) }
    }
}

fn no_memory<T>(bytes: usize) -> impl FnOnce(T) -> BuildError {
    move |_| BuildError::Memory { bytes: bytes as u64 }
}

impl<H: BuildHasher> Store for Grown<H> {
    #[inline]
    fn brick(&mut self, mask: u64) -> Result<u32, BuildError> {
        let hash = self.hasher.hash_one(mask);
        let (bricks, set) = (&self.bricks, &self.sets[BRICK_LEVEL as usize]);
        if let Some(&found) = set.find(hash, |&i| bricks[i as usize / 2] == mask) {
            return Ok(found);
        }
        self.take(2)?;
        let id = 2 * self.bricks.len() as u32;
        self.bricks.try_reserve(1).map_err(no_memory(8))?;
        self.bricks.push(mask);
        let (bricks, hasher) = (&self.bricks, &self.hasher);
        let set = &mut self.sets[BRICK_LEVEL as usize];
        let rehash = |i: &u32| hasher.hash_one(bricks[*i as usize / 2]);
        set.try_reserve(1, rehash).map_err(no_memory(5 * bricks.len()))?;
        set.insert_unique(hash, id, rehash);
        Ok(id)
    }

    fn node(&mut self, level: u8, node: &[u32]) -> Result<u32, BuildError> {
        let at = |nodes: &[u32], i: u32| {
            let i = i as usize;
            i..i + 1 + ONES[(nodes[i] & 0xff) as usize] as usize
        };
        let hash = self.hasher.hash_one(node);
        let (nodes, set) = (&self.nodes[level as usize], &self.sets[level as usize]);
        if let Some(&found) = set.find(hash, |&i| &nodes[at(nodes, i)] == node) {
            return Ok(found);
        }
        self.take(node.len())?;
        let nodes = &mut self.nodes[level as usize];
        let id = nodes.len() as u32;
        nodes.try_reserve(node.len()).map_err(no_memory(4 * node.len()))?;
        nodes.extend_from_slice(node);
        let hasher = &self.hasher;
        let rehash = |i: &u32| hasher.hash_one(&nodes[at(nodes, *i)]);
        let set = &mut self.sets[level as usize];
        set.try_reserve(1, rehash).map_err(no_memory(5 * (set.len() + 1)))?;
        set.insert_unique(hash, id, rehash);
        Ok(id)
    }
}

/// The hash function of the builder: multiply and fold every word, seeded. Nodes never depend on it, only speed does.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mix(pub u64);

impl BuildHasher for Mix {
    type Hasher = Mix;
    fn build_hasher(&self) -> Mix {
        *self
    }
}

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }
    #[inline]
    fn write_u64(&mut self, x: u64) {
        let wide = u128::from(self.0 ^ x ^ 0x9e37_79b9_7f4a_7c15) * 0xa076_1d64_78bd_642f;
        self.0 = (wide as u64 ^ (wide >> 64) as u64).wrapping_mul(0xd6e8_feb8_6659_fd93);
        self.0 ^= self.0 >> 32;
    }
    #[inline]
    fn write_usize(&mut self, x: usize) {
        self.write_u64(x as u64);
    }
    #[inline]
    fn write(&mut self, bytes: &[u8]) {
        let (chunks, rest) = bytes.as_chunks::<8>();
        for chunk in chunks {
            self.write_u64(u64::from_le_bytes(*chunk));
        }
        if !rest.is_empty() {
            let mut last = [0; 8];
            last[..rest.len()].copy_from_slice(rest);
            self.write_u64(u64::from_le_bytes(last));
        }
    }
}
