//! Building a material tree: cubes are closed from the bricks upwards as the Morton curve leaves them.
//!
//! In: bricks in Morton order with the materials of their filled voxels. Out: what each cube comes to, equal ones once;
//! [`super::pack`] lays it out. Of a cube of two materials only bits are kept, turned so that its first voxel's bit is 0:
//! so cubes whose two materials are others, or the other way round, are equal where their borders are. The words depend
//! on the voxels and their materials alone.

use alloc::vec::Vec;

use super::{BRICK, BRICK_IDS, BRICK_WORDS, ID, INNER, PAIR, SHIFT, Tree, pack};
use crate::build::{BuildError, Interned};
use crate::dag::BRICK_LEVEL;
use crate::material::MaterialId;
use crate::morton::{BITS, Morton};

/// What a closed cube comes to.
#[derive(Clone, Copy)]
enum Cube {
    Empty,
    /// All its voxels are of one material.
    One(MaterialId),
    /// Of two, in ascending order: its bits (a pattern or a node of its level), and whether they are swapped.
    Two {
        ids: [MaterialId; 2],
        at: u32,
        swap: bool,
    },
    /// Of more: its entry, and the material of its first voxel.
    More {
        entry: u32,
        first: MaterialId,
    },
}

impl Cube {
    /// The material of its first voxel.
    fn first(self) -> Option<MaterialId> {
        match self {
            Cube::Empty => None,
            Cube::One(id) | Cube::More { first: id, .. } => Some(id),
            Cube::Two { ids, swap, .. } => Some(ids[usize::from(swap)]),
        }
    }
}

/// The different materials of a cube, as far as three.
#[derive(Clone, Copy, Default)]
struct Few {
    ids: [MaterialId; 2],
    count: usize,
}

impl Few {
    fn add(&mut self, id: MaterialId) {
        if self.count > 2 || self.ids[..self.count].contains(&id) {
            return;
        }
        if self.count < 2 {
            self.ids[self.count] = id;
        }
        self.count += 1;
    }
}

/// Octants of a node of bits: nothing, all 0, all 1, or `INSIDE + 2 number + swap`.
pub(super) const NOTHING: u32 = 0;
pub(super) const ZEROS: u32 = 1;
pub(super) const ONES: u32 = 2;
pub(super) const INSIDE: u32 = 4;
/// A cell of the top table without voxels.
pub(super) const VACANT: u32 = u32::MAX;

/// All different cubes so far, in the order in which the curve left them.
pub(super) struct Cubes {
    /// Bricks of two: which voxels are filled (low, high), and the bits of those.
    pub patterns: Interned<4>,
    /// Larger cubes of two, by level from 3.
    pub bits: [Interned<8>; 19],
    /// Cubes of two beside others: ids, level, `2 number + swap`.
    pub pairs: Interned<3>,
    pub nodes: Interned<8>,
    pub few: Interned<6>,
    pub some: Interned<16>,
    pub many: Interned<32>,
    /// Entries of the top table's cells, and the materials of their first voxels.
    pub table: Vec<u32>,
    pub firsts: Vec<MaterialId>,
}

/// A material tree that owns its words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TreeBuf {
    pub(super) words: Vec<u32>,
}

impl TreeBuf {
    /// The view that answers look-ups.
    pub fn tree(&self) -> Tree<'_> {
        Tree::new(&self.words).expect("a builder's words are a tree")
    }

    /// The words, as [`Tree::words`] lays them out.
    pub fn words(&self) -> &[u32] {
        &self.words
    }
}

/// Builds a material tree from bricks in Morton order, in memory that grows as needed and never aborts.
///
/// ```
/// use voxdag::{Morton, tree::TreeBuilder};
/// let mut builder = TreeBuilder::new(3)?; // 8^3 voxels
/// builder.push(Morton(0), 0b11, &[4, 7])?; // voxels (0, 0, 0) and (1, 0, 0) of the first brick
/// builder.push_uniform(Morton(64), 7)?; // all voxels of the second
/// let built = builder.finish()?;
/// assert_eq!(built.tree().get(Morton(0)), 4);
/// assert_eq!(built.tree().get(Morton(70)), 7);
/// # Ok::<(), voxdag::build::BuildError>(())
/// ```
pub struct TreeBuilder {
    depth: u8,
    /// Level of the top table's cells.
    top: u8,
    cubes: Cubes,
    open: [[Cube; 8]; 22],
    /// Code of the brick that came last.
    last: Option<u64>,
}

impl TreeBuilder {
    /// A cube of `2^depth` voxels a side, depth 0 to 21.
    pub fn new(depth: u8) -> Result<TreeBuilder, BuildError> {
        if u32::from(depth) > BITS {
            return Err(BuildError::Depth { found: depth });
        }
        // A third of the levels: the table stays small beside what it spares.
        let root = depth.max(BRICK_LEVEL);
        let bits = ((root - 1) / 3).min(root - BRICK_LEVEL);
        let cells = 1usize << (3 * bits);
        let (mut table, mut firsts) = (Vec::new(), Vec::new());
        table.try_reserve_exact(cells).map_err(|_| BuildError::Memory { bytes: 4 * cells as u64 })?;
        table.resize(cells, VACANT);
        firsts.try_reserve_exact(cells).map_err(|_| BuildError::Memory { bytes: 2 * cells as u64 })?;
        firsts.resize(cells, 0);
        let cubes = Cubes {
            patterns: Interned::new(),
            bits: [const { Interned::new() }; 19],
            pairs: Interned::new(),
            nodes: Interned::new(),
            few: Interned::new(),
            some: Interned::new(),
            many: Interned::new(),
            table,
            firsts,
        };
        Ok(TreeBuilder { depth, top: root - bits, cubes, open: [[Cube::Empty; 8]; 22], last: None })
    }

    /// Adds the next brick: `code` is that of its first voxel (a multiple of 64, ascending), `mask` its filled voxels in
    /// Morton order, `ids` their materials in the same order; voxels beyond the last id do not count as filled, ids beyond
    /// the last voxel are not read. What is out of order or outside is refused and changes nothing; after any other error
    /// the builder is of no more use. A brick without voxels is passed over.
    pub fn push(&mut self, code: Morton, mask: u64, ids: &[MaterialId]) -> Result<(), BuildError> {
        let (mut few, mut filled, mut left) = (Few::default(), 0u64, mask);
        for &id in ids.iter().take(mask.count_ones() as usize) {
            few.add(id);
            filled |= left & left.wrapping_neg();
            left &= left - 1;
        }
        let mask = filled;
        if mask == 0 {
            return Ok(());
        }
        let voxels = || (0..64u32).filter(|bit| mask >> bit & 1 != 0).zip(ids.iter().copied());
        self.follow(code)?;
        let cube = match few.count {
            1 => Cube::One(few.ids[0]),
            2 => {
                few.ids.sort_unstable();
                let mut bits = 0u64;
                voxels().for_each(|(bit, id)| bits |= u64::from(id == few.ids[1]) << bit);
                let swap = bits >> mask.trailing_zeros() & 1 != 0;
                let bits = if swap { mask & !bits } else { bits };
                let words = [mask as u32, (mask >> 32) as u32, bits as u32, (bits >> 32) as u32];
                Cube::Two { ids: few.ids, at: self.cubes.patterns.number(words)?, swap }
            }
            _ => Cube::More { entry: self.brick(mask, ids)?, first: ids[0] },
        };
        self.add(code, cube)
    }

    /// [`TreeBuilder::push`] where all voxels of the brick are of one material.
    pub fn push_uniform(&mut self, code: Morton, id: MaterialId) -> Result<(), BuildError> {
        self.follow(code)?;
        self.add(code, Cube::One(id))
    }

    /// Bytes that the cubes take so far, room to grow included.
    pub fn bytes(&self) -> u64 {
        let Cubes { patterns, bits, pairs, nodes, few, some, many, table, .. } = &self.cubes;
        let bits: u64 = bits.iter().map(Interned::bytes).sum();
        bits + patterns.bytes()
            + pairs.bytes()
            + nodes.bytes()
            + few.bytes()
            + some.bytes()
            + many.bytes()
            + 6 * table.len() as u64
    }

    /// Closes the open cubes and lays the words out.
    pub fn finish(mut self) -> Result<TreeBuf, BuildError> {
        if let Some(last) = self.last {
            self.close(last, self.top)?;
        }
        pack::pack(self.depth, self.top, self.cubes)
    }

    /// Checks a brick's code, and closes the cubes that the curve has left.
    fn follow(&mut self, code: Morton) -> Result<(), BuildError> {
        if !code.0.is_multiple_of(64) || code.0 >> (3 * u32::from(self.depth.max(BRICK_LEVEL))) != 0 {
            return Err(BuildError::Outside { code: code.0 });
        }
        let Some(last) = self.last else { return Ok(()) };
        if code.0 <= last {
            return Err(BuildError::Order { code: code.0 });
        }
        self.close(last, ((63 - (code.0 ^ last).leading_zeros()) / 3).min(u32::from(self.top)) as u8)
    }

    /// Hangs a cube of the brick level into its parent.
    fn add(&mut self, code: Morton, cube: Cube) -> Result<(), BuildError> {
        self.last = Some(code.0);
        self.hang(code.0, BRICK_LEVEL, cube)
    }

    fn hang(&mut self, code: u64, level: u8, cube: Cube) -> Result<(), BuildError> {
        if level < self.top {
            self.open[usize::from(level) + 1][usize::from(Morton(code).octant(level))] = cube;
            return Ok(());
        }
        let bits = self.depth.max(BRICK_LEVEL) - self.top;
        let [x, y, z] = Morton(code).decode().map(|k| (k >> self.top) as usize);
        let cell = ((z << bits | y) << bits) | x;
        self.cubes.firsts[cell] = cube.first().unwrap_or(0);
        self.cubes.table[cell] = self.entry(level, cube)?.unwrap_or(VACANT);
        Ok(())
    }

    /// Closes the cubes of levels 3 to `level` that the brick at `code` was in.
    fn close(&mut self, code: u64, level: u8) -> Result<(), BuildError> {
        for l in BRICK_LEVEL + 1..=level {
            let octants = core::mem::replace(&mut self.open[usize::from(l)], [Cube::Empty; 8]);
            let cube = self.closed(l, &octants)?;
            self.hang(code, l, cube)?;
        }
        Ok(())
    }

    /// What the octants of a cube make together.
    fn closed(&mut self, level: u8, octants: &[Cube; 8]) -> Result<Cube, BuildError> {
        let mut few = Few::default();
        for octant in octants {
            match *octant {
                Cube::Empty => {}
                Cube::One(id) => few.add(id),
                Cube::Two { ids, .. } => ids.into_iter().for_each(|id| few.add(id)),
                Cube::More { .. } => few.count = 3,
            }
        }
        let Some(first) = octants.iter().find_map(|octant| octant.first()) else { return Ok(Cube::Empty) };
        match few.count {
            1 => Ok(Cube::One(first)),
            2 => {
                few.ids.sort_unstable();
                let swap = first == few.ids[1];
                let octants = octants.map(|octant| match octant {
                    Cube::Empty | Cube::More { .. } => NOTHING,
                    Cube::One(id) => ZEROS + u32::from((id == few.ids[1]) != swap),
                    Cube::Two { at, swap: inner, .. } => INSIDE + 2 * at + u32::from(inner != swap),
                });
                let at = self.cubes.bits[usize::from(level) - 3].number(octants)?;
                Ok(Cube::Two { ids: few.ids, at, swap })
            }
            _ => {
                let mut entries = [ID << SHIFT | u32::from(first); 8];
                for (entry, octant) in entries.iter_mut().zip(octants) {
                    if let Some(filled) = self.entry(level - 1, *octant)? {
                        *entry = filled;
                    }
                }
                Ok(Cube::More { entry: INNER << SHIFT | self.cubes.nodes.number(entries)?, first })
            }
        }
    }

    /// The entry of a cube of a level; `None` if it is empty.
    fn entry(&mut self, level: u8, cube: Cube) -> Result<Option<u32>, BuildError> {
        Ok(Some(match cube {
            Cube::Empty => return Ok(None),
            Cube::One(id) => ID << SHIFT | u32::from(id),
            Cube::Two { ids, at, swap } => {
                let pair = [u32::from(ids[0]) | u32::from(ids[1]) << 16, level.into(), 2 * at + u32::from(swap)];
                PAIR << SHIFT | self.cubes.pairs.number(pair)?
            }
            Cube::More { entry, .. } => entry,
        }))
    }

    /// The entry of a brick of three materials and more. Its empty voxels go with the filled one before.
    fn brick(&mut self, mask: u64, ids: &[MaterialId]) -> Result<u32, BuildError> {
        let (mut palette, mut count, mut of_voxel) = ([0; 64], 0, [0u32; 64]);
        let mut left = ids.iter();
        let mut index = 0;
        for (bit, voxel) in of_voxel.iter_mut().enumerate() {
            if mask >> bit & 1 != 0
                && let Some(&id) = left.next()
            {
                index = palette[..count].iter().position(|p| *p == id).unwrap_or(count);
                if index == count {
                    palette[count] = id;
                    count += 1;
                }
            }
            *voxel = index as u32;
        }
        let kind = usize::from(count > 4) + usize::from(count > 16);
        let mut words = [0; 32];
        if kind == 2 {
            palette = of_voxel.map(|index| palette[index as usize]);
        }
        let ids = BRICK_IDS[kind];
        for (word, two) in words.iter_mut().zip(palette.chunks_exact(2)).take(ids) {
            *word = u32::from(two[0]) | u32::from(two[1]) << 16;
        }
        if kind < 2 {
            let width = 2 << kind;
            for (bit, index) in of_voxel.iter().enumerate() {
                words[ids + bit * width / 32] |= index << (bit * width % 32);
            }
        }
        let number = match kind {
            0 => self.cubes.few.number(cut(&words))?,
            1 => self.cubes.some.number(cut(&words))?,
            _ => self.cubes.many.number(words)?,
        };
        Ok((BRICK + kind as u32) << SHIFT | number)
    }
}

/// The first words.
fn cut<const N: usize>(words: &[u32; BRICK_WORDS[2]]) -> [u32; N] {
    core::array::from_fn(|i| words[i])
}
