//! The walk from empty box to empty box in f32 lanes.
//!
//! In: rays that have entered the cube. Out: for each the voxel where it ended, and how. A step is that of the scalar
//! walk ([`super::super::walk`]) for all lanes alike: no stack, no branch; the box is looked up from the top grid down,
//! every time. Two packets are in flight, stage by stage, so that the look-ups of one hide behind those of the other.
//!
//! A voxel is known as an integer; a ray by its place relative to the middle of the voxel where it entered, where f32 is
//! finest. A step is certain if exactly one plane comes first, and the place on both other axes then is nearer to
//! the middle of a voxel than [`Walks::half`] less [`SLOPE`] times the time: docs/numerics.md.

use fearless_simd::{Simd, prelude::*};

use super::enter::Walks;
use super::{CHUNK, LANES};
use crate::simd::{Level, dispatch, least, most};
use crate::trace::ray::axes;

/// How the walk of a ray ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub(super) enum End {
    /// It left the cube, or its end came.
    Miss,
    /// In a filled voxel.
    Hit,
    /// In a voxel that f32 cannot tell the way out of.
    Unclear,
    /// It has not begun.
    Whole,
}

/// Where rays ended, by number.
#[repr(align(64))] // vectors lie within lines of the cache
pub(super) struct Ends {
    pub how: [End; CHUNK],
    /// As columns, whole numbers.
    pub voxels: [[f64; CHUNK]; 3],
}

impl Ends {
    pub(super) const ZERO: Ends = Ends { how: [End::Miss; CHUNK], voxels: [[0.0; CHUNK]; 3] };

    #[inline(always)]
    pub(super) fn voxel(&self, number: usize) -> [i32; 3] {
        axes(|i| self.voxels[i][number] as i32)
    }
}

/// What rays walk through.
#[derive(Clone, Copy)]
pub(super) struct Tables<'a> {
    /// The top grid: its words, cells a side as a power of two, and level.
    pub top: &'a [u32],
    pub bits: u32,
    pub level: u32,
    /// The wide tree: its words and depth.
    pub words: &'a [u32],
    pub depth: u32,
}

/// What a unit of time adds to the bound of a place: 8 x 2^-24.
const SLOPE: f32 = 8.0 / 16_777_216.0;

/// A ray in each lane.
#[derive(Clone, Copy)]
struct Packet<S: Simd> {
    /// One bit for each lane that has a ray.
    live: u64,
    number: S::i32s,
    voxel: [S::i32s; 3],
    /// The middle of the voxel where the ray entered, and from there to the ray's place at time 0.
    base: [S::f32s; 3],
    off: [S::f32s; 3],
    dir: [S::f32s; 3],
    inverse: [S::f32s; 3],
    /// All ones where the direction is positive (or 0), else 0.
    up: [S::i32s; 3],
    /// Where the top grid for its octant begins, and half a node of the wide tree for it.
    octant: S::i32s,
    part: S::i32s,
    /// Factors that move what a word of the wide tree says for the octant: of a node to bit 18, of a brick to bit 14.
    align: [S::i32s; 2],
    half: S::f32s,
    stop: S::f32s,
    end: S::f32s,
}

/// Walks all rays. If `exact`, what f32 cannot tell ends as [`End::Unclear`]; if `bounded`, rays have ends.
pub(super) fn walk(level: Level, tables: &Tables<'_>, exact: bool, bounded: bool, walks: &Walks, ends: &mut Ends) {
    dispatch!(level, simd => match (exact, bounded) {
        (true, true) => in_lanes::<_, true, true>(simd, tables, walks, ends),
        (true, false) => in_lanes::<_, true, false>(simd, tables, walks, ends),
        (false, true) => in_lanes::<_, false, true>(simd, tables, walks, ends),
        (false, false) => in_lanes::<_, false, false>(simd, tables, walks, ends),
    });
}

#[inline(always)]
fn in_lanes<S: Simd, const EXACT: bool, const BOUNDED: bool>(
    simd: S,
    tables: &Tables<'_>,
    walks: &Walks,
    ends: &mut Ends,
) {
    let mut packets = [Packet::<S>::idle(simd); 2];
    let mut next = 0;
    loop {
        for packet in &mut packets {
            packet.refill(simd, tables, walks, &mut next);
        }
        let [a, b] = &mut packets;
        if a.live | b.live == 0 {
            break;
        }
        let cells = [a.cell(simd, tables), b.cell(simd, tables)];
        // Where all lanes are in empty cells of the grid, nothing is below.
        let below = match (cells[0].max(cells[1])).simd_ge(0).any_true() {
            true => [a.below(simd, tables, cells[0]), b.below(simd, tables, cells[1])],
            false => [(cells[0], cells[0]); 2],
        };
        let ended = [
            a.step::<EXACT, BOUNDED>(simd, tables, cells[0], below[0]),
            b.step::<EXACT, BOUNDED>(simd, tables, cells[1], below[1]),
        ];
        a.retire(ended[0], ends);
        b.retire(ended[1], ends);
    }
}

/// The words at so many places. None is out of range: voxels, also those of lanes without a ray, lie in the cube, the tree's
/// words name its own nodes, and a grid's words were checked to be nodes of the tree when the tracer was made.
#[inline(always)]
fn gather<S: Simd>(simd: S, words: &[u32], at: S::i32s) -> S::i32s {
    let at = at.as_slice();
    S::i32s::from_fn(simd, |lane| words[at[lane] as u32 as usize] as i32)
}

impl<S: Simd> Packet<S> {
    #[inline(always)]
    fn idle(simd: S) -> Self {
        let (zero, int) = (S::f32s::splat(simd, 0.0), S::i32s::splat(simd, 0));
        Packet {
            live: 0,
            number: int,
            voxel: [int; 3],
            base: [zero; 3],
            off: [zero; 3],
            dir: [zero; 3],
            inverse: [zero; 3],
            up: [int; 3],
            octant: int,
            part: int,
            align: [int; 2],
            half: zero,
            stop: zero,
            end: zero,
        }
    }

    /// Fills the idle lanes with the next rays if at least a quarter of all are idle.
    #[inline(always)]
    fn refill(&mut self, simd: S, tables: &Tables<'_>, walks: &Walks, next: &mut usize) {
        let width = S::i32s::LEN;
        let left = walks.len.saturating_sub(*next);
        let mut lanes = !self.live & (u64::MAX >> (64 - width));
        if left == 0 || lanes.count_ones() < width as u32 / 4 {
            return;
        }
        for _ in left..lanes.count_ones() as usize {
            lanes &= !(1 << (63 - lanes.leading_zeros()));
        }
        let mask = S::mask32s::from_bitmask(simd, lanes);
        let from = (*next).min(CHUNK);
        *next += lanes.count_ones() as usize;
        self.live |= lanes;

        let numbers = S::i32s::from_slice(simd, &walks.number[from..from + width]);
        self.number = numbers.expand_merge(mask, self.number);
        let mut octant = S::i32s::splat(simd, 0);
        for i in 0..3 {
            let voxel = S::f32s::from_slice(simd, &walks.voxel[i][from..from + width]).expand(mask);
            self.voxel[i] = mask.select(voxel.to_int(), self.voxel[i]);
            self.base[i] = mask.select(voxel + 0.5, self.base[i]);
            load(simd, &walks.off[i], from, mask, &mut self.off[i]);
            load(simd, &walks.dir[i], from, mask, &mut self.dir[i]);
            load(simd, &walks.inverse[i], from, mask, &mut self.inverse[i]);
            self.up[i] = self.dir[i].simd_ge(0.0).select(S::i32s::splat(simd, -1), S::i32s::splat(simd, 0));
            octant |= self.up[i] & (1 << i);
        }
        self.octant = octant << (3 * tables.bits);
        self.part = octant << 4 & 64;
        let one = S::i32s::splat(simd, 1);
        let behind = |bit: i32| (octant & bit).simd_eq(0);
        self.align = [
            behind(1).select(one << 6, one) * behind(2).select(one << 12, one),
            behind(1).select(one << 2, one) * behind(2).select(one << 4, one) * behind(4).select(one << 8, one),
        ];
        load(simd, &walks.half, from, mask, &mut self.half);
        load(simd, &walks.stop, from, mask, &mut self.stop);
        load(simd, &walks.end, from, mask, &mut self.end);
    }

    /// The words of the top grid's cells.
    #[inline(always)]
    fn cell(&self, simd: S, tables: &Tables<'_>) -> S::i32s {
        let [x, y, z] = self.voxel;
        let (bits, level) = (tables.bits, tables.level);
        gather(simd, tables.top, ((((z >> level) << bits) | (y >> level)) << bits | (x >> level)) | self.octant)
    }

    /// From these words down: the side of the cell that the voxel is in, 0 if it is filled; and the box of such cells that
    /// is empty ahead, in the code of the wide tree. Negative words, of empty cells of the grid, give anything.
    #[inline(always)]
    fn below(&self, simd: S, tables: &Tables<'_>, cell: S::i32s) -> (S::i32s, S::i32s) {
        let zero = S::i32s::splat(simd, 0);
        let [x, y, z] = self.voxel;
        // Go down to the brick. What has met an empty cell looks on at node 0, and what it sees does not count.
        let (mut word, mut side) = (cell, zero);
        let mut level = tables.level;
        while level > 2 {
            level -= 2;
            let place = (x >> level & 3) | (y >> level & 3) << 2 | (z >> level & 3) << 4 | self.part;
            let below = gather(simd, tables.words, word.max(zero) + place);
            let open = word.simd_lt(zero);
            side = open.select(side, S::i32s::splat(simd, 1 << level));
            word = open.select(word, below);
        }
        // Look at the voxel: filled, or how much around and ahead of it is empty.
        let place = (x & 3) >> 1 | (y & 3) << 1 | (z & 3) << 3;
        let pair = gather(simd, tables.words, word.max(zero) + place);
        let own = (x & 1).simd_eq(zero).select(pair, pair >> 16);
        let code = (own * self.align[1]) >> 14 & 3;
        let open = word.simd_lt(zero);
        (open.select(side, code + (code >> 1 & code)), open.select((word * self.align[0]) >> 18 & 63, zero))
    }

    /// Leaves the boxes of all rays; gives the lanes that hit, those that missed, and those that cannot tell, which stay
    /// where they are.
    #[inline(always)]
    fn step<const EXACT: bool, const BOUNDED: bool>(
        &mut self,
        simd: S,
        tables: &Tables<'_>,
        cell: S::i32s,
        (side, ahead): (S::i32s, S::i32s),
    ) -> [u64; 3] {
        let zero = S::i32s::splat(simd, 0);
        // Find when the ray crosses the planes ahead.
        let boxed = cell.simd_lt(zero);
        let level = tables.level;
        let far = [(cell & 0x1ff) << level, (cell >> 9 & 0x1ff) << level, (cell >> 18 & 0x1ff) << level];
        let more = [ahead & 3, ahead >> 2 & 3, ahead >> 4];
        let mut planes = [zero; 3];
        let mut times = [S::f32s::splat(simd, 0.0); 3];
        for i in 0..3 {
            // One more than these cells upwards, less them downwards.
            let cells = (more[i] ^ !self.up[i]) + 1;
            planes[i] = boxed.select(far[i], (self.voxel[i] & (zero - side)) + side * cells);
            let plane: S::f32s = planes[i].to_float();
            times[i] = ((plane - self.base[i]) - self.off[i]) * self.inverse[i];
        }
        let others = [least(times[1], times[2]), least(times[2], times[0]), least(times[0], times[1])];
        let now = least(times[0], others[0]);

        // Cross the first one, and follow the ray on the other axes.
        let mut next = self.voxel;
        let mut worst = S::f32s::splat(simd, 0.0);
        let mut bits = zero;
        for i in 0..3 {
            let place = self.off[i] + self.dir[i] * now;
            let middle = place.round_ties_even();
            let there: S::i32s = (middle + (self.base[i] - 0.5)).to_int();
            let crossed = planes[i] + !self.up[i];
            next[i] = if EXACT {
                // At a tie no axis is before the others, and those that tie are far from all middles.
                let first = times[i].simd_lt(others[i]);
                worst = first.select(worst, most(worst, (place - middle).abs()));
                first.select(crossed, there)
            } else {
                // Stay in the box, whatever was rounded how.
                let down = !self.up[i];
                let low = (self.voxel[i] & self.up[i]) | (planes[i] & down);
                let high = ((planes[i] - 1) & self.up[i]) | (self.voxel[i] & down);
                times[i].simd_le(now).select(crossed, there.max(low).min(high))
            };
            bits |= next[i];
        }

        // Tell those that go on from those that end.
        let hit = self.live & (side | (cell & i32::MIN)).simd_eq(zero).to_bitmask();
        let mut missed = (bits >> tables.depth).simd_ne(zero).to_bitmask();
        let mut unclear = if EXACT { !worst.simd_lt(self.half - now * SLOPE).to_bitmask() } else { 0 };
        if BOUNDED {
            let over = now.simd_gt(self.end).to_bitmask();
            unclear = (unclear | !now.simd_lt(self.stop).to_bitmask()) & !over;
            missed |= over;
        }
        let left = self.live & !hit;
        let unclear = unclear & left;
        let missed = missed & left & !unclear;
        self.live = left & !unclear & !missed;
        let on = S::mask32s::from_bitmask(simd, self.live);
        for i in 0..3 {
            self.voxel[i] = on.select(next[i], self.voxel[i]);
        }
        [hit, missed, unclear]
    }

    /// Writes down the rays that have ended.
    #[inline(always)]
    fn retire(&self, [hit, missed, unclear]: [u64; 3], ends: &mut Ends) {
        let mut lanes = hit | missed | unclear;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes - 1;
            let number = self.number.as_slice()[lane] as usize % CHUNK;
            ends.how[number] = match (hit >> lane & 1, unclear >> lane & 1) {
                (0, 0) => End::Miss,
                (0, _) => End::Unclear,
                _ => End::Hit,
            };
            for i in 0..3 {
                ends.voxels[i][number] = f64::from(self.voxel[i].as_slice()[lane]);
            }
        }
    }
}

/// Puts the next values of a column into the lanes of a mask.
#[inline(always)]
fn load<S: Simd>(simd: S, column: &[f32], from: usize, mask: S::mask32s, lanes: &mut S::f32s) {
    *lanes = S::f32s::from_slice(simd, &column[from..from + S::f32s::LEN]).expand_merge(mask, *lanes);
}
