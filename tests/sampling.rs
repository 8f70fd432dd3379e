//! Laws of supersampling: which pixels take all samples, what they and the others show, and what it costs.

use voxdag::camera::Camera;
use voxdag::color::{Mean, quantize};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::math;
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{Counters, Samples, Settings, Supersample, View, each_pixel, render_rows};
use voxdag::shade::{Light, Surface, shade};
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::{Dag, Geometry, Grid, Material, Materials, Morton};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;

const SIZE: [u32; 2] = [60, 40];
const PIXELS: u64 = 60 * 40;
const GRID: Grid = Grid { origin: [-1.0, 5.0, 2.5], voxel_size: 0.25, resolution: 32 };
const PALETTE: [Material; 2] = [
    Material::GREY,
    Material { diffuse: [0.9, 0.2, 0.1], specular: [0.5; 3], shininess: 9, illum: 2, ..Material::GREY },
];

/// Two materials in stripes along z.
#[derive(Clone, Copy)]
struct Stripes;

impl Materials for Stripes {
    fn id(&self, voxel: Morton) -> u16 {
        (voxel.decode()[2] / 8 % 2) as u16
    }

    fn normal(&self, _: Morton) -> Option<[f32; 3]> {
        None
    }
}

/// A ball, a floor and a thin pole, which together do not fill the cube of 32 voxels a side.
struct Scene {
    voxels: Vec<[u32; 3]>,
    words: Vec<u32>,
    camera: Camera,
}

impl Scene {
    fn new() -> Scene {
        let cube = (0..32u32).flat_map(|z| (0..32).flat_map(move |y| (0..32).map(move |x| [x, y, z])));
        let ball = |v: [u32; 3]| v.map(|c| f64::from(c) - 14.7).map(|x| x * x).iter().sum::<f64>() <= 80.0;
        let floor = |[x, y, z]: [u32; 3]| y == 3 && (2..29).contains(&x) && (1..27).contains(&z);
        let pole = |[x, y, z]: [u32; 3]| x == 26 && z == 22 && (3..30).contains(&y);
        let voxels: Vec<_> = cube.filter(|&v| floor(v) || ball(v) || pole(v)).collect();
        let words = VoxelSet::new(voxels.iter().copied()).words(5);
        let bounds = Bounds { min: GRID.origin, max: GRID.to_world([32.0; 3]) };
        Scene { voxels, words, camera: Camera::framing(&bounds, UpAxis::Y) }
    }

    fn dag(&self) -> Dag<'_> {
        Dag::new(&self.words).unwrap()
    }

    /// Seen from the side of an axis, a little turned.
    fn seen_along(mut self, axis: usize, sign: f64) -> Scene {
        let middle = self.camera.target;
        let mut ahead = [0.3, -0.35, 0.4];
        ahead[axis] = sign;
        self.camera.eye = math::add_scaled(middle, ahead, -11.0);
        self
    }

    fn picture(&self, samples: Samples, supersample: Supersample) -> (Vec<u32>, Counters) {
        self.drawn(&Settings { samples, supersample, ..Settings::default() })
    }

    fn drawn(&self, settings: &Settings) -> (Vec<u32>, Counters) {
        let lights = self.lights();
        let settings = Settings { width: SIZE[0], height: SIZE[1], ..*settings };
        let mut out = vec![0; PIXELS as usize];
        let counters = render_rows(&self.view(&lights), &settings, 0..SIZE[1], &mut out).unwrap();
        // The same rows in any order.
        let (mut sum, mut again) = (Counters::default(), vec![0; out.len()]);
        for rows in [31..40, 0..1, 7..31, 1..7] {
            let places = (rows.start * SIZE[0]) as usize..(rows.end * SIZE[0]) as usize;
            sum += render_rows(&self.view(&lights), &settings, rows, &mut again[places]).unwrap();
        }
        assert!(again == out && sum == counters, "{settings:?}");
        (out, counters)
    }

    fn lights(&self) -> [Light; 1] {
        [self.camera.headlight(5.0)]
    }

    fn view<'a>(&'a self, lights: &'a [Light]) -> View<'a, Stripes> {
        let tracer = Tracer::new(self.dag());
        View { tracer, materials: Stripes, palette: &PALETTE, grid: GRID, camera: self.camera, lights }
    }

    /// What a look at each pixel's rays gives.
    fn each<T: Default + Clone>(&self, look: impl Fn(&dyn Fn([f64; 2]) -> Query) -> T) -> Vec<T> {
        let mut out = vec![T::default(); PIXELS as usize];
        each_pixel(&self.camera, &GRID, SIZE, 0..SIZE[1], &mut out, |pixel| look(&|place| pixel.query(place))).unwrap();
        out
    }
}

/// All samples where `inside`, the centre elsewhere: the pixels of the two pictures, one by one, and no ray too many.
fn choose_pixels(scene: &Scene, rule: Supersample, inside: &[bool], center_rays: bool, context: &str) {
    for samples in [Samples::Four, Samples::Five, Samples::Sixteen] {
        let (all, _) = scene.picture(samples, Supersample::All);
        let (one, _) = scene.picture(Samples::One, Supersample::All);
        let (found, counters) = scene.picture(samples, rule);
        for i in 0..found.len() {
            let expected = if inside[i] { all[i] } else { one[i] };
            assert_eq!(found[i], expected, "{context}, {samples:?}: pixel {i}, inside: {}", inside[i]);
        }
        let chosen = inside.iter().filter(|x| **x).count() as u64;
        let extra = u64::from(center_rays && samples != Samples::Five);
        assert_eq!(counters.supersampled, chosen, "{context}");
        assert_eq!(counters.primary, PIXELS - chosen + chosen * (u64::from(samples.count()) + extra), "{context}");
    }
}

#[test]
fn near_is_the_nearer_share_of_the_voxels_pixel_by_pixel() {
    let mut seen = [0; 2];
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let scene = Scene::new().seen_along(axis, sign);
        let dag = scene.dag();
        let layers = || scene.voxels.iter().map(|v| v[axis]);
        let (first, last) = (layers().min().unwrap(), layers().max().unwrap());
        for share in [0.0, 0.3, 0.5, 1.0, f64::NAN] {
            let rule = Supersample::near(dag, &scene.camera, share);
            // As many layers as are whole in the share.
            let near = (f64::from(last - first + 1) * share).floor();
            let inside = scene.each(|query| {
                let hit = dag.trace(&query([0.5; 2]));
                hit.is_some_and(|hit| {
                    let layer = hit.voxel.decode()[axis];
                    f64::from(if sign > 0.0 { layer - first } else { last - layer }) < near
                })
            });
            choose_pixels(&scene, rule, &inside, true, &format!("axis {axis}, sign {sign}, share {share}"));
            seen[0] += inside.iter().filter(|x| **x).count();
            seen[1] += inside.iter().filter(|x| !**x).count();
        }
    }
    assert!(seen.iter().all(|n| *n > 5_000), "{seen:?}");
    // The thesis's rule where the voxels fill the grid: z > (n - 1) / 2, the camera looking towards -z.
    let camera = Camera { eye: [0.0, 0.0, 9.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 45.0 };
    for side in [1, 2, 3, 8] {
        let words = VoxelSet::new([[0; 3], [side - 1; 3]]).words(3);
        let nearer: Vec<_> = (0..side).filter(|&z| 2 * z > side - 1).collect();
        let Supersample::Slab { axis: 2, from, to } = Supersample::near(Dag::new(&words).unwrap(), &camera, 0.5) else {
            panic!("another axis")
        };
        assert_eq!((from..to).collect::<Vec<_>>(), nearer, "{side}");
    }
    let nothing = VoxelSet::new([]).words(3);
    let rule = Supersample::near(Dag::new(&nothing).unwrap(), &camera, 1.0);
    assert!(matches!(rule, Supersample::Slab { from: 0, to: 0, .. }));
}

#[test]
fn regions_are_rectangles() {
    let scene = Scene::new();
    for (from, to) in
        [([7, 5], [31, 33]), ([0, 0], SIZE), ([59, 39], [u32::MAX; 2]), ([9, 9], [9, 20]), ([9, 9], [3, 20])]
    {
        let place = |i: usize| [i as u32 % SIZE[0], i as u32 / SIZE[0]];
        let inside: Vec<_> =
            (0..PIXELS as usize).map(|i| (0..2).all(|k| from[k] <= place(i)[k] && place(i)[k] < to[k])).collect();
        choose_pixels(&scene, Supersample::Region { from, to }, &inside, false, &format!("{from:?} to {to:?}"));
    }
}

/// Adaptive pixels one by one, by the rule of the documentation in f64.
#[test]
fn adaptive_takes_all_samples_where_the_corners_part() {
    let scene = Scene::new();
    let (dag, lights) = (scene.dag(), scene.lights());
    let tracer = Tracer::new(dag);
    for (samples, corners) in [(Samples::Sixteen, [0, 3, 12, 15]), (Samples::SixtyFour, [0, 7, 56, 63])] {
        let (all, _) = scene.picture(samples, Supersample::All);
        for degrees in [1.0, 8.0, 40.0f32] {
            let settings = Settings { samples, supersample: Supersample::Adaptive { degrees }, ..Settings::default() };
            let (found, counters) = scene.drawn(&settings);
            let (marked, _) = scene.drawn(&Settings { mark_supersampled: true, ..settings });
            // Whether the corners part, unless it is too close to call, and their mean.
            let expected = scene.each(|query| {
                let mut mean = Mean::default();
                let seen = corners.map(|i| {
                    let query = query(samples.position(i));
                    let hit = tracer.trace(Arithmetic::Exact, &query);
                    let seen = hit.map(|hit| {
                        let n = normal(&tracer, Stripes, &hit, query.dir, NormalKind::Plane2).direction;
                        let back = math::normalize(query.dir).unwrap().map(|x| -x as f32);
                        let point = GRID.to_world(math::add_scaled(query.origin, query.dir, hit.t));
                        let id = Stripes.id(hit.voxel);
                        let surface = Surface { point, normal: n, view: back };
                        mean.add(shade(&PALETTE[usize::from(id)], &surface, settings.ambient, &lights).map(quantize));
                        (hit.voxel.decode().map(f64::from), n.map(f64::from), id)
                    });
                    if seen.is_none() {
                        mean.add(settings.background.map(quantize));
                    }
                    seen
                });
                let (mut parts, mut close) = (false, false);
                for other in &seen[1..] {
                    let (Some((a, n, id)), Some((b, m, other))) = (seen[0], *other) else {
                        parts |= seen[0].is_some() != other.is_some();
                        continue;
                    };
                    let across = math::cross(n, m);
                    let angle = libm::atan2(math::dot(across, across).sqrt(), math::dot(n, m)).to_degrees();
                    let way = math::sub(b, a);
                    let height = math::dot(way, n).abs()
                        - 2.0
                        - libm::sin(f64::from(degrees).to_radians()) * math::dot(way, way).sqrt();
                    close |= (angle - f64::from(degrees)).abs() < 0.05 || height.abs() < 1e-4;
                    parts |= angle > f64::from(degrees) || height > 0.0 || id != other;
                }
                ((!close).then_some(parts), mean.srgb8())
            });
            let (mut chosen, mut called) = (0, [0; 2]);
            for (i, (parts, [r, g, b])) in expected.iter().enumerate() {
                let is_marked = marked[i] != found[i];
                chosen += u64::from(is_marked);
                if let Some(parts) = *parts {
                    assert_eq!(is_marked, parts, "pixel {i} at {degrees} degrees");
                    called[usize::from(parts)] += 1;
                }
                let corners = u32::from_le_bytes([*r, *g, *b, 255]);
                assert_eq!(found[i], if is_marked { all[i] } else { corners }, "pixel {i} at {degrees} degrees");
                let [r, g, b, a] = marked[i].to_le_bytes();
                let mark = (r, a) == (255, 255) && g <= 85 && b <= 85;
                assert!(mark || !is_marked, "pixel {i} is not red");
            }
            assert!(called.iter().all(|n| *n > 100), "{called:?} of {PIXELS} pixels: too few of one");
            assert_eq!(counters.supersampled, chosen);
            assert_eq!(counters.primary, 4 * PIXELS + (u64::from(samples.count()) - 4) * chosen);
        }
    }
    for samples in [Samples::One, Samples::Four, Samples::Five] {
        let adaptive = scene.picture(samples, Supersample::Adaptive { degrees: 5.0 });
        assert_eq!(adaptive, scene.picture(samples, Supersample::All));
        assert_eq!(adaptive.1.supersampled, if samples == Samples::One { 0 } else { PIXELS });
    }
}

#[test]
fn adaptive_is_as_good_as_all_samples_and_costs_half() {
    let scene = Scene::new();
    let (truth, _) = scene.picture(Samples::SixtyFour, Supersample::All);
    let rmse = |picture: &[u32]| {
        let squares = picture.iter().zip(&truth).flat_map(|(a, b)| {
            let (a, b) = (a.to_le_bytes(), b.to_le_bytes());
            (0..3).map(move |i| (f64::from(a[i]) - f64::from(b[i])) * (f64::from(a[i]) - f64::from(b[i])))
        });
        (squares.sum::<f64>() / (3.0 * PIXELS as f64)).sqrt()
    };
    let (all, all_rays) = scene.picture(Samples::Sixteen, Supersample::All);
    let (adaptive, rays) = scene.picture(Samples::Sixteen, Supersample::Adaptive { degrees: 2.0 });
    let (four, _) = scene.picture(Samples::Four, Supersample::All);
    let (error, usual, share) = (rmse(&adaptive), rmse(&all), rays.primary as f64 / all_rays.primary as f64);
    println!("RMSE {error:.3} with {share:.3} of the rays, {usual:.3} with all, {:.3} with four", rmse(&four));
    assert!(error < 1.1 * usual && share < 0.5, "{error} for {usual}, {share}");
    assert!(rmse(&four) > 1.3 * usual);
}

#[test]
fn the_extent_is_that_of_the_voxels() {
    const SEED: u64 = 20;
    let mut rng = Rng::new(SEED);
    for round in 0..400 {
        let depth = [0, 1, 2, 3, 5, 9, 21][round % 7] as u8;
        let side = 1u64 << depth;
        let near = [(); 3].map(|()| rng.below(side));
        let reach = 1 + rng.below(side.min(40));
        let voxels: Vec<[u32; 3]> =
            (0..rng.below(30)).map(|_| near.map(|x| ((x + rng.below(reach)) % side) as u32)).collect();
        let words = VoxelSet::new(voxels.iter().copied()).words(depth);
        let dag = Dag::new(&words).unwrap();
        for level in [0, 1, 2, 3, 4, 8, 20, 30] {
            let cube = |x: u32| x >> level.min(depth) << level.min(depth);
            let expected = (!voxels.is_empty()).then(|| {
                let along = |i: usize| voxels.iter().map(move |v| cube(v[i]));
                let last = |i: usize| along(i).max().unwrap() + (1 << level.min(depth)) - 1;
                [[0, 1, 2].map(|i| along(i).min().unwrap()), [0, 1, 2].map(last)]
            });
            assert_eq!(dag.extent(level), expected, "seed {SEED}, round {round}: {voxels:?}, level {level} of {depth}");
        }
    }
}
