//! Rays against voxels (hard-cases, section 4.2): the oracle on big rationals decides; the exact tracer must equal it, f64
//! and the textbook in f32 (Laine and Karras 2010) keep the three inequalities of section 4.1 or are counted as wrong.
//!
//! The six numbers of a ray are f32 numbers, so that both get the same ray; only tiny components may be smaller.

use std::sync::{Arc, OnceLock};

use voxdag::trace::{Arithmetic, Hit, Query, TopBuf, Tracer};
use voxdag::{Dag, Morton};

use super::{Case, Tally, Unit};
use crate::octree::VoxelSet;
use crate::ray::{self, Ray, Time, Truth};
use crate::rng::Rng;
use crate::scenes::Implicit;
use crate::textbook::esvo_f32;

/// The kinds of rays, by the number that [`Scene::draw`] takes.
pub const CLASSES: [&str; 7] = [
    "random",
    "along an axis",
    "in a plane between voxels",
    "along diagonals, through corners",
    "from 1e3 scenes away",
    "from 1e6 scenes away",
    "tiny components",
];
const DEPTHS: [u8; 4] = [3, 10, 16, 21];
/// Rays of a piece at each shape.
const RAYS: u64 = 5;

/// A shape as a DAG and in the oracle's terms.
pub struct Scene {
    /// What it is.
    pub name: &'static str,
    depth: u8,
    /// The DAG.
    pub words: Vec<u32>,
    shape: Shape,
    /// Filled voxels to aim at.
    targets: Vec<[u32; 3]>,
    top: TopBuf,
}

enum Shape {
    Implicit(Implicit),
    Set(VoxelSet),
}

impl Scene {
    fn new(name: &'static str, depth: u8, words: Vec<u32>, shape: Shape, targets: Vec<[u32; 3]>) -> Scene {
        let dag = Dag::new(&words).expect("the twin's words are good");
        let top = TopBuf::new(&dag, 4).expect("room for a small grid");
        assert!(targets.iter().all(|v| Morton::encode(*v).is_some_and(|v| dag.contains(v))), "{name}");
        Scene { name, depth, words, shape, targets, top }
    }

    /// A shape without a list of voxels; `aim` moves a random voxel into it.
    fn implicit(name: &'static str, depth: u8, shape: Implicit, aim: impl Fn(&mut Rng, [i64; 3]) -> [i64; 3]) -> Scene {
        let mut rng = Rng::new(u64::from(depth));
        let mut targets = Vec::new();
        while targets.len() < 64 {
            let v = [(); 3].map(|()| rng.below(1 << depth) as i64);
            let v = aim(&mut rng, v);
            if v.iter().all(|k| (0..1 << depth).contains(k)) {
                targets.push(v.map(|k| k as u32));
            }
        }
        Scene::new(name, depth, shape.words(depth), Shape::Implicit(shape), targets)
    }

    /// The four shapes of the catalogue at a depth.
    pub fn all(depth: u8) -> Vec<Scene> {
        let n = 1i64 << depth;
        // The part of a sphere's shell around its point nearest to a corner; the whole one up to 2^6.
        let shell = Implicit::Shell { centre: [n; 3], inner: n - 3, outer: n };
        let at = (n as f64 * 0.5 * (1.0 - libm::sqrt(1.0 / 3.0))) as i64;
        let (lo, hi) = ((at - 16).max(0), (at + 16).min(n));
        let side = hi - lo;
        let piece = (0..side * side * side).map(|i| [i % side, i / side % side, i / (side * side)]);
        let piece: Vec<[u32; 3]> = piece.map(|v| v.map(|k| (k + lo) as u32)).filter(|v| shell.filled(*v)).collect();
        let set = VoxelSet::new(piece.iter().copied());
        let wall = n / 3;
        vec![
            Scene::new("shell", depth, set.words(depth), Shape::Set(set), piece),
            Scene::implicit("wall", depth, Implicit::Wall { axis: 1, lo: wall, hi: wall + 1 }, |_, v| {
                [v[0], wall, v[2]]
            }),
            Scene::implicit("diagonal wall", depth, Implicit::Diagonal { lo: n, hi: n + 3 }, |rng, v| {
                [v[0], v[1], n + rng.between(0, 2) - v[0] - v[1]]
            }),
            Scene::implicit("dust", depth, Implicit::Dust { at: [1, 3, 0] }, |_, v| {
                [v[0] & !3 | 1, v[1] | 3, v[2] & !3]
            }),
        ]
    }

    fn any(&self, level: u8, corner: [u32; 3]) -> bool {
        match &self.shape {
            Shape::Implicit(shape) => shape.any(level, corner),
            Shape::Set(set) => set.any(level, corner),
        }
    }

    /// Which of the three inequalities are broken by a method that found this voxel: it is filled and touched (A), no later
    /// than the first whose interior is met, which no method may miss (B), and nothing is found only where there is none (C).
    pub fn broken<'a>(&'a self, ray: &'a Ray) -> impl Fn(Option<[u32; 3]>) -> [bool; 3] + 'a {
        let interior = ray::first_interior(ray, self.depth, &|level, corner| self.any(level, corner));
        let first = interior.map(|hit| Time::At(hit.time));
        move |found| {
            let Some(voxel) = found else { return [false, false, first.is_some()] };
            match ray::arrival(ray, voxel).filter(|_| self.any(0, voxel)) {
                Some(time) => [false, first.as_ref().is_some_and(|first| time > *first), false],
                None => [true, false, false],
            }
        }
    }

    /// Asks all about a ray.
    fn ask(&self, ray: &Ray, tally: &mut Tally) {
        let any = |level: u8, corner: [u32; 3]| self.any(level, corner);
        let truth = ray::first(ray, self.depth, 0, &any);
        let broken = self.broken(ray);
        let kept = |found: Option<[u32; 3]>| broken(found) == [false; 3];

        let query = Query { t_min: ray.t_min, t_max: ray.t_max, ..Query::new(ray.origin, ray.dir) };
        let dag = Dag::new(&self.words).expect("the twin's words are good");
        let tracers = [Tracer::new(dag), Tracer::with_top(dag, self.top.as_top()).expect("the grid is this DAG's")];
        let ours = tracers.iter().all(|tracer| {
            same(tracer.trace(Arithmetic::Exact, &query), truth.as_ref())
                && tracer.occluded(Arithmetic::Exact, &query) == truth.is_some()
        });
        let f64 = tracers.iter().all(|t| kept(t.trace(Arithmetic::F64, &query).map(|hit| hit.voxel.decode())));
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        let f32 = esvo_f32(single(ray.origin), single(ray.dir), ray.t_max as f32, self.depth, any);
        tally.count(kept(f32), f64, ours, || format!("{}, 2^{}: {ray:?}", self.name, self.depth));
    }

    /// A ray of a class at one of the targets.
    pub fn draw(&self, class: usize, rng: &mut Rng) -> Ray {
        let n = f64::from(1u32 << self.depth);
        let target = rng.pick(&self.targets).map(f64::from);
        let inside = target.map(|k| k + rng.unit());
        let corner = target.map(|k| k + rng.below(2) as f64);
        let signs = [(); 3].map(|()| rng.pick(&[-1.0, 1.0]));
        let axis = rng.below(3) as usize;
        let toward = |origin: [f64; 3]| Ray::new(origin, core::array::from_fn(|i| single(inside[i] - origin[i])));
        // Where rays may run on for ever, between grains of dust or along a wall, those of the oracle must not.
        let near = |origin: [f64; 3], dir: [f64; 3]| Ray { t_max: 512.0, ..Ray::new(origin, dir) };
        match class {
            0 => toward([(); 3].map(|()| single(rng.uniform(-0.5 * n, 1.5 * n)))),
            1 => {
                let mut origin = target.map(|k| k + rng.pick(&[0.0, 0.5, 1.0]));
                origin[axis] = target[axis] + rng.between(-80, 80) as f64 / 2.0;
                let mut dir = [0.0, -0.0, 0.0];
                dir[axis] = signs[axis];
                near(origin, dir)
            }
            2 => {
                let mut dir = rng.direction().map(single);
                dir[axis] = 0.0;
                let mut origin: [f64; 3] = core::array::from_fn(|i| single(inside[i] - 10.0 * dir[i]));
                origin[axis] = corner[axis];
                near(origin, dir)
            }
            3 => {
                let steps = rng.below(40) as f64;
                near(core::array::from_fn(|i| corner[i] - steps * signs[i]), signs)
            }
            4 | 5 => {
                let far = if class == 4 { 1e3 * n } else { 1e6 * n };
                let d = rng.direction();
                toward(core::array::from_fn(|i| single(inside[i] - far * d[i])))
            }
            _ => {
                let mut ray = self.draw(1 + rng.below(3) as usize, rng);
                ray.dir[axis] = rng.pick(&[1e-30, -1e-40, 1e-45, -1e-300, 5e-324, -3e-310]);
                // All of them tiny, by a power of two, so that the line stays what it is.
                let exponent = rng.pick(&[0, 0, -100, -960]);
                if exponent != 0 {
                    ray.dir = ray.dir.map(|d| libm::scalbn(d, exponent));
                    ray.t_max = libm::scalbn(ray.t_max, -exponent);
                }
                if ray.dir == [0.0; 3] {
                    ray.dir[axis] = 5e-324;
                }
                ray
            }
        }
    }
}

/// The f32 number next to it.
fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

/// The tracer says what is true: voxel, time to one unit in the last place, face, and the voxel before.
fn same(found: Option<Hit>, truth: Option<&Truth>) -> bool {
    match (found, truth) {
        (None, None) => true,
        (Some(hit), Some(truth)) => {
            (hit.voxel.decode(), hit.face, hit.from.map(Morton::decode)) == (truth.voxel, truth.face, truth.from)
                && (hit.t == truth.t || hit.t == truth.t.next_up() || hit.t == truth.t.next_down())
        }
        _ => false,
    }
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for depth in DEPTHS {
        let scenes = Arc::new(OnceLock::new());
        for (class, name) in CLASSES.into_iter().enumerate() {
            let scenes = scenes.clone();
            let ask = move |piece: u64| {
                let mut tally = Tally::default();
                for scene in scenes.get_or_init(|| Scene::all(depth)) {
                    let mut rng = Rng::new(piece << 8 | (class as u64) << 5 | u64::from(depth));
                    (0..RAYS).for_each(|_| scene.ask(&scene.draw(class, &mut rng), &mut tally));
                }
                tally
            };
            cases.push(Case::new("rays", format!("{name}, 2^{depth}"), Unit::Rays, [4, 400], Box::new(ask)));
        }
    }
    cases
}
