//! What is true: the surfaces themselves, before they became voxels.
//!
//! In: a mesh, or one of the known shapes by its formula. Out: what a ray meets, in f64 and in the world's coordinates;
//! from that a picture in the same light as the voxels' ([`draw`]), and how far the voxels' shape is off
//! ([`errors`]). Nothing here knows of voxels but the comparison itself.

mod draw;
mod errors;
mod mesh;
mod shapes;

pub use draw::{Lit, draw, look};
pub use errors::{Deviations, ShapeErrors, shape_errors};
pub use mesh::MeshTruth;
pub use shapes::Known;

use voxdag::material::MaterialId;
use voxdag::math;

/// What a ray meets, in world coordinates.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Met {
    /// Where, in units of the ray's direction, whose length is the caller's choice.
    pub t: f64,
    /// Unit normal that is drawn, towards the viewer's side of the surface.
    pub normal: [f64; 3],
    /// Unit normal of the surface itself, towards the viewer: the side from which light is seen.
    pub side: [f64; 3],
    pub material: MaterialId,
}

/// Surfaces, as rays meet them.
pub trait Truth: Sync {
    /// The first surface along the half line, after t = 0; `None` also for a direction that is none.
    fn nearest(&self, origin: [f64; 3], dir: [f64; 3]) -> Option<Met>;

    /// Whether there is a surface after t = 0 and before `t_max`. The ray is to start clear of the surface it leaves:
    /// see [`Truth::extent`].
    fn occluded(&self, origin: [f64; 3], dir: [f64; 3], t_max: f64) -> bool {
        self.nearest(origin, dir).is_some_and(|met| met.t < t_max)
    }

    /// The longest side of the box around all surfaces, in world units.
    fn extent(&self) -> f64;
}

/// `normal` (not 0, of either side) as a surface shows it whose own unit normal towards the viewer is `side`, at unit
/// length: in the half space of `side`, and, as interpolated normals may point away from a viewer who sees the surface,
/// turned up just so far that it does not. `side` where nothing of it is left.
fn facing(normal: [f64; 3], side: [f64; 3], dir: [f64; 3]) -> [f64; 3] {
    let Some(n) = math::normalize(normal) else { return side };
    let n = if math::dot(n, side) < 0.0 { n.map(|x| -x) } else { n };
    let away = math::dot(n, dir);
    if away <= 0.0 {
        return n;
    }
    math::normalize(math::add_scaled(n, dir, -away / math::dot(dir, dir))).unwrap_or(side)
}

/// A unit normal on the side from which a ray along `dir` comes.
fn towards_viewer(normal: [f64; 3], dir: [f64; 3]) -> [f64; 3] {
    if math::dot(normal, dir) > 0.0 { normal.map(|x| -x) } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_face_the_viewer() {
        let (side, dir) = ([0.0, 0.0, 1.0], [0.0, 3.0, -4.0]);
        let close = |a: [f64; 3], b: [f64; 3]| math::sub(a, b).iter().all(|x| x.abs() < 1e-15);
        // As it is, from behind, and seen at a grazing angle where it would be seen from behind.
        assert_eq!(facing([0.0, 0.0, 2.0], side, dir), side);
        assert!(close(facing([0.0, 0.6, -0.8], side, dir), [0.0, -0.6, 0.8]));
        assert!(close(facing([0.0, 1.0, 0.0], side, dir), [0.0, 0.8, 0.6]));
        // Nothing is left of one along the ray, which has no side either.
        assert_eq!(facing([0.0; 3], side, dir), side);
    }
}
