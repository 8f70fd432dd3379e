//! Laws of shading and of pictures: one test per row S1 to S10 of the hard cases, and the camera's geometry.

use voxdag::camera::{Camera, CameraError};
use voxdag::color::{Mean, WHITE, linear_to_srgb8, quantize, srgb_to_linear};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::materials::Single;
use voxdag::normal::NormalKind;
use voxdag::render::{Counters, RenderError, Samples, Settings, View, render_rows};
use voxdag::shade::{Light, LightKind, Surface, power, shade};
use voxdag::trace::Tracer;
use voxdag::{Dag, Grid, Material};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;

const WHITE_LIGHT: [f32; 3] = [1.0; 3];
const NO_LIGHT: [f32; 3] = [0.0; 3];

fn shiny(shininess: u32) -> Material {
    Material { diffuse: [0.25, 0.5, 0.75], specular: [0.5; 3], shininess, illum: 2, ..Material::GREY }
}

/// A point on a floor, seen from `view`.
fn floor(view: [f64; 3]) -> Surface {
    let view = voxdag::math::normalize(view).unwrap().map(|x| x as f32);
    Surface { point: [0.0; 3], normal: [0.0, 1.0, 0.0], view }
}

fn towards(direction: [f64; 3]) -> [Light; 1] {
    [Light { kind: LightKind::Directional(direction), color: WHITE_LIGHT, shadow: false }]
}

fn lamp(position: [f64; 3]) -> [Light; 1] {
    [Light { kind: LightKind::Point(position), color: WHITE_LIGHT, shadow: false }]
}

#[test]
fn the_equation_is_phongs() {
    let material = Material { ambient: [0.1, 0.2, 0.3], ..shiny(3) };
    let lights = [
        Light { kind: LightKind::Point([0.0, 2.0, 2.0]), color: [0.5, 1.0, 2.0], shadow: false },
        Light { kind: LightKind::Directional([3.0, 4.0, 0.0]), color: [1.0, 0.0, 1.0], shadow: false },
    ];
    let surface = floor([1.0, 1.0, -1.0]);
    let found = shade(&material, &surface, [0.5, 1.0, 0.0], &lights);
    // By hand: L.N is 1/sqrt 2 and 4/5; R is (0, 1, -1)/sqrt 2 and (-3, 4, 0)/5, so V.R is 2/sqrt 6 and 1/(5 sqrt 3).
    let (l, v) = ([0.5f64.sqrt(), 0.8], [2.0 / 6.0f64.sqrt(), 1.0 / (5.0 * 3.0f64.sqrt())]);
    let kd = [0.25, 0.5, 0.75];
    let (light, ia_ka) = ([[0.5, 1.0, 2.0], [1.0, 0.0, 1.0]], [0.05, 0.2, 0.0]);
    for c in 0..3 {
        let lit: f64 = (0..2).map(|i| light[i][c] * (kd[c] * l[i] + 0.5 * v[i] * v[i] * v[i])).sum();
        assert!((f64::from(found[c]) - ia_ka[c] - lit).abs() < 1e-6, "channel {c}: {found:?}");
    }
}

#[test]
fn s01_no_highlight_from_behind_and_exponent_zero() {
    // At exponent 0 any highlight counts in full, so that one in the wrong place would show.
    let material = shiny(0);
    let ambient = shade(&material, &floor([0.0, 1.0, 0.0]), WHITE_LIGHT, &[]);
    for below in [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [1.0, -1e-3, 0.0]] {
        assert_eq!(shade(&material, &floor([1.0, 1.0, 0.0]), WHITE_LIGHT, &towards(below)), ambient);
    }
    // V.R is 0: light from the left, viewer on the left.
    let found = shade(&material, &floor([-1.0, 1.0, 0.0]), NO_LIGHT, &towards([-1.0, 1.0, 0.0]));
    let matte =
        shade(&Material { illum: 1, ..material }, &floor([-1.0, 1.0, 0.0]), NO_LIGHT, &towards([-1.0, 1.0, 0.0]));
    assert_eq!(found, matte);
    // Checking a material makes 0 a 1.
    assert_eq!(material.checked().unwrap().shininess, 1);
    assert_eq!((power(0.0, 0), power(0.0, 1), power(1.0, 1_000_000)), (1.0, 0.0, 1.0));
}

#[test]
fn s02_negative_base() {
    let material = shiny(3);
    // V.R < 0, an odd exponent: nothing is taken away.
    let (surface, light) = (floor([-1.0, 0.2, 0.0]), towards([-1.0, 0.5, 0.0]));
    let matte = shade(&Material { specular: NO_LIGHT, ..material }, &surface, NO_LIGHT, &light);
    assert_eq!(shade(&material, &surface, NO_LIGHT, &light), matte);
    assert_eq!(power(-0.1, 3), 0.0);
}

#[test]
fn s03_large_exponents_against_libm() {
    const SEED: u64 = 3;
    let mut random = Rng::new(SEED);
    for exponent in [1, 2, 3, 10, 96, 1000, 65_535, 1_000_000] {
        for _ in 0..2000 {
            // Close enough to 1 for the result to be neither 0 nor 1.
            let base = (1.0 - random.unit() * 8.0 / f64::from(exponent)).max(0.0) as f32;
            let exact = libm::pow(f64::from(base), f64::from(exponent));
            let error = (f64::from(power(base, exponent)) - exact).abs();
            assert!(error <= exact * 6e-8 + 1e-45, "seed {SEED}: {base}^{exponent} is {exact}, off by {error}");
        }
    }
}

#[test]
fn s04_light_at_the_hit_point() {
    let surface = floor([0.0, 1.0, 0.0]);
    let ambient = shade(&shiny(5), &surface, WHITE_LIGHT, &[]);
    assert_eq!(shade(&shiny(5), &surface, WHITE_LIGHT, &lamp([0.0; 3])), ambient);
    assert_eq!(shade(&shiny(5), &surface, WHITE_LIGHT, &towards([0.0; 3])), ambient);
    assert_eq!(shade(&shiny(5), &surface, WHITE_LIGHT, &lamp([f64::NAN, 0.0, 0.0])), ambient);
}

#[test]
fn s05_tiny_and_huge_distances() {
    let surface = floor([1.0, 1.0, 0.0]);
    let expected = shade(&shiny(5), &surface, NO_LIGHT, &lamp([1.0, 2.0, 3.0]));
    for exponent in [-1000, -500, -30, 30, 500, 1000] {
        let scale = libm::scalbn(1.0, exponent);
        let light = [1.0, 2.0, 3.0].map(|x| x * scale);
        assert_eq!(shade(&shiny(5), &surface, NO_LIGHT, &lamp(light)), expected, "2^{exponent}");
        assert_eq!(shade(&shiny(5), &surface, NO_LIGHT, &towards(light)), expected, "2^{exponent}");
    }
}

#[test]
fn s06_materials_that_are_no_numbers_are_refused() {
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        for i in 0..5 {
            let mut material = shiny(1);
            let fields: [&mut [f32; 3]; 5] = [
                &mut material.ambient,
                &mut material.diffuse,
                &mut material.specular,
                &mut material.emission,
                &mut material.transmission,
            ];
            fields.into_iter().nth(i).unwrap()[i % 3] = bad;
            assert!(material.checked().is_err());
        }
    }
}

#[test]
fn s07_saturation_comes_after_averaging() {
    let mean = |samples: &[f32]| {
        let mut mean = Mean::default();
        samples.iter().for_each(|&s| mean.add([quantize(s); 3]));
        mean.srgb8()[0]
    };
    assert_eq!(mean(&[1.7]), 255);
    assert_eq!(mean(&[1.5, 0.5]), 255);
    assert_eq!(mean(&[2.0, 0.0, 0.0, 0.0]), mean(&[0.5]));
    assert!(mean(&[1.0, 0.0, 0.0, 0.0]) < mean(&[2.0, 0.0, 0.0, 0.0]));
}

#[test]
fn s08_srgb_is_correctly_rounded() {
    let curve = |x: f64| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 };
    let mut last = 0;
    for linear in 0..=WHITE {
        let byte = linear_to_srgb8(linear);
        let exact = 255.0 * curve(f64::from(linear) / f64::from(WHITE));
        assert_eq!(f64::from(byte), libm::round(exact), "{linear}: {exact}");
        assert!(byte >= last, "{linear}");
        last = byte;
    }
    assert_eq!(linear_to_srgb8(u32::MAX), 255);
    for byte in 0..=255u8 {
        let s = f64::from(byte) / 255.0;
        assert_eq!(linear_to_srgb8(quantize(srgb_to_linear(s) as f32)), byte);
        let exact = if s <= 0.040_45 { s / 12.92 } else { libm::pow((s + 0.055) / 1.055, 2.4) };
        assert!((srgb_to_linear(s) - exact).abs() <= 1e-15 * exact, "{byte}");
    }
    for s in [1.5, 40.0, 1e30] {
        let exact = libm::pow((s + 0.055) / 1.055, 2.4);
        assert!((srgb_to_linear(s) - exact).abs() <= 1e-13 * exact, "{s}");
    }
    assert!(srgb_to_linear(f64::NAN).is_nan());
}

#[test]
fn s09_the_mean_does_not_depend_on_the_order() {
    const SEED: u64 = 9;
    let mut random = Rng::new(SEED);
    let mut samples: Vec<f32> = (0..4096).map(|_| random.unit() as f32).collect();
    let mean = |samples: &[f32]| {
        let mut mean = Mean::default();
        samples.iter().for_each(|&s| mean.add([quantize(s), quantize(1.0 - s), quantize(1.0 / 3.0)]));
        mean
    };
    let expected = mean(&samples);
    for _ in 0..20 {
        random.shuffle(&mut samples);
        assert_eq!(mean(&samples), expected, "seed {SEED}");
    }
    // Exact: equal samples have themselves as their mean, also as many and as bright as can be.
    for value in [1.0 / 3.0, 0.1, 0.0, 1.0, 16.0] {
        let mut equal = Mean::default();
        (0..4096).for_each(|_| equal.add([quantize(value); 3]));
        assert_eq!(equal.srgb8(), [linear_to_srgb8(quantize(value)); 3]);
    }
}

#[test]
fn s10_sample_positions_are_dyadic_distinct_and_balanced() {
    for count in 0..=100 {
        let Some(samples) = Samples::new(count) else {
            assert!(![1, 4, 5, 16, 64].contains(&count));
            continue;
        };
        assert_eq!(samples.count(), count);
        let mut places: Vec<[f64; 2]> = (0..count).map(|i| samples.position(i)).collect();
        for axis in 0..2 {
            assert_eq!(places.iter().map(|p| p[axis]).sum::<f64>() / f64::from(count), 0.5, "{samples:?}");
        }
        for p in &places {
            assert!(p.iter().all(|&x| x > 0.0 && x < 1.0 && (x * 16.0).fract() == 0.0), "{samples:?} {p:?}");
        }
        places.sort_by(|a, b| a.partial_cmp(b).unwrap());
        places.dedup();
        assert_eq!(places.len(), count as usize, "{samples:?}");
    }
}

/// A ball on a floor, 32 voxels a side.
fn scene() -> Vec<u32> {
    let cube = (0..32u32).flat_map(|z| (0..32).flat_map(move |y| (0..32).map(move |x| [x, y, z])));
    let ball = |v: [u32; 3]| v.map(|c| f64::from(c) - 15.7).map(|x| x * x).iter().sum::<f64>() <= 100.0;
    VoxelSet::new(cube.filter(|&v| v[1] == 2 || ball(v))).words(5)
}

fn settings(width: u32, height: u32) -> Settings {
    Settings { width, height, ..Settings::default() }
}

/// The scene's cube in the world: 32 voxels of 0.25, with a corner off the origin.
const GRID: Grid = Grid { origin: [-1.0, 5.0, 2.5], voxel_size: 0.25, resolution: 32 };

fn bounds() -> Bounds {
    Bounds { min: GRID.origin, max: GRID.to_world([32.0; 3]) }
}

fn picture(
    words: &[u32],
    camera: Camera,
    lights: &[Light],
    material: Material,
    settings: &Settings,
) -> (Vec<u32>, Counters) {
    let dag = Dag::new(words).unwrap();
    let view =
        View { tracer: Tracer::new(dag), materials: Single(0), palette: &[material], grid: GRID, camera, lights };
    let mut out = vec![0; (settings.width * settings.height) as usize];
    let counters = render_rows(&view, settings, 0..settings.height, &mut out).unwrap();
    (out, counters)
}

#[test]
fn a_picture_shows_the_scene() {
    let words = scene();
    let camera = Camera::framing(&bounds(), UpAxis::Y);
    let lights = [camera.headlight(bounds().radius())];
    let settings = settings(64, 48);
    let (out, counters) = picture(&words, camera, &lights, Material::GREY, &settings);
    assert_eq!(
        counters,
        Counters { primary: 64 * 48, hits: counters.hits, normals: counters.hits, ..Counters::default() }
    );
    let background = u32::from_le_bytes([222, 226, 230, 255]);
    let empty = out.iter().filter(|&&p| p == background).count() as u64;
    assert_eq!(empty, counters.primary - counters.hits);
    assert!(counters.hits > 64 * 48 / 5 && empty > 64 * 48 / 5, "{counters:?}");
    // The middle is the ball, lit; a grey scene in white light stays grey.
    let middle = out[24 * 64 + 32].to_le_bytes();
    assert!(middle[0] > 100 && middle[0] == middle[1] && middle[1] == middle[2] && middle[3] == 255, "{middle:?}");
}

#[test]
fn a_pixel_depends_on_its_place_only() {
    let words = scene();
    let camera = Camera::framing(&bounds(), UpAxis::Y);
    let lights = [camera.headlight(bounds().radius())];
    let dag = Dag::new(&words).unwrap();
    let view = View {
        tracer: Tracer::new(dag),
        materials: Single(0),
        palette: &[shiny(20)],
        grid: GRID,
        camera,
        lights: &lights,
    };
    for samples in [1, 4, 5, 16] {
        let settings = Settings { samples: Samples::new(samples).unwrap(), ..settings(40, 30) };
        let mut whole = vec![0; 1200];
        let all = render_rows(&view, &settings, 0..30, &mut whole).unwrap();
        assert_eq!(all.primary, u64::from(samples) * 1200);
        let mut sum = Counters::default();
        for rows in [20..30, 0..1, 7..20, 1..7, 7..7] {
            let mut part = vec![0; rows.len() * 40];
            sum += render_rows(&view, &settings, rows.clone(), &mut part).unwrap();
            assert_eq!(part, whole[rows.start as usize * 40..rows.end as usize * 40]);
        }
        assert_eq!(sum, all);
    }
}

#[test]
fn what_does_not_apply_changes_nothing() {
    let words = scene();
    let camera = Camera::framing(&bounds(), UpAxis::Y);
    let lights = [camera.headlight(bounds().radius())];
    let plain = Material { specular: NO_LIGHT, illum: 1, shininess: 1, ..Material::GREY };
    let picture = |material, lights: &[Light]| picture(&words, camera, lights, material, &settings(40, 30));
    let expected = picture(plain, &lights);
    // Ks of 0 whatever the exponent, and a Ks that the model does not use.
    assert_eq!(picture(Material { illum: 2, shininess: 900, ..plain }, &lights), expected);
    assert_eq!(picture(Material { specular: [1.0; 3], ..plain }, &lights), expected);
    assert_ne!(picture(Material { specular: [1.0; 3], illum: 2, shininess: 9, ..plain }, &lights), expected);
    // A black light.
    let black = Light { color: NO_LIGHT, ..lights[0] };
    assert_eq!(picture(plain, &[lights[0], black]), expected);
}

#[test]
fn ids_beyond_the_palette_are_grey() {
    let words = scene();
    let camera = Camera::framing(&bounds(), UpAxis::Y);
    let dag = Dag::new(&words).unwrap();
    let render = |palette: &[Material]| {
        let view = View { tracer: Tracer::new(dag), materials: Single(3), palette, grid: GRID, camera, lights: &[] };
        let mut out = [0; 300];
        render_rows(&view, &settings(20, 15), 0..15, &mut out).unwrap();
        out
    };
    assert_eq!(render(&[]), render(&[Material::GREY; 4]));
    assert_eq!(render(&[shiny(1); 3]), render(&[Material::GREY; 4]));
}

#[test]
fn normals_of_every_kind_make_a_picture() {
    let words = scene();
    let camera = Camera::framing(&bounds(), UpAxis::Y);
    let lights = [camera.headlight(bounds().radius())];
    let render = |normals| picture(&words, camera, &lights, shiny(9), &Settings { normals, ..settings(40, 30) });
    use NormalKind::*;
    let pictures = [Face, Gradient, Plane1, Plane2, Plane3, Ernerfeldt1, Ernerfeldt2].map(render);
    for (i, p) in pictures.iter().enumerate() {
        // Not every normal has its highlight, and those of sides take no work.
        let normals = if i == 0 { 0 } else { p.1.hits };
        assert_eq!(p.1, Counters { highlights: p.1.highlights, normals, ..pictures[0].1 });
        assert!(pictures[..i].iter().all(|other| other.0 != p.0), "picture {i}");
    }
    assert_eq!(render(Stored), pictures[3]);
}

#[test]
fn nonsense_is_refused() {
    let words = scene();
    let good = Camera::framing(&bounds(), UpAxis::Y);
    let dag = Dag::new(&words).unwrap();
    let render = |settings: &Settings, camera, rows, room: usize| {
        let view =
            View { tracer: Tracer::new(dag), materials: Single(0), palette: &[], grid: GRID, camera, lights: &[] };
        render_rows(&view, settings, rows, &mut vec![7; room])
    };
    let s = settings(4, 3);
    assert!(render(&s, good, 0..3, 12).is_ok());
    for (width, height) in [(0, 3), (4, 0), (65_537, 3), (4, u32::MAX)] {
        assert_eq!(render(&settings(width, height), good, 0..0, 0), Err(RenderError::Size { width, height }));
    }
    for (start, end) in [(0, 4), (4, 4), (2, 1), (0, u32::MAX)] {
        assert_eq!(render(&s, good, start..end, 12), Err(RenderError::Rows { start, end, height: 3 }));
    }
    for room in [0, 7, 9, 12] {
        let error = RenderError::Output { expected: 8, found: room as u64 };
        assert_eq!(render(&s, good, 1..3, room), Err(error));
        assert!(error.to_string().contains('8'));
    }
    let check = |camera: Camera, error| {
        assert_eq!(camera.checked(), Err(error));
        assert_eq!(render(&s, camera, 0..3, 12), Err(RenderError::Camera(error)));
    };
    check(Camera { eye: good.target, ..good }, CameraError::NoDirection);
    check(Camera { eye: [f64::NAN; 3], ..good }, CameraError::NotFinite);
    check(Camera { up: [f64::INFINITY, 0.0, 0.0], ..good }, CameraError::NotFinite);
    check(Camera { eye: [1.7e308; 3], target: [-1.7e308; 3], ..good }, CameraError::NotFinite);
    for fov_y in [0.0, -1.0, 180.0, f64::NAN, f64::INFINITY] {
        check(Camera { fov_y, ..good }, CameraError::FieldOfView);
    }
}

/// Whether two vectors have the same direction, up to rounding.
fn parallel(a: [f64; 3], b: [f64; 3]) -> bool {
    let [a, b] = [a, b].map(|v| voxdag::math::normalize(v).unwrap());
    (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12)
}

#[test]
fn the_camera_looks_where_it_should() {
    let camera = Camera { eye: [1.0, 2.0, 3.0], target: [1.0, 2.0, -7.0], up: [0.0, 5.0, 2.0], fov_y: 90.0 };
    let rays = camera.rays(200, 100).unwrap();
    // The middle, and the borders: 45 degrees up and down, twice as far to the sides; row 0 is the top.
    for (x, y, expected) in [
        (100.0, 50.0, [0.0, 0.0, -1.0]),
        (100.0, 0.0, [0.0, 1.0, -1.0]),
        (100.0, 100.0, [0.0, -1.0, -1.0]),
        (0.0, 50.0, [-2.0, 0.0, -1.0]),
        (200.0, 50.0, [2.0, 0.0, -1.0]),
    ] {
        assert!(parallel(rays.direction(x, y), expected), "{x} {y}: {:?}", rays.direction(x, y));
    }
    // An up that says nothing is replaced, the same way each time.
    for up in [[0.0; 3], [0.0, 0.0, 4.0], [0.0, 0.0, -1e-9]] {
        assert_eq!(Camera { up, ..camera }.checked().unwrap().up, [0.0, 1.0, 0.0]);
    }
    let down = Camera { target: [1.0, -2.0, 3.0], up: [0.0, 1.0, 0.0], ..camera };
    assert_eq!(down.checked().unwrap().up, [0.0, 0.0, 1.0]);
}

#[test]
fn the_default_view_frames_the_box_either_way_up() {
    let b = Bounds { min: [-1.0, 0.0, -3.0], max: [1.0, 4.0, 3.0] };
    let camera = Camera::framing(&b, UpAxis::Y);
    let distance = voxdag::math::sub(camera.eye, camera.target);
    assert_eq!(camera.target, [0.0, 2.0, 0.0]);
    assert!((voxdag::math::dot(distance, distance).sqrt() - 2.0 * b.radius()).abs() < 1e-12);
    assert!(parallel(distance, [1.0, 0.6, 1.2]));
    // The same model with z up gives the same picture: the camera turns with it.
    let turned = |p| UpAxis::Z.turn(p);
    let corners = [turned(b.min), turned(b.max)];
    let z_up = Bounds {
        min: [0, 1, 2].map(|i| corners[0][i].min(corners[1][i])),
        max: [0, 1, 2].map(|i| corners[0][i].max(corners[1][i])),
    };
    let z_camera = Camera::framing(&z_up, UpAxis::Z);
    assert_eq!(
        (z_camera.eye, z_camera.target, z_camera.up),
        (turned(camera.eye), turned(camera.target), [0.0, 0.0, 1.0])
    );
    assert_eq!(
        z_camera.headlight(3.0).kind,
        LightKind::Point(turned(match camera.headlight(3.0).kind {
            LightKind::Point(p) => p,
            LightKind::Directional(_) => unreachable!(),
        }))
    );
    // A single point can be looked at.
    assert!(Camera::framing(&Bounds { min: [1.0; 3], max: [1.0; 3] }, UpAxis::Y).checked().is_ok());
}

#[test]
fn s07_the_strongest_lights_are_white_not_black() {
    let lights = [Light { kind: LightKind::Point([3.0, 9.0, 9.0]), color: [3e38; 3], shadow: false }];
    let material = Material { diffuse: [1.0; 3], specular: [2.0; 3], shininess: 1_000_000, illum: 2, ..Material::GREY };
    for angle in [0.1, 0.5, 0.9] {
        let surface =
            Surface { point: [0.0; 3], normal: [0.0, 0.0, 1.0], view: [angle, 0.0, (1.0 - angle * angle).sqrt()] };
        let color = shade(&material, &surface, [0.2; 3], &lights);
        assert!(color.iter().all(|c| *c > 1.0), "{color:?}");
    }
}
