//! The exact ray oracle: which half-open voxels `[k, k+1)^3` a real line meets, and in which order, by big rationals.
//!
//! In: six f64 taken as the dyadic rationals that they are, and `t_min <= t < t_max`. Out: the walk through a cube of
//! side 2^L, and the first voxel that is filled, found by descent through cubes, so that depth 21 is no matter.
//!
//! One idea makes ties simple. An [`Instant`] is a time t, or "just after t". On an axis with d > 0 the line is in
//! `[lo, hi)` from the time of lo until the time of hi; with d < 0 from just after the time of hi until just after the
//! time of lo. Every such [`Span`] is half-open in the order of instants, and so is `t_min <= t < t_max`: a voxel is met
//! exactly if the intersection of four spans has its start before its end. Positive axes that cross at t step at t,
//! together; negative ones just after, together.

use voxdag::trace::Face;

use crate::num::Rational;

/// A ray in grid coordinates.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ray {
    /// Where t is 0.
    pub origin: [f64; 3],
    /// Any length; t is in units of it.
    pub dir: [f64; 3],
    /// The first t that counts.
    pub t_min: f64,
    /// The first t that does not count any more.
    pub t_max: f64,
}

impl Ray {
    /// The half line from `origin` along `dir`.
    pub fn new(origin: [f64; 3], dir: [f64; 3]) -> Ray {
        Ray { origin, dir, t_min: 0.0, t_max: f64::INFINITY }
    }
}

/// A time, with both infinities.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Time {
    /// Before every time.
    Past,
    /// A finite time.
    At(Rational),
    /// After every time.
    Future,
}

/// A time (`after` is false) or just after it, before every later time.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Instant {
    /// The time.
    pub time: Time,
    /// Whether just after it.
    pub after: bool,
}

impl Instant {
    fn at(time: Rational) -> Instant {
        Instant { time: Time::At(time), after: false }
    }

    fn just_after(time: Rational) -> Instant {
        Instant { time: Time::At(time), after: true }
    }

    fn from_f64(t: f64) -> Option<Instant> {
        let time = match Rational::from_f64(t) {
            Some(t) => Time::At(t),
            None if t.is_nan() => return None,
            None => {
                if t < 0.0 {
                    Time::Past
                } else {
                    Time::Future
                }
            }
        };
        Some(Instant { time, after: false })
    }
}

/// The instants from `start`, included, to `end`, excluded.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Span {
    /// The first instant.
    pub start: Instant,
    /// The first instant that is not part of it.
    pub end: Instant,
}

impl Span {
    /// What both have; `None` if nothing.
    pub fn and(&self, other: &Span) -> Option<Span> {
        let start = (&self.start).max(&other.start);
        let end = (&self.end).min(&other.end);
        (start < end).then(|| Span { start: start.clone(), end: end.clone() })
    }
}

/// A ray as exact numbers.
#[derive(Clone, Debug)]
pub struct Line {
    origin: [Rational; 3],
    dir: [Rational; 3],
    /// `t_min <= t < t_max`.
    range: Span,
}

/// Where a ray ends, in truth.
#[derive(Clone, PartialEq, Debug)]
pub struct Truth {
    /// The voxel, or the first voxel of the cube that was asked for.
    pub voxel: [u32; 3],
    /// When the ray enters it; `t_min` if it starts inside.
    pub time: Rational,
    /// The f64 nearest to `time`.
    pub t: f64,
    /// The side of entry.
    pub face: Face,
    /// The voxel (of side 1) in which the ray was immediately before; `None` if it starts inside the hit or comes from
    /// outside the cube.
    pub from: Option<[u32; 3]>,
}

impl Line {
    /// `None` if the ray is none: NaN anywhere, an infinite origin or direction, a zero direction.
    pub fn new(ray: &Ray) -> Option<Line> {
        let exact = |v: [f64; 3]| -> Option<[Rational; 3]> {
            Some([Rational::from_f64(v[0])?, Rational::from_f64(v[1])?, Rational::from_f64(v[2])?])
        };
        let (origin, dir) = (exact(ray.origin)?, exact(ray.dir)?);
        let range = Span { start: Instant::from_f64(ray.t_min)?, end: Instant::from_f64(ray.t_max)? };
        dir.iter().any(|d| d.sign() != 0).then_some(Line { origin, dir, range })
    }

    /// When the line crosses the plane `x_axis = k`; the axis must move.
    fn crossing(&self, axis: usize, k: i64) -> Rational {
        self.origin[axis].from_int(k).over(&self.dir[axis])
    }

    /// When the line enters the half-space of the cells behind plane k (in its own direction of travel).
    fn step(&self, axis: usize, k: i64) -> Instant {
        let time = self.crossing(axis, k);
        if self.dir[axis].sign() > 0 { Instant::at(time) } else { Instant::just_after(time) }
    }

    /// While `lo <= x_axis < hi`; `None` if never.
    fn slab(&self, axis: usize, lo: i64, hi: i64) -> Option<Span> {
        match self.dir[axis].sign() {
            0 => {
                let inside = Rational::from(lo) <= self.origin[axis] && self.origin[axis] < Rational::from(hi);
                let ever = Span {
                    start: Instant { time: Time::Past, after: false },
                    end: Instant { time: Time::Future, after: true },
                };
                inside.then_some(ever)
            }
            1 => Some(Span { start: self.step(axis, lo), end: self.step(axis, hi) }),
            _ => Some(Span { start: self.step(axis, hi), end: self.step(axis, lo) }),
        }
    }

    /// While the ray is in the half-open cube; `None` if never.
    pub fn span(&self, corner: [i64; 3], side: i64) -> Option<Span> {
        let mut span = self.range.clone();
        for axis in 0..3 {
            span = span.and(&self.slab(axis, corner[axis], corner[axis] + side)?)?;
        }
        Some(span)
    }

    /// The voxel that the line is in at an instant; the instant must be finite.
    fn voxel_at(&self, instant: &Instant) -> [i64; 3] {
        core::array::from_fn(|axis| {
            let x = self.position(axis, &instant.time);
            let leaves_a_plane_downwards = instant.after && self.dir[axis].sign() < 0;
            let k = if leaves_a_plane_downwards { x.ceil().map(|k| k - 1) } else { x.floor() };
            k.expect("inside the cube")
        })
    }

    /// The voxel that the line is in immediately before an instant.
    fn voxel_before(&self, instant: &Instant) -> Option<[i64; 3]> {
        let mut voxel = [0; 3];
        for axis in 0..3 {
            let x = self.position(axis, &instant.time);
            let comes_to_a_plane_from_below = !instant.after && self.dir[axis].sign() > 0;
            voxel[axis] = if comes_to_a_plane_from_below { x.ceil()? - 1 } else { x.floor()? };
        }
        Some(voxel)
    }

    fn position(&self, axis: usize, time: &Time) -> Rational {
        let Time::At(t) = time else { panic!("no position at infinity") };
        self.origin[axis].plus(&self.dir[axis].times(t))
    }

    /// What there is to say about a hit of the cube of side 2^`level` at `corner`, met during `span`.
    fn truth(&self, corner: [i64; 3], side: i64, span: &Span, depth: u8) -> Truth {
        let Time::At(time) = &span.start.time else { panic!("a cube is finite") };
        let starts_inside = span.start == self.range.start;
        // Of the axes that cross into the cube at this very instant the steepest one names the face.
        let mut face = Face::Inside;
        let mut from = None;
        if !starts_inside {
            let mut steepest: Option<usize> = None;
            for axis in 0..3 {
                let near = if self.dir[axis].sign() > 0 { corner[axis] } else { corner[axis] + side };
                let crosses = self.dir[axis].sign() != 0 && self.step(axis, near) == span.start;
                if crosses && steepest.is_none_or(|s| self.dir[axis].abs() > self.dir[s].abs()) {
                    steepest = Some(axis);
                }
            }
            let axis = steepest.expect("something starts the span");
            let sides = [[Face::NegX, Face::PosX], [Face::NegY, Face::PosY], [Face::NegZ, Face::PosZ]];
            face = sides[axis][usize::from(self.dir[axis].sign() < 0)];
            from = self
                .voxel_before(&span.start)
                .filter(|v| v.iter().all(|&k| (0..1 << depth).contains(&k)))
                .map(|v| v.map(|k| k as u32));
        }
        Truth { voxel: corner.map(|k| k as u32), t: time.to_f64(), time: time.clone(), face, from }
    }

    /// Descends into the cubes that the ray meets, in the order in which it meets them.
    fn descend(
        &self,
        (level, corner): (u8, [i64; 3]),
        stop: u8,
        any_filled: &dyn Fn(u8, [u32; 3]) -> bool,
        counts: &dyn Fn([i64; 3], &Span) -> bool,
        span: &Span,
    ) -> Option<(u8, [i64; 3], Span)> {
        if !any_filled(level, corner.map(|k| k as u32)) {
            return None;
        }
        if level <= stop {
            return counts(corner, span).then(|| (level, corner, span.clone()));
        }
        let half = 1i64 << (level - 1);
        let halves: [[Option<Span>; 2]; 3] = core::array::from_fn(|axis| {
            let lo = corner[axis];
            [self.slab(axis, lo, lo + half), self.slab(axis, lo + half, lo + 2 * half)]
        });
        let mut children: Vec<(Span, [i64; 3])> = (0..8)
            .filter_map(|octant: usize| {
                let mut span = span.clone();
                for axis in 0..3 {
                    span = span.and(halves[axis][octant >> axis & 1].as_ref()?)?;
                }
                Some((span, core::array::from_fn(|axis| corner[axis] + half * (octant >> axis & 1) as i64)))
            })
            .collect();
        // The spans are disjoint, so that their starts order them.
        children.sort_by(|a, b| a.0.start.cmp(&b.0.start));
        children.iter().find_map(|(span, child)| self.descend((level - 1, *child), stop, any_filled, counts, span))
    }
}

/// The first filled cube of side 2^`level` that the ray meets in the cube of side 2^`depth`.
///
/// `any_filled(h, corner)` says whether the cube of side 2^h at a voxel holds a filled voxel; above `level` it may say
/// yes too often. With `level` at or above `depth` the whole cube is the one candidate.
pub fn first(ray: &Ray, depth: u8, level: u8, any_filled: &dyn Fn(u8, [u32; 3]) -> bool) -> Option<Truth> {
    let line = Line::new(ray)?;
    let span = line.span([0; 3], 1 << depth)?;
    let (level, corner, span) = line.descend((depth, [0; 3]), level, any_filled, &|_, _| true, &span)?;
    Some(line.truth(corner, 1 << level, &span, depth))
}

/// The first filled voxel whose open interior the ray meets in the cube of side 2^`depth`: what no tracer may miss,
/// whatever its rounding.
pub fn first_interior(ray: &Ray, depth: u8, any_filled: &dyn Fn(u8, [u32; 3]) -> bool) -> Option<Truth> {
    let line = Line::new(ray)?;
    let span = line.span([0; 3], 1 << depth)?;
    // The interior is met for more than a moment, and by no line that stays in a face.
    let inside = |corner: [i64; 3], span: &Span| {
        let in_a_face = |i: usize| line.dir[i].sign() == 0 && line.origin[i] == Rational::from(corner[i]);
        span.start.time < span.end.time && !(0..3).any(in_a_face)
    };
    let (_, corner, span) = line.descend((depth, [0; 3]), 0, any_filled, &inside, &span)?;
    Some(line.truth(corner, 1, &span, depth))
}

/// When the ray first comes to the closed voxel (`t_max` included); `None` if never.
pub fn arrival(ray: &Ray, voxel: [u32; 3]) -> Option<Time> {
    let line = Line::new(ray)?;
    let mut start = line.range.start.time.clone();
    let mut end = line.range.end.time.clone();
    for axis in 0..3 {
        let (lo, hi) = (i64::from(voxel[axis]), i64::from(voxel[axis]) + 1);
        if line.dir[axis].sign() == 0 {
            if line.origin[axis] < Rational::from(lo) || line.origin[axis] > Rational::from(hi) {
                return None;
            }
            continue;
        }
        let (near, far) = if line.dir[axis].sign() > 0 { (lo, hi) } else { (hi, lo) };
        start = start.max(Time::At(line.crossing(axis, near)));
        end = end.min(Time::At(line.crossing(axis, far)));
    }
    (start <= end).then_some(start)
}

/// Whether the ray comes to the closed voxel at all (`t_max` included).
pub fn touches(ray: &Ray, voxel: [u32; 3]) -> bool {
    arrival(ray, voxel).is_some()
}

/// All voxels that the ray meets in the cube of side 2^`depth`, in order, at most `limit`: by stepping from plane to
/// plane, another way than [`first`].
pub fn walk(ray: &Ray, depth: u8, limit: usize) -> Vec<[u32; 3]> {
    let mut voxels = Vec::new();
    let Some(line) = Line::new(ray) else { return voxels };
    let Some(span) = line.span([0; 3], 1 << depth) else { return voxels };
    let mut voxel = line.voxel_at(&span.start);
    while voxels.len() < limit {
        voxels.push(voxel.map(|k| k as u32));
        // All axes that step at the earliest instant step together.
        let next: [Option<Instant>; 3] = core::array::from_fn(|axis| match line.dir[axis].sign() {
            0 => None,
            1 => Some(line.step(axis, voxel[axis] + 1)),
            _ => Some(line.step(axis, voxel[axis])),
        });
        let Some(earliest) = next.iter().flatten().min() else { return voxels };
        if *earliest >= span.end {
            break;
        }
        for axis in 0..3 {
            if next[axis].as_ref() == Some(earliest) {
                voxel[axis] += i64::from(line.dir[axis].sign());
            }
        }
    }
    voxels
}
