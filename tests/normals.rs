//! Laws of normals: one test per row N1 to N14 of the hard cases, accuracy on known surfaces, and an independent method
//! (sums in f64 voxel by voxel, eigenvectors by Jacobi rotations).

use std::collections::HashSet;
use voxdag::camera::Camera;
use voxdag::materials::{Materials, Single};
use voxdag::math::{add_scaled, cross, dot, normalize, sub};
use voxdag::normal::{Confidence, Normal, NormalKind, normal};
use voxdag::trace::{Face, Hit, Query, TopBuf, Tracer};
use voxdag::{Dag, Morton};
use voxdag_oracle::eigen::jacobi;
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;
use voxdag_oracle::textbook::ernerfeldt;

type Voxel = [i32; 3];

const PLANES: [(NormalKind, i32); 3] = [(NormalKind::Plane1, 1), (NormalKind::Plane2, 2), (NormalKind::Plane3, 3)];
const REGRESSIONS: [(NormalKind, i32); 2] = [(NormalKind::Ernerfeldt1, 1), (NormalKind::Ernerfeldt2, 2)];
const FACES: [Face; 6] = [Face::NegX, Face::PosX, Face::NegY, Face::PosY, Face::NegZ, Face::PosZ];

/// Where neighbourhoods are put: depth of a cube and a voxel in it. A cube of depth 3 cuts off what lies outside, but not
/// what the widest window around the voxel sees.
const PLACES: [(u8, i32); 5] = [(5, 16), (3, 4), (10, 1000), (16, 65_000), (21, 2_000_000)];

/// Voxels relative to a place in a cube, at each of the places.
struct Set([Vec<u32>; 5]);

impl Set {
    fn new(voxels: impl IntoIterator<Item = Voxel>) -> Set {
        let voxels: Vec<_> = voxels.into_iter().collect();
        Set(PLACES.map(|(depth, at)| {
            let inside = |v: &Voxel| v.iter().all(|c| (0..1 << depth).contains(&(c + at)));
            Set::at([at; 3], depth, voxels.iter().copied().filter(inside))
        }))
    }

    /// Words of the voxels relative to a voxel of a cube.
    fn at(center: Voxel, depth: u8, voxels: impl IntoIterator<Item = Voxel>) -> Vec<u32> {
        let voxels = voxels.into_iter().map(|v| moved(v, center).map(|c| c as u32));
        VoxelSet::new(voxels).words(depth)
    }

    /// In the cube of depth 5, relative to [16, 16, 16].
    fn dag(&self) -> Dag<'_> {
        dag(&self.0[0])
    }

    fn normal(&self, voxel: Voxel, kind: NormalKind, dir: [f64; 3]) -> Normal {
        self.through(voxel, kind, dir, face_against(dir))
    }

    /// The normal at a voxel: the same at each place.
    fn through(&self, voxel: Voxel, kind: NormalKind, dir: [f64; 3], face: Face) -> Normal {
        let all = [0, 1, 2, 3, 4].map(|i| through(dag(&self.0[i]), moved(voxel, [PLACES[i].1; 3]), kind, dir, face));
        assert!(all.iter().all(|n| *n == all[0]), "{voxel:?}, {kind:?}: {all:?} at {PLACES:?}");
        all[0]
    }
}

fn dag(words: &[u32]) -> Dag<'_> {
    Dag::new(words).unwrap()
}

fn moved(v: Voxel, by: Voxel) -> Voxel {
    [v[0] + by[0], v[1] + by[1], v[2] + by[2]]
}

/// The normal at a voxel, seen along `dir` through the face that looks at the viewer most.
fn at(dag: Dag<'_>, voxel: Voxel, kind: NormalKind, dir: [f64; 3]) -> Normal {
    through(dag, voxel, kind, dir, face_against(dir))
}

fn through(dag: Dag<'_>, voxel: Voxel, kind: NormalKind, dir: [f64; 3], face: Face) -> Normal {
    let voxel = Morton::encode(voxel.map(|c| c as u32)).unwrap();
    let hit = Hit { voxel, from: None, t: 0.0, level: 0, face };
    let n = normal(&Tracer::new(dag), Single(0), &hit, dir, kind);
    assert_unit(n.direction);
    n
}

fn face_against(dir: [f64; 3]) -> Face {
    *FACES.iter().min_by(|a, b| facing(**a, dir).total_cmp(&facing(**b, dir))).unwrap()
}

fn facing(face: Face, dir: [f64; 3]) -> f64 {
    dot(face.normal().map(f64::from), dir)
}

/// Angle between two vectors in degrees, accurate near 0 too.
fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    let c = cross(a, b);
    libm::atan2(dot(c, c).sqrt(), dot(a, b)).to_degrees()
}

/// A random unit vector.
fn unit(random: &mut Rng) -> [f64; 3] {
    normalize(random.direction()).unwrap()
}

fn assert_unit(n: [f32; 3]) {
    let length2 = n.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>();
    assert!((length2 - 1.0).abs() < 1e-6, "{n:?} is no unit vector");
}

fn boxed(min: Voxel, max: Voxel) -> impl Iterator<Item = Voxel> {
    (min[2]..=max[2]).flat_map(move |z| (min[1]..=max[1]).flat_map(move |y| (min[0]..=max[0]).map(move |x| [x, y, z])))
}

fn is_plane(n: &Normal) -> bool {
    matches!(n.confidence, Confidence::Plane { .. })
}

fn assert_near(n: &Normal, expected: [f64; 3], tolerance: f64) {
    let angle = degrees(n.direction.map(f64::from), expected);
    assert!(angle <= tolerance, "{n:?}: {angle} degrees from {expected:?}");
}

const BISECTOR: f64 = std::f64::consts::FRAC_1_SQRT_2;

#[test]
fn n01_isolated_voxel() {
    let set = Set::new([[0, 0, 0]]);
    for face in FACES {
        let dir = face.normal().map(|x| -f64::from(x) + 0.25);
        for (kind, _) in PLANES {
            let n = set.through([0; 3], kind, dir, face);
            assert_eq!((n.direction, n.confidence), (face.normal(), Confidence::Face));
        }
    }
}

#[test]
fn n02_line() {
    let set = Set::new([[0, 0, 0], [1, 0, 0]]);
    for (kind, _) in PLANES {
        // The view direction without its part along the line.
        let n = set.normal([0, 0, 0], kind, [0.5, 0.3, -0.4]);
        assert_eq!(n.confidence, Confidence::Line);
        assert_near(&n, [0.0, -0.6, 0.8], 1e-4);
        assert_eq!(n.direction[0], 0.0);
        // Along the line there is none: the face.
        let n = set.normal([0, 0, 0], kind, [2.0, 0.0, 0.0]);
        assert_eq!((n.direction, n.confidence), ([-1.0, 0.0, 0.0], Confidence::Face));
    }
    let diagonal = Set::new((-3..=3).map(|i| [i, i, -i]));
    let n = diagonal.normal([0; 3], NormalKind::Plane3, [0.1, 0.7, -0.7]);
    assert_eq!(n.confidence, Confidence::Line);
    assert!(dot(n.direction.map(f64::from), [1.0, 1.0, -1.0]).abs() < 1e-6);
    assert_eq!(diagonal.normal([0; 3], NormalKind::Plane3, [1.0, 1.0, -1.0]).confidence, Confidence::Face);
}

#[test]
fn n03_full_block_and_checkerboard() {
    let block = Set::new(boxed([-5; 3], [5; 3]));
    let checkers = Set::new(boxed([-5; 3], [5; 3]).filter(|v| v.iter().sum::<i32>() % 2 == 0));
    for set in [block, checkers] {
        for (kind, _) in PLANES {
            let n = set.normal([0; 3], kind, [0.3, 0.2, 0.9]);
            assert_eq!((n.direction, n.confidence), ([0.0, 0.0, -1.0], Confidence::Face));
        }
    }
}

#[test]
fn n04_flat_sheet() {
    let set = Set::new(boxed([-5, -5, 0], [5, 5, 0]));
    for (kind, _) in PLANES {
        for side in [1.0, -1.0] {
            let n = set.normal([0; 3], kind, [0.6, 0.5, -0.1 * side]);
            assert_eq!((n.direction, n.confidence), ([0.0, 0.0, side as f32], Confidence::Plane { ratio: 0.0 }));
        }
    }
}

#[test]
fn n05_wall_two_thick() {
    let set = Set::new(boxed([-5, -5, -1], [5, 5, 0]));
    for (kind, _) in PLANES {
        for (z, side) in [(0, 1.0), (-1, -1.0)] {
            let n = set.normal([0, 0, z], kind, [0.6, 0.5, -0.1 * side]);
            assert!(is_plane(&n));
            assert_eq!(n.direction, [0.0, 0.0, side as f32]);
        }
    }
}

#[test]
fn n06_two_sheets_with_a_gap() {
    let set = Set::new(boxed([-5, -5, -2], [5, 5, 0]).filter(|v| v[2] != -1));
    for (kind, _) in &PLANES[1..] {
        let n = set.normal([0; 3], *kind, [0.6, 0.5, -0.1]);
        assert!(is_plane(&n));
        assert_eq!(n.direction, [0.0, 0.0, 1.0]);
    }
}

#[test]
fn n07_half_space() {
    let set = Set::new(boxed([-5; 3], [5, 5, 0]));
    for (kind, r) in PLANES {
        let n = set.normal([0; 3], kind, [0.6, 0.5, -0.1]);
        assert_eq!(n.direction, [0.0, 0.0, 1.0]);
        // Variances of r + 1 layers and of 2 r + 1.
        let variance = |n: i32| f64::from(n * n - 1);
        let expected = (variance(r + 1) / variance(2 * r + 1)) as f32;
        let Confidence::Plane { ratio } = n.confidence else { panic!("{n:?}") };
        assert!((ratio - expected).abs() < 1e-6, "{ratio} for {expected}");
    }
}

#[test]
fn n08_solid_cube_edge() {
    let set = Set::new(boxed([-6; 3], [0, 6, 0]));
    for (kind, _) in PLANES {
        for dir in [[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [-0.5, 0.1, -0.6]] {
            let n = set.normal([0; 3], kind, dir);
            assert_eq!(n.confidence, Confidence::Gradient);
            assert_eq!(n.direction, [BISECTOR as f32, 0.0, BISECTOR as f32]);
        }
    }
}

#[test]
fn n09_solid_cube_corner() {
    let set = Set::new(boxed([-6; 3], [0; 3]));
    for (kind, _) in PLANES {
        let n = set.normal([0; 3], kind, [-0.2, -0.3, -0.9]);
        assert_eq!(n.confidence, Confidence::Gradient);
        assert!(n.direction.iter().all(|&x| x == n.direction[0] && x > 0.57));
    }
}

#[test]
fn n10_shell_edge_and_corner() {
    let edge = Set::new(boxed([-6; 3], [0, 6, 0]).filter(|v| v[0] == 0 || v[2] == 0));
    let corner = Set::new(boxed([-6; 3], [0; 3]).filter(|v| v.contains(&0)));
    for (kind, _) in PLANES {
        assert_near(&edge.normal([0; 3], kind, [-0.5, 0.1, -0.6]), [BISECTOR, 0.0, BISECTOR], 1e-4);
        assert_near(&corner.normal([0; 3], kind, [-0.5, -0.4, -0.6]), [1.0; 3], 1e-4);
    }
}

/// The 48 symmetries of the cube: permutations of the axes with signs.
fn symmetries() -> Vec<([usize; 3], [i32; 3])> {
    let axes = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    axes.iter().flat_map(|&a| (0..8).map(move |s| (a, [0, 1, 2].map(|i| 1 - 2 * (s >> i & 1))))).collect()
}

/// Random voxels around 0 within 3, which is filled, of one of several densities, or a slab, or something symmetric.
fn neighbourhood(random: &mut Rng) -> Vec<Voxel> {
    let (shape, density, n) = (random.below(3), 1 + random.below(8), unit(random));
    boxed([-3; 3], [3; 3])
        .filter(|v| {
            let h = dot(v.map(f64::from), n);
            let kept = match shape {
                0 => random.below(8) < density,
                1 => h.abs() < 0.9 && random.below(8) != 0,
                _ => h <= 0.0,
            };
            kept || *v == [0; 3]
        })
        .collect()
}

#[test]
fn n11_mirror_images() {
    const SEED: u64 = 11;
    let mut random = Rng::new(SEED);
    let mut branches = HashSet::new();
    for round in 0..120 {
        let voxels = neighbourhood(&mut random);
        let dir = unit(&mut random);
        let face = face_against(dir);
        let kinds = [NormalKind::Gradient, NormalKind::Plane1, NormalKind::Plane2, NormalKind::Plane3];
        let plain = Set::new(voxels.iter().copied());
        let plain = kinds.map(|kind| through(plain.dag(), [16; 3], kind, dir, face));
        for (axes, signs) in symmetries() {
            let turned = |v: [f64; 3]| [0, 1, 2].map(|i| v[axes[i]] * f64::from(signs[i]));
            let image = Set::new(voxels.iter().map(|v| [0, 1, 2].map(|i| v[axes[i]] * signs[i])));
            for (kind, n) in kinds.iter().zip(&plain) {
                let m = through(image.dag(), [16; 3], *kind, turned(dir), face_against(turned(dir)));
                let expected = turned(n.direction.map(f64::from));
                let context = format!("seed {SEED}, round {round}, {kind:?}, {axes:?} {signs:?}: {n:?} became {m:?}");
                assert_eq!(m.confidence, n.confidence, "{context}");
                branches.insert(std::mem::discriminant(&m.confidence));
                for i in 0..3 {
                    assert!((f64::from(m.direction[i]) - expected[i]).abs() < 1e-6, "{context}");
                }
            }
        }
    }
    assert!(branches.len() >= 3, "the neighbourhoods are too alike");
}

#[test]
fn n12_absolute_coordinates() {
    const SEED: u64 = 12;
    let mut random = Rng::new(SEED);
    for round in 0..40 {
        let voxels = neighbourhood(&mut random);
        let dir = unit(&mut random);
        let near = Set::new(voxels.iter().copied());
        let far = [(1 << 21) - 4, 3 + random.below(1 << 20) as i32, 1 << 20];
        let set = Set::at(far, 21, voxels);
        for (kind, _) in PLANES {
            assert_eq!(
                at(dag(&set), far, kind, dir),
                at(near.dag(), [16; 3], kind, dir),
                "seed {SEED}, round {round}, {kind:?} at {far:?}"
            );
        }
    }
}

#[test]
fn n13_grid_boundary() {
    // A sheet that the cube cuts off does not tilt towards the border, on whichever side of the cube it lies.
    for depth in [2, 3, 4] {
        let last = (1 << depth) - 1;
        for height in [0, last] {
            let sheet = Set::at([0; 3], depth, boxed([0, 0, height], [last, last, height]));
            for (x, y) in [(0, 0), (last, 0), (last, last), (0, last / 2)] {
                for (kind, _) in PLANES {
                    let n = at(dag(&sheet), [x, y, height], kind, [0.1, 0.1, -0.3]);
                    assert_eq!((n.direction, is_plane(&n)), ([0.0, 0.0, 1.0], true), "{kind:?} at {x} {y} {height}");
                }
            }
        }
    }
    for depth in [10, 16, 21] {
        let last = (1 << depth) - 1;
        for (i, kind) in (0..24).flat_map(|i| PLANES.map(|(kind, _)| (i, kind))) {
            // The corner of a sheet in one of the six sides of the cube.
            let (axis, [a, b, c]) = (i / 8, [1, 2, 4].map(|bit| if i & bit == 0 { 0 } else { last }));
            let place = |u: i32, v: i32| {
                let mut p = [c; 3];
                p[(axis + 1) % 3] = (a - u).abs();
                p[(axis + 2) % 3] = (b - v).abs();
                p
            };
            let sheet = Set::at([0; 3], depth, (0..64).map(|k| place(k % 8, k / 8)));
            let mut dir = [0.1; 3];
            dir[axis] = -0.3;
            let n = at(dag(&sheet), place(0, 0), kind, dir);
            let up: [f32; 3] = [0, 1, 2].map(|i| if i == axis { 1.0 } else { 0.0 });
            assert_eq!((n.direction, is_plane(&n)), (up, true), "{kind:?}, depth {depth}, corner {i}");
        }
    }
    // Cubes of 1 and 2 voxels a side are one brick.
    let single = Set::at([0; 3], 0, [[0; 3]]);
    assert_eq!(at(dag(&single), [0; 3], NormalKind::Plane2, [0.0, -1.0, 0.0]).direction, [0.0, 1.0, 0.0]);
    let sheet = Set::at([0; 3], 1, boxed([0; 3], [1, 1, 0]));
    assert_eq!(at(dag(&sheet), [0; 3], NormalKind::Plane3, [0.5, 0.0, 0.4]).direction, [0.0, 0.0, -1.0]);
    // Nothing aliases to the far side of the cube.
    let ends = Set::at([0; 3], 4, [[0, 0, 0], [15, 0, 0], [15, 15, 0], [0, 0, 15]]);
    assert_eq!(at(dag(&ends), [0; 3], NormalKind::Plane3, [0.5, 0.0, 0.4]).confidence, Confidence::Face);
}

#[test]
fn n14_side() {
    let sheet = Set::new(boxed([-5, -5, 0], [5, 5, 0]));
    for kind in [NormalKind::Plane1, NormalKind::Plane2, NormalKind::Plane3] {
        // n.d = 0: the face decides, on either side.
        for (face, z) in [(Face::PosZ, 1.0), (Face::NegZ, -1.0)] {
            assert_eq!(sheet.through([0; 3], kind, [1.0, 0.0, 0.0], face).direction, [0.0, 0.0, z]);
        }
        // n.face = 0 too: the face itself.
        let n = sheet.through([0; 3], kind, [1.0, 0.0, 0.0], Face::NegX);
        assert_eq!((n.direction, n.confidence), ([-1.0, 0.0, 0.0], Confidence::Face));
        // A ray that starts inside comes through the face against its largest component.
        let n = sheet.through([0; 3], kind, [0.0, 1.0, 0.0], Face::Inside);
        assert_eq!(n.direction, [0.0, -1.0, 0.0]);
        // No direction at all is no reason for NaN.
        for dir in [[0.0; 3], [f64::NAN; 3], [f64::INFINITY, 0.0, 0.0]] {
            sheet.through([0; 3], kind, dir, Face::Inside);
            sheet.through([0; 3], kind, dir, Face::PosZ);
        }
    }
}

/// Share in percent of the hits in a picture of 200 x 200 pixels whose normal points into the surface.
fn turned_inside_out(
    voxels: impl Iterator<Item = Voxel>,
    camera: &Camera,
    truth: impl Fn([f64; 3]) -> [f64; 3],
) -> f64 {
    let set = Set::at([0; 3], 6, voxels);
    let rays = camera.rays(200, 200).unwrap();
    let (mut wrong, mut all) = (0, 0);
    for (x, y) in (0..200).flat_map(|y| (0..200).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5))) {
        let dir = rays.direction(x, y);
        if let Some(hit) = dag(&set).trace(&Query::new(camera.eye, dir)) {
            let n = normal(&Tracer::new(dag(&set)), Single(0), &hit, dir, NormalKind::Plane2);
            let out = truth(add_scaled(camera.eye, dir, hit.t));
            all += u32::from(is_plane(&n));
            wrong += u32::from(is_plane(&n) && dot(n.direction.map(f64::from), out) < 0.0);
        }
    }
    assert!(all > 4000, "{all} planes are too few");
    100.0 * f64::from(wrong) / f64::from(all)
}

#[test]
fn normals_point_out_of_the_surface_at_horizons_and_on_bumps() {
    let center = [32.2, 31.9, 32.1];
    let from_center = |p: [f64; 3]| sub(p, center);
    let middle = |v: Voxel| v.map(|c| f64::from(c) + 0.5);
    let length = |p: [f64; 3]| dot(p, p).sqrt();
    for radius in [12.0, 24.0] {
        let camera = Camera { eye: [90.0, 66.0, 102.0], target: center, up: [0.0, 1.0, 0.0], fov_y: 1.5 * radius };
        let shell = boxed([0; 3], [63; 3]).filter(|&v| (length(from_center(middle(v))) - radius).abs() <= 0.5);
        let solid = boxed([0; 3], [63; 3]).filter(|&v| length(from_center(middle(v))) <= radius);
        assert_eq!(turned_inside_out(shell, &camera, from_center), 0.0, "shell of radius {radius}");
        assert_eq!(turned_inside_out(solid, &camera, from_center), 0.0, "ball of radius {radius}");
    }
    let inside = Camera { eye: [32.0, 32.0, 55.0], target: center, up: [0.0, 1.0, 0.0], fov_y: 100.0 };
    let shell = boxed([0; 3], [63; 3]).filter(|&v| (length(from_center(middle(v))) - 28.0).abs() <= 0.5);
    assert_eq!(turned_inside_out(shell, &inside, |p| sub(center, p)), 0.0, "shell from inside");

    // A floor with bumps, seen at a low angle from above it, so that its rim is out of sight.
    const SEED: u64 = 18;
    let mut random = Rng::new(SEED);
    for percent in [5, 20] {
        let bumps: Vec<Voxel> = boxed([1, 31, 1], [62, 31, 60]).filter(|_| random.below(100) < percent).collect();
        let floor = boxed([1, 30, 1], [62, 30, 60]).chain(bumps);
        let camera = Camera { eye: [20.0, 38.0, 58.0], target: [32.0, 30.0, 28.0], up: [0.0, 1.0, 0.0], fov_y: 40.0 };
        assert_eq!(turned_inside_out(floor, &camera, |_| [0.0, 1.0, 0.0]), 0.0, "seed {SEED}, {percent} % bumps");
    }
}

#[test]
fn every_answer_is_a_unit_vector() {
    const SEED: u64 = 15;
    let mut random = Rng::new(SEED);
    for _ in 0..60 {
        let set = Set::new(neighbourhood(&mut random));
        for kind in [NormalKind::Face, NormalKind::Stored, NormalKind::Gradient, NormalKind::Plane2] {
            for voxel in [[16; 3], [0, 31, 7], [18, 15, 16], [40, 3, 3], [(1 << 21) - 1; 3]] {
                // `at` asserts it.
                for length in [1.0, 1e-200, 1e200] {
                    at(set.dag(), voxel, kind, unit(&mut random).map(|x| x * length));
                }
            }
        }
    }
}

#[test]
fn top_grids_change_no_normal() {
    let mut random = Rng::new(41);
    // A dense blob that reaches the borders of the cube, so that windows are cut.
    let blob: Vec<Voxel> = (0..4000).map(|_| std::array::from_fn(|_| random.below(24) as i32)).collect();
    let words = Set::at([0; 3], 5, blob.iter().copied());
    let dag = dag(&words);
    for bits in 0..=3 {
        let top = TopBuf::new(&dag, bits).unwrap();
        let tracer = Tracer::with_top(dag, top.as_top()).unwrap();
        // Filled voxels, empty ones, and those beside and beyond the cube.
        for voxel in blob.iter().copied().take(300).chain([[31, 0, 31], [32, 5, 5], [63; 3], [25, 30, 2]]) {
            let voxel = Morton::encode(voxel.map(|c| c as u32)).unwrap();
            let hit = Hit { voxel, from: None, t: 0.0, level: 0, face: Face::NegY };
            let dir = unit(&mut random);
            for kind in [NormalKind::Gradient, NormalKind::Plane1, NormalKind::Plane2, NormalKind::Plane3] {
                let by_top = normal(&tracer, Single(0), &hit, dir, kind);
                assert_eq!(
                    by_top,
                    normal(&Tracer::new(dag), Single(0), &hit, dir, kind),
                    "2^{bits} cells, {voxel:?}, {kind:?}"
                );
            }
        }
    }
}

#[test]
fn stored_normals_come_first_where_there_are_any() {
    #[derive(Clone, Copy)]
    struct Kept(Option<[f32; 3]>);
    impl Materials for Kept {
        fn id(&self, _: Morton) -> u16 {
            0
        }
        fn normal(&self, _: Morton) -> Option<[f32; 3]> {
            self.0
        }
    }
    let sheet = Set::new(boxed([-5, -5, 0], [5, 5, 0]));
    let hit = Hit { voxel: Morton::encode([16; 3]).unwrap(), from: None, t: 0.0, level: 0, face: Face::PosZ };
    let ask = |kept, kind| normal(&Tracer::new(sheet.dag()), Kept(kept), &hit, [0.1, 0.1, -1.0], kind);
    let n = ask(Some([3.0, 0.0, 4.0]), NormalKind::Stored);
    assert_eq!((n.direction, n.confidence), ([0.6, 0.0, 0.8], Confidence::Stored));
    // Seen from behind it is turned; other kinds do not ask for it; without one, or with none to speak of, a plane.
    assert_eq!(ask(Some([0.0, 0.0, -2.0]), NormalKind::Stored).direction, [0.0, 0.0, 1.0]);
    let plane = ask(None, NormalKind::Plane2);
    assert!(is_plane(&plane));
    assert_eq!(ask(Some([1.0, 0.0, 0.0]), NormalKind::Plane2), plane);
    for none in [None, Some([0.0; 3]), Some([f32::NAN, 0.0, 1.0]), Some([f32::INFINITY, 0.0, 0.0])] {
        assert_eq!(ask(none, NormalKind::Stored), plane);
    }
}

#[test]
fn planes_agree_with_jacobi_voxel_by_voxel() {
    const SEED: u64 = 16;
    let mut random = Rng::new(SEED);
    let (mut planes, mut solids) = (0, 0);
    for round in 0..400 {
        // Somewhere in a small cube, the borders included.
        let center: Voxel = [0, 1, 2].map(|_| random.below(32) as i32);
        let voxels: Vec<Voxel> = neighbourhood(&mut random)
            .into_iter()
            .map(|v| moved(v, center))
            .filter(|v| v.iter().all(|c| (0..32).contains(c)))
            .collect();
        let set = Set::at([0; 3], 5, voxels.iter().copied());
        let dir = unit(&mut random);
        for (kind, r) in PLANES {
            let window: Vec<[f64; 3]> = voxels
                .iter()
                .filter(|v| (0..3).all(|i| (v[i] - center[i]).abs() <= r))
                .map(|v| v.map(f64::from))
                .collect();
            let mean = [0, 1, 2].map(|i| window.iter().map(|v| v[i]).sum::<f64>() / window.len() as f64);
            let covariance = [0, 1, 2]
                .map(|i| [0, 1, 2].map(|j| window.iter().map(|v| (v[i] - mean[i]) * (v[j] - mean[j])).sum::<f64>()));
            let [(l0, n), (l1, _), _] = jacobi(covariance);
            let ratio = l0.max(0.0) / l1;
            let found = at(dag(&set), center, kind, dir);
            let context = format!("seed {SEED}, round {round}, {kind:?} at {center:?}, ratio {ratio}: {found:?}");
            match found.confidence {
                Confidence::Plane { ratio: found_ratio } => {
                    planes += 1;
                    assert!((f64::from(found_ratio) - ratio).abs() < 1e-5, "{context}");
                    let angle = degrees(found.direction.map(f64::from), n);
                    assert!(angle.min(180.0 - angle) < 1e-4, "{context}: {n:?}");
                }
                Confidence::Line => assert!(l1 < 1e-9, "{context}"),
                _ => {
                    solids += 1;
                    assert!(l1 < 1e-9 || ratio > 0.6 - 1e-9, "{context}");
                }
            }
        }
    }
    assert!(planes > 300 && solids > 100, "{planes} planes and {solids} solids: too few of one");
}

/// Mean and largest error in degrees over all voxels, seen along the true normal a little turned.
fn errors(depth: u8, voxels: &[Voxel], kind: NormalKind, truth: impl Fn(Voxel) -> [f64; 3]) -> (f64, f64) {
    let set = Set::at([0; 3], depth, voxels.iter().copied());
    let (mut sum, mut largest) = (0.0, 0.0f64);
    for &v in voxels {
        let n = normalize(truth(v)).unwrap();
        let found = at(dag(&set), v, kind, [-n[0] + 0.1, -n[1] - 0.05, -n[2] + 0.02]);
        let error = degrees(found.direction.map(f64::from), n);
        sum += error;
        largest = largest.max(error);
    }
    (sum / voxels.len() as f64, largest)
}

#[test]
fn accuracy_on_a_sphere() {
    // Centre off the lattice, radius 32.
    let (center, radius) = ([40.3, 39.8, 40.1], 32.0);
    let from_center = |v: Voxel| [0, 1, 2].map(|i| f64::from(v[i]) + 0.5 - center[i]);
    let length = |p: [f64; 3]| dot(p, p).sqrt();
    // Thin: the centre within half a voxel of the surface. Cover: the surface runs through the voxel.
    let thin: Vec<_> = boxed([0; 3], [80; 3]).filter(|&v| (length(from_center(v)) - radius).abs() <= 0.5).collect();
    let cover: Vec<_> = boxed([0; 3], [80; 3])
        .filter(|&v| {
            let p = from_center(v).map(f64::abs);
            length(p.map(|x| (x - 0.5).max(0.0))) <= radius && radius <= length(p.map(|x| x + 0.5))
        })
        .collect();
    for (name, voxels) in [("thin", thin), ("cover", cover)] {
        for (kind, mean_limit, largest_limit) in [
            (NormalKind::Plane1, 6.8, 30.0),
            (NormalKind::Plane2, 2.4, 16.0),
            (NormalKind::Plane3, 1.3, 9.0),
            (NormalKind::Ernerfeldt1, 6.4, 30.0),
            (NormalKind::Ernerfeldt2, 2.2, 16.0),
        ] {
            let (mean, largest) = errors(7, &voxels, kind, from_center);
            println!("sphere, {name}, {kind:?}: mean {mean:.2}, largest {largest:.1} degrees");
            assert!(mean <= mean_limit && largest <= largest_limit, "{name} {kind:?}: {mean} {largest}");
        }
    }
}

#[test]
fn accuracy_on_tilted_planes() {
    const SEED: u64 = 17;
    const ROUNDS: i32 = 60;
    let mut random = Rng::new(SEED);
    // The voxels that the plane runs through, and those whose centre is within half a voxel of it.
    for name in ["cover", "thin"] {
        let mut sums = [0.0; 3];
        for _ in 0..ROUNDS {
            let n = unit(&mut random);
            let through: Voxel = [0, 1, 2].map(|_| 4000 + random.below(256) as i32);
            let reach = if name == "thin" { 0.5 } else { n.iter().map(|x| x.abs()).sum::<f64>() / 2.0 };
            let height = |v: &Voxel| dot([0, 1, 2].map(|i| f64::from(256 * v[i] - through[i]) / 256.0), n);
            let voxels: Vec<_> = boxed([0; 3], [31; 3]).filter(|v| height(v).abs() <= reach).collect();
            let inner: Vec<_> = voxels.iter().copied().filter(|v| v.iter().all(|c| (3..=28).contains(c))).collect();
            let set = Set::at([0; 3], 5, voxels);
            for (i, (kind, _)) in PLANES.iter().enumerate() {
                let error = |v: &Voxel| degrees(at(dag(&set), *v, *kind, n.map(|x| -x)).direction.map(f64::from), n);
                sums[i] += inner.iter().map(error).sum::<f64>() / inner.len() as f64;
            }
        }
        let means = sums.map(|s| s / f64::from(ROUNDS));
        println!("tilted planes, {name}: means {means:.2?} degrees");
        assert!(means[0] <= 7.5 && means[1] <= 2.4 && means[2] <= 1.3, "seed {SEED}, {name}: {means:?}");
    }
}

/// What the weighted regressions answer where the truth is known (rows N1 to N3, N5 to N10): the thesis's method, its
/// defects included.
#[test]
fn ernerfeldts_planes_have_the_known_answers() {
    let dir = [0.6, 0.5, -0.7];
    let slab = |keep: fn(i32) -> bool| Set::new(boxed([-5; 3], [5; 3]).filter(move |v| keep(v[2])));
    let (sheet, wall, gap, half) =
        (slab(|z| z == 0), slab(|z| z == 0 || z == -1), slab(|z| z == 0 || z == -2), slab(|z| z <= 0));
    let tilt = |set: &Set, kind| {
        let n = set.through([0; 3], kind, dir, Face::PosZ);
        assert_eq!(n.confidence, Confidence::Regression);
        assert!(n.direction[0] >= 0.0 && n.direction[1] >= 0.0, "{n:?}");
        degrees(n.direction.map(f64::from), [0.0, 0.0, 1.0])
    };
    // With variances u < v of one axis and two, the sum is (u v)^3, (u v)^3, v^6: a tilt of atan(sqrt 2 (u / v)^3).
    for (name, set, kind, u, v) in [
        ("sheet", &sheet, NormalKind::Ernerfeldt2, 0.0, 2.0),
        ("wall", &wall, NormalKind::Ernerfeldt1, 0.25, 2.0 / 3.0),
        ("wall", &wall, NormalKind::Ernerfeldt2, 0.25, 2.0),
        ("gap", &gap, NormalKind::Ernerfeldt2, 1.0, 2.0),
        ("half space", &half, NormalKind::Ernerfeldt1, 0.25, 2.0 / 3.0),
        ("half space", &half, NormalKind::Ernerfeldt2, 2.0 / 3.0, 2.0),
    ] {
        let (found, ratio) = (tilt(set, kind), u / v);
        let expected = libm::atan(2.0f64.sqrt() * ratio * ratio * ratio).to_degrees();
        println!("{name}, {kind:?}: tilts by {found:.2} degrees");
        assert!((found - expected).abs() < 1e-4, "{name}, {kind:?}: {found}, not {expected}");
    }

    let point = Set::new([[0; 3]]);
    let line = Set::new((-3..=3).map(|x| [x, 0, 0]));
    let block = Set::new(boxed([-5; 3], [5; 3]));
    let edge = Set::new(boxed([-6; 3], [0, 6, 0]).filter(|v| v[0] == 0 || v[2] == 0));
    for (kind, _) in REGRESSIONS {
        let n = point.through([0; 3], kind, dir, Face::PosZ);
        assert_eq!((n.direction, n.confidence), ([0.0, 0.0, 1.0], Confidence::Face));
        assert_eq!(
            line.normal([0; 3], kind, [0.5, 0.3, -0.4]),
            line.normal([0; 3], NormalKind::Plane2, [0.5, 0.3, -0.4])
        );
        // Nothing to go by, and an answer all the same, on the side of the entry face.
        for (face, sign) in [(Face::PosZ, 1.0), (Face::NegX, -1.0)] {
            assert_near(&block.through([0; 3], kind, dir, face), [sign; 3], 1e-4);
        }
        assert_near(&edge.through([0; 3], kind, dir, Face::PosX), [BISECTOR, 0.0, BISECTOR], 0.5);
        // The side is the face's alone, although the viewer looks from the other one.
        assert_eq!(sheet.through([0; 3], kind, [0.1, 0.1, 1.0], Face::PosZ).direction, [0.0, 0.0, 1.0]);
        let n = sheet.through([0; 3], kind, dir, Face::NegX);
        assert_eq!((n.direction, n.confidence), ([-1.0, 0.0, 0.0], Confidence::Face));
    }
}

/// The same plane as the textbook's for any voxels, and, as that, not that of the mirror image.
#[test]
fn ernerfeldts_planes_are_the_textbooks() {
    const SEED: u64 = 19;
    let mut random = Rng::new(SEED);
    let (mut compared, mut turned_away, mut largest) = (0, 0, 0.0f64);
    for round in 0..3000 {
        let voxels = neighbourhood(&mut random);
        let set = Set::at([16; 3], 5, voxels.iter().copied());
        let image = Set::at([16; 3], 5, voxels.iter().map(|v| [-v[0], v[1], v[2]]));
        for (kind, r) in REGRESSIONS {
            let n = through(dag(&set), [16; 3], kind, [0.3, 0.4, -0.5], Face::PosZ);
            let near: Vec<_> = voxels.iter().filter(|v| v.iter().all(|c| c.abs() <= r)).collect();
            // By their number, so that the textbook's centre has no rounding error.
            let points: Vec<_> = near.iter().map(|v| v.map(|x| f64::from(x * near.len() as i32))).collect();
            let Some(textbook) = ernerfeldt(&points) else {
                assert_ne!(n.confidence, Confidence::Regression, "seed {SEED}, round {round}");
                continue;
            };
            let angle = |a: [f32; 3], b: [f64; 3]| {
                let angle = degrees(a.map(f64::from), b);
                angle.min(180.0 - angle)
            };
            if n.confidence == Confidence::Regression {
                compared += 1;
                assert!(
                    angle(n.direction, textbook) < 1e-4,
                    "seed {SEED}, round {round}, {kind:?}: {n:?} {textbook:?}"
                );
                assert!(n.direction[2] > 0.0);
                let m = through(dag(&image), [16; 3], kind, [-0.3, 0.4, -0.5], Face::PosZ).direction.map(f64::from);
                let off = angle(n.direction, [-m[0], m[1], m[2]]);
                turned_away += u32::from(off > 0.01);
                largest = largest.max(off);
            }
        }
    }
    println!("{turned_away} of {compared} mirror images differ, by up to {largest:.1} degrees");
    assert!(compared > 4000 && turned_away > 0, "{compared} {turned_away}");
}

/// The answer depends on where the ray heads to, not on how long its direction is.
#[test]
fn the_length_of_the_direction_does_not_matter() {
    let line = Set::new((-3..=3).map(|x| [x, 0, 0]));
    let [short, usual, long] = [1e-200, 1.0, 1e200]
        .map(|length| at(line.dag(), [16; 3], NormalKind::Plane2, [0.3 * length, 0.2 * length, -length]));
    assert_eq!(usual.confidence, Confidence::Line);
    for other in [short, long] {
        assert_eq!(other.confidence, usual.confidence);
        assert!((0..3).all(|i| (other.direction[i] - usual.direction[i]).abs() < 1e-6), "{other:?} {usual:?}");
    }
}

/// A view that is nearly, but not quite, along a line of voxels: what is left across it may be as small as f64 goes.
#[test]
fn n02_a_line_seen_nearly_along_it() {
    let line = Set::new((-3..=3).map(|y| [0, y, 0]));
    for across in [1e-3, 1e-150, 1e-160, 1e-200, 1e-300, 1e-307] {
        for (kind, _) in PLANES {
            let n = line.normal([0; 3], kind, [across, 1.0, -across]);
            assert_eq!(n.confidence, Confidence::Line, "{across:e}");
            assert_near(&n, [-1.0, 0.0, 1.0], 1e-4);
        }
    }
}
