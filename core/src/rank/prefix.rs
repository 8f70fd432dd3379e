//! Rank by prefix counts per child, in an array parallel to the DAG's nodes (after Dolonius et al. 2017).
//!
//! In: a DAG, and words made for it. Out: ranks. At a child's place stands the number of voxels in the children before
//! it, at a mask's place the node's total, so every count can be checked against those of the level below, without a
//! heap. Differs from the source: counts per child beside the totals, so that a step down reads one count, not up to
//! seven.
//!
//! ```text
//! word  i        low 32 bits of the count for the DAG's word a + i; a = start of level 3
//!       N + i    high bits of the count for the DAG's word b + i;   b = start of level 11, N = end - a
//! ```

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

use super::{NARROW, Rank, RankError, in_brick};
#[cfg(feature = "alloc")]
use crate::build::BuildError;
use crate::dag::{BRICK_LEVEL, Dag, ONES};
use crate::morton::{BITS, Morton};

/// A checked view over a DAG's prefix counts.
#[derive(Clone, Copy, Debug)]
pub struct Prefix<'a> {
    dag: Dag<'a>,
    words: &'a [u32],
    counts: Counts<&'a [u32]>,
    voxels: u64,
}

/// The counts of a DAG, named by its words.
#[derive(Clone, Copy, Debug)]
struct Counts<W> {
    low: W,
    high: W,
    /// First word of the DAG that has a count, and first one whose count has high bits.
    first: usize,
    wide: usize,
}

impl Counts<&[u32]> {
    /// The count at a word of a node above level [`NARROW`].
    #[inline]
    fn wide(&self, word: usize) -> u64 {
        u64::from(self.low[word - self.first]) | u64::from(self.high[word - self.wide]) << 32
    }

    /// The count at a word of any node.
    #[inline]
    fn get(&self, word: usize) -> u64 {
        if word < self.wide { self.low[word - self.first].into() } else { self.wide(word) }
    }
}

impl Counts<&mut [u32]> {
    fn set(&mut self, word: usize, count: u64) {
        self.low[word - self.first] = count as u32;
        if word >= self.wide {
            self.high[word - self.wide] = (count >> 32) as u32;
        }
    }

    fn shared(&self) -> Counts<&[u32]> {
        Counts { low: self.low, high: self.high, first: self.first, wide: self.wide }
    }
}

/// The voxels of a brick or node, by the counts of its level.
fn total(dag: &Dag<'_>, counts: &Counts<&[u32]>, word: usize) -> u64 {
    if word < counts.first { dag.brick_at(word).count_ones().into() } else { counts.get(word) }
}

impl<'a> Prefix<'a> {
    /// Words that the counts of a DAG take: one for each of its nodes' words, two above level 10.
    pub fn words_for(dag: &Dag<'_>) -> usize {
        let end = dag.words().len();
        2 * end - dag.level_start(3) - dag.level_start(NARROW + 1)
    }

    /// Checks that the words are the counts of this DAG, in O(words), without heap.
    pub fn new(dag: Dag<'a>, words: &'a [u32]) -> Result<Prefix<'a>, RankError> {
        check_len(&dag, words.len())?;
        let (first, wide) = (dag.level_start(3), dag.level_start(NARROW + 1));
        let (low, high) = words.split_at(dag.words().len() - first);
        let counts = Counts { low, high, first, wide };
        for (word, children) in (3..=BITS as u8).flat_map(|level| dag.stored(level)) {
            let wrong = |word: usize| RankError::Count { word: (word - first) as u32 };
            let mut sum = 0;
            for (place, &child) in (word + 1..).zip(children) {
                if counts.get(place) != sum {
                    return Err(wrong(place));
                }
                sum += total(&dag, &counts, child as usize);
            }
            if counts.get(word) != sum {
                return Err(wrong(word));
            }
        }
        Ok(Prefix::over(dag, words, counts))
    }

    /// Counts the voxels of a DAG into lent words, as many as [`Prefix::words_for`] says.
    pub fn build_into(dag: Dag<'a>, words: &'a mut [u32]) -> Result<Prefix<'a>, RankError> {
        check_len(&dag, words.len())?;
        let (first, wide) = (dag.level_start(3), dag.level_start(NARROW + 1));
        let split = dag.words().len() - first;
        let (low, high) = words.split_at_mut(split);
        let mut counts = Counts { low, high, first, wide };
        for (word, children) in (3..=BITS as u8).flat_map(|level| dag.stored(level)) {
            let mut sum = 0;
            for (place, &child) in (word + 1..).zip(children) {
                counts.set(place, sum);
                sum += total(&dag, &counts.shared(), child as usize);
            }
            counts.set(word, sum);
        }
        let words: &'a [u32] = words;
        let (low, high) = words.split_at(split);
        Ok(Prefix::over(dag, words, Counts { low, high, first, wide }))
    }

    /// Counts the voxels of a DAG into words from the heap, for [`Prefix::new`].
    ///
    /// ```
    /// use voxdag::{Morton, Rank, build::DagBuilder, rank::Prefix};
    /// let mut builder = DagBuilder::new(3)?;
    /// builder.push(Morton(0), 0b11)?;
    /// builder.push(Morton(64), 0b100)?;
    /// let built = builder.finish()?;
    /// let words = Prefix::build(&built.dag())?;
    /// let prefix = Prefix::new(built.dag(), &words).expect("the counts of this DAG");
    /// assert_eq!((prefix.count(), prefix.rank(Morton(66)), prefix.rank(Morton(2))), (3, Some(2), None));
    /// # Ok::<(), voxdag::build::BuildError>(())
    /// ```
    #[cfg(feature = "alloc")]
    pub fn build(dag: &Dag<'_>) -> Result<Vec<u32>, BuildError> {
        let len = Prefix::words_for(dag);
        let mut words = Vec::new();
        words.try_reserve_exact(len).map_err(|_| BuildError::Memory { bytes: 4 * len as u64 })?;
        words.resize(len, 0);
        Prefix::build_into(*dag, &mut words).expect("as many words as the DAG asks for");
        Ok(words)
    }

    fn over(dag: Dag<'a>, words: &'a [u32], counts: Counts<&'a [u32]>) -> Prefix<'a> {
        let voxels = if dag.is_empty() { 0 } else { total(&dag, &counts, dag.root()) };
        Prefix { dag, words, counts, voxels }
    }

    /// The DAG whose voxels are counted.
    pub fn dag(&self) -> Dag<'a> {
        self.dag
    }

    /// The words, as they stand in a file.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }
}

fn check_len(dag: &Dag<'_>, found: usize) -> Result<(), RankError> {
    let expected = Prefix::words_for(dag);
    if found == expected {
        return Ok(());
    }
    Err(RankError::Length { expected: expected as u64, found: found as u64 })
}

impl Rank for Prefix<'_> {
    fn count(&self) -> u64 {
        self.voxels
    }

    #[inline]
    fn rank(&self, voxel: Morton) -> Option<u64> {
        let (dag, counts) = (&self.dag, &self.counts);
        let top = dag.depth().max(BRICK_LEVEL);
        if dag.is_empty() || voxel.0 >> (3 * u32::from(top)) != 0 {
            return None;
        }
        let words = dag.words();
        let (mut node, mut before) = (dag.root(), 0);
        // The place of the child on the way to the voxel.
        let step = |node: usize, level: u8| {
            let (mask, octant) = (words[node], voxel.octant(level));
            let earlier = ONES[(mask & ((1 << octant) - 1) & 0xff) as usize];
            (mask >> octant & 1 != 0).then_some(node + 1 + usize::from(earlier))
        };
        for level in (NARROW..top).rev() {
            let place = step(node, level)?;
            before += counts.wide(place);
            node = words[place] as usize;
        }
        for level in (BRICK_LEVEL..top.min(NARROW)).rev() {
            let place = step(node, level)?;
            before += u64::from(counts.low[place - counts.first]);
            node = words[place] as usize;
        }
        Some(before + in_brick(dag.brick_at(node), voxel)?)
    }
}
