//! Which material a voxel has, beside a geometry that knows none. One type per representation; renderers are generic over
//! it, and the edge matches on [`AnyMaterials`] once per call.

use crate::material::MaterialId;
use crate::morton::Morton;
use crate::rank::AnyRank;
#[cfg(feature = "alloc")]
use crate::ranked::RankedError;
use crate::ranked::{Moxels, Packed, Palettes, Ranked, Values};
use crate::table::Table;
use crate::tree::Tree;

/// Look-ups by voxel. A representation that needs the geometry for them (ranks) holds a view of it. They are total: a voxel
/// that the representation does not know has material 0 and no normal.
pub trait Materials: Copy + Sync {
    /// Index into the scene's materials.
    fn id(&self, voxel: Morton) -> MaterialId;

    /// The outward unit normal stored with the voxel; `None` if there is none.
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]>;

    /// The colour that its texture has there, sRGB bytes; `None` if there is none. Asked for where the material is
    /// [`textured`](crate::Material::textured).
    #[inline]
    fn color(&self, _voxel: Morton) -> Option<[u8; 3]> {
        None
    }
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

/// Every representation of materials.
#[derive(Clone, Copy, Debug)]
pub enum AnyMaterials<'a> {
    /// One material for all voxels.
    Single(Single),
    /// A material per voxel, with or without a normal.
    Table(Table<'a>),
    /// A material per cube of space.
    Tree(Tree<'a>),
    /// Packed ids by rank.
    Ranked(Ranked<AnyRank<'a>, Packed<'a>>),
    /// Blocks of ids by rank, each with a palette of its own; not for files.
    Palettes(Ranked<AnyRank<'a>, Palettes<'a>>),
    /// Williams's moxel table, with or without normals; not for files.
    Moxels(Ranked<AnyRank<'a>, Moxels<'a>>),
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
    /// See [`Packed`].
    Ranked(crate::ranked::PackedBuf),
    /// See [`Palettes`].
    Palettes(crate::ranked::PalettesBuf),
    /// See [`Moxels`].
    Moxels(crate::ranked::MoxelsBuf),
}

#[cfg(feature = "alloc")]
impl MaterialsBuf {
    /// Whether look-ups go by rank.
    pub fn needs_rank(&self) -> bool {
        matches!(self, MaterialsBuf::Ranked(_) | MaterialsBuf::Palettes(_) | MaterialsBuf::Moxels(_))
    }

    /// The words, less those of ranks; none for a single material.
    pub fn words(&self) -> &[u32] {
        match self {
            MaterialsBuf::Single(_) => &[],
            MaterialsBuf::Table(table) => table.as_table().words(),
            MaterialsBuf::Tree(tree) => tree.tree().words(),
            MaterialsBuf::Ranked(ids) => ids.as_packed().words(),
            MaterialsBuf::Palettes(ids) => ids.as_palettes().words(),
            MaterialsBuf::Moxels(moxels) => moxels.as_moxels().words(),
        }
    }

    /// The view that answers look-ups: by `rank` where [`MaterialsBuf::needs_rank`]. An error if it is of other voxels, or
    /// missing, which counts as no voxel.
    pub fn as_materials<'a>(&'a self, rank: Option<AnyRank<'a>>) -> Result<AnyMaterials<'a>, RankedError> {
        let rank = |found| rank.ok_or(RankedError::Voxels { expected: 0, found });
        Ok(match self {
            MaterialsBuf::Single(single) => AnyMaterials::Single(*single),
            MaterialsBuf::Table(table) => AnyMaterials::Table(table.as_table()),
            MaterialsBuf::Tree(tree) => AnyMaterials::Tree(tree.tree()),
            MaterialsBuf::Ranked(ids) => {
                let ids = ids.as_packed();
                AnyMaterials::Ranked(Ranked::new(rank(ids.count())?, ids)?)
            }
            MaterialsBuf::Palettes(ids) => {
                let ids = ids.as_palettes();
                AnyMaterials::Palettes(Ranked::new(rank(ids.count())?, ids)?)
            }
            MaterialsBuf::Moxels(moxels) => {
                let moxels = moxels.as_moxels();
                AnyMaterials::Moxels(Ranked::new(rank(moxels.count())?, moxels)?)
            }
        })
    }
}

impl<'a> AnyMaterials<'a> {
    /// The words, less those of ranks; none for a single material.
    pub fn words(&self) -> &'a [u32] {
        match self {
            AnyMaterials::Single(_) => &[],
            AnyMaterials::Table(table) => table.words(),
            AnyMaterials::Tree(tree) => tree.words(),
            AnyMaterials::Ranked(ids) => ids.values().words(),
            AnyMaterials::Palettes(ids) => ids.values().words(),
            AnyMaterials::Moxels(moxels) => moxels.values().words(),
        }
    }

    /// What look-ups go by, if they go by rank.
    pub fn rank(&self) -> Option<AnyRank<'a>> {
        match self {
            AnyMaterials::Single(_) | AnyMaterials::Table(_) | AnyMaterials::Tree(_) => None,
            AnyMaterials::Ranked(ids) => Some(ids.rank()),
            AnyMaterials::Palettes(ids) => Some(ids.rank()),
            AnyMaterials::Moxels(moxels) => Some(moxels.rank()),
        }
    }

    /// The words of the counts that ranks go by, as a file holds them; none where there are none, or only in the geometry.
    pub fn count_words(&self) -> &'a [u32] {
        self.rank().and_then(|rank| rank.words()).unwrap_or(&[])
    }

    /// Whether voxels have normals of their own.
    pub fn has_normals(&self) -> bool {
        match self {
            AnyMaterials::Table(table) => table.has_normals(),
            AnyMaterials::Moxels(moxels) => moxels.values().has_normals(),
            _ => false,
        }
    }

    /// No voxel's material id is above this one.
    pub fn max_material(&self) -> MaterialId {
        match self {
            AnyMaterials::Single(single) => single.0,
            AnyMaterials::Table(table) => table.max_material(),
            AnyMaterials::Tree(tree) => tree.max_material(),
            AnyMaterials::Ranked(ids) => ids.values().max_material(),
            AnyMaterials::Palettes(ids) => ids.values().max_material(),
            AnyMaterials::Moxels(moxels) => moxels.values().max_material(),
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
            AnyMaterials::Ranked(ids) => ids.id(voxel),
            AnyMaterials::Palettes(ids) => ids.id(voxel),
            AnyMaterials::Moxels(moxels) => moxels.id(voxel),
        }
    }

    #[inline]
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        match self {
            AnyMaterials::Table(table) => table.normal(voxel),
            AnyMaterials::Moxels(moxels) => moxels.normal(voxel),
            _ => None,
        }
    }
}
