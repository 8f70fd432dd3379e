//! Lines of sight, walls between two places, and how far a ball can move: for physics, audio and games.
//!
//! `cargo run --release -p voxdag --features obj --example sight`

use std::error::Error;

use voxdag::build::{DagBuf, DagBuilder};
use voxdag::geometry::BRICK_LEVEL;
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::{Geometry, Morton, math};

/// The ray from one place to another, in grid coordinates; t is 1 at the other.
fn between(from: [f64; 3], to: [f64; 3]) -> Query {
    Query { t_max: 1.0, ..Query::new(from, math::sub(to, from)) }
}

/// Whether nothing stands between two places.
fn sees<G: Geometry>(tracer: &Tracer<'_, G>, from: [f64; 3], to: [f64; 3]) -> bool {
    !tracer.occluded(Arithmetic::Exact, &between(from, to))
}

/// How many filled voxels lie on the way between two places: what muffles a sound.
fn voxels_between<G: Geometry>(tracer: &Tracer<'_, G>, from: [f64; 3], to: [f64; 3]) -> usize {
    tracer.hits(&between(from, to)).count()
}

/// How far a ball can move before it touches a filled voxel: the share of the way, 1 for all of it.
///
/// Conservative: never too late, and too early only by what passes it within 0.37 voxels: half a voxel's diagonal, less half
/// its side.
fn sweep<G: Geometry>(geometry: &G, radius: f64, from: [f64; 3], to: [f64; 3]) -> f64 {
    let way = math::sub(to, from);
    // Rounding must not make it late.
    let largest = from.iter().chain(&to).fold(0.0, |most: f64, x| most.max(x.abs()));
    let radius = radius * (1.0 + 1e-9) + 1e-9 + 1e-14 * largest;
    // A node holds its box, and a ball around the middle of it: neither is touched before what lies inside.
    let touched = |corner: [u32; 3], side: u32| {
        let (corner, side) = (corner.map(f64::from), f64::from(side));
        let middle = corner.map(|x| x + side / 2.0);
        let around = radius + side * 3f64.sqrt() / 2.0;
        let (mut first, mut last) = meets_ball(math::sub(from, middle), way, around)?;
        for i in 0..3 {
            let (low, high) = (corner[i] - radius - from[i], corner[i] + side + radius - from[i]);
            if way[i] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / way[i], high / way[i]);
            first = first.max(a.min(b));
            last = last.min(a.max(b));
        }
        (first <= last && last >= 0.0).then_some(first.max(0.0))
    };

    let mut best = 1.0;
    if geometry.is_empty() {
        return best;
    }
    // At most eight children wait on each of 20 levels.
    let mut stack = [(0, 0, [0; 3], 0.0); 160];
    let top = geometry.depth().max(BRICK_LEVEL);
    stack[0] = (geometry.root(), top, [0; 3], 0.0);
    let mut waiting = 1;
    while waiting > 0 {
        waiting -= 1;
        let (node, level, corner, time) = stack[waiting];
        if time >= best {
            continue;
        }
        if level == BRICK_LEVEL {
            let mask = geometry.brick_at(node);
            for bit in (0..64).filter(|bit| mask >> bit & 1 != 0) {
                let inside = Morton(bit).decode();
                let voxel = [0, 1, 2].map(|i| corner[i] + inside[i]);
                best = touched(voxel, 1).map_or(best, |time| time.min(best));
            }
            continue;
        }
        let half = 1 << (level - 1);
        for octant in 0..8 {
            let Some(child) = geometry.child(node, level, octant) else { continue };
            let corner = [0, 1, 2].map(|i| corner[i] + half * (octant >> i & 1));
            if let Some(time) = touched(corner, half).filter(|&time| time < best) {
                stack[waiting] = (child, level - 1, corner, time);
                waiting += 1;
            }
        }
    }
    best
}

/// When a point, `from` the middle of a ball, on its `way` goes into the ball and out of it.
fn meets_ball(from: [f64; 3], way: [f64; 3], radius: f64) -> Option<(f64, f64)> {
    let (a, b) = (math::dot(way, way), math::dot(from, way));
    if a == 0.0 {
        return (math::dot(from, from) <= radius * radius).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    // Where it is nearest to the middle: squares of large numbers would swallow the radius.
    let near = math::add_scaled(from, way, -b / a);
    let rest = radius * radius - math::dot(near, near);
    if rest < 0.0 {
        return None;
    }
    let root = math::sqrt(rest / a);
    Some((-b / a - root, -b / a + root))
}

/// A wall with a door, 32 voxels high.
fn wall() -> Result<DagBuf, Box<dyn Error>> {
    let is_filled = |[x, y, z]: [u32; 3]| (15..17).contains(&x) && !((12..20).contains(&z) && y < 20);
    let mut builder = DagBuilder::new(5)?;
    for brick in 0..8u64.pow(3) {
        let filled = (0..64).filter(|bit| is_filled(Morton(64 * brick + bit).decode()));
        let mask = filled.fold(0, |mask, bit| mask | 1 << bit);
        if mask != 0 {
            builder.push(Morton(64 * brick), mask)?;
        }
    }
    Ok(builder.finish()?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let wall = wall()?;
    let tracer = Tracer::new(wall.dag());
    for (what, from, to) in [
        ("through the door", [2.0, 8.0, 16.0], [30.0, 8.0, 16.0]),
        ("through the wall", [2.0, 8.0, 5.0], [30.0, 8.0, 5.0]),
    ] {
        println!(
            "{what}, from {from:?} to {to:?}: {}, {} voxels between; of this way a ball with a radius of 3 voxels gets {:.0} %, \
             with one of 5 {:.0} %",
            if sees(&tracer, from, to) { "in sight" } else { "out of sight" },
            voxels_between(&tracer, from, to),
            100.0 * sweep(&wall.dag(), 3.0, from, to),
            100.0 * sweep(&wall.dag(), 5.0, from, to),
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_door_lets_sight_sound_and_small_balls_through() {
        let wall = wall().unwrap();
        let tracer = Tracer::new(wall.dag());
        let [door, side] = [16.0, 5.0].map(|z| [[2.0, 8.0, z], [30.0, 8.0, z]]);
        assert!(sees(&tracer, door[0], door[1]) && !sees(&tracer, side[0], side[1]));
        assert_eq!((voxels_between(&tracer, door[0], door[1]), voxels_between(&tracer, side[0], side[1])), (0, 2));
        assert_eq!(sweep(&wall.dag(), 3.0, door[0], door[1]), 1.0);
        // The wall begins 13 voxels from the start; the ball touches it 3 before.
        let stop = sweep(&wall.dag(), 3.0, side[0], side[1]) * 28.0;
        assert!((9.13..=10.0).contains(&stop), "{stop}");
    }

    /// Against small steps and the distance to every voxel.
    #[test]
    fn a_ball_is_stopped_never_late_and_by_something_near() {
        let mut state = 7u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut stopped = 0;
        for round in 0..300 {
            let mut builder = DagBuilder::new(4).unwrap();
            for brick in 0..64 {
                let mask = (0..64).filter(|_| unit() < 0.004).fold(0u64, |mask, bit| mask | 1 << bit);
                if mask != 0 {
                    builder.push(Morton(64 * brick), mask).unwrap();
                }
            }
            let built = builder.finish().unwrap();
            let [from, to] = [(); 2].map(|()| [(); 3].map(|()| unit() * 24.0 - 4.0));
            let (radius, way) = (unit() * 3.0, math::sub(to, from));
            // From the ball's middle to the nearest voxel.
            let gap = |time: f64| {
                let center = math::add_scaled(from, way, time);
                let gaps = built.dag().voxels().map(|voxel| {
                    let corner = voxel.decode().map(f64::from);
                    let off = [0, 1, 2].map(|i| center[i] - center[i].clamp(corner[i], corner[i] + 1.0));
                    math::sqrt(math::dot(off, off))
                });
                gaps.fold(f64::INFINITY, f64::min)
            };
            let stop = sweep(&built.dag(), radius, from, to);
            let steps = (0..=1000).map(|i| f64::from(i) / 1000.0).take_while(|time| *time < stop);
            assert!(steps.map(gap).all(|gap| gap > radius), "round {round}: late");
            if stop < 1.0 {
                stopped += 1;
                assert!(
                    gap(stop) < radius + 0.367,
                    "round {round}: stopped by nothing, {} from it",
                    gap(stop) - radius
                );
            }
        }
        assert!(stopped > 80, "{stopped} sweeps that meet something are too few to say anything");
    }
}
