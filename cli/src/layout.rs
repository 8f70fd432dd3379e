//! The voxels of a built scene in the layout that was asked for, and the counts by which ranks are found in it.

use std::sync::Arc;

use voxdag::Dag;
use voxdag::build::{BuildError, DagBuf};
use voxdag::layout::AnyGeometry;
use voxdag::rank::{AnyRank, MoxelDagBuf, OffsetsBuf, Prefix, Totals};
use voxdag::ssvdag::SsvdagBuf;
use voxdag::svo::{Svo, SvoBuf};

use crate::options::GeometryArg;

/// The DAG that everything begins with, and what was made of it.
pub struct Layout {
    dag: Arc<DagBuf>,
    other: Option<Other>,
    /// Prefix counts of the DAG or totals of the SSVDAG; empty where nobody asks for ranks, or the layout has its own.
    counts: Vec<u32>,
}

/// Any layout but the DAG.
enum Other {
    Ssvdag(SsvdagBuf),
    Svo(SvoBuf),
    Offsets(OffsetsBuf),
    MoxelDag(MoxelDagBuf),
}

impl Layout {
    /// About how many bytes it takes to make the layout, beside the DAG.
    pub fn bytes_for(dag: &Dag<'_>, kind: GeometryArg, ranks: bool) -> Result<u64, BuildError> {
        let words = dag.words().len() as u64;
        let counts = if ranks { 4 * Prefix::words_for(dag) as u64 } else { 0 };
        Ok(match kind {
            GeometryArg::Dag => counts,
            GeometryArg::Svo => {
                let stats = dag.stats().map_err(|bytes| BuildError::Memory { bytes: bytes as u64 })?;
                Svo::words_for(&stats).saturating_mul(4).saturating_add(counts)
            }
            // Per word of the DAG: 12 bytes for the places and counts of its nodes, and at most 12 for its copy.
            GeometryArg::Offsets | GeometryArg::Moxel => 24 * words,
            // Classes of nodes, with their forms in a hash set, and the words: 6 to 11 bytes a word of the DAG, measured.
            // There are fewer totals than counts.
            GeometryArg::Ssvdag => 16 * words + counts,
        })
    }

    /// Turns a DAG into the layout, with counts if `ranks` are asked for.
    pub fn new(dag: Arc<DagBuf>, kind: GeometryArg, ranks: bool) -> Result<Layout, BuildError> {
        let plain = dag.dag();
        let other = match kind {
            GeometryArg::Dag => None,
            GeometryArg::Ssvdag => Some(Other::Ssvdag(SsvdagBuf::build(&plain)?)),
            GeometryArg::Svo => Some(Other::Svo(SvoBuf::build(&plain, u32::MAX)?)),
            GeometryArg::Offsets => Some(Other::Offsets(OffsetsBuf::build(&plain)?)),
            GeometryArg::Moxel => Some(Other::MoxelDag(MoxelDagBuf::build(&plain)?)),
        };
        let counts = match &other {
            _ if !ranks => Vec::new(),
            None | Some(Other::Svo(_)) => Prefix::build(&plain)?,
            Some(Other::Ssvdag(ssvdag)) => Totals::build(&ssvdag.ssvdag())?,
            Some(Other::Offsets(_) | Other::MoxelDag(_)) => Vec::new(),
        };
        Ok(Layout { dag, other, counts })
    }

    /// The voxels.
    pub fn geometry(&self) -> AnyGeometry<'_> {
        match &self.other {
            None => AnyGeometry::Dag(self.dag.dag()),
            Some(Other::Ssvdag(ssvdag)) => AnyGeometry::Ssvdag(ssvdag.ssvdag()),
            Some(Other::Svo(svo)) => AnyGeometry::Svo(svo.as_svo()),
            Some(Other::Offsets(offsets)) => AnyGeometry::Offsets(offsets.as_offsets()),
            Some(Other::MoxelDag(moxels)) => AnyGeometry::MoxelDag(moxels.as_moxel_dag()),
        }
    }

    /// What numbers the voxels; `None` if that takes counts which were not asked for.
    pub fn rank(&self) -> Option<AnyRank<'_>> {
        match &self.other {
            None | Some(Other::Svo(_)) => Prefix::new(self.dag.dag(), &self.counts).ok().map(AnyRank::Prefix),
            Some(Other::Ssvdag(ssvdag)) => Totals::new(ssvdag.ssvdag(), &self.counts).ok().map(AnyRank::Totals),
            Some(Other::Offsets(offsets)) => Some(AnyRank::Offsets(offsets.as_offsets())),
            Some(Other::MoxelDag(moxels)) => Some(AnyRank::MoxelDag(moxels.as_moxel_dag())),
        }
    }

    /// Words that it holds, those of the DAG included.
    pub fn words(&self) -> usize {
        let other = if self.other.is_some() { self.geometry().words().len() } else { 0 };
        self.dag.words().len() + other + self.counts.len()
    }
}
