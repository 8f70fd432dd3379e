//! What went wrong, for C: a status to branch on, and a text with places and numbers, so that nothing of what the core says
//! is lost.

use core::ffi::{CStr, c_char};
use core::fmt::{self, Write};

use voxdag::camera::CameraError;
use voxdag::dag::DagError;
use voxdag::file::{LoadError, WriteError};
use voxdag::grid::GridError;
use voxdag::material::MaterialError;
use voxdag::mesh::MeshError;
use voxdag::rank::RankError;
use voxdag::ranked::RankedError;
use voxdag::render::RenderError;
use voxdag::scene::SceneError;
use voxdag::ssvdag::SsvdagError;
use voxdag::table::TableError;
use voxdag::tree::TreeError;
use voxdag::voxelize::VoxelizeError;

/// What became of a call. Later versions may add values: treat unknown ones as errors.
#[repr(i32)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum VoxdagStatus {
    /// It did what it is for.
    Ok = 0,
    /// A pointer is null that must not be.
    Null = 1,
    /// A pointer is not aligned as its type asks.
    Misaligned = 2,
    /// So many items that no memory holds them.
    Count = 3,
    /// A number that means nothing there: of a choice, a flag, not finite, or out of range.
    Argument = 4,
    /// The memory lent is too small; the error says how much is enough.
    TooSmall = 5,
    /// The heap refused, or the memory limit did.
    Memory = 6,
    /// A defect of this library: the call ended half way, its output is undefined, the scene can still be used.
    Panic = 7,

    /// Not a .vxd file.
    FileMagic = 16,
    /// The words of the file are in the other byte order.
    FileEndianness = 17,
    /// A version of the file that this library does not know.
    FileVersion = 18,
    /// The file is shorter or longer than it says.
    FileLength = 19,
    /// A checksum of the file is wrong.
    FileChecksum = 20,
    /// Sections of the file are missing, double, or out of place.
    FileSection = 21,
    /// The file's header is malformed.
    FileHeader = 22,
    /// The file's voxels are malformed.
    FileGeometry = 23,
    /// The file's materials, names or colours are malformed.
    FileMaterials = 24,

    /// A mesh without triangles, or with too many.
    MeshSize = 32,
    /// A coordinate that is not finite; `position` is the vertex.
    MeshNotFinite = 33,
    /// A triangle names a vertex that does not exist; `position` is the triangle.
    MeshIndex = 34,
    /// A triangle names a material that does not exist; `position` is the triangle.
    MeshMaterial = 35,
    /// A vertex outside the grid; `position` is the vertex.
    MeshOutside = 36,
    /// A grid whose resolution, voxel size or origin is out of range.
    Grid = 37,
    /// A material with a number that is not finite or below 0, or with a texture that has no pixels; `position` is the
    /// material.
    Material = 38,
    /// A name that is not UTF-8; `position` is the material.
    Name = 39,

    /// Width or height is out of range.
    PictureSize = 48,
    /// Rows that are not in the picture.
    PictureRows = 49,
    /// A camera that sees nothing.
    Camera = 50,
    /// A light of no kind, nowhere, or with a number that is not finite or out of range; `position` is the light.
    Light = 51,
}

/// More about an error, in memory that the caller lends: written where a function does not return `VOXDAG_STATUS_OK`, left
/// as it is otherwise.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct VoxdagError {
    /// What the function returned.
    pub status: VoxdagStatus,
    /// Bytes of `message` before its zero byte.
    pub length: u32,
    /// Which item is wrong, counted from 0: a vertex, triangle, material, light, hit, or word of the file or of its section;
    /// the message says which. `VOXDAG_NONE` if it is no single one.
    pub position: u64,
    /// What would be enough: words, pixels or bytes where the lent memory is too small, bytes where memory could not be
    /// had; otherwise 0.
    pub needed: u64,
    /// One sentence in English for people: UTF-8, ends with a zero byte.
    pub message: [c_char; 256],
}

/// Everything that a function can fail with.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failure {
    Null { name: &'static str },
    Misaligned { name: &'static str, expected: usize },
    Count { name: &'static str, found: u64 },
    Choice { name: &'static str, found: u32 },
    NotFinite { name: &'static str },
    Item { name: &'static str, position: u64, found: u64 },
    TooSmall { needed: u64, unit: &'static str },
    Memory { needed: u64 },
    Panic,
    Load(LoadError),
    Build(SceneError),
    Write(WriteError),
    Render(RenderError),
    TriangleMaterial { triangle: u64, material: u16, count: u64 },
    Material { index: u64, error: MaterialError },
    Illum { index: u64, found: u32 },
    Texture { index: u64 },
    Name { index: u64 },
    Light { index: u64 },
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Failure {
        Failure::Load(error)
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Failure {
        Failure::Build(error)
    }
}

impl From<MeshError> for Failure {
    fn from(error: MeshError) -> Failure {
        Failure::Build(SceneError::Voxelize(VoxelizeError::Mesh(error)))
    }
}

impl From<GridError> for Failure {
    fn from(error: GridError) -> Failure {
        Failure::Build(SceneError::Voxelize(VoxelizeError::Grid(error)))
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Failure {
        Failure::Write(error)
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Failure {
        Failure::Render(error)
    }
}

impl From<CameraError> for Failure {
    fn from(error: CameraError) -> Failure {
        Failure::Render(RenderError::Camera(error))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Null { name } => write!(f, "`{name}` is a null pointer"),
            Failure::Misaligned { name, expected } => {
                write!(f, "`{name}` is not aligned: expected a multiple of {expected} bytes")
            }
            Failure::Count { name, found } => write!(f, "`{name}` cannot have {found} items: no memory is that large"),
            Failure::Choice { name, found } => write!(f, "{found} is no {name}"),
            Failure::NotFinite { name } => write!(f, "`{name}` has a number that is not finite, or out of range"),
            Failure::Item { name, position, found } => write!(f, "{found} is no {name} (number {position}, from 0)"),
            Failure::TooSmall { needed, unit } => {
                write!(f, "the lent memory is too small: expected room for {needed} {unit}")
            }
            Failure::Memory { needed } => write!(f, "out of memory: {needed} bytes could not be had"),
            Failure::Panic => f.write_str("a defect of this library: the call ended half way"),
            Failure::Load(error) => error.fmt(f),
            Failure::Build(error) => error.fmt(f),
            Failure::Write(error) => error.fmt(f),
            Failure::Render(error) => error.fmt(f),
            Failure::TriangleMaterial { triangle, material, count } => {
                write!(f, "triangle {triangle} (counted from 0) has material {material}, but there are only {count}")
            }
            Failure::Material { index, error } => write!(f, "material {index} (counted from 0): {error}"),
            Failure::Illum { index, found } => {
                write!(f, "material {index} (counted from 0) has illum {found}: expected 0 to 10")
            }
            Failure::Texture { index } => {
                write!(
                    f,
                    "a texture of material {index} (counted from 0) has no pixels, or a number that is not finite"
                )
            }
            Failure::Name { index } => write!(f, "the name of material {index} (counted from 0) is not UTF-8"),
            Failure::Light { index } => {
                write!(
                    f,
                    "light {index} (counted from 0) is of no kind or nowhere, or has a number that is out of range"
                )
            }
        }
    }
}

/// No position.
const NONE: u64 = u64::MAX;

impl Failure {
    pub fn status(&self) -> VoxdagStatus {
        self.facts().0
    }

    pub fn report(&self) -> VoxdagError {
        let (status, position, needed) = self.facts();
        let mut text = Text { bytes: [0; 256], length: 0 };
        // Too long a text is cut off, which is no error.
        let _ = write!(text, "{self}");
        VoxdagError {
            status,
            length: text.length as u32,
            position,
            needed,
            message: text.bytes.map(|byte| byte as c_char),
        }
    }

    /// Status, position, what is needed.
    fn facts(&self) -> (VoxdagStatus, u64, u64) {
        use VoxdagStatus as S;
        match *self {
            Failure::Null { .. } => (S::Null, NONE, 0),
            Failure::Misaligned { .. } => (S::Misaligned, NONE, 0),
            Failure::Count { .. } => (S::Count, NONE, 0),
            Failure::Choice { .. } | Failure::NotFinite { .. } => (S::Argument, NONE, 0),
            Failure::Item { position, .. } => (S::Argument, position, 0),
            Failure::TooSmall { needed, .. } => (S::TooSmall, NONE, needed),
            Failure::Memory { needed } => (S::Memory, NONE, needed),
            Failure::Panic => (S::Panic, NONE, 0),
            Failure::Load(error) => load(error),
            Failure::Build(SceneError::Voxelize(VoxelizeError::Mesh(error))) => match error {
                MeshError::Empty | MeshError::TooLarge => (S::MeshSize, NONE, 0),
                MeshError::NonFinite { vertex } => (S::MeshNotFinite, vertex.into(), 0),
                MeshError::VertexIndex { triangle, .. } => (S::MeshIndex, triangle.into(), 0),
                MeshError::MaterialIndex { triangle } => (S::MeshMaterial, triangle.into(), 0),
                MeshError::Length { .. } => (S::Count, NONE, 0),
            },
            Failure::Build(SceneError::Voxelize(VoxelizeError::Grid(error))) => match error {
                GridError::Outside { vertex } => (S::MeshOutside, vertex.into(), 0),
                _ => (S::Grid, NONE, 0),
            },
            Failure::Build(SceneError::Limit { needed, enough, .. }) => (S::Memory, NONE, enough.max(needed)),
            Failure::Build(SceneError::Voxelize(VoxelizeError::Memory { bytes })) => (S::Memory, NONE, bytes),
            Failure::Build(SceneError::Reduce(_) | SceneError::Table(_)) => (S::Memory, NONE, 0),
            Failure::Write(WriteError::Invalid(error)) => load(error),
            Failure::Write(WriteError::Memory { bytes }) => (S::Memory, NONE, bytes),
            Failure::Write(WriteError::Full { .. } | WriteError::Names { .. } | WriteError::Representation) => {
                (S::Argument, NONE, 0)
            }
            Failure::Render(RenderError::Size { .. }) => (S::PictureSize, NONE, 0),
            Failure::Render(RenderError::Rows { .. }) => (S::PictureRows, NONE, 0),
            Failure::Render(RenderError::Output { expected, .. }) => (S::TooSmall, NONE, expected),
            Failure::Render(RenderError::Camera(_)) => (S::Camera, NONE, 0),
            Failure::TriangleMaterial { triangle, .. } => (S::MeshMaterial, triangle, 0),
            Failure::Material { index, .. } | Failure::Illum { index, .. } | Failure::Texture { index } => {
                (S::Material, index, 0)
            }
            Failure::Name { index } => (S::Name, index, 0),
            Failure::Light { index } => (S::Light, index, 0),
        }
    }
}

/// The facts of a file that cannot be read.
fn load(error: LoadError) -> (VoxdagStatus, u64, u64) {
    use VoxdagStatus as S;
    match error {
        LoadError::Magic { .. } | LoadError::Text => (S::FileMagic, 0, 0),
        LoadError::Endianness => (S::FileEndianness, 0, 0),
        LoadError::Version { .. } => (S::FileVersion, 1, 0),
        LoadError::Truncated { .. } | LoadError::Trailing { .. } | LoadError::NotWords { .. } => {
            (S::FileLength, NONE, 0)
        }
        LoadError::Memory { bytes } => (S::Memory, NONE, bytes),
        LoadError::HeaderCrc { .. } => (S::FileChecksum, 0, 0),
        LoadError::Crc { word, .. } | LoadError::UnknownCrc { word, .. } => (S::FileChecksum, word, 0),
        LoadError::SectionBounds { word, .. } => (S::FileSection, word, 0),
        LoadError::Duplicate { .. } | LoadError::Missing { .. } | LoadError::Conflict { .. } => {
            (S::FileSection, NONE, 0)
        }
        LoadError::Reserved { word } => (S::FileHeader, word, 0),
        LoadError::UpAxis { .. } => (S::FileHeader, 5, 0),
        LoadError::Grid(_) | LoadError::Bounds | LoadError::Unit => (S::FileHeader, NONE, 0),
        LoadError::Dag(error) => (S::FileGeometry, dag(error), 0),
        LoadError::Ssvdag(error) => (S::FileGeometry, ssvdag(error), 0),
        LoadError::Depth { .. } => (S::FileGeometry, NONE, 0),
        LoadError::Table(TableError::Header { word } | TableError::Slot { word } | TableError::Order { word }) => {
            (S::FileMaterials, word, 0)
        }
        LoadError::Tree(TreeError::Header { word } | TreeError::Entry { word }) => (S::FileMaterials, word.into(), 0),
        LoadError::Ranks(RankError::Count { word }) => (S::FileMaterials, word.into(), 0),
        LoadError::Ids(error) | LoadError::Colors(error) => (S::FileMaterials, ranked(error), 0),
        LoadError::Material { index, .. } | LoadError::Name { index } => (S::FileMaterials, index.into(), 0),
        LoadError::Table(_)
        | LoadError::Tree(_)
        | LoadError::TreeDepth { .. }
        | LoadError::Ranks(_)
        | LoadError::MaterialCount { .. }
        | LoadError::MaterialId { .. }
        | LoadError::Names { .. } => (S::FileMaterials, NONE, 0),
    }
}

fn dag(error: DagError) -> u64 {
    match error {
        DagError::Header { word }
        | DagError::Brick { word }
        | DagError::Node { word }
        | DagError::Child { word, .. } => word.into(),
        DagError::Truncated { .. } | DagError::Trailing { .. } | DagError::Depth { .. } | DagError::Root => NONE,
    }
}

fn ssvdag(error: SsvdagError) -> u64 {
    match error {
        SsvdagError::Header { word }
        | SsvdagError::Block { word }
        | SsvdagError::Pointer { word }
        | SsvdagError::Brick { word } => word.into(),
        SsvdagError::Length { .. } => NONE,
    }
}

fn ranked(error: RankedError) -> u64 {
    match error {
        RankedError::Header { word } => word.into(),
        RankedError::Value { word } => word,
        RankedError::Length { .. } | RankedError::Voxels { .. } => NONE,
    }
}

/// A text of so many bytes at most, the last of them 0.
struct Text {
    bytes: [u8; 256],
    length: usize,
}

impl Write for Text {
    fn write_str(&mut self, more: &str) -> fmt::Result {
        let room = self.bytes.len() - 1 - self.length;
        let whole = (0..=room.min(more.len())).rev().find(|&end| more.is_char_boundary(end)).unwrap_or(0);
        self.bytes[self.length..self.length + whole].copy_from_slice(&more.as_bytes()[..whole]);
        self.length += whole;
        if whole < more.len() { Err(fmt::Error) } else { Ok(()) }
    }
}

impl VoxdagStatus {
    /// All of them, in the order of their numbers.
    pub(crate) const TEXTS: [(VoxdagStatus, &CStr); 29] = [
        (VoxdagStatus::Ok, c"ok"),
        (VoxdagStatus::Null, c"a pointer is null that must not be"),
        (VoxdagStatus::Misaligned, c"a pointer is not aligned as its type asks"),
        (VoxdagStatus::Count, c"so many items that no memory holds them"),
        (VoxdagStatus::Argument, c"a number that means nothing where it stands"),
        (VoxdagStatus::TooSmall, c"the lent memory is too small"),
        (VoxdagStatus::Memory, c"out of memory, or over the memory limit"),
        (VoxdagStatus::Panic, c"a defect of this library: the call ended half way"),
        (VoxdagStatus::FileMagic, c"not a .vxd file"),
        (VoxdagStatus::FileEndianness, c"the words of the file are in the other byte order"),
        (VoxdagStatus::FileVersion, c"a version of the file that this library does not know"),
        (VoxdagStatus::FileLength, c"the file is shorter or longer than it says"),
        (VoxdagStatus::FileChecksum, c"a checksum of the file is wrong"),
        (VoxdagStatus::FileSection, c"sections of the file are missing, double, or out of place"),
        (VoxdagStatus::FileHeader, c"the file's header is malformed"),
        (VoxdagStatus::FileGeometry, c"the file's voxels are malformed"),
        (VoxdagStatus::FileMaterials, c"the file's materials, names or colours are malformed"),
        (VoxdagStatus::MeshSize, c"a mesh without triangles, or with too many"),
        (VoxdagStatus::MeshNotFinite, c"a vertex with a coordinate that is not finite"),
        (VoxdagStatus::MeshIndex, c"a triangle names a vertex that does not exist"),
        (VoxdagStatus::MeshMaterial, c"a triangle names a material that does not exist"),
        (VoxdagStatus::MeshOutside, c"a vertex lies outside the grid"),
        (VoxdagStatus::Grid, c"the grid's resolution, voxel size or origin is out of range"),
        (VoxdagStatus::Material, c"a material with a number that is out of range"),
        (VoxdagStatus::Name, c"a material's name is not UTF-8"),
        (VoxdagStatus::PictureSize, c"the picture's width or height is out of range"),
        (VoxdagStatus::PictureRows, c"the rows are not in the picture"),
        (VoxdagStatus::Camera, c"the camera sees nothing"),
        (VoxdagStatus::Light, c"a light is of no kind or nowhere, or has a number that is out of range"),
    ];
}
