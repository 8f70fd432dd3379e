//! Surfaces that have a formula, and the meshes that are voxelised for them.
//!
//! In: a name. Out: the surface in closed form, and a source of triangles that is so close to it that the difference is
//! no matter beside a voxel: the plane and the wall are the same but for rounding, the sphere and the torus are off by
//! less than 0.02 voxels at a resolution of 2048. All stand upright for a camera that looks down on them, y upwards.
//!
//! The torus is a quartic of the ray. It is taken about the ray's point nearest to the middle, where it has no cubic
//! term and all roots lie within the ball around the torus; they are found between the roots of its derivative, which
//! are found between those of the second, by Newton's steps that bisection keeps from leaving (Press et al., Numerical
//! Recipes, section 9.4). So each piece is monotone, has one root at most, and none is missed.

use clap::ValueEnum;
use voxdag::Material;
use voxdag::math;
use voxdag::mtl::NamedMaterial;
use voxdag::obj::Model;
use voxdag_oracle::scenes::{self, Shape};

use super::{Met, Truth, towards_viewer};
use crate::source::Source;

/// Shapes with a formula.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Known {
    /// A ball
    Sphere,
    /// A ring that lies flat
    Torus,
    /// A tilted square
    Plane,
    /// A slanted sheet, 0.3 voxels thick at a resolution of 512
    Wall,
}

/// A surface in closed form, all in material 0.
#[derive(Clone, Copy, Debug)]
pub enum Closed {
    /// Around the origin.
    Sphere {
        /// Of the ball.
        radius: f64,
    },
    /// Around the y axis, its middle the origin.
    Torus {
        /// Of the circle in the middle of the ring.
        major: f64,
        /// Of the ring itself.
        minor: f64,
    },
    /// A parallelogram.
    Sheet {
        /// Its middle.
        center: [f64; 3],
        /// Half of its edges.
        edges: [[f64; 3]; 2],
    },
    /// A parallelepiped.
    Block {
        /// Its middle.
        center: [f64; 3],
        /// Half of its edges.
        edges: [[f64; 3]; 3],
    },
}

/// Slope of the plane along both of its edges, in no proportion to a voxel's.
const RISE: f64 = -0.37;
/// Halvings of an octahedron's edges for the sphere's mesh, and pieces around and across the ring of the torus's.
const HALVINGS: u32 = 8;
const PIECES: [u32; 2] = [1024, 512];
/// Radii of the torus.
const TORUS: [f64; 2] = [1.0, 0.4];

impl Known {
    /// The surface.
    pub fn closed(self) -> Closed {
        match self {
            Known::Sphere => Closed::Sphere { radius: 1.0 },
            Known::Torus => Closed::Torus { major: TORUS[0], minor: TORUS[1] },
            Known::Plane => Closed::Sheet {
                center: [0.5, RISE / 2.0, 0.5],
                edges: [[0.0, RISE / 4.0, 0.5], [0.5, RISE / 4.0, 0.0]],
            },
            Known::Wall => {
                let unit = |a| math::normalize(a).unwrap_or([0.0; 3]);
                let across = unit([1.0, 0.5, 2.0]);
                let along = unit(math::cross([0.0, 1.0, 0.0], across));
                let edges = [along, math::cross(across, along)].map(|edge| edge.map(|x| x * 0.5));
                let thickness = 0.3 / 512.0 * extent(&edges);
                Closed::Block { center: [0.0; 3], edges: [edges[0], edges[1], across.map(|x| x * thickness / 2.0)] }
            }
        }
    }

    /// The mesh that is voxelised for it, as if it had been read; in a grey with a highlight, which shows what normals
    /// do.
    pub fn source(self) -> Source {
        let Shape { positions, triangles } = self.shape();
        let material = Material { specular: [0.4; 3], shininess: 30, illum: 2, ..Material::GREY };
        let materials =
            vec![NamedMaterial { name: "grey".to_owned(), material, has_ambient: true, map_kd: None, map_d: None }];
        let name = self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
        let faces = triangles.len();
        Source::of(&name, Model { positions, triangles, materials, faces, ..Model::default() })
    }

    /// Triangles near it.
    fn shape(self) -> Shape {
        // The scenes have z upwards.
        let upright = |shape: Shape| shape.map(|[x, y, z]| [y, z, x]);
        match self.closed() {
            Closed::Sphere { radius } => scenes::sphere([0.0; 3], radius, HALVINGS),
            Closed::Torus { major, minor } => upright(scenes::torus([0.0; 3], major, minor, PIECES[0], PIECES[1])),
            Closed::Sheet { .. } => upright(scenes::tilted_plane(1.0, RISE, 0.0)),
            Closed::Block { center, edges } => scenes::cuboid([-1.0; 3], [1.0; 3])
                .map(|p| (0..3).fold(center, |sum, i| math::add_scaled(sum, edges[i], p[i]))),
        }
    }
}

/// The longest side of the box around a middle and all sums and differences of half edges.
fn extent(edges: &[[f64; 3]]) -> f64 {
    (0..3).map(|i| 2.0 * edges.iter().map(|edge| edge[i].abs()).sum::<f64>()).fold(0.0, f64::max)
}

impl Truth for Closed {
    fn nearest(&self, origin: [f64; 3], dir: [f64; 3]) -> Option<Met> {
        // Around the middle, from the point of the line that is nearest to it, at unit speed.
        let center = match *self {
            Closed::Sheet { center, .. } | Closed::Block { center, .. } => center,
            _ => [0.0; 3],
        };
        let (unit, from) = (math::normalize(dir)?, math::sub(origin, center));
        let start = math::dot(from, unit);
        let line = Line { point: math::add_scaled(from, unit, -start), dir: unit, start };
        let (s, normal) = match *self {
            Closed::Sphere { radius } => line.sphere(radius),
            Closed::Torus { major, minor } => line.torus(major, minor),
            Closed::Sheet { edges: [a, b], .. } => line.sheet(a, b),
            Closed::Block { edges, .. } => line.block(edges),
        }?;
        let side = towards_viewer(math::normalize(normal)?, dir);
        let t = (s - start) / math::sqrt(math::dot(dir, dir));
        Some(Met { t, normal: side, side, material: 0 })
    }

    fn extent(&self) -> f64 {
        match self {
            Closed::Sphere { radius } => 2.0 * radius,
            Closed::Torus { major, minor } => 2.0 * (major + minor),
            Closed::Sheet { edges, .. } => extent(edges),
            Closed::Block { edges, .. } => extent(edges),
        }
    }
}

/// `point + s dir` for s > start; `dir` is of unit length and at right angles to `point`.
struct Line {
    point: [f64; 3],
    dir: [f64; 3],
    start: f64,
}

/// Where a line meets a surface first, as its s, and a normal there, of any side and length.
type At = Option<(f64, [f64; 3])>;

impl Line {
    fn at(&self, s: f64) -> [f64; 3] {
        math::add_scaled(self.point, self.dir, s)
    }

    fn sphere(&self, radius: f64) -> At {
        let square = radius * radius - math::dot(self.point, self.point);
        // A ray that only touches it misses it, and so does NaN.
        if !(square > 0.0) {
            return None;
        }
        let half = math::sqrt(square);
        let s = [-half, half].into_iter().find(|&s| s > self.start)?;
        Some((s, self.at(s)))
    }

    /// `(|p|^2 + R^2 - r^2)^2 = 4 R^2 (x^2 + z^2)`.
    fn torus(&self, major: f64, minor: f64) -> At {
        let (p, d, square) = (self.point, self.dir, 4.0 * major * major);
        let nearest = math::dot(p, p);
        // Within a ball that is a little larger, whose border has no root. NaN for a line that stays away.
        let ball = 1.01 * (major + minor);
        let reach = math::sqrt(ball * ball - nearest);
        if !(reach > self.start) {
            return None;
        }
        let k = nearest + major * major - minor * minor;
        let (c2, c1, c0) = (
            2.0 * k - square * (d[0] * d[0] + d[2] * d[2]),
            -2.0 * square * (p[0] * d[0] + p[2] * d[2]),
            k * k - square * (p[0] * p[0] + p[2] * p[2]),
        );
        let quartic = |s: f64| (((s * s + c2) * s + c1) * s + c0, (4.0 * s * s + 2.0 * c2) * s + c1);
        let cubic = |s: f64| (quartic(s).1, 12.0 * s * s + 2.0 * c2);
        let bend = math::sqrt((-c2 / 6.0).max(0.0));

        let span = (self.start.max(-reach), reach);
        let turns: Vec<f64> =
            Roots { f: cubic, from: span.0, stops: [-bend, bend, span.1].into_iter(), span }.collect();
        let stops = turns.into_iter().chain([span.1]);
        let s = Roots { f: quartic, from: span.0, stops, span }.next()?;
        let [x, y, z] = self.at(s);
        let inner = major / math::sqrt(x * x + z * z);
        Some((s, [x - x * inner, y, z - z * inner]))
    }

    fn sheet(&self, a: [f64; 3], b: [f64; 3]) -> At {
        let normal = math::cross(a, b);
        let [u, v, w] = self.within([a, b, normal]);
        let s = -w[0] / w[1];
        let inside = |[from, step]: [f64; 2]| (from + step * s).abs() <= 1.0;
        (s > self.start && s.is_finite() && inside(u) && inside(v)).then_some((s, normal))
    }

    fn block(&self, edges: [[f64; 3]; 3]) -> At {
        // The last side that it enters, and the first that it leaves.
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        for (i, [from, step]) in self.within(edges).into_iter().enumerate() {
            if step == 0.0 {
                if from.abs() > 1.0 {
                    return None;
                }
                continue;
            }
            let (near, far) = ((-step.signum() - from) / step, (step.signum() - from) / step);
            enter = if near > enter.0 { (near, i) } else { enter };
            leave = if far < leave.0 { (far, i) } else { leave };
        }
        if !(enter.0 <= leave.0) {
            return None;
        }
        let (s, i) = [enter, leave].into_iter().find(|&(s, _)| s > self.start)?;
        Some((s, math::cross(edges[(i + 1) % 3], edges[(i + 2) % 3])))
    }

    /// The line in the coordinates of three vectors, which need not be at right angles: where s is 0, and per s.
    fn within(&self, [a, b, c]: [[f64; 3]; 3]) -> [[f64; 2]; 3] {
        let volume = math::dot(a, math::cross(b, c));
        let dual = [math::cross(b, c), math::cross(c, a), math::cross(a, b)];
        dual.map(|n| [math::dot(self.point, n) / volume, math::dot(self.dir, n) / volume])
    }
}

/// The roots of a function, ascending, that is monotone from `from` to the first of `stops`, and on to each next one;
/// each value is given with the slope. Stops outside of `span` are taken at its ends.
struct Roots<F, I> {
    f: F,
    from: f64,
    stops: I,
    span: (f64, f64),
}

impl<F: Fn(f64) -> (f64, f64), I: Iterator<Item = f64>> Iterator for Roots<F, I> {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        loop {
            let to = self.stops.next()?.clamp(self.span.0, self.span.1);
            let from = core::mem::replace(&mut self.from, to);
            if ((self.f)(from).0 < 0.0) != ((self.f)(to).0 < 0.0) {
                return Some(root(&self.f, from, to));
            }
        }
    }
}

/// The root between two places of which one has a value below 0 and the other not.
fn root(f: impl Fn(f64) -> (f64, f64), mut from: f64, mut to: f64) -> f64 {
    let falling = !(f(from).0 < 0.0);
    let mut s = 0.5 * (from + to);
    // Bisection alone takes some 60 steps.
    for _ in 0..100 {
        let (value, slope) = f(s);
        if (value < 0.0) == falling {
            to = s;
        } else {
            from = s;
        }
        let newton = s - value / slope;
        let next = if newton > from && newton < to { newton } else { 0.5 * (from + to) };
        if (next - s).abs() <= f64::EPSILON * s.abs() {
            return next;
        }
        s = next;
    }
    s
}

#[cfg(test)]
mod tests {
    use super::super::MeshTruth;
    use super::*;
    use crate::memory::Memory;
    use voxdag::camera::Camera;
    use voxdag::grid::UpAxis;
    use voxdag_oracle::rng::Rng;

    /// How far a point is from a surface.
    fn distance(closed: &Closed, p: [f64; 3]) -> f64 {
        let length = |a: [f64; 3]| math::sqrt(math::dot(a, a));
        match *closed {
            Closed::Sphere { radius } => (length(p) - radius).abs(),
            Closed::Torus { major, minor } => {
                let out = math::sqrt(p[0] * p[0] + p[2] * p[2]) - major;
                (math::sqrt(out * out + p[1] * p[1]) - minor).abs()
            }
            Closed::Sheet { .. } => (p[1] - RISE * (p[0] + p[2]) / 2.0).abs(),
            Closed::Block { edges, .. } => {
                let lengths = edges.map(length);
                let off = |i: usize| (math::dot(p, edges[i]).abs() / lengths[i] - lengths[i]).abs();
                off(0).min(off(1)).min(off(2))
            }
        }
    }

    #[test]
    fn the_meshes_are_within_a_fiftieth_of_a_voxel() {
        for known in Known::value_variants().iter().copied() {
            let (closed, shape) = (known.closed(), known.shape());
            let bounds = shape.mesh().validate().unwrap();
            let voxel = bounds.extent() / 2048.0;
            assert!((bounds.extent() / closed.extent() - 1.0).abs() < 1e-4, "{known:?}");
            // Corners, middles of edges, and the middle, where triangles are farthest off.
            let farthest = shape.corners().flat_map(|[a, b, c]| {
                let mix = |u: f64, v: f64, w: f64| [0, 1, 2].map(|i| (u * a[i] + v * b[i] + w * c[i]) / (u + v + w));
                [mix(1.0, 0.0, 0.0), mix(1.0, 1.0, 0.0), mix(0.0, 1.0, 1.0), mix(1.0, 0.0, 1.0), mix(1.0, 1.0, 1.0)]
            });
            let farthest = farthest.map(|p| distance(&closed, p)).fold(0.0, f64::max) / voxel;
            let bound = if matches!(known, Known::Sphere | Known::Torus) { 0.02 } else { 1e-10 };
            assert!(farthest < bound, "{known:?}: {farthest} voxels");
        }
    }

    #[test]
    fn rays_meet_the_formula_where_they_meet_its_mesh() {
        let memory = Memory::new(None);
        for known in Known::value_variants().iter().copied() {
            let (closed, source) = (known.closed(), known.source());
            let mesh = source.model.mesh();
            let camera = Camera::framing(&mesh.validate().unwrap(), UpAxis::Y);
            let size = [64, 36];
            let truth = MeshTruth::new(mesh, &memory).unwrap();
            let met = super::super::look(&truth, &camera, size, &memory).unwrap();
            let expected = super::super::look(&closed, &camera, size, &memory).unwrap();
            let rays = camera.rays(size[0], size[1]).unwrap();
            let (mut hits, mut beyond) = (0, 0);
            for (i, pair) in met.iter().zip(&expected).enumerate() {
                let (Some(met), Some(expected)) = pair else {
                    beyond += u32::from(pair.0 != pair.1);
                    continue;
                };
                hits += 1;
                let dir = rays.direction((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
                let off = ((met.t - expected.t) * math::dot(dir, expected.side)).abs();
                let cosine = math::dot(met.side, expected.normal);
                // A horizon may let a ray pass to what is behind; and the mesh's normals are those of its flat pieces.
                beyond += u32::from(!(off < 5e-5 && cosine > 0.9999));
            }
            assert!(hits > 200 && beyond <= 3, "{known:?}: {hits} hits, {beyond} off");
        }
    }

    #[test]
    fn a_torus_is_met_from_everywhere() {
        let torus = Known::Torus.closed();
        let met = |origin, dir| torus.nearest(origin, dir).map(|met| (met.t, met.normal));
        let near = |found: Option<(f64, [f64; 3])>, t: f64, normal: [f64; 3]| {
            let (time, n) = found.unwrap();
            assert!((time - t).abs() < 1e-12 && math::dot(n, normal) > 1.0 - 1e-12, "{time} {n:?}");
        };
        near(met([1.0, 5.0, 0.0], [0.0, -2.0, 0.0]), 2.3, [0.0, 1.0, 0.0]);
        near(met([3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), 1.6, [1.0, 0.0, 0.0]);
        near(met([0.0; 3], [1.0, 0.0, 0.0]), 0.6, [-1.0, 0.0, 0.0]);
        // From within the ring, and from behind it.
        near(met([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), 0.4, [0.0, -1.0, 0.0]);
        assert_eq!(met([0.0, 5.0, 0.0], [0.0, -1.0, 0.0]), None);
        assert_eq!(met([-1.5, 0.0, 0.0], [-1.0, 0.0, 0.0]), None);
        assert_eq!(met([0.0; 3], [0.0; 3]), None);

        // Small steps along the ray until the side changes.
        let (mut rng, mut hits) = (Rng::new(73), 0);
        for ray in 0..if cfg!(miri) { 3 } else { 300 } {
            let origin = rng.direction().map(|x| 2.0 * x);
            let dir = math::sub(rng.direction(), origin);
            let inside = |t: f64| {
                let p = math::add_scaled(origin, dir, t);
                let out = math::sqrt(p[0] * p[0] + p[2] * p[2]) - 1.0;
                out * out + p[1] * p[1] < 0.16
            };
            let step = 4.0 / 20_000.0;
            let first = (0..20_000).map(|i| f64::from(i) * step).find(|&t| inside(t) != inside(t + step));
            match (first, torus.nearest(origin, dir)) {
                (Some(t), Some(met)) => {
                    hits += 1;
                    assert!((t - 1e-12..=t + step + 1e-12).contains(&met.t), "ray {ray} of seed 73: {t}, {}", met.t);
                }
                // Less than a step of the ray is inside, or the surface is more than four directions away.
                (None, Some(met)) => {
                    assert!(met.t > 4.0 - step || inside(met.t + 1e-9), "ray {ray} of seed 73: {met:?}")
                }
                (Some(t), None) => panic!("ray {ray} of seed 73: missed at {t}"),
                (None, None) => {}
            }
        }
        assert!(cfg!(miri) || hits > 100, "{hits}");
    }

    #[test]
    fn spheres_sheets_and_blocks_are_met_in_front() {
        let met = |closed: Closed, origin, dir| closed.nearest(origin, dir).map(|met| (met.t, met.normal));
        let ball = Closed::Sphere { radius: 2.0 };
        assert_eq!(met(ball, [0.0, 0.0, 8.0], [0.0, 0.0, -3.0]), Some((2.0, [0.0, 0.0, 1.0])));
        assert_eq!(met(ball, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), Some((1.0, [0.0, 0.0, -1.0])));
        assert_eq!(met(ball, [0.0, 0.0, 8.0], [0.0, 0.0, 3.0]), None);

        // A parallelogram whose edges are not at right angles.
        let sheet = Closed::Sheet { center: [0.0, 0.0, 5.0], edges: [[2.0, 0.0, 0.0], [2.0, 1.0, 0.0]] };
        assert_eq!(met(sheet, [3.5, 0.9, 0.0], [0.0, 0.0, 2.0]), Some((2.5, [0.0, 0.0, -1.0])));
        assert_eq!(met(sheet, [3.5, -0.9, 0.0], [0.0, 0.0, 2.0]), None);
        assert_eq!(met(sheet, [0.0; 3], [1.0, 0.0, 0.0]), None);

        let edges = [[0.0, 3.0, 0.0], [0.0, 0.0, 1.0], [2.0, 0.0, 0.0]];
        let block = Closed::Block { center: [10.0, 0.0, 0.0], edges };
        assert_eq!(met(block, [0.0, 2.9, 0.9], [4.0, 0.0, 0.0]), Some((2.0, [-1.0, 0.0, 0.0])));
        assert_eq!(met(block, [10.0, 0.0, 0.0], [0.0, -1.0, 0.0]), Some((3.0, [0.0, 1.0, 0.0])));
        assert_eq!(met(block, [0.0, 3.1, 0.0], [4.0, 0.0, 0.0]), None);
        assert_eq!(met(block, [13.0, 0.0, 0.0], [4.0, 0.0, 0.0]), None);
    }
}
