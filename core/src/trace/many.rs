//! Many rays at once, in whatever form they come.
//!
//! In: rays as a list, as columns, or as a tile of a picture, and room for the answers. Out: for each ray the answer that it has
//! alone, bit for bit: by vectors where the tracer has them ([`Tracer::with_level`]), else one by one. No heap.

use super::{Arithmetic, Hit, Query, Tracer, packet, ray};
use crate::geometry::Geometry;

/// Rays from one point through places of a plane: the pixels, or parts of pixels, of a picture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tile<'a> {
    /// Where all rays begin, in grid coordinates.
    pub origin: [f64; 3],
    /// The direction through place (0, 0), of any length.
    pub corner: [f64; 3],
    /// What one unit along x adds to it,
    pub dx: [f64; 3],
    /// and what one along y does.
    pub dy: [f64; 3],
    /// The places; neighbours are best near to each other.
    pub places: &'a [[f64; 2]],
}

impl Tile<'_> {
    /// The direction through a place.
    #[inline]
    pub fn direction(&self, place: [f64; 2]) -> [f64; 3] {
        ray::axes(|i| self.along(i, place))
    }

    #[inline(always)]
    pub(super) fn along(&self, axis: usize, [x, y]: [f64; 2]) -> f64 {
        (self.corner[axis] + self.dx[axis] * x) + self.dy[axis] * y
    }
}

/// Rays as columns, entry `i` of each for ray `i`; there are as many as the shortest column is long. The other fields of
/// their queries are those of [`Query::new`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Columns<'a> {
    /// Where the rays begin: x, y and z in grid coordinates.
    pub origin: [&'a [f64]; 3],
    /// Their directions, of any length.
    pub dir: [&'a [f64]; 3],
    /// Where they end, in units of the direction; `None` if nowhere.
    pub t_max: Option<&'a [f64]>,
}

impl Columns<'_> {
    /// How many rays there are.
    pub fn len(&self) -> usize {
        let columns = self.origin.iter().chain(&self.dir).chain(&self.t_max);
        columns.map(|column| column.len()).min().unwrap_or(0)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Ray `i`; it must be there.
    pub(super) fn query(&self, i: usize) -> Query {
        let t_max = self.t_max.map_or(f64::INFINITY, |column| column[i]);
        Query { t_max, ..Query::new(self.origin.map(|column| column[i]), self.dir.map(|column| column[i])) }
    }
}

impl<'g, G: Geometry> Tracer<'g, G> {
    /// Traces every query; `hits[i]` becomes the answer to `queries[i]`, as far as both slices reach.
    ///
    /// ```
    /// # use voxdag::{Morton, build::DagBuilder, trace::{Arithmetic, Query, Tracer}};
    /// # let mut builder = DagBuilder::new(2).unwrap();
    /// # builder.push(Morton(0), 1).unwrap();
    /// # let built = builder.finish().unwrap();
    /// let tracer = Tracer::new(built.dag()); // one voxel, at (0, 0, 0)
    /// let rays = [Query::new([0.5, 0.5, 9.0], [0.0, 0.0, -2.0]), Query::new([1.5, 0.5, 9.0], [0.0, 0.0, -2.0])];
    /// let mut hits = [None; 2];
    /// tracer.trace_many(Arithmetic::Exact, &rays, &mut hits);
    /// assert_eq!(hits.map(|hit| hit.map(|hit| hit.t)), [Some(4.0), None]);
    /// ```
    #[inline]
    pub fn trace_many(&self, arithmetic: Arithmetic, queries: &[Query], hits: &mut [Option<Hit>]) {
        let count = queries.len().min(hits.len());
        match self.packets(arithmetic, count) {
            Some(packets) => {
                packets.trace(&packet::Made { count, ray: |i| queries[i] }, |i, hit| hits[i] = hit);
            }
            // In place: a copy of each costs some percent.
            None => queries.iter().zip(hits).for_each(|(query, hit)| *hit = self.trace(arithmetic, query)),
        }
    }

    /// Traces `count` rays: `ray(i)` says which, `put(i, hit)` takes the answers, in order. For rays and hits that lie in
    /// memory in a way of their own, such as an array for each coordinate; `ray` may be asked more than once for the same.
    ///
    /// ```
    /// # use voxdag::{Morton, build::DagBuilder, trace::{Arithmetic, Query, Tracer}};
    /// # let mut builder = DagBuilder::new(2).unwrap();
    /// # builder.push(Morton(0), 1).unwrap();
    /// # let built = builder.finish().unwrap();
    /// let tracer = Tracer::new(built.dag()); // one voxel, at (0, 0, 0)
    /// let (x, mut t) = ([0.5, 1.5], [f64::INFINITY; 2]);
    /// let ray = |i: usize| Query::new([x[i], 0.5, 9.0], [0.0, 0.0, -2.0]);
    /// tracer.trace_each(Arithmetic::Exact, 2, ray, |i, hit| t[i] = hit.map_or(t[i], |hit| hit.t));
    /// assert_eq!(t, [4.0, f64::INFINITY]);
    /// ```
    #[inline]
    pub fn trace_each(
        &self,
        arithmetic: Arithmetic,
        count: usize,
        ray: impl Fn(usize) -> Query,
        put: impl FnMut(usize, Option<Hit>),
    ) {
        match self.packets(arithmetic, count) {
            Some(packets) => packets.trace(&packet::Made { count, ray }, put),
            None => {
                let one = |ray: &Query| self.trace(arithmetic, ray);
                in_blocks(count, ray, None, one, put);
            }
        }
    }

    /// Traces rays that come as columns; `hits[i]` becomes the answer to ray `i`, as far as all slices reach.
    ///
    /// ```
    /// # use voxdag::{Morton, build::DagBuilder, trace::{Arithmetic, Columns, Tracer}};
    /// # let mut builder = DagBuilder::new(2).unwrap();
    /// # builder.push(Morton(0), 1).unwrap();
    /// # let built = builder.finish().unwrap();
    /// let tracer = Tracer::new(built.dag()); // one voxel, at (0, 0, 0)
    /// let (zero, half) = ([0.0; 2], [0.5; 2]);
    /// let rays = Columns { origin: [&[0.5, 1.5], &half, &[9.0; 2]], dir: [&zero, &zero, &[-2.0; 2]], t_max: None };
    /// let mut hits = [None; 2];
    /// tracer.trace_columns(Arithmetic::Exact, &rays, &mut hits);
    /// assert_eq!(hits.map(|hit| hit.map(|hit| hit.t)), [Some(4.0), None]);
    /// ```
    pub fn trace_columns(&self, arithmetic: Arithmetic, rays: &Columns<'_>, hits: &mut [Option<Hit>]) {
        let count = rays.len().min(hits.len());
        self.trace_each(arithmetic, count, |i| rays.query(i), |i, hit| hits[i] = hit);
    }

    /// Traces the rays of a tile; `hits[i]` becomes the answer to the ray through `places[i]`, as far as both slices
    /// reach. The answers are those to [`Query::new`]; some hundred rays or more at a time are best.
    ///
    /// ```
    /// # use voxdag::{Morton, build::DagBuilder, trace::{Arithmetic, Tile, Tracer}};
    /// # let mut builder = DagBuilder::new(2).unwrap();
    /// # builder.push(Morton(0), 1).unwrap();
    /// # let built = builder.finish().unwrap();
    /// let tracer = Tracer::new(built.dag()); // one voxel, at (0, 0, 0)
    /// let places = [[0.5, 0.5], [1.5, 0.5]];
    /// let (corner, dx, dy) = ([-0.5, -0.5, -2.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// let tile = Tile { origin: [0.5, 0.5, 9.0], corner, dx, dy, places: &places };
    /// let mut hits = [None; 2];
    /// tracer.trace_tile(Arithmetic::Exact, &tile, &mut hits);
    /// assert_eq!(hits.map(|hit| hit.map(|hit| hit.t)), [Some(4.0), None]);
    /// ```
    #[inline]
    pub fn trace_tile(&self, arithmetic: Arithmetic, tile: &Tile<'_>, hits: &mut [Option<Hit>]) {
        let count = tile.places.len().min(hits.len());
        match self.packets(arithmetic, count) {
            Some(packets) => {
                packets.trace(&Tile { places: &tile.places[..count], ..*tile }, |i, hit| hits[i] = hit);
            }
            None => tile.places.iter().zip(hits).for_each(|(place, hit)| {
                *hit = self.trace(arithmetic, &Query::new(tile.origin, tile.direction(*place)));
            }),
        }
    }

    /// Whether every ray meets any filled voxel; `blocked[i]` becomes the answer to `queries[i]`, as far as both slices
    /// reach.
    ///
    /// ```
    /// # use voxdag::{Morton, build::DagBuilder, trace::{Arithmetic, Query, Tracer}};
    /// # let mut builder = DagBuilder::new(2).unwrap();
    /// # builder.push(Morton(0), 1).unwrap();
    /// # let built = builder.finish().unwrap();
    /// let tracer = Tracer::new(built.dag()); // one voxel, at (0, 0, 0)
    /// let rays = [Query::new([0.5, 0.5, 9.0], [0.0, 0.0, -2.0]), Query::new([1.5, 0.5, 9.0], [0.0, 0.0, -2.0])];
    /// let mut blocked = [false; 2];
    /// tracer.occluded_many(Arithmetic::Exact, &rays, &mut blocked);
    /// assert_eq!(blocked, [true, false]);
    /// ```
    #[inline]
    pub fn occluded_many(&self, arithmetic: Arithmetic, queries: &[Query], blocked: &mut [bool]) {
        let count = queries.len().min(blocked.len());
        match self.packets(arithmetic, count) {
            Some(packets) => {
                packets.occluded(&packet::Made { count, ray: |i| queries[i] }, |i, answer| blocked[i] = answer);
            }
            None => {
                queries.iter().zip(blocked).for_each(|(query, answer)| *answer = self.occluded(arithmetic, query));
            }
        }
    }

    /// [`Tracer::trace_each`] for the question whether a ray meets any filled voxel.
    #[inline]
    pub fn occluded_each(
        &self,
        arithmetic: Arithmetic,
        count: usize,
        ray: impl Fn(usize) -> Query,
        put: impl FnMut(usize, bool),
    ) {
        match self.packets(arithmetic, count) {
            Some(packets) => packets.occluded(&packet::Made { count, ray }, put),
            None => {
                let one = |ray: &Query| self.occluded(arithmetic, ray);
                in_blocks(count, ray, false, one, put);
            }
        }
    }

    /// [`Tracer::trace_columns`] for the question whether a ray meets any filled voxel.
    pub fn occluded_columns(&self, arithmetic: Arithmetic, rays: &Columns<'_>, blocked: &mut [bool]) {
        let count = rays.len().min(blocked.len());
        self.occluded_each(arithmetic, count, |i| rays.query(i), |i, answer| blocked[i] = answer);
    }

    /// What so many rays are traced by; `None` if they are traced one by one.
    fn packets(&self, arithmetic: Arithmetic, count: usize) -> Option<packet::Packets<'_, 'g, G>> {
        if count < FEWEST { None } else { packet::Packets::of(self, arithmetic) }
    }
}

/// Rays from which on vectors are faster than one ray after the other: what they need is laid out once a call. Measured: 12
/// to 15 at every level.
const FEWEST: usize = 16;

/// Answers rays that do not lie in memory as queries: as many are put there as this, as one that was written just before it is
/// read is slow to read. For fewer than half of that it takes longer to make room.
#[inline]
fn in_blocks<T: Copy>(
    count: usize,
    ray: impl Fn(usize) -> Query,
    none: T,
    one: impl Fn(&Query) -> T,
    mut put: impl FnMut(usize, T),
) {
    const BLOCK: usize = 8;
    if count < BLOCK / 2 {
        return (0..count).for_each(|i| put(i, one(&ray(i))));
    }
    let (mut queries, mut answers) = ([Query::new([0.0; 3], [0.0; 3]); BLOCK], [none; BLOCK]);
    for from in (0..count).step_by(BLOCK) {
        let len = BLOCK.min(count - from);
        queries[..len].iter_mut().zip(from..).for_each(|(query, i)| *query = ray(i));
        answers[..len].iter_mut().zip(&queries).for_each(|(answer, query)| *answer = one(query));
        answers[..len].iter().zip(from..).for_each(|(answer, i)| put(i, *answer));
    }
}
