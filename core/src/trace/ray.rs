//! A ray, and the times at which it crosses planes: in f64 with a bound on the error, and exactly.
//!
//! A crossing's time is the real number `(k - o) / d` for the plane k and one axis of the ray's origin and direction. Its
//! f64 value carries three roundings, so it is off by at most 3.01 units of 2^-53 of itself; two values that are further
//! apart than [`Ray::time_slack`] are in the right order. A place `o + d t` is off by at most 6.1 such units of its terms;
//! if it is nearer than [`Ray::half`] to the middle of a cell, its voxel is right. Whatever is closer is decided by the
//! sign of `(k - o) d' - (k' - o') d`, summed without rounding ([`super::exact`]). No epsilon is absolute: near the ends
//! of the f64 range, where products may under- or overflow, the slacks are infinite and everything is decided exactly.

use core::cmp::Ordering;

use super::Query;
use super::exact::{self, HUGE, Sum, TINY};

/// The axis of a plain time: the crossing of `plane = t` with origin 0 and direction 1.
const TIME: usize = 3;

/// What a query brings along, worked out once. Axis 3 is time itself.
pub(super) struct Ray {
    origin: [f64; 4],
    dir: [f64; 4],
    /// 1 / dir; infinite where the ray does not move, so that the plane ahead is never reached.
    inverse: [f64; 4],
    /// All ones where the direction is positive (or 0), else 0.
    pub up: [i32; 4],
    /// The octant it heads to: `up` of x, y and z as bits.
    pub octant: usize,
    t_min: f64,
    t_max: f64,
    /// Times below it are certainly below `t_max`.
    pub stop: f64,
    /// Times that are further apart are in the order of their f64 values.
    time_slack: f64,
    /// Places that are further from the middle of a cell than this half of its width are too close to a plane to tell.
    half: f64,
    /// Whether the voxels may lie off the line: by f64 alone, or begun in a voxel that somebody else found.
    strays: bool,
}

/// What the errors of f64 values are measured in, with room to spare: 16 x 2^-53.
pub(super) const UNIT: f64 = f64::from_bits((1023 - 49) << 52);

/// 1.5 x 2^52: adding it rounds to an integer and leaves that in the low bits.
pub(super) const ROUND: f64 = 6_755_399_441_055_744.0;

/// What f64 values are too close to tell.
pub(super) struct Unclear;

/// The largest of three numbers that are no NaN; one instruction a step, where `f64::max` also asks for NaN.
#[inline(always)]
fn largest([a, b, c]: [f64; 3]) -> f64 {
    let ab = if a > b { a } else { b };
    if ab > c { ab } else { c }
}

/// The smallest of three numbers that are no NaN.
#[inline(always)]
fn smallest([a, b, c]: [f64; 3]) -> f64 {
    let ab = if b < a { b } else { a };
    if c < ab { c } else { ab }
}

/// The origin of a query that does not move along some axes, with these coordinates in the middle of their voxel: the ray
/// meets the same voxels, and is clear of all planes. `None` if it moves nowhere, or stands beside the cube.
#[cold]
#[inline(never)]
fn stand_still(query: &Query, size: i32) -> Option<[f64; 3]> {
    let mut origin = query.origin;
    for i in (0..3).filter(|i| query.dir[*i] == 0.0) {
        // Rounding may have put the origin beside the voxel it is to start in, and no step would ever put that right.
        let k = match query.start {
            Some(voxel) if origin[i].is_finite() => f64::from(voxel.decode()[i]),
            None if origin[i] >= 0.0 && origin[i] < f64::from(size) => f64::from(origin[i] as i32),
            _ => return None,
        };
        origin[i] = k + 0.5;
    }
    (query.dir != [0.0; 3]).then_some(origin)
}

/// Something of each axis.
#[inline(always)]
pub(super) fn axes<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

/// `a` or `b`, without a branch: which one is as good as random.
#[inline(always)]
fn select(first: bool, a: i32, b: i32) -> i32 {
    let mask = -i32::from(first);
    b ^ (a ^ b) & mask
}

/// Whether one of the three is true, and no more.
#[inline(always)]
fn alone(flags: [bool; 3]) -> bool {
    u8::from(flags[0]) + u8::from(flags[1]) + u8::from(flags[2]) == 1
}

/// A time at which the ray crosses a plane.
#[derive(Clone, Copy)]
pub(super) struct Crossing {
    pub axis: usize,
    plane: f64,
    /// The time's f64 value.
    pub t: f64,
}

impl Crossing {
    /// A plain time as a crossing.
    pub(super) fn at_time(t: f64) -> Crossing {
        Crossing { axis: TIME, plane: t, t }
    }

    /// Whether it is the plain time before all others: any plane comes after it.
    pub(super) fn is_beginning(&self) -> bool {
        self.axis == TIME && self.t == f64::NEG_INFINITY
    }

    /// Whether it is a plane's, not a plain time.
    pub(super) fn is_plane(&self) -> bool {
        self.axis != TIME
    }
}

impl Ray {
    /// The ray of a query, for a cube of `size` voxels; `None` if it cannot meet that: numbers that are not finite, no
    /// direction, no time between `t_min` and `t_max`, or standing still beside the cube.
    #[inline(always)]
    pub(super) fn new<const EXACT: bool>(query: &Query, size: i32) -> Option<Ray> {
        let Query { origin: mut o, dir: d, t_min, t_max, .. } = *query;
        // The comparison also refuses NaN.
        if !(t_min < t_max) {
            return None;
        }
        let still = axes(|i| d[i] == 0.0);
        if still[0] | still[1] | still[2] {
            o = stand_still(query, size)?;
        }
        // Where a sum is below a bound, all its terms are, and none is NaN.
        let sum = |v: [f64; 3]| v[0].abs() + v[1].abs() + v[2].abs();
        let (far_out, speed) = (sum(o), sum(d));
        let slowest = smallest(axes(|i| if still[i] { 1.0 } else { d[i].abs() }));
        let tame = (far_out <= HUGE) & (speed <= HUGE) & (slowest >= TINY);
        if !tame && !o.iter().chain(&d).all(|x| x.is_finite()) {
            return None;
        }

        let up = axes(|i| if d[i] < 0.0 { 0 } else { -1 });
        let mut ray = Ray {
            origin: [o[0], o[1], o[2], 0.0],
            dir: [d[0], d[1], d[2], 1.0],
            // Of both zeros the positive one: up is where the plane ahead lies.
            inverse: [1.0 / (d[0] + 0.0), 1.0 / (d[1] + 0.0), 1.0 / (d[2] + 0.0), 1.0],
            up: [up[0], up[1], up[2], -1],
            octant: (up[0] & 1 | up[1] & 2 | up[2] & 4) as usize,
            t_min,
            t_max,
            stop: f64::NEG_INFINITY,
            time_slack: f64::INFINITY,
            half: f64::NEG_INFINITY,
            strays: !EXACT || query.start.is_some(),
        };
        // Bound the errors of the f64 values. All times that matter lie between the cube's near and far planes, or are
        // t_min. Where products may under- or overflow, the slacks stay infinite.
        let start = if t_min == f64::NEG_INFINITY { 0.0 } else { t_min.abs() };
        let far = largest([start, largest(ray.nears(size)).abs(), smallest(ray.fars(size)).abs()]);
        if !EXACT {
            (ray.time_slack, ray.half) = (0.0, 1.0);
        } else if tame && (TINY..=HUGE).contains(&far) {
            ray.time_slack = far * UNIT;
            ray.half = 0.5 - (far_out + speed * far + f64::from(size)) * UNIT;
        }
        ray.stop = t_max - ray.time_slack;
        Some(ray)
    }

    /// When the ray crosses the near planes of the cube, which face it, by f64 alone; never where it does not move.
    #[inline(always)]
    fn nears(&self, size: i32) -> [f64; 3] {
        axes(|i| self.t(i, size & !self.up[i]))
    }

    /// When it crosses the far ones.
    #[inline(always)]
    fn fars(&self, size: i32) -> [f64; 3] {
        axes(|i| self.t(i, size & self.up[i]))
    }

    /// Times that are further apart are in the order of their f64 values.
    #[cfg(test)]
    pub(super) fn time_slack(&self) -> f64 {
        self.time_slack
    }

    /// Places that are further from the middle of a cell are too close to a plane to tell.
    #[cfg(test)]
    pub(super) fn half(&self) -> f64 {
        self.half
    }

    /// Whether the ray moves along an axis.
    #[inline(always)]
    pub(super) fn moving(&self, axis: usize) -> bool {
        self.dir[axis] != 0.0
    }

    /// How fast the ray moves along an axis.
    pub(super) fn steepness(&self, axis: usize) -> f64 {
        self.dir[axis].abs()
    }

    /// The f64 value of a crossing's time.
    #[inline(always)]
    fn t(&self, axis: usize, plane: i32) -> f64 {
        (f64::from(plane) - self.origin[axis]) * self.inverse[axis]
    }

    /// The crossing of a plane of an axis.
    #[inline]
    pub(super) fn crossing(&self, axis: usize, plane: i32) -> Crossing {
        Crossing { axis, plane: f64::from(plane), t: self.t(axis, plane) }
    }

    /// The voxel's coordinate on an axis at time `t` by f64 alone, and whether that is certain: no plane is too close.
    #[inline(always)]
    pub(super) fn place(&self, axis: usize, t: f64) -> (i32, bool) {
        let middle = self.origin[axis] + self.dir[axis] * t - 0.5;
        let rounded = middle + ROUND;
        (rounded.to_bits() as i32, (middle - (rounded - ROUND)).abs() < self.half)
    }

    /// The planes through which the ray leaves the cube of `side` (a power of two) around voxel `p`.
    #[inline(always)]
    pub(super) fn planes(&self, p: [i32; 3], side: i32) -> [i32; 3] {
        axes(|i| (p[i] & -side) + (side & self.up[i]))
    }

    /// First and last cell on an axis that the ray can reach from cell `p` before it crosses `plane`.
    #[inline(always)]
    fn ahead(&self, axis: usize, p: i32, plane: i32) -> (i32, i32) {
        let up = self.up[axis];
        ((p & up) | (plane & !up), ((plane - 1) & up) | (p & !up))
    }

    /// The first voxel in the cube, by f64 values alone: `Err` if these are too close to tell, `Ok(None)` if the ray
    /// certainly misses.
    #[inline(always)]
    pub(super) fn enter(&self, size: i32) -> Result<Option<[i32; 3]>, Unclear> {
        let (nears, leave) = (self.nears(size), smallest(self.fars(size)));
        let near = largest(nears);
        let now = if near > self.t_min { near } else { self.t_min };
        if now > leave + self.time_slack {
            return Ok(None);
        }
        // It comes in through one near plane, after t_min, or is inside by then.
        let close = nears.map(|t| !(t < near - self.time_slack));
        let outside = near > self.t_min + self.time_slack;
        let inside = near < self.t_min - self.time_slack;
        let places = axes(|i| self.place(i, now));
        let crossed = axes(|i| close[i] & outside);
        let certain = axes(|i| crossed[i] | places[i].1);
        let clear = certain[0] & certain[1] & certain[2];
        if !((inside | outside & alone(close)) & clear & (now < leave - self.time_slack) & (now < self.stop)) {
            return Err(Unclear);
        }
        Ok(Some(axes(|i| select(crossed[i], (size - 1) & !self.up[i], places[i].0.max(0).min(size - 1)))))
    }

    /// The axis whose plane the ray crossed last on its way into voxel `p`, by f64 values alone; `Err` if these are too
    /// close to tell, or if that was before `t_min`.
    #[inline(always)]
    pub(super) fn entry_axis(&self, p: [i32; 3]) -> Result<usize, Unclear> {
        let t = axes(|i| self.t(i, p[i] + (1 & !self.up[i])));
        let last = largest(t);
        let close = t.map(|t| !(t < last - self.time_slack));
        let axis = usize::from(close[1]) + 2 * usize::from(close[2]);
        if alone(close) & (last > self.t_min + self.time_slack) { Ok(axis) } else { Err(Unclear) }
    }

    /// The voxel in which the ray is once it has left a box around `p` through the first of `planes`; `Err` if f64 values
    /// are too close to tell, or if that may be at `t_max` or later. `single`: the box is one voxel.
    #[inline(always)]
    pub(super) fn step(&self, p: [i32; 3], planes: [i32; 3], single: bool) -> Result<[i32; 3], Unclear> {
        // A branch on the axis is often foreseen, and then nothing waits for the comparison.
        let t = axes(|i| self.t(i, planes[i]));
        if t[1] < t[0] {
            if t[2] < t[1] { self.cross::<2>(p, planes, t, single) } else { self.cross::<1>(p, planes, t, single) }
        } else if t[2] < t[0] {
            self.cross::<2>(p, planes, t, single)
        } else {
            self.cross::<0>(p, planes, t, single)
        }
    }

    /// The same if the plane of axis `A` comes first.
    #[inline(always)]
    fn cross<const A: usize>(
        &self,
        p: [i32; 3],
        planes: [i32; 3],
        t: [f64; 3],
        single: bool,
    ) -> Result<[i32; 3], Unclear> {
        let (b, c) = ((A + 1) % 3, (A + 2) % 3);
        let now = t[A];
        let limit = now + self.time_slack;
        let mut next = p;
        next[A] = planes[A] + !self.up[A];
        // A NaN is neither above nor below, and so counts as close.
        if !((t[b] > limit) & (t[c] > limit) & (now < self.stop)) {
            return Err(Unclear);
        }
        if !single {
            let ((pb, cb), (pc, cc)) = (self.place(b, now), self.place(c, now));
            if !(cb & cc) {
                return Err(Unclear);
            }
            (next[b], next[c]) = (pb, pc);
        }
        if self.strays {
            for i in [b, c] {
                let (low, high) = self.ahead(i, p[i], planes[i]);
                next[i] = next[i].max(low).min(high);
            }
        }
        Ok(next)
    }

    /// The order in which two crossings enter their voxels; equal ones enter together.
    #[inline]
    pub(super) fn order<const EXACT: bool>(&self, a: &Crossing, b: &Crossing) -> Ordering {
        if a.axis == b.axis && a.plane == b.plane {
            return Ordering::Equal;
        }
        let apart = a.t - b.t;
        if apart.abs() > self.time_slack {
            return if apart < 0.0 { Ordering::Less } else { Ordering::Greater };
        }
        let same_time = if EXACT { self.order_exact(a, b) } else { Ordering::Equal };
        // A step in negative direction comes just after its time.
        same_time.then(self.up[a.axis].cmp(&self.up[b.axis]))
    }

    /// The exact order of two finite times.
    #[cold]
    #[inline(never)]
    fn order_exact(&self, a: &Crossing, b: &Crossing) -> Ordering {
        let (da, db) = (self.dir[a.axis], self.dir[b.axis]);
        let mut sum = Sum::ZERO;
        sum.add(a.plane, db);
        sum.add(-self.origin[a.axis], db);
        sum.add(-b.plane, da);
        sum.add(self.origin[b.axis], da);
        let order = sum.sign();
        if (da < 0.0) != (db < 0.0) { order.reverse() } else { order }
    }

    /// The cell on an axis within `low..=high` that the ray is in once `now` has been crossed.
    pub(super) fn cell<const EXACT: bool>(&self, axis: usize, now: &Crossing, low: i32, high: i32) -> i32 {
        let (place, certain) = self.place(axis, now.t);
        let (mut low, mut high) = (low, high);
        if certain {
            return place.max(low).min(high);
        }
        // The place is near a plane: only the cells beside it are left, unless f64 cannot tell at all.
        if self.half > 0.25 {
            (low, high) = (place.saturating_sub(1).max(low).min(high), place.saturating_add(1).max(low).min(high));
        }
        // Bisect: ask of planes whether they have been crossed.
        while low < high {
            let plane = low + (high - low + 1) / 2;
            let crossed = self.order::<EXACT>(&self.crossing(axis, plane), now).is_le();
            if crossed == (self.up[axis] != 0) {
                low = plane;
            } else {
                high = plane - 1;
            }
        }
        low
    }

    /// [`Ray::step`] where f64 values are too close to tell. `None` if the ray leaves the box at `t_max` or later.
    #[cold]
    #[inline(never)]
    pub(super) fn step_close<const EXACT: bool>(&self, mut p: [i32; 3], planes: [i32; 3]) -> Option<[i32; 3]> {
        let mut first: Option<Crossing> = None;
        let mut together = [false; 3];
        for i in (0..3).filter(|i| self.moving(*i)) {
            let crossing = self.crossing(i, planes[i]);
            match first.map(|f| self.order::<EXACT>(&crossing, &f)) {
                Some(Ordering::Greater) => {}
                Some(Ordering::Equal) => together[i] = true,
                None | Some(Ordering::Less) => {
                    first = Some(crossing);
                    together = [false; 3];
                    together[i] = true;
                }
            }
        }
        let now = first?;
        if self.reached_end::<EXACT>(&now) {
            return None;
        }
        for i in 0..3 {
            if together[i] {
                p[i] = planes[i] + !self.up[i];
            } else if self.moving(i) {
                let (low, high) = self.ahead(i, p[i], planes[i]);
                p[i] = self.cell::<EXACT>(i, &now, low, high);
            }
        }
        Some(p)
    }

    /// Whether a crossing comes at or after `t_max`.
    pub(super) fn reached_end<const EXACT: bool>(&self, now: &Crossing) -> bool {
        self.t_max != f64::INFINITY && self.order::<EXACT>(now, &Crossing::at_time(self.t_max)).is_ge()
    }

    /// The time of a crossing, to within one unit in the last place.
    pub(super) fn time(&self, crossing: &Crossing) -> f64 {
        exact::quotient(crossing.plane, self.origin[crossing.axis], self.dir[crossing.axis])
    }
}
