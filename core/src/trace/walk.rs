//! The walk of a ray through the DAG, from empty cube to empty cube.
//!
//! State: the voxel `p` that the ray is in, and the crossing that brought it there. Each round finds the largest empty
//! cube around `p` that the octree knows (the ancestors of the last one are kept, so only what changed is looked up),
//! leaves it through the plane that the ray crosses first, and finds the new voxel on the far side. Two questions decide
//! everything: which plane comes first, and whether another plane was crossed by then. Both compare f64 values and ask
//! [`Time::cmp`] where those are too close (`EXACT`). Ties: a crossing in positive direction enters the next voxel at its
//! time, one in negative direction just after it, so at one time all positive axes step, together, then all negative ones.
//! Every round moves `p` forward on some axis and never back on another: at most 3 x 2^21 rounds.

use core::cmp::Ordering;

use super::time::Time;
use super::{Face, Hit, Query};
use crate::dag::{BRICK_LEVEL, Dag};
use crate::morton::Morton;

/// What a ray brings along, worked out once.
struct Ray {
    origin: [f64; 3],
    dir: [f64; 3],
    inverse: [f64; 3],
    moving: [bool; 3],
    positive: [bool; 3],
    t_max: f64,
    /// Times that are further apart than this are in the order of their f64 values.
    time_slack: f64,
    /// Coordinates that are further than this from a plane are on the side that f64 says.
    place_slack: [f64; 3],
}

/// The last crossing: what brought the ray into its voxel.
#[derive(Clone, Copy)]
struct Crossing {
    time: Time,
    /// Its f64 value.
    t: f64,
    /// Whether it enters just after its time (a step in negative direction).
    after: bool,
}

impl Ray {
    fn crossing(&self, axis: usize, plane: i32) -> Crossing {
        let time = Time { plane: f64::from(plane), origin: self.origin[axis], dir: self.dir[axis] };
        Crossing { time, t: self.t(axis, plane), after: !self.positive[axis] }
    }

    #[inline(always)]
    fn t(&self, axis: usize, plane: i32) -> f64 {
        (f64::from(plane) - self.origin[axis]) * self.inverse[axis]
    }

    /// The order in which two crossings enter their voxels; equal ones enter together.
    #[inline]
    fn order<const EXACT: bool>(&self, a: &Crossing, b: &Crossing) -> Ordering {
        let apart = a.t - b.t;
        if apart.abs() > self.time_slack || !EXACT && apart != 0.0 {
            return if apart < 0.0 { Ordering::Less } else { Ordering::Greater };
        }
        if EXACT { a.time.cmp(&b.time).then(a.after.cmp(&b.after)) } else { a.after.cmp(&b.after) }
    }

    /// The cell on `axis` within `low..=high` that the ray is in once `now` has been crossed.
    #[inline(always)]
    fn cell<const EXACT: bool>(&self, axis: usize, now: &Crossing, low: i32, high: i32) -> i32 {
        let x = self.origin[axis] + self.dir[axis] * now.t;
        let cell = x as i32;
        let fraction = x - f64::from(cell);
        let slack = self.place_slack[axis];
        if EXACT && !(fraction > slack && fraction < 1.0 - slack) {
            return self.cell_exact(axis, now, low, high);
        }
        cell.max(low).min(high)
    }

    /// [`Ray::cell`] by bisection: asks of each plane whether it has been crossed.
    #[cold]
    #[inline(never)]
    fn cell_exact(&self, axis: usize, now: &Crossing, low: i32, high: i32) -> i32 {
        let crossed = |plane| self.order::<true>(&self.crossing(axis, plane), now).is_le();
        let (mut low, mut high) = (low, high);
        while low < high {
            let plane = low + (high - low + 1) / 2;
            if crossed(plane) == self.positive[axis] {
                low = plane;
            } else {
                high = plane - 1;
            }
        }
        low
    }
}

/// The axes whose flag is set.
fn axes(flags: [bool; 3]) -> impl Iterator<Item = usize> {
    (0..3).filter(move |i| flags[*i])
}

/// Nearest hit.
#[inline(never)]
pub(super) fn trace<const EXACT: bool>(dag: &Dag<'_>, query: &Query) -> Option<Hit> {
    let (ray, mut p, mut last) = enter::<EXACT>(dag, query)?;
    let level = walk::<EXACT>(dag, &ray, &mut p, &mut last, query.min_level)?;
    Some(arrive::<EXACT>(&ray, p, level, last.as_ref(), 1 << dag.depth(), query.t_min))
}

/// Any hit.
#[inline(never)]
pub(super) fn occluded<const EXACT: bool>(dag: &Dag<'_>, query: &Query) -> bool {
    let Some((ray, mut p, mut last)) = enter::<EXACT>(dag, query) else { return false };
    walk::<EXACT>(dag, &ray, &mut p, &mut last, query.min_level).is_some()
}

/// Moves `p` to the first filled voxel and `last` to the crossing that leads into it; gives the level of what was hit.
#[inline(always)]
fn walk<const EXACT: bool>(
    dag: &Dag<'_>,
    ray: &Ray,
    p: &mut [i32; 3],
    last: &mut Option<Crossing>,
    min_level: u8,
) -> Option<u8> {
    let depth = dag.depth();
    let size = 1i32 << depth;
    let goal = min_level.min(depth);

    let top = depth.max(BRICK_LEVEL) as usize;
    let mut nodes = [0u32; 22];
    nodes[top] = dag.root() as u32;
    let mut level = top;
    let mut brick = 0;
    loop {
        // Go down to the voxel, or to the largest empty cube around it.
        let empty = loop {
            if level <= goal as usize && level > BRICK_LEVEL as usize {
                return Some(goal);
            }
            if level == BRICK_LEVEL as usize {
                brick = dag.brick_at(nodes[level] as usize);
                if goal == BRICK_LEVEL {
                    return Some(goal);
                }
                break 0;
            }
            level -= 1;
            let bit = |i: usize| (p[i] as u32 >> level) & 1;
            let octant = bit(0) | bit(1) << 1 | bit(2) << 2;
            match dag.child(nodes[level + 1] as usize, octant) {
                Some(child) => nodes[level] = child as u32,
                None => break level as u8,
            }
        };
        let mut empty = empty;
        if empty == 0 {
            let block = (p[0] & 2) << 2 | (p[1] & 2) << 3 | (p[2] & 2) << 4;
            let bit = block | (p[0] & 1) | (p[1] & 1) << 1 | (p[2] & 1) << 2;
            let eight = (brick >> block) as u8;
            if eight != 0 {
                if goal == 1 || brick >> bit & 1 != 0 {
                    return Some(goal);
                }
            } else {
                empty = 1;
            }
        }

        // Find the plane of the cube that the ray crosses first.
        let side = 1i32 << empty;
        let mut planes = [0; 3];
        let mut t = [f64::INFINITY; 3];
        for i in 0..3 {
            let low = p[i] & -side;
            planes[i] = if ray.positive[i] { low + side } else { low };
            if ray.moving[i] {
                t[i] = ray.t(i, planes[i]);
            }
        }
        let mut first = usize::from(t[1] < t[0]);
        if t[2] < t[first] {
            first = 2;
        }
        let limit = t[first] + ray.time_slack;
        // `>` is false for NaN, which then counts as close.
        let close = u8::from(!(t[0] > limit)) | u8::from(!(t[1] > limit)) << 1 | u8::from(!(t[2] > limit)) << 2;
        let mut step = 1 << first;
        if close != step {
            (first, step) = first_of_many::<EXACT>(ray, &planes, &t);
        }
        let now = &*last.insert(ray.crossing(first, planes[first]));
        if !(now.t + ray.time_slack < ray.t_max) && reached_end::<EXACT>(ray, now) {
            return None;
        }

        // Step on the axes that cross, and follow the others within the cube.
        let old = *p;
        for i in 0..3 {
            if step >> i & 1 != 0 {
                p[i] = if ray.positive[i] { planes[i] } else { planes[i] - 1 };
            } else if empty != 0 && ray.moving[i] {
                let low = p[i] & -side;
                let (low, high) = if ray.positive[i] { (p[i], low + side - 1) } else { (low, p[i]) };
                p[i] = ray.cell::<EXACT>(i, now, low, high);
            }
        }
        if ((p[0] | p[1] | p[2]) & -size) != 0 {
            return None;
        }
        // The lowest ancestor that the old and the new voxel share is still known.
        let changed = (old[0] ^ p[0] | old[1] ^ p[1] | old[2] ^ p[2]) as u32;
        level = level.max((32 - changed.leading_zeros()) as usize);
    }
}

/// Which axes cross together first, where f64 values are too close to tell.
#[cold]
#[inline(never)]
fn first_of_many<const EXACT: bool>(ray: &Ray, planes: &[i32; 3], t: &[f64; 3]) -> (usize, u8) {
    let mut best: Option<(usize, Crossing)> = None;
    let mut step = 0;
    for i in 0..3 {
        if !ray.moving[i] {
            continue;
        }
        let mut crossing = ray.crossing(i, planes[i]);
        crossing.t = t[i];
        match best.map(|(_, b)| ray.order::<EXACT>(&crossing, &b)) {
            Some(Ordering::Greater) => {}
            Some(Ordering::Equal) => step |= 1 << i,
            None | Some(Ordering::Less) => {
                best = Some((i, crossing));
                step = 1 << i;
            }
        }
    }
    (best.map_or(0, |(i, _)| i), step)
}

/// Whether a crossing comes at or after `t_max`.
#[cold]
#[inline(never)]
fn reached_end<const EXACT: bool>(ray: &Ray, now: &Crossing) -> bool {
    if ray.t_max == f64::INFINITY {
        return false;
    }
    let end = Crossing { time: Time::plain(ray.t_max), t: ray.t_max, after: false };
    ray.order::<EXACT>(now, &end).is_ge()
}

/// Checks the ray and finds its first voxel in the cube, and the crossing that led into the cube (`None` if it starts
/// inside).
fn enter<const EXACT: bool>(dag: &Dag<'_>, query: &Query) -> Option<(Ray, [i32; 3], Option<Crossing>)> {
    let Query { origin, dir, t_min, t_max, .. } = *query;
    let finite = origin.iter().chain(&dir).all(|x| x.is_finite());
    let moving = dir.map(|d| d != 0.0);
    // The comparison also refuses NaN.
    if dag.is_empty() || !finite || moving == [false; 3] || !(t_min < t_max) || t_min == f64::INFINITY {
        return None;
    }
    let size = 1i32 << dag.depth();
    let positive = dir.map(|d| d > 0.0);
    let inverse = dir.map(|d| 1.0 / d);
    let mut ray = Ray {
        origin,
        dir,
        inverse,
        moving,
        positive,
        t_max,
        time_slack: f64::INFINITY,
        place_slack: [f64::INFINITY; 3],
    };
    ray.set_slack(t_min, size);

    // A ray that never moves along an axis must lie within the cube there.
    for i in 0..3 {
        if !moving[i] && !(origin[i] >= 0.0 && origin[i] < f64::from(size)) {
            return None;
        }
    }
    let start = Crossing { time: Time::plain(t_min), t: t_min, after: false };
    if let Some(voxel) = query.start {
        let p = voxel.decode().map(|x| x as i32);
        return (p.iter().all(|x| *x < size) && t_min.is_finite()).then_some((ray, p, None));
    }
    // The ray enters with the last of the planes that face it, unless it has crossed them all at t_min.
    let mut entry: Option<Crossing> = None;
    for i in axes(moving) {
        let near = ray.crossing(i, if positive[i] { 0 } else { size });
        let behind = t_min != f64::NEG_INFINITY && ray.order::<EXACT>(&near, &start).is_le();
        if !behind && entry.is_none_or(|e| ray.order::<EXACT>(&near, &e).is_gt()) {
            entry = Some(near);
        }
    }
    let now = entry.unwrap_or(start);
    if entry.is_some() && !(now.t + ray.time_slack < t_max) && reached_end::<EXACT>(&ray, &now) {
        return None;
    }
    // It misses if it has left through the far plane of an axis by then.
    let mut p = [0; 3];
    for i in 0..3 {
        if !moving[i] {
            p[i] = origin[i] as i32;
            continue;
        }
        let far = ray.crossing(i, if positive[i] { size } else { 0 });
        if ray.order::<EXACT>(&far, &now).is_le() {
            return None;
        }
        p[i] = ray.cell::<EXACT>(i, &now, 0, size - 1);
    }
    Some((ray, p, entry))
}

impl Ray {
    /// Bounds the errors of the f64 values that the walk compares; leaves them infinite where numbers are so small or so
    /// large that products may under- or overflow.
    fn set_slack(&mut self, t_min: f64, size: i32) {
        const TINY: f64 = f64::from_bits((1023 - 900) << 52); // 2^-900
        const HUGE: f64 = f64::from_bits((1023 + 900) << 52); // 2^900
        // 16 roundings of half a unit each; the derivation counts 3 per time.
        const UNIT: f64 = f64::from_bits((1023 - 49) << 52);
        let tame = |x: f64| x == 0.0 || x.abs() >= TINY && x.abs() <= HUGE;
        // All times that matter lie between the cube's near and far planes, or are t_min.
        let mut far = if t_min == f64::NEG_INFINITY { 0.0 } else { t_min.abs() };
        let mut leave = f64::INFINITY;
        let mut enter = f64::NEG_INFINITY;
        for i in axes(self.moving) {
            let (a, b) = (self.t(i, 0), self.t(i, size));
            leave = leave.min(a.max(b));
            enter = enter.max(a.min(b));
        }
        far = far.max(leave.abs()).max(enter.abs());
        if !(self.origin.iter().chain(&self.dir).all(|x| tame(*x)) && far >= TINY && far <= HUGE) {
            return;
        }
        self.time_slack = far * UNIT;
        self.place_slack =
            core::array::from_fn(|i| (self.origin[i].abs() + self.dir[i].abs() * far + f64::from(size)) * UNIT);
    }
}

/// The hit at voxel `p`: entry face, time and the voxel before, from the crossing that led there.
fn arrive<const EXACT: bool>(ray: &Ray, p: [i32; 3], level: u8, last: Option<&Crossing>, size: i32, t_min: f64) -> Hit {
    let side = 1i32 << level;
    let low = p.map(|x| x & -side);
    let code = |p: [i32; 3]| Morton::encode_masked(p.map(|x| x as u32));
    let Some(last) = last else {
        return Hit { voxel: code(low), from: None, t: t_min, level, face: Face::Inside };
    };
    // The axes that crossed together: those whose plane of entry is met at the same time, in the same direction.
    let mut together = [false; 3];
    for i in axes(ray.moving) {
        let plane = if ray.positive[i] { low[i] } else { low[i] + side };
        together[i] = ray.order::<EXACT>(&ray.crossing(i, plane), last).is_eq();
    }
    // Of those the steepest gives the face, then the first.
    let mut face = Face::Inside;
    let mut steepest = 0.0;
    for i in axes(together) {
        if ray.dir[i].abs() > steepest {
            steepest = ray.dir[i].abs();
            face = FACES[i][usize::from(ray.positive[i])];
        }
    }
    let mut from = p;
    for i in axes(together) {
        from[i] += if ray.positive[i] { -1 } else { 1 };
    }
    let inside = from.iter().all(|x| *x >= 0 && *x < size);
    Hit { voxel: code(low), from: inside.then(|| code(from)), t: last.time.value().max(t_min), level, face }
}

/// The face through which a step in negative or positive direction enters, per axis.
const FACES: [[Face; 2]; 3] = [[Face::PosX, Face::NegX], [Face::PosY, Face::NegY], [Face::PosZ, Face::NegZ]];
