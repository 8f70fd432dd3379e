//! Rays against the triangles of a mesh.
//!
//! In: a mesh that was validated. Out: the nearest triangle, decided in f64 for the corners as they are in the file.
//! The boxes around the triangles and the walk through them are the library's, in f32: rays start and boxes are padded
//! so that the walk never misses what the ray meets (see [`PAD`]).
//!
//! The test is that of Woop, Benthin and Wald (2013, "Watertight Ray/Triangle Intersection"), with f64 for their f32:
//! the corners are sheared along the ray into a plane, each the same for all triangles that share it, and the signs of
//! three edge functions decide. `a b - c d` of rounded products has the sign of the true one or is 0, and 0 counts as
//! inside: no ray passes between two triangles. Of triangles met at one time the first of the file counts, however the
//! boxes lie.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::{Ray, RayHit};
use voxdag::{Mesh, math};

use super::{Met, Truth, facing, towards_viewer};
use crate::error::{Error, Kind, Result};
use crate::memory::Memory;

/// How far boxes reach beyond their triangles, where the mesh's box reaches from -1 to 1. Rays start at most 2 sqrt(2)
/// from the middle and end within 4 of their start; so what rounding to f32 does to the start, the direction, its
/// inverse (the library takes components below 2^-23 for that) and the distances moves a box's sides by less than
/// 2^-19.
const PAD: f64 = 1.0 / (1 << 17) as f64;
/// Radius of a ball around the middle that holds the mesh's box, and a little more.
const BALL: f64 = 2.0;
/// Bytes that a triangle takes while the boxes are built: two nodes, its corners, and what the library takes for both.
const BYTES: u64 = 500;

/// A mesh as rays meet it.
pub struct MeshTruth<'a> {
    mesh: Mesh<'a>,
    boxes: Bvh2,
    /// Triangles in the order of the boxes' leaves: corners, and which of the mesh they are.
    triangles: Vec<([[f64; 3]; 3], u32)>,
    frame: Unit,
}

/// From the world to coordinates in which the mesh's box reaches from -1 to 1.
#[derive(Clone, Copy)]
struct Unit {
    center: [f64; 3],
    scale: f64,
}

impl Unit {
    fn of(self, p: [f64; 3]) -> [f64; 3] {
        math::sub(p, self.center).map(|x| x * self.scale)
    }

    /// The same half line for the boxes, from where it may first meet one, and what takes its time to theirs; `None` if
    /// it stays away from them, or has no direction.
    fn ray(self, origin: [f64; 3], dir: [f64; 3]) -> Option<(Ray, impl Fn(f64) -> f32)> {
        let (start, unit) = (self.of(origin), math::normalize(dir)?);
        let middle = -math::dot(start, unit);
        let closest = math::add_scaled(start, unit, middle);
        let skipped = (middle - BALL).max(0.0);
        let start = math::add_scaled(start, unit, skipped);
        // It passes by the ball or leaves it behind, or its numbers are none.
        if !(math::dot(closest, closest) <= BALL * BALL && middle >= -BALL) {
            return None;
        }
        let length = math::sqrt(math::dot(dir, dir)) * self.scale;
        let time = move |t: f64| (t * length - skipped) as f32;
        Some((Ray::new_inf(start.map(|x| x as f32).into(), unit.map(|x| x as f32).into()), time))
    }

    /// The box of a triangle, padded.
    fn boxed(self, corners: &[[f64; 3]; 3]) -> Aabb {
        let corners = corners.map(|p| self.of(p));
        let side = |pad: f64, pick: fn(f64, f64) -> f64| {
            let extreme = |i: usize| pick(pick(corners[0][i], corners[1][i]), corners[2][i]);
            [0, 1, 2].map(|i| (extreme(i) + pad) as f32)
        };
        Aabb::new(side(-PAD, f64::min).into(), side(PAD, f64::max).into())
    }
}

impl<'a> MeshTruth<'a> {
    /// Sorts the triangles of a mesh into boxes. The mesh must be valid.
    pub fn new(mesh: Mesh<'a>, memory: &Memory) -> Result<MeshTruth<'a>> {
        let bounds = mesh.validate().map_err(|error| Error::new(Kind::BadInput, error))?;
        let bytes = BYTES * mesh.triangles.len() as u64;
        memory.afford(bytes, "the ground truth", "raise --memory-limit, or take a mesh of fewer triangles")?;
        // Of a single point, and of sizes at the ends of f64, there is nothing to scale.
        let scale = Some(2.0 / bounds.extent()).filter(|scale| scale.is_normal()).unwrap_or(1.0);
        let frame = Unit { center: bounds.center(), scale };
        let corners = |t: usize| mesh.triangles[t].map(|vertex| mesh.positions[vertex as usize]);
        let padded: Vec<Aabb> = (0..mesh.triangles.len()).map(|t| frame.boxed(&corners(t))).collect();
        let boxes = build_bvh2(&padded, BvhBuildParams::medium_build(), &mut Default::default());
        let triangles = boxes.primitive_indices.iter().map(|&t| (corners(t as usize), t)).collect();
        Ok(MeshTruth { mesh, boxes, triangles, frame })
    }

    /// The normal that the mesh gives at a point of a triangle, not of unit length; `None` if it gives none.
    fn interpolated(&self, triangle: u32, weights: [f64; 3]) -> Option<[f64; 3]> {
        let corners = self.mesh.normals.get(triangle as usize)?;
        let sum = |i: usize| (0..3).map(|corner| weights[corner] * f64::from(corners[corner][i])).sum::<f64>();
        Some([0, 1, 2].map(sum)).filter(|n| n.iter().all(|x| x.is_finite()))
    }
}

impl Truth for MeshTruth<'_> {
    fn nearest(&self, origin: [f64; 3], dir: [f64; 3]) -> Option<Met> {
        let (ray, time) = self.frame.ray(origin, dir)?;
        let shear = Shear::new(origin, dir);
        let mut best: Option<(Hit, usize)> = None;
        self.boxes.ray_traverse(ray, &mut RayHit::none(), |_, leaf| {
            let (corners, id) = &self.triangles[leaf];
            let Some(hit) = shear.hit(corners) else { return f32::INFINITY };
            let wins = best.as_ref().is_none_or(|(b, l)| hit.t < b.t || (hit.t == b.t && *id < self.triangles[*l].1));
            if wins {
                best = Some((hit, leaf));
            }
            time(hit.t)
        });

        let (hit, leaf) = best?;
        let ([a, b, c], id) = self.triangles[leaf];
        let across = math::cross(math::sub(b, a), math::sub(c, a));
        // A triangle without a direction of its own, but with an area: too small for f64. It faces the viewer.
        let side = math::normalize(across).or_else(|| math::normalize(dir.map(|x| -x)))?;
        let side = towards_viewer(side, dir);
        let normal = self.interpolated(id, hit.weights).map_or(side, |n| facing(n, side, dir));
        Some(Met { t: hit.t, normal, side, material: self.mesh.material(id as usize) })
    }

    fn occluded(&self, origin: [f64; 3], dir: [f64; 3], t_max: f64) -> bool {
        let Some((mut ray, time)) = self.frame.ray(origin, dir) else { return false };
        // Boxes are padded more than rounding takes away from the end.
        ray.tmax = time(t_max);
        let shear = Shear::new(origin, dir);
        !self.boxes.ray_traverse_miss(ray, |_, leaf| match shear.hit(&self.triangles[leaf].0) {
            Some(hit) if hit.t < t_max => f32::NEG_INFINITY,
            _ => f32::INFINITY,
        })
    }

    fn extent(&self) -> f64 {
        2.0 / self.frame.scale
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
struct Hit {
    t: f64,
    /// Of the three corners; they sum to 1.
    weights: [f64; 3],
}

/// A ray, made ready for triangles.
struct Shear {
    origin: [f64; 3],
    /// Two axes, then the one along which the ray runs most.
    axes: [usize; 3],
    /// How far the ray runs along the two while it runs 1 along the third; and what t it takes for that.
    shear: [f64; 3],
}

impl Shear {
    /// Of a direction that is not 0.
    fn new(origin: [f64; 3], dir: [f64; 3]) -> Shear {
        let z = (1..3).fold(0, |z, i| if dir[i].abs() > dir[z].abs() { i } else { z });
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        Shear { origin, axes, shear: [dir[axes[0]] / dir[z], dir[axes[1]] / dir[z], 1.0 / dir[z]] }
    }

    /// Where the ray meets the triangle after t = 0, its edges included; `None` also for one seen edge-on.
    #[inline]
    fn hit(&self, corners: &[[f64; 3]; 3]) -> Option<Hit> {
        let [x, y, z] = self.axes;
        let [sx, sy, sz] = self.shear;
        let [a, b, c] = corners.map(|p| {
            let p = math::sub(p, self.origin);
            [p[x] - sx * p[z], p[y] - sy * p[z], sz * p[z]]
        });
        let edge = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let weights = [edge(b, c), edge(c, a), edge(a, b)];
        if weights.iter().any(|&w| w < 0.0) && weights.iter().any(|&w| w > 0.0) {
            return None;
        }
        let sum = weights[0] + weights[1] + weights[2];
        let weights = weights.map(|w| w / sum);
        // NaN where the sum is 0.
        let t = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        (t > 0.0 && t.is_finite()).then_some(Hit { t, weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use voxdag_oracle::rng::Rng;
    use voxdag_oracle::scenes::{self, Shape};

    /// All triangles one by one, as Möller and Trumbore (1997) do: t, and whether it is within `slack` of an edge.
    fn brute(shape: &Shape, origin: [f64; 3], dir: [f64; 3], slack: f64) -> Option<(f64, bool)> {
        let hits = shape.corners().filter_map(|[a, b, c]| {
            let (ab, ac, way) = (math::sub(b, a), math::sub(c, a), math::sub(origin, a));
            let p = math::cross(dir, ac);
            let q = math::cross(way, ab);
            let volume = math::dot(ab, p);
            let (u, v, t) = (math::dot(way, p) / volume, math::dot(dir, q) / volume, math::dot(ac, q) / volume);
            let least = u.min(v).min(1.0 - u - v);
            (least >= -slack && t > 0.0).then_some((t, least <= slack))
        });
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn moved(shape: &Shape, offset: [f64; 3], scale: f64) -> Shape {
        shape.map(|p| math::add_scaled(offset, p, scale))
    }

    #[test]
    fn the_nearest_triangle_is_that_of_all_triangles() {
        let (seed, rays) = (71, if cfg!(miri) { 20 } else { 20_000 });
        let shapes = [
            scenes::sphere([0.0; 3], 1.0, 4),
            scenes::torus([0.1, 0.2, 0.3], 1.0, 0.4, 40, 20),
            scenes::soup(seed, 500, 8, 1.5).map(|p| p.map(|x| x / 4.0 - 1.0)),
        ];
        let places = [([0.0; 3], 1.0), ([1e6, -2e6, 3e6], 10.0), ([0.5, 0.0, 0.0], 1e-6)];
        for (number, shape) in shapes.iter().enumerate() {
            for (offset, scale) in places {
                let shape = moved(shape, offset, scale);
                let truth = MeshTruth::new(shape.mesh(), &Memory::new(None)).unwrap();
                let mut rng = Rng::new(seed + number as u64);
                let mut hits = 0;
                for ray in 0..rays / shapes.len() / places.len() {
                    // From within and from far away, towards the middle and past it.
                    let distance = rng.spread(-1, 6);
                    let way = rng.direction();
                    let origin = math::add_scaled(offset, way, scale * distance);
                    let aim = math::add_scaled(offset, rng.direction(), scale * 1.5);
                    let mut dir = math::sub(aim, origin).map(|x| x * 0.3);
                    if rng.below(4) == 0 {
                        dir[rng.below(3) as usize] = 0.0;
                    }
                    let met = truth.nearest(origin, dir);
                    let told = format!("shape {number} at {offset:?}, ray {ray} of seed {seed}: {met:?}");
                    // Far from the origin the corners themselves are no better known than that.
                    match brute(&shape, origin, dir, 1e-9) {
                        Some((_, true)) => continue,
                        Some((t, false)) => {
                            let met = met.expect(&told);
                            hits += 1;
                            let error = (met.t - t).abs();
                            // Rounding counts for more where a triangle is seen edge-on.
                            let steep = 1e-12 / math::dot(met.side, math::normalize(dir).unwrap()).abs();
                            assert!(error <= t * steep, "{told}: {t}, off by {error}");
                            assert!(!truth.occluded(origin, dir, t * (1.0 - 1e-9)), "{told}");
                            assert!(truth.occluded(origin, dir, t * (1.0 + 1e-9)), "{told}");
                        }
                        None => {
                            assert_eq!(met, None, "{told}");
                            assert!(!truth.occluded(origin, dir, f64::INFINITY), "{told}");
                        }
                    }
                }
                assert!(cfg!(miri) || hits > rays / 50, "{hits}");
            }
        }
    }

    /// Rays into a closed surface through its vertices and edges all meet it.
    #[test]
    fn no_ray_passes_between_triangles() {
        let shape = moved(&scenes::sphere([0.0; 3], 1.0, if cfg!(miri) { 1 } else { 4 }), [3.0, -7.0, 11.0], 0.37);
        let truth = MeshTruth::new(shape.mesh(), &Memory::new(None)).unwrap();
        let mut rng = Rng::new(72);
        for (i, corners) in shape.corners().enumerate() {
            for edge in 0..3 {
                let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
                let on_edge = math::add_scaled(a, math::sub(b, a), rng.unit());
                for through in [a, on_edge, math::add_scaled(a, math::sub(b, a), 0.5)] {
                    // Out by the distance of the middle, and to the side, but never past the horizon.
                    let out = math::sub(through, [3.0, -7.0, 11.0]);
                    let origin =
                        math::add_scaled(math::add_scaled(through, out, rng.uniform(0.1, 9.0)), rng.direction(), 0.01);
                    let dir = math::sub(through, origin);
                    let met = truth.nearest(origin, dir);
                    assert!(met.is_some_and(|met| (met.t - 1.0).abs() < 1e-9), "triangle {i}, edge {edge}: {met:?}");
                }
            }
        }
    }

    #[test]
    fn normals_are_interpolated_where_there_are_some() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];
        let tilted = [[-0.6, 0.0, 0.8], [0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]];
        let mesh = Mesh {
            positions: &positions,
            triangles: &[[0, 1, 2], [3, 4, 5]],
            materials: &[3, 4],
            normals: &[tilted, [[f32::NAN; 3]; 3]],
            ..Mesh::default()
        };
        let truth = MeshTruth::new(mesh, &Memory::new(None)).unwrap();
        let near = |a: [f64; 3], b: [f64; 3]| math::sub(a, b).iter().all(|x| x.abs() < 1e-6);
        // In the middle of the edge from the first to the second corner, from above and from below.
        for (z, up) in [(2.0, 1.0), (-2.0, -1.0)] {
            let met = truth.nearest([0.5, 0.0, z], [0.0, 0.0, -z]).unwrap();
            assert_eq!((met.t, met.material, met.side), (1.0, 3, [0.0, 0.0, up]));
            assert!(near(met.normal, [0.0, 0.0, up]));
        }
        // A quarter of the way: the sum of three quarters and one quarter, of unit length.
        let met = truth.nearest([0.25, 0.0, 2.0], [0.0, 0.0, -1.0]).unwrap();
        assert!(near(met.normal, math::normalize([-0.3, 0.0, 0.8]).unwrap()), "{met:?}");
        // The other triangle has none of its own.
        let met = truth.nearest([0.25, 0.25, 8.0], [0.0, 0.0, -1.0]).unwrap();
        assert_eq!((met.t, met.material, met.normal), (3.0, 4, [0.0, 0.0, 1.0]));
    }
}
