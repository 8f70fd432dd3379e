//! What is kept of the owners of voxels until all of them are known: one word a brick where its triangles agree.

use alloc::vec::Vec;

use super::SceneError;
use crate::dag::Dag;
use crate::material::MaterialId;
use crate::morton::Morton;
use crate::table::Entry;
use crate::voxelize::{Marked, Owner, VoxelizeError, Voxelizer};

/// The owners of voxels in Morton order, brick by brick.
#[derive(Default)]
pub(super) struct Owners {
    /// One word per brick: the material of all its voxels, or [`MIXED`].
    pub bricks: Vec<u32>,
    /// Of mixed bricks the material of each voxel.
    pub mixed: Vec<MaterialId>,
    /// Where normals are kept, one per voxel of any brick; zero where the owner has no area.
    pub normals: Vec<[f32; 3]>,
    /// Of voxels whose material has a texture.
    pub colors: Vec<[u8; 3]>,
}

/// In [`Owners::bricks`]: the owners of a brick's voxels are of several materials.
pub(super) const MIXED: u32 = u32::MAX;

/// Appends one list to another, or says how many bytes were refused.
fn extend<T: Copy>(list: &mut Vec<T>, more: &[T]) -> Result<(), SceneError> {
    list.try_reserve(more.len())
        .map_err(|_| SceneError::Voxelize(VoxelizeError::Memory { bytes: size_of_val(more) as u64 }))?;
    list.extend_from_slice(more);
    Ok(())
}

impl Owners {
    /// Bytes of the lists.
    pub fn bytes(&self) -> u64 {
        let Owners { bricks, mixed, normals, colors } = self;
        let lists = [size_of_val(&bricks[..]), size_of_val(&mixed[..]), size_of_val(&normals[..])];
        (lists.iter().sum::<usize>() + size_of_val(&colors[..])) as u64
    }

    pub fn push(
        &mut self,
        voxelizer: &Voxelizer<'_>,
        part: usize,
        brick: &Marked<'_>,
        normals: bool,
    ) -> Result<(), SceneError> {
        let uniform = voxelizer.uniform_material(brick);
        extend(&mut self.bricks, &[uniform.map_or(MIXED, u32::from)])?;
        let textured = voxelizer.may_have_colors(brick);
        if normals || textured || uniform.is_none() {
            let (mut ids, mut directions, mut count) = ([0; 64], [[0.0; 3]; 64], 0);
            let (mut colors, mut painted) = ([[0; 3]; 64], 0);
            voxelizer.owners(part, brick, |_, Owner { material, normal, color }| {
                ids[count] = material;
                let unit = crate::math::normalize(normal.map(|x| x as f64)).unwrap_or([0.0; 3]);
                directions[count] = unit.map(|x| x as f32);
                count += 1;
                if let Some(color) = color {
                    colors[painted] = color;
                    painted += 1;
                }
            });
            extend(&mut self.colors, &colors[..painted])?;
            if uniform.is_none() {
                extend(&mut self.mixed, &ids[..count])?;
            }
            if normals {
                extend(&mut self.normals, &directions[..count])?;
            }
        }
        Ok(())
    }

    pub fn append(&mut self, other: Owners) -> Result<(), SceneError> {
        extend(&mut self.bricks, &other.bricks)?;
        extend(&mut self.mixed, &other.mixed)?;
        extend(&mut self.colors, &other.colors)?;
        extend(&mut self.normals, &other.normals)
    }

    /// Every voxel of `dag`, in Morton order, with its entry.
    pub fn entries(&self, dag: &Dag<'_>) -> impl Iterator<Item = (Morton, Entry)> {
        let (mut mixed, mut normals) = (self.mixed.iter(), self.normals.iter());
        let mut bricks = dag.bricks().zip(&self.bricks);
        let (mut code, mut left, mut material) = (0, 0u64, 0);
        core::iter::from_fn(move || {
            if left == 0 {
                let ((next, mask), owner) = bricks.next()?;
                (code, left, material) = (next.0, mask, *owner);
            }
            let bit = left.trailing_zeros();
            left &= left - 1;
            let id = if material == MIXED { *mixed.next()? } else { material as MaterialId };
            Some((Morton(code | u64::from(bit)), Entry { material: id, normal: normals.next().copied() }))
        })
    }
}
