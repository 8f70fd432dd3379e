//! Rays through a DAG: the first filled voxel along the real line that six f64 describe.

mod exact;
mod ray;
mod walk;

use crate::dag::Dag;
use crate::morton::Morton;

/// A ray in grid coordinates (voxel k spans k to k + 1) and what counts as a hit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Query {
    /// Where t is 0.
    pub origin: [f64; 3],
    /// Any length; t is measured in units of it.
    pub dir: [f64; 3],
    /// Hits before it do not count.
    pub t_min: f64,
    /// Hits at or after it do not count.
    pub t_max: f64,
    /// Nodes of this level count as filled if anything in them is: 0 is voxels, 1 cubes of 2^3, and so on.
    pub min_level: u8,
    /// Start in this (empty) voxel instead of where the origin lies: rays that leave a surface name `Hit::from`.
    pub start: Option<Morton>,
}

impl Query {
    /// The half line from `origin` along `dir`, at full resolution.
    pub fn new(origin: [f64; 3], dir: [f64; 3]) -> Query {
        Query { origin, dir, t_min: 0.0, t_max: f64::INFINITY, min_level: 0, start: None }
    }
}

/// The side of a voxel through which a ray came in.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Face {
    /// x = k: the ray runs towards +x.
    NegX,
    /// x = k + 1.
    PosX,
    /// y = k.
    NegY,
    /// y = k + 1.
    PosY,
    /// z = k.
    NegZ,
    /// z = k + 1.
    PosZ,
    /// The ray starts inside the voxel.
    Inside,
}

impl Face {
    /// Outward unit normal; zero for [`Face::Inside`].
    pub const fn normal(self) -> [f32; 3] {
        match self {
            Face::NegX => [-1.0, 0.0, 0.0],
            Face::PosX => [1.0, 0.0, 0.0],
            Face::NegY => [0.0, -1.0, 0.0],
            Face::PosY => [0.0, 1.0, 0.0],
            Face::NegZ => [0.0, 0.0, -1.0],
            Face::PosZ => [0.0, 0.0, 1.0],
            Face::Inside => [0.0; 3],
        }
    }
}

/// Where a ray ends.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Hit {
    /// The voxel; with a `min_level` the first voxel of the cube that was hit.
    pub voxel: Morton,
    /// The last empty voxel before it; `None` if the ray starts in the hit or comes from outside the cube.
    pub from: Option<Morton>,
    /// Entry, in units of the direction; `t_min` if the ray starts inside.
    pub t: f64,
    /// Level of what was hit: 0 a voxel, otherwise the query's `min_level`.
    pub level: u8,
    /// Side of entry.
    pub face: Face,
}

/// How the tracer decides which plane comes first.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Arithmetic {
    /// For the real line, always (the default).
    #[default]
    Exact,
    /// By rounded f64 alone.
    F64,
}

impl Dag<'_> {
    /// The first filled voxel that the ray meets; `None` if there is none, or if the ray is no ray (NaN, infinite
    /// or zero direction).
    pub fn trace(&self, query: &Query) -> Option<Hit> {
        self.trace_with(Arithmetic::Exact, query)
    }

    /// [`Dag::trace`] with the arithmetic named.
    pub fn trace_with(&self, arithmetic: Arithmetic, query: &Query) -> Option<Hit> {
        match arithmetic {
            Arithmetic::Exact => walk::trace::<true>(self, query),
            Arithmetic::F64 => walk::trace::<false>(self, query),
        }
    }

    /// Whether the ray meets any filled voxel: `trace(query).is_some()`, without working out where.
    pub fn occluded(&self, query: &Query) -> bool {
        self.occluded_with(Arithmetic::Exact, query)
    }

    /// [`Dag::occluded`] with the arithmetic named.
    pub fn occluded_with(&self, arithmetic: Arithmetic, query: &Query) -> bool {
        match arithmetic {
            Arithmetic::Exact => walk::occluded::<true>(self, query),
            Arithmetic::F64 => walk::occluded::<false>(self, query),
        }
    }

    /// [`Dag::trace_with`], and the number of rounds of the walk.
    pub fn trace_counted(&self, arithmetic: Arithmetic, query: &Query) -> (Option<Hit>, u32) {
        (self.trace_with(arithmetic, query), 0)
    }
}
