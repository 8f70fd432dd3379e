//! Laws of effects: which a scene calls for, that others cost nothing, and what mirrors and glass show, by hand.

use std::collections::HashSet;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use voxdag::camera::Camera;
use voxdag::color::{Mean, quantize};
use voxdag::effects::Effects;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::material::MaterialId;
use voxdag::math::{add_scaled, dot, normalize, sub};
use voxdag::normal::NormalKind;
use voxdag::render::{
    Counters, Full, Kernel, Phong, RenderError, Samples, Settings, Shadows, View, each_pixel, render_rows,
    render_rows_by,
};
use voxdag::shade::{Light, LightKind};
use voxdag::simd::Level;
use voxdag::trace::{Hit, Query, TopBuf, Tracer};
use voxdag::wide::WideBuf;
use voxdag::{Dag, Grid, Material, Materials, Morton};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;

const SIZE: [u32; 2] = [72, 48];
/// 64 voxels a side, with a corner off the world's origin.
const GRID: Grid = Grid { origin: [-3.0, 5.0, 2.5], voxel_size: 0.25, resolution: 64 };
const WHITE: [f32; 3] = [1.0; 3];
const BLACK: [f32; 3] = [0.0; 3];
/// Sends nothing of its own.
const DARK: Material = Material { ambient: BLACK, diffuse: BLACK, ..Material::GREY };

fn cube(side: u32) -> impl Iterator<Item = [u32; 3]> {
    (0..side).flat_map(move |z| (0..side).flat_map(move |y| (0..side).map(move |x| [x, y, z])))
}

/// The material of each voxel, by its place.
#[derive(Clone, Copy)]
struct Placed(fn([u32; 3]) -> MaterialId);

impl Materials for Placed {
    fn id(&self, voxel: Morton) -> MaterialId {
        self.0(voxel.decode())
    }

    fn normal(&self, _: Morton) -> Option<[f32; 3]> {
        None
    }

    fn color(&self, voxel: Morton) -> Option<[u8; 3]> {
        Some(color_of(voxel.decode()))
    }
}

/// The colour of each voxel's texture.
fn color_of(voxel: [u32; 3]) -> [u8; 3] {
    voxel.map(|c| (c * 67 % 256) as u8)
}

type IsFilled<'a> = &'a dyn Fn([u32; 3]) -> bool;
type Change = fn(&mut Material);
type Draw<'a> = fn(&View<'a, Placed>, &Settings, Range<u32>, &mut [u32]) -> Result<Counters, RenderError>;

struct Scene {
    words: Vec<u32>,
    materials: Placed,
    palette: Vec<Material>,
    lights: Vec<Light>,
    camera: Camera,
}

impl Scene {
    /// Seen from one place in the grid to another.
    fn new(
        is_filled: impl Fn([u32; 3]) -> bool,
        id: fn([u32; 3]) -> MaterialId,
        palette: &[Material],
        [eye, target]: [[f64; 3]; 2],
    ) -> Scene {
        let [eye, target] = [eye, target].map(|place| GRID.to_world(place));
        Scene {
            words: VoxelSet::new(cube(64).filter(|&voxel| is_filled(voxel))).words(6),
            materials: Placed(id),
            palette: palette.to_vec(),
            lights: Vec::new(),
            camera: Camera { eye, target, up: [0.1, 1.0, 0.2], fov_y: 40.0 },
        }
    }

    fn drawn(&self, settings: &Settings) -> (Vec<u32>, Counters) {
        self.drawn_with(settings, render_rows)
    }

    /// By a kernel that is named.
    fn drawn_by<K: Kernel>(&self, settings: &Settings) -> (Vec<u32>, Counters) {
        self.drawn_with(settings, render_rows_by::<K, _, _>)
    }

    fn drawn_with<'a>(&'a self, settings: &Settings, draw: Draw<'a>) -> (Vec<u32>, Counters) {
        let Scene { materials, ref palette, ref lights, camera, .. } = *self;
        let tracer = Tracer::new(Dag::new(&self.words).unwrap());
        let view = View { tracer, materials, palette, grid: GRID, camera, lights };
        let mut out = vec![0; (settings.width * settings.height) as usize];
        let counters = draw(&view, settings, 0..settings.height, &mut out).unwrap();
        (out, counters)
    }

    /// The ray through each pixel's middle, and what it meets.
    fn seen(&self) -> Vec<(Query, Option<Hit>)> {
        let dag = Dag::new(&self.words).unwrap();
        let mut out = vec![(Query::new([0.0; 3], [1.0; 3]), None); (SIZE[0] * SIZE[1]) as usize];
        each_pixel(&self.camera, &GRID, SIZE, 0..SIZE[1], &mut out, |pixel| {
            let query = pixel.query([0.5; 2]);
            (query, dag.trace(&query))
        })
        .unwrap();
        out
    }
}

fn settings(normals: NormalKind) -> Settings {
    // In this light a surface sends its Ka.
    Settings { width: SIZE[0], height: SIZE[1], normals, ambient: WHITE, ..Settings::default() }
}

fn pixel(color: [f32; 3]) -> u32 {
    let mut mean = Mean::default();
    mean.add(color.map(quantize));
    let [r, g, b] = mean.srgb8();
    u32::from_le_bytes([r, g, b, 255])
}

/// Whether a pixel is of a colour, up to the rounding of some shares to 1/65535.
fn is_color(found: u32, color: [f32; 3]) -> bool {
    [-3.0, 0.0, 3.0].iter().any(|slack| found == pixel(color.map(|x| x + slack / 65_535.0)))
}

fn mix(a: [f32; 3], b: [f32; 3], share: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| a[i] + share[i] * b[i])
}

#[test]
fn models_call_for_what_the_table_says() {
    // All that a material can have.
    let full = Material { specular: [0.5; 3], emission: [0.1; 3], opacity: 0.5, refraction: 1.5, ..Material::GREY };
    let with_light = [Light { kind: LightKind::Point([0.0; 3]), color: WHITE, shadow: false }];
    let needed = |material: Material| {
        let material = material.checked().unwrap();
        assert_eq!(Effects::needed(&[material], &with_light), Effects::of(&material));
        Effects::of(&material).names().collect::<Vec<_>>().join(" ")
    };
    let table = [
        (0, "transparency emission"),
        (1, "transparency emission"),
        (2, "specular transparency emission"),
        (3, "specular mirror transparency emission"),
        (4, "specular mirror transparency emission"),
        (5, "specular mirror transparency emission"),
        (6, "specular mirror transparency refraction emission"),
        (7, "specular mirror transparency refraction emission"),
        (8, "specular transparency emission"),
        (9, "specular transparency emission"),
        (10, "specular transparency emission"),
    ];
    for (illum, expected) in table {
        let material = Material { illum, ..full };
        assert_eq!(needed(material), expected, "illum {illum}");
        let without = |name: &str| {
            expected.split(' ').filter(|n| *n != name && (name != "transparency" || *n != "refraction")).collect()
        };
        let cases: [(Material, Vec<&str>); 4] = [
            (Material { emission: BLACK, ..material }, without("emission")),
            (Material { opacity: 1.0, ..material }, without("transparency")),
            (Material { refraction: 1.0, ..material }, without("refraction")),
            (Material { refraction: 0.0, ..material }, without("refraction")),
        ];
        for (material, expected) in cases {
            assert_eq!(needed(material), expected.join(" "), "{material:?}");
        }
        let dull = expected.split(' ').filter(|n| !["specular", "mirror"].contains(n)).collect::<Vec<_>>();
        assert_eq!(needed(Material { specular: BLACK, ..material }), dull.join(" "));
        // What exporters write where nothing is meant.
        for transmission in [BLACK, WHITE] {
            assert_eq!(needed(Material { illum, transmission, ..Material::GREY }), "", "illum {illum}");
        }
        // A colour of what comes through is meant where the model has one.
        let stained = Material { illum, transmission: [1.0, 0.5, 0.5], ..Material::GREY };
        assert_eq!(needed(stained), if [4, 6, 7, 9].contains(&illum) { "transparency" } else { "" });
    }
    // Lights: no highlight without one, and shadows if one of them casts some.
    let shiny = [Material::GREY, Material { specular: WHITE, illum: 2, ..Material::GREY }];
    assert_eq!(Effects::needed(&shiny, &[]), Effects::NONE);
    assert_eq!(Effects::needed(&shiny, &with_light), Effects::PHONG);
    let both = [with_light[0], Light { shadow: true, ..with_light[0] }];
    assert_eq!(Effects::needed(&shiny[..1], &both), Effects::SHADOWS);
    assert_eq!(Effects::needed(&[], &[]), Effects::NONE);
}

#[test]
fn a_floor_mirrors_a_wall_in_its_place() {
    const WALL: [f32; 3] = [0.8, 0.2, 0.1];
    const OWN: [f32; 3] = [0.05, 0.1, 0.15];
    let palette =
        [Material { ambient: OWN, specular: [0.5, 0.25, 0.75], illum: 3, ..DARK }, Material { ambient: WALL, ..DARK }];
    let scene = Scene::new(
        |[_, y, z]| y == 10 || z == 5 && (10..30).contains(&y),
        |[_, y, z]| MaterialId::from(z == 5 && y != 10),
        &palette,
        [[31.0, 40.0, 90.0], [30.0, 11.0, 30.0]],
    );
    let background = Settings::default().background;
    // With fitted normals the image may be as far off as the place above the floor where the rays start.
    for (normals, slack) in [(NormalKind::Face, 1e-6), (NormalKind::Plane2, 2.5)] {
        let (found, counters) = scene.drawn(&settings(normals));
        let (mut walls, mut skies, mut floor) = (0, 0, 0);
        for (i, (query, hit)) in scene.seen().into_iter().enumerate() {
            let Some(hit) = hit else { continue };
            let [x, y, z] = hit.voxel.decode();
            // Where planes end fitted normals lean.
            if y != 10 || z < 9 || !(3..61).contains(&x) || z > 60 || hit.face != voxdag::trace::Face::PosY {
                continue;
            }
            floor += 1;
            let place = add_scaled(query.origin, query.dir, hit.t);
            let t = (6.0 - place[2]) / query.dir[2];
            let [x, y] = [place[0] + t * query.dir[0], 11.0 - t * query.dir[1]];
            let inside = |slack: f64| (-slack..64.0 + slack).contains(&x) && y < 30.0 + slack;
            if inside(-slack) {
                walls += 1;
                let expected = mix(OWN, WALL, palette[0].specular);
                assert!(is_color(found[i], expected), "{normals:?}: {:?}, {expected:?}", found[i].to_le_bytes());
            } else if !inside(slack) {
                skies += 1;
                assert!(is_color(found[i], mix(OWN, background, palette[0].specular)), "{normals:?}: pixel {i}");
            }
        }
        assert!(walls > 200 && skies > 200, "{walls} {skies}");
        assert!(counters.secondary >= floor && counters.secondary <= counters.hits, "{counters:?}");
    }
}

/// Between mirrors on all sides no ray gets out: it is followed as often as may be, and no more.
#[test]
fn rays_go_on_eight_times() {
    let is_wall = |v: [u32; 3]| v.iter().any(|&x| x == 10 || x == 50) && v.iter().all(|x| (10..=50).contains(x));
    for illum in [3, 4, 5] {
        let mirror = Material { ambient: [0.25; 3], specular: [0.5; 3], illum, ..DARK };
        let scene = Scene::new(is_wall, |_| 0, &[mirror], [[30.0, 33.0, 45.0], [31.0, 27.0, 11.0]]);
        for normals in [NormalKind::Face, NormalKind::Plane2] {
            let (found, counters) = scene.drawn(&settings(normals));
            assert_eq!((counters.hits, counters.secondary), (counters.primary, 8 * counters.primary), "{normals:?}");
            // Fresnel's mirrors send back more.
            let expected = 0.25 * (2.0 - libm::exp2f(-8.0));
            let darker = |p: &u32| p.to_le_bytes()[0] < pixel([expected; 3]).to_le_bytes()[0];
            assert!(if illum == 5 {
                !found.iter().any(darker)
            } else {
                found.iter().all(|p| is_color(*p, [expected; 3]))
            });
        }
        // A dull one is left sooner: 0.25^5 is less than 1/512.
        let dull = Scene { palette: vec![Material { specular: [0.25; 3], illum: 3, ..mirror }], ..scene };
        let (_, counters) = dull.drawn(&settings(NormalKind::Face));
        assert_eq!(counters.secondary, 4 * counters.primary);
    }
}

/// As many rays as there can be: every surface sends on two, and none of them gets lost.
#[test]
fn rays_that_branch_everywhere_find_room() {
    let is_filled = |v: [u32; 3]| {
        let shell = v.iter().any(|&x| x == 5 || x == 59) && v.iter().all(|x| (5..=59).contains(x));
        shell || v[2].is_multiple_of(6) && v.iter().all(|x| (5..=59).contains(x))
    };
    let glass = Material { ambient: [0.01; 3], specular: WHITE, opacity: 0.0, illum: 4, ..DARK };
    let wall = Material { ambient: [0.01; 3], specular: WHITE, illum: 3, ..DARK };
    let id = |v: [u32; 3]| MaterialId::from(v.iter().any(|&x| x == 5 || x == 59));
    let scene = Scene::new(is_filled, id, &[glass, wall], [[30.0, 33.0, 33.0], [31.0, 29.0, 11.0]]);
    let settings = Settings { width: 24, height: 12, samples: Samples::Four, ..settings(NormalKind::Face) };
    let (_, counters) = scene.drawn(&settings);
    assert!(counters.secondary > 200 * counters.primary, "{counters:?}");
}

const WALL: [f32; 3] = [0.9, 0.6, 0.3];

/// A pane in front of a wall at z = 5.
fn pane(id: fn([u32; 3]) -> MaterialId, is_pane: impl Fn([u32; 3]) -> bool, glass: Material, eye: [f64; 3]) -> Scene {
    let wall = Material { ambient: WALL, ..DARK };
    Scene::new(|v| v[2] == 5 || is_pane(v), id, &[wall, glass], [eye, [31.0, 30.0, 20.0]])
}

#[test]
fn a_pane_is_one_surface_however_thick() {
    let own = [0.2, 0.4, 0.6];
    for (illum, tf) in [(4, [1.0, 0.5, 0.25]), (9, [1.0, 0.5, 0.25]), (2, WHITE), (1, WHITE), (0, WHITE)] {
        let glass = Material { ambient: own, opacity: 0.25, transmission: [1.0, 0.5, 0.25], illum, ..DARK };
        let expected = mix(own.map(|x| 0.25 * x), WALL, tf.map(|x| 0.75 * x));
        for eye in [[31.0, 30.0, 63.5], [55.0, 40.0, 50.0], [31.0, 30.0, 90.0]] {
            for thick in 1..=3 {
                for normals in [NormalKind::Face, NormalKind::Plane2] {
                    let scene = pane(|v| MaterialId::from(v[2] != 5), |v| (33 - thick..33).contains(&v[2]), glass, eye);
                    let (found, counters) = scene.drawn(&settings(normals));
                    let (mut panes, mut through) = (0, 0);
                    for (i, (query, hit)) in scene.seen().into_iter().enumerate() {
                        let Some(hit) = hit else { continue };
                        if hit.face != voxdag::trace::Face::PosZ || hit.voxel.decode()[2] != 32 {
                            continue;
                        }
                        panes += 1;
                        let t = (6.0 - query.origin[2]) / query.dir[2];
                        let wall = add_scaled(query.origin, query.dir, t);
                        if (0..2).all(|k| (0.0..64.0).contains(&wall[k])) {
                            through += 1;
                            assert!(is_color(found[i], expected), "illum {illum}, {thick}, {eye:?}: {hit:?}");
                        }
                    }
                    // What leaves the cube in the pane meets nothing.
                    assert!((through..=panes).contains(&counters.secondary), "{counters:?}, {through} of {panes}");
                    assert!(through > 1000, "{through}");
                }
            }
        }
    }
}

/// Panes at a slant are steps: one surface, too, also where a ray meets several of them.
#[test]
fn a_tilted_pane_is_one_surface() {
    const SEED: u64 = 11;
    let mut rng = Rng::new(SEED);
    let glass = Material { ambient: BLACK, opacity: 0.25, illum: 4, ..DARK };
    let expected = WALL.map(|x| 0.75 * x);
    let mut seen = 0;
    for _ in 0..12 {
        let normal = normalize([rng.uniform(-0.9, 0.9), rng.uniform(-0.9, 0.9), 1.0]).unwrap();
        let is_pane = |v: [u32; 3]| {
            let height = |corner: [u32; 3]| dot([0, 1, 2].map(|i| f64::from(v[i] + corner[i]) - 32.1), normal);
            let mut sides = cube(2).map(|corner| height(corner) > 0.0);
            let first = sides.next();
            v.iter().all(|x| (12..52).contains(x)) && sides.any(|above| Some(above) != first)
        };
        for slant in [0.0, 1.0, 2.5] {
            let across = normalize(sub([0.0, 1.0, 0.0], normal.map(|x| x * normal[1]))).unwrap();
            let eye = add_scaled([32.0; 3], normalize(add_scaled(normal, across, slant)).unwrap(), 28.0);
            let wall = Material { ambient: WALL, ..DARK };
            // All around, so that it is behind every pane.
            let is_wall = |v: [u32; 3]| v.iter().any(|&x| x == 0 || x == 63);
            let id = |v: [u32; 3]| MaterialId::from(!v.iter().any(|&x| x == 0 || x == 63));
            let scene = Scene::new(|v| is_wall(v) || is_pane(v), id, &[wall, glass], [eye, [32.0; 3]]);
            let settings = settings(NormalKind::Plane2);
            let (found, _) = scene.drawn(&settings);
            let (mut panes, mut wrong) = (0, 0);
            for (i, (query, hit)) in scene.seen().into_iter().enumerate() {
                let Some(hit) = hit else { continue };
                // Away from the edges, where normals lean.
                let place = add_scaled(query.origin, query.dir, hit.t);
                let t = dot(sub([32.1; 3], query.origin), normal) / dot(query.dir, normal);
                let middle = add_scaled(query.origin, query.dir, t);
                let inner = [place, middle].iter().flatten().all(|x| (16.0..48.0).contains(x));
                if inner && is_pane(hit.voxel.decode()) {
                    panes += 1;
                    wrong += usize::from(!is_color(found[i], expected));
                }
            }
            assert_eq!(wrong, 0, "seed {SEED}: of {panes} pixels, {normal:?}, {slant}");
            seen += panes;
        }
    }
    assert!(seen > 20_000, "{seen} pixels");
}

/// A wall in stripes along x, so that colours tell where a ray arrives.
fn striped(is_glass: impl Fn([u32; 3]) -> bool, glass: Material, eye: [f64; 3]) -> Scene {
    let mut palette: Vec<_> = (0..64).map(|i| Material { ambient: [(i + 1) as f32 / 80.0; 3], ..DARK }).collect();
    palette.push(glass);
    let id = |v: [u32; 3]| if v[2] == 5 { v[0] as MaterialId } else { 64 };
    Scene::new(|v| v[2] == 5 || is_glass(v), id, &palette, [eye, [31.0, 30.0, 20.0]])
}

#[test]
fn a_slab_shifts_what_is_behind_it_as_snell_says() {
    for ni in [1.5f32, 1.2, 0.8] {
        let glass = Material { opacity: 0.0, refraction: ni, illum: 6, ..DARK };
        // Two sheets 20 apart, whose sides towards the ray count, and a filled block from 41 down to 20.
        let sheets = |v: [u32; 3]| v[2] == 40 || v[2] == 20;
        let block = |v: [u32; 3]| (20..=40).contains(&v[2]);
        let cases = [(&sheets as IsFilled<'_>, 20.0), (&block, 21.0)];
        for (is_glass, depth) in cases {
            let scene = striped(is_glass, glass, [40.0, 31.0, 80.0]);
            for normals in [NormalKind::Face, NormalKind::Plane2] {
                let (found, _) = scene.drawn(&settings(normals));
                let (mut bent, mut straight) = (0, 0);
                for (i, (query, hit)) in scene.seen().into_iter().enumerate() {
                    let Some(hit) = hit else { continue };
                    if hit.voxel.decode()[2] != 40 || hit.face != voxdag::trace::Face::PosZ {
                        continue;
                    }
                    let place = add_scaled(query.origin, query.dir, hit.t);
                    let dir = normalize(query.dir).unwrap();
                    // Sines shrink by Ni; how far to the side a ray gets goes with the tangent.
                    let sine = [dir[0] / f64::from(ni), dir[1] / f64::from(ni)];
                    let cosine = (1.0 - sine[0] * sine[0] - sine[1] * sine[1]).sqrt();
                    let arrive = |slant: [f64; 2]| {
                        [0, 1].map(|k| place[k] + depth * slant[k] + (41.0 - depth - 6.0) * dir[k] / -dir[2])
                    };
                    let [x, y] = arrive(sine.map(|s| s / cosine));
                    let unbent = arrive([dir[0] / -dir[2], dir[1] / -dir[2]]);
                    let leaves_early = |p: &[f64; 2]| p.iter().any(|c| !(1.0..63.0).contains(c));
                    if leaves_early(&[x, y]) || (x - x.round()).abs() < 1e-3 {
                        continue;
                    }
                    let stripe = |x: f64| [(x.floor() as f32 + 1.0) / 80.0; 3];
                    assert!(is_color(found[i], stripe(x)), "Ni {ni}, {depth}, {normals:?}: {x}, pixel {i}");
                    bent += usize::from(x.floor() != unbent[0].floor());
                    straight += usize::from(x.floor() == unbent[0].floor());
                }
                assert!(bent > 200 && straight > 20, "{bent} {straight}");
                // Without the effect light goes straight on.
                let off = Settings { effects: Effects::ALL.difference(Effects::REFRACTION), ..settings(normals) };
                let mut palette = scene.palette.clone();
                palette[64].refraction = 1.0;
                let unbent = Scene { palette, words: scene.words.clone(), lights: vec![], ..scene };
                assert_eq!(scene.drawn(&off).0, unbent.drawn(&settings(normals)).0);
            }
        }
    }
}

/// Where nothing gets through a surface mirrors, from outside and from inside, and that ends.
#[test]
fn total_internal_reflection_mirrors_and_ends() {
    // Thinner than air: beyond 30 degrees nothing gets in.
    let thin = Material { opacity: 0.0, refraction: 0.5, illum: 6, ..DARK };
    let scene = striped(|v| v[0] == 20, thin, [50.0, 31.0, 60.0]);
    let mirror = Scene {
        palette: [&scene.palette[..64], &[Material { specular: WHITE, illum: 3, ..DARK }]].concat(),
        words: scene.words.clone(),
        lights: vec![],
        ..scene
    };
    for normals in [NormalKind::Face, NormalKind::Plane2] {
        let [found, expected] = [&scene, &mirror].map(|scene| scene.drawn(&settings(normals)).0);
        let mut reflected = 0;
        for (i, (query, hit)) in scene.seen().into_iter().enumerate() {
            let Some(hit) = hit else { continue };
            let dir = normalize(query.dir).unwrap();
            if hit.face == voxdag::trace::Face::PosX && hit.voxel.decode()[2] != 5 && dir[0] > -0.8 {
                reflected += 1;
                assert_eq!(found[i], expected[i], "pixel {i}");
            }
        }
        assert!(reflected > 300, "{reflected}");
    }
    // Inside a ball and a box of glass, from where most rays do not get out.
    for is_ball in [true, false] {
        let from_center = |v: [u32; 3]| v.map(|x| f64::from(x) - 31.5);
        let shell = |v: [u32; 3]| {
            let c = from_center(v);
            let distance = if is_ball { dot(c, c).sqrt() } else { c[0].abs().max(c[1].abs()).max(c[2].abs()) };
            (24.0..25.5).contains(&distance)
        };
        for illum in [6, 7] {
            let glass = Material { specular: [0.04; 3], opacity: 0.1, refraction: 2.4, illum, ..DARK };
            let scene = striped(shell, glass, [33.0, 45.0, 40.0]);
            let outside = striped(shell, glass, [60.0, 55.0, 80.0]);
            for scene in [scene, outside] {
                let (_, counters) = scene.drawn(&settings(NormalKind::Plane2));
                assert!(counters.secondary > counters.hits, "{counters:?}");
            }
        }
    }
}

#[test]
fn glass_lets_coloured_light_through_its_shadow() {
    let glass = Material { opacity: 0.5, transmission: [1.0, 0.5, 0.0], illum: 4, ..DARK };
    let floor = Material { diffuse: WHITE, ..DARK };
    let is_pane = |[x, y, z]: [u32; 3]| y == 30 && (20..44).contains(&x) && (20..44).contains(&z);
    let scene = |opaque: bool| {
        let palette = [floor, if opaque { Material { opacity: 1.0, transmission: WHITE, ..glass } } else { glass }];
        let views = [[31.0, 25.0, 62.0], [31.0, 11.0, 31.0]];
        let id = |[_, y, _]: [u32; 3]| MaterialId::from(y == 30);
        let scene = Scene::new(|v| v[1] == 10 || is_pane(v), id, &palette, views);
        let light = Light { kind: LightKind::Directional([0.0, 1.0, 0.0]), color: [0.5; 3], shadow: true };
        Scene { lights: vec![light], ..scene }
    };
    for normals in [NormalKind::Face, NormalKind::Plane2] {
        let settings = Settings { ambient: BLACK, ..settings(normals) };
        for (opaque, shade) in [(true, BLACK), (false, [0.25, 0.125, 0.0])] {
            let scene = scene(opaque);
            let (found, counters) = scene.drawn(&settings);
            let (mut lit, mut shaded) = (0, 0);
            for (i, (query, hit)) in scene.seen().into_iter().enumerate() {
                let Some(hit) = hit else { continue };
                let [x, y, z] = hit.voxel.decode();
                if y != 10 || [x, z].iter().any(|c| !(3..61).contains(c)) {
                    continue;
                }
                let place = add_scaled(query.origin, query.dir, hit.t);
                // Where the fitted normal starts the ray is above the place.
                let below = [place[0], place[2]].iter().all(|c| (20.0..44.0).contains(c));
                let expected = if below { shade } else { [0.5; 3] };
                (lit, shaded) = (lit + usize::from(!below), shaded + usize::from(below));
                assert!(is_color(found[i], expected), "{normals:?}, {opaque}: {hit:?}");
            }
            assert!(lit > 200 && shaded > 200 && counters.shadow > 0, "{lit} {shaded}");
        }
    }
}

/// Ka and Kd of a textured material are multiplied by the colour of each voxel, in linear light.
#[test]
fn textures_color_what_is_matte() {
    let material = Material { ambient: [0.5, 0.25, 1.0], textured: true, ..DARK };
    let scene = Scene::new(|v| v[1] == 10, |_| 0, &[material], [[30.0, 60.0, 95.0], [31.0, 10.0, 32.0]]);
    let settings = settings(NormalKind::Face);
    let (found, counters) = scene.drawn(&settings);
    let mut hits = 0;
    for (i, (_, hit)) in scene.seen().into_iter().enumerate() {
        let Some(hit) = hit else { continue };
        hits += 1;
        let texel = color_of(hit.voxel.decode()).map(|byte| {
            let s = f64::from(byte) / 255.0;
            if s <= 0.04045 { s / 12.92 } else { libm::pow((s + 0.055) / 1.055, 2.4) }
        });
        let expected = [0, 1, 2].map(|k| material.ambient[k] * texel[k] as f32);
        assert!(is_color(found[i], expected), "{hit:?}");
    }
    assert!(hits > 1000 && counters.textures == hits, "{hits} {counters:?}");
    // As it is without the texture, where nobody asks for it.
    let plain = Scene { palette: vec![Material { textured: false, ..material }], ..scene };
    assert_eq!(Effects::needed(&plain.palette, &[]), Effects::NONE);
    assert_eq!(plain.drawn(&settings).1.textures, 0);
}

/// A palette that calls for everything, and a scene of small things in front of a floor.
fn everything(rng: &mut Rng) -> Scene {
    let mut color = |most: f64| [0; 3].map(|_| rng.uniform(0.0, most) as f32);
    let mut palette = Vec::new();
    for illum in [1, 2, 3, 4, 5, 6, 7, 9] {
        palette.push(Material {
            ambient: color(0.5),
            diffuse: color(0.8),
            specular: color(0.6),
            emission: color(0.2),
            transmission: color(1.0),
            shininess: 9,
            opacity: 0.4,
            refraction: 1.4,
            illum,
            textured: illum % 2 == 0,
        });
    }
    // Blocks of 3^3 voxels.
    let blocks = (0..300).map(|_| [0; 3].map(|_| 7 + rng.below(40) as u32));
    let voxels: HashSet<[u32; 3]> =
        blocks.flat_map(|block| cube(3).map(move |v| [0, 1, 2].map(|i| block[i] + v[i]))).collect();
    let is_filled = |v: [u32; 3]| v[1] == 4 || voxels.contains(&v);
    let id = |v: [u32; 3]| ((v[0] / 7 + v[1] / 5 + v[2] / 6) % 8) as MaterialId;
    let mut scene = Scene::new(is_filled, id, &palette, [[30.0, 45.0, 95.0], [28.0, 22.0, 28.0]]);
    let lamp = LightKind::Point(GRID.to_world([50.0, 60.0, 70.0]));
    scene.lights = vec![
        Light { kind: LightKind::Directional([-0.4, 1.0, 0.3]), color: [0.5, 0.4, 0.3], shadow: true },
        Light { kind: lamp, color: [0.3, 0.4, 0.5], shadow: false },
    ];
    scene
}

#[test]
fn what_is_off_costs_nothing_and_is_as_if_it_were_not_called_for() {
    const SEED: u64 = 21;
    let mut rng = Rng::new(SEED);
    let scene = everything(&mut rng);
    let with = |effects: Effects| scene.drawn(&Settings { effects, ..settings(NormalKind::Plane1) });
    let (full, all) = with(Effects::ALL);
    assert_eq!(Effects::needed(&scene.palette, &scene.lights), Effects::ALL);
    assert!(all.shadow > 0 && all.secondary > 0 && all.highlights > 0 && all.normals > all.hits, "{all:?}");

    let none = with(Effects::NONE).1;
    assert_eq!(none, Counters { primary: all.primary, hits: all.hits, normals: all.hits, ..Counters::default() });
    let goes_on = Effects::MIRROR.union(Effects::TRANSPARENCY);
    for effect in Effects::ALL.iter() {
        let (picture, off) = with(Effects::ALL.difference(effect));
        assert!(picture != full, "{effect:?} shows nowhere");
        let (_, on) = with(effect);
        let rays = [
            (Effects::SPECULAR, [off.highlights, on.highlights]),
            (Effects::SHADOWS, [off.shadow, on.shadow]),
            (Effects::TEXTURES, [off.textures, on.textures]),
        ];
        for (what, [off, on]) in rays {
            assert_eq!((off > 0, on > 0), (what != effect, what == effect), "{effect:?}: {what:?}");
        }
        assert_eq!(on.secondary > 0, goes_on.contains(effect), "{effect:?}");
        assert!(off.secondary > 0 && (!goes_on.contains(effect) || off.secondary < all.secondary), "{effect:?}");
    }
    assert_eq!(with(Effects::ALL.difference(goes_on)).1.secondary, 0);
    // Sides need no normals.
    let sides = scene.drawn(&settings(NormalKind::Face)).1;
    assert_eq!(sides.normals, 0);

    // The same picture from materials and lights that do not call for it.
    let changed = |change: fn(&mut Material), shadow: bool| {
        let mut palette = scene.palette.clone();
        palette.iter_mut().for_each(change);
        let lights = scene.lights.iter().map(|light| Light { shadow: light.shadow && shadow, ..*light }).collect();
        let changed = Scene { palette, lights, words: scene.words.clone(), ..scene };
        (changed.drawn(&settings(NormalKind::Plane1)), Effects::needed(&changed.palette, &changed.lights))
    };
    let cases: [(Effects, Change, bool); 6] = [
        (Effects::TEXTURES, |m| m.textured = false, true),
        (Effects::SHADOWS, |_| (), false),
        (Effects::EMISSION, |m| m.emission = BLACK, true),
        (Effects::REFRACTION, |m| m.refraction = 1.0, true),
        (Effects::TRANSPARENCY.union(Effects::REFRACTION), |m| (m.opacity, m.transmission) = (1.0, WHITE), true),
        (Effects::SPECULAR.union(Effects::MIRROR), |m| m.specular = BLACK, true),
    ];
    for (effects, change, shadow) in cases {
        let (drawn, needed) = changed(change, shadow);
        assert_eq!(needed, Effects::ALL.difference(effects));
        assert!(drawn == with(needed), "{effects:?}");
    }
}

/// The renderer does nothing but what materials and lights call for: to have more at hand changes no byte and no count.
#[test]
fn more_than_is_needed_changes_nothing() {
    const SEED: u64 = 31;
    let mut rng = Rng::new(SEED);
    for round in 0..24 {
        let mut scene = everything(&mut rng);
        // Some of the effects.
        let set = rng.bits();
        for material in &mut scene.palette {
            if set & 1 == 0 {
                material.emission = BLACK;
            }
            if set & 2 == 0 {
                (material.opacity, material.transmission) = (1.0, WHITE);
            }
            if set & 4 == 0 {
                material.refraction = 1.0;
            }
            if set & 8 == 0 {
                material.specular = BLACK;
            }
            if set & 32 == 0 {
                material.textured = false;
            }
        }
        scene.lights[0].shadow = set & 16 != 0;
        let settings = settings([NormalKind::Face, NormalKind::Plane2][round % 2]);
        let expected = scene.drawn(&settings);
        let needed = Effects::needed(&scene.palette, &scene.lights);
        assert!(scene.drawn(&Settings { effects: needed, ..settings }) == expected);

        // A material that no voxel has, and a black light, call for all the rest.
        let full = Material { specular: WHITE, emission: WHITE, opacity: 0.5, refraction: 2.0, illum: 7, ..DARK };
        let full = Material { textured: true, ..full };
        scene.palette.push(full);
        scene.lights.push(Light { kind: LightKind::Point([0.0; 3]), color: BLACK, shadow: true });
        assert_eq!(Effects::needed(&scene.palette, &scene.lights), Effects::ALL);
        let (found, counters) = scene.drawn(&settings);
        assert!(found == expected.0, "seed {SEED}, round {round}: {needed:?}");
        assert_eq!(counters.secondary, expected.1.secondary);
    }
}

/// Mirrors alone, as a program might name them.
struct Mirrors;

impl Kernel for Mirrors {
    const EFFECTS: Effects = Effects::PHONG.union(Effects::MIRROR);
}

/// Rays that go on, without what only colours them.
struct Glass;

impl Kernel for Glass {
    const EFFECTS: Effects = Effects::TRANSPARENCY.union(Effects::REFRACTION).union(Effects::SHADOWS);
}

/// Has a clock, by which all that is called for takes its time.
struct Timed;

impl Kernel for Timed {
    const EFFECTS: Effects = Effects::ALL;

    fn now() -> u64 {
        static CALLS: AtomicU64 = AtomicU64::new(0);
        CALLS.fetch_add(1, Ordering::Relaxed)
    }
}

/// On random scenes: the full kernel is the specification, whatever the narrower one leaves out.
#[test]
fn kernels_draw_what_the_full_one_does() {
    fn agrees<K: Kernel>(scene: &Scene, settings: &Settings, called_for: Effects) -> bool {
        let found = scene.drawn_by::<K>(settings);
        let effects = settings.effects.intersection(K::EFFECTS);
        assert!(
            found == scene.drawn_by::<Full>(&Settings { effects, ..*settings }),
            "{:?} of {called_for:?}",
            K::EFFECTS
        );
        let is_enough = K::EFFECTS.contains(called_for);
        assert!(!is_enough || found == scene.drawn(settings), "{:?} for {called_for:?}", K::EFFECTS);
        is_enough
    }
    const SEED: u64 = 51;
    let mut rng = Rng::new(SEED);
    let mut enough = [0; 5];
    for round in 0..40 {
        let mut scene = everything(&mut rng);
        // Few effects are often called for.
        let set = rng.bits() & rng.bits() | 1 << (round % 7);
        let off = |effect: u32| set >> effect & 1 == 0;
        for material in &mut scene.palette {
            if off(0) {
                material.emission = BLACK;
            }
            if off(1) {
                (material.opacity, material.transmission) = (1.0, WHITE);
            }
            if off(2) {
                material.refraction = 1.0;
            }
            if off(3) {
                material.specular = BLACK;
            }
            material.textured &= !off(6);
            if off(5) && matches!(material.illum, 3..=7) {
                material.illum = 2;
            }
        }
        scene.lights[0].shadow = !off(4);
        let settings = settings([NormalKind::Face, NormalKind::Plane2][round % 2]);
        let called_for = Effects::needed(&scene.palette, &scene.lights);
        let agreed = [
            agrees::<Phong>(&scene, &settings, called_for),
            agrees::<Shadows>(&scene, &settings, called_for),
            agrees::<Mirrors>(&scene, &settings, called_for),
            agrees::<Glass>(&scene, &settings, called_for),
            agrees::<Full>(&scene, &settings, called_for),
        ];
        enough.iter_mut().zip(agreed).for_each(|(sum, enough)| *sum += u32::from(enough));

        // A clock changes nothing but the times, and those of what is not called for are 0.
        let (picture, timed) = scene.drawn_by::<Timed>(&settings);
        let (expected, counters) = scene.drawn(&settings);
        assert!(picture == expected && Counters { shadow_time: 0, secondary_time: 0, ..timed } == counters);
        assert_eq!(timed.shadow_time > 0, called_for.contains(Effects::SHADOWS), "{called_for:?}: {timed:?}");
        let goes_on = Effects::MIRROR.union(Effects::TRANSPARENCY);
        assert_eq!(timed.secondary_time > 0, called_for.intersects(goes_on), "{called_for:?}: {timed:?}");
    }
    assert!(enough.iter().all(|count| *count > 2) && enough[0] < 40, "seed {SEED}: {enough:?}");
}

#[test]
fn pixels_depend_on_neither_rows_nor_vectors() {
    const SEED: u64 = 41;
    let mut rng = Rng::new(SEED);
    for _ in 0..3 {
        let scene = everything(&mut rng);
        let dag = Dag::new(&scene.words).unwrap();
        let wide = WideBuf::new(&dag, usize::MAX).unwrap();
        let top = TopBuf::new(&wide.as_wide(), 2).unwrap();
        let Scene { materials, ref palette, ref lights, camera, .. } = scene;
        for samples in [Samples::One, Samples::Four] {
            let settings = Settings { samples, ..settings(NormalKind::Plane2) };
            let expected = scene.drawn(&settings);
            let view = View { tracer: Tracer::new(dag), materials, palette, grid: GRID, camera, lights };
            let (mut sum, mut rows) = (Counters::default(), vec![0; expected.0.len()]);
            for part in [20..31, 0..1, 31..48, 1..20] {
                let out = &mut rows[part.start as usize * SIZE[0] as usize..part.end as usize * SIZE[0] as usize];
                sum += render_rows(&view, &settings, part, out).unwrap();
            }
            assert!((rows, sum) == expected, "seed {SEED}");
            for level in Level::all() {
                let tracer = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap().with_level(Some(level));
                assert!(tracer.packet_level().is_some());
                let view = View { tracer, materials, palette, grid: GRID, camera, lights };
                let mut out = vec![0; expected.0.len()];
                let counters = render_rows(&view, &settings, 0..SIZE[1], &mut out).unwrap();
                assert!((out, counters) == expected, "seed {SEED}: {}", level.name());
            }
        }
    }
}

/// Framed from outside the cube, where rays have no empty voxel before the first hit.
#[test]
fn mirrors_at_the_cubes_border_show_what_is_outside() {
    let mirror = Material { specular: WHITE, illum: 3, ..DARK };
    let mut scene = Scene::new(|_| true, |_| 0, &[mirror], [[0.0; 3], [1.0; 3]]);
    scene.camera = Camera::framing(&Bounds { min: GRID.origin, max: GRID.to_world([64.0; 3]) }, UpAxis::Y);
    for normals in [NormalKind::Face, NormalKind::Plane2] {
        let (found, counters) = scene.drawn(&settings(normals));
        let background = pixel(Settings::default().background);
        assert!(counters.hits > 500 && found.iter().all(|p| *p == background), "{normals:?}");
    }
}
