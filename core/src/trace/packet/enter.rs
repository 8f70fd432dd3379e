//! Where rays enter the cube, in f64 lanes, and the same from there in f32.
//!
//! In: rays as columns. Out: those that certainly enter, with the voxel, and with their origin moved to where they enter
//! and their direction scaled by a power of two, so that what follows can be done in f32; of the others whether they
//! certainly miss. It is `Ray::new` and `Ray::enter` for all lanes alike, with the same bounds; what these bounds cannot
//! tell, and whatever is unusual, is left to the scalar tracer as a whole.

use fearless_simd::{Simd, prelude::*};

use super::walk::{End, Ends};
use super::{CHUNK, LANES};
use crate::simd::{Level, dispatch, least, most};
use crate::trace::exact::{HUGE, TINY};
use crate::trace::ray::{UNIT, axes};

/// Rays of a chunk as columns, in f64.
#[repr(align(64))] // vectors lie within lines of the cache
pub(in crate::trace) struct Rays {
    pub len: usize,
    pub origin: [[f64; CHUNK]; 3],
    pub dir: [[f64; CHUNK]; 3],
    pub t_min: [f64; CHUNK],
    pub t_max: [f64; CHUNK],
    /// The voxel to start in; negative for none. Read if any ray has one.
    pub start: [[f64; CHUNK]; 3],
    pub started: bool,
    /// Whether any `t_max` is finite.
    pub bounded: bool,
    /// What [`enter`] finds: 1 / dir, and the slack of times.
    pub inverse: [[f64; CHUNK]; 3],
    pub slack: [f64; CHUNK],
}

impl Rays {
    pub(super) const ZERO: Rays = Rays {
        len: 0,
        origin: [[0.0; CHUNK]; 3],
        dir: [[0.0; CHUNK]; 3],
        t_min: [0.0; CHUNK],
        t_max: [0.0; CHUNK],
        start: [[0.0; CHUNK]; 3],
        started: false,
        bounded: false,
        inverse: [[0.0; CHUNK]; 3],
        slack: [0.0; CHUNK],
    };
}

/// Rays that have entered, as columns, in f32. Times are counted from where they entered, in units of `dir`.
#[repr(align(64))] // vectors lie within lines of the cache
pub(super) struct Walks {
    pub len: usize,
    /// In the chunk.
    pub number: [i32; CHUNK + LANES],
    /// The first voxel.
    pub voxel: [[f32; CHUNK + LANES]; 3],
    /// From its middle to where the ray entered.
    pub off: [[f32; CHUNK + LANES]; 3],
    /// The largest is between 0.5 and 1.
    pub dir: [[f32; CHUNK + LANES]; 3],
    pub inverse: [[f32; CHUNK + LANES]; 3],
    /// Places nearer than this to the middle of a voxel are certain at time 0.
    pub half: [f32; CHUNK + LANES],
    /// Times before it are certainly before `t_max`,
    pub stop: [f32; CHUNK + LANES],
    /// and times after this one after it.
    pub end: [f32; CHUNK + LANES],
}

impl Walks {
    pub(super) const ZERO: Walks = Walks {
        len: 0,
        number: [0; CHUNK + LANES],
        voxel: [[0.0; CHUNK + LANES]; 3],
        off: [[0.0; CHUNK + LANES]; 3],
        dir: [[0.0; CHUNK + LANES]; 3],
        inverse: [[0.0; CHUNK + LANES]; 3],
        half: [0.0; CHUNK + LANES],
        stop: [0.0; CHUNK + LANES],
        end: [0.0; CHUNK + LANES],
    };
}

/// What becomes of a vector of rays.
struct Entered<S: Simd> {
    go: S::mask64s,
    missed: S::mask64s,
    voxel: [S::f64s; 3],
    off: [S::f64s; 3],
    dir: [S::f64s; 3],
    inverse: [S::f64s; 3],
    half: S::f64s,
    stop: S::f64s,
    end: S::f64s,
}

/// Lines up the rays that enter a cube of `size` voxels; tells of the others how they end.
pub(super) fn enter(level: Level, rays: &mut Rays, size: i32, ends: &mut Ends, walks: &mut Walks) {
    dispatch!(level, simd => match rays.started {
        true => in_lanes::<_, true>(simd, rays, size, ends, walks),
        false => in_lanes::<_, false>(simd, rays, size, ends, walks),
    });
}

#[inline(always)]
fn in_lanes<S: Simd, const STARTED: bool>(simd: S, rays: &mut Rays, size: i32, ends: &mut Ends, walks: &mut Walks) {
    ends.how = [End::Miss; CHUNK];
    walks.len = 0;
    let width = S::f64s::LEN;
    let numbers = S::i32s::from_fn(simd, |i| i as i32);
    let mut from = 0;
    while from < rays.len {
        let low = vector::<S, STARTED>(simd, rays, from, size);
        let high = vector::<S, STARTED>(simd, rays, from + width, size);
        let there = u64::MAX >> (64 - (rays.len - from).min(2 * width));
        let go = low.go.narrow(high.go).to_bitmask() & there;
        let mut whole = there & !go & !low.missed.narrow(high.missed).to_bitmask();
        while whole != 0 {
            ends.how[(from + whole.trailing_zeros() as usize) % CHUNK] = End::Whole;
            whole &= whole - 1;
        }
        // Line up those that go: mostly all of them or none.
        if go == 0 {
            from += 2 * width;
            continue;
        }
        let all = go == u64::MAX >> (64 - 2 * width);
        let mask = S::mask32s::from_bitmask(simd, go);
        let at = walks.len;
        let put = |column: &mut [f32], low: S::f64s, high: S::f64s| {
            let values = low.narrow(high);
            (if all { values } else { values.compress(mask) }).store_slice(&mut column[at..at + 2 * width]);
        };
        (numbers + from as i32).compress(mask).store_slice(&mut walks.number[at..at + 2 * width]);
        for i in 0..3 {
            put(&mut walks.voxel[i], low.voxel[i], high.voxel[i]);
            put(&mut walks.off[i], low.off[i], high.off[i]);
            put(&mut walks.dir[i], low.dir[i], high.dir[i]);
            put(&mut walks.inverse[i], low.inverse[i], high.inverse[i]);
        }
        put(&mut walks.half, low.half, high.half);
        put(&mut walks.stop, low.stop, high.stop);
        put(&mut walks.end, low.end, high.end);
        walks.len += go.count_ones() as usize;
        from += 2 * width;
    }
}

#[inline(always)]
fn vector<S: Simd, const STARTED: bool>(simd: S, rays: &mut Rays, from: usize, size: i32) -> Entered<S> {
    let width = S::f64s::LEN;
    let splat = |x: f64| S::f64s::splat(simd, x);
    let size = f64::from(size);
    let (zero, one, infinity) = (splat(0.0), splat(1.0), splat(f64::INFINITY));
    let load = |column: &[f64; CHUNK]| S::f64s::from_slice(simd, &column[from..from + width]);
    let d = axes(|i| load(&rays.dir[i]));
    let (t_min, t_max) = (load(&rays.t_min), load(&rays.t_max));
    let start = axes(|i| if STARTED { load(&rays.start[i]) } else { zero });
    let started = start[0].simd_ge(0.0);

    // Where a ray does not move it stands in the middle of its voxel.
    let still = axes(|i| d[i].simd_eq(0.0));
    let mut valid = t_min.simd_lt(t_max);
    let mut o = axes(|i| load(&rays.origin[i]));
    if (still[0] | still[1] | still[2]).any_true() {
        for i in 0..3 {
            let cell = if STARTED { started.select(start[i], o[i].floor()) } else { o[i].floor() };
            valid &= !still[i] | cell.simd_ge(0.0) & cell.simd_lt(size) & o[i].abs().simd_lt(infinity);
            o[i] = still[i].select(cell + 0.5, o[i]);
            o[i].store_slice(&mut rays.origin[i][from..from + width]);
        }
    }
    let inverse = axes(|i| one / (d[i] + 0.0));
    let up = axes(|i| !d[i].simd_lt(0.0));

    // Bound the errors of f64 values.
    let far_out = o[0].abs() + o[1].abs() + o[2].abs();
    let speed = d[0].abs() + d[1].abs() + d[2].abs();
    let moving = axes(|i| still[i].select(infinity, d[i].abs()));
    let slowest = least(least(moving[0], moving[1]), moving[2]);
    let fastest = most(most(d[0].abs(), d[1].abs()), d[2].abs());
    valid &= far_out.simd_le(HUGE) & speed.simd_le(HUGE) & slowest.simd_ge(TINY);
    let near = axes(|i| (up[i].select(zero, splat(size)) - o[i]) * inverse[i]);
    let far = axes(|i| (up[i].select(splat(size), zero) - o[i]) * inverse[i]);
    let last_near = most(most(near[0], near[1]), near[2]);
    let leave = least(least(far[0], far[1]), far[2]);
    let begin = t_min.simd_eq(f64::NEG_INFINITY).select(zero, t_min.abs());
    let longest = most(most(begin, last_near.abs()), leave.abs());
    valid &= longest.simd_ge(TINY) & longest.simd_le(HUGE);
    let slack = longest * UNIT;
    let error = (far_out + speed * longest + size) * UNIT;

    // The first voxel, and a time on the line in it.
    let mut now = most(last_near, t_min);
    let mut missed = valid & now.simd_gt(leave + slack);
    let close = axes(|i| !near[i].simd_lt(last_near - slack));
    let outside = last_near.simd_gt(t_min + slack);
    let inside = last_near.simd_lt(t_min - slack);
    let alone = (close[0] ^ close[1] ^ close[2]) & !(close[0] & close[1] & close[2]);
    let mut clear = (inside | outside & alone) & now.simd_lt(leave - slack) & now.simd_lt(t_max - slack);
    // Where it begins at time 0 and in the cube, which secondary rays do, often on a plane, there is nothing to round.
    let mut within = t_min.simd_eq(zero);
    for i in 0..3 {
        within &= o[i].simd_ge(zero) & o[i].simd_lt(size);
    }
    now = within.select(zero, now);
    let mut begun = started;
    if STARTED {
        // The line is to pass the voxel that it starts in.
        let entry = axes(|i| (start[i] + up[i].select(zero, one) - o[i]) * inverse[i]);
        let exit = axes(|i| (start[i] + up[i].select(one, zero) - o[i]) * inverse[i]);
        let t_in = most(most(entry[0], entry[1]), entry[2]);
        let t_out = least(least(exit[0], exit[1]), exit[2]);
        begun &= (t_in + slack * 2.0).simd_lt(t_out);
        for i in 0..3 {
            begun &= start[i].simd_lt(size);
        }
        now = started.select(t_in, now);
        missed &= !started;
    }
    let middle = axes(|i| o[i] + d[i] * now - 0.5);
    let mut voxel = [zero; 3];
    for i in 0..3 {
        let rounded = middle[i].round_ties_even();
        let crossed = close[i] & outside;
        clear &= crossed | (middle[i] - rounded).abs().simd_lt(splat(0.5) - error);
        let first = up[i].select(zero, splat(size - 1.0));
        voxel[i] = crossed.select(first, least(most(rounded, zero), splat(size - 1.0)));
        voxel[i] = within.select(o[i].floor(), voxel[i]);
        if STARTED {
            voxel[i] = started.select(start[i], voxel[i]);
        }
    }
    clear |= within;
    if STARTED {
        clear = (!started & clear) | begun;
    }

    // The same from there in f32, with the largest direction between 0.5 and 1.
    let two_to = S::f64s::from_bits(fastest.to_bits() & (0x7ff << 52));
    let scale = splat(0.5) / two_to;
    let stretch = two_to * 2.0;
    let steepest = one / (slowest * scale);
    let go = clear & valid & steepest.simd_le(1e10);
    let error = error + f64::from_bits((1023 - 26) << 52);
    let bound = error * (steepest + 1.0) * 1.1 + f64::from_bits((1023 - 23) << 52);
    // No ray of the cube takes longer than this.
    let longest = least(most((t_max - now) * stretch, splat(-1e30)), splat(1e30));
    let margin = longest.abs() * (8.0 / 16_777_216.0) + bound;
    let endless = t_max.simd_eq(f64::INFINITY);
    for i in 0..3 {
        inverse[i].store_slice(&mut rays.inverse[i][from..from + width]);
    }
    slack.store_slice(&mut rays.slack[from..from + width]);
    Entered {
        go,
        missed: missed | t_min.simd_ge(t_max),
        off: axes(|i| middle[i] - voxel[i]),
        voxel,
        dir: axes(|i| d[i] * scale),
        inverse: axes(|i| inverse[i] * stretch),
        half: splat(0.5) - bound,
        stop: endless.select(infinity, longest - margin),
        end: endless.select(infinity, longest + margin),
    }
}
