//! Rays: the first filled voxel along each, or whether there is one.

use core::mem::MaybeUninit;

use voxdag::Morton;
use voxdag::trace::{Arithmetic, Face, Hit, Query};

use crate::VOXDAG_NONE;
use crate::border::Caller;
use crate::error::{Failure, VoxdagError, VoxdagStatus};
use crate::scene::{VoxdagScene, with_tracer};

/// How the tracer decides which voxel comes first.
#[repr(u32)]
pub enum VoxdagArithmetic {
    /// For the real line, always (the default).
    Exact = 0,
    /// By rounded double alone.
    F64 = 1,
    /// By rounded float alone, for many rays: a preview. Single rays are exact.
    F32 = 2,
}

/// The side of a voxel through which a ray came in.
#[repr(u32)]
pub enum VoxdagFace {
    /// x = k: the ray runs towards +x.
    NegX = 0,
    /// x = k + 1.
    PosX = 1,
    /// y = k.
    NegY = 2,
    /// y = k + 1.
    PosY = 3,
    /// z = k.
    NegZ = 4,
    /// z = k + 1.
    PosZ = 5,
    /// The ray starts inside the voxel.
    Inside = 6,
    /// The ray missed.
    None = 7,
}

/// A ray in grid coordinates, in which voxel k spans k to k + 1: grid = (world - origin) / voxel_size. A direction in the
/// world's axes is as good, as t is measured in units of it; divided by voxel_size, too, t is that of the world.
/// A ray with a direction that is 0, or with a number that is NaN or infinite where it must not be, misses.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagRay {
    /// Where t is 0.
    pub origin: [f64; 3],
    /// Any length.
    pub direction: [f64; 3],
    /// Hits before it do not count.
    pub t_min: f64,
    /// Hits at or after it do not count; infinity for all.
    pub t_max: f64,
    /// Start in this empty voxel, which the ray passes, instead of where the origin lies: for a ray that leaves a surface, the
    /// `from` of the hit there. `VOXDAG_NONE` for none.
    pub start: u64,
    /// Cubes of 2^min_level voxels a side count as filled if anything in them is; 0 for voxels, at most 21.
    pub min_level: u32,
    /// `VOXDAG_ARITHMETIC_*`; 0 is exact.
    pub arithmetic: u32,
}

/// Where a ray ends.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagHit {
    /// The voxel's Morton code: `voxdag_voxel_position`. `VOXDAG_NONE` if the ray missed.
    pub voxel: u64,
    /// The last empty voxel before it; `VOXDAG_NONE` if the ray starts in the hit or comes from outside the grid.
    pub from: u64,
    /// Entry, in units of the direction; infinity if the ray missed or if it is too large for a number; `t_min` if the ray
    /// starts inside.
    pub t: f64,
    /// 0 for a voxel, else the ray's `min_level`, at most the scene's depth.
    pub level: u32,
    /// `VOXDAG_FACE_*`.
    pub face: u32,
}

/// Many rays as arrays; see `VoxdagRay`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VoxdagRays {
    /// How many rays there are.
    pub count: usize,
    /// 3 * count numbers: x, y, z of each.
    pub origins: *const f64,
    /// 3 * count numbers: x, y, z of each.
    pub directions: *const f64,
    /// count numbers, or null: 0 for all.
    pub t_min: *const f64,
    /// count numbers, or null: infinity for all.
    pub t_max: *const f64,
    /// count voxels, or null: none.
    pub starts: *const u64,
    /// Of all rays.
    pub min_level: u32,
    /// Of all rays.
    pub arithmetic: u32,
}

/// Room for many hits as arrays of as many items as there are rays; see `VoxdagHit`. What is null is not written.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VoxdagHits {
    /// `VOXDAG_NONE` for a miss. Must not be null.
    pub voxels: *mut u64,
    /// May be null.
    pub from: *mut u64,
    /// May be null.
    pub t: *mut f64,
    /// `VOXDAG_FACE_*`; may be null.
    pub faces: *mut u8,
}

/// The ray from (0, 0, 0) without a direction, to be filled in: all hits count, exactly.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_ray_default() -> VoxdagRay {
    VoxdagRay {
        origin: [0.0; 3],
        direction: [0.0; 3],
        t_min: 0.0,
        t_max: f64::INFINITY,
        start: VOXDAG_NONE,
        min_level: 0,
        arithmetic: VoxdagArithmetic::Exact as u32,
    }
}

/// The first filled voxel that a ray meets.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_trace(
    scene: *const VoxdagScene,
    ray: *const VoxdagRay,
    hit: *mut VoxdagHit,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        let (arithmetic, query) = caller.one("ray", ray)?.query()?;
        let found = with_tracer!(scene, tracer => tracer.trace(arithmetic, &query));
        caller.put("hit", hit, found.into())
    })
}

/// The first filled voxel that each of many rays meets: the same answers as one by one, faster with trees, fastest for some
/// hundred rays or more that are near each other. Takes up to 100 KiB of stack, no heap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_trace_many(
    scene: *const VoxdagScene,
    rays: *const VoxdagRays,
    hits: *const VoxdagHits,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        let rays = Rays::new(&caller, rays)?;
        let mut hits = Hits::new(&caller, hits, rays.origins.len())?;
        with_tracer!(scene, tracer => {
            tracer.trace_each(rays.arithmetic, rays.origins.len(), |i| rays.query(i), |i, hit| hits.put(i, hit));
        });
        Ok(())
    })
}

/// Whether a ray meets any filled voxel: 1 or 0 in `blocked`. Faster than to find out where.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_occluded(
    scene: *const VoxdagScene,
    ray: *const VoxdagRay,
    blocked: *mut u8,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        let (arithmetic, query) = caller.one("ray", ray)?.query()?;
        let answer = with_tracer!(scene, tracer => tracer.occluded(arithmetic, &query));
        caller.put("blocked", blocked, answer.into())
    })
}

/// Whether each of many rays meets any filled voxel: 1 or 0 in `blocked`, one byte a ray.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_occluded_many(
    scene: *const VoxdagScene,
    rays: *const VoxdagRays,
    blocked: *mut u8,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        let rays = Rays::new(&caller, rays)?;
        let blocked = caller.room("blocked", blocked, rays.origins.len())?;
        let mut put = |i: usize, answer: bool| _ = blocked[i].write(answer.into());
        with_tracer!(scene, tracer => {
            tracer.occluded_each(rays.arithmetic, rays.origins.len(), |i| rays.query(i), &mut put);
        });
        Ok(())
    })
}

/// The coordinates x, y, z of a voxel, in 3 numbers of `position`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_voxel_position(
    voxel: u64,
    position: *mut u32,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let position = caller.room("position", position, 3)?;
        if voxel >> 63 != 0 {
            return Err(Failure::Item { name: "voxel", position: 0, found: voxel });
        }
        position.iter_mut().zip(Morton(voxel).decode()).for_each(|(place, x)| *place = MaybeUninit::new(x));
        Ok(())
    })
}

/// The voxel at the coordinates x, y, z; `VOXDAG_NONE` if one is 2^21 or more.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_voxel_at(x: u32, y: u32, z: u32) -> u64 {
    Morton::encode([x, y, z]).map_or(VOXDAG_NONE, |voxel| voxel.0)
}

pub(crate) fn arithmetic(number: u32) -> Result<Arithmetic, Failure> {
    [Arithmetic::Exact, Arithmetic::F64, Arithmetic::F32]
        .get(number as usize)
        .copied()
        .ok_or(Failure::Choice { name: "arithmetic", found: number })
}

/// A level of an octree.
fn level(number: u32) -> Result<u8, Failure> {
    u8::try_from(number)
        .ok()
        .filter(|&level| u32::from(level) <= voxdag::morton::BITS)
        .ok_or(Failure::Choice { name: "min_level", found: number })
}

pub(crate) fn voxel(code: u64) -> Option<Morton> {
    (code != VOXDAG_NONE).then_some(Morton(code))
}

impl VoxdagRay {
    fn query(&self) -> Result<(Arithmetic, Query), Failure> {
        let VoxdagRay { origin, direction: dir, t_min, t_max, start, min_level, arithmetic: number } = *self;
        let query = Query { origin, dir, t_min, t_max, min_level: level(min_level)?, start: voxel(start) };
        Ok((arithmetic(number)?, query))
    }
}

impl From<Option<Hit>> for VoxdagHit {
    #[inline]
    fn from(hit: Option<Hit>) -> VoxdagHit {
        let miss = VoxdagHit {
            voxel: VOXDAG_NONE,
            from: VOXDAG_NONE,
            t: f64::INFINITY,
            level: 0,
            face: VoxdagFace::None as u32,
        };
        hit.map_or(miss, |Hit { voxel, from, t, level, face }| VoxdagHit {
            voxel: voxel.0,
            from: from.map_or(VOXDAG_NONE, |from| from.0),
            t,
            level: level.into(),
            face: face as u32,
        })
    }
}

/// The face of a hit; `None` where there is none.
pub(crate) fn face(number: u32) -> Option<Face> {
    Face::ALL.get(number as usize).copied()
}

/// Many rays, checked.
struct Rays<'a> {
    origins: &'a [[f64; 3]],
    directions: &'a [[f64; 3]],
    t_min: Option<&'a [f64]>,
    t_max: Option<&'a [f64]>,
    starts: Option<&'a [u64]>,
    min_level: u8,
    arithmetic: Arithmetic,
}

impl<'a> Rays<'a> {
    fn new(caller: &'a Caller, rays: *const VoxdagRays) -> Result<Rays<'a>, Failure> {
        let rays = caller.one("rays", rays)?;
        Ok(Rays {
            origins: caller.triples("rays.origins", rays.origins, rays.count)?,
            directions: caller.triples("rays.directions", rays.directions, rays.count)?,
            t_min: caller.optional("rays.t_min", rays.t_min, rays.count)?,
            t_max: caller.optional("rays.t_max", rays.t_max, rays.count)?,
            starts: caller.optional("rays.starts", rays.starts, rays.count)?,
            min_level: level(rays.min_level)?,
            arithmetic: arithmetic(rays.arithmetic)?,
        })
    }

    #[inline]
    fn query(&self, i: usize) -> Query {
        Query {
            origin: self.origins[i],
            dir: self.directions[i],
            t_min: self.t_min.map_or(0.0, |t_min| t_min[i]),
            t_max: self.t_max.map_or(f64::INFINITY, |t_max| t_max[i]),
            min_level: self.min_level,
            start: self.starts.and_then(|starts| voxel(starts[i])),
        }
    }
}

/// Room for many hits, checked.
struct Hits<'a> {
    voxels: &'a mut [MaybeUninit<u64>],
    from: Option<&'a mut [MaybeUninit<u64>]>,
    t: Option<&'a mut [MaybeUninit<f64>]>,
    faces: Option<&'a mut [MaybeUninit<u8>]>,
}

impl<'a> Hits<'a> {
    fn new(caller: &'a Caller, hits: *const VoxdagHits, count: usize) -> Result<Hits<'a>, Failure> {
        let hits = caller.one("hits", hits)?;
        Ok(Hits {
            voxels: caller.room("hits.voxels", hits.voxels, count)?,
            from: caller.optional_room("hits.from", hits.from, count)?,
            t: caller.optional_room("hits.t", hits.t, count)?,
            faces: caller.optional_room("hits.faces", hits.faces, count)?,
        })
    }

    #[inline]
    fn put(&mut self, i: usize, hit: Option<Hit>) {
        let hit = VoxdagHit::from(hit);
        self.voxels[i].write(hit.voxel);
        if let Some(from) = &mut self.from {
            from[i].write(hit.from);
        }
        if let Some(t) = &mut self.t {
            t[i].write(hit.t);
        }
        if let Some(faces) = &mut self.faces {
            faces[i].write(hit.face as u8);
        }
    }
}
