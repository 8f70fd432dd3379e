//! Parametric shapes as OBJ text: everything is a sheet of quads or a flat polygon.
//!
//! A sheet runs over (s, t) in the unit square; its outside is where ds x dt points. Corners that fall together are
//! written once, so a pole gives triangles. Coordinates are rounded to 1/10000 and printed as integers.

use alloc::string::String;
use alloc::vec::Vec;
use core::f64::consts::TAU;
use core::fmt::Write as _;

use crate::math::{add_scaled, cross, normalize, sub};

/// A position in metres, y up.
pub type Point = [f64; 3];

/// Units per metre of a printed coordinate.
const SCALE: f64 = 10_000.0;

/// An OBJ under construction.
pub struct Writer {
    text: String,
    vertices: usize,
    material: &'static str,
}

impl Writer {
    /// An OBJ that names its material library.
    pub fn new(mtl: &str) -> Writer {
        let mut text = String::new();
        let _ = writeln!(text, "# voxdag demo scene\nmtllib {mtl}");
        Writer { text, vertices: 0, material: "" }
    }

    /// The finished text.
    pub fn finish(self) -> String {
        self.text
    }

    /// Starts a named object.
    pub fn object(&mut self, name: &str) {
        let _ = writeln!(self.text, "o {name}");
    }

    /// Writes a vertex.
    fn vertex(&mut self, p: [i64; 3]) {
        self.text.push('v');
        for x in p {
            let (sign, x) = (if x < 0 { "-" } else { "" }, x.unsigned_abs());
            let _ = write!(self.text, " {sign}{}.{:04}", x / SCALE as u64, x % SCALE as u64);
        }
        self.text.push('\n');
        self.vertices += 1;
    }

    /// Writes a face of vertices that are written already, counted from 0.
    fn face(&mut self, material: &'static str, corners: impl IntoIterator<Item = usize>) {
        if material != self.material {
            self.material = material;
            let _ = writeln!(self.text, "usemtl {material}");
        }
        self.text.push('f');
        for corner in corners {
            let _ = write!(self.text, " {}", corner + 1);
        }
        self.text.push('\n');
    }

    /// A flat polygon, counter-clockwise seen from outside.
    pub fn polygon(&mut self, material: &'static str, points: &[Point]) {
        let first = self.vertices;
        for &p in points {
            self.vertex(rounded(p));
        }
        self.face(material, first..self.vertices);
    }

    /// `cells` quads along s and t over the surface `at(s, t)`, each of the material that `paint(i, j)` names.
    pub fn sheet(
        &mut self,
        cells: [usize; 2],
        paint: impl Fn(usize, usize) -> &'static str,
        at: impl Fn(f64, f64) -> Point,
    ) {
        let [columns, rows] = cells;
        let first = self.vertices;
        let mut points = Vec::with_capacity((columns + 1) * (rows + 1));
        for j in 0..=rows {
            for i in 0..=columns {
                points.push(rounded(at(i as f64 / columns as f64, j as f64 / rows as f64)));
            }
        }
        for &p in &points {
            self.vertex(p);
        }
        for j in 0..rows {
            for i in 0..columns {
                let k = j * (columns + 1) + i;
                let quad = [k, k + 1, k + columns + 2, k + columns + 1];
                let mut corners = Vec::with_capacity(4);
                for (n, &corner) in quad.iter().enumerate() {
                    if points[corner] != points[quad[(n + 1) % 4]] {
                        corners.push(first + corner);
                    }
                }
                if corners.len() >= 3 {
                    self.face(paint(i, j), corners);
                }
            }
        }
    }

    /// The outside of an axis-parallel box.
    pub fn block(&mut self, material: &'static str, min: Point, max: Point) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for (plane, turn) in [(max, false), (min, true)] {
                let mut square: [Point; 4] = [[0.0; 3]; 4];
                for (corner, (a, b)) in square.iter_mut().zip([(0, 0), (1, 0), (1, 1), (0, 1)]) {
                    corner[axis] = plane[axis];
                    corner[u] = [min, max][a][u];
                    corner[v] = [min, max][b][v];
                }
                if turn {
                    square.reverse();
                }
                self.polygon(material, &square);
            }
        }
    }

    /// A profile of (radius, height), from the bottom up, turned around the vertical axis through `foot`.
    pub fn lathe(&mut self, material: &'static str, foot: Point, sides: usize, profile: &[[f64; 2]]) {
        let rows = profile.len() - 1;
        self.sheet(
            [rows, sides],
            |_, _| material,
            |s, t| {
                let [r, y] = profile[libm::rint(s * rows as f64) as usize];
                let (sin, cos) = sin_cos((t + 0.5 / sides as f64) * TAU);
                [foot[0] + r * cos, foot[1] + y, foot[2] + r * sin]
            },
        );
    }

    /// A pipe of the given radius along `path(s)`, which must never run straight towards or from `centre`.
    pub fn tube(
        &mut self,
        material: &'static str,
        cells: [usize; 2],
        centre: Point,
        radius: f64,
        path: impl Fn(f64) -> Point,
    ) {
        const STEP: f64 = 1e-4;
        self.sheet(
            cells,
            |_, _| material,
            |s, t| {
                let p = path(s);
                let along = unit(sub(path(s + STEP), path(s - STEP)));
                let side = unit(cross(along, sub(p, centre)));
                let out = cross(side, along);
                let (sin, cos) = sin_cos(t * TAU);
                add_scaled(add_scaled(p, out, radius * cos), side, -radius * sin)
            },
        );
    }

    /// A sphere.
    pub fn ball(&mut self, material: &'static str, centre: Point, radius: f64, sides: usize) {
        let profile: Vec<[f64; 2]> = arc([0.0, 0.0], radius, -90.0, 90.0, sides / 2).collect();
        self.lathe(material, centre, sides, &profile);
    }
}

/// Points of a circle's arc from angle `from` to angle `to` (degrees, 0 along the first axis), both included.
pub fn arc(centre: [f64; 2], radius: f64, from: f64, to: f64, steps: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..=steps).map(move |i| {
        let (sin, cos) = sin_cos((from + (to - from) * i as f64 / steps as f64) * (TAU / 360.0));
        [centre[0] + radius * cos, centre[1] + radius * sin]
    })
}

/// Sine and cosine, the same bits everywhere.
pub fn sin_cos(angle: f64) -> (f64, f64) {
    (libm::sin(angle), libm::cos(angle))
}

fn unit(a: Point) -> Point {
    normalize(a).unwrap_or([0.0, 1.0, 0.0])
}

fn rounded(p: Point) -> [i64; 3] {
    p.map(|x| libm::rint(x * SCALE) as i64)
}
