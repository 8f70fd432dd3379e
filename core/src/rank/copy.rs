//! A DAG's nodes written anew, with room for counts in them: what [`super::Offsets`] and [`super::MoxelDag`] share.
//!
//! Header and bricks are the DAG's own; level starts are new. Counts leave bit 31 of their words clear, so that a mask
//! word, which has it set, marks where a node starts; only the root, which is known, may hold a count that is too
//! large.

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

#[cfg(feature = "alloc")]
use crate::build::{BuildError, write_header};
#[cfg(feature = "alloc")]
use crate::dag::Dag;
use crate::dag::{BRICK_LEVEL, HEADER, NODE, ONES};
#[cfg(feature = "alloc")]
use crate::morton::BITS;

/// Nodes with counts, level by level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nodes<'a> {
    pub words: &'a [u32],
    /// Filled voxels.
    pub voxels: u64,
}

#[cfg(feature = "alloc")]
/// Nodes with counts that own their words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct NodesBuf {
    words: Vec<u32>,
    voxels: u64,
}

#[cfg(feature = "alloc")]
/// A child as its parent sees it.
#[derive(Clone, Copy)]
pub(super) struct Child {
    /// Where it stands now.
    pub word: u32,
    /// Its filled voxels.
    pub voxels: u64,
}

#[cfg(feature = "alloc")]
impl NodesBuf {
    /// Copies the nodes of `dag`. `len` says how many words a node of a level with so many children takes, behind its
    /// mask; `write` writes them.
    pub fn copy(
        dag: &Dag<'_>,
        len: impl Fn(u8, usize) -> usize,
        write: impl Fn(u8, &[Child], &mut [u32]),
    ) -> Result<NodesBuf, BuildError> {
        // Take the memory.
        let mut level_words = [0; 22];
        for level in 3..=BITS as u8 {
            level_words[usize::from(level)] = dag.stored(level).map(|(_, c)| 1 + len(level, c.len()) as u64).sum();
        }
        let total = dag.level_start(3) as u64 + level_words.iter().sum::<u64>();
        let mut words = zeros(total)?;
        write_header(&mut words[..HEADER], dag.depth(), dag.brick_count().into(), &level_words)
            .ok_or(BuildError::Words { needed: total })?;
        let mut places = zeros(dag.words().len() as u64)?;
        let mut counts = zeros(dag.words().len() as u64)?;

        // Bricks stay where they are.
        let bricks = HEADER..dag.level_start(3);
        words[bricks.clone()].copy_from_slice(&dag.words()[bricks.clone()]);
        for word in bricks.step_by(2) {
            (places[word], counts[word]) = (word as u32, dag.brick_at(word).count_ones().into());
        }
        let mut at = dag.level_start(3);
        for level in 3..=BITS as u8 {
            for (word, children) in dag.stored(level) {
                let mut list = [Child { word: 0, voxels: 0 }; 8];
                for (child, &old) in list.iter_mut().zip(children) {
                    *child = Child { word: places[old as usize], voxels: counts[old as usize] };
                }
                let list = &list[..children.len()];
                let end = at + 1 + len(level, list.len());
                words[at] = dag.words()[word];
                write(level, list, &mut words[at + 1..end]);
                (places[word], counts[word]) = (at as u32, list.iter().map(|child| child.voxels).sum());
                at = end;
            }
        }
        let voxels = if dag.is_empty() { 0 } else { counts[dag.root()] };
        Ok(NodesBuf { words, voxels })
    }

    pub fn nodes(&self) -> Nodes<'_> {
        Nodes { words: &self.words, voxels: self.voxels }
    }
}

#[cfg(feature = "alloc")]
fn zeros<T: Clone + Default>(len: u64) -> Result<Vec<T>, BuildError> {
    let missing = BuildError::Memory { bytes: len * size_of::<T>() as u64 };
    let len = usize::try_from(len).map_err(|_| missing)?;
    let mut list = Vec::new();
    list.try_reserve_exact(len).map_err(|_| missing)?;
    list.resize(len, T::default());
    Ok(list)
}

impl Nodes<'_> {
    #[inline]
    pub fn depth(&self) -> u8 {
        self.words[0] as u8
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.words[1] == 0
    }

    #[inline]
    fn level_start(&self, level: u8) -> usize {
        if level <= BRICK_LEVEL { HEADER } else { self.words[usize::from(level) - 1] as usize }
    }

    #[inline]
    pub fn root(&self) -> usize {
        if self.depth() <= BRICK_LEVEL { HEADER } else { self.level_start(self.depth()) }
    }

    pub fn is_node(&self, node: u32, level: u8) -> bool {
        let word = node as usize;
        if !(self.level_start(level)..self.level_start(level + 1)).contains(&word) {
            return false;
        }
        match level {
            BRICK_LEVEL => node.is_multiple_of(2),
            _ if level == self.depth() => word == self.root(),
            _ => self.words[word] & NODE != 0,
        }
    }

    /// Which of a node's children, counted from 0, is in an octant.
    #[inline]
    pub fn child(&self, node: usize, octant: u32) -> Option<usize> {
        let mask = self.words[node];
        let before = ONES[(mask & ((1 << octant) - 1) & 0xff) as usize];
        (mask >> octant & 1 != 0).then_some(usize::from(before))
    }

    #[inline]
    pub fn brick_at(&self, brick: usize) -> u64 {
        u64::from(self.words[brick]) | u64::from(self.words[brick + 1]) << 32
    }
}
