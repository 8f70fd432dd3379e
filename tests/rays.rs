//! The tracer against the exact ray oracle, row by row of the catalogue (hard-cases, section 4): equality, not tolerance.
//!
//! Not here: R8's cost of garbage (a bounded walk is tested instead), R18 (leaks: tests/selftest.rs, which shares them with
//! `voxdag selftest`) and the symmetries of the cube (tests/symmetry.rs).

use std::time::{Duration, Instant};

use voxdag::simd::Level;
use voxdag::trace::{Arithmetic, Face, Hit, Query, Top, TopBuf, Tracer};
use voxdag::wide::{Wide, WideBuf};
use voxdag::{Dag, Geometry, Morton};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::ray::{self, Ray, Truth};
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::Implicit;

/// What rays are shot at: a DAG's words, and the same shape in the oracle's terms.
struct Scene {
    name: String,
    depth: u8,
    words: Vec<u32>,
    shape: Filled,
    /// Filled voxels to aim at.
    targets: Vec<[u32; 3]>,
    /// Top grids of the DAG, from one cell to as many as are reasonable.
    tops: Vec<TopBuf>,
    /// The same voxels as a wide tree, and a top grid of it, for packets.
    wide: WideBuf,
    wide_top: TopBuf,
}

enum Filled {
    Implicit(Implicit),
    Set(VoxelSet),
}

impl Scene {
    fn of_set(name: &str, depth: u8, set: VoxelSet) -> Scene {
        let targets = set.codes().iter().map(|&c| Morton(c).decode()).collect();
        let words = set.words(depth);
        Scene::new(format!("{name} at depth {depth}"), depth, words, Filled::Set(set), targets)
    }

    fn of_implicit(name: &str, depth: u8, shape: Implicit, seed: u64) -> Scene {
        // Rays of the oracle find voxels to aim at.
        let mut rng = Rng::new(seed);
        let n = f64::from(1u32 << depth);
        let mut targets = Vec::new();
        while targets.len() < 40 {
            let ray = Ray::new([(); 3].map(|()| rng.uniform(0.0, n)), rng.direction());
            targets.extend(ray::first(&ray, depth, 0, &|h, c| shape.any(h, c)).map(|t| t.voxel));
        }
        let words = shape.words(depth);
        Scene::new(format!("{name} at depth {depth}"), depth, words, Filled::Implicit(shape), targets)
    }

    fn new(name: String, depth: u8, words: Vec<u32>, shape: Filled, targets: Vec<[u32; 3]>) -> Scene {
        let dag = Dag::new(&words).expect("the twin's words are good");
        let tops = [0, 1, 3, 4].map(|bits| TopBuf::new(&dag, bits).unwrap()).into();
        let wide = WideBuf::new(&dag, usize::MAX).unwrap();
        let bits = Top::bits_for_packets(&dag, 2 + depth % 3);
        let wide_top = TopBuf::new(&wide.as_wide(), bits).unwrap();
        Scene { name, depth, words, shape, targets, tops, wide, wide_top }
    }

    fn dag(&self) -> Dag<'_> {
        Dag::new(&self.words).expect("the twin's words are good")
    }

    fn tracers(&self) -> impl Iterator<Item = Tracer<'_>> {
        self.tops.iter().map(|top| Tracer::with_top(self.dag(), top.as_top()).expect("the grid is this DAG's"))
    }

    /// A tracer of packets at each level that this machine has.
    fn packets(&self) -> impl Iterator<Item = Tracer<'_, Wide<'_>>> {
        let tracer = Tracer::with_top(self.wide.as_wide(), self.wide_top.as_top()).expect("the grid is this tree's");
        Level::all().map(move |level| {
            let tracer = tracer.with_level(Some(level));
            assert!(tracer.packet_level().is_some() || self.wide.as_wide().is_empty());
            tracer
        })
    }

    fn any(&self, level: u8, corner: [u32; 3]) -> bool {
        match &self.shape {
            Filled::Implicit(shape) => shape.any(level, corner),
            Filled::Set(set) => set.any(level, corner),
        }
    }

    fn truth(&self, ray: &Ray, level: u8) -> Option<Truth> {
        ray::first(ray, self.depth, level, &|h, c| self.any(h, c))
    }
}

/// Walls, diagonal walls, dust, a piece of a shell, and a cloud of single voxels.
fn all_scenes(depth: u8) -> Vec<Scene> {
    let n = 1i64 << depth;
    let mut rng = Rng::new(u64::from(depth));
    let cloud = VoxelSet::new((0..(4 * n * n).min(3000)).map(|_| [(); 3].map(|()| rng.below(n as u64) as u32)));
    // A piece of a sphere's shell of half the cube's size, around its point nearest to a corner.
    let shell = Implicit::Shell { centre: [n; 3], inner: n - 3, outer: n };
    let at = (n as f64 * 0.5 * (1.0 - 1.0 / 3f64.sqrt())) as i64;
    let (lo, hi) = ((at - 16).max(0), (at + 16).min(n));
    let mut piece = Vec::new();
    for i in 0..(hi - lo).pow(3) {
        let w = hi - lo;
        let v = [i % w, i / w % w, i / w / w].map(|k| (k + lo) as u32);
        if shell.filled(v) {
            piece.push(v);
        }
    }
    vec![
        Scene::of_set("cloud", depth, cloud),
        Scene::of_set("piece of a shell", depth, VoxelSet::new(piece)),
        Scene::of_implicit("wall", depth, Implicit::Wall { axis: 1, lo: n / 3, hi: n / 3 + 1 }, 1),
        Scene::of_implicit("diagonal wall", depth, Implicit::Diagonal { lo: n, hi: n + 3 }, 2),
        Scene::of_implicit("thin diagonal wall", depth, Implicit::Diagonal { lo: n + 1, hi: n + 2 }, 3),
        Scene::of_implicit("dust", depth, Implicit::Dust { at: [1, 3, 0] }, 4),
    ]
}

fn query(ray: &Ray) -> Query {
    Query { t_min: ray.t_min, t_max: ray.t_max, ..Query::new(ray.origin, ray.dir) }
}

/// Steps between two floats of one sign.
fn ulps(a: f64, b: f64) -> u64 {
    if a == b {
        return 0;
    }
    if (a < 0.0) != (b < 0.0) {
        return u64::MAX;
    }
    a.to_bits().abs_diff(b.to_bits())
}

/// The tracer says what is true: voxel, time, face, and the voxel before.
fn same(found: Option<Hit>, truth: Option<Truth>, what: &dyn Fn() -> String) {
    match (&found, &truth) {
        (None, None) => {}
        (Some(hit), Some(truth)) => {
            let what = || format!("{}\nfound {hit:?}\ntruth {truth:?}", what());
            assert_eq!(hit.voxel.decode(), truth.voxel, "voxel: {}", what());
            assert_eq!(hit.face, truth.face, "face: {}", what());
            assert_eq!(hit.from.map(Morton::decode), truth.from, "from: {}", what());
            assert!(ulps(hit.t, truth.t) <= 1, "t: {}", what());
        }
        _ => panic!("{}\nfound {found:?}\ntruth {truth:?}", what()),
    }
}

fn check(scene: &Scene, ray: &Ray) -> Option<Truth> {
    let truth = scene.truth(ray, 0);
    let what = || format!("{}, {ray:?}", scene.name);
    same(scene.dag().trace(&query(ray)), truth.clone(), &what);
    assert_eq!(scene.dag().occluded(&query(ray)), truth.is_some(), "occluded: {}", what());
    // A top grid changes no answer.
    for tracer in scene.tracers() {
        same(tracer.trace(Arithmetic::Exact, &query(ray)), truth.clone(), &what);
        assert_eq!(tracer.occluded(Arithmetic::Exact, &query(ray)), truth.is_some(), "occluded: {}", what());
    }
    // Neither do packets, at any level; the last one also walks it one by one.
    for tracer in scene.packets() {
        let (mut hit, mut blocked) = ([None], [false]);
        tracer.trace_many(Arithmetic::Exact, &[query(ray)], &mut hit);
        assert_eq!(hit[0], scene.dag().trace(&query(ray)), "{:?}: {}", tracer.packet_level(), what());
        tracer.occluded_many(Arithmetic::Exact, &[query(ray)], &mut blocked);
        assert_eq!(blocked[0], truth.is_some(), "occluded, {:?}: {}", tracer.packet_level(), what());
    }
    truth
}

/// A ray of one of the classes; most of them are aimed at something.
///
/// In large implicit scenes the oracle looks at every cube near a wall or between grains of dust: there the part of the
/// ray that counts ends 500 voxels from the target, and starts there too where the ray might run along a wall for ever.
fn draw(class: u32, scene: &Scene, rng: &mut Rng) -> Ray {
    let target = rng.pick(&scene.targets);
    let mut ray = draw_at(class, target, scene, rng);
    if scene.depth > 10 && matches!(scene.shape, Filled::Implicit(_)) {
        let axis = (0..3).max_by(|&a, &b| ray.dir[a].abs().total_cmp(&ray.dir[b].abs())).unwrap();
        let [near, far] = [-500.0, 500.0].map(|around: f64| {
            (f64::from(target[axis]) + around * ray.dir[axis].signum() - ray.origin[axis]) / ray.dir[axis]
        });
        ray.t_max = far;
        if class >= 3 {
            ray.t_min = near.max(0.0);
        }
    }
    ray
}

fn draw_at(class: u32, target: [u32; 3], scene: &Scene, rng: &mut Rng) -> Ray {
    let n = f64::from(1u32 << scene.depth);
    let target = target.map(f64::from);
    let inside = target.map(|k| k + rng.unit());
    let corner = target.map(|k| k + rng.below(2) as f64);
    let toward = |origin: [f64; 3], p: [f64; 3]| -> [f64; 3] { core::array::from_fn(|i| p[i] - origin[i]) };
    let signs = [(); 3].map(|()| rng.pick(&[-1.0, 1.0]));
    match class {
        // From around and within the cube, at nothing.
        0 => Ray::new([(); 3].map(|()| rng.uniform(-0.5 * n, 1.5 * n)), rng.direction()),
        // Near a target, at it.
        1 => {
            let origin = inside.map(|x| x + rng.uniform(-20.0, 20.0));
            Ray::new(origin, toward(origin, inside))
        }
        // From one thousand and one million scene sizes away.
        2 => {
            let far = rng.pick(&[1e3, 1e6]) * n;
            let d = rng.direction();
            let origin = core::array::from_fn(|i| inside[i] - far * d[i]);
            Ray::new(origin, toward(origin, inside))
        }
        // Along an axis, from lattice points and halves.
        3 => {
            let axis = rng.below(3) as usize;
            let mut origin = target.map(|k| k + rng.pick(&[0.0, 0.5, 1.0]));
            origin[axis] = rng.pick(&[-3.0, n + 2.0, 0.0, n, target[axis], target[axis] + 5.0]);
            let mut dir = [0.0, -0.0, 0.0];
            dir[axis] = signs[axis];
            Ray::new(origin, dir)
        }
        // Exactly through corners, along diagonals.
        4 => {
            let steps = rng.below(40) as f64;
            Ray::new(core::array::from_fn(|i| corner[i] - steps * signs[i]), signs)
        }
        // In a plane between voxels.
        5 => {
            let axis = rng.below(3) as usize;
            let mut dir = rng.direction();
            dir[axis] = 0.0;
            let mut origin: [f64; 3] = core::array::from_fn(|i| inside[i] - 10.0 * dir[i]);
            origin[axis] = corner[axis];
            Ray::new(origin, dir)
        }
        // Small integers: ties of two and three axes at any slope.
        6 => {
            let dir = loop {
                let d = [(); 3].map(|()| rng.between(-4, 4) as f64);
                if d != [0.0; 3] {
                    break d;
                }
            };
            let steps = rng.below(8) as f64;
            Ray::new(core::array::from_fn(|i| corner[i] - steps * dir[i]), dir)
        }
        // Components of any magnitude.
        7 => {
            let mut ray = draw_at(rng.below(7) as u32, target.map(|k| k as u32), scene, rng);
            let axis = rng.below(3) as usize;
            ray.dir[axis] = rng.pick(&[1e-300, -1e-300, 5e-324, -3e-310, 1e-40, -1e-17]);
            if rng.below(2) == 0 {
                ray.dir = ray.dir.map(|d| d * rng.pick(&[1.0, 1e-290, 1e200]));
            }
            ray
        }
        // Magnitudes spread over all exponents.
        _ => {
            let d = [(); 3].map(|()| rng.spread(-60, 60));
            let length = rng.spread(-30, 30).abs();
            Ray::new(core::array::from_fn(|i| inside[i] - d[i] * length), d)
        }
    }
}

const CLASSES: u32 = 9;

#[test]
fn r00_equality_with_the_oracle_at_every_depth() {
    for depth in [3, 10, 16, 21] {
        for scene in all_scenes(depth) {
            let mut hits = 0;
            for class in 0..CLASSES {
                for seed in 0..40 {
                    let mut rng = Rng::new(seed * 100 + u64::from(class));
                    hits += i32::from(check(&scene, &draw(class, &scene, &mut rng)).is_some());
                }
            }
            // Random rays find little in a cloud of a large cube; aimed ones find their target.
            assert!(hits > 130, "{}: {hits} hits are too few to say anything", scene.name);
        }
    }
}

#[test]
fn r00_small_cubes_and_full_and_empty_ones() {
    for depth in 0..=4u8 {
        let n = 1u32 << depth;
        let full = VoxelSet::new((0..n * n * n).map(|i| [i % n, i / n % n, i / n / n]));
        let mut rng = Rng::new(u64::from(depth));
        let some = VoxelSet::new((0..1 + n * n).map(|_| [(); 3].map(|()| rng.below(u64::from(n)) as u32)));
        for set in [full, some] {
            let scene = Scene::of_set("small", depth, set);
            for seed in 0..600 {
                check(&scene, &draw(seed as u32 % CLASSES, &scene, &mut Rng::new(seed)));
            }
        }
        let empty = VoxelSet::default().words(depth);
        assert_eq!(Dag::new(&empty).unwrap().trace(&Query::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0])), None);
    }
}

/// A third of the voxels of an 8^3 cube.
fn eighth(seed: u64) -> Scene {
    let mut rng = Rng::new(seed);
    let voxels = (0..512u32).filter(|_| rng.below(12) == 0).map(|i| [i & 7, i >> 3 & 7, i >> 6]);
    Scene::of_set("random", 3, VoxelSet::new(voxels.collect::<Vec<_>>()))
}

/// The same in the far corner of a cube of another depth.
fn eighth_in(seed: u64, depth: u8) -> (Scene, f64) {
    let first = (1u32 << depth) - 8;
    let small = eighth(seed);
    let voxels = small.targets.iter().map(|v| v.map(|k| k + first));
    (Scene::of_set("random, far corner", depth, VoxelSet::new(voxels)), f64::from(first))
}

/// The depths at which the rows are tried, and every how manieth of the rays of 8^3: the oracle's numbers grow.
const DEPTHS: [(u8, usize); 4] = [(3, 1), (10, 7), (16, 11), (21, 11)];

fn lattice() -> impl Iterator<Item = [f64; 3]> {
    (0..9 * 9 * 9).map(|i| [i % 9, i / 9 % 9, i / 81].map(f64::from))
}

#[test]
fn r01_axis_rays_from_every_lattice_point() {
    for (depth, step) in DEPTHS {
        let (scene, first) = eighth_in(1, depth);
        for origin in lattice().step_by(step).map(|p| p.map(|x| x + first)) {
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    let mut dir = [0.0; 3];
                    dir[axis] = sign;
                    check(&scene, &Ray::new(origin, dir));
                    // And from outside, along the same line.
                    let mut outside = origin;
                    outside[axis] -= 20.0 * sign;
                    check(&scene, &Ray::new(outside, dir));
                }
            }
        }
    }
}

#[test]
fn r00_times_are_the_nearest_floats() {
    // One unit in the last place is what is promised; with the remainder of the division put back it is hardly ever used.
    let scene = eighth(3);
    let (mut hits, mut nearest) = (0, 0);
    for seed in 0..1500 {
        let mut rng = Rng::new(seed);
        let ray = draw(1, &scene, &mut rng);
        if let (Some(hit), Some(truth)) = (scene.dag().trace(&query(&ray)), scene.truth(&ray, 0)) {
            hits += 1;
            nearest += i32::from(hit.t == truth.t);
        }
    }
    assert!(hits > 1000 && hits - nearest <= hits / 200, "{nearest} of {hits}");
}

#[test]
fn r02_the_sign_of_zero_does_not_matter() {
    for (depth, step) in DEPTHS {
        let scene = eighth_in(2, depth).0;
        for seed in (0..2000).step_by(step) {
            let mut rng = Rng::new(seed);
            let mut ray = draw(rng.pick(&[3, 5, 6]), &scene, &mut rng);
            let axis = rng.below(3) as usize;
            if rng.below(2) == 0 {
                ray.origin[axis] = 0.0;
            }
            let negate = |x: f64| if x == 0.0 { -x } else { x };
            let negated = Query { t_min: -0.0, ..Query::new(ray.origin.map(negate), ray.dir.map(negate)) };
            assert_eq!(scene.dag().trace(&query(&ray)), scene.dag().trace(&negated), "2^{depth}, seed {seed}: {ray:?}");
        }
    }
}

#[test]
fn r03_through_edges_and_corners() {
    for (depth, step) in DEPTHS {
        let (scene, first) = eighth_in(3, depth);
        for origin in lattice().step_by(step) {
            for k in 0..125 {
                let dir = [k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2].map(f64::from);
                if dir != [0.0; 3] && origin.iter().sum::<f64>() % 3.0 == f64::from(k % 3) {
                    check(&scene, &Ray::new(origin.map(|x| x + first), dir));
                }
            }
        }
    }
}

#[test]
fn r04_within_face_planes() {
    for (depth, step) in DEPTHS {
        for seed in (0..40).step_by(step) {
            let (scene, first) = eighth_in(seed, depth);
            let mut rng = Rng::new(seed);
            for axis in 0..3 {
                for plane in 0..=8 {
                    let mut origin = [(); 3].map(|()| first + rng.uniform(-1.0, 9.0));
                    let mut dir = rng.direction();
                    origin[axis] = first + f64::from(plane);
                    dir[axis] = 0.0;
                    check(&scene, &Ray::new(origin, dir));
                    // Also along the lattice's lines in it.
                    check(&scene, &Ray::new(origin.map(f64::round), dir.map(f64::round).map(|d| d + 0.0)));
                }
            }
        }
    }
}

#[test]
fn r05_origins_in_27_positions_of_a_voxel() {
    for (depth, step) in DEPTHS {
        let first = (1 << depth) - 8;
        let scene = Scene::of_set("one voxel", depth, VoxelSet::new([[3, 4, 5].map(|k| k + first)]));
        for place in 0..27 {
            let at = |i: usize| [0.0, 0.5, 1.0][place / 3usize.pow(i as u32) % 3];
            let origin = [3.0 + at(0), 4.0 + at(1), 5.0 + at(2)].map(|x| x + f64::from(first));
            for k in (0..125).step_by(step) {
                let dir = [k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2].map(f64::from);
                if dir == [0.0; 3] {
                    continue;
                }
                for t_min in [0.0, -1.0, 0.25] {
                    let truth = check(&scene, &Ray { t_min, ..Ray::new(origin, dir) });
                    if t_min == 0.0 && (0..3).all(|i| at(i) < 1.0) {
                        let truth = truth.expect("the origin is inside");
                        assert_eq!((truth.t, truth.face, truth.from), (0.0, Face::Inside, None));
                    }
                }
            }
        }
    }
}

#[test]
fn r06_far_origins_are_as_good_as_near_ones() {
    // Through a wall, from up to 2^40 scenes away: never a leak.
    for (depth, step) in DEPTHS {
        let n = 1i64 << depth;
        for shape in [
            Implicit::Wall { axis: 0, lo: n / 2, hi: n / 2 + 1 },
            Implicit::Diagonal { lo: 3 * n / 2, hi: 3 * n / 2 + 3 },
        ] {
            let scene = Scene::of_implicit("wall", depth, shape, 6);
            let n = n as f64;
            for seed in (0..300).step_by(1 + step / 7) {
                let mut rng = Rng::new(seed);
                let p = [(); 3].map(|()| rng.uniform(0.01 * n, 0.99 * n));
                let away = rng.pick(&[1e3, 1e6, 1e12]) * n;
                let d = rng.direction();
                let origin = core::array::from_fn(|i| p[i] - away * d[i]);
                check(&scene, &Ray::new(origin, core::array::from_fn(|i| p[i] - origin[i])));
            }
        }
    }
}

#[test]
fn r07_tiny_and_subnormal_components_count() {
    for (depth, _) in DEPTHS {
        let scene = Scene::of_implicit("wall", depth, Implicit::Wall { axis: 2, lo: 7, hi: 8 }, 7);
        for tiny in [1e-300, 5e-324, 1e-40] {
            // After 1e300 units of time a component of 1e-300 has moved the ray by a voxel: it must not be dropped.
            let ray = Ray::new([4.5, 4.5, 6.5], [0.0, tiny, tiny]);
            let truth = check(&scene, &ray).expect("it reaches the wall in the end");
            assert_eq!(truth.voxel, [4, 5, 7]);
            // Both planes are crossed at once, and no axis is steeper.
            assert_eq!(truth.face, Face::NegY);
            // Along the wall for a while: the oracle looks at every voxel there.
            check(&scene, &Ray { t_max: 600.0, ..Ray::new([4.5, 4.5, 6.5], [0.0, 1.0, tiny]) });
            check(&scene, &Ray::new([4.5, 4.5, 8.0], [tiny, 0.0, -tiny]));
        }
        for seed in 0..100 {
            let mut rng = Rng::new(seed);
            check(&scene, &draw(7, &scene, &mut rng));
        }
    }
}

#[test]
fn r08_numbers_that_are_none_miss_also_where_nothing_moves() {
    let mut builder = voxdag::build::DagBuilder::new(3).unwrap();
    builder.push(Morton::encode([4, 0, 0]).unwrap(), 1 << 9 | 1).unwrap();
    let built = builder.finish().unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let query = Query { start: Some(Morton(0)), ..Query::new([0.5, bad, 0.5], [1.0, 0.0, 0.0]) };
        assert_eq!(built.dag().trace(&query), None);
        assert!(built.dag().trace(&Query { origin: [0.5; 3], ..query }).is_some());
    }
    // A start far off the line ends, and overflows nothing.
    for y in [-2147483648.0 - 3.5, 2147483647.0 + 0.5, 4294967296.0] {
        let query = Query { start: Some(Morton(0)), ..Query::new([0.5, y, 0.5], [1.0, 1.0, 0.0]) };
        let _ = (built.dag().trace(&query), built.dag().trace(&Query { dir: [1.0, -1.0, 0.0], ..query }));
    }
}

#[test]
fn r08_what_is_no_ray_misses_in_no_time() {
    let scene = eighth(8);
    let dag = scene.dag();
    let good = Query::new([-1.0, 4.5, 4.5], [1.0, 0.01, 0.02]);
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let miss = |q: Query| {
        for arithmetic in [Arithmetic::Exact, Arithmetic::F64] {
            assert_eq!(dag.trace_with(arithmetic, &q), None, "{q:?}");
        }
        assert!(!dag.occluded(&q), "{q:?}");
    };
    for x in bad {
        for axis in 0..3 {
            let mut q = good;
            q.origin[axis] = x;
            miss(q);
            let mut q = good;
            q.dir[axis] = x;
            miss(q);
        }
    }
    miss(Query { dir: [0.0; 3], ..good });
    miss(Query { dir: [0.0, -0.0, 0.0], ..good });
    miss(Query { t_min: f64::NAN, ..good });
    miss(Query { t_max: f64::NAN, ..good });
    miss(Query { t_min: f64::INFINITY, ..good });
    miss(Query { t_max: f64::NEG_INFINITY, ..good });
    miss(Query { t_min: 2.0, t_max: 2.0, ..good });

    // Any bits at all: an answer that the oracle agrees with, soon.
    let start = Instant::now();
    for seed in 0..10_000 {
        let mut rng = Rng::new(seed);
        let wild = |rng: &mut Rng| match rng.below(5) {
            0 => f64::from_bits(rng.bits()),
            1 => rng.spread(-1074, 1020),
            2 => rng.between(-9, 9) as f64,
            _ => rng.uniform(-10.0, 10.0),
        };
        let ray = Ray {
            origin: [(); 3].map(|()| wild(&mut rng)),
            dir: [(); 3].map(|()| wild(&mut rng)),
            t_min: if rng.below(2) == 0 { 0.0 } else { wild(&mut rng) },
            t_max: if rng.below(2) == 0 { f64::INFINITY } else { wild(&mut rng) },
        };
        let q = Query { min_level: rng.below(25) as u8, ..query(&ray) };
        dag.trace_with(Arithmetic::F64, &q);
        dag.trace(&Query { start: Some(Morton(rng.bits() >> rng.below(64))), ..q });
        check(&scene, &ray);
    }
    assert!(start.elapsed() < Duration::from_secs(60));
}

#[test]
fn r09_the_length_of_the_direction_scales_t_exactly() {
    for scene in DEPTHS.into_iter().flat_map(|(depth, _)| all_scenes(depth)) {
        for seed in 0..70 {
            let mut rng = Rng::new(seed);
            let ray = draw(seed as u32 % 7, &scene, &mut rng);
            let here = scene.dag().trace(&query(&ray));
            for exponent in [-200, -1, 3, 150] {
                let dir = ray.dir.map(|d| libm::scalbn(d, exponent));
                let [t_min, t_max] = [ray.t_min, ray.t_max].map(|t| libm::scalbn(t, -exponent));
                let scaled = Ray { dir, t_min, t_max, ..ray };
                let there = scene.dag().trace(&query(&scaled));
                let expected = here.map(|h| Hit { t: libm::scalbn(h.t, -exponent), ..h });
                assert_eq!(there, expected, "{}, seed {seed}: {ray:?} by 2^{exponent}", scene.name);
            }
        }
    }
}

#[test]
fn r10_t_min_counts_and_t_max_does_not() {
    for (depth, _) in DEPTHS {
        for scene in all_scenes(depth) {
            for seed in 0..27 {
                let mut rng = Rng::new(seed);
                let ray = draw(seed as u32 % CLASSES, &scene, &mut rng);
                let Some(truth) = check(&scene, &ray) else { continue };
                // Around the hit: at it, just before and just after it. The oracle knows which side of a rounded t is which.
                for t in [truth.t, truth.t.next_down(), truth.t.next_up()] {
                    check(&scene, &Ray { t_max: t, ..ray });
                    check(&scene, &Ray { t_min: t, ..ray });
                    check(&scene, &Ray { t_min: t, t_max: t.next_up(), ..ray });
                }
                check(&scene, &Ray { t_min: -truth.t, t_max: truth.t * 0.5, ..ray });
                check(&scene, &Ray { t_min: f64::NEG_INFINITY, ..ray });
            }
        }
    }
    // Where t is exact: a wall at t = 2.
    let scene = Scene::of_implicit("wall", 3, Implicit::Wall { axis: 0, lo: 2, hi: 3 }, 10);
    let at = |t_min, t_max| {
        scene
            .dag()
            .trace(&Query { t_min, t_max, ..Query::new([0.0, 1.5, 1.5], [1.0, 0.0, 0.0]) })
            .map(|h| (h.t, h.face))
    };
    assert_eq!(at(0.0, 2.0), None);
    assert_eq!(at(0.0, 2.0f64.next_up()), Some((2.0, Face::NegX)));
    assert_eq!(at(2.0, 9.0), Some((2.0, Face::Inside)));
    assert_eq!(at(3.0f64.next_down(), 9.0), Some((3.0f64.next_down(), Face::Inside)));
    assert_eq!(at(3.0, 9.0), None);
}

#[test]
fn r11_rays_that_start_in_the_voxel_before_do_not_hit_where_they_are() {
    // On flat walls a ray that leaves on the side it came from never hits the wall again, wherever rounding put its origin.
    for depth in [3, 10, 16, 21] {
        let n = 1i64 << depth;
        for (axis, lo) in [(0, n / 3), (1, n / 2), (2, n - 2)] {
            let scene = Scene::of_implicit("wall", depth, Implicit::Wall { axis, lo, hi: lo + 1 }, 11);
            for seed in 0..300 {
                let mut rng = Rng::new(seed);
                let ray = draw(seed as u32 % 3, &scene, &mut rng);
                let Some(hit) = scene.dag().trace(&query(&ray)) else { continue };
                let Some(from) = hit.from else { continue };
                assert!(!scene.dag().contains(from), "seed {seed}");
                let point: [f64; 3] = core::array::from_fn(|i| ray.origin[i] + ray.dir[i] * hit.t);
                let normal = hit.face.normal();
                // Leave on the same side, also at grazing angles; the origin may be off by several units in the last place.
                let mut away = rng.direction();
                let up = f64::from(normal[axis]);
                away[axis] = away[axis].abs().max(1e-12) * up * rng.pick(&[1.0, 1e-9]);
                let origin = point.map(|x| x + x.abs() * 1e-15 * rng.between(-4, 4) as f64);
                // Flat rays of a large cube walk along the wall for millions of voxels: a few of them to the end.
                let t_max = if seed % 50 == 0 { f64::INFINITY } else { 2000.0 };
                let shadow = Query { start: Some(from), t_max, ..Query::new(origin, away) };
                assert_eq!(scene.dag().trace(&shadow), None, "{}, seed {seed}: {ray:?}, {shadow:?}", scene.name);
                assert!(!scene.dag().occluded(&shadow), "{}, seed {seed}", scene.name);
            }
        }
    }
}

#[test]
fn r11_a_start_in_the_voxel_of_the_origin_changes_nothing() {
    for scene in DEPTHS.into_iter().flat_map(|(depth, _)| all_scenes(depth)) {
        for seed in 0..200 {
            let mut rng = Rng::new(seed);
            let mut ray = draw(1, &scene, &mut rng);
            ray.origin = ray.origin.map(|x| x.abs());
            let Some(start) = Morton::encode(ray.origin.map(|x| x as u32)) else { continue };
            if ray.origin.iter().any(|x| *x >= f64::from(1u32 << scene.depth)) || scene.dag().contains(start) {
                continue;
            }
            let with = scene.dag().trace(&Query { start: Some(start), ..query(&ray) });
            assert_eq!(with, scene.dag().trace(&query(&ray)), "{}, seed {seed}: {ray:?}", scene.name);
        }
    }
}

#[test]
fn r12_depth_21_is_resolved_to_the_voxel_and_22_is_refused() {
    // The last voxels of the largest cube in turn, each alone: rays to a point of it hit it, rays that pass it by 2^-25 of
    // a voxel, which f32 could not tell, do not.
    let n = 1u32 << 21;
    for k in 1..=16 {
        let voxel = [n - k, n - 1, n - 17 + k];
        let scene = Scene::of_set("one voxel", 21, VoxelSet::new([voxel]));
        let low = voxel.map(f64::from);
        for (origin, dir) in [
            ([0.0, low[1] + 0.5, low[2] + 0.5], [1.0, 0.0, 0.0]),
            ([low[0] + 0.5, 0.0, low[2] + 0.5], [0.0, 1.0, 0.0]),
            ([low[0] + 0.5, low[1] + 0.5, 0.0], [0.0, 0.0, 1.0]),
            ([0.0; 3], low.map(|x| x + 0.5)),
        ] {
            assert_eq!(check(&scene, &Ray::new(origin, dir)).map(|t| t.voxel), Some(voxel), "{origin:?} {dir:?}");
        }
        let beside = 1.0 / f64::from(1 << 25);
        for (offset, met) in [(-beside, false), (0.0, true), (1.0 - beside, true), (1.0, false)] {
            let ray = Ray::new([low[0] + offset, 0.0, low[2] + 0.5], [0.0, 1.0, 0.0]);
            assert_eq!(check(&scene, &ray).is_some(), met, "{ray:?}");
        }
    }
    // Nothing deeper can be named, built or loaded.
    assert_eq!(Morton::encode([n, 0, 0]), None);
    assert!(voxdag::build::DagBuilder::new(22).is_err());
    let mut words = VoxelSet::new([[1, 2, 3]]).words(21);
    words[0] = 22;
    assert_eq!(Dag::new(&words).err(), Some(voxdag::dag::DagError::Depth { found: 22 }));
}

#[test]
fn r13_thin_boxes_and_the_border_of_the_cube_are_never_missed() {
    for (depth, step) in DEPTHS {
        let n = 1u64 << depth;
        // Boxes of one to eight voxels a side, most of them flat, somewhere in the cube.
        for seed in (0..60).step_by(step) {
            let mut rng = Rng::new(seed);
            let size = [(); 3].map(|()| rng.pick(&[1, 1, 2, 8]));
            let low = size.map(|s| rng.below(n - s + 1));
            let voxels = (0..512).map(|i| [i & 7, i >> 3 & 7, i >> 6]).filter(|v| (0..3).all(|i| v[i] < size[i]));
            let set = VoxelSet::new(voxels.map(|v| core::array::from_fn(|i| (low[i] + v[i]) as u32)));
            let scene = Scene::of_set("box", depth, set);
            for _ in 0..30 {
                // At its faces, edges and corners, and a few units in the last place beside them.
                let at: [f64; 3] = core::array::from_fn(|i| {
                    let x = low[i] as f64 + size[i] as f64 * rng.pick(&[0.0, 1.0, rng.clone().unit()]);
                    x + x * f64::EPSILON * rng.between(-2, 2) as f64
                });
                let mut dir = rng.direction();
                dir[rng.below(3) as usize] *= rng.pick(&[1.0, 1e-3, 1e-15, 0.0]);
                let back = rng.pick(&[1.0, n as f64, 1e3 * n as f64]);
                check(&scene, &Ray::new(core::array::from_fn(|i| at[i] - back * dir[i]), dir));
            }
        }
        // The cube itself, full: a ray hits it exactly if it meets its half-open box.
        let full = Scene::of_implicit("full cube", depth, Implicit::Wall { axis: 0, lo: 0, hi: n as i64 }, 13);
        let mut met = 0;
        for seed in 0..400 {
            let mut rng = Rng::new(seed);
            let at = [(); 3].map(|()| {
                let x = n as f64 * rng.pick(&[0.0, 1.0, rng.clone().unit()]);
                x + n as f64 * f64::EPSILON * rng.between(-2, 2) as f64
            });
            let dir = rng.direction();
            let back = rng.pick(&[0.0, 1.0, n as f64, 1e3 * n as f64]);
            met += u32::from(check(&full, &Ray::new(core::array::from_fn(|i| at[i] - back * dir[i]), dir)).is_some());
        }
        assert!((100..300).contains(&met), "{met} of 400 hits say too little");
    }
}

#[test]
fn r14_coarser_levels_are_the_oracle_of_coarser_cubes() {
    for (depth, _) in DEPTHS {
        for scene in all_scenes(depth) {
            for seed in 0..72 {
                let mut rng = Rng::new(seed);
                let ray = draw(seed as u32 % CLASSES, &scene, &mut rng);
                let level = rng.below(u64::from(depth) + 3) as u8;
                let found = scene.dag().trace(&Query { min_level: level, ..query(&ray) });
                let truth = scene.truth(&ray, level.min(depth));
                same(found, truth, &|| format!("{}, level {level}, seed {seed}: {ray:?}", scene.name));
                assert_eq!(found.map_or(level.min(depth), |h| h.level), level.min(depth), "seed {seed}");
                assert_eq!(scene.dag().occluded(&Query { min_level: level, ..query(&ray) }), found.is_some());
            }
        }
    }
}

#[test]
fn r14_the_hierarchy_finds_what_stepping_finds() {
    for seed in 0..1500 {
        let scene = eighth(seed % 20);
        let mut rng = Rng::new(seed);
        let ray = draw(seed as u32 % CLASSES, &scene, &mut rng);
        let stepped = ray::walk(&ray, 3, usize::MAX).into_iter().find(|&v| scene.any(0, v));
        assert_eq!(scene.dag().trace(&query(&ray)).map(|h| h.voxel.decode()), stepped, "seed {seed}: {ray:?}");
    }
}

#[test]
fn r15_faces_follow_a_permutation_of_the_axes() {
    // At corners too: among tied axes the steepest wins, whatever its name.
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    for seed in 0..500 {
        let mut rng = Rng::new(seed);
        let depth = DEPTHS[seed as usize % 4].0;
        let first = (1 << depth) - 8;
        let voxels: Vec<[u32; 3]> = (0..40).map(|_| [(); 3].map(|()| first + rng.below(8) as u32)).collect();
        let mut dir = [1.0, 2.0, 4.0].map(|d: f64| d * rng.pick(&[-1.0, 1.0]));
        rng.shuffle(&mut dir);
        let corner = rng.pick(&voxels).map(|k| (k + rng.below(2) as u32) as f64);
        let origin: [f64; 3] = core::array::from_fn(|i| corner[i] - dir[i] * rng.pick(&[1.0, 1.0, 2.0]));
        let axis_of = |face: Face| face.normal().iter().position(|x| *x != 0.0);
        let hit = |order: [usize; 3]| {
            let set = VoxelSet::new(voxels.iter().map(|v| order.map(|i| v[i])));
            let words = set.words(depth);
            let hit = Dag::new(&words).unwrap().trace(&Query::new(order.map(|i| origin[i]), order.map(|i| dir[i])));
            hit.map(|h| (h.voxel.decode(), axis_of(h.face), h.t))
        };
        let plain = hit(ORDERS[0]);
        for order in ORDERS {
            let back = |axis: usize| order.iter().position(|&i| i == axis).unwrap();
            let expected = plain.map(|(v, axis, t)| (order.map(|i| v[i]), axis.map(back), t));
            assert_eq!(hit(order), expected, "seed {seed}, {order:?}: {origin:?} {dir:?}");
        }
    }
    // Equal steepness: the first axis.
    let scene = Scene::of_set("corner", 3, VoxelSet::new([[4, 4, 4]]));
    let face = |dir| scene.dag().trace(&Query::new([4.0 - 4.0; 3], dir)).unwrap().face;
    assert_eq!(face([1.0; 3]), Face::NegX);
}

#[test]
fn r16_published_endless_loops_end() {
    // fast_voxel_traversal issue 5: bins of 16, from (-668, -340, 77) to (404, -64, -784); issues 2 and 3 likewise.
    let vectors = [
        ([-668.0, -340.0, 77.0], [404.0, -64.0, -784.0]),
        ([0.0, 0.0, 0.0], [90.0, -16.0, 45.0]),
        ([-984.0, 670.0, -652.0], [580.0, 423.0, -869.0]),
    ];
    let bin = |p: [f64; 3]| p.map(|x| (x + 1024.0) / 16.0);
    for (from, to) in vectors {
        let (from, to) = (bin(from), bin(to));
        let dir: [f64; 3] = core::array::from_fn(|i| to[i] - from[i]);
        let ray = Ray { t_max: 1.0, ..Ray::new(from, dir) };
        let walk = ray::walk(&ray, 7, usize::MAX);
        assert_eq!(walk[0], from.map(|x| x as u32));
        // Each voxel of the walk in turn is the only one that is filled.
        for voxel in &walk {
            let scene = Scene::of_set("one voxel of the walk", 7, VoxelSet::new([*voxel]));
            assert_eq!(check(&scene, &ray).map(|t| t.voxel), Some(*voxel));
        }
        // And beside the walk there is nothing.
        let beside = walk.iter().map(|v| [v[0], v[1], v[2] ^ 1]).filter(|v| !walk.contains(v));
        let scene = Scene::of_set("beside the walk", 7, VoxelSet::new(beside));
        assert_eq!(check(&scene, &ray), None);
    }
}

#[test]
fn r17_published_rays_along_an_axis() {
    // cpu_voxel_raycaster issue 3: the unit cube is hit at z = 0.
    let scene = Scene::of_set("unit cube", 0, VoxelSet::new([[0, 0, 0]]));
    let hit = scene.dag().trace(&Query::new([0.49, 0.49, -1.0], [0.0, 0.0, 2.0])).unwrap();
    assert_eq!((hit.voxel, hit.t, hit.face, hit.from), (Morton(0), 0.5, Face::NegZ, None));
    // collision-rs issue 25: a ray along y at x = 6 does not meet a box from x = 21 on.
    let set = VoxelSet::new((21..23).flat_map(|x| (14..16).map(move |y| [x, y, 0])));
    let scene = Scene::of_set("box", 5, set);
    assert_eq!(check(&scene, &Ray::new([6.0, 0.0, 0.5], [0.0, 1.0, 0.0])), None);
    assert!(check(&scene, &Ray::new([21.0, 0.0, 0.5], [0.0, 1.0, 0.0])).is_some());
    assert_eq!(check(&scene, &Ray::new([23.0, 0.0, 0.5], [0.0, 1.0, 0.0])), None);
}

#[test]
fn r20_f64_arithmetic_keeps_the_three_inequalities() {
    // (A) the voxel found is touched; (B) it is not later than the first voxel whose interior is met; (C) a miss only
    // where no interior is met. What f64 promises, as opposed to equality.
    for depth in [3, 10, 16, 21] {
        for scene in all_scenes(depth) {
            for seed in 0..300 {
                let mut rng = Rng::new(seed);
                let ray = draw(seed as u32 % 7, &scene, &mut rng);
                let what = || format!("{}, seed {seed}: {ray:?}", scene.name);
                let interior = ray::first_interior(&ray, scene.depth, &|h, c| scene.any(h, c));
                let Some(hit) = scene.dag().trace_with(Arithmetic::F64, &query(&ray)) else {
                    assert!(interior.is_none(), "(C) {}: misses {interior:?}", what());
                    continue;
                };
                let v = hit.voxel.decode();
                assert!(scene.any(0, v), "not filled: {}", what());
                assert!(ray::touches(&ray, v), "(A) {}: {hit:?}", what());
                if let Some(interior) = interior {
                    assert!(hit.t <= interior.t * (1.0 + 1e-12) + 1e-300, "(B) {}: {hit:?} {interior:?}", what());
                }
            }
        }
    }
}

#[test]
fn r21_all_voxels_along_a_ray_are_those_of_the_oracle() {
    for (depth, _) in DEPTHS {
        for scene in all_scenes(depth) {
            for seed in 0..CLASSES * 10 {
                let mut rng = Rng::new(u64::from(seed));
                let ray = draw(seed % CLASSES, &scene, &mut rng);
                let truth = ray::walk(&ray, depth, 700);
                let query = query(&ray);
                let what = format!("{}, {ray:?}", scene.name);
                let passed: Vec<_> = query.voxels(depth).take(700).map(Morton::decode).collect();
                assert_eq!(passed, truth, "{what}");
                // Of them, those that are filled.
                let filled: Vec<_> = truth.into_iter().filter(|v| scene.any(0, *v)).collect();
                for tracer in scene.tracers().chain([Tracer::new(scene.dag())]) {
                    let hits: Vec<_> = tracer.hits(&query).take(filled.len()).collect();
                    assert!(hits.iter().map(|h| h.voxel.decode()).eq(filled.iter().copied()), "{what}");
                    assert!(hits.is_sorted_by(|a, b| a.t <= b.t), "{what}");
                    assert_eq!(hits.first().copied(), scene.dag().trace(&query).filter(|_| !hits.is_empty()), "{what}");
                }
            }
        }
    }
}

#[test]
fn r22_a_top_grid_serves_coarser_levels_and_refuses_other_dags() {
    let scenes = all_scenes(6);
    for scene in &scenes {
        for seed in 0..CLASSES * 20 {
            let mut rng = Rng::new(u64::from(seed));
            let mut query = query(&draw(seed % CLASSES, scene, &mut rng));
            query.min_level = rng.below(8) as u8;
            query.start = query.voxels(6).nth(rng.below(40) as usize).filter(|_| seed % 3 == 0);
            for arithmetic in [Arithmetic::Exact, Arithmetic::F64] {
                let plain = scene.dag().trace_with(arithmetic, &query);
                for tracer in scene.tracers() {
                    let topped = tracer.trace(arithmetic, &query);
                    assert_eq!(topped.is_some(), tracer.occluded(arithmetic, &query), "{} {query:?}", scene.name);
                    if arithmetic == Arithmetic::Exact {
                        assert_eq!(topped, plain, "{} {query:?}", scene.name);
                    }
                }
            }
        }
    }
    let other = VoxelSet::new([[1, 2, 3]]).words(7);
    assert!(Tracer::with_top(Dag::new(&other).unwrap(), scenes[0].tops[2].as_top()).is_none());
}

#[test]
fn r11_rays_along_a_wall_do_not_hit_it() {
    // Rays that do not move across the wall that they leave, from points that rounding has put on its far side.
    let wall = VoxelSet::new((0..64).map(|i| [5, i % 8, i / 8])).words(3);
    let dag = Dag::new(&wall).unwrap();
    for off in -2..=2 {
        let x = 5.0 + f64::from(off) * 1e-15;
        for dir in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.3, 0.7], [-0.0, 0.3, 0.7], [-1e-9, 0.3, 0.7]] {
            for (y, z) in [(4u32, 4u32), (3, 3), (0, 7)] {
                let origin = [x, f64::from(y) + 0.5, f64::from(z) + 0.5];
                let query = Query { start: Morton::encode([4, y, z]), ..Query::new(origin, dir) };
                assert_eq!(dag.trace(&query), None, "{query:?}");
                assert!(!dag.occluded(&query), "{query:?}");
            }
        }
    }
    // As a renderer meets them: the light stands right above the point that was hit.
    let mut rng = Rng::new(1);
    let mut lit = 0;
    while lit < 3000 {
        let origin = [rng.uniform(0.0, 4.9), rng.uniform(0.0, 8.0), rng.uniform(0.0, 8.0)];
        let query = Query::new(origin, rng.direction());
        let Some(hit) = dag.trace(&query).filter(|hit| hit.voxel.decode()[0] == 5 && hit.from.is_some()) else {
            continue;
        };
        let point = core::array::from_fn(|i| query.origin[i] + query.dir[i] * hit.t);
        assert!(!dag.occluded(&Query { start: hit.from, ..Query::new(point, [0.0, 0.0, 1.0]) }), "{query:?} {hit:?}");
        lit += 1;
    }
}

/// Numbers of every size in every place, limits at and beside the crossings: equality all the same.
#[test]
fn r23_any_numbers_in_small_cubes() {
    let mut hits = 0;
    for seed in 0..400 {
        let mut rng = Rng::new(seed * 7919);
        let depth = rng.below(6) as u8;
        let n = 1u64 << depth;
        let set = VoxelSet::new((0..1 + rng.below(n * n)).map(|_| [(); 3].map(|()| rng.below(n) as u32)));
        let scene = Scene::of_set("any numbers", depth, set);
        for _ in 0..25 {
            let scale = match rng.below(6) {
                0 => rng.spread(-1073, 900).abs(),
                _ => 1.0,
            };
            let dir = [(); 3].map(|()| {
                let component = match rng.below(7) {
                    0 => 0.0,
                    1 => -0.0,
                    2 => rng.between(-3, 3) as f64,
                    3 => rng.spread(-1074, 0),
                    4 => rng.spread(-60, 0),
                    _ => rng.uniform(-1.0, 1.0),
                };
                component * scale
            });
            // Through a lattice point, beside one, or anywhere; from near or far.
            let through = [(); 3].map(|()| match rng.below(3) {
                0 => rng.between(0, n as i64) as f64,
                1 => rng.between(0, n as i64) as f64 + rng.spread(-60, -40),
                _ => rng.uniform(0.0, n as f64),
            });
            let back = match rng.below(5) {
                0 => 0.0,
                1 => rng.between(-9, 9) as f64,
                2 => rng.spread(-10, 60),
                3 => rng.spread(-10, 900),
                _ => rng.uniform(-9.0, 9.0),
            } / scale;
            let origin = core::array::from_fn(|i| through[i] - dir[i] * back);
            let mut limit = || match rng.below(4) {
                0 => back,
                1 => back + rng.between(-3, 3) as f64 / scale,
                2 => rng.spread(-1000, 1000),
                _ => back * (1.0 + rng.between(-3, 3) as f64 * f64::EPSILON),
            };
            let limits = [limit(), limit()];
            let t_min = [0.0, f64::NEG_INFINITY, limits[0], limits[0]][rng.below(4) as usize];
            let t_max = [limits[1], f64::INFINITY, f64::INFINITY][rng.below(3) as usize];
            hits += u32::from(check(&scene, &Ray { origin, dir, t_min, t_max }).is_some());
        }
    }
    assert!(hits > 1000, "{hits} hits are too few to say anything");
}
