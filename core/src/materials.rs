//! Which material a voxel has, beside a DAG that knows geometry only. One type per representation; renderers are generic
//! over it, and the edge matches on [`AnyMaterials`] once per call.

use crate::material::MaterialId;
use crate::morton::Morton;
use crate::table::Table;
use crate::tree::Tree;

/// Look-ups by voxel. A representation that needs the geometry for them (ranks) holds a view of it. They are total: a voxel that the representation does not know has material 0 and no normal.
pub trait Materials: Copy + Sync {
    /// Index into the scene's materials.
    fn id(&self, voxel: Morton) -> MaterialId;

    /// The outward unit normal stored with the voxel; `None` if there is none.
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]>;
}

/// One material for all voxels.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Single(pub MaterialId);

impl Materials for Single {
    #[inline]
    fn id(&self, _: Morton) -> MaterialId {
        self.0
    }

    #[inline]
    fn normal(&self, _: Morton) -> Option<[f32; 3]> {
        None
    }
}

impl Materials for Table<'_> {
    #[inline]
    fn id(&self, voxel: Morton) -> MaterialId {
        self.get(voxel).map_or(0, |entry| entry.material)
    }

    #[inline]
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
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
    /// A material per cube of space.
    Tree(Tree<'a>),
}

/// A representation that owns its words.
#[cfg(feature = "alloc")]
#[derive(PartialEq, Debug)]
pub enum MaterialsBuf {
    /// One material for all voxels.
    Single(Single),
    /// See [`Table`].
    Table(crate::table::TableBuf),
    /// See [`Tree`].
    Tree(crate::tree::TreeBuf),
}

#[cfg(feature = "alloc")]
impl MaterialsBuf {
    /// The view that answers look-ups.
    pub fn as_materials(&self) -> AnyMaterials<'_> {
        match self {
            MaterialsBuf::Single(single) => AnyMaterials::Single(*single),
            MaterialsBuf::Table(table) => AnyMaterials::Table(table.as_table()),
            MaterialsBuf::Tree(tree) => AnyMaterials::Tree(tree.tree()),
        }
    }
}

impl<'a> AnyMaterials<'a> {
    /// The words as they stand in a file; none for a single material.
    pub fn words(&self) -> &'a [u32] {
        match self {
            AnyMaterials::Single(_) => &[],
            AnyMaterials::Table(table) => table.words(),
            AnyMaterials::Tree(tree) => tree.words(),
        }
    }

    /// Whether voxels have normals of their own.
    pub fn has_normals(&self) -> bool {
        matches!(self, AnyMaterials::Table(table) if table.has_normals())
    }

    /// No voxel's material id is above this one.
    pub fn max_material(&self) -> MaterialId {
        match self {
            AnyMaterials::Single(single) => single.0,
            AnyMaterials::Table(table) => table.max_material(),
            AnyMaterials::Tree(tree) => tree.max_material(),
        }
    }
}

impl Materials for AnyMaterials<'_> {
    #[inline]
    fn id(&self, voxel: Morton) -> MaterialId {
        match self {
            AnyMaterials::Single(single) => single.id(voxel),
            AnyMaterials::Table(table) => table.id(voxel),
            AnyMaterials::Tree(tree) => tree.id(voxel),
        }
    }

    #[inline]
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        match self {
            AnyMaterials::Single(single) => single.normal(voxel),
            AnyMaterials::Table(table) => table.normal(voxel),
            AnyMaterials::Tree(tree) => tree.normal(voxel),
        }
    }
}
