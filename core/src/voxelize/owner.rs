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

/// What a voxel takes over from the triangle that owns it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Owner {
    /// Its material.
    pub material: MaterialId,
    /// Its normal: integer, not of unit length, the first component that is not 0 positive; 0 if it has no area.
    pub normal: [i64; 3],
    /// The colour of its texture in the voxel, sRGB; `None` if its material has none.
    pub color: Option<[u8; 3]>,
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

    /// Whether a voxel of the brick may be owned by a triangle with a texture.
    pub fn may_have_colors(&self, brick: &Marked<'_>) -> bool {
        !self.textures.is_empty() && brick.triangles.iter().any(|(triangle, _)| self.texture(*triangle).is_some())
    }

    /// Calls `each` with every marked voxel's bit and its owner, in Morton order.
    pub fn owners(&self, subtree: usize, brick: &Marked<'_>, mut each: impl FnMut(u32, Owner)) {
        let base = Morton(self.subtree_code(subtree).0 | brick.code.0).decode().map(i64::from);
        let mut best: [Option<(f64, Plane, u32)>; 64] = [None; 64];
        for &(triangle, mask) in brick.triangles {
            let plane = self.plane(triangle);
            for bit in bits(mask) {
                let distance = plane.distance(center(base, bit));
                let nearer = match &best[bit] {
                    None => true,
                    Some((d, other, owner)) if distance == *d => match plane.before(other) {
                        // Of one plane and material: which of them it is matters to textures only.
                        Ordering::Equal => {
                            self.texture(triangle).is_some() && self.shows_before(triangle, *owner, center(base, bit))
                        }
                        order => order.is_lt(),
                    },
                    Some((d, ..)) => distance < *d,
                };
                if nearer {
                    best[bit] = Some((distance, plane, triangle));
                }
            }
        }
        // Neighbours mostly have one owner.
        let mut last = None;
        for bit in bits(brick.mask) {
            if let Some((_, Plane { material, normal, .. }, triangle)) = best[bit] {
                let (_, paint) = match last.take().filter(|(known, _)| *known == triangle) {
                    Some(paint) => last.insert(paint),
                    None => last.insert((triangle, self.paint(triangle))),
                };
                each(bit as u32, Owner { material, normal, color: paint.as_ref().map(|p| p.color(center(base, bit))) });
            }
        }
    }
}

/// Centre of a voxel of the brick whose first voxel is `first`, in 1/256 voxels.
pub(super) fn center(first: [i64; 3], bit: usize) -> [i64; 3] {
    let cell = cell_of(bit);
    core::array::from_fn(|i| SUB * (first[i] + cell[i] as i64) + SUB / 2)
}

/// The set bits of a mask, ascending.
pub(super) fn bits(mask: u64) -> impl Iterator<Item = usize> {
    let mut left = mask;
    core::iter::from_fn(move || {
        let bit = left.trailing_zeros() as usize;
        left &= left.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}
