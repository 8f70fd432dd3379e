//! Rank of a voxel: how many filled voxels have a smaller Morton code; the thesis's *moxel index* (section 3.3).
//!
//! In: a DAG. Out: counts beside it or within it, summed up along the path to a voxel. An array of values in Morton
//! order, one a filled voxel, is then all that a material map needs ([`crate::ranked`]). The schemes always agree:
//! [`Prefix`] (beside a DAG's nodes) and [`Totals`] (beside an SSVDAG's), which go into files; [`Offsets`] (beside each
//! pointer) and [`MoxelDag`] (counts of empty voxels), built in memory. A cube of depth 21 has up to 2^63 voxels:
//! counts of cubes above level 10 take two words, all others one.

mod any;
mod copy;
mod moxel;
mod offsets;
mod prefix;
mod totals;

pub use any::AnyRank;
pub use moxel::MoxelDag;
#[cfg(feature = "alloc")]
pub use moxel::MoxelDagBuf;
pub use offsets::Offsets;
#[cfg(feature = "alloc")]
pub use offsets::OffsetsBuf;
pub use prefix::Prefix;
pub use totals::Totals;

use crate::morton::Morton;

/// Counts of voxels in a node of this level, 8^10 at most, and of lower ones fit a word.
pub(crate) const NARROW: u8 = 10;

/// What numbers the filled voxels of a geometry in Morton order.
pub trait Rank: Copy + Sync {
    /// Number of filled voxels.
    fn count(&self) -> u64;

    /// Number of filled voxels with a smaller Morton code; `None` if the voxel is empty or outside the cube.
    fn rank(&self, voxel: Morton) -> Option<u64>;
}

/// Why words are not the counts of a DAG. Offsets count words from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RankError {
    /// Another number of words than the DAG asks for.
    Length {
        /// Words that the DAG asks for.
        expected: u64,
        /// Words there are.
        found: u64,
    },
    /// A count is not what the DAG below it holds.
    Count {
        /// Offset of its low word.
        word: u32,
    },
}

impl core::fmt::Display for RankError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            RankError::Length { expected, found } => {
                write!(f, "there are {found} words of prefix counts: expected {expected} for this DAG")
            }
            RankError::Count { word } => {
                write!(f, "the prefix count at word {word} is not the number of voxels that the DAG has there")
            }
        }
    }
}

impl core::error::Error for RankError {}

/// Rank of a voxel among those of its brick.
#[inline]
fn in_brick(mask: u64, voxel: Morton) -> Option<u64> {
    let bit = voxel.0 & 63;
    (mask >> bit & 1 != 0).then(|| u64::from((mask & ((1 << bit) - 1)).count_ones()))
}
