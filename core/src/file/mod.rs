//! The `.vxd` file: a scene in little-endian `u32` words, read without copying. Byte offsets are in `docs/format.md`.
//!
//! ```text
//! word  0      magic: the bytes "VXD", 0x1a            28, 29  metres per world unit, 0 if unknown
//!       1      version: 1; 2, 3, 4 from kind 5, 6, 9   30, 31  0
//!       2, 3   words in the file (low, high)           32..    one row of 6 words per section, in file order:
//!       4      resolution                                      [ kind ][ CRC-32 ][ offset ][ - ][ length ][ - ]
//!       5      up axis: 1 is y, 2 is z                 then    CRC-32 of all words before it
//!       6      material of all voxels if no section    then    the sections, without gaps
//!              says otherwise, else 0                  kinds:  1 DAG         words of `dag`
//!       7      number of sections                              2 table       words of `table` (may be missing)
//!       8..    f64: origin x y z, voxel size                   3 materials   20 words each
//!       16..   f64: the mesh's box, min x y z, max x y z       4 names       byte offsets, one more than materials; UTF-8
//!                                                              5 tree        words of `tree`, instead of a table
//!                                                              6 SSVDAG      words of `ssvdag`, instead of a DAG
//!                                                              7 ranks       words of `rank`: prefix counts or totals
//!                                                              8 ids         words of `ranked`, instead of a table
//!                                                              9 colours     words of `colors`, beside ranks
//! ```
//!
//! f64, offsets and lengths are two words, low first. Sections of unknown kind are skipped once their CRC is right, so
//! that later writers can add to a scene; what an old reader must not skip raises the version.

mod crc;
mod error;
mod names;
mod write;

pub use error::{LoadError, Section};
pub use names::Name;
pub use write::{Parts, WriteError};

use crate::colors::{Colored, Colors, Painted};
use crate::dag::Dag;
use crate::geometry::Geometry;
use crate::grid::{Bounds, Grid, UpAxis};
use crate::layout::AnyGeometry;
use crate::material::{Material, MaterialId};
use crate::materials::{AnyMaterials, Single};
use crate::rank::{AnyRank, Prefix, Totals};
use crate::ranked::{Packed, Ranked};
use crate::ssvdag::Ssvdag;
use crate::table::Table;
use crate::tree::Tree;
use names::Names;

/// The first word: the bytes `V`, `X`, `D` and 0x1a, which ends a text file, so that no text starts like this.
pub const MAGIC: u32 = u32::from_le_bytes(*b"VXD\x1a");
/// The newest version. A scene is written as the oldest version that knows all its sections.
pub const VERSION: u32 = 4;
/// Words before the section table.
pub const HEADER: usize = 32;
/// Words per row of the section table.
const ROW: usize = 6;
/// Words per material.
const RECORD: usize = 20;
/// Beside illum: the material has a texture.
const TEXTURED: u32 = 1 << 8;

/// A scene in a file's words; nothing in it can panic.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Where the voxels lie in the world.
    pub grid: Grid,
    /// The mesh's box in world units.
    pub bounds: Bounds,
    /// Which axis of the world points up.
    pub up: UpAxis,
    /// Metres per world unit; 0 if nobody said.
    pub metres_per_unit: f64,
    /// The filled voxels. Their depth is the grid's; filled voxels beyond the resolution, within the cube of 2^depth,
    /// are not looked for: they do no harm.
    pub geometry: AnyGeometry<'a>,
    /// Which material a voxel has. That a table's entries are the voxels is not checked: missing ones
    /// have material 0.
    pub materials: AnyMaterials<'a>,
    /// The colours of textures, where there are any.
    pub colors: Option<Colored<'a>>,
    records: &'a [[u32; RECORD]],
    names: Names<'a>,
}

impl<'a> Scene<'a> {
    /// Materials and colours together, as a renderer asks for them.
    pub fn looks(&self) -> Painted<'a, AnyMaterials<'a>> {
        Painted { materials: self.materials, colors: self.colors }
    }

    /// The parameters of a material; [`Material::GREY`] beyond the last.
    pub fn material(&self, id: MaterialId) -> Material {
        self.records.get(usize::from(id)).map_or(Material::GREY, decode_material)
    }

    /// Number of materials, 1 to 65,536.
    pub fn material_count(&self) -> usize {
        self.records.len()
    }

    /// The name of a material; empty beyond the last.
    pub fn name(&self, id: MaterialId) -> Name<'a> {
        self.names.get(usize::from(id))
    }
}

/// Checks a file's words and borrows the scene in them. O(words), no heap, nothing is copied.
pub fn read(words: &[u32]) -> Result<Scene<'_>, LoadError> {
    check_magic(words.first().copied())?;
    let found = words.len() as u64;
    let Some(header) = words.first_chunk::<HEADER>() else {
        return Err(LoadError::Truncated { expected: HEADER as u64, found });
    };
    if !(1..=VERSION).contains(&header[1]) {
        return Err(LoadError::Version { found: header[1] });
    }
    let expected = u64_at(header, 2);
    if found < expected {
        return Err(LoadError::Truncated { expected, found });
    }
    if found > expected {
        return Err(LoadError::Trailing { expected, found });
    }
    let sections = find_sections(words)?;
    let required = |section: Section| sections[section as usize].ok_or(LoadError::Missing { section });

    // The header's numbers.
    if let Some(word) = (30..HEADER).find(|&i| header[i] != 0) {
        return Err(LoadError::Reserved { word: word as u64 });
    }
    let grid = Grid { origin: f64s_at(header, 8), voxel_size: f64_at(header, 14), resolution: header[4] };
    let bounds = Bounds { min: f64s_at(header, 16), max: f64s_at(header, 22) };
    let up = match header[5] {
        1 => UpAxis::Y,
        2 => UpAxis::Z,
        found => return Err(LoadError::UpAxis { found }),
    };
    let metres_per_unit = f64_at(header, 28);

    // The sections.
    let found = |section: Section| sections[section as usize].map(|words| (section, words));
    let geometry = match one_of([found(Section::Dag), found(Section::Ssvdag)])? {
        Some((Section::Ssvdag, words)) => AnyGeometry::Ssvdag(Ssvdag::new(words).map_err(LoadError::Ssvdag)?),
        _ => AnyGeometry::Dag(Dag::new(required(Section::Dag)?).map_err(LoadError::Dag)?),
    };
    let ranks = || {
        let counts = required(Section::Ranks)?;
        let rank = match geometry {
            AnyGeometry::Dag(dag) => Prefix::new(dag, counts).map(AnyRank::Prefix),
            AnyGeometry::Ssvdag(ssvdag) => Totals::new(ssvdag, counts).map(AnyRank::Totals),
            _ => return Err(LoadError::Missing { section: Section::Dag }),
        };
        rank.map_err(LoadError::Ranks)
    };
    let materials = match one_of([found(Section::Table), found(Section::Tree), found(Section::Ids)])? {
        Some(_) if header[6] != 0 => return Err(LoadError::Reserved { word: 6 }),
        Some((Section::Table, words)) => AnyMaterials::Table(Table::new(words).map_err(LoadError::Table)?),
        Some((Section::Tree, words)) => AnyMaterials::Tree(Tree::new(words).map_err(LoadError::Tree)?),
        Some((_, words)) => {
            let ids = Packed::new(words).map_err(LoadError::Ids)?;
            AnyMaterials::Ranked(Ranked::new(ranks()?, ids).map_err(LoadError::Ids)?)
        }
        None => match MaterialId::try_from(header[6]) {
            Ok(id) => AnyMaterials::Single(Single(id)),
            Err(_) => return Err(LoadError::MaterialId { count: 1 << 16, found: header[6] }),
        },
    };
    let colors = match sections[Section::Colors as usize] {
        Some(words) => {
            let colors = Colors::new(words).map_err(LoadError::Colors)?;
            // Counted for the materials already, if they go by ranks.
            let rank = materials.rank().map_or_else(ranks, Ok)?;
            Some(Colored::new(rank, colors).map_err(LoadError::Colors)?)
        }
        None => None,
    };
    let (records, rest) = required(Section::Materials)?.as_chunks::<RECORD>();
    if !rest.is_empty() {
        return Err(LoadError::MaterialCount { found: (records.len() * RECORD + rest.len()) as u64 });
    }
    let names = Names::new(required(Section::Names)?, records.len())?;
    check(&grid, &bounds, metres_per_unit, geometry, materials, records.len())?;
    for (index, record) in records.iter().enumerate() {
        check_record(index as u32, record, colors.is_some())?;
    }
    Ok(Scene { grid, bounds, up, metres_per_unit, geometry, materials, colors, records, names })
}

/// The one section that is there, if there is one.
fn one_of<const N: usize>(found: [Option<(Section, &[u32])>; N]) -> Result<Option<(Section, &[u32])>, LoadError> {
    let mut found = found.into_iter().flatten();
    match (found.next(), found.next()) {
        (Some((first, _)), Some((second, _))) => Err(LoadError::Conflict { first, second }),
        (one, _) => Ok(one),
    }
}

/// The words of a file's bytes. Its length and first bytes are checked here, the rest by [`read`].
#[cfg(feature = "alloc")]
pub fn words_from_bytes(bytes: &[u8]) -> Result<alloc::vec::Vec<u32>, LoadError> {
    let (whole, rest) = bytes.as_chunks::<4>();
    check_magic(whole.first().map(|&bytes| u32::from_le_bytes(bytes)))?;
    if !rest.is_empty() {
        return Err(LoadError::NotWords { bytes: bytes.len() as u64 });
    }
    let mut words = alloc::vec::Vec::new();
    words.try_reserve_exact(whole.len()).map_err(|_| LoadError::Memory { bytes: bytes.len() as u64 })?;
    words.extend(whole.iter().map(|&bytes| u32::from_le_bytes(bytes)));
    Ok(words)
}

/// The first word must be the magic; says what it looks like otherwise.
fn check_magic(first: Option<u32>) -> Result<(), LoadError> {
    let Some(found) = first else {
        return Err(LoadError::Truncated { expected: HEADER as u64, found: 0 });
    };
    let is_text = |byte: u8| byte.is_ascii_graphic() || b" \t\r\n".contains(&byte);
    match found {
        MAGIC => Ok(()),
        _ if found == MAGIC.swap_bytes() => Err(LoadError::Endianness),
        _ if found.to_le_bytes().into_iter().all(is_text) => Err(LoadError::Text),
        _ => Err(LoadError::Magic { found }),
    }
}

/// The words of the sections of each kind that this version knows, all checksums compared.
fn find_sections(words: &[u32]) -> Result<[Option<&[u32]>; Section::COUNT], LoadError> {
    let found = words.len() as u64;
    let rows_end = HEADER as u64 + ROW as u64 * u64::from(words[7]);
    if rows_end >= found {
        return Err(LoadError::Truncated { expected: rows_end + 1, found });
    }
    let rows_end = rows_end as usize;
    crc::check(&words[..rows_end], words[rows_end], None)?;

    // The sections follow each other from here to the end.
    let mut sections = [None; Section::COUNT];
    let mut next = rows_end + 1;
    for (index, row) in words[HEADER..rows_end].chunks_exact(ROW).enumerate() {
        let (offset, length) = (u64_at(row, 2), u64_at(row, 4));
        if offset != next as u64 || length > found - offset {
            return Err(LoadError::SectionBounds { word: (HEADER + index * ROW) as u64, offset, length });
        }
        let section = &words[next..next + length as usize];
        crc::check(section, row[1], Some((Section::of(row[0], words[1]).ok_or(row[0]), offset)))?;
        next += length as usize;
        if let Some(kind) = Section::of(row[0], words[1])
            && sections[kind as usize].replace(section).is_some()
        {
            return Err(LoadError::Duplicate { section: kind });
        }
    }
    if next as u64 != found {
        return Err(LoadError::Trailing { expected: next as u64, found });
    }
    Ok(sections)
}

/// Where a section begins in the words of a file that passes [`read`]; `None` if it has none, or beyond 32 bits.
pub(crate) fn section_start(words: &[u32], section: Section) -> Option<u32> {
    let rows = words.get(HEADER..)?.chunks_exact(ROW).take(words[7] as usize);
    let row = rows.into_iter().find(|row| Section::of(row[0], words[1]) == Some(section))?;
    u32::try_from(u64_at(row, 2)).ok()
}

/// What must hold between a scene's parts, whether they are read or written.
fn check(
    grid: &Grid,
    bounds: &Bounds,
    metres_per_unit: f64,
    geometry: AnyGeometry<'_>,
    materials: AnyMaterials<'_>,
    count: usize,
) -> Result<(), LoadError> {
    grid.checked().map_err(LoadError::Grid)?;
    if !(0..3).all(|i| bounds.min[i] <= bounds.max[i] && (bounds.max[i] - bounds.min[i]).is_finite()) {
        return Err(LoadError::Bounds);
    }
    if !(metres_per_unit >= 0.0 && metres_per_unit.is_finite()) {
        return Err(LoadError::Unit);
    }
    if geometry.depth() != grid.depth() {
        return Err(LoadError::Depth { expected: grid.depth(), found: geometry.depth() });
    }
    if let AnyMaterials::Tree(tree) = materials
        && tree.depth() != geometry.depth()
    {
        return Err(LoadError::TreeDepth { expected: geometry.depth(), found: tree.depth() });
    }
    if count == 0 || count > 1 << 16 {
        return Err(LoadError::MaterialCount { found: (count * RECORD) as u64 });
    }
    let found = materials.max_material();
    if usize::from(found) >= count {
        return Err(LoadError::MaterialId { count: count as u32, found: u32::from(found) });
    }
    Ok(())
}

/// A record must be what the writer makes of a material that passes.
fn check_record(index: u32, record: &[u32; RECORD], has_colors: bool) -> Result<(), LoadError> {
    let material = decode_material(record);
    check_material(index, &material, has_colors)?;
    if encode_material(&material) != *record {
        return Err(LoadError::Material { index, field: "illum" });
    }
    Ok(())
}

/// What is textured needs colours.
fn check_material(index: u32, material: &Material, has_colors: bool) -> Result<(), LoadError> {
    let checked = material.checked().map_err(|e| LoadError::Material { index, field: e.field })?;
    if checked.shininess != material.shininess {
        return Err(LoadError::Material { index, field: "shininess" });
    }
    if material.illum > 10 {
        return Err(LoadError::Material { index, field: "illum" });
    }
    if material.textured && !has_colors {
        return Err(LoadError::Material { index, field: "textured" });
    }
    Ok(())
}

fn decode_material(record: &[u32; RECORD]) -> Material {
    let rgb = |at: usize| [record[at], record[at + 1], record[at + 2]].map(f32::from_bits);
    Material {
        ambient: rgb(0),
        diffuse: rgb(3),
        specular: rgb(6),
        emission: rgb(9),
        transmission: rgb(12),
        opacity: f32::from_bits(record[15]),
        refraction: f32::from_bits(record[16]),
        shininess: record[17],
        illum: record[18] as u8,
        textured: record[18] & TEXTURED != 0,
    }
}

fn encode_material(material: &Material) -> [u32; RECORD] {
    let Material {
        ambient,
        diffuse,
        specular,
        emission,
        transmission,
        shininess,
        opacity,
        refraction,
        illum,
        textured,
    } = *material;
    let mut record = [0; RECORD];
    for (words, rgb) in record.chunks_exact_mut(3).zip([ambient, diffuse, specular, emission, transmission]) {
        words.copy_from_slice(&rgb.map(f32::to_bits));
    }
    record[15..19].copy_from_slice(&[opacity.to_bits(), refraction.to_bits(), shininess, u32::from(illum)]);
    record[18] |= if textured { TEXTURED } else { 0 };
    record
}

fn u64_at(words: &[u32], at: usize) -> u64 {
    u64::from(words[at]) | u64::from(words[at + 1]) << 32
}

fn f64_at(words: &[u32], at: usize) -> f64 {
    f64::from_bits(u64_at(words, at))
}

fn f64s_at(words: &[u32], at: usize) -> [f64; 3] {
    [0, 2, 4].map(|i| f64_at(words, at + i))
}
