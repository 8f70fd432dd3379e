//! Rays on the adapter against the exact tracer, which must be equalled, and against the oracle: a hit is touched (A), no
//! later than the first voxel whose interior is met (B), and nothing is found only where there is none (C).

use voxdag::materials::Single;
use voxdag::normal::{NormalKind, normal};
use voxdag::trace::{Arithmetic, Face, Hit, Query, Tracer};
use voxdag::{Dag, Morton, math, wgsl};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::ray::Ray;
use voxdag_oracle::rng::Rng;
use voxdag_oracle::selftest::rays::{CLASSES, Scene};

use crate::gpu::{Gpu, Scene as Uploaded};

/// Words of a question and of an answer.
pub const WORDS: usize = 16;

/// What is asked: a ray of f32 numbers, and where it starts if not at its origin.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    pub origin: [f32; 3],
    pub dir: [f32; 3],
    pub t_max: f32,
    pub start: Option<Morton>,
}

/// What the adapter says.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Answer {
    pub hit: Option<Found>,
    pub occluded: bool,
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Found {
    pub voxel: [u32; 3],
    pub before: Option<[u32; 3]>,
    pub t: f32,
    pub face: Face,
    pub material: u32,
    pub normal: [f32; 3],
}

impl Question {
    pub fn new(origin: [f32; 3], dir: [f32; 3]) -> Question {
        Question { origin, dir, t_max: f32::MAX, start: None }
    }

    /// The ray, its numbers rounded to f32; `None` if what is left of its direction is subnormal: a card may divide by 0
    /// where it works out t, and then there is none.
    fn of(ray: &Ray) -> Option<Question> {
        let [origin, dir] = [ray.origin, ray.dir].map(|v| v.map(|x| x as f32));
        let usable = dir.iter().any(|x| x.is_normal()) && origin.iter().chain(&dir).all(|x| x.is_finite());
        usable.then_some(Question { t_max: (ray.t_max as f32).min(f32::MAX), ..Question::new(origin, dir) })
    }

    /// The ray that is meant.
    fn ray(&self) -> Ray {
        let t_max = if self.t_max == f32::MAX { f64::INFINITY } else { self.t_max.into() };
        Ray { t_max, ..Ray::new(self.origin.map(f64::from), self.dir.map(f64::from)) }
    }

    pub fn query(&self) -> Query {
        let ray = self.ray();
        Query { t_max: ray.t_max, start: self.start, ..Query::new(ray.origin, ray.dir) }
    }

    /// Whether the shader's integers hold its numbers without rounding (docs/gpu.md).
    fn is_exact(&self) -> bool {
        let whole = |v: [f32; 3], bits: i32, most: i32| {
            let largest = v.map(|x| f64::from(x.abs())).into_iter().fold(0.0, f64::max);
            let unit = libm::exp2(f64::from(libm::ilogb(largest).saturating_sub(bits - 1).max(most)));
            v.iter().all(|x| (f64::from(*x) / unit).fract() == 0.0)
        };
        whole(self.dir, 63, i32::MIN / 2) && whole(self.origin, 62, -32)
    }

    fn words(&self) -> [u32; WORDS] {
        let mut words = [0; WORDS];
        for i in 0..3 {
            words[i] = self.origin[i].to_bits();
            words[3 + i] = self.dir[i].to_bits();
            words[6 + i] = self.start.map_or(u32::MAX, |start| start.decode()[i]);
        }
        words[9] = self.t_max.to_bits();
        words
    }
}

/// Asks the adapter.
pub fn ask(gpu: &Gpu, pipeline: &wgpu::ComputePipeline, scene: &Uploaded, questions: &[Question]) -> Vec<Answer> {
    let words: Vec<u32> = questions.iter().flat_map(|question| question.words()).collect();
    let groups = [questions.len().div_ceil(64) as u32, 1];
    let answers = gpu.run(pipeline, scene, (&words, wgpu::BufferUsages::STORAGE), groups, words.len());
    answers.as_chunks::<WORDS>().0.iter().map(answer).collect()
}

fn answer(words: &[u32; WORDS]) -> Answer {
    let three = |at: usize| [words[at], words[at + 1], words[at + 2]];
    let hit = (words[0] & 1 != 0).then(|| Found {
        voxel: three(1),
        before: (words[4] as i32 >= 0).then(|| three(4)),
        t: f32::from_bits(words[7]),
        face: Face::ALL[words[8] as usize],
        material: words[9],
        normal: three(10).map(f32::from_bits),
    });
    Answer { hit, occluded: words[0] & 2 != 0 }
}

/// llvmpipe ends all loops of a shader once they have taken 65,535 turns together; there, longer rays are left out.
const LLVMPIPE_ROUNDS: u32 = 8000;

/// What came of the rays of a class at a depth.
#[derive(Default)]
pub struct Tally {
    rays: u64,
    left_out: u64,
    hits: u64,
    judged: u64,
    broken: [u64; 3],
    /// Another voxel, face or voxel before than the exact tracer's, or any hit that is not nearest hit.
    other: u64,
    /// The largest error of t, in units of 2^-24 of it.
    t_error: f64,
    /// Degrees between normals.
    angles: Angles,
    first: Option<String>,
}

/// Degrees that no rounding explains.
const LARGE: f64 = 0.1;

/// Angles between normals, in degrees.
#[derive(Default)]
pub struct Angles {
    most: f64,
    sum: f64,
    count: u64,
    /// Of more than [`LARGE`].
    large: u64,
}

impl Angles {
    fn add(&mut self, a: [f32; 3], b: [f32; 3]) -> f64 {
        let [a, b] = [a, b].map(|v| v.map(f64::from));
        let sine = math::cross(a, b);
        let angle = libm::atan2(math::sqrt(math::dot(sine, sine)), math::dot(a, b)).to_degrees();
        self.most = self.most.max(angle);
        self.sum += angle;
        self.count += 1;
        let angle = if angle.is_nan() { f64::INFINITY } else { angle };
        self.large += u64::from(angle > LARGE);
        angle
    }
}

impl std::fmt::Display for Angles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.1e} | {:.1e} | {}", self.most, self.sum / self.count.max(1) as f64, self.large)
    }
}

impl Tally {
    fn fail(&mut self, what: impl FnOnce() -> String) {
        self.first.get_or_insert_with(what);
    }
}

/// The head of the table of [`check`]: errors of t in units of 2^-24 of it, normals in degrees from the core's.
pub const HEAD: &str = "\
| depth | rays | traced | left out | hits | other | t off | normals off: most | mean | above 0.1 | judged | A | B | C |
| ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |";

/// Rays of all classes at a depth; how many were wrong.
pub fn check(gpu: &Gpu, depth: u8, rays: usize, judged: usize) -> u64 {
    let pipeline = gpu.pipeline("ask_rays");
    let mut wrong = 0;
    let scenes = Scene::all(depth);
    for (class, name) in CLASSES.into_iter().enumerate() {
        let mut tally = Tally::default();
        for scene in &scenes {
            let dag = Dag::new(&scene.words).expect("the twin's words are good");
            let uploaded = gpu.scene(&scene.words, &wgsl::dag(dag));
            let mut rng = Rng::new(u64::from(depth) << 8 | class as u64);
            let mut questions: Vec<Question> =
                (0..rays).filter_map(|_| Question::of(&scene.draw(class, &mut rng))).collect();
            let drawn = questions.len();
            if gpu.is_llvmpipe {
                let rounds = |q: &Question| Tracer::new(dag).trace_counted(Arithmetic::Exact, &q.query()).1.rounds;
                questions.retain(|question| rounds(question) <= LLVMPIPE_ROUNDS);
            }
            tally.left_out += (drawn - questions.len()) as u64;
            let answers = ask(gpu, &pipeline, &uploaded, &questions);
            for (i, (question, answer)) in questions.iter().zip(&answers).enumerate() {
                compare(&mut tally, dag, question, answer, scene.name);
                if i < judged {
                    let ray = question.ray();
                    let broken = scene.broken(&ray)(answer.hit.map(|hit| hit.voxel));
                    tally.judged += 1;
                    for (sum, broken) in tally.broken.iter_mut().zip(broken) {
                        *sum += u64::from(broken);
                    }
                    if broken != [false; 3] {
                        tally.fail(|| format!("{}: {question:?}: {answer:?}, broken: {broken:?}", scene.name));
                    }
                }
            }
        }
        let Tally { rays, hits, left_out, judged, broken: [a, b, c], other, t_error, ref angles, .. } = tally;
        print!("| {depth} | {name} | {rays} | {left_out} | {hits} | {other} | {t_error:.1} ");
        println!("| {angles} | {judged} | {a} | {b} | {c} |");
        if let Some(first) = &tally.first {
            println!("  first: {first}");
        }
        wrong += other + a + b + c + angles.large;
    }
    wrong
}

/// Rays that leave surfaces, as shadows do: from the voxel before a hit, up to some `t_max`; how many were wrong.
pub fn check_leaving(gpu: &Gpu, depth: u8, rays: usize) -> u64 {
    let pipeline = gpu.pipeline("ask_rays");
    let mut tally = Tally::default();
    for scene in Scene::all(depth) {
        let dag = Dag::new(&scene.words).expect("the twin's words are good");
        let uploaded = gpu.scene(&scene.words, &wgsl::dag(dag));
        let mut rng = Rng::new(u64::from(depth));
        let questions: Vec<Question> = (0..rays)
            .filter_map(|_| {
                let first = Question::of(&scene.draw(0, &mut rng))?;
                let hit = Tracer::new(dag).trace(Arithmetic::Exact, &first.query())?;
                // Rounded, the place may be beside the voxel that the ray is to start in.
                let Query { origin, dir, .. } = first.query();
                let origin = math::add_scaled(origin, dir, hit.t).map(|x| x as f32);
                let dir = rng.direction().map(|x| x as f32);
                // Some begin in the voxel itself, where an end at or before the start still ends them.
                if rng.below(8) == 0 {
                    let middle = hit.voxel.decode().map(|x| x as f32 + 0.5);
                    return Some(Question { t_max: rng.pick(&[0.0, -1.0, 2.0]), ..Question::new(middle, dir) });
                }
                let t_max = rng.pick(&[1.0, 4.0, 30.0, 1000.0]) * rng.unit() as f32;
                Some(Question { t_max, start: Some(hit.from?), ..Question::new(origin, dir) })
            })
            .collect();
        for (question, answer) in questions.iter().zip(&ask(gpu, &pipeline, &uploaded, &questions)) {
            // Of a ray that starts beside its voxel the side of entry may be another.
            let truth = Tracer::new(dag).trace(Arithmetic::Exact, &question.query()).map(|hit| hit.voxel.decode());
            tally.rays += 1;
            tally.hits += u64::from(truth.is_some());
            if truth != answer.hit.map(|hit| hit.voxel) || answer.occluded != truth.is_some() {
                tally.other += 1;
                tally.fail(|| format!("{}: {question:?}:\n    {answer:?}\n    {truth:?}", scene.name));
            }
        }
    }
    let Tally { rays, hits, other, .. } = tally;
    println!("leaving surfaces at depth {depth}: {rays} rays, {hits} hits, {other} not the exact tracer's");
    if let Some(first) = &tally.first {
        println!("  first: {first}");
    }
    other
}

/// Voxels at random, few to many: points, lines, planes and solids around the hits; how many normals were wrong.
pub fn check_noise(gpu: &Gpu) -> u64 {
    let pipeline = gpu.pipeline("ask_rays");
    let mut tally = Tally::default();
    let small = [(0, 999), (1, 300), (2, 20), (2, 900), (3, 200)];
    for (depth, per_mille) in [3, 10, 30, 100, 200, 400, 700].map(|n| (5, n)).into_iter().chain(small) {
        let mut rng = Rng::new(per_mille);
        let all = (0..1u32 << (3 * depth)).map(|i| Morton(i.into()).decode());
        let set = VoxelSet::new(all.filter(|_| rng.below(1000) < per_mille));
        let words = set.words(depth);
        let dag = Dag::new(&words).expect("the twin's words are good");
        let questions: Vec<Question> = (0..20_000)
            .map(|_| {
                let n = f64::from(1u32 << depth);
                let origin = [(); 3].map(|()| rng.uniform(-0.3 * n, 1.3 * n) as f32);
                Question::new(origin, rng.direction().map(|x| x as f32))
            })
            .collect();
        let answers = ask(gpu, &pipeline, &gpu.scene(&words, &wgsl::dag(dag)), &questions);
        for (question, answer) in questions.iter().zip(&answers) {
            compare(&mut tally, dag, question, answer, "noise");
        }
    }
    let Tally { rays, hits, other, ref angles, .. } = tally;
    println!("voxels at random: {rays} rays, {hits} hits, {other} not the exact tracer's; normals off | {angles}");
    other + angles.large
}

/// What is no ray, or far from any scene, meets nothing; what is no DAG is left some time. How many were wrong.
pub fn check_garbage(gpu: &Gpu) -> u64 {
    let pipeline = gpu.pipeline("ask_rays");
    let mut rng = Rng::new(1);
    let scene = &Scene::all(10)[1];
    let dag = Dag::new(&scene.words).expect("the twin's words are good");
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let odd = [0.0, -0.0, nan, inf, -inf, f32::MAX, 1e-45, -1e-45, f32::MIN_POSITIVE, 1.0, 5e18, -3e9];
    let mut draw = || [(); 3].map(|()| rng.pick(&odd));
    let questions: Vec<Question> = (0..20_000).map(|_| Question::new(draw(), draw())).collect();
    let uploaded = gpu.scene(&scene.words, &wgsl::dag(dag));
    let mut tally = Tally::default();
    for (question, answer) in questions.iter().zip(&ask(gpu, &pipeline, &uploaded, &questions)) {
        // What is 2^62 voxels away meets nothing; what is rounded may meet something else.
        let far = question.origin.iter().any(|x| x.is_finite() && x.abs() >= 4e18);
        let no_ray = !question.origin.iter().chain(&question.dir).all(|x| x.is_finite()) || question.dir == [0.0; 3];
        if !no_ray && !far && !question.is_exact() {
            continue;
        }
        if no_ray || far {
            tally.other += u64::from(answer.hit.is_some() || answer.occluded);
            tally.rays += 1;
        } else {
            compare(&mut tally, dag, question, answer, scene.name);
        }
        if tally.other == 1 {
            tally.fail(|| format!("{question:?}: {answer:?}"));
        }
    }
    // Words that nobody checked: whatever comes of them, it comes.
    let words: Vec<u32> = (0..4096).map(|_| rng.bits() as u32).collect();
    for depth in [2, 5, 9] {
        let mut uniform = [0; wgsl::SCENE_WORDS];
        (uniform[1], uniform[2]) = (depth, 24);
        let questions: Vec<Question> = (0..4096)
            .map(|_| {
                let origin = [(); 3].map(|()| rng.uniform(-9.0, 600.0) as f32);
                Question::new(origin, rng.direction().map(|x| x as f32))
            })
            .collect();
        assert_eq!(ask(gpu, &pipeline, &gpu.scene(&words, &uniform), &questions).len(), questions.len());
    }
    let Tally { rays, hits, other, .. } = tally;
    println!("numbers that are odd: {rays} rays, {hits} hits, {other} wrong");
    if let Some(first) = &tally.first {
        println!("  first: {first}");
    }
    other
}

/// Holds an answer against the exact tracer's.
fn compare(tally: &mut Tally, dag: Dag<'_>, question: &Question, answer: &Answer, scene: &str) {
    let truth = Tracer::new(dag).trace(Arithmetic::Exact, &question.query());
    tally.rays += 1;
    tally.hits += u64::from(truth.is_some());
    let place = |hit: &Hit| (hit.voxel.decode(), hit.from.map(Morton::decode), hit.face);
    let same = truth.as_ref().map(place) == answer.hit.map(|hit| (hit.voxel, hit.before, hit.face));
    if !same || answer.occluded != answer.hit.is_some() {
        tally.other += 1;
        tally.fail(|| format!("{scene}: {question:?}:\n    {answer:?}\n    {truth:?}"));
    }
    if let (Some(truth), Some(hit), true) = (truth, answer.hit, same)
        && truth.t != 0.0
    {
        let error = (f64::from(hit.t) - truth.t).abs() / truth.t * f64::from(1u32 << 24);
        tally.t_error = tally.t_error.max(error);
        let expected = normal(&Tracer::new(dag), Single(0), &truth, question.query().dir, NormalKind::Plane2);
        // The side of a plane that the ray runs along may hang on a component that a card takes for 0.
        let whole = !question.dir.iter().any(|x| x.is_subnormal());
        if whole && tally.angles.add(expected.direction, hit.normal) > LARGE {
            tally.fail(|| format!("{scene}: {question:?}:\n    {hit:?}\n    {expected:?}"));
        }
    }
}
