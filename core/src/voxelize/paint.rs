//! The colour of a voxel: the mean of its owner's texture over what the voxel cuts out of the triangle's plane.
//!
//! In: a triangle, a voxel. Out: sRGB bytes. The mean is over a square of a voxel's side in the plane, around the point of
//! the triangle that is nearest to the voxel's centre: of places spread evenly on it, those that lie in the triangle. Each
//! blends pixels of the halving in which the square is two to four pixels wide across, and as many places are taken along
//! either side as it takes to miss none, up to [`MOST`]. Corners are taken in the order of their snapped positions, so the
//! colour depends neither on the order of vertices nor on that of triangles.

use super::Voxelizer;
use super::owner::{bits, center};
use crate::color;
use crate::grid::SUB;
use crate::math;
use crate::texture::{Maps, Texture};

/// Most places along a side of the square.
const MOST: u32 = 8;

/// A triangle under its texture; lengths in voxels.
struct Patch {
    /// One corner, and from there to the other two.
    corner: [f64; 3],
    edges: [[f64; 3]; 2],
    uvs: [[f64; 2]; 3],
    /// Products of the edges, and their determinant: 0 for a triangle without area.
    products: [f64; 3],
    determinant: f64,
}

impl Voxelizer<'_> {
    /// The textures of a triangle's material.
    fn maps(&self, triangle: u32) -> Option<&Maps> {
        self.textures.get(usize::from(self.mesh.material(triangle as usize)))
    }

    /// The texture that colours a triangle.
    pub(super) fn texture(&self, triangle: u32) -> Option<&Texture> {
        self.maps(triangle)?.diffuse()
    }

    /// Of the voxels of a brick, the first of which is `first`, those that the triangle fills by half or more.
    pub(super) fn filled(&self, triangle: u32, first: [i64; 3], marked: u64) -> u64 {
        let Some(texture) = self.maps(triangle).and_then(Maps::dissolve) else { return marked };
        let paint = self.lay(triangle, texture);
        bits(marked).filter(|bit| paint.opacity(center(first, *bit)) >= 0.5).fold(0, |mask, bit| mask | 1 << bit)
    }

    /// Corners of a triangle with their texture coordinates, in the order of their positions.
    fn corners(&self, triangle: u32) -> [([i64; 3], [f32; 2]); 3] {
        let vertices = self.vertices(triangle as usize);
        let uvs = self.mesh.uvs.get(triangle as usize).copied().unwrap_or([[f32::NAN; 2]; 3]);
        let mut corners = [0, 1, 2].map(|i| (vertices[i], uvs[i]));
        corners.sort_unstable_by_key(|(position, uv)| (*position, uv.map(order)));
        corners
    }

    fn patch(&self, triangle: u32) -> Patch {
        let corners = self.corners(triangle);
        let [a, b, c] = corners.map(|(position, _)| position.map(|x| x as f64 / SUB as f64));
        let edges = [math::sub(b, a), math::sub(c, a)];
        let products = [math::dot(edges[0], edges[0]), math::dot(edges[0], edges[1]), math::dot(edges[1], edges[1])];
        let determinant = products[0] * products[2] - products[1] * products[1];
        Patch { corner: a, edges, uvs: corners.map(|(_, uv)| uv.map(f64::from)), products, determinant }
    }

    /// Whether of two triangles in one plane the first is the one that shows at `center` (in 1/256 voxels): the nearer one;
    /// of equally near ones that with the smaller corners, then with the smaller coordinates.
    pub(super) fn shows_before(&self, first: u32, second: u32, center: [i64; 3]) -> bool {
        let center = center.map(|x| x as f64 / SUB as f64);
        let distance = |triangle| {
            let patch = self.patch(triangle);
            let away = math::sub(center, patch.at(patch.nearest(center)));
            math::dot(away, away)
        };
        let key = |triangle| self.corners(triangle).map(|(position, uv)| (position, uv.map(order)));
        let (a, b) = (distance(first), distance(second));
        a < b || a == b && key(first) < key(second)
    }

    /// What colours the voxels that `triangle` owns; `None` without a texture.
    pub(super) fn paint(&self, triangle: u32) -> Option<Paint<'_>> {
        Some(self.lay(triangle, self.texture(triangle)?))
    }

    /// Lays a texture on a triangle.
    fn lay<'a>(&self, triangle: u32, texture: &'a Texture) -> Paint<'a> {
        let patch = self.patch(triangle);
        let has_uvs = patch.uvs.as_flattened().iter().all(|x| x.is_finite());
        let mut paint = Paint { texture, patch, has_uvs, tangents: [[0.0; 3]; 2], counts: [1; 2], level: 0 };
        let Some(tangents) = paint.patch.tangents() else { return paint };

        // Turn the square so that its sides are those along which the picture is finest and coarsest, and find out how many
        // pixels wide it is there; the map is the same everywhere on the triangle.
        let corner = paint.patch.corner;
        let here = paint.place(paint.patch.weights(corner));
        let [u, v] = tangents.map(|tangent| {
            let there = paint.place(paint.patch.weights(math::add_scaled(corner, tangent, 1.0)));
            [there[0] - here[0], there[1] - here[1]]
        });
        let product = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let (uu, uv, vv) = (product(u, u), product(u, v), product(v, v));
        let half = 0.5 * (uu - vv);
        let spread = math::sqrt(half * half + uv * uv);
        let along = if half > 0.0 { [half + spread, uv, 0.0] } else { [uv, spread - half, 0.0] };
        let [x, y, _] = math::normalize(along).unwrap_or([1.0, 0.0, 0.0]);
        let turned = |x: f64, y: f64| math::add_scaled(tangents[0].map(|t| x * t), tangents[1], y);
        let (finest, coarsest) = (0.5 * (uu + vv) + spread, (0.5 * (uu + vv) - spread).max(0.0));
        let wide = [finest, coarsest].map(math::sqrt);

        paint.level = texture.level((0.5 * wide[1]).max(0.5 * wide[0] / f64::from(MOST)));
        let pixels = f64::from(2u32 << paint.level);
        paint.counts = wide.map(|wide| ((wide / pixels) as u32).saturating_add(1).min(MOST));
        paint.tangents = [turned(x, y), turned(-y, x)];
        paint
    }
}

/// A triangle's texture, ready for voxels.
pub(super) struct Paint<'a> {
    texture: &'a Texture,
    patch: Patch,
    has_uvs: bool,
    /// Directions of the square's sides, and how many places are taken along each.
    tangents: [[f64; 3]; 2],
    counts: [u32; 2],
    level: usize,
}

impl Paint<'_> {
    /// Where on the picture the point is that shares of the corners make.
    fn place(&self, weights: [f64; 3]) -> [f64; 2] {
        self.texture.to_pixels(self.patch.uv(weights))
    }

    /// The colour of the voxel around `center` (in 1/256 voxels); white without texture coordinates.
    pub(super) fn color(&self, center: [i64; 3]) -> [u8; 3] {
        let sum = self.mean(center, |place| self.texture.read(place, self.level));
        let linear = sum.map_or([1.0; 3], |[r, g, b, weight]| [r, g, b].map(|x| x / weight));
        linear.map(|x| color::linear_to_srgb8(color::quantize(x as f32)))
    }

    /// How much of the surface is in the voxel around `center`, 0 to 1; all of it without texture coordinates.
    fn opacity(&self, center: [i64; 3]) -> f64 {
        self.mean(center, |place| [self.texture.opacity(place, self.level)]).map_or(1.0, |[opacity]| opacity)
    }

    /// The mean of what is read in a voxel; `None` without texture coordinates.
    #[inline]
    fn mean<const N: usize>(&self, center: [i64; 3], read: impl Fn([f64; 2]) -> [f64; N]) -> Option<[f64; N]> {
        if !self.has_uvs {
            return None;
        }
        let nearest = self.patch.nearest(center.map(|x| x as f64 / SUB as f64));
        let [columns, rows] = self.counts;
        if columns * rows == 1 {
            return Some(read(self.place(nearest)));
        }
        let middle = self.patch.at(nearest);
        let offset = |i: u32, count: u32| (f64::from(i) + 0.5) / f64::from(count) - 0.5;
        let (mut sum, mut count) = ([0.0; N], 0);
        for row in 0..rows {
            let line = math::add_scaled(middle, self.tangents[1], offset(row, rows));
            for column in 0..columns {
                let weights = self.patch.weights(math::add_scaled(line, self.tangents[0], offset(column, columns)));
                if weights.iter().all(|w| *w >= 0.0) {
                    sum.iter_mut().zip(read(self.place(weights))).for_each(|(sum, value)| *sum += value);
                    count += 1;
                }
            }
        }
        Some(if count == 0 { read(self.place(nearest)) } else { sum.map(|x| x / f64::from(count)) })
    }
}

/// Numbers in an order that has a place for each.
fn order(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    if bits < 0 { bits ^ i32::MAX } else { bits }
}

impl Patch {
    /// The point that shares of the corners make.
    fn at(&self, [_, b, c]: [f64; 3]) -> [f64; 3] {
        math::add_scaled(math::add_scaled(self.corner, self.edges[0], b), self.edges[1], c)
    }

    /// Texture coordinates of the point that shares of the corners make.
    fn uv(&self, [a, b, c]: [f64; 3]) -> [f64; 2] {
        [0, 1].map(|i| a * self.uvs[0][i] + b * self.uvs[1][i] + c * self.uvs[2][i])
    }

    /// Shares of the corners that make the point of the plane under `point`; the triangle must have an area.
    fn weights(&self, point: [f64; 3]) -> [f64; 3] {
        let from = math::sub(point, self.corner);
        let [p, q] = self.edges.map(|edge| math::dot(from, edge));
        let [bb, bc, cc] = self.products;
        let b = (p * cc - q * bc) / self.determinant;
        let c = (q * bb - p * bc) / self.determinant;
        [1.0 - b - c, b, c]
    }

    /// Shares of the corners that make the triangle's point nearest to `point`.
    fn nearest(&self, point: [f64; 3]) -> [f64; 3] {
        if self.determinant > 0.0 {
            let weights = self.weights(point);
            if weights.iter().all(|w| *w >= 0.0) {
                return weights;
            }
        }
        // It is on a side: of each the nearest point, and of these the nearest.
        let corners = [self.corner, self.at([0.0, 1.0, 0.0]), self.at([0.0, 0.0, 1.0])];
        let sides = [[0, 1], [0, 2], [1, 2]].map(|[i, j]| {
            let side = math::sub(corners[j], corners[i]);
            let length = math::dot(side, side);
            let along = math::dot(math::sub(point, corners[i]), side);
            let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
            let mut weights = [0.0; 3];
            (weights[i], weights[j]) = (1.0 - t, t);
            let away = math::sub(point, self.at(weights));
            (math::dot(away, away), weights)
        });
        let [first, others @ ..] = sides;
        others.into_iter().fold(first, |best, side| if side.0 < best.0 { side } else { best }).1
    }

    /// Two directions of unit length in the plane, at right angles; `None` for a triangle without area.
    fn tangents(&self) -> Option<[[f64; 3]; 2]> {
        let normal = math::normalize(math::cross(self.edges[0], self.edges[1]))?;
        let along = math::normalize(self.edges[0])?;
        (self.determinant > 0.0).then(|| [along, math::cross(normal, along)])
    }
}
