//! One colour a voxel, by rank: what textures gave the voxels when they were built.
//!
//! In: checked words. Out: sRGB bytes, red, green, blue. A colour stands for what a texture sends back where the voxel is:
//! it multiplies Kd and Ka. Voxels whose material has no texture have a place, too, and no meaning: looking one up is
//! harmless.
//!
//! ```text
//! word  0, 1   number of colours (low, high)
//!       2      bits of a colour: 24, or 0 for blocks      colour: red in bits 0 to 7, green 8 to 15, blue 16 to 23
//!       3      0
//!       4..    24: colour i has bits 24 i to 24 (i + 1), low bits and low words first; bits to spare are 0
//!              0:  see `blocks`
//! ```

mod blocks;
#[cfg(feature = "alloc")]
mod fit;

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

pub use blocks::Blocks;

#[cfg(feature = "alloc")]
use crate::build::BuildError;
use crate::material::MaterialId;
use crate::materials::Materials;
use crate::morton::Morton;
use crate::rank::{AnyRank, Rank};
use crate::ranked::{MAX_COUNT, RankedError, bits};

/// Words before the colours.
const HEADER: usize = 4;
/// Bits of a colour as it is.
const RAW: u32 = 24;
/// The colour of what is not there.
const WHITE: [u8; 3] = [255; 3];

/// How colours are kept.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum ColorMode {
    /// Blocks of 64 between two colours each, at most 5.02 bits a voxel where they are smooth; nearly the same colours.
    #[default]
    Blocks,
    /// 24 bits each, the very same colours.
    Raw,
}

/// A checked view over colours.
#[derive(Clone, Copy, Debug)]
pub enum Colors<'a> {
    /// Between two colours a block.
    Blocks(Blocks<'a>),
    /// As they are.
    Raw(Raw<'a>),
}

/// A checked view over colours of 24 bits.
#[derive(Clone, Copy, Debug)]
pub struct Raw<'a> {
    words: &'a [u32],
    count: u64,
}

impl<'a> Colors<'a> {
    /// Checks words in O(words), without heap; after `Ok` no look-up can panic.
    pub fn new(words: &'a [u32]) -> Result<Colors<'a>, RankedError> {
        let found = words.len() as u64;
        let Some(&[low, high, width, reserved]) = words.first_chunk::<HEADER>() else {
            return Err(RankedError::Length { expected: HEADER as u64, found });
        };
        let count = u64::from(low) | u64::from(high) << 32;
        if count > MAX_COUNT {
            return Err(RankedError::Header { word: 1 });
        }
        if reserved != 0 {
            return Err(RankedError::Header { word: 3 });
        }
        match width {
            0 => Blocks::new(words, count).map(Colors::Blocks),
            RAW => {
                let expected = bits::words_for(count, RAW).saturating_add(HEADER as u64);
                if found != expected {
                    return Err(RankedError::Length { expected, found });
                }
                let spare = 32 * (found - HEADER as u64) - count * u64::from(RAW);
                if spare > 0 && words.last().is_some_and(|last| last.leading_zeros() < spare as u32) {
                    return Err(RankedError::Value { word: found - 1 });
                }
                Ok(Colors::Raw(Raw { words, count }))
            }
            _ => Err(RankedError::Header { word: 2 }),
        }
    }

    /// The words, as they stand in a file.
    pub fn words(&self) -> &'a [u32] {
        match self {
            Colors::Blocks(blocks) => blocks.words(),
            Colors::Raw(raw) => raw.words,
        }
    }

    /// Number of colours.
    pub fn count(&self) -> u64 {
        match self {
            Colors::Blocks(blocks) => blocks.count(),
            Colors::Raw(raw) => raw.count,
        }
    }

    /// The colour of the voxel of a rank, sRGB; white beyond the last.
    #[inline]
    pub fn get(&self, rank: u64) -> [u8; 3] {
        match self {
            Colors::Blocks(blocks) => blocks.get(rank),
            Colors::Raw(raw) if rank < raw.count => from_word(bits::get(&raw.words[HEADER..], rank, RAW)),
            Colors::Raw(_) => WHITE,
        }
    }
}

/// The colour in the low 24 bits of a word.
#[inline]
fn from_word(word: u32) -> [u8; 3] {
    let [r, g, b, _] = word.to_le_bytes();
    [r, g, b]
}

/// The word whose low 24 bits are a colour.
#[cfg(feature = "alloc")]
fn to_word([r, g, b]: [u8; 3]) -> u32 {
    u32::from_le_bytes([r, g, b, 0])
}

/// Colours that own their words. The words depend on the colours alone.
#[cfg(feature = "alloc")]
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ColorsBuf {
    words: Vec<u32>,
}

#[cfg(feature = "alloc")]
impl ColorsBuf {
    /// The colours of all voxels in Morton order; `None` where a voxel's does not matter.
    pub fn new(mode: ColorMode, colors: impl Iterator<Item = Option<[u8; 3]>>) -> Result<ColorsBuf, BuildError> {
        let words = match mode {
            ColorMode::Blocks => fit::blocks(colors)?,
            ColorMode::Raw => raw(colors)?,
        };
        Ok(ColorsBuf { words })
    }

    /// The view that answers look-ups.
    pub fn as_colors(&self) -> Colors<'_> {
        let count = u64::from(self.words[0]) | u64::from(self.words[1]) << 32;
        match self.words[2] {
            RAW => Colors::Raw(Raw { words: &self.words, count }),
            _ => Colors::Blocks(Blocks::trusted(&self.words, count)),
        }
    }

    /// The words, for [`Colors::new`].
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }
}

/// Three bytes a colour.
#[cfg(feature = "alloc")]
fn raw(colors: impl Iterator<Item = Option<[u8; 3]>>) -> Result<Vec<u32>, BuildError> {
    let mut words = Vec::new();
    crate::ranked::append(&mut words, &[0, 0, RAW, 0])?;
    let (mut pending, mut filled, mut count) = (0u64, 0, 0u64);
    for color in colors {
        pending |= u64::from(to_word(color.unwrap_or(WHITE))) << filled;
        filled += RAW;
        count += 1;
        if filled >= 32 {
            crate::ranked::append(&mut words, &[pending as u32])?;
            pending >>= 32;
            filled -= 32;
        }
    }
    if filled > 0 {
        crate::ranked::append(&mut words, &[pending as u32])?;
    }
    (words[0], words[1]) = (count as u32, (count >> 32) as u32);
    Ok(words)
}

/// Colours, and what finds a voxel's place among them.
#[derive(Clone, Copy, Debug)]
pub struct Colored<'a> {
    rank: AnyRank<'a>,
    colors: Colors<'a>,
}

impl<'a> Colored<'a> {
    /// Joins the two, which must be of equally many voxels.
    pub fn new(rank: AnyRank<'a>, colors: Colors<'a>) -> Result<Colored<'a>, RankedError> {
        let (expected, found) = (rank.count(), colors.count());
        if expected != found {
            return Err(RankedError::Voxels { expected, found });
        }
        Ok(Colored { rank, colors })
    }

    /// What finds the places.
    pub fn rank(&self) -> AnyRank<'a> {
        self.rank
    }

    /// The colours.
    pub fn colors(&self) -> Colors<'a> {
        self.colors
    }

    /// The colour of a voxel, sRGB; `None` if the voxel is empty.
    #[inline]
    pub fn color(&self, voxel: Morton) -> Option<[u8; 3]> {
        Some(self.colors.get(self.rank.rank(voxel)?))
    }
}

/// Materials with colours beside them, where there are any.
#[derive(Clone, Copy, Debug)]
pub struct Painted<'a, M> {
    /// What each voxel is made of.
    pub materials: M,
    /// What its texture looks like there.
    pub colors: Option<Colored<'a>>,
}

impl<M: Materials> Materials for Painted<'_, M> {
    #[inline]
    fn id(&self, voxel: Morton) -> MaterialId {
        self.materials.id(voxel)
    }

    #[inline]
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        self.materials.normal(voxel)
    }

    #[inline]
    fn color(&self, voxel: Morton) -> Option<[u8; 3]> {
        self.colors?.color(voxel)
    }
}
