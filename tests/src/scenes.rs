//! Seeded scenes: meshes, and shapes without a mesh whose voxels can be asked for one by one at any depth.
//!
//! Meshes are in voxel units unless they say otherwise, so that a grid of origin 0 and voxel size 1 takes them as they
//! are. Implicit shapes answer for cubes too, which is what the ray oracle descends by.

use std::collections::BTreeMap;

use voxdag::Mesh;

use crate::clip::{SUB, Triangle};
use crate::octree::{Recursive, words_of};
use crate::rng::Rng;

/// A mesh that owns its numbers.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Vertices.
    pub positions: Vec<[f64; 3]>,
    /// Three vertices each, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// The core's view of it, all in material 0.
    pub fn mesh(&self) -> Mesh<'_> {
        Mesh { positions: &self.positions, triangles: &self.triangles, ..Mesh::default() }
    }

    /// Every vertex through a function.
    pub fn map(&self, f: impl Fn([f64; 3]) -> [f64; 3]) -> Shape {
        Shape { positions: self.positions.iter().map(|&p| f(p)).collect(), triangles: self.triangles.clone() }
    }

    /// Another shape's triangles in addition.
    pub fn add(&mut self, other: &Shape) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }

    /// The triangles' corners.
    pub fn corners(&self) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|v| self.positions[v as usize]))
    }

    /// The triangles in 1/256 voxel, rounded half to even. Our own rounding: the core's `rint` is not asked.
    pub fn rounded(&self, origin: [f64; 3], voxel_size: f64) -> Vec<Triangle> {
        let round = |p: [f64; 3]| -> [i64; 3] {
            core::array::from_fn(|i| {
                let x = (p[i] - origin[i]) * (SUB as f64 / voxel_size);
                let floor = x.floor();
                let up = match x - floor {
                    0.5 => floor % 2.0 != 0.0,
                    r => r > 0.5,
                };
                floor as i64 + i64::from(up)
            })
        };
        self.corners().map(|t| t.map(round)).collect()
    }

    /// The triangles in 1/256 voxel, by the rule of the design: rounded, and the far border of `resolution` voxels pulled
    /// in by one unit.
    pub fn snapped(&self, origin: [f64; 3], voxel_size: f64, resolution: u32) -> Vec<Triangle> {
        let last = SUB * i64::from(resolution) - 1;
        let rounded = self.rounded(origin, voxel_size);
        rounded.into_iter().map(|t| t.map(|p| p.map(|x| x.min(last)))).collect()
    }
}

/// The surface of an axis-parallel box.
pub fn cuboid(lo: [f64; 3], hi: [f64; 3]) -> Shape {
    let corner = |c: usize| core::array::from_fn(|i| if c >> i & 1 == 1 { hi[i] } else { lo[i] });
    let quads: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Shape { positions: (0..8).map(corner).collect(), triangles }
}

/// The surface of the unit cube.
pub fn unit_cube() -> Shape {
    cuboid([0.0; 3], [1.0; 3])
}

/// A sphere: an octahedron whose edges are halved `times` times and pushed out. 8 * 4^times triangles.
pub fn sphere(centre: [f64; 3], radius: f64, times: u32) -> Shape {
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut p = [0.0; 3];
            p[axis] = sign;
            positions.push(p);
        }
    }
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for octant in 0..8u32 {
        let [x, y, z] = [octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2 & 1)];
        triangles.push(if octant.count_ones() % 2 == 0 { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..times {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let (p, q) = (positions[a as usize], positions[b as usize]);
                let m: [f64; 3] = core::array::from_fn(|i| p[i] + q[i]);
                let length = (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]).sqrt();
                positions.push(m.map(|x| x / length));
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    Shape { positions, triangles }.map(|p| core::array::from_fn(|i| centre[i] + radius * p[i]))
}

/// A sphere of circles of latitude and longitude, as in Embree's watertightness test: `4 n (n - 1)` triangles. Each vertex
/// is pushed out to `radius` times what `bump` says of its place in the list.
pub fn globe(centre: [f64; 3], radius: f64, n: u32, mut bump: impl FnMut(usize) -> f64) -> Shape {
    let around = 2 * n;
    let mut shape = Shape::default();
    let mut add = |p: [f64; 3]| {
        let r = radius * bump(shape.positions.len());
        shape.positions.push(core::array::from_fn(|i| centre[i] + r * p[i]));
    };
    add([0.0, 0.0, -1.0]);
    add([0.0, 0.0, 1.0]);
    for i in 1..n {
        let (out, up) = libm::sincos(core::f64::consts::PI * f64::from(i) / f64::from(n));
        for j in 0..around {
            let (sin, cos) = libm::sincos(core::f64::consts::TAU * f64::from(j) / f64::from(around));
            add([out * cos, out * sin, -up]);
        }
    }
    let at = |i: u32, j: u32| 2 + (i - 1) * around + j % around;
    for j in 0..around {
        shape.triangles.push([0, at(1, j + 1), at(1, j)]);
        shape.triangles.push([1, at(n - 1, j), at(n - 1, j + 1)]);
        for i in 1..n - 1 {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            shape.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    shape
}

/// The surface of an axis-parallel box, each side divided into `n` by `n` squares: `12 n^2` triangles.
pub fn divided_box(lo: [f64; 3], hi: [f64; 3], n: u32) -> Shape {
    let mut shape = Shape::default();
    let mut known = BTreeMap::new();
    let mut vertex = |k: [u32; 3]| {
        *known.entry(k).or_insert_with(|| {
            shape.positions.push(core::array::from_fn(|i| match k[i] {
                0 => lo[i],
                k if k == n => hi[i],
                k => lo[i] + (hi[i] - lo[i]) * f64::from(k) / f64::from(n),
            }));
            shape.positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n * n {
                let mut corner = |u: u32, v: u32| {
                    let mut k = [side; 3];
                    k[(axis + 1) % 3] = i % n + u;
                    k[(axis + 2) % 3] = i / n + v;
                    vertex(k)
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                shape.triangles.extend(if side == 0 { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
            }
        }
    }
    shape
}

/// A torus around the z axis: `around` times `across` quads, two triangles each.
pub fn torus(centre: [f64; 3], major: f64, minor: f64, around: u32, across: u32) -> Shape {
    let turn = |k: u32, n: u32| libm::sincos(core::f64::consts::TAU * f64::from(k) / f64::from(n));
    let mut shape = Shape::default();
    for i in 0..around {
        let (sin, cos) = turn(i, around);
        for j in 0..across {
            let (up, out) = turn(j, across);
            let r = major + minor * out;
            shape.positions.push([centre[0] + r * cos, centre[1] + r * sin, centre[2] + minor * up]);
            let at = |i: u32, j: u32| i % around * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            shape.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    shape
}

/// Two triangles over `[0, n]^2` with `z = rise (x + y) / 2 + z0`.
pub fn tilted_plane(n: f64, rise: f64, z0: f64) -> Shape {
    let at = |x: f64, y: f64| [x, y, z0 + rise * (x + y) / 2.0];
    Shape { positions: vec![at(0.0, 0.0), at(n, 0.0), at(n, n), at(0.0, n)], triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

/// Triangles across a scene of `n` voxels that are at most `width` voxels wide.
pub fn slivers(seed: u64, count: usize, n: f64, width: f64) -> Shape {
    let mut rng = Rng::new(seed);
    let mut shape = Shape::default();
    for i in 0..count as u32 {
        let mut point = || [(); 3].map(|()| rng.uniform(0.0, n));
        let (a, b) = (point(), point());
        let near = a.map(|x| (x + rng.uniform(-width, width)).clamp(0.0, n));
        shape.positions.extend([a, b, near]);
        shape.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    shape
}

/// Triangles without area around one point: points, segments given by two equal or by three collinear vertices.
/// All on the lattice of half voxels, where ties are.
pub fn degenerate_fan(seed: u64, count: usize, n: u32) -> Shape {
    let mut rng = Rng::new(seed);
    let mut lattice = || [(); 3].map(|()| rng.below(u64::from(2 * n) + 1) as f64 / 2.0);
    let hub = lattice();
    let mut shape = Shape { positions: vec![hub], triangles: vec![[0, 0, 0]] };
    for _ in 0..count {
        let tip = lattice();
        let at = shape.positions.len() as u32;
        shape.positions.extend([tip, core::array::from_fn(|i| (hub[i] + tip[i]) / 2.0)]);
        shape.triangles.extend([[at, at, at], [0, at, at], [0, at, 0], [0, at, at + 1]]);
    }
    shape
}

/// Two thin triangles along the main diagonal of a scene of `n` voxels, and one triangle that spans it.
pub fn diagonals(n: f64) -> Shape {
    let positions = vec![[0.0; 3], [n; 3], [n, n, n - 1.0], [0.0, n, 0.0], [n, 0.0, 0.0], [n, 1.0, 0.0], [0.0, 0.0, n]];
    Shape { positions, triangles: vec![[0, 1, 2], [3, 4, 5], [3, 4, 6]] }
}

/// Small random triangles, some with vertices on lattice points, edges and faces of voxels.
pub fn soup(seed: u64, count: usize, n: u32, size: f64) -> Shape {
    let mut rng = Rng::new(seed);
    let mut shape = Shape::default();
    let n = f64::from(n);
    for i in 0..count as u32 {
        let centre = [(); 3].map(|()| rng.uniform(0.0, n));
        for _ in 0..3 {
            let p = centre.map(|x| {
                let x = (x + rng.uniform(-size, size)).clamp(0.0, n);
                // A third of the coordinates goes to planes between voxels.
                if rng.below(3) == 0 { x.round() } else { x }
            });
            shape.positions.push(p);
        }
        shape.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    shape
}

/// A voxel shape without a mesh.
#[derive(Clone, Copy, Debug)]
pub enum Implicit {
    /// Voxels whose centre is at least `inner` and less than `outer` (in half voxels) from `centre` (in half voxels).
    Shell {
        /// Centre in half voxels.
        centre: [i64; 3],
        /// Inner radius in half voxels.
        inner: i64,
        /// Outer radius in half voxels.
        outer: i64,
    },
    /// `lo <= voxel[axis] < hi`.
    Wall {
        /// 0, 1 or 2.
        axis: usize,
        /// First layer.
        lo: i64,
        /// First layer that is empty again.
        hi: i64,
    },
    /// `lo <= x + y + z < hi`.
    Diagonal {
        /// First sum.
        lo: i64,
        /// First sum that is empty again.
        hi: i64,
    },
    /// One voxel in every cube of 4^3, at the same place.
    Dust {
        /// The place in the cube, each 0 to 3.
        at: [u32; 3],
    },
}

impl Implicit {
    /// Whether a voxel is filled.
    pub fn filled(&self, voxel: [u32; 3]) -> bool {
        self.any(0, voxel)
    }

    /// Whether the cube of side 2^`level` at `corner` holds a filled voxel. Exact, but for shells above level 0, where
    /// it may say yes too often.
    pub fn any(&self, level: u8, corner: [u32; 3]) -> bool {
        let side = 1i64 << level;
        let corner = corner.map(i64::from);
        match *self {
            Implicit::Shell { centre, inner, outer } => {
                // Centres of voxels are odd numbers of half voxels.
                let (mut nearest, mut farthest) = (0, 0);
                for i in 0..3 {
                    let (lo, hi) = (2 * corner[i] + 1 - centre[i], 2 * (corner[i] + side) - 1 - centre[i]);
                    let near = if lo > 0 { lo } else { (-hi).max(0) };
                    nearest += near * near;
                    farthest += lo.abs().max(hi.abs()) * lo.abs().max(hi.abs());
                }
                nearest < outer * outer && farthest >= inner * inner
            }
            Implicit::Wall { axis, lo, hi } => corner[axis] < hi && corner[axis] + side > lo,
            Implicit::Diagonal { lo, hi } => {
                let sum: i64 = corner.iter().sum();
                sum < hi && sum + 3 * (side - 1) >= lo
            }
            Implicit::Dust { at } => {
                level >= 2 || (0..3).all(|i| (corner[i] & 3..(corner[i] & 3) + side).contains(&i64::from(at[i])))
            }
        }
    }

    /// The DAG's words; for walls, diagonal walls and dust also at depth 21.
    pub fn words(&self, depth: u8) -> Vec<u32> {
        words_of(self, depth, self.any(depth, [0; 3]).then_some(&[0; 3]))
    }

    /// The filled voxels of the cube of side 2^`depth`.
    pub fn voxels(&self, depth: u8) -> Vec<[u32; 3]> {
        fn descend(shape: &Implicit, level: u8, corner: [u32; 3], found: &mut Vec<[u32; 3]>) {
            if !shape.any(level, corner) {
                return;
            }
            if level == 0 {
                found.push(corner);
                return;
            }
            for octant in 0..8 {
                let child = core::array::from_fn(|i| corner[i] + ((octant >> i & 1) << (level - 1)));
                descend(shape, level - 1, child, found);
            }
        }
        let mut found = Vec::new();
        descend(self, depth, [0; 3], &mut found);
        found
    }
}

/// The state of a cube of an [`Implicit`] is where the shape lies as seen from the cube's corner. Walls, diagonal walls
/// and dust have few states on a level; a shell has as many as it has cubes.
impl Recursive for Implicit {
    type State = [i64; 3];

    fn split(&self, level: u8, state: &[i64; 3]) -> [Option<[i64; 3]>; 8] {
        core::array::from_fn(|octant| {
            let half = 1i64 << (level - 1);
            let moved: [i64; 3] = core::array::from_fn(|i| state[i] + half * (octant >> i & 1) as i64);
            if !self.any(level - 1, moved.map(|x| x as u32)) {
                return None;
            }
            Some(match *self {
                // Only the corner's part that the shape depends on.
                Implicit::Wall { axis, .. } => core::array::from_fn(|i| if i == axis { moved[axis] } else { 0 }),
                Implicit::Diagonal { .. } => [moved.iter().sum(), 0, 0],
                Implicit::Dust { .. } => moved.map(|x| x & 3),
                Implicit::Shell { .. } => moved,
            })
        })
    }
}
