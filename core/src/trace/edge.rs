//! The f64 filter at its edge: near ties, decided by rounded values and by the exact order.

use super::ray::Ray;
use super::{Arithmetic, Query, Tracer};
use crate::morton::Morton;
use crate::trace::ray::UNIT;

/// Enough to come to the edge, but for Miri, which is some thousand times slower.
const RAYS: u32 = if cfg!(miri) { 300 } else { 400_000 };

/// Splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: u64) -> i32 {
        (self.next() % n) as i32
    }
}

/// A ray through, or past by some units in the last place, the edge x = a, y = b, and its two planes.
fn near_tie(random: &mut Random, size: i32) -> (Query, i32, i32) {
    let (a, b) = (1 + random.below(size as u64 - 1), 1 + random.below(size as u64 - 1));
    let d = [0.1 + random.unit(), 0.1 + random.unit(), 1e-3 * random.unit()];
    let t = f64::from(size) * (0.5 + random.unit());
    let mut o = [f64::from(a) - d[0] * t, f64::from(b) - d[1] * t, 0.5];
    o[1] = f64::from_bits(o[1].to_bits().wrapping_add_signed(i64::from(random.below(9)) - 4));
    (Query::new(o, d), a, b)
}

#[test]
fn f64_is_wrong_only_within_the_slack_and_comes_near_to_what_was_derived() {
    let mut random = Random(3);
    let (mut worst, mut fell_back) = (0.0f64, 0);
    const SIZE: i32 = 1024;
    for _ in 0..RAYS {
        let (query, a, b) = near_tie(&mut random, SIZE);
        let ray = Ray::new::<true>(&query, SIZE).unwrap();
        let (x, y) = (ray.crossing(0, a), ray.crossing(1, b));
        let exact = ray.order::<true>(&x, &y);
        // Where the two are further apart than the slack, the rounded times are in the right order.
        let apart = x.t - y.t;
        let wrong = apart != 0.0 && (apart < 0.0) != exact.is_lt() && exact.is_ne();
        fell_back += u32::from(apart.abs() <= ray.time_slack());
        if wrong || exact.is_eq() {
            worst = worst.max(apart.abs() / (ray.time_slack() / 16.0));
        }
    }
    // docs/numerics.md derives 10.1 units of 2^-53 of the longest time, against a slack of 16.
    assert!(worst <= 10.1, "{worst} units");
    assert!(cfg!(miri) || worst > 2.0, "the test does not reach the edge: {worst} units");
    assert!(fell_back > RAYS / 4, "only {fell_back} near ties");
}

#[test]
fn places_are_wrong_only_within_the_slack_and_come_near_to_what_was_derived() {
    let mut random = Random(5);
    let mut worst = 0.0f64;
    const SIZE: i32 = 1024;
    for _ in 0..RAYS {
        let (query, a, b) = near_tie(&mut random, SIZE);
        let ray = Ray::new::<true>(&query, SIZE).unwrap();
        // Where it crosses x = a it is within rounding of y = b: above it if it has crossed that plane by then.
        let now = ray.crossing(0, a);
        let middle = query.origin[1] + query.dir[1] * now.t - 0.5;
        let above = ray.order::<true>(&ray.crossing(1, b), &now).is_le();
        let place = middle + 0.5 - f64::from(b);
        if (place >= 0.0) != above {
            worst = worst.max(place.abs() / ((0.5 - ray.half()) / 16.0));
        }
        // What passes for certain is right.
        let (k, certain) = ray.place(1, now.t);
        assert!(!certain || k == if above { b } else { b - 1 }, "{query:?}");
    }
    // docs/numerics.md derives 6.1 units of the terms, against a slack of 16.
    assert!(worst <= 6.1, "{worst} units");
    assert!(cfg!(miri) || worst > 0.3, "the test does not reach the edge: {worst} units");
}

#[test]
fn the_slacks_are_sixteen_units_of_what_they_are_to_bound() {
    // Origin 3 before the cube and t_min 0: the longest time is that of the far plane, 19 / 2.
    let ray = Ray::new::<true>(&Query::new([-3.0, 1.5, 2.5], [2.0, 0.0, 0.0]), 16).unwrap();
    assert_eq!(UNIT, 16.0 * f64::EPSILON / 2.0);
    assert_eq!(ray.time_slack(), 9.5 * UNIT);
    assert_eq!(ray.half(), 0.5 - (3.0 + 1.5 + 2.5 + 2.0 * 9.5 + 16.0) * UNIT);
    // A longer t_min counts, too; numbers at the ends of the range leave everything to exact arithmetic.
    let late = Query { t_min: 100.0, ..Query::new([-3.0, 1.5, 2.5], [2.0, 0.0, 0.0]) };
    assert_eq!(Ray::new::<true>(&late, 16).unwrap().time_slack(), 100.0 * UNIT);
    for tiny in [1e-300, -5e-324, 1e200] {
        let ray = Ray::new::<true>(&Query::new([-3.0, 1.5, 2.5], [2.0, tiny, 0.0]), 16).unwrap();
        assert_eq!((ray.time_slack(), ray.half()), (f64::INFINITY, f64::NEG_INFINITY), "{tiny}");
    }
}

#[test]
fn far_and_near_ties_are_counted() {
    let mut builder = crate::build::DagBuilder::new(4).unwrap();
    builder.push(Morton::encode([12, 12, 0]).unwrap(), 1).unwrap();
    let built = builder.finish().unwrap();
    let tracer = Tracer::new(built.dag());
    let close = |d: [f64; 3]| tracer.trace_counted(Arithmetic::Exact, &Query::new([0.5, 0.5, 0.25], d)).1.close;
    assert_eq!(close([1.0, 0.3, 0.0]), 0);
    // Along the diagonal every edge is a tie.
    assert!(close([1.0, 1.0, 0.0]) > 0);
    assert_eq!(tracer.trace_counted(Arithmetic::F64, &Query::new([0.5, 0.5, 0.25], [1.0, 0.3, 0.0])).1.close, 0);
}
