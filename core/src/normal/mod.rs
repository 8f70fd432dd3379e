//! The surface's direction at a hit, from the occupancy around it (Pineda 2021, section 4.3) or as stored.
//!
//! In: a geometry, a hit on it and the ray's direction. Out: always a unit vector out of the surface, and how it was found.
//! Exact integer moments decide every degenerate case, so neither the place of a neighbourhood nor how it is turned
//! matters: a plane if the voxels are flat enough (l0 / l1 <= 0.6), otherwise the gradient, otherwise the entry face;
//! for voxels on a line the view direction made perpendicular to it, otherwise the entry face.
//!
//! Side: of a plane's two normals the one along `face - d + (voxel - centre)`, with the entry face's normal, the ray's
//! unit direction, and the centre of the filled voxels around; if neither is, the entry face. Differs from the thesis,
//! which asks the face alone and errs for up to 24 % of the hits on bumpy floors, and from `n . d < 0`, which errs for
//! 0.3 to 2 % on balls, where voxels beyond the horizon stick out. In the same pictures the sum never did. Planes and
//! sides as the thesis has them are the kinds named after Ernerfeldt.

mod batch;
mod cubes;
mod ernerfeldt;
mod lanes;
mod plane;
mod window;

pub use batch::normals;

use crate::geometry::Geometry;
use crate::materials::Materials;
use crate::math;
use crate::trace::{Face, Hit, Tracer};
use cubes::{Alone, Windows};
use plane::Fit;
use window::{Moments, Window};

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
    /// The thesis's plane through the 3^3 voxels around (section 4.3.2), on the side of the entry face: 4 degrees off on
    /// a wall two voxels thick, and of a mirror image another one. To compare with.
    Ernerfeldt1,
    /// The thesis's plane through the 5^3 voxels around: 10 degrees off on two parallel sheets.
    Ernerfeldt2,
}

impl NormalKind {
    /// All of them.
    pub const ALL: [NormalKind; 8] = [
        NormalKind::Face,
        NormalKind::Stored,
        NormalKind::Gradient,
        NormalKind::Plane1,
        NormalKind::Plane2,
        NormalKind::Plane3,
        NormalKind::Ernerfeldt1,
        NormalKind::Ernerfeldt2,
    ];
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
    /// The weighted sum of regressions along the three axes, which says nothing about its own quality.
    Regression,
}

/// A normal, and how it was found.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Normal {
    /// Unit length, out of the surface on the side the ray comes from. It may lean away from the viewer where the
    /// surface does: a voxel behind the horizon that sticks out.
    pub direction: [f32; 3],
    /// How it was found.
    pub confidence: Confidence,
}

/// The normal at `hit`, which a ray along `dir` (grid coordinates, any length) found in the tracer's geometry; a tracer
/// with a top grid is faster.
///
/// Total: also for a voxel that is not filled or a direction that is none, the answer is a unit vector.
pub fn normal<G: Geometry, M: Materials>(
    tracer: &Tracer<'_, G>,
    materials: M,
    hit: &Hit,
    dir: [f64; 3],
    kind: NormalKind,
) -> Normal {
    one(&mut Alone(tracer), materials, hit, dir, kind)
}

/// The normal at `hit`.
#[inline]
fn one<M: Materials>(windows: &mut impl Windows, materials: M, hit: &Hit, dir: [f64; 3], kind: NormalKind) -> Normal {
    let (view, center) = (View::new(hit.face, dir), hit.voxel.decode());
    let stored = || {
        let n = math::normalize(materials.normal(hit.voxel)?.map(f64::from))?;
        oriented(n, view.outwards, Confidence::Stored)
    };
    let found = match kind {
        NormalKind::Face => None,
        NormalKind::Stored => stored().or_else(|| view.plane(&windows.window::<2>(center), plane::fit)),
        NormalKind::Gradient => view.gradient(&windows.window::<1>(center)),
        NormalKind::Plane1 => view.plane(&windows.window::<1>(center), plane::fit),
        NormalKind::Plane2 => view.plane(&windows.window::<2>(center), plane::fit),
        NormalKind::Plane3 => view.plane(&windows.window::<3>(center), plane::fit),
        NormalKind::Ernerfeldt1 => view.plane(&windows.window::<1>(center), ernerfeldt::fit),
        NormalKind::Ernerfeldt2 => view.plane(&windows.window::<2>(center), ernerfeldt::fit),
    };
    found.unwrap_or_else(|| view.entry())
}

/// Where a hit is seen from.
struct View {
    /// Unit direction of the ray; 0 if it has none.
    dir: [f64; 3],
    /// Unit normal of the side of entry.
    face: [f64; 3],
    /// Out of the surface as far as the ray tells: `face`, less the ray's unit direction.
    outwards: [f64; 3],
}

impl View {
    fn new(face: Face, dir: [f64; 3]) -> View {
        let face = entry_face(face, dir);
        let dir = math::normalize(dir).unwrap_or([0.0; 3]);
        View { dir, face, outwards: math::sub(face, dir) }
    }

    /// The side of entry.
    fn entry(&self) -> Normal {
        Normal { direction: self.face.map(|x| x as f32), confidence: Confidence::Face }
    }

    /// From the voxels in a window; `None`: entry face.
    fn plane<const RADIUS: usize>(&self, window: &Window<RADIUS>, fit: fn(&Moments) -> Fit) -> Option<Normal> {
        let moments = window.sums().moments();
        match fit(&moments) {
            Fit::Point => None,
            Fit::Line(line) => {
                // line x (dir x line) = dir |line|^2 - line (line . dir), exactly 0 if they are parallel, and as small as
                // f64 goes if they nearly are.
                let across = math::normalize(math::cross(line, math::cross(self.dir, line)))?;
                oriented(across, self.dir.map(|x| -x), Confidence::Line)
            }
            Fit::Solid => self.gradient(window),
            Fit::Regression(normal) => oriented(normal, self.face, Confidence::Regression),
            Fit::Plane { normal, ratio } => {
                let outwards = math::add_scaled(self.outwards, moments.out_of_center(RADIUS), 1.0);
                oriented(normal, outwards, Confidence::Plane { ratio: ratio as f32 })
            }
        }
    }

    /// From filled to empty among the six neighbours in the middle of a window; outside the cube is empty. `None`: entry
    /// face.
    fn gradient<const RADIUS: usize>(&self, window: &Window<RADIUS>) -> Option<Normal> {
        let filled = |axis: usize, at: usize| {
            let mut neighbour = [RADIUS; 3];
            neighbour[axis] = at;
            f64::from(u8::from(window.contains(neighbour)))
        };
        let gradient = core::array::from_fn(|i| filled(i, RADIUS - 1) - filled(i, RADIUS + 1));
        oriented(gradient, self.outwards, Confidence::Gradient)
    }
}

/// `n`, whose square is far from the limits of f64, at unit length and turned `outwards`; `None` if it is 0 or at right
/// angles to it.
fn oriented(n: [f64; 3], outwards: [f64; 3], confidence: Confidence) -> Option<Normal> {
    let side = math::dot(n, outwards);
    let scale = if side > 0.0 {
        1.0
    } else if side < 0.0 {
        -1.0
    } else {
        return None;
    } / math::sqrt(math::dot(n, n));
    Some(Normal { direction: n.map(|x| (x * scale) as f32), confidence })
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
