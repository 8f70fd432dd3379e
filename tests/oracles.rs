//! The oracles against each other, against closed forms and against published cases. Nothing of the core is tested here
//! but Morton codes and the checked view, which the twins must agree with.

use std::collections::BTreeMap;

use voxdag::trace::Face;
use voxdag::{Dag, Morton};
use voxdag_oracle::brute::{self, Fraction, SmallRay};
use voxdag_oracle::clip::{self, Aabb, Cell, SUB, Triangle};
use voxdag_oracle::num::Rational;
use voxdag_oracle::octree::{self, VoxelSet};
use voxdag_oracle::ray::{self, Ray};
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::{self, Implicit, Shape};
use voxdag_oracle::{table, textbook, thin};

// --- numbers ---

#[test]
fn rationals_are_the_floats_they_come_from() {
    let mut rng = Rng::new(1);
    for x in [0.0, 1.0, -1.5, f64::MIN_POSITIVE, 5e-324, -5e-324, f64::MAX, 1e300] {
        assert_eq!(Rational::from_f64(x).unwrap().to_f64(), x);
    }
    for _ in 0..20_000 {
        let x = f64::from_bits(rng.bits());
        match Rational::from_f64(x) {
            Some(r) => assert_eq!(r.to_f64().to_bits(), if x == 0.0 { 0 } else { x.to_bits() }, "{x:e}"),
            None => assert!(!x.is_finite()),
        }
    }
}

#[test]
fn rationals_round_as_ieee_rounds() {
    // Hardware divides and adds with correct rounding: so must we, also into subnormal numbers and into infinity.
    let mut rng = Rng::new(2);
    for _ in 0..20_000 {
        let (a, b) = (rng.spread(-1060, 1020), rng.spread(-200, 200));
        let [ra, rb] = [a, b].map(|x| Rational::from_f64(x).unwrap());
        assert_eq!(ra.over(&rb).to_f64(), a / b, "{a:e} / {b:e}");
        assert_eq!(ra.times(&rb).to_f64(), a * b, "{a:e} * {b:e}");
        let c = a * (1.0 + rng.unit());
        if c.is_finite() {
            assert_eq!(ra.plus(&Rational::from_f64(c).unwrap()).to_f64(), a + c, "{a:e} + {c:e}");
        }
        let x = rng.spread(-3, 40);
        let r = Rational::from_f64(x).unwrap();
        assert_eq!((r.floor(), r.ceil()), (Some(x.floor() as i64), Some(x.ceil() as i64)), "{x:e}");
    }
}

// --- rays ---

/// All non-zero directions with components of -2 to 2.
fn small_directions() -> Vec<[i64; 3]> {
    let all = (0..125).map(|i| [i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2]);
    all.filter(|d| *d != [0, 0, 0]).collect()
}

fn as_ray(small: &SmallRay) -> Ray {
    Ray {
        origin: small.origin4.map(|x| x as f64 / 4.0),
        dir: small.dir.map(|x| x as f64),
        t_min: small.t_min.0 as f64 / small.t_min.1 as f64,
        t_max: small.t_max.map_or(f64::INFINITY, |t| t.0 as f64 / t.1 as f64),
    }
}

/// The walk, the descent and the brute force must say the same of a ray, and of a random set of voxels along it.
fn check_ray(small: &SmallRay, rng: &mut Rng) {
    let ray = as_ray(small);
    let walk = ray::walk(&ray, 3, usize::MAX);
    assert_eq!(walk, brute::walk(small, 8), "{small:?}");

    // Any voxel of the walk may be the first filled one.
    let last = if walk.is_empty() { 0 } else { rng.below(walk.len() as u64 + 1) as usize };
    let filled = |v: [u32; 3]| walk.iter().skip(last).any(|&w| w == v);
    let any = |level: u8, corner: [u32; 3]| {
        walk.iter().skip(last).any(|v| (0..3).all(|i| v[i] >> level == corner[i] >> level))
    };
    let truth = ray::first(&ray, 3, 0, &any);
    assert_eq!(truth.as_ref().map(|t| t.voxel), walk.iter().copied().find(|&v| filled(v)), "{small:?}");
    let Some(truth) = truth else { return };

    // Where the ray comes from, and through which side.
    let before = if last == 0 { None } else { Some(walk[last - 1]) };
    assert_eq!(truth.from, before, "{small:?}");
    let position: [f64; 3] = core::array::from_fn(|i| ray.origin[i] + ray.dir[i] * ray.t_min);
    if position.map(f64::floor) == truth.voxel.map(f64::from) {
        assert_eq!((truth.face, truth.t), (Face::Inside, ray.t_min), "{small:?}");
    } else if let Some(before) = before {
        let crossed = (0..3).filter(|&i| before[i] != truth.voxel[i]);
        let axis = crossed.max_by_key(|&i| (small.dir[i].abs(), std::cmp::Reverse(i))).unwrap();
        let n = truth.face.normal();
        assert_eq!(n[axis], -small.dir[axis].signum() as f32, "{small:?}");
        assert_eq!(n.iter().filter(|x| **x != 0.0).count(), 1, "{small:?}");
        // Its plane is where the ray is at t.
        let plane = if small.dir[axis] > 0 { truth.voxel[axis] } else { truth.voxel[axis] + 1 };
        let t = (f64::from(plane) - ray.origin[axis]) / ray.dir[axis];
        assert_eq!(truth.t, t, "{small:?}");
    }

    // A coarser question: the first cube of side 2 that holds a filled voxel.
    let coarse = ray::first(&ray, 3, 1, &any).unwrap();
    let first = walk.iter().map(|v| v.map(|k| k & !1)).find(|&c| any(1, c)).unwrap();
    assert_eq!(coarse.voxel, first, "{small:?}");
    assert!(coarse.time <= truth.time, "{small:?}");
}

#[test]
fn rays_from_every_lattice_point_in_every_small_direction() {
    // Corners, edges and face planes of the lattice: 90 396 rays, all of them full of ties.
    let mut rng = Rng::new(3);
    for origin in 0..9 * 9 * 9 {
        let origin4 = [origin % 9 * 4, origin / 9 % 9 * 4, origin / 81 * 4];
        for dir in small_directions() {
            check_ray(&SmallRay { origin4, dir, t_min: Fraction(0, 1), t_max: None }, &mut rng);
        }
    }
}

#[test]
fn rays_from_anywhere_with_ranges() {
    for seed in 0..40_000 {
        let mut rng = Rng::new(seed);
        let origin4 = [(); 3].map(|()| rng.between(-20, 52));
        let dir = rng.pick(&small_directions()).map(|d| d * rng.pick(&[1, 1, 2, 3]));
        let t_min = Fraction(rng.between(-16, 16), 4);
        let length = Fraction(rng.between(0, 40), 4);
        let t_max = (rng.below(3) > 0).then_some(Fraction(t_min.0 + length.0, 4));
        check_ray(&SmallRay { origin4, dir, t_min, t_max }, &mut rng);
    }
}

#[test]
fn the_length_of_a_direction_does_not_matter() {
    for seed in 0..300 {
        let mut rng = Rng::new(seed);
        let origin = [(); 3].map(|()| rng.uniform(-4.0, 12.0));
        let dir = rng.direction();
        let walk = ray::walk(&Ray::new(origin, dir), 3, usize::MAX);
        for exponent in [-1000, -60, 1, 900] {
            let scaled = dir.map(|d| libm::scalbn(d, exponent));
            assert_eq!(walk, ray::walk(&Ray::new(origin, scaled), 3, usize::MAX), "seed {seed}");
        }
    }
}

#[test]
fn what_is_no_ray_hits_nothing() {
    let everything = |_: u8, _: [u32; 3]| true;
    let good = Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
    assert!(ray::first(&good, 3, 0, &everything).is_some());
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut ray = good;
            ray.origin[axis] = bad;
            assert_eq!(ray::first(&ray, 3, 0, &everything), None);
            let mut ray = good;
            ray.dir[axis] = bad;
            assert_eq!(ray::first(&ray, 3, 0, &everything), None);
        }
    }
    assert_eq!(ray::first(&Ray::new([1.0; 3], [0.0; 3]), 3, 0, &everything), None);
    assert_eq!(ray::first(&Ray { t_min: f64::NAN, ..good }, 3, 0, &everything), None);
    assert_eq!(ray::first(&Ray { t_max: f64::NAN, ..good }, 3, 0, &everything), None);
    assert_eq!(ray::first(&Ray { t_min: f64::INFINITY, ..good }, 3, 0, &everything), None);
    let whole_line = ray::first(&Ray { t_min: f64::NEG_INFINITY, ..good }, 3, 0, &everything).unwrap();
    assert_eq!((whole_line.voxel, whole_line.t, whole_line.face), ([0, 0, 0], 1.0, Face::NegX));
}

#[test]
fn descent_and_walk_agree_at_depth_21() {
    let shapes = [
        Implicit::Shell { centre: [1 << 21; 3], inner: 2_000_000, outer: 2_000_006 },
        Implicit::Wall { axis: 1, lo: 1_000_000, hi: 1_000_001 },
        Implicit::Diagonal { lo: 3_000_000, hi: 3_000_001 },
        Implicit::Dust { at: [3, 0, 1] },
    ];
    for seed in 0..40 {
        let mut rng = Rng::new(seed);
        let shape = shapes[seed as usize % 4];
        // Start near a place where the shape is, so that the walk is short.
        let aim = [(); 3].map(|()| rng.uniform(900_000.0, 1_100_000.0));
        let dir = rng.direction();
        let probe = ray::first(&Ray::new(aim, dir), 21, 0, &|h, c| shape.any(h, c));
        let Some(probe) = probe else { continue };
        let near: [f64; 3] = core::array::from_fn(|i| aim[i] + dir[i] * (probe.t - 100.0).max(0.0));
        let ray = Ray::new(near, dir);
        let truth = ray::first(&ray, 21, 0, &|h, c| shape.any(h, c)).expect("it was there before");
        let walk = ray::walk(&ray, 21, 2000);
        let at = walk.iter().position(|&v| shape.filled(v)).expect("within 300 voxels");
        assert_eq!(walk[at], truth.voxel, "seed {seed}");
        assert_eq!(truth.from, at.checked_sub(1).map(|i| walk[i]), "seed {seed}");
    }
}

// --- overlap ---

fn whole(t: [[i64; 3]; 3]) -> Triangle {
    t.map(|p| p.map(|x| x * SUB))
}

#[test]
fn segments_meet_the_voxels_that_a_ray_along_them_meets() {
    // A triangle without area against the ray oracle: two methods that share nothing, ties included.
    for seed in 0..3000 {
        let mut rng = Rng::new(seed);
        let coarse = rng.pick(&[1, 64, 128, 256]);
        let [a, b] = [(); 2].map(|()| [(); 3].map(|()| rng.below(8 * 256 / coarse as u64) as i64 * coarse));
        let origin = a.map(|x| x as f64 / 256.0);
        let dir: [f64; 3] = core::array::from_fn(|i| (b[i] - a[i]) as f64 / 256.0);
        let mut met = ray::walk(&Ray { origin, dir, t_min: 0.0, t_max: 1.0 }, 3, usize::MAX);
        met.push(b.map(|x| (x / 256) as u32));
        for triangle in [[a, b, b], [b, a, a], [a, b, a]] {
            let cover = clip::cover(&[triangle], 3, Cell::HalfOpen);
            assert_eq!(cover, met.iter().copied().collect(), "seed {seed}");
        }
    }
}

#[test]
fn closed_overlap_is_the_textbook_test_where_floats_are_exact() {
    // Coordinates below 2^11 in 1/256 voxel: every product of the 13-axis test in f64 is an exact integer.
    let mut met = 0;
    for seed in 0..20_000 {
        let mut rng = Rng::new(seed);
        let coarse = rng.pick(&[1, 16, 128, 256]);
        let triangle: Triangle =
            [(); 3].map(|()| [(); 3].map(|()| rng.below(4 * 256 / coarse as u64 + 1) as i64 * coarse));
        let voxel = [(); 3].map(|()| rng.below(4) as i64);
        let truth = clip::meets_voxel(&triangle, voxel, Cell::Closed);
        let float = textbook::akenine_moller(
            triangle.map(|p| p.map(|x| x as f64)),
            voxel.map(|k| (k * 256 + 128) as f64),
            [128.0; 3],
        );
        assert_eq!(truth, float, "seed {seed}: {triangle:?} {voxel:?}");
        met += i32::from(truth);
    }
    assert!((2000..18_000).contains(&met), "{met} of 20000 met: the cases are not about anything");
}

#[test]
fn every_point_of_a_triangle_lies_in_its_cover() {
    for seed in 0..200 {
        let mut rng = Rng::new(seed);
        let triangle: Triangle = [(); 3].map(|()| [(); 3].map(|()| rng.below(8 * 256) as i64));
        let cover = clip::cover(&[triangle], 3, Cell::HalfOpen);
        let closed = clip::cover(&[triangle], 3, Cell::Closed);
        let inflated = clip::cover(&[triangle], 3, Cell::Inflated);
        assert!(cover.is_subset(&closed) && closed.is_subset(&inflated), "seed {seed}");
        assert!(thin::cover(&[triangle], 3).is_subset(&cover), "seed {seed}");
        for _ in 0..200 {
            let [u, v] = [(); 2].map(|()| rng.between(0, 64));
            let [u, v] = if u + v > 64 { [64 - u, 64 - v] } else { [u, v] };
            let w = 64 - u - v;
            let voxel: [u32; 3] = core::array::from_fn(|i| {
                let x = u * triangle[0][i] + v * triangle[1][i] + w * triangle[2][i];
                (x / (64 * 256)) as u32
            });
            assert!(cover.contains(&voxel), "seed {seed}: {voxel:?}");
        }
    }
}

#[test]
fn inflated_voxels_hold_what_rounding_moved_away() {
    // Move each corner by up to half a unit in each axis: the closed voxels met then are inflated voxels met now.
    for seed in 0..2000 {
        let mut rng = Rng::new(seed);
        let triangle: Triangle = [(); 3].map(|()| [(); 3].map(|()| 64 * rng.below(17) as i64));
        let moved = triangle.map(|p| p.map(|x| 2 * x + rng.between(-1, 1)));
        let voxel = [(); 3].map(|()| rng.below(4) as i64);
        let doubled = Aabb { lo: voxel.map(|k| 512 * k), hi: voxel.map(|k| 512 * (k + 1)), open: [false; 3] };
        if clip::meets(&moved, &doubled) {
            assert!(clip::meets_voxel(&triangle, voxel, Cell::Inflated), "seed {seed}");
        }
    }
    // And no more than half a unit: a point one unit below a voxel is not in it.
    assert!(!clip::meets_voxel(&[[255; 3]; 3], [1, 1, 1], Cell::Inflated));
    assert!(
        clip::meets_voxel(&[[256; 3]; 3], [0, 0, 0], Cell::Inflated)
            && !clip::meets_voxel(&[[257; 3]; 3], [0; 3], Cell::Inflated)
    );
}

#[test]
fn a_digital_plane_has_as_many_voxels_as_the_closed_form_says() {
    // The plane x + y + z = c over the corner: voxel (i, j, k) is met if c - 3 < i + j + k <= c; there are (s+1)(s+2)/2
    // voxels of sum s. Closed voxels: c - 3 too. Crosshairs: only c - 1.
    let with_sum = |s: i64| if s < 0 { 0 } else { (s + 1) * (s + 2) / 2 };
    for c in [1, 2, 3, 7, 8, 15] {
        let plane = [whole([[c, 0, 0], [0, c, 0], [0, 0, c]])];
        let half_open = clip::cover(&plane, 4, Cell::HalfOpen);
        let sums = with_sum(c) + with_sum(c - 1) + with_sum(c - 2);
        assert_eq!(half_open.len() as i64, sums);
        assert_eq!(sums, (3 * c * c + 3 * c + 2) / 2);
        assert_eq!(clip::cover(&plane, 4, Cell::Closed).len() as i64, sums + with_sum(c - 3));
        let thin = thin::cover(&plane, 4);
        assert_eq!(thin.len() as i64, with_sum(c - 1));
        assert!(thin.iter().all(|v| i64::from(v.iter().sum::<u32>()) == c - 1));
    }
}

#[test]
fn thin_covers_of_voxel_planes() {
    // A square in the plane between two layers belongs to the upper one; in the middle of a layer to that layer.
    for (z, layer) in [(4 * SUB, 4), (4 * SUB + 128, 4), (4 * SUB - 1, 3)] {
        let square = |a: i64, b: i64| -> [Triangle; 2] {
            let p = |x: i64, y: i64| [x, y, z];
            [[p(a, a), p(b, a), p(b, b)], [p(a, a), p(b, b), p(a, b)]]
        };
        let thin = thin::cover(&square(0, 8 * SUB - 1), 3);
        assert_eq!(thin.len(), 64);
        assert!(thin.iter().all(|v| v[2] == layer));
        // Smaller than the crosshairs' distance: nothing is hit, unless the square lies in a crosshair's plane.
        let small = thin::cover(&square(10, 20), 3);
        assert_eq!(small.len(), 0);
    }
}

#[test]
fn published_overlaps() {
    // Scaled by powers of ten, so that the published decimals are integers. CGAL issue 6808 (3 of 13 axes missing):
    let cgal: Triangle =
        [[-3_411_280, -400_842, 3_950_610], [-3_609_380, -366_150, 3_687_000], [-3_457_810, -361_804, 3_997_160]];
    let aabb = Aabb { lo: [-5_235_860, -1_433_760, 2_530_370], hi: [-3_802_100, 0, 3_964_140], open: [false; 3] };
    assert!(!clip::meets(&cgal, &aabb));
    // MathGeoLib issue 51: a triangle inside the box and parallel to its faces.
    let inside: Triangle = [[0, 0, 0], [1, 0, 0], [0, 1, 0]];
    assert!(clip::meets(&inside, &Aabb { lo: [-2; 3], hi: [2; 3], open: [false; 3] }));
    assert!(clip::meets(&inside, &Aabb { lo: [-2; 3], hi: [2; 3], open: [true; 3] }));
    // Open3D issue 6111: a face's interior counts, not its edges alone. No edge comes near voxel (2, 2, 2).
    let face = whole([[-9, -9, 2], [30, -9, 2], [-9, 30, 2]]);
    assert!(clip::meets_voxel(&face, [2, 2, 2], Cell::HalfOpen));
    assert!(!clip::meets_voxel(&face, [2, 2, 1], Cell::HalfOpen) && clip::meets_voxel(&face, [2, 2, 1], Cell::Closed));
}

#[test]
fn half_open_needs_one_point_off_all_upper_faces() {
    // Touching a voxel in its upper corner, upper edge or upper face only is not meeting it; in a lower one it is.
    for octant in 0..8 {
        let corner: [i64; 3] = core::array::from_fn(|i| SUB * (4 + (octant >> i & 1)));
        let away: [i64; 3] = core::array::from_fn(|i| SUB * if octant >> i & 1 == 1 { 6 } else { 3 });
        let touching: Triangle = [corner, away, core::array::from_fn(|i| if i == 0 { away[0] } else { corner[i] })];
        let upper = (0..3).any(|i| octant >> i & 1 == 1);
        assert_eq!(clip::meets_voxel(&touching, [4; 3], Cell::HalfOpen), !upper, "octant {octant}");
        assert!(clip::meets_voxel(&touching, [4; 3], Cell::Closed), "octant {octant}");
    }
}

// --- octrees ---

#[test]
fn interleaving_is_the_morton_code() {
    let mut rng = Rng::new(5);
    for _ in 0..20_000 {
        let v = [(); 3].map(|()| rng.below(1 << 21) as u32);
        let code = octree::interleave(v);
        assert_eq!(Morton::encode(v), Some(Morton(code)));
        assert_eq!((octree::deinterleave(code), Morton(code).decode()), (v, v));
    }
    assert_eq!(octree::interleave([1 << 20, 0, 0]), 1 << 60);
    assert_eq!(octree::interleave([0, 1, 2]), 2 | 32);
}

#[test]
fn the_two_naive_builders_write_the_same_words_and_the_view_accepts_them() {
    for depth in 0..=6u8 {
        let n = 1i64 << depth;
        let shapes = [
            Implicit::Shell { centre: [n; 3], inner: (n - 2).max(0), outer: n },
            Implicit::Wall { axis: 2, lo: n / 2, hi: n / 2 + 2 },
            Implicit::Diagonal { lo: n, hi: n + 3 },
            Implicit::Dust { at: [1, 2, 0] },
            Implicit::Wall { axis: 0, lo: 0, hi: n },
            Implicit::Wall { axis: 0, lo: n, hi: n },
        ];
        for shape in shapes {
            let set = VoxelSet::new(shape.voxels(depth));
            let words = set.words(depth);
            assert_eq!(words, shape.words(depth), "{shape:?} at depth {depth}");
            let dag = Dag::new(&words).unwrap();
            assert_eq!(dag.depth(), depth);
            assert!(dag.voxels().map(|m| m.0).eq(set.codes().iter().copied()), "{shape:?} at depth {depth}");
            assert!(dag.bricks().map(|(m, mask)| (m.0, mask)).eq(set.bricks()));
            assert_eq!(octree::count_voxels(&words), set.codes().len().into());
            let stats = dag.stats().unwrap();
            assert_eq!(stats.voxels, set.codes().len() as u64);
            for level in 2..=depth {
                let (unique, all) = set.level_counts(level);
                let counted = stats.levels[usize::from(level)];
                assert_eq!((counted.unique, counted.octree), (unique as u64, all as u64), "level {level}");
            }
        }
    }
}

#[test]
fn voxel_sets_answer_for_cubes() {
    let mut rng = Rng::new(6);
    let voxels: Vec<[u32; 3]> = (0..300).map(|_| [(); 3].map(|()| rng.below(16) as u32)).collect();
    let set = VoxelSet::new(voxels.iter().copied());
    for level in 0..=4u8 {
        for i in 0..4096u32 {
            let corner = [i & 15, i >> 4 & 15, i >> 8].map(|k| k >> level << level);
            let holds = voxels.iter().any(|v| (0..3).all(|i| v[i] >> level == corner[i] >> level));
            assert_eq!(set.any(level, corner), holds);
        }
    }
}

// --- tables, scenes, textbook ---

#[test]
fn key_families_are_as_bad_as_they_should_be() {
    let mut rng = Rng::new(8);
    for _ in 0..10_000 {
        let key = rng.bits();
        assert_eq!((table::splitmix(table::unsplitmix(key)), table::unsplitmix(table::splitmix(key))), (key, key));
    }
    let families: BTreeMap<&str, Vec<u64>> = table::families().into_iter().collect();
    for (name, keys) in &families {
        let distinct: std::collections::BTreeSet<_> = keys.iter().collect();
        assert_eq!(distinct.len(), keys.len(), "{name}");
        assert!(keys.iter().all(|k| k >> 63 == 0), "{name}");
        assert!(keys.len() == 2 || keys.len() > 5000, "{name}: {}", keys.len());
    }
    // The table of hard-cases, section 7: identity on a plane is linear, the finaliser is not.
    let slots = 1 << 17;
    let identity = table::probes(&families["plane z = 777"], slots, |k| k as usize);
    let mixed = table::probes(&families["plane z = 777"], slots, |k| table::splitmix(k) as usize);
    assert!(identity.0 > 1000.0 && identity.1 > 3000, "{identity:?}");
    assert!(mixed.0 < 2.0 && mixed.1 < 64, "{mixed:?}");
    // And the inverse-constructed family breaks the finaliser, as an unseeded hash must be broken.
    let flooded = table::probes(&families["against splitmix, low bits"], slots, |k| table::splitmix(k) as usize);
    assert!(flooded.0 > 1000.0, "{flooded:?}");
}

#[test]
fn closed_scenes_are_closed_and_face_outwards() {
    let closed: [(&str, Shape); 3] = [
        ("cuboid", scenes::cuboid([1.0, 2.0, 3.0], [4.0, 6.0, 8.0])),
        ("sphere", scenes::sphere([8.0; 3], 5.0, 3)),
        ("torus", scenes::torus([8.0; 3], 5.0, 2.0, 24, 12)),
    ];
    for (name, shape) in &closed {
        // Every directed edge has its opposite, once.
        let mut edges = BTreeMap::new();
        for &[a, b, c] in &shape.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)), "{name}");
        // Signed volume: positive if the faces look outwards.
        let volume: f64 = shape
            .corners()
            .map(|[a, b, c]| {
                let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
                (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
            })
            .sum();
        assert!(volume > 10.0, "{name}: {volume}");
    }
}

#[test]
fn a_closed_surface_separates_inside_from_outside() {
    // The exact and the thin cover of a closed mesh stop every walk over faces of voxels.
    for (name, shape) in
        [("sphere", scenes::sphere([8.0; 3], 6.3, 2)), ("torus", scenes::torus([8.0; 3], 5.0, 2.0, 9, 7))]
    {
        let inside = if name == "sphere" { [8, 8, 8] } else { [13, 8, 8] };
        let triangles = shape.snapped([0.0; 3], 1.0, 16);
        for cover in [clip::cover(&triangles, 4, Cell::HalfOpen), thin::cover(&triangles, 4)] {
            let mut seen = std::collections::BTreeSet::from([inside]);
            let mut open = vec![inside];
            assert!(!cover.contains(&inside), "{name}");
            while let Some(v) = open.pop() {
                for axis in 0..3 {
                    for step in [-1i32, 1] {
                        let mut w = v;
                        w[axis] = w[axis].wrapping_add_signed(step);
                        assert!(w[axis] < 16, "{name} leaks through {v:?}");
                        if !cover.contains(&w) && seen.insert(w) {
                            open.push(w);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn textbook_methods_are_right_where_nothing_is_tight() {
    let shape = Implicit::Shell { centre: [64; 3], inner: 50, outer: 56 };
    let mut wrong = 0;
    for seed in 0..2000 {
        let mut rng = Rng::new(seed);
        let origin = [(); 3].map(|()| rng.uniform(-20.0, 84.0) as f32);
        let dir = rng.direction().map(|d| d as f32);
        let truth = ray::first(&Ray::new(origin.map(f64::from), dir.map(f64::from)), 6, 0, &|h, c| shape.any(h, c));
        let float = textbook::dda_f32(origin, dir, 6, |v| shape.filled(v));
        wrong += usize::from(truth.map(|t| t.voxel) != float);
    }
    assert!(wrong < 20, "{wrong} of 2000 rays");
    let mut wrong = 0;
    for seed in 0..4000 {
        let mut rng = Rng::new(seed);
        let triangle: Triangle = [(); 3].map(|()| [(); 3].map(|()| rng.below(1024) as i64));
        let voxel = [(); 3].map(|()| rng.below(4) as i64);
        let float = triangle.map(|p| p.map(|x| x as f32 / 256.0));
        let truth = clip::meets_voxel(&triangle, voxel, Cell::Closed);
        wrong += usize::from(truth != textbook::schwarz_seidel(float, voxel.map(|k| k as f32), [1.0; 3]));
    }
    assert!(wrong < 8, "{wrong} of 4000 triangles");
}
