//! Hits, from the voxels where rays ended, in f64 lanes.
//!
//! In: rays as columns, and where they ended. Out: for each that hit the voxel's code, that of the voxel before, the side of
//! entry and the time, as the scalar tracer's `arrive` has them; where f64 cannot tell which plane was the last
//! one, nothing.

use fearless_simd::{Simd, prelude::*};

use super::CHUNK;
use super::enter::Rays;
use super::walk::{End, Ends};
use crate::morton::Morton;
use crate::simd::{Level, dispatch, most};
use crate::trace::exact::{HUGE, TINY};
use crate::trace::ray::{ROUND, axes};
use crate::trace::walk::FACES;
use crate::trace::{Face, Hit};

/// The bits of a code that are x's.
const AXIS: u64 = 0x1249_2492_4924_9249;
/// No voxel.
const NONE: u64 = u64::MAX;
/// In place of a side: the ray starts inside.
const INSIDE: u8 = 6;
/// f64 cannot tell.
const UNCLEAR: u8 = 7;

/// Hits as columns, by number of the ray.
#[repr(align(64))] // vectors lie within lines of the cache
pub(super) struct Found {
    code: [u64; CHUNK],
    from: [u64; CHUNK],
    t: [f64; CHUNK],
    /// Twice the axis, and 1 if the ray runs towards negative coordinates.
    side: [u8; CHUNK],
}

impl Found {
    pub(super) const ZERO: Found = Found { code: [0; CHUNK], from: [0; CHUNK], t: [0.0; CHUNK], side: [0; CHUNK] };

    /// Whether the hit of a ray that hit is known.
    #[inline(always)]
    pub(super) fn is_clear(&self, number: usize) -> bool {
        self.side[number] != UNCLEAR
    }

    #[inline(always)]
    pub(super) fn hit(&self, number: usize) -> Hit {
        let (from, side) = (self.from[number], usize::from(self.side[number]));
        Hit {
            voxel: Morton(self.code[number]),
            from: (from != NONE).then_some(Morton(from)),
            t: self.t[number],
            level: 0,
            face: FACES.as_flattened().get(side ^ 1).copied().unwrap_or(Face::Inside),
        }
    }
}

/// Works out the hits in a cube of `size` voxels.
pub(super) fn arrive(level: Level, rays: &Rays, ends: &Ends, size: i32, found: &mut Found) {
    dispatch!(level, simd => in_lanes(simd, rays, ends, size, found));
}

#[inline(always)]
fn in_lanes<S: Simd>(simd: S, rays: &Rays, ends: &Ends, size: i32, found: &mut Found) {
    let width = S::f64s::LEN;
    for from in (0..rays.len).step_by(width) {
        if ends.how[from..from + width].contains(&End::Hit) {
            vector(simd, rays, ends, size, from, found);
        }
    }
}

#[inline(always)]
fn vector<S: Simd>(simd: S, rays: &Rays, ends: &Ends, size: i32, from: usize, found: &mut Found) {
    let width = S::f64s::LEN;
    let load = |column: &[f64; CHUNK]| S::f64s::from_slice(simd, &column[from..from + width]);
    let splat = |x: f64| S::f64s::splat(simd, x);
    let (zero, one) = (splat(0.0), splat(1.0));
    let p = axes(|i| load(&ends.voxels[i]));
    let o = axes(|i| load(&rays.origin[i]));
    let d = axes(|i| load(&rays.dir[i]));
    let t_min = load(&rays.t_min);
    let slack = load(&rays.slack);
    let up = axes(|i| !d[i].simd_lt(0.0));

    // The plane that came last.
    let planes = axes(|i| p[i] + up[i].select(zero, one));
    let t = axes(|i| (planes[i] - o[i]) * load(&rays.inverse[i]));
    let last = most(most(t[0], t[1]), t[2]);
    let close = axes(|i| !t[i].simd_lt(last - slack));
    let alone = (close[0] ^ close[1] ^ close[2]) & !(close[0] & close[1] & close[2]);
    let positive = close[0] & up[0] | !close[0] & (close[1] & up[1] | !close[1] & up[2]);
    // Rays mostly begin at time 0, and secondary ones on a plane: there the order is certain, as rounded times have the
    // signs of the true ones. Of what is crossed at that time only what is crossed in negative direction comes after it.
    let from_zero = t_min.simd_eq(zero);
    let slack = from_zero.select(zero, slack);
    let on_plane = from_zero & alone & last.simd_eq(zero) & pick::<S>(close, planes).simd_eq(pick::<S>(close, o));
    let mut inside = last.simd_lt(t_min - slack) | on_plane & positive;
    let outside = alone & last.simd_gt(t_min + slack) | on_plane & !positive;
    if rays.started {
        let start = axes(|i| load(&rays.start[i]));
        inside |= start[0].simd_eq(p[0]) & start[1].simd_eq(p[1]) & start[2].simd_eq(p[2]);
    }
    let clear = inside | outside;

    // Its time, to within one unit in the last place.
    let time = quotient::<S>(pick::<S>(close, planes), pick::<S>(close, o), pick::<S>(close, d));
    let time = (time.simd_gt(t_min) & !inside).select(time, t_min);

    // The voxel's code, and that of the one before.
    let mut code = S::u64s::splat(simd, 0);
    for i in 0..3 {
        code |= spread::<S>((p[i] + ROUND).bitcast(), i as u32);
    }
    let [x, y, z] = [0, 1, 2].map(|i| S::u64s::splat(simd, AXIS << i));
    let bits = close[0].select(x, close[1].select(y, z));
    let unit = bits & (bits - 1) ^ bits;
    let along = code & bits;
    let before = positive.select(along - unit, (along | !bits) + unit) & bits;
    let beside = pick::<S>(close, p) + positive.select(splat(-1.0), one);
    let there = !inside & beside.simd_ge(0.0) & beside.simd_lt(f64::from(size));
    let before = there.select(before | code & !bits, S::u64s::splat(simd, NONE));

    time.store_slice(&mut found.t[from..from + width]);
    code.store_slice(&mut found.code[from..from + width]);
    before.store_slice(&mut found.from[from..from + width]);
    let (clear, inside, positive) = (clear.to_bitmask(), inside.to_bitmask(), positive.to_bitmask());
    let (x, y) = (close[0].to_bitmask(), close[1].to_bitmask());
    for k in 0..width {
        let axis = if x >> k & 1 != 0 { 0 } else { 2 - (y >> k & 1) as u8 };
        let side = 2 * axis + 1 - (positive >> k & 1) as u8;
        found.side[from + k] = match (clear >> k & 1, inside >> k & 1) {
            (0, _) => UNCLEAR,
            (_, 0) => side,
            _ => INSIDE,
        };
    }
}

#[inline(always)]
fn pick<S: Simd>(close: [S::mask64s; 3], v: [S::f64s; 3]) -> S::f64s {
    close[0].select(v[0], close[1].select(v[1], v[2]))
}

/// Every third bit of the low 21, from bit `i` on.
#[inline(always)]
fn spread<S: Simd>(x: S::u64s, i: u32) -> S::u64s {
    let x = x & 0x1f_ffff;
    let x = (x | x << 32) & 0x1f_0000_0000_ffff;
    let x = (x | x << 16) & 0x1f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    ((x | x << 2) & AXIS) << i
}

/// [`crate::trace::exact::quotient`].
#[inline(always)]
fn quotient<S: Simd>(a: S::f64s, b: S::f64s, d: S::f64s) -> S::f64s {
    let high = a - b;
    let bb = high - a;
    let low = (a - (high - bb)) - (b + bb);
    let q = high / d;
    let p = q * d;
    let ((qh, ql), (dh, dl)) = (split::<S>(q), split::<S>(d));
    let error = ((qh * dh - p) + qh * dl + ql * dh) + ql * dl;
    let remainder = (high - p) - error;
    (tame::<S>(high) & tame::<S>(q) & tame::<S>(d)).select(q + (remainder + low) / d, q)
}

#[inline(always)]
fn tame<S: Simd>(x: S::f64s) -> S::mask64s {
    x.abs().simd_ge(TINY) & x.abs().simd_le(HUGE)
}

#[inline(always)]
fn split<S: Simd>(x: S::f64s) -> (S::f64s, S::f64s) {
    let c = x * 134_217_729.0;
    let high = c - (c - x);
    (high, x - high)
}
