//! Who owns a voxel that several triangles marked: the one whose plane is nearest to the voxel's centre.
//!
//! A distance is an exact integer, rounded to f64 and divided by the normal's length, so that neither the order of
//! triangles nor that of their vertices matters, and triangles of one plane tie; one without area counts as farthest. Ties
//! go by the material's name, then by the integer normal with canonical sign. What the thesis does (section 4.2.2: the last writer) depends on thread timing.

use core::cmp::Ordering;

use super::prism::{cell_of, normal};
use super::{Marked, Voxelizer};
use crate::grid::SUB;
use crate::material::MaterialId;
use crate::morton::Morton;

/// The plane of a triangle, ready for distances.
#[derive(Clone, Copy)]
struct Plane {
    /// The same for all triangles of one plane: no common divisor, the first component that is not 0 positive.
    normal: [i64; 3],
    /// `normal . corner`.
    offset: i128,
    /// Length of the normal; 0 for a triangle without area.
    length: f64,
    material: MaterialId,
    /// Place of the material's name among all names.
    name: u16,
}

impl Plane {
    /// From the plane to `center`, in 1/256 voxels. The sum is exact, so triangles of one plane are equally far.
    fn distance(&self, center: [i64; 3]) -> f64 {
        if self.length == 0.0 {
            return f64::INFINITY;
        }
        let along: i128 = (0..3).map(|i| i128::from(self.normal[i]) * i128::from(center[i])).sum();
        (along - self.offset).unsigned_abs() as f64 / self.length
    }

    fn before(&self, other: &Plane) -> Ordering {
        self.name.cmp(&other.name).then(self.normal.cmp(&other.normal))
    }
}

/// Greatest common divisor; `gcd(0, 0) = 0`.
fn gcd(a: u64, b: u64) -> u64 {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl Voxelizer<'_> {
    fn plane(&self, triangle: u32) -> Plane {
        let v = self.vertices(triangle as usize);
        let mut normal = normal(&v);
        let divisor = normal.iter().fold(0, |d, x| gcd(d, x.unsigned_abs())).max(1) as i64;
        let sign = if normal < [0; 3] { -divisor } else { divisor };
        normal = normal.map(|x| x / sign);
        let n = normal.map(|x| x as f64);
        let material = self.mesh.material(triangle as usize);
        let name = self.mesh.name_order.get(usize::from(material)).copied().unwrap_or(material);
        let offset = (0..3).map(|i| i128::from(normal[i]) * i128::from(v[0][i])).sum();
        Plane { normal, offset, length: crate::math::sqrt(crate::math::dot(n, n)), material, name }
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
        let base = Morton(self.subtree_code(subtree).0 | brick.code.0).decode().map(i64::from);
        let mut best: [Option<(f64, Plane)>; 64] = [None; 64];
        for &(triangle, mask) in brick.triangles {
            let plane = self.plane(triangle);
            for bit in bits(mask) {
                let cell = cell_of(bit);
                let distance = plane.distance(core::array::from_fn(|i| SUB * (base[i] + cell[i] as i64) + SUB / 2));
                let nearer = match &best[bit] {
                    None => true,
                    Some((d, other)) => distance < *d || distance == *d && plane.before(other).is_lt(),
                };
                if nearer {
                    best[bit] = Some((distance, plane));
                }
            }
        }
        for bit in bits(brick.mask) {
            if let Some((_, plane)) = &best[bit] {
                each(bit as u32, plane.material, plane.normal);
            }
        }
    }
}

/// The set bits of a mask, ascending.
fn bits(mask: u64) -> impl Iterator<Item = usize> {
    let mut left = mask;
    core::iter::from_fn(move || {
        let bit = left.trailing_zeros() as usize;
        left &= left.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}
