//! Meshes from formulas: `+ - * /`, square roots and `libm` alone, so that they are the same numbers everywhere.

use alloc::vec::Vec;
use core::f64::consts::TAU;

use voxdag::Mesh;
use voxdag::math::sqrt;

/// A mesh with three materials, which take turns.
pub struct Shape {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u16>,
}

/// Number of materials of a [`Shape`].
pub const MATERIALS: usize = 3;

impl Shape {
    fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Shape {
        let materials = (0..triangles.len()).map(|i| (i % MATERIALS) as u16).collect();
        Shape { positions, triangles, materials }
    }

    /// The view that is voxelised.
    pub fn mesh(&self) -> Mesh<'_> {
        Mesh { positions: &self.positions, triangles: &self.triangles, materials: &self.materials, ..Mesh::default() }
    }

    /// `cells` quads over the surface `at(s, t)`, s and t from 0 to 1.
    fn sheet(cells: [u32; 2], at: impl Fn(f64, f64) -> [f64; 3]) -> Shape {
        let [columns, rows] = cells;
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for j in 0..=rows {
            for i in 0..=columns {
                positions.push(at(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows)));
                if i < columns && j < rows {
                    let k = j * (columns + 1) + i;
                    triangles.extend([[k, k + 1, k + columns + 2], [k, k + columns + 2, k + columns + 1]]);
                }
            }
        }
        Shape::new(positions, triangles)
    }
}

/// Two triangles askew.
pub fn tiny() -> Shape {
    let positions = [[0.1, 0.0, 0.2], [3.3, 0.7, 0.0], [1.0, 3.1, 2.9], [0.0, 2.0, 1.1]];
    Shape::new(positions.into(), [[0, 1, 2], [0, 2, 3]].into())
}

/// A ball in a far corner of the world, where coordinates have few digits behind the point.
pub fn ball() -> Shape {
    let centre = [148_376.125, 1_234.7, -223_423.3];
    Shape::sheet([48, 24], |s, t| {
        let ((sin, cos), (up, out)) = (libm::sincos(s * TAU), libm::sincos((t - 0.5) * TAU / 2.0));
        [centre[0] + 1.7 * out * cos, centre[1] + 1.7 * up, centre[2] + 1.7 * out * sin]
    })
}

/// A torus that lies on no axis.
pub fn ring() -> Shape {
    Shape::sheet([64, 24], |s, t| {
        let ((sin, cos), (up, out)) = (libm::sincos(s * TAU), libm::sincos(t * TAU));
        let (r, h) = (1.0 + 0.35 * out, 0.35 * up);
        let (x, y, z) = (r * cos, r * sin, h);
        [0.8 * x - 0.6 * z, y, 0.6 * x + 0.8 * z]
    })
}

/// Rings on water.
pub fn waves() -> Shape {
    Shape::sheet([60, 60], |s, t| {
        let (x, z) = (6.0 * s - 3.0, 6.0 * t - 3.0);
        [x, 0.3 * libm::sin(4.0 * sqrt(x * x + z * z)), z]
    })
}

/// Triangles of all sizes anywhere in a cube, some of them without area. Numbers by splitmix64 (Steele, Lea and Flood 2014).
pub fn soup() -> Shape {
    let mut state = 4u64;
    let mut unit = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..150 {
        let centre = [unit(), unit(), unit()];
        let size = 0.4 * unit() * unit();
        positions.extend([(); 3].map(|()| centre.map(|x| x + size * (unit() - 0.5))));
        triangles.push(if i % 10 == 0 { [3 * i, 3 * i + 1, 3 * i + 1] } else { [3 * i, 3 * i + 1, 3 * i + 2] });
    }
    Shape::new(positions, triangles)
}
