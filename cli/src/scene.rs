//! From voxels to the words of a `.vxd` and back, and what they take.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use rayon::prelude::*;
use serde::Serialize;
use voxdag::build::DagBuf;
use voxdag::colors::{Colored, ColorsBuf, Painted};
use voxdag::dag::{BRICK_LEVEL, Stats};
use voxdag::file::{self, LoadError, Parts, Scene};
use voxdag::geometry::Geometry;
use voxdag::grid::{Bounds, Grid, UpAxis};
use voxdag::layout::AnyGeometry;
use voxdag::materials::{AnyMaterials, MaterialsBuf};
use voxdag::rank::AnyRank;
use voxdag::scene::{MaterialMode, PendingMaterials, SceneError};
use voxdag::trace::TopBuf;
use voxdag::trees;
use voxdag::voxelize::VoxelizeError;
use voxdag::{Dag, Material};

use crate::error::{Error, Kind, Result};
use crate::layout::Layout;
use crate::memory::Memory;
use crate::options::{BuildArgs, GeometryArg, MaterialsArg, UpAxisArg};
use crate::picture::Shown;
use crate::progress::Progress;
use crate::report::{self, grouped, size};
use crate::source::Source;
use crate::stats;
use crate::voxelize::{Voxels, voxelize};

/// A scene that was built, and what it took.
pub struct Built {
    pub grid: Grid,
    bounds: Bounds,
    up: UpAxis,
    layout: Layout,
    voxel_materials: MaterialsBuf,
    colors: Option<ColorsBuf>,
    materials: Vec<Material>,
    names: Vec<String>,
    pub triangles: usize,
    pub stats: Stats,
    pub cost: Cost,
}

/// Time by stage; a stage that overlaps another on other threads counts the time that the run waited for it.
#[derive(Clone, Copy)]
pub struct Cost {
    pub parse: Duration,
    /// Triangles to bricks, and bricks to subtrees.
    pub voxelize: Duration,
    /// Joining the subtrees.
    pub reduce: Duration,
    pub materials: Duration,
}

/// Bytes of a scene by what they hold.
#[derive(Clone, Copy, Serialize)]
pub struct Bytes {
    pub nodes: u64,
    pub bricks: u64,
    /// What says which material a voxel has.
    pub materials: u64,
    /// The colours of textures.
    pub colors: u64,
    /// Header, parameters and names of the materials.
    pub other: u64,
    /// All together.
    pub file: u64,
}

impl Bytes {
    /// Of a file of `file` bytes whose geometry has these counts.
    pub fn of(geometry: AnyGeometry<'_>, stats: &Stats, looks: Painted<'_, AnyMaterials<'_>>, file: u64) -> Bytes {
        let bricks = 8 * stats.levels[usize::from(BRICK_LEVEL)].unique;
        let nodes = 4 * geometry.words().len() as u64 - bricks;
        let Painted { materials, colors } = looks;
        // The counts of ranks belong to the materials if these go by them, else to the colours.
        let counts = |rank: Option<AnyRank<'_>>| rank.and_then(|rank| rank.words()).map_or(0, size_of_val);
        let colors = colors.map_or(0, |colored| {
            let own = if materials.rank().is_some() { 0 } else { counts(Some(colored.rank())) };
            (own + size_of_val(colored.colors().words())) as u64
        });
        let materials = (counts(materials.rank()) + size_of_val(materials.words())) as u64;
        Bytes {
            nodes,
            bricks,
            materials,
            colors,
            other: file.saturating_sub(nodes + bricks + materials + colors),
            file,
        }
    }

    /// For people.
    pub fn text(&self) -> String {
        let Bytes { nodes, bricks, materials, colors, .. } = *self;
        let parts = [("nodes", nodes), ("bricks", bricks), ("materials", materials), ("colors", colors)];
        let parts = parts.iter().filter(|(name, bytes)| *name != "colors" || *bytes > 0);
        let parts: Vec<_> = parts.map(|(name, bytes)| format!("{name} {}", size(*bytes))).collect();
        format!("{} ({}): {}", grouped(self.file), size(self.file), parts.join(", "))
    }
}

/// How materials are kept, as the flags say.
pub fn mode(args: &BuildArgs) -> MaterialMode {
    match args.materials.unwrap_or_default() {
        MaterialsArg::Tree => MaterialMode::Tree,
        MaterialsArg::Table => MaterialMode::Table,
        MaterialsArg::TableNormals => MaterialMode::TableNormals,
        MaterialsArg::Ranked => MaterialMode::Ranked,
        MaterialsArg::Palette => MaterialMode::Palettes,
        MaterialsArg::Moxel => MaterialMode::Moxels,
        MaterialsArg::MoxelNormals => MaterialMode::MoxelsNormals,
        MaterialsArg::None => MaterialMode::None,
    }
}

/// Builds the scene on the threads of the current pool, and holds it.
pub fn build(source: &Source, args: &BuildArgs, memory: &mut Memory) -> Result<Built> {
    let mode = mode(args);
    let built = voxelize(source, args, mode, memory, |voxels| {
        let Voxels { grid, bounds, dag, mut pending, voxelize, reduce } = voxels;
        let progress = Progress::stage("materials", 0);
        let (voxel_materials, mut time) = stats::timed(|| voxel_materials(&pending, dag.dag(), mode));
        let voxel_materials = voxel_materials?;
        pending.hold(size_of_val(voxel_materials.words()) as u64);
        let (colors, took) = stats::timed(|| match args.textures.unwrap_or_default().mode() {
            Some(mode) => pending.colors(&dag.dag(), mode),
            None => Ok(None),
        });
        let colors = colors?;
        time += took;
        drop(progress);
        pending.hold(colors.as_ref().map_or(0, |colors| size_of_val(colors.as_colors().words())) as u64);
        let dag = Arc::new(dag);
        let kind = args.geometry.unwrap_or_default();
        let (layout, laid_out) =
            stats::timed(|| layout(&pending, &dag, kind, voxel_materials.needs_rank() || colors.is_some()));
        let layout = layout?;
        let (materials, names) = match voxel_materials {
            MaterialsBuf::Single(_) => (vec![Material::GREY], vec!["grey".to_owned()]),
            _ => {
                let names = source.model.materials.iter().map(|named| named.name.clone());
                (source.model.palette(colors.is_some()).collect(), names.collect())
            }
        };
        Ok(Built {
            grid,
            bounds,
            up: match args.up_axis.unwrap_or_default() {
                UpAxisArg::Y => UpAxis::Y,
                UpAxisArg::Z => UpAxis::Z,
            },
            stats: layout.geometry().stats().map_err(|bytes| VoxelizeError::Memory { bytes: bytes as u64 })?,
            layout,
            voxel_materials,
            colors,
            materials,
            names,
            triangles: source.model.mesh().triangles.len(),
            cost: Cost { parse: source.parse_time, voxelize, reduce: reduce + laid_out, materials: time },
        })
    })?;
    if built.stats.voxels == 0 {
        let why = "map_d cuts everything out, or --cover thin leaves nothing";
        report::warning(format_args!("{}: no voxel is filled: {why}", source.path.display()));
    }
    memory.hold(built.held());
    Ok(built)
}

/// The layout of the voxels, if the memory limit allows it.
pub fn layout(
    pending: &PendingMaterials<'_, '_>,
    dag: &Arc<DagBuf>,
    kind: GeometryArg,
    ranks: bool,
) -> std::result::Result<Layout, SceneError> {
    pending.afford(&dag.dag(), Layout::bytes_for(&dag.dag(), kind, ranks)?)?;
    Ok(Layout::new(dag.clone(), kind, ranks)?)
}

/// What says which material a voxel has. A table is filled by all threads: each takes the entries of its part.
pub fn voxel_materials(
    pending: &PendingMaterials<'_, '_>,
    dag: Dag<'_>,
    mode: MaterialMode,
) -> std::result::Result<MaterialsBuf, SceneError> {
    let mut table = match mode {
        MaterialMode::Table => pending.empty_table(&dag, false)?,
        MaterialMode::TableNormals => pending.empty_table(&dag, true)?,
        mode => return pending.materials(&dag, mode),
    };
    table.fill(|table| {
        let parts: Vec<_> = table.split(rayon::current_num_threads() as u32).collect();
        let filled: std::result::Result<Vec<_>, _> = parts
            .into_par_iter()
            .map(|mut part| part.insert_all(pending.entries(&dag)).map(|()| part.finish()))
            .collect();
        table.join(filled?)
    })?;
    Ok(MaterialsBuf::Table(table))
}

impl Built {
    /// Bytes that it takes in memory.
    pub fn held(&self) -> u64 {
        let colors = self.colors.as_ref().map_or(0, |colors| colors.as_colors().words().len());
        4 * (self.layout.words() + self.voxel_materials.words().len() + colors) as u64
    }

    /// The colours of textures.
    fn colored(&self) -> Option<Colored<'_>> {
        let rank = self.layout.rank();
        let colored = self.colors.as_ref().zip(rank).map(|(colors, rank)| Colored::new(rank, colors.as_colors()));
        colored.map(|colored| colored.expect("colours are of the same voxels"))
    }

    fn voxel_materials(&self) -> AnyMaterials<'_> {
        let materials = self.voxel_materials.as_materials(self.layout.rank());
        materials.expect("ranks are there if they are needed, and of the same voxels")
    }

    /// The scene as it is drawn.
    pub fn shown(&self) -> Shown<'_> {
        Shown {
            grid: self.grid,
            bounds: self.bounds,
            up: self.up,
            geometry: self.layout.geometry(),
            materials: self.voxel_materials(),
            colors: self.colored(),
            palette: self.materials.clone(),
            lod: None,
        }
    }

    /// Gives the `.vxd` file to `use_parts`.
    fn with_parts<T>(&self, use_parts: impl FnOnce(Parts<'_>) -> T) -> T {
        let names: Vec<_> = self.names.iter().map(String::as_str).collect();
        use_parts(Parts {
            grid: self.grid,
            bounds: self.bounds,
            up: self.up,
            metres_per_unit: 0.0,
            geometry: self.layout.geometry(),
            voxel_materials: self.voxel_materials(),
            colors: self.colored(),
            materials: &self.materials,
            names: &names,
        })
    }

    /// Bytes that the `.vxd` file has.
    pub fn bytes(&self) -> Bytes {
        let file = self.with_parts(|parts| 4 * parts.file_len());
        let looks = Painted { materials: self.voxel_materials(), colors: self.colored() };
        Bytes::of(self.layout.geometry(), &self.stats, looks, file)
    }

    /// Writes the `.vxd` file; the geometry and what finds materials go out as they are.
    pub fn write(&self, mut file: impl Write) -> std::io::Result<()> {
        self.with_parts(|parts| {
            let mut head = vec![0; parts.head_len() as usize];
            parts.write_head(&mut head).map_err(std::io::Error::other)?;
            write_words(&head, &mut file)?;
            parts.body().into_iter().try_for_each(|words| write_words(words, &mut file))
        })
    }
}

/// Checks the words of the scene at `path`.
pub fn open<'a>(path: &Path, words: &'a [u32]) -> Result<Scene<'a>> {
    file::read(words).map_err(|error| {
        let hint = match error {
            LoadError::Version { .. } => {
                "build it again with this version of voxdag, or read it with the one that wrote it"
            }
            _ => "copy it again from where it was whole, or build it again",
        };
        Error::input(path, error).hint(hint)
    })
}

/// Counts voxels and nodes.
pub fn count(geometry: AnyGeometry<'_>) -> Result<Stats> {
    geometry
        .stats()
        .map_err(|bytes| Error::new(Kind::Failure, format_args!("out of memory: {bytes} bytes could not be had")))
}

/// The grid that makes rays faster; it pays for itself after some thousand of them.
pub fn top_grid(geometry: impl Geometry) -> Result<TopBuf> {
    TopBuf::new(&geometry, trees::TOP_BITS)
        .map_err(|bytes| Error::new(Kind::Failure, format_args!("out of memory: {bytes} bytes could not be had")))
}

/// Writes words as little-endian bytes, piece by piece.
fn write_words(words: &[u32], mut file: impl Write) -> std::io::Result<()> {
    let mut piece = Vec::with_capacity(1 << 16);
    for words in words.chunks(1 << 14) {
        piece.clear();
        piece.extend(words.iter().flat_map(|w| w.to_le_bytes()));
        file.write_all(&piece)?;
    }
    Ok(())
}
