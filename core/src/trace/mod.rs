//! Rays through a voxel geometry: the first filled voxel along the real line that six f64 describe.

mod along;
#[cfg(all(test, feature = "alloc"))]
mod edge;
mod exact;
mod many;
mod packet;
mod ray;
mod top;
mod walk;

pub use along::{Hits, Voxels};
pub use many::{Columns, Tile};
pub use top::Top;
#[cfg(feature = "alloc")]
pub use top::TopBuf;

use crate::dag::{BRICK_LEVEL, Dag};
use crate::geometry::Geometry;
use crate::morton::Morton;
use crate::simd::Level;

/// A ray in grid coordinates (voxel k spans k to k + 1) and what counts as a hit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Query {
    /// Where t is 0.
    pub origin: [f64; 3],
    /// Any length; t is measured in units of it.
    pub dir: [f64; 3],
    /// Hits before it do not count.
    pub t_min: f64,
    /// Hits at or after it do not count (the true time decides; `Hit::t` may round to it).
    pub t_max: f64,
    /// Nodes of this level count as filled if anything in them is: 0 is voxels, 1 cubes of 2^3, and so on.
    pub min_level: u8,
    /// Start in this (empty) voxel instead of where the origin lies: rays that leave a surface name `Hit::from`. It is to
    /// be one that the line passes, up to rounding; from any other the ray drifts back to the line, by ways not specified.
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
    /// All of them, the six sides first.
    pub const ALL: [Face; 7] = [Face::NegX, Face::PosX, Face::NegY, Face::PosY, Face::NegZ, Face::PosZ, Face::Inside];

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
    /// Level of what was hit: 0 a voxel, otherwise the query's `min_level`, at most the depth.
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
    /// By rounded f32 alone, where many rays are traced at once by vectors ([`Tracer::with_level`]): a preview. Rays that
    /// are traced one by one are exact, which costs no more.
    F32,
}

/// What the walk of a ray took.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Steps {
    /// Boxes of empty space and voxels looked at.
    pub rounds: u32,
    /// Of these the ones left where f64 values are too close to tell which plane or which voxel comes next, so that exact
    /// arithmetic decides.
    pub close: u32,
}

/// A geometry and, if there is one, its top grid: what answers rays. The answers depend on neither the layout nor the grid.
#[derive(Clone, Copy, Debug)]
pub struct Tracer<'a, G = Dag<'a>> {
    geometry: G,
    top: Option<Top<'a>>,
    level: Option<Level>,
}

impl<'a, G: Geometry> Tracer<'a, G> {
    /// Traces the geometry as it is.
    pub fn new(geometry: G) -> Tracer<'a, G> {
        Tracer { geometry, top: None, level: None }
    }

    /// Traces with a top grid, which must have been made from these words; `None` if its size says that it was not.
    pub fn with_top(geometry: G, top: Top<'a>) -> Option<Tracer<'a, G>> {
        top.fits(&geometry).then_some(Tracer { geometry, top: Some(top), level: None })
    }

    /// Traces many rays at once by vectors of this level. It takes a [`Wide`](crate::wide::Wide) tree with a top grid whose
    /// cells are of even level ([`Top::bits_for_packets`]); without these, and for `None`, rays are traced one by one.
    pub fn with_level(self, level: Option<Level>) -> Tracer<'a, G> {
        Tracer { level, ..self }
    }

    /// What was given to [`Tracer::with_level`].
    #[inline]
    pub(crate) fn level(&self) -> Option<Level> {
        self.level
    }

    /// What many rays at once are traced by, if they are 16 or more; `None` if they are traced one by one.
    pub fn packet_level(&self) -> Option<Level> {
        packet::Packets::of(self, Arithmetic::Exact).and(self.level)
    }

    /// The geometry.
    pub fn geometry(&self) -> G {
        self.geometry
    }

    /// Level of the nodes at which a search from above begins: the top grid's, or the root's.
    #[inline]
    pub(crate) fn entry_level(&self) -> u32 {
        match &self.top {
            Some(top) => top.level() as u32,
            None => u32::from(self.geometry.depth().max(BRICK_LEVEL)),
        }
    }

    /// The node of that level around a voxel in the cube; `None` if it is empty.
    #[inline]
    pub(crate) fn entry(&self, voxel: [u32; 3]) -> Option<u32> {
        match &self.top {
            Some(top) => top.node(voxel),
            None => (!self.geometry.is_empty()).then(|| self.geometry.root()),
        }
    }

    /// The first filled voxel that the ray meets; `None` if there is none, or if the ray is no ray (NaN, infinite
    /// or zero direction).
    #[inline]
    pub fn trace(&self, arithmetic: Arithmetic, query: &Query) -> Option<Hit> {
        self.trace_counted(arithmetic, query).0
    }

    /// [`Tracer::trace`], and what the walk took.
    pub fn trace_counted(&self, arithmetic: Arithmetic, query: &Query) -> (Option<Hit>, Steps) {
        match (arithmetic, self.serves(query)) {
            (Arithmetic::Exact | Arithmetic::F32, true) => walk::trace::<true, true, G>(self, query),
            (Arithmetic::Exact | Arithmetic::F32, false) => walk::trace::<true, false, G>(self, query),
            (Arithmetic::F64, true) => walk::trace::<false, true, G>(self, query),
            (Arithmetic::F64, false) => walk::trace::<false, false, G>(self, query),
        }
    }

    /// Whether the ray meets any filled voxel: `trace(..).is_some()`, without working out where.
    pub fn occluded(&self, arithmetic: Arithmetic, query: &Query) -> bool {
        match (arithmetic, self.serves(query)) {
            (Arithmetic::Exact | Arithmetic::F32, true) => walk::occluded::<true, true, G>(self, query),
            (Arithmetic::Exact | Arithmetic::F32, false) => walk::occluded::<true, false, G>(self, query),
            (Arithmetic::F64, true) => walk::occluded::<false, true, G>(self, query),
            (Arithmetic::F64, false) => walk::occluded::<false, false, G>(self, query),
        }
    }

    /// Whether there is a top grid that this query can use.
    #[inline]
    fn serves(&self, query: &Query) -> bool {
        self.top.is_some_and(|top| usize::from(query.min_level) <= top.level())
    }
}

impl Dag<'_> {
    /// The first filled voxel that the ray meets; `None` if there is none, or if the ray is no ray (NaN, infinite
    /// or zero direction).
    pub fn trace(&self, query: &Query) -> Option<Hit> {
        self.trace_with(Arithmetic::Exact, query)
    }

    /// [`Dag::trace`] with the arithmetic named.
    pub fn trace_with(&self, arithmetic: Arithmetic, query: &Query) -> Option<Hit> {
        Tracer::new(*self).trace(arithmetic, query)
    }

    /// Whether the ray meets any filled voxel: `trace(query).is_some()`, without working out where.
    pub fn occluded(&self, query: &Query) -> bool {
        self.occluded_with(Arithmetic::Exact, query)
    }

    /// [`Dag::occluded`] with the arithmetic named.
    pub fn occluded_with(&self, arithmetic: Arithmetic, query: &Query) -> bool {
        Tracer::new(*self).occluded(arithmetic, query)
    }

    /// [`Tracer::trace_counted`] without a top grid.
    pub fn trace_counted(&self, arithmetic: Arithmetic, query: &Query) -> (Option<Hit>, Steps) {
        Tracer::new(*self).trace_counted(arithmetic, query)
    }
}
