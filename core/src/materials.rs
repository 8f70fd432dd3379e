//! Which material a voxel has, beside a DAG that knows geometry only. One type per representation; renderers are generic
//! over it, and the edge matches on [`AnyMaterials`] once per call.

use crate::dag::Dag;
use crate::material::MaterialId;
use crate::morton::Morton;
use crate::table::Table;

/// Look-ups by voxel. They are total: a voxel that the representation does not know has material 0 and no normal.
pub trait Materials: Copy + Sync {
    /// Index into the scene's materials.
    fn id(&self, dag: Dag<'_>, voxel: Morton) -> MaterialId;

    /// The outward unit normal stored with the voxel; `None` if there is none.
    fn normal(&self, dag: Dag<'_>, voxel: Morton) -> Option<[f32; 3]>;
}

/// One material for all voxels.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Single(pub MaterialId);

impl Materials for Single {
    #[inline]
    fn id(&self, _: Dag<'_>, _: Morton) -> MaterialId {
        self.0
    }

    #[inline]
    fn normal(&self, _: Dag<'_>, _: Morton) -> Option<[f32; 3]> {
        None
    }
}

impl Materials for Table<'_> {
    #[inline]
    fn id(&self, _: Dag<'_>, voxel: Morton) -> MaterialId {
        self.get(voxel).map_or(0, |entry| entry.material)
    }

    #[inline]
    fn normal(&self, _: Dag<'_>, voxel: Morton) -> Option<[f32; 3]> {
        self.get(voxel)?.normal
    }
}

/// Every representation that a file may hold.
#[derive(Clone, Copy, Debug)]
pub enum AnyMaterials<'a> {
    /// One material for all voxels.
    Single(Single),
    /// A material per voxel, with or without a normal.
    Table(Table<'a>),
}

impl AnyMaterials<'_> {
    /// No voxel's material id is above this one.
    pub fn max_material(&self) -> MaterialId {
        match self {
            AnyMaterials::Single(single) => single.0,
            AnyMaterials::Table(table) => table.max_material(),
        }
    }
}

impl Materials for AnyMaterials<'_> {
    fn id(&self, dag: Dag<'_>, voxel: Morton) -> MaterialId {
        match self {
            AnyMaterials::Single(single) => single.id(dag, voxel),
            AnyMaterials::Table(table) => table.id(dag, voxel),
        }
    }

    fn normal(&self, dag: Dag<'_>, voxel: Morton) -> Option<[f32; 3]> {
        match self {
            AnyMaterials::Single(single) => single.normal(dag, voxel),
            AnyMaterials::Table(table) => table.normal(dag, voxel),
        }
    }
}
