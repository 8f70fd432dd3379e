//! The surface's direction at a hit, from the occupancy around it (Pineda 2021, section 4.3) or as stored.
//!
//! In: a DAG, a hit on it and the ray's direction. Out: always a unit vector on the viewer's side, and how it was found.
//! Exact integer moments decide every degenerate case, so what happens does not depend on where a neighbourhood lies or
//! how it is turned:
//!
//! * a plane if the voxels are flat enough (l0 / l1 <= 0.6), otherwise the gradient, otherwise the entry face;
//! * voxels on a line: the view direction made perpendicular to it, otherwise the entry face.
//!
//! Side: `n . d < 0`; if that is 0, `n . face > 0`; if that is 0 too, the face. (The thesis asks the face alone, which
//! leaves normals that point away from the viewer.)

mod plane;
mod window;

use crate::dag::Dag;
use crate::materials::Materials;
use crate::math;
use crate::morton::Morton;
use crate::trace::{Face, Hit};
use plane::Fit;
use window::Moments;

/// Where normals come from, in the order of what they cost, the stored ones aside.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum NormalKind {
    /// The side of the voxel through which the ray came.
    Face,
    /// As kept with the materials; [`NormalKind::Plane2`] where none is.
    Stored,
    /// From the six neighbours (section 4.3.1): one of 26 directions.
    Gradient,
    /// The plane through the 3^3 voxels around: about 6 degrees off on a curved surface.
    Plane1,
    /// The plane through the 5^3 voxels around: about 2 degrees off (the default).
    #[default]
    Plane2,
    /// The plane through the 7^3 voxels around: about 1 degree off, and wider corners.
    Plane3,
}

/// How a normal was found, hence how far to trust it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Confidence {
    /// Side of entry: asked for, or nothing better is known.
    Face,
    /// Kept with the materials.
    Stored,
    /// Difference of the six neighbours.
    Gradient,
    /// The voxels around form a line; the direction is that of the viewer, made perpendicular to it.
    Line,
    /// A fitted plane.
    Plane {
        /// Smallest by middle eigenvalue, l0 / l1: 0 is flat, 0.6 the thickest that counts as a plane.
        ratio: f32,
    },
}

/// A normal, and how it was found.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Normal {
    /// Unit length, on the side the ray comes from.
    pub direction: [f32; 3],
    /// How it was found.
    pub confidence: Confidence,
}

/// The normal at `hit`, which a ray along `dir` (grid coordinates, any length) found in `dag`.
///
/// Total: also for a voxel that is not filled or a direction that is none, the answer is a unit vector.
pub fn normal<M: Materials>(dag: Dag<'_>, materials: M, hit: &Hit, dir: [f64; 3], kind: NormalKind) -> Normal {
    let view = View { dir, face: entry_face(hit.face, dir) };
    let stored = || {
        let n = materials.normal(dag, hit.voxel)?;
        view.facing(n.map(f64::from), Confidence::Stored)
    };
    let found = match kind {
        NormalKind::Face => None,
        NormalKind::Stored => stored().or_else(|| view.plane(dag, hit.voxel, 2)),
        NormalKind::Gradient => view.gradient(dag, hit.voxel),
        NormalKind::Plane1 => view.plane(dag, hit.voxel, 1),
        NormalKind::Plane2 => view.plane(dag, hit.voxel, 2),
        NormalKind::Plane3 => view.plane(dag, hit.voxel, 3),
    };
    found.unwrap_or(Normal { direction: view.face.map(|x| x as f32), confidence: Confidence::Face })
}

/// What decides on the side.
struct View {
    dir: [f64; 3],
    /// Unit normal of the side of entry.
    face: [f64; 3],
}

impl View {
    /// From the voxels at most `radius` away along each axis; `None`: entry face.
    fn plane(&self, dag: Dag<'_>, voxel: Morton, radius: u32) -> Option<Normal> {
        match plane::fit(&Moments::around(dag, voxel, radius)) {
            Fit::Point => None,
            Fit::Line(line) => {
                // line x (dir x line) = dir |line|^2 - line (line . dir), exactly 0 if they are parallel.
                let across = math::cross(line, math::cross(self.dir, line));
                self.facing(across, Confidence::Line)
            }
            Fit::Solid => self.gradient(dag, voxel),
            Fit::Plane { normal, ratio } => self.facing(normal, Confidence::Plane { ratio: ratio as f32 }),
        }
    }

    /// From filled to empty among the six neighbours; outside the cube is empty. `None`: entry face.
    fn gradient(&self, dag: Dag<'_>, voxel: Morton) -> Option<Normal> {
        let filled = |axis: usize, step: i32| {
            let mut offset = [0; 3];
            offset[axis] = step;
            f64::from(u8::from(voxel.neighbour(offset).is_some_and(|v| dag.contains(v))))
        };
        self.facing(core::array::from_fn(|i| filled(i, -1) - filled(i, 1)), Confidence::Gradient)
    }

    /// `n` at unit length, on the viewer's side; `None` if it has no direction or no side.
    fn facing(&self, n: [f64; 3], confidence: Confidence) -> Option<Normal> {
        let n = math::normalize(n)?;
        let away = math::dot(n, self.dir);
        // Where the plane is seen edge-on, the side of entry decides.
        let towards = if away != 0.0 { -away } else { math::dot(n, self.face) };
        let direction = if towards > 0.0 {
            n
        } else if towards < 0.0 {
            n.map(|x| -x)
        } else {
            return None;
        };
        Some(Normal { direction: direction.map(|x| x as f32), confidence })
    }
}

/// Unit normal of the side of entry; for a ray that starts inside, against the largest component of its direction.
fn entry_face(face: Face, dir: [f64; 3]) -> [f64; 3] {
    if face != Face::Inside {
        return face.normal().map(f64::from);
    }
    let mut axis = 0;
    for i in 1..3 {
        if dir[i].abs() > dir[axis].abs() {
            axis = i;
        }
    }
    let mut normal = [0.0; 3];
    normal[axis] = if dir[axis] > 0.0 { -1.0 } else { 1.0 };
    normal
}
