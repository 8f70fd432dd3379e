//! The colour of a voxel: the mean of its owner's texture over what the voxel cuts out of the triangle's plane.
//!
//! In: a triangle, a voxel. Out: sRGB bytes. The mean is that of [`TAPS`]^2 places on a square of a voxel's side in the
//! plane, around the point of the triangle that is nearest to the voxel's centre, of those that lie in the triangle; each
//! reads the halving of the picture in which the places are a pixel or two apart. Corners are taken in the order of their
//! snapped positions, so the colour depends neither on the order of vertices nor on that of triangles.

use super::Voxelizer;
use crate::color;
use crate::grid::SUB;
use crate::math;
use crate::texture::Texture;

/// Places along a side of the square.
const TAPS: usize = 4;

/// The square's colour where a triangle has no texture coordinates.
const WHITE: [u8; 3] = [255; 3];

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
    /// The texture of a triangle's material.
    pub(super) fn texture(&self, triangle: u32) -> Option<&Texture> {
        self.textures.get(usize::from(self.mesh.material(triangle as usize)))?.as_ref()
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

    /// The colour of the voxel around `center` (in 1/256 voxels), which `triangle` owns; `None` without a texture.
    pub(super) fn color(&self, triangle: u32, center: [i64; 3]) -> Option<[u8; 3]> {
        let texture = self.texture(triangle)?;
        let patch = self.patch(triangle);
        if !patch.uvs.as_flattened().iter().all(|x| x.is_finite()) {
            return Some(WHITE);
        }
        let nearest = patch.nearest(center.map(|x| x as f64 / SUB as f64));
        let place = |weights: [f64; 3]| texture.to_pixels(patch.uv(weights));
        let Some(tangents) = patch.tangents() else {
            return Some(encoded(texture.read(place(nearest), 0)));
        };

        // How far apart the places are on the picture.
        let (here, middle) = (place(nearest), patch.at(nearest));
        let step = tangents.map(|tangent| {
            let there = place(patch.weights(math::add_scaled(middle, tangent, 1.0 / TAPS as f64)));
            let [x, y] = [there[0] - here[0], there[1] - here[1]];
            math::sqrt(x * x + y * y)
        });
        let level = texture.level(step[0].max(step[1]));

        let (mut sum, mut count) = ([0.0; 3], 0);
        let offset = |i: usize| (i as f64 + 0.5) / TAPS as f64 - 0.5;
        for i in 0..TAPS * TAPS {
            let point = math::add_scaled(middle, tangents[0], offset(i % TAPS));
            let weights = patch.weights(math::add_scaled(point, tangents[1], offset(i / TAPS)));
            if weights.iter().all(|w| *w >= 0.0) {
                sum = math::add_scaled(sum, texture.read(place(weights), level), 1.0);
                count += 1;
            }
        }
        Some(encoded(if count == 0 { texture.read(here, level) } else { sum.map(|x| x / f64::from(count)) }))
    }
}

/// Numbers in an order that has a place for each.
fn order(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    if bits < 0 { bits ^ i32::MAX } else { bits }
}

/// A linear colour in sRGB bytes.
fn encoded(linear: [f64; 3]) -> [u8; 3] {
    linear.map(|x| color::linear_to_srgb8(color::quantize(x as f32)))
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
