//! Rays that go on: every filled voxel along a ray, and every voxel at all.
//!
//! The same walk as for the first hit, taken up again behind each one; exact, and in the order in which the ray meets them.

use super::ray::Ray;
use super::walk::{arrive, begin, walk};
use super::{Hit, Query, Steps, Tracer};
use crate::dag::Dag;
use crate::geometry::Geometry;
use crate::morton::{BITS, Morton};

/// Iterator over the filled voxels along a ray. See [`Tracer::hits`].
pub struct Hits<'a, G = Dag<'a>> {
    tracer: Tracer<'a, G>,
    query: Query,
    /// The ray and the voxel to go on from; `None` at the end.
    next: Option<(Ray, [i32; 3])>,
}

/// Iterator over the voxels that a ray passes, filled or not. See [`Query::voxels`].
pub struct Voxels {
    size: i32,
    next: Option<(Ray, [i32; 3])>,
}

/// The voxel behind the cube of `side` around `p`; `None` outside the cube of `size` voxels or at `t_max`.
fn behind(ray: &Ray, p: [i32; 3], side: i32, size: i32) -> Option<[i32; 3]> {
    let planes = ray.planes(p, side);
    let next = ray.step(p, planes, side == 1).ok().or_else(|| ray.step_close::<true>(p, planes))?;
    next.iter().all(|x| *x >= 0 && *x < size).then_some(next)
}

impl<'a, G: Geometry> Tracer<'a, G> {
    /// All filled voxels that the ray meets between `t_min` and `t_max`, in order, exactly: picking through what is in
    /// front. With a `min_level` all cubes of that level that hold one.
    ///
    /// ```
    /// # use voxdag::{Morton, build::DagBuilder, trace::{Query, Tracer}};
    /// let mut builder = DagBuilder::new(2)?;
    /// builder.push(Morton(0), 1 | 1 << 8)?; // voxels (0, 0, 0) and (2, 0, 0)
    /// let built = builder.finish()?;
    /// let query = Query::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
    /// let times: Vec<f64> = Tracer::new(built.dag()).hits(&query).map(|hit| hit.t).collect();
    /// assert_eq!(times, [1.0, 3.0]);
    /// # Ok::<(), voxdag::build::BuildError>(())
    /// ```
    pub fn hits(&self, query: &Query) -> Hits<'a, G> {
        let next = if self.geometry.is_empty() { None } else { begin::<true>(query, 1 << self.geometry.depth()) };
        Hits { tracer: *self, query: *query, next }
    }
}

impl<G: Geometry> Iterator for Hits<'_, G> {
    type Item = Hit;

    fn next(&mut self) -> Option<Hit> {
        let (ray, p) = self.next.take()?;
        let size = 1 << self.tracer.geometry.depth();
        let min_level = self.query.min_level;
        let (p, level) = if self.tracer.serves(&self.query) {
            walk::<true, true, G>(&self.tracer, &ray, p, min_level, &mut Steps::default())?
        } else {
            walk::<true, false, G>(&self.tracer, &ray, p, min_level, &mut Steps::default())?
        };
        let hit = arrive::<true>(&ray, p, level, size, &self.query);
        self.next = behind(&ray, p, 1 << level, size).map(|next| (ray, next));
        Some(hit)
    }
}

impl Query {
    /// All voxels that the ray passes between `t_min` and `t_max` in a cube of `2^depth` voxels a side (depth at most 21),
    /// in order, exactly, whether anything fills them or not: lines of sight, marking, carving. `min_level` is ignored.
    ///
    /// ```
    /// # use voxdag::trace::Query;
    /// let diagonal = Query { t_max: 3.0, ..Query::new([0.5, 0.5, 0.5], [1.0, 1.0, 0.0]) };
    /// let passed: Vec<_> = diagonal.voxels(2).map(|voxel| voxel.decode()).collect();
    /// assert_eq!(passed, [[0, 0, 0], [1, 1, 0], [2, 2, 0], [3, 3, 0]]);
    /// ```
    pub fn voxels(&self, depth: u8) -> Voxels {
        let size = 1 << u32::from(depth).min(BITS);
        Voxels { size, next: begin::<true>(self, size) }
    }
}

impl Iterator for Voxels {
    type Item = Morton;

    fn next(&mut self) -> Option<Morton> {
        let (ray, p) = self.next.take()?;
        self.next = behind(&ray, p, 1, self.size).map(|next| (ray, next));
        Some(Morton::encode_masked(p.map(|x| x as u32)))
    }
}
