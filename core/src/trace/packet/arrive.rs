//! Hits, from the voxels where rays ended.

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::{CHUNK, Ends, Found, HIT, Rays};
use crate::morton::Morton;
use crate::trace::exact::{HUGE, TINY};
use crate::trace::ray::axes;
use crate::trace::{Face, Hit};

/// 1.5 x 2^52: adding it leaves an integer in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// The bits of a code that are x's.
const AXIS: u64 = 0x1249_2492_4924_9249;

#[inline(always)]
pub(super) fn arrive<S: Simd>(simd: S, rays: &Rays, ends: &Ends, size: i32, found: &mut Found) {
    let width = S::f64s::LEN;
    let mut from = 0;
    while from < rays.len {
        if ends.how[from..from + width].contains(&HIT) {
            vector(simd, rays, ends, size, from, found);
        }
        from += width;
    }
}

#[inline(always)]
fn vector<S: Simd>(simd: S, rays: &Rays, ends: &Ends, size: i32, from: usize, found: &mut Found) {
    let width = S::f64s::LEN;
    let load = |column: &[f64; CHUNK]| S::f64s::from_slice(simd, &column[from..from + width]);
    let splat = |x: f64| S::f64s::splat(simd, x);
    let (zero, one) = (splat(0.0), splat(1.0));
    let p = axes(|i| S::f64s::from_fn(simd, |k| f64::from(ends.voxel[i][from + k])));
    let o = axes(|i| load(&rays.origin[i]));
    let d = axes(|i| load(&rays.dir[i]));
    let t_min = load(&rays.t_min);
    let slack = load(&rays.slack);
    let up = axes(|i| !d[i].simd_lt(0.0));

    // The plane that came last.
    let planes = axes(|i| p[i] + up[i].select(zero, one));
    let t = axes(|i| (planes[i] - o[i]) * load(&rays.inverse[i]));
    let last = t[0].max(t[1]).max(t[2]);
    let close = axes(|i| !t[i].simd_lt(last - slack));
    let alone = (close[0] ^ close[1] ^ close[2]) & !(close[0] & close[1] & close[2]);
    let mut clear = alone & last.simd_gt(t_min + slack);
    if rays.any_start {
        let start = axes(|i| load(&rays.start[i]));
        clear = clear & !(start[0].simd_eq(p[0]) & start[1].simd_eq(p[1]) & start[2].simd_eq(p[2]));
    }

    // Its time, to within one unit in the last place.
    let time = quotient::<S>(pick::<S>(close, planes), pick::<S>(close, o), pick::<S>(close, d)).max(t_min);

    // The voxel's code, and that of the one before.
    let mut code = S::u64s::splat(simd, 0);
    for i in 0..3 {
        code |= spread::<S>((p[i] + ROUND).bitcast(), i as u32);
    }
    let [x, y, z] = [0, 1, 2].map(|i| S::u64s::splat(simd, AXIS << i));
    let bits = close[0].select(x, close[1].select(y, z));
    let unit = bits & (bits - 1) ^ bits;
    let positive = close[0] & up[0] | !close[0] & (close[1] & up[1] | !close[1] & up[2]);
    let along = code & bits;
    let before = positive.select(along - unit, (along | !bits) + unit) & bits;
    let beside = pick::<S>(close, p) + positive.select(splat(-1.0), one);
    let inside = beside.simd_ge(0.0) & beside.simd_lt(f64::from(size));
    let before = inside.select(before | code & !bits, S::u64s::splat(simd, u64::MAX));

    time.store_slice(&mut found.t[from..from + width]);
    code.store_slice(&mut found.code[from..from + width]);
    before.store_slice(&mut found.from[from..from + width]);
    let (clear, positive) = (clear.to_bitmask(), positive.to_bitmask());
    let (x, y) = (close[0].to_bitmask(), close[1].to_bitmask());
    for k in 0..width {
        let axis = if x >> k & 1 != 0 { 0 } else { 2 - (y >> k & 1) as u8 };
        let face = 2 * axis + 1 - (positive >> k & 1) as u8;
        found.face[from + k] = if clear >> k & 1 != 0 { face } else { 6 };
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

const FACES: [Face; 8] =
    [Face::NegX, Face::PosX, Face::NegY, Face::PosY, Face::NegZ, Face::PosZ, Face::Inside, Face::Inside];

impl Found {
    #[inline(always)]
    pub(super) fn hit(&self, k: usize) -> Hit {
        let from = self.from[k];
        Hit {
            voxel: Morton(self.code[k]),
            from: (from != u64::MAX).then_some(Morton(from)),
            t: self.t[k],
            level: 0,
            face: FACES[self.face[k] as usize & 7],
        }
    }
}
