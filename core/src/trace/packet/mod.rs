//! Many rays at once, in the lanes of vectors: tiles of rays from one point, and streams of any rays.
//!
//! In: a tracer over a wide tree with a top grid, and rays. Out: for each ray the answer of the exact tracer, bit for bit.
//! A chunk of rays goes through three kernels. [`enter`] finds in f64 where they enter the cube and moves their origin
//! there; [`walk`] follows them in f32 lanes, refilled as rays end, and gives up a ray at the first step that f32 cannot
//! tell for certain, in the voxel that it is in; [`arrive`] makes hits of the voxels where rays ended, in f64 again. What
//! was given up is walked on by the scalar tracer from where it is. The bounds are proved in docs/numerics.md. With
//! [`Arithmetic::F32`] no ray is given up on the way: a preview.
//!
//! The kernels depend on neither layout nor source of the rays, so that each exists once for each set of instructions.
//! No heap: a chunk's columns take some 60 kB of stack.

mod arrive;
#[cfg(test)]
mod edge;
mod enter;
mod walk;

use super::ray::{Ray, axes};
use super::{Arithmetic, Hit, Query, Steps, Tile, Tracer, walk as scalar};
use crate::geometry::Geometry;
use crate::simd::Level;
use arrive::Found;
use enter::{Rays, Walks};
use walk::{End, Ends, Tables};

/// Rays that are worked on at a time.
const CHUNK: usize = 256;
/// Lanes of the widest vectors.
const LANES: usize = 16;

/// What answers many rays at once.
#[derive(Clone, Copy)]
pub(super) struct Packets<'a, 'g, G> {
    tracer: &'a Tracer<'g, G>,
    tables: Tables<'a>,
    level: Level,
    /// Rays that f32 cannot tell are followed by f64 and exactly, not by f32.
    exact: bool,
}

/// Where rays come from.
pub(super) trait Source {
    /// How many there are.
    fn len(&self) -> usize;

    /// Fills the columns with the rays from number `from` on.
    fn fill(&self, from: usize, rays: &mut Rays);

    /// One of them.
    fn query(&self, number: usize) -> Query;
}

impl<'a, 'g, G: Geometry> Packets<'a, 'g, G> {
    /// `None` where rays are traced one by one: without vectors, wide tree or top grid, or by f64 alone.
    pub(super) fn of(tracer: &'a Tracer<'g, G>, arithmetic: Arithmetic) -> Option<Self> {
        let (top, level) = (tracer.top.as_ref()?, Level::possible(tracer.level)?);
        let words = tracer.geometry.wide_words().filter(|words| !words.is_empty())?;
        let tables = Tables {
            top: top.words(),
            bits: top.bits().into(),
            level: top.level() as u32,
            depth: tracer.geometry.depth().into(),
            words,
        };
        (arithmetic != Arithmetic::F64 && tables.level.is_multiple_of(2)).then_some(Packets {
            tracer,
            tables,
            level,
            exact: arithmetic == Arithmetic::Exact,
        })
    }

    /// The nearest hit of every ray, in order.
    #[inline(never)] // its columns are not to be room of the caller's
    pub(super) fn trace(&self, source: &impl Source, mut put: impl FnMut(usize, Option<Hit>)) {
        let mut found = Found::ZERO;
        self.each_chunk(source, |from, rays, ends| {
            arrive::arrive(self.level, rays, ends, 1 << self.tables.depth, &mut found);
            for k in 0..rays.len.min(CHUNK) {
                let hit = match ends.how[k] {
                    End::Miss => None,
                    End::Hit if found.is_clear(k) => Some(found.hit(k)),
                    how => self.follow(&source.query(from + k), how, ends.voxel(k)),
                };
                put(from + k, hit);
            }
        });
    }

    /// Whether every ray hits, in order.
    #[inline(never)] // as above
    pub(super) fn occluded(&self, source: &impl Source, mut put: impl FnMut(usize, bool)) {
        self.each_chunk(source, |from, rays, ends| {
            for k in 0..rays.len.min(CHUNK) {
                let blocked = match ends.how[k] {
                    End::Miss => false,
                    End::Hit => true,
                    how => self.follow(&source.query(from + k), how, ends.voxel(k)).is_some(),
                };
                put(from + k, blocked);
            }
        });
    }

    /// Lets rays enter and walk, chunk by chunk.
    #[inline]
    fn each_chunk(&self, source: &impl Source, mut each: impl FnMut(usize, &Rays, &Ends)) {
        let (mut rays, mut walks, mut ends) = (Rays::ZERO, Walks::ZERO, Ends::ZERO);
        for from in (0..source.len()).step_by(CHUNK) {
            rays.len = CHUNK.min(source.len() - from);
            source.fill(from, &mut rays);
            enter::enter(self.level, &mut rays, 1 << self.tables.depth, &mut ends, &mut walks);
            walk::walk(self.level, &self.tables, self.exact, rays.bounded, &walks, &mut ends);
            each(from, &rays, &ends);
        }
    }

    /// What the lanes left open: the whole of a ray, the rest of its way, or how it arrived. By f32 the voxel may lie off the
    /// line; the first step from it, which is not kept in the box, leads back to the line.
    #[cold]
    #[inline(never)]
    fn follow(&self, query: &Query, how: End, voxel: [i32; 3]) -> Option<Hit> {
        if how == End::Whole {
            return self.tracer.trace(Arithmetic::Exact, query);
        }
        let size = 1i32 << self.tables.depth;
        let ray = Ray::new::<true>(query, size)?;
        let voxel = match how {
            End::Hit => voxel,
            _ => scalar::walk::<true, true, G>(self.tracer, &ray, voxel, 0, &mut Steps::default())?.0,
        };
        Some(scalar::arrive::<true>(&ray, voxel, 0, size, query))
    }
}

/// A time that no ray begins at, which leaves it to the scalar tracer.
const ELSEWHERE: f64 = f64::NAN;

/// So many rays, made by number.
pub(super) struct Made<F> {
    pub count: usize,
    pub ray: F,
}

impl<F: Fn(usize) -> Query> Source for Made<F> {
    fn len(&self) -> usize {
        self.count
    }

    #[inline]
    fn fill(&self, from: usize, rays: &mut Rays) {
        (rays.started, rays.bounded) = (false, false);
        for k in 0..rays.len.min(CHUNK) {
            let query = (self.ray)(from + k);
            for i in 0..3 {
                rays.origin[i][k] = query.origin[i];
                rays.dir[i][k] = query.dir[i];
            }
            let usual = query.min_level == 0 && query.start.is_none_or(|start| start.0 >> 63 == 0);
            rays.t_min[k] = if usual { query.t_min } else { ELSEWHERE };
            rays.t_max[k] = query.t_max;
            rays.started |= query.start.is_some();
            rays.bounded |= query.t_max != f64::INFINITY;
        }
        if rays.started {
            for k in 0..rays.len.min(CHUNK) {
                let start = (self.ray)(from + k).start.map_or([-1.0; 3], |start| start.decode().map(f64::from));
                for i in 0..3 {
                    rays.start[i][k] = start[i];
                }
            }
        }
    }

    #[inline]
    fn query(&self, number: usize) -> Query {
        (self.ray)(number)
    }
}

impl Source for Tile<'_> {
    fn len(&self) -> usize {
        self.places.len()
    }

    #[inline]
    fn fill(&self, from: usize, rays: &mut Rays) {
        let places = &self.places[from..][..rays.len.min(CHUNK)];
        (rays.started, rays.bounded) = (false, false);
        (rays.t_min, rays.t_max) = ([0.0; CHUNK], [f64::INFINITY; CHUNK]);
        rays.origin = axes(|i| [self.origin[i]; CHUNK]);
        for i in 0..3 {
            for (dir, place) in rays.dir[i].iter_mut().zip(places) {
                *dir = self.along(i, *place);
            }
        }
    }

    fn query(&self, number: usize) -> Query {
        Query::new(self.origin, self.direction(self.places[number]))
    }
}
