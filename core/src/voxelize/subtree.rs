//! One subtree: its triangles descend together, level by level, and leave their marks in bricks in Morton order.

use alloc::vec::Vec;

use super::prism::{Crosshair, Prism, Verdict};
use super::{Cover, VoxelizeError, Voxelizer, reserve};
use crate::dag::BRICK_LEVEL;
use crate::morton::Morton;

/// A brick that holds marked voxels.
#[derive(Clone, Copy, Debug)]
pub struct Marked<'a> {
    /// Code of its first voxel within the subtree.
    pub code: Morton,
    /// Its marked voxels in Morton order.
    pub mask: u64,
    /// The triangles that marked them (indices into the mesh's, in mesh order), each with its voxels; never empty.
    pub triangles: &'a [(u32, u64)],
}

/// A cube on the way down: its first cell, the triangles that reach it, and the octant to visit next.
#[derive(Clone, Copy, Default)]
struct Frame {
    cell: [i32; 3],
    start: usize,
    end: usize,
    octant: u8,
}

/// The first voxel of the brick at a cell of the subtree that begins at `base`.
fn brick_of(base: [i64; 3], cell: [i32; 3]) -> [i64; 3] {
    core::array::from_fn(|i| base[i] + i64::from(cell[i]))
}

impl Voxelizer<'_> {
    /// Voxelises one subtree: calls `sink` with each brick that holds a marked voxel, in Morton order.
    ///
    /// # Panics
    /// If `subtree` is not below [`Voxelizer::subtrees`].
    pub fn voxelize<E: From<VoxelizeError>>(
        &self,
        subtree: usize,
        mut sink: impl FnMut(&Marked<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let base = self.subtree_code(subtree).decode().map(i64::from);
        let list = self.list(subtree);
        let mut prisms = Vec::new();
        let mut crosshairs = Vec::new();
        // The triangles of the cubes on the way down: place in `prisms`, and inequalities that are still open.
        let mut reached: Vec<(u32, u32)> = Vec::new();
        let mut marks: Vec<(u32, u64)> = Vec::new();
        reserve(&mut prisms, list.len())?;
        reserve(&mut reached, list.len())?;
        reserve(&mut crosshairs, if self.cover == Cover::Thin { list.len() } else { 0 })?;
        for (at, &triangle) in list.iter().enumerate() {
            let v = self.vertices(triangle as usize);
            let prism = Prism::new(&v, self.cover, base, self.level, self.grid.resolution);
            reached.push((at as u32, prism.active));
            prisms.push(prism);
            if self.cover == Cover::Thin {
                crosshairs.push(Crosshair::new(&v, base));
            }
        }

        let mut frames = [Frame::default(); 22];
        let top = self.level as usize;
        frames[top] = Frame { cell: [0; 3], start: 0, end: reached.len(), octant: 0 };
        let mut level = top;
        loop {
            let Frame { cell, start, end, octant } = frames[level];
            if level == BRICK_LEVEL as usize {
                // Mark the brick's voxels, triangle by triangle.
                marks.clear();
                reserve(&mut marks, end - start)?;
                let mut mask = 0;
                for &(at, open) in &reached[start..end] {
                    let marked = match self.cover {
                        Cover::Thin => crosshairs[at as usize].brick(cell),
                        Cover::Exact | Cover::Inflated => prisms[at as usize].brick(cell, open),
                    };
                    let marked = self.filled(list[at as usize], brick_of(base, cell), marked);
                    if marked != 0 {
                        mask |= marked;
                        marks.push((list[at as usize], marked));
                    }
                }
                if mask != 0 {
                    let code = Morton::encode_masked(cell.map(|c| c as u32));
                    sink(&Marked { code, mask, triangles: &marks })?;
                }
            } else if octant < 8 {
                // Go down into the next octant with the triangles that reach it.
                frames[level].octant += 1;
                reached.truncate(end);
                reserve(&mut reached, end - start)?;
                let size = 1 << (level - 1);
                let below = core::array::from_fn(|i| cell[i] + (i32::from(octant) >> i & 1) * size);
                for i in start..end {
                    let (at, open) = reached[i];
                    if let Verdict::Open(open) = prisms[at as usize].cube(below, size, open) {
                        reached.push((at, open));
                    }
                }
                if reached.len() > end {
                    level -= 1;
                    frames[level] = Frame { cell: below, start: end, end: reached.len(), octant: 0 };
                }
                continue;
            }
            // Go up from a brick, or from a cube whose octants are done.
            level += 1;
            if level > top {
                return Ok(());
            }
        }
    }

    /// The voxels that one triangle marks in one brick, given the code of the brick's first voxel: what
    /// [`Voxelizer::voxelize`] says of them, without the rest of the triangle. The way down is O(depth), however large the
    /// triangle is; the brick is 0 if it lies outside the grid.
    ///
    /// # Panics
    /// If `triangle` is no index into the mesh's triangles.
    pub fn brick(&self, triangle: u32, brick: Morton) -> u64 {
        let v = self.vertices(triangle as usize);
        let code = brick.0 >> (3 * u32::from(self.level));
        let subtree = self.subtrees.partition_point(|s| u64::from(s.0) < code);
        let known = self.subtrees.get(subtree).is_some_and(|s| u64::from(s.0) == code);
        if !known || self.list(subtree).binary_search(&triangle).is_err() {
            return 0;
        }
        let first = self.subtree_code(subtree).decode();
        let base = first.map(i64::from);
        let prism = Prism::new(&v, self.cover, base, self.level, self.grid.resolution);
        let cell: [i32; 3] = core::array::from_fn(|i| (brick.decode()[i] - first[i]) as i32 & !3);
        let mut open = prism.active;
        for level in (BRICK_LEVEL..self.level).rev() {
            match prism.cube(cell.map(|c| c >> level << level), 1 << level, open) {
                Verdict::Open(still) => open = still,
                Verdict::Apart => return 0,
            }
        }
        let marked = match self.cover {
            Cover::Thin => Crosshair::new(&v, base).brick(cell),
            Cover::Exact | Cover::Inflated => prism.brick(cell, open),
        };
        self.filled(triangle, brick_of(base, cell), marked)
    }
}
