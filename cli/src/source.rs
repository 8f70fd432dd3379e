//! Mesh files as they are read: the text of an OBJ, the libraries and pictures that it names, and what is to be said of them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use voxdag::Mesh;
use voxdag::obj::{self, ImportError, Model, Warning};
use voxdag::texture::{DecodeError, Texture, decode};

use crate::error::{Error, Kind, Result};
use crate::input::{Companions, Unread};
use crate::memory::{Memory, round_up};
use crate::progress::Progress;
use crate::report;
use crate::stats;

/// Warnings about a mesh that are printed one by one.
const MAX_WARNINGS: usize = 10;

/// A mesh that was read.
pub struct Source {
    /// The name that messages give it.
    pub path: PathBuf,
    pub model: Model,
    /// The mesh's file and those that it names and that are there, read or not.
    pub files: Vec<PathBuf>,
    /// Time to parse it.
    pub parse_time: Duration,
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
        for map in source.model.materials.iter().flat_map(|named| [&named.map_kd, &named.map_d]).flatten() {
            map.places().iter().for_each(|place| beside.note(place));
        }
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
            let bytes = beside.content(name)?.map_err(|why| match why {
                Unread::Limit(needed) => DecodeError::Limit { needed },
                Unread::Cause(cause) => DecodeError::Picture(cause.to_string()),
            });
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

/// What a model takes in memory.
fn bytes_of(model: &Model) -> u64 {
    let Mesh { positions, triangles, materials, name_order, uvs, normals } = model.mesh();
    let sizes = [size_of_val(positions), size_of_val(triangles), size_of_val(materials), size_of_val(name_order)];
    let mesh: u64 = sizes.into_iter().chain([size_of_val(uvs), size_of_val(normals)]).map(|bytes| bytes as u64).sum();
    let textures = model.textures.iter().flat_map(|maps| [maps.diffuse(), maps.dissolve()]).flatten();
    // Each picture once, however many materials show it.
    let mut known = HashSet::new();
    let pictures = textures.map(Texture::image).filter(|image| known.insert(Arc::as_ptr(image)));
    mesh + pictures.map(|image| image.bytes()).sum::<u64>()
}

/// Where a message of the importer belongs: into the mesh or into a library beside it.
fn place(path: &Path, note: &Warning) -> String {
    let file = if note.file.is_empty() { path.to_path_buf() } else { path.with_file_name(&note.file) };
    format!("{}:{}: {}", file.display(), note.line, note.message)
}
