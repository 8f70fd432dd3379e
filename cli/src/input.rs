//! Reading inputs: a mesh with the files it names, or a scene that was built before. Which of the two a file is decides
//! its content, not its name.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::error::{Error, Kind, Result};
use crate::memory::Memory;
use crate::report::{self, shell_word};

/// A file's content.
pub enum Content {
    /// The words of a `.vxd` file, not yet checked.
    Scene(Vec<u32>),
    /// Any other bytes: the text of a mesh.
    Mesh(Vec<u8>),
}

/// Reads a file that may be a mesh or a scene, and holds its bytes.
pub fn read(path: &Path, memory: &mut Memory) -> Result<Content> {
    let (file, length) = open(path)?;
    // A device or a pipe has no length beforehand, and a file may grow: no more is read than may be held.
    let most = memory.left().unwrap_or(u64::MAX - 1);
    over(path, length, memory)?;
    let mut file = file.take(most + 1);
    let mut head = [0; 4];
    let read = read_up_to(&mut file, &mut head).map_err(|e| unreadable(path, &e))?;
    let magic = u32::from_le_bytes(head);
    if read == 4 && (magic == voxdag::file::MAGIC || magic.swap_bytes() == voxdag::file::MAGIC) {
        let words = words(path, file, length, magic)?;
        over(path, 4 * words.len() as u64, memory)?;
        memory.hold(4 * words.len() as u64);
        return Ok(Content::Scene(words));
    }
    if has_extension(path, "vxd") {
        return Err(Error::input(path, "is not a voxdag scene: it does not start with the mark of one")
            .hint("build it from its mesh with `voxdag build`"));
    }
    if let Some(known) =
        ["ply", "stl", "gltf", "glb", "fbx", "dae", "vox", "png"].iter().find(|e| has_extension(path, e))
    {
        return Err(Error::input(path, format_args!(".{known} files cannot be read"))
            .hint("expected a Wavefront OBJ (.obj) or a voxdag scene (.vxd)"));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|_| too_large(path, length))?;
    bytes.extend_from_slice(&head[..read]);
    file.read_to_end(&mut bytes).map_err(|e| unreadable(path, &e))?;
    over(path, bytes.len() as u64, memory)?;
    memory.hold(bytes.len() as u64);
    Ok(Content::Mesh(bytes))
}

/// Refuses a file of so many bytes if it is over the limit.
fn over(path: &Path, bytes: u64, memory: &Memory) -> Result<()> {
    memory.afford(bytes, &path.display().to_string(), "raise --memory-limit")
}

/// Reads a file that must be a scene.
pub fn read_scene(path: &Path) -> Result<Vec<u32>> {
    read_scene_within(path, &mut Memory::new(None))
}

/// The same within a limit of memory.
pub fn read_scene_within(path: &Path, memory: &mut Memory) -> Result<Vec<u32>> {
    match read(path, memory)? {
        Content::Scene(words) => Ok(words),
        Content::Mesh(_) => Err(Error::input(path, "is not a voxdag scene").hint(format_args!(
            "make one of a mesh with `voxdag build {} -o {}`",
            shell_word(path),
            shell_word(&path.with_extension("vxd"))
        ))),
    }
}

/// Reads a file that must be a mesh.
pub fn read_mesh(path: &Path, memory: &mut Memory) -> Result<Vec<u8>> {
    match read(path, memory)? {
        Content::Mesh(bytes) => Ok(bytes),
        Content::Scene(_) => Err(Error::input(path, "is built already")
            .hint(format_args!("look at it with `voxdag info {}`", shell_word(path)))),
    }
}

/// Finds the files that a mesh names, relative to the mesh's own folder, and remembers which are there.
pub struct Companions<'a> {
    folder: PathBuf,
    memory: &'a mut Memory,
    /// Every file that is there, read or not.
    there: Vec<PathBuf>,
    /// Why the run cannot go on.
    failure: Option<Error>,
}

/// Why a file that is there has no content.
pub enum Unread {
    /// It is larger than so many bytes, which memory is left for; the run cannot go on.
    Limit(u64),
    /// What the system says.
    Cause(std::io::Error),
}

impl Companions<'_> {
    /// Of the mesh at `path`.
    pub fn of<'a>(path: &Path, memory: &'a mut Memory) -> Companions<'a> {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Companions { folder, memory, there: vec![path.to_path_buf()], failure: None }
    }

    /// The content of `name`; a file that is there and cannot be read counts as empty, with a warning.
    pub fn resolve(&mut self, name: &str) -> Option<Vec<u8>> {
        let content = self.content(name)?;
        Some(content.unwrap_or_else(|why| {
            if let Unread::Cause(cause) = why {
                let (path, what) = (self.folder.join(name), "what it would define is drawn grey");
                report::warning(format_args!("{}: cannot be read: {cause}; {what}", path.display()));
            }
            Vec::new()
        }))
    }

    /// The content of `name`, its folders apart by `/`; `None` if there is no such file.
    pub fn content(&mut self, name: &str) -> Option<std::result::Result<Vec<u8>, Unread>> {
        let path = self.folder.join(name);
        let most = self.memory.left().unwrap_or(u64::MAX - 1);
        let mut length = 0;
        // Asked before it is opened: opening a pipe would wait for its other end.
        let content = std::fs::metadata(&path).and_then(|found| {
            if !found.is_file() {
                return Err(std::io::Error::other("it is not a regular file"));
            }
            length = found.len();
            let mut bytes = Vec::new();
            if length <= most {
                // It may grow meanwhile.
                File::open(&path)?.take(most + 1).read_to_end(&mut bytes)?;
                length = length.max(bytes.len() as u64);
            }
            Ok(bytes)
        });
        match content {
            Ok(bytes) => {
                self.there.push(path.clone());
                if let Err(error) = over(&path, length, self.memory) {
                    self.failure.get_or_insert(error);
                    return Some(Err(Unread::Limit(length)));
                }
                self.memory.hold(length);
                Some(Ok(bytes))
            }
            // `NotADirectory`: a part of the path is a file.
            Err(cause) if matches!(cause.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => None,
            Err(cause) => Some(Err(Unread::Cause(cause))),
        }
    }

    /// Remembers a file that the mesh names and that need not be read, if it is there.
    pub fn note(&mut self, name: &str) {
        let path = self.folder.join(name);
        if std::fs::metadata(&path).is_ok_and(|found| found.is_file()) {
            self.there.push(path);
        }
    }

    /// The account that files are held in.
    pub fn memory(&self) -> &Memory {
        self.memory
    }

    /// The files that are there, or why the run cannot go on.
    pub fn finish(self) -> Result<Vec<PathBuf>> {
        self.failure.map_or(Ok(self.there), Err)
    }
}

/// Opens a file, and says how long it is; a device or a pipe has no length beforehand.
pub fn open(path: &Path) -> Result<(File, u64)> {
    let file = File::open(path).map_err(|e| unreadable(path, &e))?;
    let found = file.metadata().map_err(|e| unreadable(path, &e))?;
    if found.is_dir() {
        return Err(Error::input(path, "is a folder").hint("name a file in it"));
    }
    Ok((file, found.len()))
}

/// A file that the system would not let us read.
pub fn unreadable(path: &Path, cause: &std::io::Error) -> Error {
    match cause.kind() {
        ErrorKind::NotFound => Error::input(path, "there is no such file"),
        _ => Error::input(path, format_args!("cannot read: {cause}")),
    }
}

fn too_large(path: &Path, length: u64) -> Error {
    Error::new(Kind::Failure, format_args!("{}: no memory for its {length} bytes", path.display()))
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Fills the buffer as far as the file reaches.
fn read_up_to(file: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match file.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}

/// The rest of a scene's words, piece by piece, so that its bytes are never all there beside them.
fn words(path: &Path, mut file: impl Read, length: u64, first: u32) -> Result<Vec<u32>> {
    let mut words = Vec::new();
    words.try_reserve_exact((length / 4) as usize).map_err(|_| too_large(path, length))?;
    words.push(first);
    let mut piece = vec![0; 1 << 16];
    loop {
        let read = read_up_to(&mut file, &mut piece).map_err(|e| unreadable(path, &e))?;
        words.extend(piece[..read].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])));
        if read % 4 != 0 {
            return Err(Error::input(path, "is cut short: its length in bytes is no multiple of 4")
                .hint("copy or build it again"));
        }
        if read < piece.len() {
            return Ok(words);
        }
    }
}
