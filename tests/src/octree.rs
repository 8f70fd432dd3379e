//! Naive twins of the octree and of the DAG: sorted lists of voxels, and words written from them level by level.
//!
//! In: Morton codes, or a self-similar shape given by its states. Out: the words that `voxdag::dag` documents, counts
//! per level, and checks of words against the documentation by a reader of our own. The twin knows no reducer: it cuts
//! the sorted list into the subtrees of a level and looks for equal pieces.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigUint;

/// Words of the header.
const HEADER: u32 = 24;

/// The Morton code of a voxel, bit by bit.
pub fn interleave(voxel: [u32; 3]) -> u64 {
    let mut code = 0;
    for bit in 0..21 {
        for axis in 0..3 {
            code |= u64::from(voxel[axis] >> bit & 1) << (3 * bit + axis);
        }
    }
    code
}

/// The voxel of a Morton code, bit by bit.
pub fn deinterleave(code: u64) -> [u32; 3] {
    let mut voxel = [0; 3];
    for bit in 0..21 {
        for axis in 0..3 {
            voxel[axis] |= ((code >> (3 * bit + axis) & 1) as u32) << bit;
        }
    }
    voxel
}

/// A set of voxels as a sorted list of codes.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct VoxelSet {
    codes: Vec<u64>,
}

impl VoxelSet {
    /// The set of these voxels, in any order, doubles allowed.
    pub fn new(voxels: impl IntoIterator<Item = [u32; 3]>) -> VoxelSet {
        VoxelSet { codes: voxels.into_iter().map(interleave).collect::<BTreeSet<_>>().into_iter().collect() }
    }

    /// The codes, ascending.
    pub fn codes(&self) -> &[u64] {
        &self.codes
    }

    /// Whether a voxel is in the set.
    pub fn contains(&self, voxel: [u32; 3]) -> bool {
        self.any(0, voxel)
    }

    /// Whether the cube of side 2^`level` at `corner` (a multiple of 2^`level`) holds a voxel of the set.
    pub fn any(&self, level: u8, corner: [u32; 3]) -> bool {
        let first = interleave(corner);
        let next = self.codes.partition_point(|&c| c < first);
        self.codes.get(next).is_some_and(|&c| c >> (3 * level) == first >> (3 * level))
    }

    /// The bricks that hold voxels: the code of the first of their 64 places, and the mask; ascending.
    pub fn bricks(&self) -> Vec<(u64, u64)> {
        let bricks = self.codes.chunk_by(|a, b| a >> 6 == b >> 6);
        bricks.map(|voxels| (voxels[0] & !63, voxels.iter().fold(0, |mask, v| mask | 1 << (v & 63)))).collect()
    }

    /// For a level: the subtrees in Morton order, each as the list of its voxels relative to its corner.
    fn subtrees(&self, level: u8) -> Vec<Vec<u64>> {
        let shift = 3 * u32::from(level);
        let pieces = self.codes.chunk_by(|a, b| a >> shift == b >> shift);
        pieces.map(|voxels| voxels.iter().map(|v| v & ((1u64 << shift) - 1)).collect()).collect()
    }

    /// Nodes of a level: how many different ones, and how many in the octree without sharing.
    pub fn level_counts(&self, level: u8) -> (usize, usize) {
        let all = self.subtrees(level);
        (all.iter().collect::<BTreeSet<_>>().len(), all.len())
    }

    /// Over the different nodes of a level: how many of their octants hold something.
    pub fn unique_octants(&self, level: u8) -> u64 {
        let all = self.subtrees(level);
        let shift = 3 * (u32::from(level) - 1);
        let octants = |voxels: &Vec<u64>| voxels.chunk_by(|a, b| a >> shift == b >> shift).count() as u64;
        all.iter().collect::<BTreeSet<_>>().into_iter().map(octants).sum()
    }

    /// The DAG's words, by the documentation alone. The codes must be below 8^`depth`.
    pub fn words(&self, depth: u8) -> Vec<u32> {
        assert!(self.codes.last().is_none_or(|&c| c >> (3 * depth) == 0), "a voxel outside the cube");
        let mut writer = Writer::new(depth);
        let mut below = BTreeMap::new();
        for (voxels, brick) in first_visits(self.subtrees(2)).into_iter().zip(0..) {
            writer.words.extend(mask_words(voxels.iter().fold(0, |mask, v| mask | 1u64 << v)));
            below.insert(voxels, HEADER + 2 * brick);
        }
        writer.end_level(2);
        for level in 3..=depth {
            let mut here = BTreeMap::new();
            for voxels in first_visits(self.subtrees(level)) {
                // The children are the pieces with the same octant, that is the same three top bits.
                let shift = 3 * (u32::from(level) - 1);
                let children = voxels.chunk_by(|a, b| a >> shift == b >> shift).map(|piece| {
                    let relative: Vec<u64> = piece.iter().map(|v| v & ((1u64 << shift) - 1)).collect();
                    ((piece[0] >> shift) as u32, below[&relative])
                });
                let word = writer.node(children);
                here.insert(voxels, word);
            }
            writer.end_level(level);
            below = here;
        }
        writer.finish()
    }
}

/// The different elements, in the order of their first appearance.
fn first_visits(all: Vec<Vec<u64>>) -> Vec<Vec<u64>> {
    let mut seen = BTreeSet::new();
    all.into_iter().filter(|voxels| seen.insert(voxels.clone())).collect()
}

fn mask_words(mask: u64) -> [u32; 2] {
    [mask as u32, (mask >> 32) as u32]
}

/// Writes sections one after the other and the header's level starts.
struct Writer {
    words: Vec<u32>,
}

impl Writer {
    fn new(depth: u8) -> Writer {
        let mut words = vec![0; HEADER as usize];
        words[0] = u32::from(depth);
        Writer { words }
    }

    /// Writes a node with children (octant, word) and gives its word.
    fn node(&mut self, children: impl Iterator<Item = (u32, u32)>) -> u32 {
        let at = self.words.len();
        self.words.push(1 << 31);
        for (octant, child) in children {
            self.words[at] |= 1 << octant;
            self.words.push(child);
        }
        at as u32
    }

    /// Notes where the level above starts: level 3 in word 2, and so on; after level 21 the end.
    fn end_level(&mut self, level: u8) {
        self.words[usize::from(level)] = self.words.len() as u32;
        if level == 2 {
            self.words[1] = (self.words.len() as u32 - HEADER) / 2;
        }
    }

    fn finish(mut self) -> Vec<u32> {
        // Levels above the root are empty: they start and end at the end.
        let end = self.words.len() as u32;
        for word in usize::from(self.words[0].max(2) as u8)..=21 {
            self.words[word] = end;
        }
        self.words
    }
}

/// A shape in terms of itself: a state describes the content of a cube, and splits into the states of its octants.
/// Planes, walls and lattices of any depth have few states, so that cubes of side 2^21 can be written down.
pub trait Recursive {
    /// What is in a cube, seen from its corner.
    type State: Clone + Ord;

    /// The content of the octants (x + 2 y + 4 z) of a cube of side 2^`level`; `None` where there is nothing.
    /// A level-0 state that is there is a filled voxel.
    fn split(&self, level: u8, state: &Self::State) -> [Option<Self::State>; 8];
}

/// A node while it is unknown where it will stand: its children's numbers by octant, or a brick's mask.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Content {
    Brick(u64),
    Node(Vec<(u32, usize)>),
}

/// The DAG's words of a recursive shape in the cube of side 2^`depth`; `None` for an empty cube.
pub fn words_of<R: Recursive>(shape: &R, depth: u8, root: Option<&R::State>) -> Vec<u32> {
    let mut reducer = Reducer { shape, known: BTreeMap::new(), numbers: BTreeMap::new(), contents: Vec::new() };
    let top = depth.max(2);
    let root = root.and_then(|root| {
        if depth >= 2 {
            return reducer.reduce(top, root);
        }
        // A small cube is the first corner of its only brick.
        let mask = reducer.mask(depth, root);
        (mask != 0).then(|| reducer.number(2, Content::Brick(mask)))
    });
    // Number the nodes of each level in the order of their first visit.
    let mut order: Vec<Vec<usize>> = vec![Vec::new(); usize::from(top) + 1];
    if let Some(root) = root {
        let mut visited = BTreeSet::new();
        visit(&reducer.contents, top, root, &mut visited, &mut order);
    }
    let mut writer = Writer::new(depth);
    let mut place = vec![0; reducer.contents.len()];
    for level in 2..=top {
        for &number in &order[usize::from(level)] {
            match &reducer.contents[number] {
                Content::Brick(mask) => {
                    place[number] = writer.words.len() as u32;
                    writer.words.extend(mask_words(*mask));
                }
                Content::Node(children) => {
                    place[number] = writer.node(children.iter().map(|&(octant, child)| (octant, place[child])));
                }
            }
        }
        writer.end_level(level);
    }
    writer.finish()
}

struct Reducer<'a, R: Recursive> {
    shape: &'a R,
    known: BTreeMap<(u8, R::State), Option<usize>>,
    /// The level is part of the key: equal content on two levels is two nodes.
    numbers: BTreeMap<(u8, Content), usize>,
    contents: Vec<Content>,
}

impl<R: Recursive> Reducer<'_, R> {
    fn number(&mut self, level: u8, content: Content) -> usize {
        let contents = &mut self.contents;
        *self.numbers.entry((level, content.clone())).or_insert_with(|| {
            contents.push(content);
            contents.len() - 1
        })
    }

    fn mask(&self, level: u8, state: &R::State) -> u64 {
        if level == 0 {
            return 1;
        }
        let octants = self.shape.split(level, state);
        let parts = octants.iter().zip(0..).map(|(child, octant): (_, u32)| {
            child.as_ref().map_or(0, |c| self.mask(level - 1, c) << (octant << (3 * (level - 1))))
        });
        parts.fold(0, |mask, part| mask | part)
    }

    fn reduce(&mut self, level: u8, state: &R::State) -> Option<usize> {
        if let Some(&number) = self.known.get(&(level, state.clone())) {
            return number;
        }
        let content = if level == 2 {
            let mask = self.mask(2, state);
            (mask != 0).then_some(Content::Brick(mask))
        } else {
            let mut children = Vec::new();
            for (octant, child) in (0..).zip(self.shape.split(level, state)) {
                children.extend(child.and_then(|c| self.reduce(level - 1, &c)).map(|number| (octant, number)));
            }
            (!children.is_empty()).then_some(Content::Node(children))
        };
        let number = content.map(|content| self.number(level, content));
        self.known.insert((level, state.clone()), number);
        number
    }
}

fn visit(contents: &[Content], level: u8, number: usize, visited: &mut BTreeSet<usize>, order: &mut [Vec<usize>]) {
    if !visited.insert(number) {
        return;
    }
    order[usize::from(level)].push(number);
    if let Content::Node(children) = &contents[number] {
        for &(_, child) in children {
            visit(contents, level - 1, child, visited, order);
        }
    }
}

/// The number of voxels that words stand for, each node counted once, in integers that cannot overflow.
/// The words must be valid.
pub fn count_voxels(words: &[u32]) -> BigUint {
    let mut counts: BTreeMap<u32, BigUint> = BTreeMap::new();
    let mut last = BigUint::ZERO;
    let mut at = HEADER;
    while (at as usize) < words.len() {
        let start = at;
        if start < words[2] {
            last = BigUint::from(words[at as usize].count_ones() + words[at as usize + 1].count_ones());
            at += 2;
        } else {
            let children = (words[at as usize] & 0xff).count_ones();
            last = (1..=children).map(|i| &counts[&words[(at + i) as usize]]).sum();
            at += 1 + children;
        }
        counts.insert(start, last.clone());
    }
    last
}
