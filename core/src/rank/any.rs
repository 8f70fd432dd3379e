//! Any rank, for code that learns at run time which one a scene has.

use super::{MoxelDag, Offsets, Prefix, Rank, Totals};
use crate::morton::Morton;

/// Every scheme of ranks.
#[derive(Clone, Copy, Debug)]
pub enum AnyRank<'a> {
    /// Counts beside a DAG's nodes.
    Prefix(Prefix<'a>),
    /// Counts beside an SSVDAG's nodes.
    Totals(Totals<'a>),
    /// Counts beside each pointer of a DAG.
    Offsets(Offsets<'a>),
    /// Counts of empty voxels in the nodes of a DAG.
    MoxelDag(MoxelDag<'a>),
}

impl<'a> AnyRank<'a> {
    /// Its words, if it is one that a file may hold.
    pub fn words(&self) -> Option<&'a [u32]> {
        match self {
            AnyRank::Prefix(prefix) => Some(prefix.words()),
            AnyRank::Totals(totals) => Some(totals.words()),
            AnyRank::Offsets(_) | AnyRank::MoxelDag(_) => None,
        }
    }
}

impl Rank for AnyRank<'_> {
    fn count(&self) -> u64 {
        match self {
            AnyRank::Prefix(rank) => rank.count(),
            AnyRank::Totals(rank) => rank.count(),
            AnyRank::Offsets(rank) => rank.count(),
            AnyRank::MoxelDag(rank) => rank.count(),
        }
    }

    #[inline]
    fn rank(&self, voxel: Morton) -> Option<u64> {
        match self {
            AnyRank::Prefix(rank) => rank.rank(voxel),
            AnyRank::Totals(rank) => rank.rank(voxel),
            AnyRank::Offsets(rank) => rank.rank(voxel),
            AnyRank::MoxelDag(rank) => rank.rank(voxel),
        }
    }
}
