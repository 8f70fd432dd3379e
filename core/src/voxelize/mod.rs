//! Triangles to filled voxels, exactly: bricks of 4^3 voxels in Morton order, subtree by subtree.
//!
//! In: a mesh and a grid. Out: per subtree the bricks that hold marked voxels, with the triangles that marked them. The
//! vertices are snapped once ([`Grid::snap`]); all that follows is integer. A triangle descends only into the cubes that
//! it can mark (`prism`), so the work is in proportion to its area, never to its box, and no list of voxels is kept.
//! Source: the 13-axis test of Akenine-Moeller (2001) on half-open voxels `[k, k+1)`; differs from the thesis (section
//! 2.2) in being exact, hierarchical and independent of the order of triangles and of their vertices.

mod owner;
mod paint;
mod prism;
mod subtree;

pub use owner::Owner;
pub use subtree::Marked;

use alloc::vec::Vec;

use crate::grid::{Grid, GridError};
use crate::material::MaterialId;
use crate::mesh::{Mesh, MeshError};
use crate::morton::Morton;
use crate::texture::Maps;
use prism::{Prism, Verdict};

/// Which voxels a triangle marks.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Cover {
    /// Those whose half-open box the snapped triangle meets: no point of it is outside a marked voxel, and every marked
    /// voxel holds a point of it. Rays cannot pass (the default).
    #[default]
    Exact,
    /// Those whose centre cross it pierces: thinner and 6-separating only, so that **rays may slip through edges**.
    Thin,
    /// Those whose closed box it comes within half a snapped unit of: holds every point of the original floats too.
    Inflated,
}

/// Why a mesh cannot be voxelised.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum VoxelizeError {
    /// The mesh is malformed.
    Mesh(MeshError),
    /// The grid is malformed, or does not hold the mesh.
    Grid(GridError),
    /// The heap refused, or the limit did.
    Memory {
        /// Bytes that were asked for and not given.
        bytes: u64,
    },
}

impl core::fmt::Display for VoxelizeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            VoxelizeError::Mesh(e) => e.fmt(f),
            VoxelizeError::Grid(e) => e.fmt(f),
            VoxelizeError::Memory { bytes } => write!(f, "out of memory: {bytes} bytes could not be had"),
        }
    }
}

impl core::error::Error for VoxelizeError {}

/// Subtrees along an axis at the most, as a power of two: enough to share work between threads.
const SPLIT: u8 = 3;

/// A snapped mesh, its triangles sorted into subtrees that can be voxelised apart.
pub struct Voxelizer<'m> {
    mesh: Mesh<'m>,
    grid: Grid,
    cover: Cover,
    /// By material.
    textures: &'m [Maps],
    /// Snapped positions; 0 for vertices that no triangle uses.
    snapped: Vec<[i32; 3]>,
    /// Level of the subtrees: each spans `2^level` voxels.
    level: u8,
    /// Code of each subtree in units of subtrees, and the end of its list in `lists`; those without triangles are left out.
    subtrees: Vec<(u32, u32)>,
    /// Triangles of the subtrees, one list after the other.
    lists: Vec<u32>,
}

/// Reserves room for `more` items, or says how many bytes were refused.
fn reserve<T>(list: &mut Vec<T>, more: usize) -> Result<(), VoxelizeError> {
    list.try_reserve(more).map_err(|_| VoxelizeError::Memory { bytes: (more * size_of::<T>()) as u64 })
}

impl<'m> Voxelizer<'m> {
    /// Checks and snaps the mesh and sorts its triangles into subtrees. O(triangles).
    pub fn new(mesh: &Mesh<'m>, grid: &Grid, cover: Cover) -> Result<Voxelizer<'m>, VoxelizeError> {
        Voxelizer::within(mesh, grid, cover, u64::MAX)
    }

    /// [`Voxelizer::new`], refusing to take more than `limit` bytes for snapped vertices and lists of triangles.
    pub fn within(mesh: &Mesh<'m>, grid: &Grid, cover: Cover, limit: u64) -> Result<Voxelizer<'m>, VoxelizeError> {
        mesh.validate().map_err(VoxelizeError::Mesh)?;
        let grid = grid.checked().map_err(VoxelizeError::Grid)?;

        let bytes = 12 * mesh.positions.len() as u64;
        if bytes > limit {
            return Err(VoxelizeError::Memory { bytes });
        }

        // Snap the vertices that triangles use.
        let mut snapped = Vec::new();
        reserve(&mut snapped, mesh.positions.len())?;
        const UNUSED: [i32; 3] = [-1; 3];
        snapped.resize(mesh.positions.len(), UNUSED);
        for &vertex in mesh.triangles.iter().flatten() {
            let slot = &mut snapped[vertex as usize];
            if *slot == UNUSED {
                let position = mesh.positions[vertex as usize];
                // Inflation makes up for half a unit; the far border must not be pulled in by a whole one.
                let nearest = if cover == Cover::Inflated { grid.snap_nearest(position) } else { grid.snap(position) };
                *slot = nearest.ok_or(VoxelizeError::Grid(GridError::Outside { vertex }))?;
            }
        }

        let depth = grid.depth().max(2);
        let level = depth - (depth - 2).min(SPLIT);
        let mut voxelizer = Voxelizer {
            mesh: *mesh,
            grid,
            cover,
            textures: &[],
            snapped,
            level,
            subtrees: Vec::new(),
            lists: Vec::new(),
        };
        voxelizer.sort_into_subtrees(limit)?;
        Ok(voxelizer)
    }

    /// With the textures of the materials, by id; those beyond the end have none.
    pub fn with_textures(self, textures: &'m [Maps]) -> Voxelizer<'m> {
        Voxelizer { textures, ..self }
    }

    /// Whether a material has a texture that colours its voxels.
    pub fn is_textured(&self, material: MaterialId) -> bool {
        self.textures.get(usize::from(material)).is_some_and(|maps| maps.diffuse().is_some())
    }

    /// Calls `each` with every triangle and every subtree that it can mark (its code in units of subtrees).
    fn each_subtree(&self, mut each: impl FnMut(usize, u32)) {
        let depth = self.grid.depth().max(2);
        let size = 1i32 << self.level;
        for triangle in 0..self.mesh.triangles.len() {
            let prism = Prism::new(&self.vertices(triangle), self.cover, [0; 3], depth, self.grid.resolution);
            let cells = prism.range().map(|(lo, hi)| (lo >> self.level, hi >> self.level));
            let alone = cells.iter().all(|(lo, hi)| lo == hi);
            for z in cells[2].0..=cells[2].1 {
                for y in cells[1].0..=cells[1].1 {
                    for x in cells[0].0..=cells[0].1 {
                        let k = [x, y, z];
                        // Where the triangle's box lies in one subtree, it can only be that one.
                        if alone || matches!(prism.cube(k.map(|c| c * size), size, prism.active), Verdict::Open(_)) {
                            each(Morton::encode_masked(k.map(|c| c as u32)).0 as usize, triangle as u32);
                        }
                    }
                }
            }
        }
    }

    /// Fills `subtrees` and `lists`, unless they and the snapped vertices take more bytes than `limit`.
    fn sort_into_subtrees(&mut self, limit: u64) -> Result<(), VoxelizeError> {
        // Count the triangles of each subtree, add up, and place: they keep their order within a subtree.
        let depth = self.grid.depth().max(2);
        let subtrees = 1usize << (3 * (depth - self.level));
        let mut ends = [0u32; 1 << (3 * SPLIT)];
        let mut total = 0u64;
        self.each_subtree(|code, _| {
            total += 1;
            ends[code] = ends[code].wrapping_add(1);
        });
        let bytes = 12 * self.snapped.len() as u64 + 4 * total;
        if total > u64::from(u32::MAX) || bytes > limit {
            return Err(VoxelizeError::Memory { bytes });
        }
        let mut start = 0;
        for count in &mut ends[..subtrees] {
            (*count, start) = (start, start + *count);
        }
        reserve(&mut self.lists, total as usize)?;
        let mut lists = core::mem::take(&mut self.lists);
        lists.resize(total as usize, 0);
        self.each_subtree(|code, triangle| {
            lists[ends[code] as usize] = triangle;
            ends[code] += 1;
        });
        self.lists = lists;
        reserve(&mut self.subtrees, subtrees)?;
        let mut start = 0;
        for (code, &end) in ends[..subtrees].iter().enumerate() {
            if end > start {
                self.subtrees.push((code as u32, end));
            }
            start = end;
        }
        Ok(())
    }

    /// Number of subtrees that hold triangles. They can be voxelised in any order and on any thread.
    pub fn subtrees(&self) -> usize {
        self.subtrees.len()
    }

    /// Octree levels of each subtree: it spans `2^depth` voxels a side.
    pub fn subtree_depth(&self) -> u8 {
        self.level
    }

    /// Code of the first voxel of a subtree; ascending with the index.
    ///
    /// # Panics
    /// If `subtree` is not below [`Voxelizer::subtrees`].
    pub fn subtree_code(&self, subtree: usize) -> Morton {
        Morton(u64::from(self.subtrees[subtree].0) << (3 * u32::from(self.level)))
    }

    /// The triangles that can mark voxels of a subtree, as indices into the mesh's.
    fn list(&self, subtree: usize) -> &[u32] {
        let start = if subtree == 0 { 0 } else { self.subtrees[subtree - 1].1 };
        &self.lists[start as usize..self.subtrees[subtree].1 as usize]
    }

    /// Bytes of the snapped vertices and of the lists of triangles.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.snapped[..]) + size_of_val(&self.lists[..])) as u64
    }

    /// Bytes that [`Voxelizer::voxelize`] takes for the triangles of a subtree.
    pub fn subtree_bytes(&self, subtree: usize) -> u64 {
        let crosshair = if self.cover == Cover::Thin { size_of::<prism::Crosshair>() } else { 0 };
        (self.list(subtree).len() * (size_of::<Prism>() + crosshair + 8)) as u64
    }

    /// The grid that the mesh was snapped to.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The snapped vertices of a triangle.
    fn vertices(&self, triangle: usize) -> [[i64; 3]; 3] {
        self.mesh.triangles[triangle].map(|v| self.snapped[v as usize].map(i64::from))
    }

    /// About how many voxels will be marked: the mean number of cells that a plane of the triangles' areas meets.
    /// Small or overlapping triangles make it too high, never by less than the surface that they share.
    pub fn estimate(&self) -> u64 {
        let unit = (crate::grid::SUB * crate::grid::SUB) as f64;
        let cells = |t| {
            let n = prism::normal(&self.vertices(t));
            n.iter().map(|x| x.abs() as f64).sum::<f64>() / (2.0 * unit)
        };
        (0..self.mesh.triangles.len()).map(cells).sum::<f64>() as u64
    }
}
