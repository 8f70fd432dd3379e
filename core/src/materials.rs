//! Which material a voxel has: the one trait behind every material scheme.
//!
//! In: a DAG and a filled voxel of it. Out: an index into the scene's list of materials and, where the scheme keeps
//! normals, the voxel's. The DAG itself knows no materials (Pineda 2021, section 4.2, keeps them apart for the same reason).

use crate::dag::Dag;
use crate::material::MaterialId;
use crate::morton::Morton;

/// A material scheme. A voxel that is not filled has no meaning here: any answer will do, but no panic.
pub trait Materials: Copy + Sync {
    /// The material of a filled voxel.
    fn id(&self, dag: Dag<'_>, voxel: Morton) -> MaterialId;

    /// The normal kept for a filled voxel, of any length and either side; `None` if the scheme keeps none.
    fn normal(&self, dag: Dag<'_>, voxel: Morton) -> Option<[f32; 3]>;
}

/// One material for everything, no normals.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Single(pub MaterialId);

impl Materials for Single {
    fn id(&self, _: Dag<'_>, _: Morton) -> MaterialId {
        self.0
    }

    fn normal(&self, _: Dag<'_>, _: Morton) -> Option<[f32; 3]> {
        None
    }
}
