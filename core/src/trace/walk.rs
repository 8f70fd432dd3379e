//! The walk of a ray through the octree, from empty cube to empty cube.
//!
//! State: the voxel `p` that the ray is in. Each round finds the largest empty
//! cube around `p` that the octree knows (the ancestors of the last one are kept, so only what changed is looked up),
//! leaves it through the plane that the ray crosses first, and finds the new voxel on the far side. Two questions decide
//! everything: which plane comes first, and which planes were crossed by then. Both are answered from f64 values where
//! these are further apart than their errors, else in [`Ray::step_close`], exactly. Ties: a crossing in positive
//! direction enters the next voxel at its time, one in negative direction just after it, so at one time all positive axes
//! step, together, then all negative ones. A round moves `p` forward on some axis and back on none: at most 3 x 2^21.

use core::cmp::Ordering;

use super::ray::{Crossing, Ray, Unclear, axes};
use super::top::Cell;
use super::{Face, Hit, Query, Steps, Tracer};
use crate::dag::BRICK_LEVEL;
use crate::geometry::Geometry;
use crate::morton::Morton;

/// Nearest hit, and what it took.
#[inline(never)]
pub(super) fn trace<const EXACT: bool, const TOP: bool, G: Geometry>(
    tracer: &Tracer<'_, G>,
    query: &Query,
) -> (Option<Hit>, Steps) {
    let mut steps = Steps::default();
    let size = 1i32 << tracer.geometry.depth();
    let Some((ray, start)) = begin::<EXACT>(query, size) else { return (None, steps) };
    let found = walk::<EXACT, TOP, G>(tracer, &ray, start, query.min_level, &mut steps);
    (found.map(|(p, level)| arrive::<EXACT>(&ray, p, level, size, query)), steps)
}

/// Any hit.
#[inline(never)]
pub(super) fn occluded<const EXACT: bool, const TOP: bool, G: Geometry>(tracer: &Tracer<'_, G>, query: &Query) -> bool {
    let size = 1i32 << tracer.geometry.depth();
    let Some((ray, start)) = begin::<EXACT>(query, size) else { return false };
    walk::<EXACT, TOP, G>(tracer, &ray, start, query.min_level, &mut Steps::default()).is_some()
}

/// The ray of a query and its first voxel in a cube of `size` voxels; `None` for a miss.
#[inline(always)]
pub(super) fn begin<const EXACT: bool>(query: &Query, size: i32) -> Option<(Ray, [i32; 3])> {
    let ray = Ray::new::<EXACT>(query, size)?;
    if let Some(voxel) = query.start {
        let p = voxel.decode().map(|x| x as i32);
        return p.iter().all(|x| *x < size).then_some((ray, p));
    }
    let first = match ray.enter(size) {
        Ok(first) => first,
        Err(Unclear) => enter_close::<EXACT>(&ray, query, size),
    };
    first.map(|p| (ray, p))
}

/// From voxel `p` to the first filled one, and the level of what was hit. With `TOP` the tracer has a top grid, and its
/// cells are no smaller than `min_level`.
#[inline(never)]
pub(super) fn walk<const EXACT: bool, const TOP: bool, G: Geometry>(
    tracer: &Tracer<'_, G>,
    ray: &Ray,
    mut p: [i32; 3],
    min_level: u8,
    steps: &mut Steps,
) -> Option<([i32; 3], u8)> {
    let geometry = tracer.geometry;
    let depth = geometry.depth();
    let outside = -1i32 << depth;
    if geometry.is_empty() {
        return None;
    }
    let goal = min_level.min(depth);
    // The way down ends at a brick, or at the first node that counts as filled.
    let floor = goal.max(BRICK_LEVEL) as usize;
    let mut level = depth.max(BRICK_LEVEL) as usize;
    let mut nodes = [0u32; 32];
    nodes[level & 31] = geometry.root();
    let top = if TOP { tracer.top } else { None };
    loop {
        steps.rounds += 1;
        let (planes, single) = 'empty: {
            // Above the top grid's cells, look up the cell: its node, or the box that is empty ahead.
            if let Some(top) = &top
                && level > top.level()
            {
                match top.cell(p, ray.octant) {
                    Cell::Node(node) => {
                        level = top.level();
                        nodes[level & 31] = node;
                    }
                    Cell::Empty(planes) => {
                        level = top.level() + 1;
                        break 'empty (planes, false);
                    }
                }
            }
            // Go down to the largest empty cube around the voxel.
            while level > floor {
                level -= 1;
                let bit = |i: usize| (p[i] as u32 >> level) & 1;
                let octant = bit(0) | bit(1) << 1 | bit(2) << 2;
                match geometry.child(nodes[(level + 1) & 31], level as u8 + 1, octant) {
                    Some(child) => nodes[level & 31] = child,
                    None => break 'empty (ray.planes(p, 1 << level), false),
                }
            }
            if floor > BRICK_LEVEL as usize {
                return Some((p, goal));
            }
            // In a brick, look at the voxel and at the 2^3 around it.
            let brick = geometry.brick_at(nodes[BRICK_LEVEL as usize]);
            let block = (p[0] & 2) << 2 | (p[1] & 2) << 3 | (p[2] & 2) << 4;
            let eight = (brick >> block) as u8;
            let bit = (p[0] & 1) | (p[1] & 1) << 1 | (p[2] & 1) << 2;
            if eight >> bit & 1 != 0 || goal > 0 && (goal == BRICK_LEVEL || eight != 0) {
                return Some((p, goal));
            }
            (ray.planes(p, 1 + i32::from(eight == 0)), eight != 0)
        };

        // Leave the box through the plane that comes first, and follow the ray on the other axes.
        let next = match ray.step(p, planes, single) {
            Ok(next) => next,
            Err(Unclear) => {
                steps.close += 1;
                ray.step_close::<EXACT>(p, planes)?
            }
        };
        if (next[0] | next[1] | next[2]) & outside != 0 {
            return None;
        }
        // The lowest ancestor that the old and the new voxel share is still known.
        let changed = (p[0] ^ next[0] | p[1] ^ next[1] | p[2] ^ next[2]) as u32;
        level = level.max((changed | 1).ilog2() as usize + 1);
        p = next;
    }
}

/// The first voxel in the cube where f64 values are too close to tell; `None` for a miss.
#[cold]
#[inline(never)]
fn enter_close<const EXACT: bool>(ray: &Ray, query: &Query, size: i32) -> Option<[i32; 3]> {
    // The ray enters with the last of the planes that face it, unless it has crossed them all at t_min.
    let start = Crossing::at_time(query.t_min);
    let mut now = start;
    for i in (0..3).filter(|i| ray.moving(*i)) {
        let near = ray.crossing(i, size & !ray.up[i]);
        if now.is_beginning() || ray.order::<EXACT>(&near, &now).is_gt() {
            now = near;
        }
    }
    if !(now.t < ray.stop) && ray.reached_end::<EXACT>(&now) {
        return None;
    }
    // It misses if it has left through the far plane of an axis by then.
    let mut p = [0; 3];
    for i in 0..3 {
        if !ray.moving(i) {
            p[i] = query.origin[i] as i32;
            continue;
        }
        if ray.order::<EXACT>(&ray.crossing(i, size & ray.up[i]), &now).is_le() {
            return None;
        }
        let first = (size - 1) & !ray.up[i];
        p[i] = if now.axis == i { first } else { ray.cell::<EXACT>(i, &now, 0, size - 1) };
    }
    Some(p)
}

/// The face through which a step in negative or positive direction enters, per axis.
pub(super) const FACES: [[Face; 2]; 3] = [[Face::PosX, Face::NegX], [Face::PosY, Face::NegY], [Face::PosZ, Face::NegZ]];

/// The later of two times; of both zeros the one that was asked for, where `f64::max` may give either.
#[inline(always)]
fn later(t: f64, t_min: f64) -> f64 {
    if t > t_min { t } else { t_min }
}

/// The hit at voxel `p`: entry face, time and the voxel before.
#[inline]
pub(super) fn arrive<const EXACT: bool>(ray: &Ray, p: [i32; 3], level: u8, size: i32, query: &Query) -> Hit {
    let side = 1i32 << level;
    let low = p.map(|x| x & -side);
    let code = |p: [i32; 3]| Morton::encode_masked(p.map(|x| x as u32));
    let started = |p: [i32; 3]| query.start.is_some_and(|start| start == code(p));

    // One plane came last.
    if let Ok(i) = ray.entry_axis(p)
        && !started(p)
    {
        let positive = ray.up[i] != 0;
        let before = if positive { p[i] - 1 } else { p[i] + 1 };
        let entry = if positive { p[i] == low[i] } else { p[i] == low[i] + side - 1 };
        let face = if entry { FACES[i][usize::from(positive)] } else { Face::Inside };
        let t = later(ray.time(&ray.crossing(i, p[i] + (1 & !ray.up[i]))), query.t_min);
        let inside = before >= 0 && before < size;
        let from = inside.then(|| code(axes(|k| if k == i { before } else { p[k] })));
        return Hit { voxel: code(low), from, t, level, face };
    }
    arrive_close::<EXACT>(ray, p, level, size, query)
}

/// The same where f64 values are too close to tell.
#[cold]
#[inline(never)]
fn arrive_close<const EXACT: bool>(ray: &Ray, p: [i32; 3], level: u8, size: i32, query: &Query) -> Hit {
    let side = 1i32 << level;
    let low = p.map(|x| x & -side);
    let code = |p: [i32; 3]| Morton::encode_masked(p.map(|x| x as u32));
    // The ray came in with the last of the voxel's planes that face it; those met at the same time in the same direction
    // were crossed together.
    let mut last = Crossing::at_time(query.t_min);
    let mut together = [false; 3];
    for i in (0..3).filter(|i| ray.moving(*i)) {
        let entry = ray.crossing(i, p[i] + (1 & !ray.up[i]));
        let order = if last.is_beginning() { Ordering::Greater } else { ray.order::<EXACT>(&entry, &last) };
        if order.is_gt() {
            last = entry;
            together = [false; 3];
        }
        together[i] = order.is_gt() || order.is_eq() && last.is_plane();
    }
    if !last.is_plane() || query.start == Some(code(p)) {
        return Hit { voxel: code(low), from: None, t: query.t_min, level, face: Face::Inside };
    }
    // Of those that led into the cube, too, the steepest gives the face, or else the first.
    let (mut from, mut face, mut steepest) = (p, Face::Inside, 0.0);
    for i in (0..3).filter(|i| together[*i]) {
        let positive = ray.up[i] != 0;
        from[i] += if positive { -1 } else { 1 };
        let entry = if positive { p[i] == low[i] } else { p[i] == low[i] + side - 1 };
        if entry && ray.steepness(i) > steepest {
            steepest = ray.steepness(i);
            face = FACES[i][usize::from(positive)];
        }
    }
    let inside = from.iter().all(|x| *x >= 0 && *x < size);
    Hit { voxel: code(low), from: inside.then(|| code(from)), t: later(ray.time(&last), query.t_min), level, face }
}
