//! Laying an SSVDAG out in words, from the root down.
//!
//! A class is stored as its first visitor in the level above sees it, so that this one needs neither pointer nor mirror. The
//! words depend on the voxels alone.

use alloc::vec::Vec;

use super::merge::Classes;
use super::{BLOCK, NODES, ROW, Ssvdag, bits_of, row_start};
use crate::build::BuildError;
use crate::dag::{BRICK_LEVEL, Dag};

/// An SSVDAG that owns its words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SsvdagBuf {
    words: Vec<u32>,
}

impl SsvdagBuf {
    /// Merges the nodes of a DAG up to mirrors, in memory that grows as needed and never aborts. Levels of 2^28 classes and
    /// more are refused ([`BuildError::Words`]).
    ///
    /// ```
    /// use voxdag::{Geometry, Morton, build::DagBuilder, ssvdag::SsvdagBuf};
    /// let mut builder = DagBuilder::new(3)?; // 8^3 voxels
    /// builder.push(Morton::encode([0, 0, 0]).unwrap(), 1)?; // voxel (0, 0, 0) of the first brick
    /// builder.push(Morton::encode([4, 0, 0]).unwrap(), 1 << 9)?; // voxel (7, 0, 0)
    /// let built = SsvdagBuf::build(&builder.finish()?.dag())?;
    /// assert!(built.ssvdag().contains(Morton::encode([7, 0, 0]).unwrap()));
    /// assert_eq!(built.ssvdag().node_count(2), 1); // the second brick mirrors the first
    /// # Ok::<(), voxdag::build::BuildError>(())
    /// ```
    pub fn build(dag: &Dag<'_>) -> Result<SsvdagBuf, BuildError> {
        let classes = Classes::of(dag)?;
        let root = dag.depth().max(BRICK_LEVEL);
        let mut words = Vec::new();
        (0..root).try_for_each(|_| extend(&mut words, &[0; ROW]))?;
        words[0] = u32::from(dag.depth());

        // The stored nodes of a level, by the words of the plain DAG that they were first seen at.
        let mut nodes: Vec<u32> = Vec::new();
        if !dag.is_empty() {
            extend(&mut nodes, &[dag.root() as u32])?;
        }
        for level in (3..=root).rev() {
            let (count, blocks) = (nodes.len(), words.len());
            let mut numbers = Numbers::new(&classes, level - 1)?;
            let mut pointers = Vec::new();
            for eight in nodes.chunks(NODES as usize) {
                let before = [pointers.len(), numbers.nodes.len()].map(|count| count as u32);
                let (mut children, mut new) = (0u64, 0u64);
                for (i, &node) in eight.iter().enumerate() {
                    for octant in 0..8 {
                        let Some(child) = dag.child(node as usize, octant) else { continue };
                        let bit = 1 << (8 * i as u32 + octant);
                        children |= bit;
                        match numbers.visit(child)? {
                            None => new |= bit,
                            Some(pointer) => extend(&mut pointers, &[pointer])?,
                        }
                    }
                }
                let masks = [children as u32, (children >> 32) as u32, new as u32, (new >> 32) as u32];
                let block: [u32; BLOCK] = [masks[0], masks[1], masks[2], masks[3], before[0], before[1]];
                extend(&mut words, &block)?;
            }
            nodes = numbers.nodes;
            let bits = bits_of(nodes.len() as u32);
            let row = [count, blocks, words.len(), bits as usize];
            set_row(&mut words, level, row);
            pack(&mut words, &pointers, bits)?;
        }

        let row = [nodes.len(), words.len(), 0, 0];
        set_row(&mut words, BRICK_LEVEL, row);
        for word in nodes {
            let word = word as usize;
            extend(&mut words, &dag.words()[word..word + 2])?;
        }
        Ok(SsvdagBuf { words })
    }

    /// The view that answers queries.
    pub fn ssvdag(&self) -> Ssvdag<'_> {
        Ssvdag::new(&self.words).expect("a builder's words are an SSVDAG")
    }

    /// The words, as [`Ssvdag::words`] lays them out.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The words, without a copy.
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }
}

/// The numbers of a level's nodes, given in the order of first visit.
struct Numbers<'a> {
    classes: &'a Classes,
    level: u8,
    /// By class: its number, and the mirror in which it was first seen; [`UNSEEN`] before.
    of_class: Vec<u32>,
    /// By number: where in the plain DAG it was first seen.
    nodes: Vec<u32>,
}

const UNSEEN: u32 = u32::MAX;

impl<'a> Numbers<'a> {
    fn new(classes: &'a Classes, level: u8) -> Result<Numbers<'a>, BuildError> {
        let count = classes.count(level);
        let mut of_class = Vec::new();
        of_class.try_reserve_exact(count).map_err(|_| BuildError::Memory { bytes: 4 * count as u64 })?;
        of_class.resize(count, UNSEEN);
        Ok(Numbers { classes, level, of_class, nodes: Vec::new() })
    }

    /// Visits the node at a word of the plain DAG: `number << 3 | mirror` if its class has a number, which it gets if not.
    fn visit(&mut self, word: usize) -> Result<Option<u32>, BuildError> {
        let seen = self.classes.seen(word);
        let number = &mut self.of_class[(seen >> 3) as usize];
        if *number == UNSEEN {
            *number = (self.nodes.len() as u32) << 3 | seen & 7;
            extend(&mut self.nodes, &[word as u32])?;
            return Ok(None);
        }
        let mirror = self.classes.mirrored(self.level, seen, *number & 7) & 7;
        Ok(Some(*number & !7 | mirror))
    }
}

/// Writes a level's row of the header. Its numbers fit, as the plain DAG with its words below 2^31 is larger.
fn set_row(words: &mut [u32], level: u8, row: [usize; ROW]) {
    words[row_start(level)..][..ROW].copy_from_slice(&row.map(|number| number as u32));
}

/// Appends pointers, `bits` for the number and three for the mirror each.
fn pack(words: &mut Vec<u32>, pointers: &[u32], bits: u32) -> Result<(), BuildError> {
    let (mut open, mut filled) = (0u64, 0);
    for pointer in pointers {
        open |= u64::from(pointer >> 3 | (pointer & 7) << bits) << filled;
        filled += bits + 3;
        if filled >= 32 {
            extend(words, &[open as u32])?;
            open >>= 32;
            filled -= 32;
        }
    }
    if filled > 0 { extend(words, &[open as u32]) } else { Ok(()) }
}

fn extend(list: &mut Vec<u32>, more: &[u32]) -> Result<(), BuildError> {
    list.try_reserve(more.len()).map_err(|_| BuildError::Memory { bytes: 4 * (list.len() + more.len()) as u64 })?;
    list.extend_from_slice(more);
    Ok(())
}
