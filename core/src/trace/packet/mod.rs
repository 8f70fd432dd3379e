//! Many rays at once.

mod arrive;
mod enter;
mod step;

use fearless_simd::Simd;

use super::ray::Ray;
use super::top::Top;
use super::walk::{self, walk};
use super::{Arithmetic, Hit, Query, Steps, Tracer};
use crate::geometry::Geometry;
use crate::simd::Level;
use crate::wide::Wide;
use core::sync::atomic::{AtomicU64, Ordering::Relaxed};
#[allow(missing_docs)]
pub static C: [AtomicU64; 4] = [const { AtomicU64::new(0) }; 4];
#[allow(missing_docs)]
pub static T: [AtomicU64; 4] = [const { AtomicU64::new(0) }; 4];

/// Rays that are worked on at a time.
const CHUNK: usize = 256;
/// Room for a whole vector after the last of them.
const ROOM: usize = CHUNK + 16;

/// Where a ray of a chunk ends.
const MISS: u8 = 0;
const HIT: u8 = 1;
/// In a voxel from which f32 cannot tell the way.
const UNCLEAR: u8 = 2;
/// Nothing is known yet.
const WHOLE: u8 = 3;

/// Rays of a chunk as columns, in f64.
struct Rays {
    len: usize,
    origin: [[f64; CHUNK]; 3],
    dir: [[f64; CHUNK]; 3],
    t_min: [f64; CHUNK],
    t_max: [f64; CHUNK],
    start: [[f64; CHUNK]; 3],
    any_start: bool,
    inverse: [[f64; CHUNK]; 3],
    slack: [f64; CHUNK],
}

/// Rays that walk, as columns.
struct Walks {
    len: usize,
    id: [i32; ROOM],
    voxel: [[f32; ROOM]; 3],
    off: [[f32; ROOM]; 3],
    dir: [[f32; ROOM]; 3],
    inverse: [[f32; ROOM]; 3],
    half: [f32; ROOM],
    stop: [f32; ROOM],
    end: [f32; ROOM],
}

/// Where rays ended.
struct Ends {
    how: [u8; CHUNK],
    voxel: [[i32; CHUNK]; 3],
}

/// Hits, as columns.
struct Found {
    code: [u64; CHUNK],
    from: [u64; CHUNK],
    t: [f64; CHUNK],
    /// Axis, or 3 if unclear.
    face: [u8; CHUNK],
}

/// All that a chunk needs.
struct Chunk {
    rays: Rays,
    walks: Walks,
    ends: Ends,
    found: Found,
}

impl Chunk {
    const NEW: Chunk = Chunk {
        rays: Rays {
            len: 0,
            origin: [[0.0; CHUNK]; 3],
            dir: [[1.0; CHUNK]; 3],
            t_min: [0.0; CHUNK],
            t_max: [f64::INFINITY; CHUNK],
            start: [[-1.0; CHUNK]; 3],
            any_start: false,
            inverse: [[1.0; CHUNK]; 3],
            slack: [0.0; CHUNK],
        },
        walks: Walks {
            len: 0,
            id: [0; ROOM],
            voxel: [[0.0; ROOM]; 3],
            off: [[0.0; ROOM]; 3],
            dir: [[0.0; ROOM]; 3],
            inverse: [[0.0; ROOM]; 3],
            half: [0.0; ROOM],
            stop: [0.0; ROOM],
            end: [0.0; ROOM],
        },
        ends: Ends { how: [MISS; CHUNK], voxel: [[0; CHUNK]; 3] },
        found: Found { code: [0; CHUNK], from: [0; CHUNK], t: [0.0; CHUNK], face: [0; CHUNK] },
    };
}

/// What packets walk through.
#[derive(Clone, Copy)]
struct Tables<'a> {
    top: &'a [u32],
    bits: u32,
    level: u32,
    depth: u32,
    words: &'a [u32],
}

/// Traces by packets.
pub(super) fn trace<G: Geometry>(
    tracer: &Tracer<'_, G>,
    level: Level,
    top: &Top<'_>,
    wide: &Wide<'_>,
    exact: bool,
    queries: &[Query],
    hits: &mut [Option<Hit>],
) {
    let tables = Tables {
        top: top.words(),
        bits: top.bits().into(),
        level: top.level() as u32,
        depth: tracer.geometry.depth().into(),
        words: wide.words(),
    };
    let simd = level.token().as_avx512().unwrap();
    let _ = exact;
    use fearless_simd::Simd as _;
    simd.vectorize(#[inline(always)] || stream::<_, G, true>(simd, tracer, &tables, queries, hits));
}

/// Traces a stream.
#[inline(always)]
fn stream<S: Simd, G: Geometry, const EXACT: bool>(
    simd: S,
    tracer: &Tracer<'_, G>,
    tables: &Tables<'_>,
    queries: &[Query],
    hits: &mut [Option<Hit>],
) {
    let mut chunk = Chunk::NEW;
    let size = 1i32 << tracer.geometry.depth();
    for (queries, hits) in queries.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)) {
        let t0 = std::time::Instant::now();
        chunk.rays.fill(queries);
        let t1 = std::time::Instant::now();
        enter::enter(simd, &mut chunk.rays, size, &mut chunk.ends.how, &mut chunk.walks);
        let t2 = std::time::Instant::now();
        step::walk::<S, step::W16, EXACT, false>(simd, tables, &chunk.walks, &mut chunk.ends);
        let t3 = std::time::Instant::now();
        arrive::arrive(simd, &chunk.rays, &chunk.ends, size, &mut chunk.found);
        for (k, (query, hit)) in queries.iter().zip(hits).enumerate() {
            *hit = match chunk.ends.how[k] {
                MISS => None,
                HIT if chunk.found.face[k] < 6 => Some(chunk.found.hit(k)),
                _ => rest(tracer, query, chunk.ends.how[k], chunk.ends.voxel.each_ref().map(|column| column[k])),
            };
        }
        let t4 = std::time::Instant::now();
        T[0].fetch_add((t1 - t0).as_nanos() as u64, Relaxed);
        T[1].fetch_add((t2 - t1).as_nanos() as u64, Relaxed);
        T[2].fetch_add((t3 - t2).as_nanos() as u64, Relaxed);
        T[3].fetch_add((t4 - t3).as_nanos() as u64, Relaxed);
    }
}

/// What lanes left open.
#[cold]
#[inline(never)]
fn rest<G: Geometry>(tracer: &Tracer<'_, G>, query: &Query, how: u8, voxel: [i32; 3]) -> Option<Hit> {
    let size = 1i32 << tracer.geometry.depth();
    if how == WHOLE {
        return tracer.trace(Arithmetic::Exact, query);
    }
    let ray = Ray::new::<true>(query, size)?;
    let (voxel, level) = if how == HIT {
        (voxel, 0)
    } else {
        walk::<true, true, G>(tracer, &ray, voxel, 0, &mut Steps::default())?
    };
    Some(walk::arrive::<true>(&ray, voxel, level, size, query))
}

impl Rays {
    fn fill(&mut self, queries: &[Query]) {
        self.len = queries.len();
        self.any_start = false;
        for (k, query) in queries.iter().enumerate().take(CHUNK) {
            for i in 0..3 {
                self.origin[i][k] = query.origin[i];
                self.dir[i][k] = query.dir[i];
            }
            self.t_min[k] = query.t_min;
            self.t_max[k] = query.t_max;
            self.any_start |= query.start.is_some();
        }
        if self.any_start {
            for (k, query) in queries.iter().enumerate().take(CHUNK) {
                let start = query.start.map_or([-1.0; 3], |start| start.decode().map(f64::from));
                for i in 0..3 {
                    self.start[i][k] = start[i];
                }
            }
        }
    }
}
