//! The walk of a ray through the DAG, from empty cube to empty cube.
//!
//! State: the voxel `p` that the ray is in, and the crossing that brought it there. Each round finds the largest empty
//! cube around `p` that the octree knows (the ancestors of the last one are kept, so only what changed is looked up),
//! leaves it through the plane that the ray crosses first, and finds the new voxel on the far side. Two questions decide
//! everything: which plane comes first, and which planes were crossed by then. Both are answered from f64 values where
//! these are further apart than their errors, else in [`Ray::step_close`], exactly. Ties: a crossing in positive
//! direction enters the next voxel at its time, one in negative direction just after it, so at one time all positive axes
//! step, together, then all negative ones. A round moves `p` forward on some axis and back on none: at most 3 x 2^21.

use super::ray::{Crossing, Ray};
use super::{Face, Hit, Query};
use crate::dag::{BRICK_LEVEL, Dag};
use crate::morton::Morton;

/// Nearest hit.
#[inline(never)]
pub(super) fn trace<const EXACT: bool>(dag: &Dag<'_>, query: &Query) -> Option<Hit> {
    let (ray, start, entry) = enter::<EXACT>(dag, query)?;
    let (p, last, level) = walk::<EXACT>(dag, &ray, start, entry, query.min_level)?;
    Some(arrive::<EXACT>(&ray, p, level, last, 1 << dag.depth(), query.t_min))
}

/// Any hit.
#[inline(never)]
pub(super) fn occluded<const EXACT: bool>(dag: &Dag<'_>, query: &Query) -> bool {
    let Some((ray, start, entry)) = enter::<EXACT>(dag, query) else { return false };
    walk::<EXACT>(dag, &ray, start, entry, query.min_level).is_some()
}

/// From voxel `p` to the first filled one: that voxel, the crossing that leads into it (`None` if the ray starts there),
/// and the level of what was hit.
#[inline(always)]
fn walk<const EXACT: bool>(
    dag: &Dag<'_>,
    ray: &Ray,
    mut p: [i32; 3],
    mut last: Option<Crossing>,
    min_level: u8,
) -> Option<([i32; 3], Option<Crossing>, u8)> {
    let depth = dag.depth();
    let outside = -1i32 << depth;
    let goal = min_level.min(depth);
    let mut level = depth.max(BRICK_LEVEL) as usize;
    let mut nodes = [0u32; 22];
    nodes[level] = dag.root() as u32;
    loop {
        // Go down to a brick, or to the largest empty cube around the voxel.
        let mut empty = loop {
            if level <= goal as usize && level > BRICK_LEVEL as usize {
                return Some((p, last, goal));
            }
            if level == BRICK_LEVEL as usize {
                break 0;
            }
            level -= 1;
            let bit = |i: usize| (p[i] as u32 >> level) & 1;
            let octant = bit(0) | bit(1) << 1 | bit(2) << 2;
            match dag.child(nodes[level + 1] as usize, octant) {
                Some(child) => nodes[level] = child as u32,
                None => break level,
            }
        };
        // In a brick, look at the voxel and at the 2^3 around it.
        if empty == 0 {
            let brick = dag.brick_at(nodes[BRICK_LEVEL as usize] as usize);
            let block = (p[0] & 2) << 2 | (p[1] & 2) << 3 | (p[2] & 2) << 4;
            let eight = (brick >> block) as u8;
            let bit = (p[0] & 1) | (p[1] & 1) << 1 | (p[2] & 1) << 2;
            if eight >> bit & 1 != 0 || goal > 0 && (goal == BRICK_LEVEL || eight != 0) {
                return Some((p, last, goal));
            }
            empty = usize::from(eight == 0);
        }

        // Leave the cube through the plane that comes first, and follow the ray on the other axes.
        let side = 1i32 << empty;
        let planes: [i32; 3] = core::array::from_fn(|i| (p[i] & -side) + (side & ray.up[i]));
        let t: [f64; 3] = core::array::from_fn(|i| ray.t(i, planes[i]));
        let mut first = usize::from(t[1] < t[0]);
        first = if t[2] < t[first] { 2 } else { first };
        let now = t[first];
        let limit = now + ray.time_slack;
        let close = |i: usize| i != first && !(t[i] > limit);
        let (places, doubt) = ray.places(now);
        let old = p;
        // A NaN is neither above nor below, and so counts as close.
        if close(0) | close(1) | close(2) | !(now < ray.stop) | (doubt & !(1 << first) != 0 && side > 1) {
            let crossing;
            (p, crossing) = ray.step_close::<EXACT>(p, side, &planes)?;
            last = Some(crossing);
        } else {
            for i in 0..3 {
                let (low, high) = ray.ahead(i, p[i], side);
                p[i] = places[i].max(low).min(high);
            }
            p[first] = planes[first] + !ray.up[first];
            last = Some(Crossing { axis: first, plane: f64::from(planes[first]), t: now });
        }
        if (p[0] | p[1] | p[2]) & outside != 0 {
            return None;
        }
        // The lowest ancestor that the old and the new voxel share is still known.
        let changed = (old[0] ^ p[0] | old[1] ^ p[1] | old[2] ^ p[2]) as u32;
        level = level.max((32 - changed.leading_zeros()) as usize);
    }
}

/// Checks the ray and finds its first voxel in the cube, and the crossing that led into the cube (`None` if it starts
/// inside).
#[inline(always)]
fn enter<const EXACT: bool>(dag: &Dag<'_>, query: &Query) -> Option<(Ray, [i32; 3], Option<Crossing>)> {
    if dag.is_empty() {
        return None;
    }
    let size = 1i32 << dag.depth();
    let ray = Ray::new::<EXACT>(query, size)?;
    let start = Crossing::at_time(query.t_min);
    if let Some(voxel) = query.start {
        let p = voxel.decode().map(|x| x as i32);
        let inside = p.iter().all(|x| *x < size) && query.t_min.is_finite();
        return inside.then_some((ray, p, None));
    }
    // The ray enters with the last of the planes that face it, unless it has crossed them all at t_min.
    let mut entry: Option<Crossing> = None;
    for i in (0..3).filter(|i| ray.moving(*i)) {
        let near = ray.crossing(i, size & !ray.up[i]);
        let behind = query.t_min != f64::NEG_INFINITY && ray.order::<EXACT>(&near, &start).is_le();
        if !behind && entry.is_none_or(|e| ray.order::<EXACT>(&near, &e).is_gt()) {
            entry = Some(near);
        }
    }
    let now = entry.unwrap_or(start);
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
        let far = ray.crossing(i, size & ray.up[i]);
        if ray.order::<EXACT>(&far, &now).is_le() {
            return None;
        }
        p[i] = ray.cell::<EXACT>(i, &now, 0, size - 1);
    }
    Some((ray, p, entry))
}

/// The face through which a step in negative or positive direction enters, per axis.
const FACES: [[Face; 2]; 3] = [[Face::PosX, Face::NegX], [Face::PosY, Face::NegY], [Face::PosZ, Face::NegZ]];

/// The hit at voxel `p`: entry face, time and the voxel before, from the crossing that led there.
fn arrive<const EXACT: bool>(ray: &Ray, p: [i32; 3], level: u8, last: Option<Crossing>, size: i32, t_min: f64) -> Hit {
    let side = 1i32 << level;
    let low = p.map(|x| x & -side);
    let code = |p: [i32; 3]| Morton::encode_masked(p.map(|x| x as u32));
    let Some(last) = last else {
        return Hit { voxel: code(low), from: None, t: t_min, level, face: Face::Inside };
    };
    // The axes that crossed together are those whose plane of entry into the voxel is met at the same time, in the same
    // direction; of those that led into the cube, too, the steepest gives the face, or else the first.
    let (mut from, mut face, mut steepest) = (p, Face::Inside, 0.0);
    for i in (0..3).filter(|i| ray.moving(*i)) {
        let plane = p[i] + (1 & !ray.up[i]);
        if ray.order::<EXACT>(&ray.crossing(i, plane), &last).is_eq() {
            let positive = ray.up[i] != 0;
            from[i] += if positive { -1 } else { 1 };
            if plane == low[i] + (side & !ray.up[i]) && ray.steepness(i) > steepest {
                steepest = ray.steepness(i);
                face = FACES[i][usize::from(positive)];
            }
        }
    }
    let inside = from.iter().all(|x| *x >= 0 && *x < size);
    Hit { voxel: code(low), from: inside.then(|| code(from)), t: ray.time(&last).max(t_min), level, face }
}
