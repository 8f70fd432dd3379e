//! Packets of rays: the walk from empty box to empty box in f32 lanes.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use fearless_simd::*;
use super::{CHUNK, Ends, ROOM, Tables, Walks};
use crate::trace::ray::axes;

/// Vectors of so many lanes.
pub(super) trait Width<S: Simd>: Copy {
    type F: SimdFloat<S, Element = f32, Mask = Self::M> + SimdCvtFloat<Self::I>;
    type B: SimdBase<S, Element = u8, ByteVector = Self::B> + Bytes<Bytes = Self::B>;
    type I: SimdInt<S, Element = i32, Mask = Self::M, ByteVector = Self::B> + SimdCvtTruncate<Self::F>;
    type P: SimdInt<S, Element = u64, ByteVector = Self::B>;
    type M: SimdMask<S> + Select<Self::F> + Select<Self::I> + Copy;
}
#[derive(Clone, Copy)]
pub(super) struct W4;
#[derive(Clone, Copy)]
pub(super) struct W8;
#[derive(Clone, Copy)]
pub(super) struct W16;
impl<S: Simd> Width<S> for W4 { type B = u8x16<S>; type F = f32x4<S>; type I = i32x4<S>; type P = u64x2<S>; type M = mask32x4<S>; }
impl<S: Simd> Width<S> for W8 { type B = u8x32<S>; type F = f32x8<S>; type I = i32x8<S>; type P = u64x4<S>; type M = mask32x8<S>; }
impl<S: Simd> Width<S> for W16 { type B = u8x64<S>; type F = f32x16<S>; type I = i32x16<S>; type P = u64x8<S>; type M = mask32x16<S>; }

#[derive(Clone, Copy)]
struct Packet<S: Simd, W: Width<S>> {
    live: u64,
    id: W::I,
    p: [W::I; 3],
    base: [W::F; 3],
    off: [W::F; 3],
    dir: [W::F; 3],
    inv: [W::F; 3],
    up: [W::I; 3],
    grid: W::I,
    half: W::F,
    stop: W::F,
    end: W::F,
    simd: core::marker::PhantomData<S>,
}

/// What f32 lanes add to the bound of a place for each unit of time: 7 x 2^-24.
pub(super) const SLOPE: f32 = 7.0 / 16_777_216.0;

/// The words at so many places.
#[inline(always)]
fn gather<S: Simd, W: Width<S>>(simd: S, words: &[u32], at: W::I) -> W::I {
    let at = at.as_slice();
    W::I::from_fn(simd, |i| words[at[i] as u32 as usize] as i32)
}

impl<S: Simd, W: Width<S>> Packet<S, W> {
    #[inline(always)]
    fn idle(simd: S) -> Self {
        let zero = W::I::splat(simd, 0);
        let one = W::F::splat(simd, 1.0);
        Packet {
            live: 0,
            id: zero,
            p: [zero; 3],
            base: [one; 3],
            off: [one; 3],
            dir: [one; 3],
            inv: [one; 3],
            up: [zero; 3],
            grid: zero,
            half: one,
            stop: one,
            end: one,
            simd: core::marker::PhantomData,
        }
    }

    /// Fills idle lanes with the next rays; returns how many.
    #[inline(always)]
    fn refill(&mut self, simd: S, tables: &Tables<'_>, walks: &Walks, from: usize) -> usize {
        let width = W::I::LEN;
        let left = walks.len - from;
        let mut lanes = !self.live & (u64::MAX >> (64 - width));
        let mut count = lanes.count_ones() as usize;
        while count > left {
            lanes &= !(1 << (63 - lanes.leading_zeros()));
            count -= 1;
        }
        let mask = W::M::from_bitmask(simd, lanes);
        let int = |from_: &[i32; ROOM], old: W::I| {
            W::I::from_slice(simd, &from_[from..from + width]).expand_merge(mask, old)
        };
        let float = |from_: &[f32; ROOM], old: W::F| {
            W::F::from_slice(simd, &from_[from..from + width]).expand_merge(mask, old)
        };
        self.id = int(&walks.id, self.id);
        self.half = float(&walks.half, self.half);
        self.stop = float(&walks.stop, self.stop);
        self.end = float(&walks.end, self.end);
        let mut octant = W::I::splat(simd, 0);
        for i in 0..3 {
            let voxel = W::F::from_slice(simd, &walks.voxel[i][from..from + width]).expand(mask);
            self.p[i] = mask.select(voxel.to_int(), self.p[i]);
            self.base[i] = mask.select(voxel + 0.5, self.base[i]);
            self.off[i] = float(&walks.off[i], self.off[i]);
            self.dir[i] = float(&walks.dir[i], self.dir[i]);
            self.inv[i] = float(&walks.inverse[i], self.inv[i]);
            self.up[i] = self.dir[i].simd_ge(0.0).select(W::I::splat(simd, -1), W::I::splat(simd, 0));
            octant |= self.up[i] & (1 << i);
        }
        self.grid = octant << (3 * tables.bits);
        self.live |= lanes;
        count
    }

    /// The top grid's cells.
    #[inline(always)]
    fn cell(&self, simd: S, tables: &Tables<'_>) -> W::I {
        let [px, py, pz] = self.p;
        let (bits, level) = (tables.bits, tables.level);
        let at = ((((pz >> level) << bits) | (py >> level)) << bits | (px >> level)) | self.grid;
        gather::<S, W>(simd, tables.top, at)
    }

    /// Down to the bricks: sides of the empty cubes, 0 where a voxel is filled.
    #[inline(always)]
    fn side(&self, simd: S, tables: &Tables<'_>, cell: W::I) -> W::I {
        let zero = W::I::splat(simd, 0);
        let [px, py, pz] = self.p;
        let level = tables.level;
        let mut word = cell;
        {
            // Down to the brick. Where a lane has met an empty cell, it stays at node 0.
            let mut h = level;
            while h > 2 {
                h -= 2;
                let inside = word.max(zero);
                let at = inside + ((px >> h & 3) | (py >> h & 3) << 2 | (pz >> h & 3) << 4);
                let next = gather::<S, W>(simd, tables.words, at);
                word = word.simd_lt(0).select(word, next);
            }
            // In a brick, the voxel and the 2^3 around it.
            let bit = (px & 1) | (py & 1) << 1 | (pz & 1) << 2 | (px & 2) << 2 | (py & 2) << 3 | (pz & 2) << 4;
            let half = gather::<S, W>(simd, tables.words, word.max(zero) + (bit >> 5));
            let eight = half >> (bit & 24) & 0xff;
            let set = eight >> (bit & 7) & 1;
            let looked = eight.simd_eq(0).select(W::I::splat(simd, 2), W::I::splat(simd, 1) - set);
            word.simd_lt(0).select(word & 0x7fff_ffff, looked)
        }
    }

    /// One step of all live lanes; those that hit, left the cube, and cannot tell.
    #[inline(always)]
    fn advance<const EXACT: bool, const BOUNDED: bool>(&mut self, simd: S, tables: &Tables<'_>, cell: W::I, side: W::I) -> [u64; 3] {
        let zero = W::I::splat(simd, 0);
        let level = tables.level;
        let boxed = cell.simd_lt(0);
        let far = [(cell & 0x1ff) << level, (cell >> 9 & 0x1ff) << level, (cell >> 18 & 0x1ff) << level];
        let mut hit = (side | (cell & i32::MIN)).simd_eq(0).to_bitmask();

        // The plane that comes first.
        let mut planes = [zero; 3];
        let mut te = [W::F::splat(simd, 0.0); 3];
        for i in 0..3 {
            planes[i] = boxed.select(far[i], (self.p[i] & (zero - side)) + (side & self.up[i]));
            let plane: W::F = planes[i].to_float();
            te[i] = ((plane - self.base[i]) - self.off[i]) * self.inv[i];
        }
        let others = [te[1].min(te[2]), te[2].min(te[0]), te[0].min(te[1])];
        let now = te[0].min(others[0]);
        let mut worst = W::F::splat(simd, 0.0);
        let half = self.half - now * SLOPE;
        let mut out = zero;
        let mut next = self.p;
        for i in 0..3 {
            let middle = self.off[i] + self.dir[i] * now;
            let rounded = middle.round_ties_even();
            let place: W::I = (rounded + (self.base[i] - 0.5)).to_int();
            let crossed = planes[i] + !self.up[i];
            if EXACT {
                let across = te[i].simd_lt(others[i]);
                worst = across.select(worst, worst.max((middle - rounded).abs()));
                next[i] = across.select(crossed, place);
            } else {
                let down = !self.up[i];
                let low = (self.p[i] & self.up[i]) | (planes[i] & down);
                let high = ((planes[i] - 1) & self.up[i]) | (self.p[i] & down);
                next[i] = te[i].simd_le(now).select(crossed, place.max(low).min(high));
            }
            out |= next[i];
        }
        let mut gone = (out >> tables.depth).simd_ne(0).to_bitmask();
        let mut unclear = if EXACT { worst.simd_ge(half).to_bitmask() } else { 0 };
        if BOUNDED {
            unclear |= now.simd_ge(self.stop).to_bitmask();
            let ended = now.simd_gt(self.end).to_bitmask();
            unclear &= !ended;
            gone |= ended;
        }
        // Who ends, ends where it is.
        let live = self.live;
        hit &= live;
        unclear &= live & !hit;
        gone &= live & !hit & !unclear;
        self.live = live & !hit & !unclear & !gone;
        let on = W::M::from_bitmask(simd, self.live);
        for i in 0..3 {
            self.p[i] = on.select(next[i], self.p[i]);
        }
        [hit, gone, unclear]
    }
}

impl<S: Simd, W: Width<S>> Packet<S, W> {
    #[inline(always)]
    fn retire(&self, [hit, gone, unclear]: [u64; 3], ends: &mut Ends) {
            let mut done = hit | gone | unclear;
            while done != 0 {
                let lane = done.trailing_zeros() as usize;
                done &= done - 1;
                let id = self.id.as_slice()[lane] as usize & (CHUNK - 1);
                ends.how[id] = ((hit >> lane & 1) | (unclear >> lane & 1) << 1) as u8;
                for i in 0..3 {
                    ends.voxel[i][id] = self.p[i].as_slice()[lane];
                }
            }
    }
}

/// Packets in flight.
const K: usize = 2;

/// Walks all rays that are walks.
#[inline(always)]
pub(super) fn walk<S: Simd, W: Width<S>, const EXACT: bool, const BOUNDED: bool>(simd: S, tables: &Tables<'_>, walks: &Walks, ends: &mut Ends) {
    let mut packets = [Packet::<S, W>::idle(simd); K];
    let width = W::I::LEN as u32;
    let mut from = 0;
    loop {
        for packet in &mut packets {
            let idle = width - packet.live.count_ones();
            if from < walks.len && idle >= width / 2 {
                from += packet.refill(simd, tables, walks, from);
            }
        }
        let [a, b] = &mut packets;
        if a.live | b.live == 0 {
            break;
        }
        let (cell_a, cell_b) = (a.cell(simd, tables), b.cell(simd, tables));
        let (side_a, side_b) = (a.side(simd, tables, cell_a), b.side(simd, tables, cell_b));
        let ends_a = a.advance::<EXACT, BOUNDED>(simd, tables, cell_a, side_a);
        let ends_b = b.advance::<EXACT, BOUNDED>(simd, tables, cell_b, side_b);
        a.retire(ends_a, ends);
        b.retire(ends_b, ends);
    }
}
