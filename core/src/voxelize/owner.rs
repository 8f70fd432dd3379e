//! Who owns a voxel that several triangles marked: the one whose plane is nearest to the voxel's centre.
//!
//! Distances are f64, from the snapped vertices in lexicographic order, so that neither the order of triangles nor that of
//! their vertices matters; a triangle without area counts as farthest. Ties go by the material's name, then by the integer
//! normal with canonical sign. What the thesis does (section 4.2.2: the last writer) depends on thread timing.

use core::cmp::Ordering;

use super::prism::{cell_of, normal};
use super::{Marked, Voxelizer};
use crate::grid::SUB;
use crate::material::MaterialId;

/// The plane of a triangle, ready for distances.
#[derive(Clone, Copy)]
struct Plane {
    corner: [i64; 3],
    normal: [i64; 3],
    length: f64,
    material: MaterialId,
    /// Place of the material's name among all names.
    name: u16,
}

impl Plane {
    fn distance(&self, center: [i64; 3]) -> f64 {
        if self.length == 0.0 {
            return f64::INFINITY;
        }
        let r: [f64; 3] = core::array::from_fn(|i| (center[i] - self.corner[i]) as f64);
        crate::math::dot(self.normal.map(|x| x as f64), r).abs() / self.length
    }

    fn before(&self, other: &Plane) -> Ordering {
        self.name.cmp(&other.name).then(self.normal.cmp(&other.normal))
    }
}

impl Voxelizer<'_> {
    /// The plane of a triangle; its normal points so that its first component that is not 0 is positive.
    fn plane(&self, triangle: u32) -> Plane {
        let mut v = self.vertices(triangle as usize);
        v.sort_unstable();
        let mut normal = normal(&v);
        if normal < [0; 3] {
            normal = normal.map(|x| -x);
        }
        let n = normal.map(|x| x as f64);
        let material = self.mesh.material(triangle as usize);
        let name = self.mesh.name_order.get(usize::from(material)).copied().unwrap_or(material);
        Plane { corner: v[0], normal, length: crate::math::sqrt(crate::math::dot(n, n)), material, name }
    }

    /// The one material of a brick's voxels, if its triangles agree.
    pub fn uniform_material(&self, brick: &Marked<'_>) -> Option<MaterialId> {
        let material = |(t, _): &(u32, u64)| self.mesh.material(*t as usize);
        let first = brick.triangles.first().map(material)?;
        brick.triangles.iter().all(|t| material(t) == first).then_some(first)
    }

    /// Calls `each` with every marked voxel's bit, its owner's material and its owner's normal (integer, not of unit
    /// length, its first component that is not 0 positive; 0 if the owner has no area), in Morton order.
    pub fn owners(&self, subtree: usize, brick: &Marked<'_>, mut each: impl FnMut(u32, MaterialId, [i64; 3])) {
        let base = crate::morton::Morton(self.subtree_code(subtree).0 | brick.code.0).decode().map(i64::from);
        let mut left = brick.mask;
        // One triangle at a time would ask for memory; one voxel at a time asks for its planes again, which is cheap.
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            let cell = cell_of(bit as usize);
            let center = core::array::from_fn(|i| SUB * (base[i] + cell[i] as i64) + SUB / 2);
            let mut owner: Option<(f64, Plane)> = None;
            for &(triangle, mask) in brick.triangles {
                if mask >> bit & 1 == 0 {
                    continue;
                }
                let plane = self.plane(triangle);
                let distance = plane.distance(center);
                let nearer = match &owner {
                    None => true,
                    Some((d, best)) => distance < *d || distance == *d && plane.before(best).is_lt(),
                };
                if nearer {
                    owner = Some((distance, plane));
                }
            }
            if let Some((_, plane)) = owner {
                each(bit, plane.material, plane.normal);
            }
        }
    }
}
