//! From a mesh file to the words of a `.vxd`, subtrees on all cores.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use voxdag::dag::Stats;
use voxdag::file::{self, Scene};
use voxdag::grid::{Bounds, Grid, GridError};
use voxdag::obj::{self, Model};
use voxdag::scene::{Build, BuildOptions, MaterialMode};
use voxdag::voxelize::Cover;

use crate::error::{Error, Kind, Result};
use crate::input::Companions;
use crate::options::{BuildArgs, CoverArg, MachineArgs, MaterialsArg, UpAxisArg};
use crate::ordered::in_order;
use crate::progress::Progress;
use crate::{report, stats};

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
    parse_ms: f64,
}

/// Parses the text of the mesh at `path`, with the files beside it.
pub fn import_file(path: &Path, text: Vec<u8>) -> Result<Source> {
    let mut beside = Companions::of(path);
    let mut source = import(path, &text, |name| beside.resolve(name))?;
    source.files = beside.read;
    Ok(source)
}

/// Parses the text of a mesh; `resolve` gives the files that it names. Warnings go to stderr.
pub fn import(path: &Path, text: &[u8], resolve: impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Source> {
    let progress = Progress::stage("reading", 0);
    let (model, parse_ms) = stats::timed(|| obj::import(text, resolve));
    drop(progress);
    let model = model.map_err(|error| malformed(path, error))?;
    for warning in model.warnings.iter().take(MAX_WARNINGS) {
        report::warning(warning);
    }
    if let Some(more) = model.warnings.len().checked_sub(MAX_WARNINGS).filter(|&more| more > 0) {
        report::warning(format_args!("{}: {more} more of this kind", path.display()));
    }
    Ok(Source { path: path.to_path_buf(), model, files: Vec::new(), parse_ms })
}

/// Lays the grid out as the flags say.
fn grid(bounds: &Bounds, args: &BuildArgs) -> Result<Grid, GridError> {
    // A given origin stands for the box's minimum: the grid reaches from there to the mesh's far side.
    let reach = args.origin.map_or(*bounds, |min| Bounds { min, max: std::array::from_fn(|i| bounds.max[i].max(min[i])) });
    match (args.voxel_size, args.resolution) {
        (Some(voxel_size), Some(resolution)) => Grid { origin: reach.min, voxel_size, resolution }.checked(),
        (Some(voxel_size), None) => Grid::with_voxel_size(&reach, voxel_size),
        (None, resolution) => Grid::fit(&reach, resolution.unwrap_or(DEFAULT_RESOLUTION)),
    }
}

/// Writes words as little-endian bytes.
pub fn write(words: &[u32], mut file: impl Write) -> std::io::Result<()> {
    let mut piece = Vec::with_capacity(1 << 16);
    for words in words.chunks(1 << 14) {
        piece.clear();
        piece.extend(words.iter().flat_map(|w| w.to_le_bytes()));
        file.write_all(&piece)?;
    }
    Ok(())
}
