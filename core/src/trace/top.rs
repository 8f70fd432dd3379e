//! The top grid: the upper levels of the octree as a dense grid of cells, made from the geometry when it is loaded.
//!
//! In: a geometry. Out: words that let a ray enter it half way down, and cross empty space in boxes. A cell that holds a
//! voxel names its node. An empty one says, for each of the eight octants a ray may head to,
//! where a box ends that is empty and begins at this cell. The box starts as the largest empty cube (a distance
//! transform from back to front) and grows along x, y and z while the slab ahead is empty. It is derived data: not stored,
//! optional, and the answers do not depend on it. Source: directed distances after Cohen and Sheffer (1994); boxes ours.
//!
//! ```text
//! word  ((octant n + z) n + y) n + x  of n^3 cells a side, octant = (dx >= 0) + 2 (dy >= 0) + 4 (dz >= 0)
//!       node: number < 2^31        empty: 1 << 31 | far plane along x | y << 9 | z << 18, in cells: 0 to n
//! ```

use crate::dag::{BRICK_LEVEL, NODE};
use crate::geometry::{Geometry, Nodes};

/// A checked top grid of a geometry, as [`Top::build_into`] writes it.
#[derive(Clone, Copy, Debug)]
pub struct Top<'a> {
    words: &'a [u32],
    /// Cells along an axis, as a power of two.
    bits: u8,
    /// Octree level of a cell.
    level: u8,
}

/// What a cell says to a ray.
pub(super) enum Cell {
    /// Its node.
    Node(u32),
    /// The planes, in voxels, through which a ray leaves the empty box ahead.
    Empty([i32; 3]),
}

impl<'a> Top<'a> {
    /// Words of a grid of `2^bits` cells a side.
    pub const fn words_for(bits: u8) -> usize {
        8 << (3 * bits)
    }

    /// Words of scratch memory that [`Top::build_into`] takes.
    pub const fn scratch_for(bits: u8) -> usize {
        let side = (1 << bits) + 1;
        side * side * side
    }

    /// The most cells along an axis, as a power of two, that a geometry can have a grid of; at most 8.
    pub fn most_bits<G: Geometry>(geometry: &G) -> u8 {
        geometry.depth().saturating_sub(BRICK_LEVEL).min(8)
    }

    /// The most cells, as a power of two and about `bits`, of a grid that serves [`super::Tracer::with_level`]: the level
    /// of its cells is even.
    pub fn bits_for_packets<G: Geometry>(geometry: &G, bits: u8) -> u8 {
        let depth = geometry.depth().max(BRICK_LEVEL);
        let bits = bits.min(Top::most_bits(geometry));
        if (depth - bits).is_multiple_of(2) { bits } else { bits.saturating_sub(1).max(depth % 2) }
    }

    /// Makes the grid of `2^bits` cells a side in lent memory; `None` if `bits` is above [`Top::most_bits`] or a slice
    /// has not the length that [`Top::words_for`] and [`Top::scratch_for`] say.
    pub fn build_into<G: Geometry>(
        geometry: &G,
        bits: u8,
        words: &'a mut [u32],
        scratch: &mut [u32],
    ) -> Option<Top<'a>> {
        if bits > Top::most_bits(geometry)
            || words.len() != Top::words_for(bits)
            || scratch.len() != Top::scratch_for(bits)
        {
            return None;
        }
        let level = geometry.depth().max(BRICK_LEVEL) - bits;
        let n = 1usize << bits;
        let at = |c: [usize; 3]| (c[2] * n + c[1]) * n + c[0];

        // Enter the nodes of the cells' level into the first octant's grid; NODE alone marks an empty cell.
        words.fill(NODE);
        for (code, node) in Nodes::new(*geometry, level) {
            words[at(code.decode().map(|x| (x >> level) as usize))] = node;
        }
        let sums = Sums::new(n, scratch, |c| words[at(c)] & NODE == 0);

        // Find each octant's boxes, from the cells that are last on its way to those that are first.
        let cells = n * n * n;
        for octant in 0..8 {
            let up: [bool; 3] = core::array::from_fn(|i| octant >> i & 1 != 0);
            let grid = octant * cells;
            for i in 0..cells {
                let back = [i % n, i / n % n, i / n / n];
                let c: [usize; 3] = core::array::from_fn(|k| if up[k] { n - 1 - back[k] } else { back[k] });
                let node = words[at(c)];
                let word = if node & NODE == 0 {
                    node
                } else {
                    // The largest empty cube is one larger than the smallest of those that begin at its successors.
                    let mut cube = FAR;
                    for successor in 1..8usize {
                        let on = |k: usize| successor >> k & 1;
                        if (0..3).all(|k| back[k] >= on(k)) {
                            let s = core::array::from_fn(|k| if up[k] { c[k] + on(k) } else { c[k] - on(k) });
                            let left = core::array::from_fn(|k| back[k] - on(k) + 1);
                            cube = cube.min(cube_of(reach_of(words[grid + at(s)], s, up), left));
                        }
                    }
                    let left = back.map(|b| b + 1);
                    let mut reach: [usize; 3] = left.map(|l| l.min(cube + 1));
                    // Grow it along each axis while the slab ahead is empty, up to the border. Where the box of the cell
                    // ahead is as wide as this one, it can be added whole.
                    for k in 0..3 {
                        while reach[k] < left[k] && reach[k] < FAR {
                            let ahead = core::array::from_fn(|j| match (j == k, up[j]) {
                                (true, true) => c[j] + reach[j],
                                (true, false) => c[j] - reach[j],
                                (false, _) => c[j],
                            });
                            let beyond = reach_of(words[grid + at(ahead)], ahead, up);
                            let wide = (0..3).all(|j| j == k || beyond[j] >= reach[j]);
                            let mut next = reach;
                            next[k] += if wide { beyond[k] } else { 1 };
                            if !wide && !sums.empty(c, up, next) {
                                break;
                            }
                            reach[k] = next[k].min(FAR);
                        }
                    }
                    let plane = |k: usize| if up[k] { c[k] + reach[k] } else { c[k] + 1 - reach[k] } as u32;
                    NODE | plane(0) | plane(1) << 9 | plane(2) << 18
                };
                words[grid + at(c)] = word;
            }
        }
        Some(Top { words, bits, level })
    }

    /// Whether it can be the grid of this geometry: its size fits, and all that it names are nodes of its level. The grid
    /// of another may pass, and then leads to wrong answers, but to nothing worse.
    pub(super) fn fits<G: Geometry>(&self, geometry: &G) -> bool {
        let known = |word: u32| word & NODE != 0 || geometry.is_node(word, self.level);
        self.level + self.bits == geometry.depth().max(BRICK_LEVEL) && self.words.iter().all(|&word| known(word))
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.words)
    }

    /// Its words.
    #[inline(always)]
    pub(super) fn words(&self) -> &'a [u32] {
        self.words
    }

    /// Cells along an axis, as a power of two.
    #[inline(always)]
    pub(super) fn bits(&self) -> u8 {
        self.bits
    }

    /// Octree level of a cell.
    #[inline(always)]
    pub(super) fn level(&self) -> usize {
        self.level as usize
    }

    /// The node of the cell around a voxel; `None` if it is empty.
    #[inline]
    pub(super) fn node(&self, voxel: [u32; 3]) -> Option<u32> {
        match self.cell(voxel.map(|x| x as i32), 0) {
            Cell::Node(node) => Some(node),
            Cell::Empty(_) => None,
        }
    }

    /// The cell around voxel `p`, for rays that head to `octant`.
    #[inline(always)]
    pub(super) fn cell(&self, p: [i32; 3], octant: usize) -> Cell {
        let c = p.map(|x| (x >> self.level) as usize);
        let word = self.words[(((octant << self.bits | c[2]) << self.bits) | c[1]) << self.bits | c[0]];
        if word & NODE == 0 {
            Cell::Node(word)
        } else {
            Cell::Empty([0, 9, 18].map(|shift| ((word >> shift & 0x1ff) << self.level) as i32))
        }
    }
}

/// A top grid that owns its words.
#[cfg(feature = "alloc")]
#[derive(Clone, Debug)]
pub struct TopBuf {
    words: alloc::vec::Vec<u32>,
    bits: u8,
    level: u8,
}

#[cfg(feature = "alloc")]
impl TopBuf {
    /// Makes the grid of `2^bits` cells a side, or of as many as the geometry can have; `Err` with the number of bytes that
    /// could not be had.
    pub fn new<G: Geometry>(geometry: &G, bits: u8) -> Result<TopBuf, usize> {
        let bits = bits.min(Top::most_bits(geometry));
        let lend = |len: usize| -> Result<alloc::vec::Vec<u32>, usize> {
            let mut list = alloc::vec::Vec::new();
            list.try_reserve_exact(len).map_err(|_| 4 * len)?;
            list.resize(len, 0);
            Ok(list)
        };
        let (mut words, mut scratch) = (lend(Top::words_for(bits))?, lend(Top::scratch_for(bits))?);
        let level = geometry.depth().max(BRICK_LEVEL) - bits;
        Top::build_into(geometry, bits, &mut words, &mut scratch).expect("the sizes are those that the grid takes");
        Ok(TopBuf { words, bits, level })
    }

    /// The view that a tracer takes.
    pub fn as_top(&self) -> Top<'_> {
        Top { words: &self.words, bits: self.bits, level: self.level }
    }
}

/// Cells that nothing limits: a box is never longer.
const FAR: usize = 255;

/// How far the box of cell `c` with this word reaches, per axis; 0 if the cell is not empty.
fn reach_of(word: u32, c: [usize; 3], up: [bool; 3]) -> [usize; 3] {
    if word & NODE == 0 {
        return [0; 3];
    }
    core::array::from_fn(|k| {
        let plane = (word >> (9 * k) & 0x1ff) as usize;
        if up[k] { plane - c[k] } else { c[k] + 1 - plane }
    })
}

/// Side of the largest empty cube that begins at a cell whose box has this reach, `left` cells from the borders ahead; the
/// world beyond the border is empty. The box holds the cube and was grown from it, so its shortest side tells.
fn cube_of(reach: [usize; 3], left: [usize; 3]) -> usize {
    reach.into_iter().zip(left).map(|(r, l)| if r == l { FAR } else { r }).fold(FAR, usize::min)
}

/// Numbers of filled cells below each corner of the grid, so that any box can be asked in eight look-ups.
struct Sums<'a> {
    sums: &'a [u32],
    side: usize,
}

impl<'a> Sums<'a> {
    fn new(n: usize, sums: &'a mut [u32], filled: impl Fn([usize; 3]) -> bool) -> Self {
        let side = n + 1;
        sums.fill(0);
        for z in 0..n {
            for y in 0..n {
                let mut row = 0;
                for x in 0..n {
                    row += u32::from(filled([x, y, z]));
                    let corner = ((z + 1) * side + y + 1) * side + x + 1;
                    let (below, left) = (side * side, side);
                    sums[corner] = row + sums[corner - below] + sums[corner - left] - sums[corner - below - left];
                }
            }
        }
        Sums { sums, side }
    }

    /// Whether the box that begins at cell `c` and reaches so many cells ahead holds no filled one.
    fn empty(&self, c: [usize; 3], up: [bool; 3], reach: [usize; 3]) -> bool {
        let low: [usize; 3] = core::array::from_fn(|k| if up[k] { c[k] } else { c[k] + 1 - reach[k] });
        let sum = |x: usize, y: usize, z: usize| {
            let end = |k: usize, high: usize| low[k] + high * reach[k];
            self.sums[(end(2, z) * self.side + end(1, y)) * self.side + end(0, x)]
        };
        let slab = |z| sum(1, 1, z) + sum(0, 0, z) - sum(0, 1, z) - sum(1, 0, z);
        slab(1) == slab(0)
    }
}
