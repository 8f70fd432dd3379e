//! Rays on the adapter against the exact tracer, which must be equalled, and against the oracle, by the three inequalities
//! of hard-cases 4.1.

use voxdag::materials::Single;
use voxdag::normal::{NormalKind, normal};
use voxdag::trace::{Arithmetic, Face, Hit, Query, Tracer};
use voxdag::{Dag, Morton, math, wgsl};
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

    /// The ray, its numbers rounded to f32; `None` if nothing is left of its direction.
    fn of(ray: &Ray) -> Option<Question> {
        let [origin, dir] = [ray.origin, ray.dir].map(|v| v.map(|x| x as f32));
        let usable = dir != [0.0; 3] && origin.iter().chain(&dir).all(|x| x.is_finite());
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

/// llvmpipe ends every loop of a shader once eight neighbours have taken 65,535 turns of loops; longer rays are left out.
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

/// Angles between normals, in degrees.
#[derive(Default)]
pub struct Angles {
    most: f64,
    sum: f64,
    count: u64,
    /// Of more than 0.1 degrees.
    large: u64,
}

impl Angles {
    pub fn add(&mut self, a: [f32; 3], b: [f32; 3]) {
        let [a, b] = [a, b].map(|v| v.map(f64::from));
        let angle = math::sqrt(math::dot(math::cross(a, b), math::cross(a, b))).atan2(math::dot(a, b)).to_degrees();
        self.most = self.most.max(angle);
        self.sum += angle;
        self.count += 1;
        self.large += u64::from(!(angle <= 0.1));
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

/// The head of the table of [`check`].
pub const HEAD: &str = "| depth | rays | traced | hits | left out | not the exact tracer's | off in t, 2^-24 | normals off, degrees: most | mean \
     | of over 0.1 | judged by the oracle | A | B | C |
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
                    for k in 0..3 {
                        tally.broken[k] += u64::from(broken[k]);
                    }
                    if broken != [false; 3] {
                        tally.fail(|| format!("{}: {question:?}: {answer:?}, broken: {broken:?}", scene.name));
                    }
                }
            }
        }
        let Tally { rays, hits, left_out, judged, broken: [a, b, c], other, t_error, ref angles, .. } = tally;
        println!(
            "| {depth} | {name} | {rays} | {hits} | {left_out} | {other} | {t_error:.1} | {angles} | {judged} | {a} | {b} | {c} |"
        );
        if let Some(first) = &tally.first {
            println!("  first: {first}");
        }
        wrong += other + a + b + c;
    }
    wrong
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
        tally.angles.add(expected.direction, hit.normal);
    }
}
