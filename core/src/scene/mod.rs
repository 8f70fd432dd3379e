//! The whole way from a mesh to a DAG and its materials, in parts that can run apart.
//!
//! In: a mesh, a grid and a choice. Out: the DAG, and per voxel its owner's material. [`Build::part`] voxelises and reduces
//! one subtree, on any thread; [`Join`] takes the parts in order. The bytes do not depend on how the parts were spread.
//! Between the two, materials are kept per brick, one word where its triangles agree, so no list of all voxels exists.
//! A limit on memory is checked before the memory is taken.
//!
//! ```
//! # use voxdag::{Grid, Mesh, Morton, scene::{Build, Options}};
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = Mesh { positions: &positions, triangles: &[[0, 1, 2]], ..Mesh::default() };
//! let grid = Grid::fit(&mesh.validate().unwrap(), 64).unwrap();
//! let built = Build::new(&mesh, &grid, &Options::default())?.run()?;
//! assert!(built.dag.dag().contains(Morton::encode([20, 20, 0]).unwrap()));
//! # Ok::<(), voxdag::scene::SceneError>(())
//! ```

mod owners;

use alloc::vec::Vec;

use self::owners::{MIXED, Owners};
use crate::build::{BuildError, DagBuf, DagBuilder};
use crate::colors::{ColorMode, Colored, ColorsBuf, Painted};
use crate::dag::Dag;
use crate::file::LoadError;
use crate::grid::Grid;
use crate::material::MaterialId;
use crate::materials::{AnyMaterials, MaterialsBuf, Single};
use crate::mesh::Mesh;
use crate::morton::Morton;
use crate::rank::{AnyRank, Prefix};
use crate::ranked::{MoxelsBuf, PackedBuf, PalettesBuf, RankedError};
use crate::table::{Entry, InsertError, Table, TableBuf};
use crate::texture::Maps;
use crate::tree::{TreeBuf, TreeBuilder};
use crate::voxelize::{Cover, VoxelizeError, Voxelizer};

/// How materials are kept beside the DAG.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum MaterialMode {
    /// Not at all: the scene has one material.
    None,
    /// A tree over space; the smallest and the fastest.
    #[default]
    Tree,
    /// The thesis's hash table without normals (its part 2).
    Table,
    /// The thesis's hash table with the owner's normal (its part 1).
    TableNormals,
    /// Packed ids by rank.
    Ranked,
    /// Blocks of ids by rank, each with a palette of its own.
    Palettes,
    /// Williams's moxel table without normals.
    Moxels,
    /// Williams's moxel table with the owner's normal.
    MoxelsNormals,
}

impl MaterialMode {
    /// Whether voxels keep the normal of their owner.
    pub fn has_normals(self) -> bool {
        matches!(self, MaterialMode::TableNormals | MaterialMode::MoxelsNormals)
    }
}

/// What to build.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Options {
    /// Which voxels a triangle marks.
    pub cover: Cover,
    /// How materials are kept.
    pub materials: MaterialMode,
    /// How the colours of textures are kept.
    pub colors: ColorMode,
    /// Most bytes that building may take at one time, beside the mesh; `None` for no limit.
    pub memory_limit: Option<u64>,
    /// How many parts are built at the same time, for the limit; 0 counts as 1.
    pub parts_at_once: usize,
}

/// Why a scene cannot be built.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum SceneError {
    /// The mesh or the grid.
    Voxelize(VoxelizeError),
    /// The DAG.
    Reduce(BuildError),
    /// The material table.
    Table(InsertError),
    /// The memory limit would be passed.
    Limit {
        /// Bytes needed at least.
        needed: u64,
        /// Bytes that will do, by the estimate of voxels; `needed` where there is none yet.
        enough: u64,
        /// Bytes allowed.
        limit: u64,
        /// Whether a coarser grid needs less.
        coarser: bool,
    },
}

impl core::fmt::Display for SceneError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            SceneError::Voxelize(e) => e.fmt(f),
            SceneError::Reduce(e) => e.fmt(f),
            SceneError::Table(e) => e.fmt(f),
            SceneError::Limit { needed, limit, .. } => {
                write!(f, "building needs about {needed} bytes of memory, the limit is {limit}")
            }
        }
    }
}

impl core::error::Error for SceneError {}

impl From<VoxelizeError> for SceneError {
    fn from(e: VoxelizeError) -> Self {
        SceneError::Voxelize(e)
    }
}

impl From<BuildError> for SceneError {
    fn from(e: BuildError) -> Self {
        SceneError::Reduce(e)
    }
}

impl From<InsertError> for SceneError {
    fn from(e: InsertError) -> Self {
        SceneError::Table(e)
    }
}

/// A mesh sorted into parts, ready to be built.
pub struct Build<'m> {
    voxelizer: Voxelizer<'m>,
    options: Options,
    /// Bytes of the snapped vertices and the sorted triangles.
    sorted: u64,
}

/// A built subtree and the materials of its voxels.
pub struct Part {
    at: Morton,
    dag: DagBuf,
    owners: Owners,
}

/// What [`Build::run`] gives.
pub struct Built {
    /// The geometry.
    pub dag: DagBuf,
    /// The material of each voxel.
    pub materials: MaterialsBuf,
    /// The colours that textures gave to voxels; `None` if no voxel has one.
    pub colors: Option<ColorsBuf>,
    /// The counts of ranks, where materials or colours go by them.
    counts: Option<Vec<u32>>,
}

impl Built {
    /// What the voxels look like: for [`View`](crate::render::View), or for the [`Parts`](crate::file::Parts) of a file. An
    /// error if one of the three was replaced by that of other voxels.
    pub fn looks(&self) -> Result<Painted<'_, AnyMaterials<'_>>, LoadError> {
        let counts = self.counts.as_ref().map(|counts| Prefix::new(self.dag.dag(), counts)).transpose();
        let rank = counts.map_err(LoadError::Ranks)?.map(AnyRank::Prefix);
        let materials = self.materials.as_materials(rank).map_err(LoadError::Ids)?;
        let colored = self.colors.as_ref().map(ColorsBuf::as_colors).map(|colors| {
            let missing = RankedError::Voxels { expected: 0, found: colors.count() };
            Colored::new(rank.ok_or(missing)?, colors)
        });
        Ok(Painted { materials, colors: colored.transpose().map_err(LoadError::Colors)? })
    }
}

/// Bytes that building takes per word of the DAG: the word, its share of the hash sets, and its copy at the end.
const BYTES_PER_WORD: u64 = 12;

impl<'m> Build<'m> {
    /// Checks mesh, grid and limit, snaps the vertices and sorts the triangles into parts. O(triangles).
    pub fn new(mesh: &Mesh<'m>, grid: &Grid, options: &Options) -> Result<Build<'m>, SceneError> {
        let limit = options.memory_limit.unwrap_or(u64::MAX);
        let voxelizer = Voxelizer::within(mesh, grid, options.cover, limit).map_err(|error| match error {
            VoxelizeError::Memory { bytes } if bytes > limit => {
                SceneError::Limit { needed: bytes, enough: bytes, limit, coarser: false }
            }
            error => error.into(),
        })?;
        let sorted = voxelizer.bytes();
        let build = Build { voxelizer, options: *options, sorted };
        // The estimate of voxels can be too high by as much as triangles share voxels; half of it is safe to refuse by.
        build.within(table_bytes(options.materials, build.voxelizer.estimate() / 2))?;
        Ok(build)
    }

    /// With the textures of the materials, by id: colours ([`Built::colors`], and with the materials [`Built::looks`]) and what
    /// is cut out. They lie where [`Mesh::uvs`] says, and are drawn on materials that are
    /// [`textured`](crate::Material::textured). `core/examples/textured.rs` shows all of it.
    pub fn with_textures(mut self, textures: &'m [Maps]) -> Build<'m> {
        self.voxelizer = self.voxelizer.with_textures(textures);
        self
    }

    /// Refuses `needed` bytes beside the sorted triangles if they are over the limit.
    fn within(&self, needed: u64) -> Result<(), SceneError> {
        let needed = needed.saturating_add(self.sorted);
        match self.options.memory_limit {
            Some(limit) if needed > limit => {
                Err(SceneError::Limit { needed, enough: self.enough().max(needed), limit, coarser: true })
            }
            _ => Ok(()),
        }
    }

    /// Bytes that will do, by the estimate of voxels: per voxel its slots in the table, 3 for the lists of owners and 3
    /// for the DAG, which are more than meshes take.
    fn enough(&self) -> u64 {
        let voxels = self.voxelizer.estimate();
        let owner = match self.options.materials {
            MaterialMode::None => 0,
            mode if mode.has_normals() => 15,
            _ => 3,
        };
        let parts = (0..self.parts()).map(|part| self.part_bytes(part)).max().unwrap_or(0);
        let lists = voxels.saturating_mul(owner + 3).saturating_add(self.sorted).saturating_add(parts);
        table_bytes(self.options.materials, voxels).saturating_add(lists)
    }

    /// Bytes of the triangles of as many parts as are built at the same time, if all were like this one.
    fn part_bytes(&self, part: usize) -> u64 {
        self.voxelizer.subtree_bytes(part).saturating_mul(self.options.parts_at_once.max(1) as u64)
    }

    /// A builder's refusal: over our limit, or over the format's.
    fn reduce_error(&self, error: BuildError) -> SceneError {
        match error {
            BuildError::Words { needed } => match self.within(needed.saturating_mul(BYTES_PER_WORD)) {
                Err(over) => over,
                Ok(()) => SceneError::Reduce(error),
            },
            error => SceneError::Reduce(error),
        }
    }

    /// Number of parts. They can be built in any order and on any thread.
    pub fn parts(&self) -> usize {
        self.voxelizer.subtrees()
    }

    /// Voxelises and reduces one part.
    ///
    /// # Panics
    /// If `part` is not below [`Build::parts`].
    pub fn part(&self, part: usize) -> Result<Part, SceneError> {
        self.within(self.part_bytes(part))?;
        let mut builder = DagBuilder::new(self.voxelizer.subtree_depth())?;
        self.limit_words(&mut builder);
        let mut owners = Owners::default();
        self.voxelizer.voxelize::<SceneError>(part, |brick| {
            builder.push(brick.code, brick.mask).map_err(|e| self.reduce_error(e))?;
            match self.options.materials {
                MaterialMode::None => Ok(()),
                mode => owners.push(&self.voxelizer, part, brick, mode.has_normals()),
            }
        })?;
        let dag = builder.finish().map_err(|e| self.reduce_error(e))?;
        Ok(Part { at: self.voxelizer.subtree_code(part), dag, owners })
    }

    fn limit_words(&self, builder: &mut DagBuilder) {
        if let Some(limit) = self.options.memory_limit {
            let words = limit.saturating_sub(self.sorted) / BYTES_PER_WORD;
            builder.limit(u32::try_from(words).unwrap_or(u32::MAX));
        }
    }

    /// Starts to put parts together.
    pub fn join(&self) -> Result<Join<'_, 'm>, SceneError> {
        let mut builder = DagBuilder::new(self.voxelizer.grid().depth())?;
        self.limit_words(&mut builder);
        Ok(Join { build: self, builder, owners: Owners::default() })
    }

    /// Builds all parts one after the other on this thread.
    pub fn run(&self) -> Result<Built, SceneError> {
        let mut join = self.join()?;
        for part in 0..self.parts() {
            join.add(self.part(part)?)?;
        }
        join.built()
    }
}

/// Bytes of the table of so many voxels, at most; a tree grows with its borders only, and is watched as it does.
fn table_bytes(mode: MaterialMode, voxels: u64) -> u64 {
    let words = |normals| Table::words_for(Table::slots_for(voxels), normals).saturating_mul(4);
    match mode {
        MaterialMode::None | MaterialMode::Tree => 0,
        MaterialMode::Table => words(false),
        MaterialMode::TableNormals => words(true),
        MaterialMode::Ranked => voxels.saturating_mul(2),
        // An index of a byte, an id of two in the palette.
        MaterialMode::Palettes => voxels.saturating_mul(3),
        MaterialMode::Moxels => voxels.saturating_mul(4),
        MaterialMode::MoxelsNormals => voxels.saturating_mul(8),
    }
}

fn voxels_of(dag: &Dag<'_>) -> u64 {
    dag.bricks().map(|(_, mask)| u64::from(mask.count_ones())).sum()
}

/// Puts parts together.
pub struct Join<'b, 'm> {
    build: &'b Build<'m>,
    builder: DagBuilder,
    owners: Owners,
}

impl<'b, 'm> Join<'b, 'm> {
    /// Takes the next part; parts come in the order of their numbers.
    pub fn add(&mut self, part: Part) -> Result<(), SceneError> {
        self.builder.append(part.at, &part.dag.dag()).map_err(|e| self.build.reduce_error(e))?;
        self.build.within((self.owners.bytes() + part.owners.bytes()).saturating_add(4 * self.builder.words()))?;
        self.owners.append(part.owners)
    }

    /// The finished DAG, and what its material map is made from.
    pub fn finish(self) -> Result<(DagBuf, PendingMaterials<'b, 'm>), SceneError> {
        let dag = self.builder.finish().map_err(|e| self.build.reduce_error(e))?;
        Ok((dag, PendingMaterials { build: self.build, owners: self.owners, held: 0 }))
    }

    /// The finished DAG with its materials and colours as the options say, made on this thread.
    pub fn built(self) -> Result<Built, SceneError> {
        let options = self.build.options;
        let (dag, mut pending) = self.finish()?;
        let materials = pending.materials(&dag.dag(), options.materials)?;
        pending.hold(size_of_val(materials.words()) as u64);
        let colors = pending.colors(&dag.dag(), options.colors)?;
        pending.hold(colors.as_ref().map_or(0, |colors| size_of_val(colors.as_colors().words())) as u64);
        let mut counts = None;
        if materials.needs_rank() || colors.is_some() {
            pending.afford(&dag.dag(), 4 * Prefix::words_for(&dag.dag()) as u64)?;
            counts = Some(Prefix::build(&dag.dag())?);
        }
        Ok(Built { dag, materials, colors, counts })
    }
}

/// The owners of all voxels, on their way into a representation.
pub struct PendingMaterials<'b, 'm> {
    build: &'b Build<'m>,
    owners: Owners,
    /// Bytes of what was made of the voxels and is kept.
    held: u64,
}

impl PendingMaterials<'_, '_> {
    /// An empty table with room for the voxels of `dag`.
    ///
    /// Threads fill it together: each takes a part of [`TableMut::split`](crate::table::TableMut::split) and all
    /// [`PendingMaterials::entries`].
    pub fn empty_table(&self, dag: &Dag<'_>, normals: bool) -> Result<TableBuf, SceneError> {
        let voxels = self.afford_voxels(dag, if normals { MaterialMode::TableNormals } else { MaterialMode::Table })?;
        Ok(TableBuf::new(voxels, normals)?)
    }

    /// Counts bytes that are kept of what was made, for the limit.
    pub fn hold(&mut self, bytes: u64) {
        self.held = self.held.saturating_add(bytes);
    }

    /// Refuses to take `bytes` beside `dag`, the owners and what is held, if that is over the limit.
    pub fn afford(&self, dag: &Dag<'_>, bytes: u64) -> Result<(), SceneError> {
        let held = self.held.saturating_add(self.owners.bytes() + 4 * dag.words().len() as u64);
        self.build.within(held.saturating_add(bytes))
    }

    /// Refuses what grows with the voxels, before it does; their number.
    fn afford_voxels(&self, dag: &Dag<'_>, mode: MaterialMode) -> Result<u64, SceneError> {
        let voxels = voxels_of(dag);
        self.afford(dag, table_bytes(mode, voxels))?;
        Ok(voxels)
    }

    /// The colours of the voxels of `dag`, the DAG that these owners came with; `None` if no voxel has a texture.
    pub fn colors(&self, dag: &Dag<'_>, mode: ColorMode) -> Result<Option<ColorsBuf>, SceneError> {
        if self.owners.colors.is_empty() {
            return Ok(None);
        }
        self.afford(dag, voxels_of(dag).saturating_mul(3))?;
        let mut colors = self.owners.colors.iter().copied();
        let of = |material| if self.build.voxelizer.is_textured(material) { colors.next() } else { None };
        let buf = ColorsBuf::new(mode, self.entries(dag).map(|(_, entry)| entry.material).map(of))?;
        Ok(Some(buf))
    }

    /// Every voxel of `dag`, the DAG that these owners came with, in Morton order with its entry.
    pub fn entries(&self, dag: &Dag<'_>) -> impl Iterator<Item = (Morton, Entry)> {
        self.owners.entries(dag)
    }

    /// The material tree of `dag`, the DAG that these owners came with.
    pub fn tree(&self, dag: &Dag<'_>) -> Result<TreeBuf, SceneError> {
        let mut builder = TreeBuilder::new(dag.depth())?;
        let mut mixed = &self.owners.mixed[..];
        for (i, ((code, mask), &owner)) in dag.bricks().zip(&self.owners.bricks).enumerate() {
            if owner == MIXED {
                let (ids, rest) = mixed.split_at_checked(mask.count_ones() as usize).unwrap_or((mixed, &[]));
                mixed = rest;
                builder.push(code, mask, ids)?;
            } else {
                builder.push_uniform(code, owner as MaterialId)?;
            }
            if i % 4096 == 0 {
                self.afford(dag, 2 * builder.bytes())?;
            }
        }
        // Laying it out takes as much again.
        self.afford(dag, 2 * builder.bytes())?;
        Ok(builder.finish()?)
    }

    /// The materials in one representation, made on this thread. Normals are there if the build was to keep them.
    pub fn materials(&self, dag: &Dag<'_>, mode: MaterialMode) -> Result<MaterialsBuf, SceneError> {
        let entries = || self.entries(dag);
        let table = |normals| {
            let mut table = self.empty_table(dag, normals)?;
            table.insert_all(entries())?;
            Ok(MaterialsBuf::Table(table))
        };
        // An array by rank: refused before it is made if it may grow too large.
        let array = || self.afford_voxels(dag, mode).map(|_| entries());
        Ok(match mode {
            MaterialMode::None => MaterialsBuf::Single(Single(0)),
            MaterialMode::Tree => MaterialsBuf::Tree(self.tree(dag)?),
            MaterialMode::Table => return table(false),
            MaterialMode::TableNormals => return table(true),
            MaterialMode::Ranked => MaterialsBuf::Ranked(PackedBuf::from_entries(array()?)?),
            MaterialMode::Palettes => MaterialsBuf::Palettes(PalettesBuf::from_entries(array()?)?),
            MaterialMode::Moxels => MaterialsBuf::Moxels(MoxelsBuf::from_entries(array()?, false)?),
            MaterialMode::MoxelsNormals => MaterialsBuf::Moxels(MoxelsBuf::from_entries(array()?, true)?),
        })
    }
}
