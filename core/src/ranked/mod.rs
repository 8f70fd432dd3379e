//! Materials as an array in Morton order, one value a filled voxel, looked up by [`Rank`].
//!
//! In: what ranks the voxels of a geometry, and a checked array. Out: materials. The arrays: [`Packed`] (ids, as many
//! bits as the largest needs; goes into files), [`Palettes`] (blocks with palettes of their own) and [`Moxels`]
//! (Williams's table, with or without normals). They know no geometry: an array fits any that has as many voxels.

pub(crate) mod bits;
mod moxels;
mod packed;
mod palette;

pub use moxels::Moxels;
#[cfg(feature = "alloc")]
pub use moxels::MoxelsBuf;
pub use packed::Packed;
#[cfg(feature = "alloc")]
pub use packed::PackedBuf;
pub use palette::Palettes;
#[cfg(feature = "alloc")]
pub use palette::PalettesBuf;

#[cfg(feature = "alloc")]
use crate::build::BuildError;
use crate::material::MaterialId;
use crate::materials::Materials;
use crate::morton::Morton;
use crate::rank::Rank;
#[cfg(feature = "alloc")]
use crate::table::Entry;

/// More voxels than a cube has.
pub(crate) const MAX_COUNT: u64 = 1 << 63;

/// Values of the filled voxels in Morton order. Look-ups are total: beyond the last voxel the answer is material 0 and
/// no normal.
pub trait Values: Copy + Sync {
    /// Number of voxels.
    fn count(&self) -> u64;

    /// The material of the voxel of a rank.
    fn id(&self, rank: u64) -> MaterialId;

    /// Its outward unit normal; `None` if none is stored.
    fn normal(&self, rank: u64) -> Option<[f32; 3]>;

    /// No voxel's material id is above this one.
    fn max_material(&self) -> MaterialId;
}

/// An array of values, and what finds a voxel's place in it.
#[derive(Clone, Copy, Debug)]
pub struct Ranked<R, V> {
    rank: R,
    values: V,
}

impl<R: Rank, V: Values> Ranked<R, V> {
    /// Joins the two, which must be of equally many voxels.
    pub fn new(rank: R, values: V) -> Result<Ranked<R, V>, RankedError> {
        let (expected, found) = (rank.count(), values.count());
        if expected != found {
            return Err(RankedError::Voxels { expected, found });
        }
        Ok(Ranked { rank, values })
    }

    /// What finds the places.
    pub fn rank(&self) -> R {
        self.rank
    }

    /// The array.
    pub fn values(&self) -> V {
        self.values
    }
}

impl<R: Rank, V: Values> Materials for Ranked<R, V> {
    #[inline]
    fn id(&self, voxel: Morton) -> MaterialId {
        self.rank.rank(voxel).map_or(0, |rank| self.values.id(rank))
    }

    #[inline]
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        self.values.normal(self.rank.rank(voxel)?)
    }
}

/// Why words are not an array of values, or not one for a geometry. Offsets count words from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RankedError {
    /// Another number of words than the header says.
    Length {
        /// Words that the header says.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// A header word is out of range or does not agree with the values.
    Header {
        /// Its offset.
        word: u32,
    },
    /// A word holds bits that mean nothing, or something that is not there.
    Value {
        /// Its offset.
        word: u64,
    },
    /// The array is of another number of voxels than the geometry.
    Voxels {
        /// Voxels of the geometry.
        expected: u64,
        /// Values of the array.
        found: u64,
    },
}

impl core::fmt::Display for RankedError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            RankedError::Length { expected, found } => {
                write!(f, "the values by rank have {found} words: expected {expected}")
            }
            RankedError::Header { word } => {
                write!(f, "word {word} of the values by rank is out of range or disagrees with the values")
            }
            RankedError::Value { word } => write!(f, "word {word} of the values by rank is no value"),
            RankedError::Voxels { expected, found } => {
                write!(f, "there are values for {found} voxels: the geometry has {expected}")
            }
        }
    }
}

impl core::error::Error for RankedError {}

/// Passes entries on to `push`, if their codes ascend.
#[cfg(feature = "alloc")]
fn in_order(
    entries: impl IntoIterator<Item = (Morton, Entry)>,
    mut push: impl FnMut(Entry) -> Result<(), BuildError>,
) -> Result<(), BuildError> {
    let mut next = 0;
    for (code, entry) in entries {
        if code.0 < next {
            return Err(BuildError::Order { code: code.0 });
        }
        next = code.0.saturating_add(1);
        push(entry)?;
    }
    Ok(())
}

/// Appends words, or says how many bytes could not be had.
#[cfg(feature = "alloc")]
pub(crate) fn append(words: &mut alloc::vec::Vec<u32>, more: &[u32]) -> Result<(), BuildError> {
    words.try_reserve(more.len()).map_err(|_| BuildError::Memory { bytes: 4 * more.len() as u64 })?;
    words.extend_from_slice(more);
    Ok(())
}
