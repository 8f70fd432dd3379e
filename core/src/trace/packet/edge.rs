//! The bounds of f32 lanes at their edge: places at crossings, by f32 as the lanes have them and by f64.

use super::enter::{Rays, Walks, enter};
use super::walk::Ends;
use super::{CHUNK, Made, Source};
use crate::simd::Level;
use crate::trace::Query;

/// Enough to come near to the edge.
const RAYS: usize = 200_000;
const SIZE: i32 = 1024;
/// 2^-24.
const V: f64 = 1.0 / 16_777_216.0;

/// A linear generator of numbers from 0 to 1.
fn unit(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
#[cfg_attr(miri, ignore = "minutes: it interprets vectors lane by lane")]
fn places_are_off_by_less_than_the_bound_and_come_near_to_what_was_derived() {
    let Some(level) = Level::best() else { return };
    let mut state = 7;
    let (mut rays, mut walks, mut ends) = (Rays::ZERO, Walks::ZERO, Ends::ZERO);
    let (mut worst, mut seen) = (0.0f64, 0);
    while seen < RAYS {
        let queries: [Query; CHUNK] = core::array::from_fn(|_| {
            let size = f64::from(SIZE);
            let origin = [(); 3].map(|()| size * (3.0 * unit(&mut state) - 1.0));
            let target = [(); 3].map(|()| size * unit(&mut state));
            Query::new(origin, core::array::from_fn(|i| target[i] - origin[i]))
        });
        rays.len = CHUNK;
        Made { count: CHUNK, ray: |i| queries[i] }.fill(0, &mut rays);
        enter(level, &mut rays, SIZE, &mut ends, &mut walks);
        for k in 0..walks.len {
            seen += 1;
            let query = &queries[walks.number[k] as usize];
            let lane = |column: &[[f32; CHUNK + super::LANES]; 3]| [0, 1, 2].map(|i| column[i][k]);
            let (voxel, off, dir, inverse) =
                (lane(&walks.voxel), lane(&walks.off), lane(&walks.dir), lane(&walks.inverse));
            // Cross some plane ahead of axis a, and look at the places on the others: as the lanes do, and in f64.
            let a = (0..3).max_by(|&a, &b| dir[a].abs().total_cmp(&dir[b].abs())).unwrap();
            let plane = if dir[a] > 0.0 { SIZE as f32 } else { 0.0 };
            let plane = voxel[a] + ((plane - voxel[a]) * unit(&mut state) as f32) as i32 as f32;
            let now = ((plane - (voxel[a] + 0.5)) - off[a]) * inverse[a];
            if now <= 0.0 {
                continue;
            }
            let time = (f64::from(plane) - query.origin[a]) / query.dir[a];
            for b in (0..3).filter(|b| *b != a) {
                let place = f64::from(off[b] + dir[b] * now);
                let truth = query.origin[b] + query.dir[b] * time - f64::from(voxel[b]) - 0.5;
                let bound = (0.5 - f64::from(walks.half[k])) + f64::from(now) * 8.0 * V;
                assert!((place - truth).abs() < bound, "{query:?}: off by {} of {bound}", (place - truth).abs());
                worst =
                    worst.max((place - truth).abs() / (6.1 * V * f64::from(now) + bound - f64::from(now) * 8.0 * V));
            }
        }
    }
    // What was derived is a worst case of seven roundings that add up.
    assert!(worst < 1.0, "{worst} of what was derived");
    assert!(worst > 0.25, "the test does not come near the edge: {worst}");
}
