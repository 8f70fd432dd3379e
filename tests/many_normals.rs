//! Normals at many hits are those one by one, bit for bit: all kinds, all vectors that the machine has, any hits in any
//! order.

use std::collections::HashSet;
use std::mem::discriminant;
use voxdag::materials::Materials;
use voxdag::normal::{Confidence, Normal, NormalKind, normal, normals};
use voxdag::simd::Level;
use voxdag::trace::{Face, Hit, TopBuf, Tracer};
use voxdag::{Dag, Morton};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::Implicit;

const NONE: Normal = Normal { direction: [9.0; 3], confidence: Confidence::Face };

/// Stored normals at every third voxel, some of them none to speak of.
#[derive(Clone, Copy)]
struct Some3;

impl Materials for Some3 {
    fn id(&self, _: Morton) -> u16 {
        0
    }

    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        voxel.0.is_multiple_of(3).then(|| [voxel.0 % 5, voxel.0 / 5 % 5, voxel.0 / 25 % 5].map(|x| x as f32 - 2.0))
    }
}

/// A hit at a voxel, through any face and along any direction, also such as are none.
fn hit(random: &mut Rng, voxel: [u32; 3]) -> (Hit, [f64; 3]) {
    let voxel = Morton::encode(voxel).unwrap();
    let length = random.pick(&[1.0, 1.0, 1.0, 1e-310, 1e300, 0.0, f64::NAN, f64::INFINITY]);
    let mut dir = random.direction().map(|x| x * length);
    if random.below(4) == 0 {
        dir[random.below(3) as usize] = 0.0;
    }
    (Hit { voxel, from: None, t: 0.0, level: 0, face: random.pick(&Face::ALL) }, dir)
}

fn bits(n: &Normal) -> ([u32; 3], String) {
    (n.direction.map(f32::to_bits), format!("{:?}", n.confidence))
}

fn levels() -> impl Iterator<Item = Option<Level>> {
    [None].into_iter().chain(Level::all().map(Some))
}

/// Asks for all normals at once, and one by one; gives how they were found.
fn check(words: &[u32], hits: &[(Hit, [f64; 3])], context: &str) -> HashSet<std::mem::Discriminant<Confidence>> {
    let dag = Dag::new(words).unwrap();
    let (hits, dirs): (Vec<_>, Vec<_>) = hits.iter().copied().unzip();
    let top = TopBuf::new(&dag, 3).unwrap();
    let mut ways = HashSet::new();
    for tracer in [Tracer::new(dag), Tracer::with_top(dag, top.as_top()).unwrap()] {
        for kind in NormalKind::ALL {
            let alone: Vec<_> = hits.iter().zip(&dirs).map(|(hit, d)| normal(&tracer, Some3, hit, *d, kind)).collect();
            ways.extend(alone.iter().map(|n| discriminant(&n.confidence)));
            for level in levels() {
                let mut many = vec![NONE; hits.len()];
                normals(level, &tracer, Some3, &hits, &dirs, kind, &mut many);
                for (i, (many, alone)) in many.iter().zip(&alone).enumerate() {
                    let (hit, dir, name) = (&hits[i], dirs[i], level.map(Level::name));
                    assert_eq!(
                        bits(many),
                        bits(alone),
                        "{context}: {kind:?}, {name:?}, number {i}, {hit:?} along {dir:?}"
                    );
                }
            }
        }
    }
    ways
}

#[test]
fn on_surfaces() {
    const SEED: u64 = 1;
    let mut random = Rng::new(SEED);
    let shapes = [
        Implicit::Shell { centre: [63, 66, 59], inner: 48, outer: 50 },
        Implicit::Shell { centre: [60, 63, 71], inner: 0, outer: 40 },
        Implicit::Shell { centre: [0, 0, 0], inner: 90, outer: 94 },
        Implicit::Wall { axis: 1, lo: 17, hi: 18 },
        Implicit::Wall { axis: 2, lo: 40, hi: 64 },
        Implicit::Diagonal { lo: 90, hi: 92 },
        Implicit::Dust { at: [1, 3, 0] },
    ];
    for shape in shapes {
        // In the order of the Morton curve, and in none.
        let mut voxels = shape.voxels(6);
        for _ in 0..2 {
            let start = random.below(voxels.len() as u64 - 400) as usize;
            let hits: Vec<_> = voxels[start..start + 400].iter().map(|&v| hit(&mut random, v)).collect();
            check(&shape.words(6), &hits, &format!("seed {SEED}, {shape:?}"));
            random.shuffle(&mut voxels);
        }
    }
}

#[test]
fn on_a_torus_in_the_order_of_a_picture() {
    const SEED: u64 = 2;
    let mut random = Rng::new(SEED);
    let inside = |v: [u32; 3]| {
        let [x, y, z] = v.map(|c| f64::from(c) - 31.3);
        let ring = (x * x + y * y).sqrt() - 20.0;
        ring * ring + z * z <= 64.0
    };
    let cube = (0..64u32).flat_map(|z| (0..64).flat_map(move |y| (0..64).map(move |x| [x, y, z])));
    let words = VoxelSet::new(cube.filter(|&v| inside(v))).words(6);
    // Seen along z, row by row: what is first.
    let pixels = (0..64).flat_map(|y| (0..64).map(move |x| [x, y]));
    let seen = pixels.filter_map(|[x, y]| (0..64).map(|z| [x, y, z]).find(|&v| inside(v)));
    let hits: Vec<_> = seen.map(|v| hit(&mut random, v)).collect();
    assert!(hits.len() > 1500);
    check(&words, &hits, &format!("seed {SEED}"));
}

#[test]
fn in_cubes_of_every_size() {
    const SEED: u64 = 3;
    let mut random = Rng::new(SEED);
    let mut ways = HashSet::new();
    for (round, depth) in (0..36).map(|round| (round, round % 6)) {
        // Of any density; beside the cube and beyond there is nothing, and a normal all the same.
        let (side, density) = (1u64 << depth, 1 + random.below(8));
        let filled: Vec<[u32; 3]> = (0..side.pow(3))
            .filter(|_| random.below(8) < density)
            .map(|i| [i % side, i / side % side, i / side / side].map(|x| x as u32))
            .collect();
        let around = side + 5;
        let hits: Vec<_> = (0..150)
            .map(|_| {
                let voxel = [0, 1, 2].map(|_| random.below(around) as u32);
                hit(&mut random, voxel)
            })
            .collect();
        let words = VoxelSet::new(filled).words(depth);
        ways.extend(check(&words, &hits, &format!("seed {SEED}, round {round}, depth {depth}")));
    }
    assert_eq!(ways.len(), 6, "face, stored, gradient, line, plane, regression: not all of them were met");
}

#[test]
fn at_the_far_corners_of_the_largest_cube() {
    const SEED: u64 = 4;
    let mut random = Rng::new(SEED);
    let last = (1u32 << 21) - 1;
    for shape in
        [Implicit::Wall { axis: 0, lo: 0, hi: 2 }, Implicit::Diagonal { lo: 0, hi: 9 }, Implicit::Dust { at: [3; 3] }]
    {
        let hits: Vec<_> = (0..200)
            .map(|_| {
                let voxel = [0, 1, 2].map(|_| random.pick(&[0, last, last, 1 << 20]) ^ random.below(8) as u32);
                hit(&mut random, voxel)
            })
            .collect();
        check(&shape.words(21), &hits, &format!("seed {SEED}, {shape:?}"));
    }
}

#[test]
fn as_far_as_all_slices_reach() {
    const SEED: u64 = 5;
    let mut random = Rng::new(SEED);
    let shape = Implicit::Shell { centre: [63, 66, 59], inner: 48, outer: 50 };
    let words = shape.words(6);
    let tracer = Tracer::new(Dag::new(&words).unwrap());
    let hits: Vec<_> = shape.voxels(6)[..80].iter().map(|&v| hit(&mut random, v)).collect();
    let (hits, dirs): (Vec<_>, Vec<_>) = hits.into_iter().unzip();
    let kind = NormalKind::Plane2;
    let alone: Vec<_> = hits.iter().zip(&dirs).map(|(hit, dir)| normal(&tracer, Some3, hit, *dir, kind)).collect();
    for level in levels() {
        for [a, b, c] in [[0, 80, 80], [1, 1, 1], [31, 32, 33], [33, 32, 31], [80, 40, 70], [70, 80, 40], [80, 80, 80]]
        {
            let mut out = [NONE; 80];
            normals(level, &tracer, Some3, &hits[..a], &dirs[..b], kind, &mut out[..c]);
            let reached = a.min(b).min(c);
            assert_eq!(out[..reached], alone[..reached], "{a} {b} {c}");
            assert!(out[reached..].iter().all(|n| *n == NONE), "{a} {b} {c}");
        }
    }
}
