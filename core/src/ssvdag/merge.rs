//! Which nodes of a plain DAG are mirror images of each other: classes, level by level from the bricks upwards.
//!
//! The form of a brick is its mask, that of a node its octants' classes and mirrors. A class is known by the least of its
//! eight mirrored forms. A child that equals some of its own mirrors (its symmetries) could be named by several; it is
//! named by the least. So mirror images have the same form, whatever their subtrees: nothing stays apart.

use alloc::vec::Vec;

use super::mirror;
use crate::build::{BuildError, Interned};
use crate::dag::{BRICK_LEVEL, Dag};

/// How a node relates to its class: `class << 3 | mirror`, which takes the class's form to the node.
pub(super) type Seen = u32;

/// The classes of all nodes of a plain DAG.
pub(super) struct Classes {
    /// By word of the plain DAG, where a brick or node begins.
    seen: Vec<Seen>,
    /// By level and class: the symmetries, one bit a mirror.
    symmetries: [Vec<u8>; 22],
}

impl Classes {
    pub(super) fn of(dag: &Dag<'_>) -> Result<Classes, BuildError> {
        let len = dag.words().len();
        let mut classes = Classes { seen: Vec::new(), symmetries: [const { Vec::new() }; 22] };
        classes.seen.try_reserve_exact(len).map_err(|_| BuildError::Memory { bytes: 4 * len as u64 })?;
        classes.seen.resize(len, 0);
        let mut bricks: Interned<2> = Interned::new();
        for word in (dag.level_start(BRICK_LEVEL)..dag.level_start(3)).step_by(2) {
            let mask = dag.brick_at(word);
            let forms = core::array::from_fn(|m| {
                let mask = mirror::brick(mask, m as u32);
                [(mask >> 32) as u32, mask as u32]
            });
            classes.add(BRICK_LEVEL, word, forms, &mut bricks)?;
        }
        for level in 3..=dag.depth() {
            let mut nodes: Interned<8> = Interned::new();
            let mut word = dag.level_start(level);
            while word < dag.level_start(level + 1) {
                // Octants: 0 is empty, others are one more than seen.
                let octants: [u32; 8] =
                    core::array::from_fn(|c| dag.child(word, c as u32).map_or(0, |child| 1 + classes.seen[child]));
                let forms = core::array::from_fn(|m| {
                    core::array::from_fn(|c| match octants[c ^ m] {
                        0 => 0,
                        seen => 1 + classes.mirrored(level - 1, seen - 1, m as u32),
                    })
                });
                classes.add(level, word, forms, &mut nodes)?;
                word += 1 + octants.iter().filter(|octant| **octant != 0).count();
            }
        }
        Ok(classes)
    }

    /// Number of classes of a level.
    pub(super) fn count(&self, level: u8) -> usize {
        self.symmetries[usize::from(level)].len()
    }

    /// The class of the node that begins at a word of the plain DAG.
    pub(super) fn seen(&self, word: usize) -> Seen {
        self.seen[word]
    }

    /// A node of a level, seen in one more mirror, by the least of the mirrors that come to the same.
    pub(super) fn mirrored(&self, level: u8, seen: Seen, mirror: u32) -> Seen {
        let symmetries = self.symmetries[usize::from(level)][(seen >> 3) as usize];
        let least = (0..8).filter(|m| symmetries >> m & 1 != 0).map(|m| seen & 7 ^ mirror ^ m).min();
        seen & !7 | least.unwrap_or(0)
    }

    /// Finds or adds the class of a node, given by its eight mirrored forms.
    fn add<const N: usize>(
        &mut self,
        level: u8,
        word: usize,
        forms: [[u32; N]; 8],
        set: &mut Interned<N>,
    ) -> Result<(), BuildError> {
        let least = (0..8).min_by_key(|m| forms[*m]).unwrap_or(0);
        let class = set.number(forms[least])?;
        let symmetries = &mut self.symmetries[usize::from(level)];
        if class as usize == symmetries.len() {
            let bytes = symmetries.len() as u64 + 1;
            symmetries.try_reserve(1).map_err(|_| BuildError::Memory { bytes })?;
            symmetries.push((0..8).map(|m| u8::from(forms[m] == forms[0]) << m).sum());
        }
        self.seen[word] = class << 3 | least as u32;
        Ok(())
    }
}
