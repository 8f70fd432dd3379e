//! Laws of shadows: where they fall, which rays they take, and how far voxels shade themselves.

use voxdag::camera::Camera;
use voxdag::color::{Mean, quantize};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::materials::Single;
use voxdag::math::{add_scaled, dot, normalize, sub};
use voxdag::normal::NormalKind;
use voxdag::render::{Counters, Samples, Settings, View, each_pixel, render_rows};
use voxdag::shade::{Light, LightKind, Surface, shade};
use voxdag::trace::{Hit, Query, Tracer};
use voxdag::{Dag, Grid, Material};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;

const SIZE: [u32; 2] = [90, 60];
/// 32 voxels a side, with a corner off the world's origin.
const GRID: Grid = Grid { origin: [-1.0, 5.0, 2.5], voxel_size: 0.25, resolution: 32 };
const SHINY: Material = Material { specular: [0.4; 3], shininess: 7, illum: 2, ..Material::GREY };

fn cube(side: u32) -> impl Iterator<Item = [u32; 3]> {
    (0..side).flat_map(move |z| (0..side).flat_map(move |y| (0..side).map(move |x| [x, y, z])))
}

fn sun(direction: [f64; 3]) -> Light {
    Light { kind: LightKind::Directional(direction), color: [0.6, 0.5, 0.4], shadow: true }
}

/// At a place in the grid.
fn lamp(grid: &Grid, place: [f64; 3]) -> Light {
    Light { kind: LightKind::Point(grid.to_world(place)), color: [0.4, 0.5, 0.6], shadow: true }
}

fn without_shadows(lights: &[Light]) -> Vec<Light> {
    lights.iter().map(|light| Light { shadow: false, ..*light }).collect()
}

struct Scene {
    words: Vec<u32>,
    grid: Grid,
    camera: Camera,
}

impl Scene {
    fn new(voxels: impl Iterator<Item = [u32; 3]>, grid: Grid, camera: Camera) -> Scene {
        Scene { words: VoxelSet::new(voxels).words(grid.depth()), grid, camera }
    }

    fn drawn(&self, normals: NormalKind, samples: Samples, lights: &[Light]) -> (Vec<u32>, Counters) {
        let tracer = Tracer::new(Dag::new(&self.words).unwrap());
        let Scene { grid, camera, .. } = *self;
        let view = View { tracer, materials: Single(0), palette: &[SHINY], grid, camera, lights };
        let settings = Settings { width: SIZE[0], height: SIZE[1], normals, samples, ..Settings::default() };
        let mut out = vec![0; (SIZE[0] * SIZE[1]) as usize];
        let counters = render_rows(&view, &settings, 0..SIZE[1], &mut out).unwrap();
        (out, counters)
    }

    /// The ray through each pixel's middle, and what it meets.
    fn seen(&self) -> Vec<Option<(Query, Hit)>> {
        let dag = Dag::new(&self.words).unwrap();
        let mut out = vec![None; (SIZE[0] * SIZE[1]) as usize];
        each_pixel(&self.camera, &self.grid, SIZE, 0..SIZE[1], &mut out, |pixel| {
            let query = pixel.query([0.5; 2]);
            dag.trace(&query).map(|hit| (query, hit))
        })
        .unwrap();
        out
    }
}

/// Whether the way from `point` to a light passes through one of the voxels (Kay and Kajiya's slabs): of voxels that are
/// smaller, and larger, by `slack` on all sides; all in grid coordinates.
fn in_the_way(voxels: &[[u32; 3]], point: [f64; 3], light: &LightKind, slack: f64) -> [bool; 2] {
    let (dir, end) = match *light {
        LightKind::Point(place) => (sub(GRID.to_grid(place), point), 1.0),
        LightKind::Directional(dir) => (dir, f64::INFINITY),
    };
    [-slack, slack].map(|more| {
        voxels.iter().any(|voxel| {
            let (mut enter, mut leave) = (0.0f64, end);
            for i in 0..3 {
                let low = (f64::from(voxel[i]) - more - point[i]) / dir[i];
                let high = (f64::from(voxel[i] + 1) + more - point[i]) / dir[i];
                enter = enter.max(low.min(high));
                leave = leave.min(low.max(high));
            }
            enter < leave
        })
    })
}

#[test]
fn a_box_shades_the_floor_where_the_way_to_the_light_passes_it() {
    for up in 0..3 {
        // Axes in turn, so that none is special.
        let turned = |v: [u32; 3]| [0, 1, 2].map(|i| v[(i + 4 - up) % 3]);
        let turned_f64 = |v: [f64; 3]| [0, 1, 2].map(|i| v[(i + 4 - up) % 3]);
        let is_floor = |[x, y, z]: [u32; 3]| y == 2 && (1..31).contains(&x) && (1..31).contains(&z);
        let is_box = |[x, y, z]: [u32; 3]| (12..18).contains(&x) && (12..16).contains(&y) && (10..20).contains(&z);
        let bodies: [Vec<_>; 2] = [
            cube(32).filter(|&v| is_floor(v)).map(turned).collect(),
            cube(32).filter(|&v| is_box(v)).map(turned).collect(),
        ];
        let eye = GRID.to_world(turned_f64([50.0, 45.0, 70.0]));
        let target = GRID.to_world(turned_f64([15.0, 6.0, 15.0]));
        let camera = Camera { eye, target, up: turned_f64([0.0, 1.0, 0.0]), fov_y: 35.0 };
        let scene = Scene::new(bodies.concat().into_iter(), GRID, camera);

        let high = lamp(&GRID, turned_f64([22.0, 29.5, 8.5]));
        let between = lamp(&GRID, turned_f64([14.0, 8.0, 16.0]));
        let slanted = sun(turned_f64([-0.7, 1.3, 0.4]));
        let shadowless = Light { shadow: false, ..high };
        let seen = scene.seen();
        for lights in [&[high][..], &[slanted], &[between], &[slanted, high, between], &[slanted, shadowless]] {
            let (found, counters) = scene.drawn(NormalKind::Face, Samples::One, lights);
            let (mut rays, mut close, mut cases) = (0, 0, [0; 2]);
            for (pixel, hit) in seen.iter().enumerate() {
                let Some((query, hit)) = hit else { continue };
                let place = add_scaled(query.origin, query.dir, hit.t);
                let surface = Surface {
                    point: GRID.to_world(place),
                    normal: hit.face.normal(),
                    view: normalize(query.dir).unwrap().map(|x| -x as f32),
                };
                // What is convex does not shade itself: a body is shaded by the other.
                let on_floor = bodies[0].contains(&hit.voxel.decode());
                let others = &bodies[usize::from(on_floor)];
                let mut reaching = Vec::new();
                let mut unclear = false;
                for light in lights {
                    if light.falls_on(&surface).is_none() {
                        continue;
                    }
                    rays += u64::from(light.shadow);
                    let [surely, perhaps] = in_the_way(others, place, &light.kind, 1e-6);
                    unclear |= light.shadow && surely != perhaps;
                    let blocked = light.shadow && surely;
                    cases[usize::from(blocked)] += usize::from(on_floor);
                    if !blocked {
                        reaching.push(*light);
                    }
                }
                if unclear {
                    close += 1;
                    continue;
                }
                let mut mean = Mean::default();
                mean.add(shade(&SHINY, &surface, Settings::default().ambient, &reaching).map(quantize));
                let [r, g, b] = mean.srgb8();
                assert_eq!(found[pixel].to_le_bytes(), [r, g, b, 255], "up {up}, {lights:?}: pixel {pixel}, {hit:?}");
            }
            assert_eq!(counters.shadow, rays, "up {up}, {lights:?}");
            assert!(close < 5 && cases[0] > 500, "{close} pixels are too close to call, {cases:?}");
            // The lamp under the box sees all of the floor.
            assert!(if lights == [between] { cases[1] == 0 } else { cases[1] > 50 }, "up {up}, {lights:?}: {cases:?}");
        }
    }
}

#[test]
fn what_nothing_shades_is_drawn_as_without_shadows() {
    let lights = [sun([0.3, 1.0, -0.2]), lamp(&GRID, [9.0, 44.0, 3.0])];
    let eye_above = |height: f64| Camera {
        eye: GRID.to_world([16.5, height, 15.5]),
        target: GRID.to_world([15.0, 0.0, 18.0]),
        up: [0.0, 0.0, 1.0],
        fov_y: 40.0,
    };
    // A floor from wall to wall of the cube, seen from inside; and one on its upper side, seen from outside, where rays that
    // start on the voxels' sides are not even traced to know that nothing is in the way.
    for (layer, camera) in [(3, eye_above(25.0)), (31, eye_above(50.0))] {
        let scene = Scene::new(cube(32).filter(|v| v[1] == layer), GRID, camera);
        for normals in [NormalKind::Face, NormalKind::Plane2] {
            let (found, counters) = scene.drawn(normals, Samples::Four, &lights);
            let (expected, plain) = scene.drawn(normals, Samples::Four, &without_shadows(&lights));
            assert!(found == expected, "layer {layer}, {normals:?}");
            let shadow = if (layer, normals) == (31, NormalKind::Face) { 0 } else { 2 * plain.hits };
            assert_eq!(counters, Counters { shadow, ..plain });
            assert_eq!(plain.hits, plain.primary);
        }
    }
}

/// However a plane is tilted, its steps do not shade it: `|nx| + |ny| + |nz|` voxels above a hit there are none of them.
#[test]
fn a_tilted_floor_is_drawn_as_without_shadows() {
    const SEED: u64 = 6;
    let mut rng = Rng::new(SEED);
    let mut stepped = 0;
    for _ in 0..12 {
        // Through the middle of the cube; its voxels are those whose corners are not all on one side.
        let normal = normalize([rng.uniform(-0.8, 0.8), 1.0, rng.uniform(-0.8, 0.8)]).unwrap();
        let height = |v: [u32; 3], corner: [u32; 3]| dot([0, 1, 2].map(|i| f64::from(v[i] + corner[i]) - 16.1), normal);
        let is_floor = |&v: &[u32; 3]| {
            let mut sides = cube(2).map(|corner| height(v, corner) > 0.0);
            let first = sides.next();
            sides.any(|above| Some(above) != first)
        };
        let eye = GRID.to_world(add_scaled([16.1; 3], normal, 9.0));
        let camera = Camera { eye, target: GRID.to_world([16.1; 3]), up: [0.3, 0.1, 1.0], fov_y: 50.0 };
        let scene = Scene::new(cube(32).filter(is_floor), GRID, camera);
        // The lowest light is 75 degrees off the normal.
        let across = normalize(sub([0.0, 0.0, 1.0], normal.map(|x| x * normal[2]))).unwrap();
        for slant in [0.0, 1.0, -1.0, 3.7, -3.7] {
            let lights = [sun(add_scaled(normal, across, slant))];
            let (found, counters) = scene.drawn(NormalKind::Plane2, Samples::One, &lights);
            let (expected, plain) = scene.drawn(NormalKind::Plane2, Samples::One, &without_shadows(&lights));
            let wrong = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
            assert_eq!((wrong, counters.shadow), (0, plain.hits), "seed {SEED}: {normal:?}, {slant}");
            let (sides, _) = scene.drawn(NormalKind::Face, Samples::One, &lights);
            let (unshaded, _) = scene.drawn(NormalKind::Face, Samples::One, &without_shadows(&lights));
            stepped += usize::from(sides != unshaded);
        }
    }
    assert!(stepped > 20, "seed {SEED}: only {stepped} pictures of the steps have shadows");
}

/// Between two balls' shells, closed and as thin as can be, so close that above the steps of one lies the other: no light
/// from outside gets in.
#[test]
fn no_light_passes_a_closed_wall() {
    const SEED: u64 = 8;
    let mut rng = Rng::new(SEED);
    let center = [32.3, 31.8, 32.1];
    let passes = |v: [u32; 3], radius: f64| {
        let mut sides = cube(2).map(|corner| {
            let from_center = [0, 1, 2].map(|i| f64::from(v[i] + corner[i]) - center[i]);
            dot(from_center, from_center) > radius * radius
        });
        let first = sides.next();
        sides.any(|outside| Some(outside) != first)
    };
    let grid = Grid { resolution: 64, ..GRID };
    let (mut rays, mut pictures) = (0, 0);
    for gap in [2.3, 3.0, 4.0] {
        let shells: Vec<_> = cube(64).filter(|&v| passes(v, 20.0) || passes(v, 20.0 + gap)).collect();
        for _ in 0..12 {
            // From an empty voxel in the gap along it.
            let out = normalize(rng.direction()).unwrap();
            let eye = add_scaled(center, out, 20.0 + 0.5 * gap);
            if shells.contains(&eye.map(|x| x as u32)) {
                continue;
            }
            let across = normalize(voxdag::math::cross(out, [0.3, 1.0, 0.2])).unwrap();
            let [eye, target] = [eye, add_scaled(eye, across, 9.0)].map(|p| grid.to_world(p));
            let camera = Camera { eye, target, up: out, fov_y: 80.0 };
            let scene = Scene::new(shells.iter().copied(), grid, camera);
            let lights = [sun(out), sun(add_scaled(out, across, 1.0)), lamp(&grid, add_scaled(center, out, 40.0))];
            for normals in [NormalKind::Face, NormalKind::Plane2] {
                let (found, counters) = scene.drawn(normals, Samples::One, &lights);
                let (dark, _) = scene.drawn(normals, Samples::One, &[]);
                assert!(found == dark, "seed {SEED}: gap {gap}, {normals:?}, {camera:?}");
                rays += counters.shadow;
                pictures += 1;
            }
        }
    }
    assert!(rays > 50_000 && pictures > 30, "{rays} rays in {pictures} pictures");
}

/// A ball is convex, so where it faces the light nothing shades it. Its voxels are steps, and shade each other.
#[test]
fn a_ball_shades_its_own_lit_side_so_much_and_no_more() {
    let grid = Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 128 };
    let from_center = |v: [u32; 3]| v.map(|c| f64::from(c) + 0.5 - 64.2);
    let ball = cube(128).filter(|&v| dot(from_center(v), from_center(v)) <= 55.0 * 55.0);
    let camera = Camera::framing(&Bounds { min: [9.2; 3], max: [119.2; 3] }, UpAxis::Y);
    let towards_eye = normalize(sub(camera.eye, camera.target)).unwrap();
    let scene = Scene::new(ball, grid, Camera { fov_y: 30.0, ..camera });
    let right = [1.2, 0.0, -1.0];
    let turned = |degrees: f64| {
        let radians = degrees.to_radians();
        let across = normalize(right).unwrap();
        add_scaled(across.map(|x| x * libm::sin(radians)), towards_eye, libm::cos(radians))
    };
    // Degrees between the light and the camera; the share of the rays to the light that are blocked: none with fitted
    // normals, and with those of the voxels' sides where the next step is in the way.
    for (degrees, [fitted, sides]) in
        [(0.0, [0.0, 0.0]), (30.0, [0.0, 0.037]), (60.0, [0.0, 0.179]), (90.0, [0.0, 0.371])]
    {
        for (normals, most) in [(NormalKind::Plane2, fitted), (NormalKind::Face, sides)] {
            let light = [sun(turned(degrees))];
            let (shaded, counters) = scene.drawn(normals, Samples::One, &light);
            let (lit, _) = scene.drawn(normals, Samples::One, &without_shadows(&light));
            let wrong = shaded.iter().zip(&lit).filter(|(a, b)| a != b).count();
            let share = wrong as f64 / counters.shadow as f64;
            println!("{degrees} degrees, {normals:?}: {wrong} of {} samples, {share:.4}", counters.shadow);
            assert!(counters.shadow > 1000 && share <= most, "{degrees} degrees, {normals:?}: {share}");
        }
    }
}
