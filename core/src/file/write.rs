//! Writing a scene: a head that is made here, then the words of the geometry and of a table as they are, so that a table of
//! any size goes to disk without a copy. What is written is what [`super::read`] takes.

use super::error::{LoadError, Section};
use super::{HEADER, MAGIC, RECORD, ROW, check, check_material, crc, encode_material};
use crate::colors::Colored;
use crate::grid::UpAxis;
use crate::grid::{Bounds, Grid};
use crate::layout::AnyGeometry;
use crate::material::Material;
use crate::materials::AnyMaterials;
use crate::rank::AnyRank;

/// What a file is made of.
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    /// Where the voxels lie in the world.
    pub grid: Grid,
    /// The mesh's box in world units.
    pub bounds: Bounds,
    /// Which axis of the world points up.
    pub up: UpAxis,
    /// Metres per world unit; 0 if nobody said.
    pub metres_per_unit: f64,
    /// The filled voxels.
    pub geometry: AnyGeometry<'a>,
    /// Which material a voxel has.
    pub voxel_materials: AnyMaterials<'a>,
    /// The colours of textures, if a material has one.
    pub colors: Option<Colored<'a>>,
    /// The materials, 1 to 65,536.
    pub materials: &'a [Material],
    /// Their names.
    pub names: &'a [&'a str],
}

/// Why a file cannot be written.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum WriteError {
    /// The lent words are too few.
    Full {
        /// Words that are missing.
        missing: u64,
    },
    /// There is no memory for the words.
    Memory {
        /// Bytes asked for.
        bytes: u64,
    },
    /// There are not as many names as materials, or they take 4 GiB or more.
    Names {
        /// Number of names.
        found: u64,
    },
    /// A geometry or materials that no file holds, or ranks of another geometry.
    Representation,
    /// A reader would refuse the file.
    Invalid(LoadError),
}

impl core::fmt::Display for WriteError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            WriteError::Full { missing } => write!(f, "{missing} more words are needed for the file"),
            WriteError::Memory { bytes } => write!(f, "no memory for a file of {bytes} bytes"),
            WriteError::Names { found } => {
                write!(f, "{found} names for the materials: expected one each, below 4 GiB together")
            }
            WriteError::Representation => f.write_str(
                "a file holds a DAG or an SSVDAG, and one material, a table, a tree, or ids by ranks of the same geometry",
            ),
            WriteError::Invalid(error) => write!(f, "no reader would take the file: {error}"),
        }
    }
}

impl core::error::Error for WriteError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            WriteError::Invalid(error) => Some(error),
            _ => None,
        }
    }
}

impl<'a> Parts<'a> {
    /// Words of the head: header, section table, materials and names.
    pub fn head_len(&self) -> u64 {
        let rows = ROW * self.sections().count();
        (HEADER + rows + 1) as u64 + self.materials_len() + self.names_len()
    }

    /// The words that follow the head, as they are: those of the geometry, of the counts of ranks, of the table, the tree
    /// or the ids, and of the colours. Of what the file does not hold there are none.
    pub fn body(&self) -> [&'a [u32]; 4] {
        let counts = self.ranks().and_then(|rank| rank.words()).unwrap_or(&[]);
        let colors = self.colors.map_or(&[][..], |colored| colored.colors().words());
        [self.geometry.words(), counts, self.voxel_materials.words(), colors]
    }

    /// What values by rank go by.
    fn ranks(&self) -> Option<AnyRank<'a>> {
        self.voxel_materials.rank().or(self.colors.map(|colored| colored.rank()))
    }

    /// Words of the whole file: head and body.
    pub fn file_len(&self) -> u64 {
        self.body().iter().fold(self.head_len(), |sum, words| sum + words.len() as u64)
    }

    /// Checks that a reader will take the file, and writes its head, checksums of the body included. Gives the number of
    /// words written, [`Parts::head_len`]; the rest of the file is [`Parts::body`].
    pub fn write_head(&self, out: &mut [u32]) -> Result<usize, WriteError> {
        self.check()?;
        let out = exactly(out, self.head_len())?;

        // The header.
        let file_len = self.file_len();
        let material = match self.voxel_materials {
            AnyMaterials::Single(single) => u32::from(single.0),
            _ => 0,
        };
        let sections = self.sections().count() as u32;
        let version = self.sections().map(Section::version).max().unwrap_or(1);
        let up = match self.up {
            UpAxis::Y => 1,
            UpAxis::Z => 2,
        };
        out.fill(0);
        (out[0], out[1]) = (MAGIC, version);
        put_u64(out, 2, file_len);
        out[4..8].copy_from_slice(&[self.grid.resolution, up, material, sections]);
        let Bounds { min, max } = self.bounds;
        let grid = self.grid.origin.into_iter().chain([self.grid.voxel_size]);
        for (i, value) in grid.chain(min).chain(max).chain([self.metres_per_unit]).enumerate() {
            put_u64(out, 8 + 2 * i, value.to_bits());
        }

        // The sections that are made here.
        let front = HEADER + ROW * sections as usize;
        let (rows, made) = out.split_at_mut(front + 1);
        let (records, names) = made.split_at_mut(self.materials_len() as usize);
        for (record, material) in records.chunks_exact_mut(RECORD).zip(self.materials) {
            record.copy_from_slice(&encode_material(material));
        }
        self.write_names(names);

        // The section table, now that all words can be summed up.
        let [geometry, counts, voxel_materials, colors] = self.body();
        let mut offset = front as u64 + 1;
        for (i, section) in self.sections().enumerate() {
            let words = match section {
                Section::Materials => &*records,
                Section::Names => &*names,
                Section::Dag | Section::Ssvdag => geometry,
                Section::Ranks => counts,
                Section::Table | Section::Tree | Section::Ids => voxel_materials,
                Section::Colors => colors,
            };
            let row = HEADER + ROW * i;
            (rows[row], rows[row + 1]) = (section.kind(), crc::of(words));
            put_u64(rows, row + 2, offset);
            put_u64(rows, row + 4, words.len() as u64);
            offset += words.len() as u64;
        }
        rows[front] = crc::of(&rows[..front]);
        Ok(out.len())
    }

    /// Writes the whole file and gives its length in words, [`Parts::file_len`].
    pub fn write_into(&self, out: &mut [u32]) -> Result<usize, WriteError> {
        let out = exactly(out, self.file_len())?;
        let mut at = self.write_head(out)?;
        for words in self.body() {
            out[at..at + words.len()].copy_from_slice(words);
            at += words.len();
        }
        Ok(at)
    }

    /// The whole file in memory of its own.
    #[cfg(feature = "alloc")]
    pub fn to_vec(&self) -> Result<alloc::vec::Vec<u32>, WriteError> {
        let len = self.file_len();
        let missing = WriteError::Memory { bytes: len.saturating_mul(4) };
        let len = usize::try_from(len).map_err(|_| missing)?;
        let mut words = alloc::vec::Vec::new();
        words.try_reserve_exact(len).map_err(|_| missing)?;
        words.resize(len, 0);
        self.write_into(&mut words)?;
        Ok(words)
    }

    fn check(&self) -> Result<(), WriteError> {
        let bytes: u64 = self.names.iter().map(|name| name.len() as u64).sum();
        if self.names.len() != self.materials.len() || bytes > u64::from(u32::MAX) {
            return Err(WriteError::Names { found: self.names.len() as u64 });
        }
        // Some representations are made in memory only, and ranks belong to the geometry that they were counted in.
        let fits = |rank| match (self.geometry, rank) {
            (AnyGeometry::Dag(dag), AnyRank::Prefix(prefix)) => prefix.dag().words() == dag.words(),
            (AnyGeometry::Ssvdag(ssvdag), AnyRank::Totals(totals)) => totals.ssvdag().words() == ssvdag.words(),
            _ => false,
        };
        let known = matches!(self.geometry, AnyGeometry::Dag(_) | AnyGeometry::Ssvdag(_))
            && !matches!(self.voxel_materials, AnyMaterials::Palettes(_) | AnyMaterials::Moxels(_));
        let ranks = [self.voxel_materials.rank(), self.colors.map(|colored| colored.rank())];
        if !known || !ranks.into_iter().flatten().all(fits) {
            return Err(WriteError::Representation);
        }
        let count = self.materials.len();
        check(&self.grid, &self.bounds, self.metres_per_unit, self.geometry, self.voxel_materials, count)
            .map_err(WriteError::Invalid)?;
        for (index, material) in self.materials.iter().enumerate() {
            check_material(index as u32, material, self.colors.is_some()).map_err(WriteError::Invalid)?;
        }
        Ok(())
    }

    /// The sections in file order.
    fn sections(&self) -> impl Iterator<Item = Section> {
        let geometry = match self.geometry {
            AnyGeometry::Ssvdag(_) => Section::Ssvdag,
            _ => Section::Dag,
        };
        let voxel_materials = match self.voxel_materials {
            AnyMaterials::Single(_) => None,
            AnyMaterials::Table(_) => Some(Section::Table),
            AnyMaterials::Tree(_) => Some(Section::Tree),
            _ => Some(Section::Ids),
        };
        let counts = self.ranks().map(|_| Section::Ranks);
        let colors = self.colors.map(|_| Section::Colors);
        let beside = [counts, voxel_materials, colors].into_iter().flatten();
        [Section::Materials, Section::Names, geometry].into_iter().chain(beside)
    }

    fn materials_len(&self) -> u64 {
        (RECORD * self.materials.len()) as u64
    }

    fn names_len(&self) -> u64 {
        let bytes: u64 = self.names.iter().map(|name| name.len() as u64).sum();
        self.names.len() as u64 + 1 + bytes.div_ceil(4)
    }

    /// Fills zeroed words with the names' offsets and bytes.
    fn write_names(&self, out: &mut [u32]) {
        let (offsets, text) = out.split_at_mut(self.names.len() + 1);
        let mut at = 0;
        for (name, end) in self.names.iter().zip(&mut offsets[1..]) {
            for byte in name.bytes() {
                text[at / 4] |= u32::from(byte) << (8 * (at % 4));
                at += 1;
            }
            *end = at as u32;
        }
    }
}

/// The first `needed` words, or how many are missing.
fn exactly(out: &mut [u32], needed: u64) -> Result<&mut [u32], WriteError> {
    let missing = needed.saturating_sub(out.len() as u64);
    match out.get_mut(..needed as usize) {
        Some(words) if missing == 0 => Ok(words),
        _ => Err(WriteError::Full { missing }),
    }
}

fn put_u64(words: &mut [u32], at: usize, value: u64) {
    (words[at], words[at + 1]) = (value as u32, (value >> 32) as u32);
}
