//! Why words are no scene: every error says where, what was expected and what was found.

use super::VERSION;
use crate::dag::DagError;
use crate::grid::GridError;
use crate::rank::RankError;
use crate::ranked::RankedError;
use crate::ssvdag::SsvdagError;
use crate::table::TableError;
use crate::tree::TreeError;

/// The sections that this version knows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Section {
    /// The filled voxels.
    Dag,
    /// Material per voxel.
    Table,
    /// Parameters of the materials.
    Materials,
    /// Names of the materials.
    Names,
    /// Material per cube of space; from version 2.
    Tree,
    /// The filled voxels, nodes merged up to mirrors; from version 3.
    Ssvdag,
    /// Numbers of voxels, by which materials are found; from version 3.
    Ranks,
    /// Material ids in the order of the voxels; from version 3.
    Ids,
    /// Colours of textures in the order of the voxels; from version 4.
    Colors,
}

impl Section {
    pub(super) const COUNT: usize = 9;

    /// The section of a kind, as a file of a version counts them.
    pub(super) fn of(kind: u32, version: u32) -> Option<Section> {
        let all = [
            Section::Dag,
            Section::Table,
            Section::Materials,
            Section::Names,
            Section::Tree,
            Section::Ssvdag,
            Section::Ranks,
            Section::Ids,
            Section::Colors,
        ];
        all.into_iter().find(|section| section.kind() == kind && version >= section.version())
    }

    /// The first version that knows it.
    pub(super) fn version(self) -> u32 {
        match self {
            Section::Dag | Section::Table | Section::Materials | Section::Names => 1,
            Section::Tree => 2,
            Section::Ssvdag | Section::Ranks | Section::Ids => 3,
            Section::Colors => 4,
        }
    }

    /// The number that stands for it in a file.
    pub(super) fn kind(self) -> u32 {
        self as u32 + 1
    }
}

impl core::fmt::Display for Section {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Section::Dag => "DAG",
            Section::Table => "material table",
            Section::Materials => "materials",
            Section::Names => "names",
            Section::Tree => "material tree",
            Section::Ssvdag => "SSVDAG",
            Section::Ranks => "rank counts",
            Section::Ids => "ranked materials",
            Section::Colors => "colours",
        })
    }
}

/// Why words are no scene. Offsets and sizes count words unless they say bytes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum LoadError {
    /// The first word is not the magic.
    Magic {
        /// The first word.
        found: u32,
    },
    /// The magic is byte-swapped: the words are big-endian.
    Endianness,
    /// The file begins like a text, an OBJ file maybe.
    Text,
    /// A version that this reader does not know.
    Version {
        /// The version.
        found: u32,
    },
    /// Fewer words than the header and the sections need.
    Truncated {
        /// Words needed.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// More words than the header or the sections account for.
    Trailing {
        /// Words accounted for.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// The length in bytes is no multiple of 4.
    NotWords {
        /// The length in bytes.
        bytes: u64,
    },
    /// There is no memory for the file's words.
    Memory {
        /// Bytes asked for.
        bytes: u64,
    },
    /// The checksum of the header and the section table is wrong.
    HeaderCrc {
        /// The one stored.
        expected: u32,
        /// The one of the words.
        found: u32,
    },
    /// The checksum of a section is wrong.
    Crc {
        /// Which section.
        section: Section,
        /// Where it starts.
        word: u64,
        /// The checksum stored.
        expected: u32,
        /// The one of the words.
        found: u32,
    },
    /// The checksum of a section of unknown kind is wrong.
    UnknownCrc {
        /// The kind.
        kind: u32,
        /// Where it starts.
        word: u64,
        /// The checksum stored.
        expected: u32,
        /// The one of the words.
        found: u32,
    },
    /// A section does not start where the one before ends, or runs past the end of the file.
    SectionBounds {
        /// Offset of its row in the section table.
        word: u64,
        /// Where it is said to start.
        offset: u64,
        /// How long it is said to be.
        length: u64,
    },
    /// Two sections of one kind.
    Duplicate {
        /// Which.
        section: Section,
    },
    /// A section that must be there is not.
    Missing {
        /// Which.
        section: Section,
    },
    /// A word that must be 0 is not.
    Reserved {
        /// Offset of the word.
        word: u64,
    },
    /// The grid is none.
    Grid(GridError),
    /// The mesh's box is not finite, or its minimum is above its maximum.
    Bounds,
    /// The metres per world unit are not a finite number of 0 or more.
    Unit,
    /// The up axis is neither y nor z.
    UpAxis {
        /// The number of the axis.
        found: u32,
    },
    /// The DAG is none; offsets count from its section's start.
    Dag(DagError),
    /// The material table is none; offsets count from its section's start.
    Table(TableError),
    /// The material tree is none; offsets count from its section's start.
    Tree(TreeError),
    /// The material tree's depth is not the geometry's.
    TreeDepth {
        /// The geometry's depth.
        expected: u8,
        /// The tree's.
        found: u8,
    },
    /// Two sections that answer the same question.
    Conflict {
        /// One of them.
        first: Section,
        /// The other one.
        second: Section,
    },
    /// The SSVDAG.
    Ssvdag(SsvdagError),
    /// The counts that ranks are summed up from.
    Ranks(RankError),
    /// The ids by rank.
    Ids(RankedError),
    /// The colours by rank.
    Colors(RankedError),
    /// The geometry's depth is not the grid's.
    Depth {
        /// Depth for the grid's resolution.
        expected: u8,
        /// The geometry's depth.
        found: u8,
    },
    /// There is no material, there are more than 65,536, or their section has part of one.
    MaterialCount {
        /// Words in the section.
        found: u64,
    },
    /// A voxel's material does not exist.
    MaterialId {
        /// Number of materials.
        count: u32,
        /// The greatest id in use.
        found: u32,
    },
    /// A material has a number out of range.
    Material {
        /// The material's id.
        index: u32,
        /// Name of the field, as in [`crate::Material`].
        field: &'static str,
    },
    /// The names' section is not as long as its offsets say.
    Names {
        /// Words needed.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// A name's bytes are not UTF-8 or out of order; the padding counts as one name more than there are materials.
    Name {
        /// The material's id.
        index: u32,
    },
}

impl core::fmt::Display for LoadError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        use LoadError::*;
        match *self {
            Magic { found } => write!(f, "this is no .vxd file: it starts with {:02x?}", found.to_le_bytes()),
            Endianness => write!(f, "the words are big-endian: expected little-endian; swap the bytes of each word"),
            Text => write!(f, "this is no .vxd file but a text: if it is a mesh, build it first"),
            Version { found } => write!(f, "version {found} of the format is unknown: expected 1 to {VERSION}"),
            Truncated { expected, found } => {
                write!(f, "the file is cut short: expected {expected} words, found {found}")
            }
            Trailing { expected, found } => {
                write!(f, "the file has words to spare: expected {expected}, found {found}")
            }
            NotWords { bytes } => write!(f, "the file has {bytes} bytes: expected a multiple of 4"),
            Memory { bytes } => write!(f, "no memory for a file of {bytes} bytes"),
            HeaderCrc { expected, found } => {
                write!(f, "the header is damaged: its checksum is {found:#010x}, expected {expected:#010x}")
            }
            Crc { section, word, expected, found } => {
                write!(
                    f,
                    "the {section} at word {word} is damaged: its checksum is {found:#010x}, expected {expected:#010x}"
                )
            }
            UnknownCrc { kind, word, expected, found } => {
                write!(
                    f,
                    "the section of kind {kind} at word {word} is damaged: \
                     its checksum is {found:#010x}, expected {expected:#010x}"
                )
            }
            SectionBounds { word, offset, length } => {
                write!(f, "the section in the row at word {word} cannot have {length} words at {offset}")
            }
            Duplicate { section } => write!(f, "the file has two sections for the {section}: expected one"),
            Missing { section } => write!(f, "the file has no section for the {section}"),
            Reserved { word } => write!(f, "word {word} is not 0, as this version expects"),
            Grid(error) => error.fmt(f),
            Bounds => write!(f, "the mesh's box is not finite or inside out"),
            Unit => write!(f, "the metres per unit are not a finite number of 0 or more"),
            UpAxis { found } => write!(f, "up axis {found} is unknown: expected 1 for y or 2 for z"),
            Dag(error) => error.fmt(f),
            Table(error) => error.fmt(f),
            Tree(error) => error.fmt(f),
            TreeDepth { expected, found } => {
                write!(f, "the material tree has depth {found}: expected {expected}, the geometry's")
            }
            Conflict { first, second } => write!(f, "the file has both {first} and {second}: expected one of them"),
            Ssvdag(error) => error.fmt(f),
            Ranks(error) => error.fmt(f),
            Ids(error) | Colors(error) => error.fmt(f),
            Depth { expected, found } => {
                write!(f, "the geometry has depth {found}: expected {expected} for the grid's resolution")
            }
            MaterialCount { found } => {
                write!(f, "the materials take {found} words: expected 20 each, for 1 to 65536 materials")
            }
            MaterialId { count, found } => write!(f, "a voxel has material {found}, but there are only {count}"),
            Material { index, field } => write!(f, "field `{field}` of material {index} is out of range"),
            Names { expected, found } => write!(f, "the names take {found} words: expected {expected}"),
            Name { index } => write!(f, "the name of material {index} is out of place or not UTF-8"),
        }
    }
}

impl core::error::Error for LoadError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            LoadError::Grid(error) => Some(error),
            LoadError::Dag(error) => Some(error),
            LoadError::Table(error) => Some(error),
            LoadError::Tree(error) => Some(error),
            LoadError::Ssvdag(error) => Some(error),
            LoadError::Ranks(error) => Some(error),
            LoadError::Ids(error) | LoadError::Colors(error) => Some(error),
            _ => None,
        }
    }
}
