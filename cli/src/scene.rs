//! From a mesh file to the words of a `.vxd`, subtrees on all cores.

use std::collections::HashSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;
use voxdag::build::{BuildError, DagBuf};
use voxdag::colors::{Colored, ColorsBuf, Painted};
use voxdag::dag::{BRICK_LEVEL, Stats};
use voxdag::file::{self, LoadError, Parts, Scene};
use voxdag::geometry::Geometry;
use voxdag::grid::{Bounds, Grid, GridError, UpAxis};
use voxdag::layout::AnyGeometry;
use voxdag::materials::{AnyMaterials, MaterialsBuf};
use voxdag::mesh::MeshError;
use voxdag::obj::{self, ImportError, Model, Warning};
use voxdag::rank::AnyRank;
use voxdag::scene::{Build, MaterialMode, Options, PendingMaterials, SceneError};
use voxdag::texture::{DecodeError, Texture, decode};
use voxdag::trace::TopBuf;
use voxdag::trees;
use voxdag::voxelize::{Cover, VoxelizeError};
use voxdag::{Dag, Material, Mesh};

use crate::error::{Error, Kind, Result};
use crate::input::Companions;
use crate::layout::Layout;
use crate::memory::{Memory, round_up};
use crate::options::{BuildArgs, CoverArg, GeometryArg, MaterialsArg, UpAxisArg};
use crate::ordered::in_order;
use crate::picture::Shown;
use crate::progress::Progress;
use crate::report::{self, grouped, size, triple};
use crate::stats;

/// Voxels along the longest axis where nobody says otherwise.
const DEFAULT_RESOLUTION: u32 = 512;
/// Warnings about a mesh that are printed one by one.
const MAX_WARNINGS: usize = 10;

/// A mesh that was read.
pub struct Source {
    /// The name that messages give it.
    path: PathBuf,
    pub model: Model,
    /// The mesh's file and those that it names.
    pub files: Vec<PathBuf>,
    /// Time to parse it.
    parse_time: Duration,
    /// Bytes of the model.
    pub bytes: u64,
}

impl Source {
    /// A model that was not read from a file.
    pub fn of(name: &str, model: Model) -> Source {
        let bytes = bytes_of(&model);
        Source { path: PathBuf::from(name), model, files: Vec::new(), parse_time: Duration::ZERO, bytes }
    }
}

/// Parses the text of the mesh at `path`, which is held, with the files beside it. The mesh is held in its stead.
///
/// With the pictures that its materials name, if voxels are to have the colours of `textures`.
pub fn import_file(path: &Path, text: Vec<u8>, textures: bool, memory: &mut Memory) -> Result<Source> {
    let before = memory.held() - text.len() as u64;
    afford_import(path, &text, memory)?;
    let mut beside = Companions::of(path, memory);
    let source = import(path, &text, |name| beside.resolve(name)).and_then(|mut source| {
        if textures {
            load_textures(&mut source, &mut beside)?;
        }
        Ok(source)
    });
    let files = beside.finish()?;
    let source = Source { files, ..source? };
    drop(text);
    memory.release(memory.held() - before);
    memory.hold(source.bytes);
    Ok(source)
}

/// Refuses a mesh that could not be parsed within the limit.
pub fn afford_import(path: &Path, text: &[u8], memory: &Memory) -> Result<()> {
    let needed = import_bytes(text);
    let hint = format!("set --memory-limit to at least {}", round_up(memory.held() + needed));
    memory.afford(needed, &format!("parsing {}", path.display()), &hint)
}

/// About how many bytes parsing takes beside the text: measured, 3 for each of the text, and 40 to 120 a corner of a face.
fn import_bytes(text: &[u8]) -> u64 {
    let faces = text.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii_start).filter(|line| line.starts_with(b"f"));
    let corners: usize = faces.map(|line| line.iter().filter(|byte| byte.is_ascii_whitespace()).count()).sum();
    3 * text.len() as u64 + 120 * corners as u64
}

/// Parses the text of a mesh; `resolve` gives the files that it names. Warnings go to stderr.
pub fn import(path: &Path, text: &[u8], resolve: impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Source> {
    let progress = Progress::stage("reading", 0);
    let (model, parse_time) = stats::timed(|| obj::import(text, resolve));
    drop(progress);
    let model = model.map_err(|ImportError(note)| Error::new(Kind::BadInput, place(path, &note)))?;
    warn(path, &model.warnings);
    let bytes = bytes_of(&model);
    Ok(Source { path: path.to_path_buf(), model, files: Vec::new(), parse_time, bytes })
}

/// Reads the pictures that the materials of a mesh name. Warnings go to stderr.
fn load_textures(source: &mut Source, beside: &mut Companions<'_>) -> Result<()> {
    let progress = Progress::stage("textures", 0);
    let (known, limit) = (
        source.model.warnings.len(),
        beside.memory().left().map_or(u64::MAX, |left| left.saturating_sub(source.bytes)),
    );
    let (loaded, time) = stats::timed(|| {
        let picture = |name: &str, left| {
            let bytes = beside.content(name)?.map_err(|cause| DecodeError::Picture(cause.to_string()));
            Some(bytes.and_then(|bytes| decode(name, &bytes, left)))
        };
        source.model.load_textures(picture, limit)
    });
    drop(progress);
    if let Err(needed) = loaded {
        let needed = needed.saturating_add(source.bytes);
        let memory = beside.memory();
        let hint =
            format!("set --memory-limit to at least {}, or try --textures none", round_up(memory.held() + needed));
        memory.afford(needed, &format!("reading the textures of {}", source.path.display()), &hint)?;
    }
    warn(&source.path, &source.model.warnings[known..]);
    source.parse_time += time;
    source.bytes = bytes_of(&source.model);
    Ok(())
}

/// Prints the first warnings about the mesh at `path`, and how many there are more.
fn warn(path: &Path, warnings: &[Warning]) {
    for note in warnings.iter().take(MAX_WARNINGS) {
        report::warning(place(path, note));
    }
    if warnings.len() > MAX_WARNINGS {
        report::warning(format_args!("{}: and {} more", path.display(), warnings.len() - MAX_WARNINGS));
    }
}

/// Lays the grid out as the flags say.
fn grid(bounds: &Bounds, args: &BuildArgs) -> std::result::Result<Grid, GridError> {
    // A given origin stands for the box's minimum: the grid reaches from there to the mesh's far side.
    let reach =
        args.origin.map_or(*bounds, |min| Bounds { min, max: std::array::from_fn(|i| bounds.max[i].max(min[i])) });
    match (args.voxel_size, args.resolution) {
        (Some(voxel_size), Some(resolution)) => Grid { origin: reach.min, voxel_size, resolution }.checked(),
        (Some(voxel_size), None) => Grid::with_voxel_size(&reach, voxel_size),
        (None, resolution) => Grid::fit(&reach, resolution.unwrap_or(DEFAULT_RESOLUTION)),
    }
}

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

/// How to build, as the flags say but for the materials; at most `memory_limit` bytes at one time.
pub fn options(args: &BuildArgs, materials: MaterialMode, memory_limit: Option<u64>) -> Options {
    let cover = match args.cover.unwrap_or_default() {
        CoverArg::Exact => Cover::Exact,
        CoverArg::Thin => Cover::Thin,
        CoverArg::Inflated => Cover::Inflated,
    };
    Options { cover, materials, memory_limit, parts_at_once: rayon::current_num_threads() }
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

/// Voxels of a mesh before anything keeps their materials.
pub struct Voxels<'b, 'm> {
    pub grid: Grid,
    pub bounds: Bounds,
    pub dag: DagBuf,
    /// What material maps are made from.
    pub pending: PendingMaterials<'b, 'm>,
    /// Triangles to bricks, and bricks to subtrees.
    pub voxelize: Duration,
    /// Joining the subtrees.
    pub reduce: Duration,
}

/// Voxelises the mesh on the threads of the current pool, as the flags say but for the materials, and lets `keep` make of
/// the voxels what is to be kept.
pub fn voxelize<T>(
    source: &Source,
    args: &BuildArgs,
    materials: MaterialMode,
    memory: &Memory,
    keep: impl FnOnce(Voxels<'_, '_>) -> std::result::Result<T, SceneError>,
) -> Result<T> {
    let mesh = source.model.mesh();
    let bounds = mesh.validate().map_err(|error| refused(source, SceneError::Voxelize(VoxelizeError::Mesh(error))))?;
    let grid = grid(&bounds, args).map_err(|error| grid_error(source, error))?;
    contains(source, &grid, &bounds)?;
    let refused = |error| match error {
        SceneError::Limit { needed, enough, coarser, .. } => {
            over_limit(source, memory, needed, enough, coarser.then_some(&grid))
        }
        SceneError::Reduce(BuildError::Words { .. }) => {
            let what = format!("{} at resolution {}", source.path.display(), grid.resolution);
            Error::new(Kind::Limit, format_args!("{what} has more nodes than a file can number")).hint(advice(
                source,
                &grid,
                "make the mesh smaller",
            ))
        }
        error => refused(source, error),
    };

    // Sort the triangles into parts, build the parts on all threads and join them as they come.
    let options = options(args, materials, memory.left());
    let start = Instant::now();
    let build = Build::new(&mesh, &grid, &options).map_err(refused)?.with_textures(&source.model.textures);
    let mut join = build.join().map_err(refused)?;
    let mut reduce = Duration::ZERO;
    let progress = Progress::stage("voxelizing", build.parts() as u64);
    let joined = in_order(
        build.parts(),
        |part| build.part(part),
        |parts| {
            for part in parts {
                let part = part?;
                let (added, time) = stats::timed(|| join.add(part));
                added?;
                reduce += time;
                progress.step();
            }
            Ok(())
        },
    );
    drop(progress);
    joined.map_err(refused)?;
    let (finished, time) = stats::timed(|| join.finish());
    let (dag, pending) = finished.map_err(refused)?;
    reduce += time;
    let voxelize = start.elapsed().saturating_sub(reduce);
    keep(Voxels { grid, bounds, dag, pending, voxelize, reduce }).map_err(refused)
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

/// What a model takes in memory.
fn bytes_of(model: &Model) -> u64 {
    let Mesh { positions, triangles, materials, name_order, uvs, normals } = model.mesh();
    let sizes = [size_of_val(positions), size_of_val(triangles), size_of_val(materials), size_of_val(name_order)];
    let mesh: u64 = sizes.into_iter().chain([size_of_val(uvs), size_of_val(normals)]).map(|bytes| bytes as u64).sum();
    let textures = model.textures.iter().flat_map(|maps| [&maps.diffuse, &maps.dissolve]).flatten();
    // Each picture once, however many materials show it.
    let mut known = HashSet::new();
    let pictures = textures.map(Texture::image).filter(|image| known.insert(Arc::as_ptr(image)));
    mesh + pictures.map(|image| image.bytes()).sum::<u64>()
}

/// Refuses a mesh that reaches out of a grid that was chosen by hand.
fn contains(source: &Source, grid: &Grid, bounds: &Bounds) -> Result<()> {
    if grid.snap(bounds.min).is_some() && grid.snap(bounds.max).is_some() {
        return Ok(());
    }
    let end = grid.to_world([f64::from(grid.resolution); 3]);
    Err(Error::usage(format_args!(
        "{}: the mesh spans {} to {}, the grid only {} to {}",
        source.path.display(),
        triple(bounds.min),
        triple(bounds.max),
        triple(grid.origin),
        triple(end)
    ))
    .hint("move --origin, or raise --resolution or --voxel-size"))
}

fn grid_error(source: &Source, error: GridError) -> Error {
    match error {
        GridError::Resolution { .. } => {
            Error::new(Kind::Limit, format_args!("{}: {error}", source.path.display())).hint("make --voxel-size larger")
        }
        _ => Error::input(&source.path, error),
    }
}

/// The memory limit is passed; `grid` where a coarser one needs less.
fn over_limit(source: &Source, memory: &Memory, needed: u64, enough: u64, grid: Option<&Grid>) -> Error {
    let limit = format!("--memory-limit {}", round_up(memory.held().saturating_add(enough)));
    let (what, hint) = match grid {
        Some(grid) => {
            (format!("{} at resolution {}", source.path.display(), grid.resolution), advice(source, grid, &limit))
        }
        None => (format!("the mesh {}", source.path.display()), format!("try {limit}")),
    };
    memory.afford(needed, &what, &hint).err().unwrap_or_else(|| Error::new(Kind::Limit, what).hint(hint))
}

/// What to try: a coarser grid where the user can choose it, or what else there is.
fn advice(source: &Source, grid: &Grid, otherwise: &str) -> String {
    if source.files.is_empty() {
        return format!("try {otherwise}");
    }
    format!("try -r {}, or {otherwise}", (grid.resolution / 2).max(1))
}

/// Why the core builds nothing, in this program's words.
fn refused(source: &Source, error: SceneError) -> Error {
    let path = &source.path;
    match error {
        SceneError::Voxelize(VoxelizeError::Grid(error)) => grid_error(source, error),
        SceneError::Voxelize(VoxelizeError::Mesh(MeshError::Empty)) => Error::input(path, "there are no faces in it")
            .hint("expected lines such as `f 1 2 3`; points and lines are not made into voxels"),
        SceneError::Voxelize(VoxelizeError::Mesh(error)) => Error::input(path, error),
        error => Error::new(Kind::Failure, format_args!("{}: {error}", path.display())).hint("try a smaller -r"),
    }
}

/// Where a message of the importer belongs: into the mesh or into a library beside it.
fn place(path: &Path, note: &Warning) -> String {
    let file = if note.file.is_empty() { path.to_path_buf() } else { path.with_file_name(&note.file) };
    format!("{}:{}: {}", file.display(), note.line, note.message)
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
