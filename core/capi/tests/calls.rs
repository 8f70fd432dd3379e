//! Every function through the ABI gives what the core gives.

mod scenes;

use core::ffi::{CStr, c_char};
use core::ptr::{null, null_mut};
use std::ffi::CString;
use std::sync::Arc;

use scenes::Kind;
use voxdag::camera::Camera;
use voxdag::colors::ColorMode;
use voxdag::effects::Effects;
use voxdag::file::{self, Parts};
use voxdag::grid::UpAxis;
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{Samples, Settings, Supersample, View, render_rows};
use voxdag::scene::{Build, MaterialMode, Options};
use voxdag::shade::{Light, LightKind};
use voxdag::texture::{Image, Maps, Placement, Texture};
use voxdag::trace::{Arithmetic, Face, Hit, Query, Tracer};
use voxdag::voxelize::Cover;
use voxdag::{Geometry, Grid, Material, Materials, Mesh, Morton};
use voxdag_capi::*;
use voxdag_oracle::rng::Rng;

const SEED: u64 = 0xca91;
const KINDS: [Kind; 3] = [Kind::Normals, Kind::Colors, Kind::Mirrors];

/// Calls a function with room for an error behind its arguments, and says what the error was.
macro_rules! call {
    ($function:ident($($argument:expr),* $(,)?)) => {{
        let mut error = core::mem::MaybeUninit::<VoxdagError>::uninit();
        // SAFETY: pointers to what lives here, arrays as long as the counts beside them say.
        match unsafe { $function($($argument,)* error.as_mut_ptr()) } {
            VoxdagStatus::Ok => {}
            // SAFETY: written where the status is not OK.
            status => panic!("{}: {status:?}: {}", stringify!($function), unsafe { text(&error.assume_init().message) }),
        }
    }};
}

/// # Safety
/// A text that ends with a zero byte.
unsafe fn text(bytes: &[c_char]) -> String {
    // SAFETY: as promised.
    unsafe { CStr::from_ptr(bytes.as_ptr()) }.to_str().unwrap().to_owned()
}

/// A scene that closes itself.
struct Open(*mut VoxdagScene);

impl Open {
    fn words(words: &[u32], tree_bytes: u64) -> Open {
        let mut scene = null_mut();
        call!(voxdag_scene_open(words.as_ptr(), words.len(), tree_bytes, &mut scene));
        Open(scene)
    }

    fn bytes(words: &[u32]) -> Open {
        // At an odd address, freed before the scene is used.
        let bytes: Vec<u8> = [0u8].into_iter().chain(words.iter().flat_map(|word| word.to_le_bytes())).collect();
        let mut scene = null_mut();
        call!(voxdag_scene_open_bytes(bytes[1..].as_ptr(), bytes.len() - 1, u64::MAX, &mut scene));
        Open(scene)
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        // SAFETY: opened, and closed once.
        unsafe { voxdag_scene_close(self.0) }
    }
}

/// The same words opened in every way: with trees, without, with little room for them, from bytes.
fn all_ways(words: &[u32]) -> [Open; 4] {
    [Open::words(words, u64::MAX), Open::words(words, 0), Open::words(words, 40_000), Open::bytes(words)]
}

/// Rays at a scene of so many voxels: from anywhere to anywhere, some limited, some along an axis, some that are none.
fn rays(rng: &mut Rng, side: f64, count: usize) -> Vec<Query> {
    let ray = |i: usize| {
        let mut point = || std::array::from_fn(|_| rng.uniform(-0.5 * side, 1.5 * side));
        let (from, to): ([f64; 3], [f64; 3]) = (point(), point());
        let mut query = Query::new(from, std::array::from_fn(|k| to[k] - from[k]));
        match i % 8 {
            1 => query.dir = [0.0, 0.0, -1.0],
            2 => query.t_min = 0.3,
            3 => query.t_max = 0.5,
            4 => query.origin = from.map(|x| x.floor().clamp(0.0, side)),
            5 if i.is_multiple_of(3) => query.dir = [f64::NAN, 1.0, 0.0],
            5 => query.dir = [0.0; 3],
            _ => {}
        }
        query
    };
    (0..count).map(ray).collect()
}

fn ray_of(query: &Query) -> VoxdagRay {
    VoxdagRay {
        origin: query.origin,
        direction: query.dir,
        t_min: query.t_min,
        t_max: query.t_max,
        start: query.start.map_or(VOXDAG_NONE, |start| start.0),
        min_level: query.min_level.into(),
        arithmetic: 0,
    }
}

fn hit_of(hit: Option<Hit>) -> VoxdagHit {
    match hit {
        Some(hit) => VoxdagHit {
            voxel: hit.voxel.0,
            from: hit.from.map_or(u64::MAX, |from| from.0),
            t: hit.t,
            level: hit.level.into(),
            face: Face::ALL.iter().position(|face| *face == hit.face).unwrap() as u32,
        },
        None => VoxdagHit { voxel: u64::MAX, from: u64::MAX, t: f64::INFINITY, level: 0, face: 7 },
    }
}

/// Arrays of so many rays and room for hits.
struct Batch {
    origins: Vec<f64>,
    directions: Vec<f64>,
    t_min: Vec<f64>,
    t_max: Vec<f64>,
    starts: Vec<u64>,
    voxels: Vec<u64>,
    from: Vec<u64>,
    t: Vec<f64>,
    faces: Vec<u8>,
}

impl Batch {
    fn new(queries: &[Query]) -> Batch {
        let count = queries.len();
        Batch {
            origins: queries.iter().flat_map(|query| query.origin).collect(),
            directions: queries.iter().flat_map(|query| query.dir).collect(),
            t_min: queries.iter().map(|query| query.t_min).collect(),
            t_max: queries.iter().map(|query| query.t_max).collect(),
            starts: queries.iter().map(|query| query.start.map_or(u64::MAX, |start| start.0)).collect(),
            voxels: vec![1; count],
            from: vec![2; count],
            t: vec![3.0; count],
            faces: vec![9; count],
        }
    }

    fn rays(&self, min_level: u8) -> VoxdagRays {
        VoxdagRays {
            count: self.t_min.len(),
            origins: self.origins.as_ptr(),
            directions: self.directions.as_ptr(),
            t_min: self.t_min.as_ptr(),
            t_max: self.t_max.as_ptr(),
            starts: self.starts.as_ptr(),
            min_level: min_level.into(),
            arithmetic: VoxdagArithmetic::Exact as u32,
        }
    }

    fn hits(&mut self) -> VoxdagHits {
        VoxdagHits {
            voxels: self.voxels.as_mut_ptr(),
            from: self.from.as_mut_ptr(),
            t: self.t.as_mut_ptr(),
            faces: self.faces.as_mut_ptr(),
        }
    }

    fn hit(&self, i: usize) -> VoxdagHit {
        VoxdagHit { voxel: self.voxels[i], from: self.from[i], t: self.t[i], level: 0, face: self.faces[i].into() }
    }
}

#[test]
fn versions_and_messages() {
    assert_eq!(voxdag_abi_version(), VOXDAG_ABI_VERSION);
    // SAFETY: texts that live for ever.
    let read = |text: *const c_char| unsafe { CStr::from_ptr(text) }.to_str().unwrap();
    assert_eq!(read(voxdag_version()), env!("CARGO_PKG_VERSION"));
    let unknown = read(voxdag_error_message(-1));
    let known: Vec<&str> = (0..64).map(|status| read(voxdag_error_message(status))).filter(|t| *t != unknown).collect();
    let mut different = known.clone();
    different.sort_unstable();
    different.dedup();
    assert_eq!((known.len(), different.len()), (29, 29));
    assert_eq!(read(voxdag_error_message(VoxdagStatus::TooSmall as i32)), "the lent memory is too small");
}

#[test]
fn a_scene_says_what_it_is() {
    for kind in KINDS {
        let words = scenes::words(kind, 90);
        let scene = file::read(&words).unwrap();
        for open in all_ways(&words) {
            let mut info = core::mem::MaybeUninit::uninit();
            call!(voxdag_scene_info(open.0, info.as_mut_ptr()));
            // SAFETY: written where the status is OK.
            let info: VoxdagSceneInfo = unsafe { info.assume_init() };
            assert_eq!((info.resolution, info.depth, info.material_count, info.up), (90, 7, 2, VoxdagUp::Z as u32));
            assert_eq!(info.has_normals, matches!(kind, Kind::Normals).into());
            assert_eq!(info.has_colors, matches!(kind, Kind::Colors).into());
            assert_eq!(
                (info.voxel_count, info.word_count),
                (scene.geometry.voxels().count() as u64, words.len() as u64)
            );
            assert_eq!((info.origin, info.voxel_size), (scene.grid.origin, scene.grid.voxel_size));
            assert_eq!((info.bounds_min, info.bounds_max), (scene.bounds.min, scene.bounds.max));
            assert_eq!(info.metres_per_unit, 0.25);

            for (id, expected) in scenes::materials().into_iter().enumerate() {
                let mut found = voxdag_material_default();
                call!(voxdag_scene_material(open.0, id as u32, &mut found));
                assert_eq!((found.diffuse, found.specular), (expected.diffuse, expected.specular));
                assert_eq!((found.ambient, found.emission), (expected.ambient, expected.emission));
                assert_eq!((found.transmission, found.opacity), (expected.transmission, expected.opacity));
                assert_eq!((found.refraction, found.shininess), (expected.refraction, expected.shininess));
                assert_eq!(
                    (found.illum, found.textured),
                    (expected.illum.into(), u32::from(id == 1) * info.has_colors)
                );
                let mut name = [1; 64];
                let room = scenes::NAMES[id].len() + 1;
                call!(voxdag_scene_material_name(open.0, id as u32, name.as_mut_ptr(), room));
                // SAFETY: a name ends with a zero byte.
                assert_eq!(unsafe { text(&name) }, scenes::NAMES[id]);
            }
        }
    }
}

#[test]
fn rays_meet_what_the_core_says() {
    println!("seed {SEED}");
    let mut rng = Rng::new(SEED);
    for kind in KINDS {
        let words = scenes::words(kind, 90);
        let scene = file::read(&words).unwrap();
        let tracer = Tracer::new(scene.geometry);
        let mut queries = rays(&mut rng, 90.0, 700);
        // Some go on from where the last one ended.
        for i in (7..queries.len()).step_by(7) {
            let last = queries[i - 1];
            if let Some(Hit { from: Some(from), t, .. }) = tracer.trace(Arithmetic::Exact, &last) {
                let origin = std::array::from_fn(|k| last.origin[k] + t * last.dir[k]);
                queries[i] = Query { start: Some(from), ..Query::new(origin, last.dir.map(|x| -x)) };
            }
        }
        let expected: Vec<_> = queries.iter().map(|query| tracer.trace(Arithmetic::Exact, query)).collect();
        let hits = expected.iter().flatten().count();
        assert!(hits > 100 && hits < 600, "{hits} hits say little");

        for open in all_ways(&words) {
            // One by one.
            for (query, expected) in queries.iter().zip(&expected) {
                let (ray, mut hit, mut blocked) = (ray_of(query), hit_of(None), 7);
                call!(voxdag_trace(open.0, &ray, &mut hit));
                call!(voxdag_occluded(open.0, &ray, &mut blocked));
                assert_eq!(hit, hit_of(*expected), "{query:?}");
                assert_eq!(blocked, u8::from(expected.is_some()));
                let coarse = VoxdagRay { min_level: 3, start: VOXDAG_NONE, ..ray };
                call!(voxdag_trace(open.0, &coarse, &mut hit));
                let query = Query { min_level: 3, start: None, ..*query };
                assert_eq!(hit, hit_of(tracer.trace(Arithmetic::Exact, &query)), "{query:?}");
            }
            // All at once, then without what may be left out.
            let mut batch = Batch::new(&queries);
            let mut blocked = vec![7; queries.len()];
            call!(voxdag_trace_many(open.0, &batch.rays(0), &batch.hits()));
            call!(voxdag_occluded_many(open.0, &batch.rays(0), blocked.as_mut_ptr()));
            for (i, expected) in expected.iter().enumerate() {
                assert_eq!(batch.hit(i), hit_of(*expected), "{:?}", queries[i]);
                assert_eq!(blocked[i], u8::from(expected.is_some()));
            }
            let bare = VoxdagRays { t_min: null(), t_max: null(), starts: null(), ..batch.rays(0) };
            let voxels_alone =
                VoxdagHits { voxels: batch.voxels.as_mut_ptr(), from: null_mut(), t: null_mut(), faces: null_mut() };
            call!(voxdag_trace_many(open.0, &bare, &voxels_alone));
            for (query, voxel) in queries.iter().zip(&batch.voxels) {
                let query = Query::new(query.origin, query.dir);
                assert_eq!(*voxel, hit_of(tracer.trace(Arithmetic::Exact, &query)).voxel);
            }
        }
    }
}

#[test]
fn arithmetics_and_levels_are_the_ones_asked_for() {
    let words = scenes::words(Kind::Normals, 90);
    let (open, scene) = (Open::words(&words, 0), file::read(&words).unwrap());
    let queries = rays(&mut Rng::new(SEED), 90.0, 200);
    for (number, arithmetic) in [Arithmetic::Exact, Arithmetic::F64, Arithmetic::F32].into_iter().enumerate() {
        let mut batch = Batch::new(&queries);
        let rays = VoxdagRays { arithmetic: number as u32, ..batch.rays(2) };
        call!(voxdag_trace_many(open.0, &rays, &batch.hits()));
        for (i, query) in queries.iter().enumerate() {
            let query = Query { min_level: 2, ..*query };
            let expected = hit_of(Tracer::new(scene.geometry).trace(arithmetic, &query));
            assert_eq!(VoxdagHit { level: expected.level, ..batch.hit(i) }, expected);
        }
    }
}

#[test]
fn normals_materials_and_colors_are_the_cores() {
    println!("seed {SEED}");
    for kind in KINDS {
        let words = scenes::words(kind, 90);
        let scene = file::read(&words).unwrap();
        let tracer = Tracer::new(scene.geometry);
        let queries = rays(&mut Rng::new(SEED), 90.0, 300);
        let hits: Vec<_> = queries.iter().map(|query| tracer.trace(Arithmetic::Exact, query)).collect();
        for open in all_ways(&words) {
            let mut batch = Batch::new(&queries);
            call!(voxdag_trace_many(open.0, &batch.rays(0), &batch.hits()));
            let (voxels, faces, directions) = (&batch.voxels, &batch.faces, &batch.directions);

            for (number, kind) in NormalKind::ALL.into_iter().enumerate() {
                let mut all = vec![[9.0f32; 3]; queries.len()];
                call!(voxdag_normals(
                    open.0,
                    number as u32,
                    queries.len(),
                    voxels.as_ptr(),
                    faces.as_ptr(),
                    directions.as_ptr(),
                    all.as_mut_ptr().cast()
                ));
                for (i, hit) in hits.iter().enumerate() {
                    let found = |hit| normal(&tracer, scene.materials, hit, queries[i].dir, kind).direction;
                    let expected = hit.as_ref().map_or([0.0; 3], found);
                    assert_eq!(all[i], expected, "{kind:?} {hit:?}");
                    let mut one = [9.0f32; 3];
                    let direction = directions[3 * i..].as_ptr();
                    call!(voxdag_normal(open.0, number as u32, &batch.hit(i), direction, one.as_mut_ptr()));
                    assert_eq!(one, expected);
                }
            }

            let mut ids = vec![9; queries.len()];
            let mut colors = vec![[9u8; 4]; queries.len()];
            call!(voxdag_materials(open.0, queries.len(), voxels.as_ptr(), ids.as_mut_ptr()));
            call!(voxdag_colors(open.0, queries.len(), voxels.as_ptr(), colors.as_mut_ptr().cast()));
            let mut colored = 0;
            for (i, hit) in hits.iter().enumerate() {
                let id = hit.map(|hit| scene.materials.id(hit.voxel));
                assert_eq!(ids[i], id.map_or(u32::MAX, u32::from));
                let textured = hit.filter(|_| scene.material(id.unwrap()).textured);
                let color = textured.and_then(|hit| scene.looks().color(hit.voxel));
                assert_eq!(colors[i], color.map_or([0; 4], |[r, g, b]| [r, g, b, 255]));
                colored += u32::from(color.is_some());
            }
            assert_eq!(colored > 20, matches!(kind, Kind::Colors), "{colored} colours");
        }
    }
}

/// In a thread with little more stack than the header says (a thread takes some itself); with less it would abort.
#[test]
fn many_normals_take_no_more_stack_than_is_said() {
    /// A scene that a thread may use.
    struct Lent(*const VoxdagScene);
    // SAFETY: the header says that any number of threads may.
    unsafe impl Send for Lent {}
    impl Lent {
        fn scene(&self) -> *const VoxdagScene {
            self.0
        }
    }
    let words = scenes::words(Kind::Normals, 90);
    let scene = Open::words(&words, u64::MAX);
    let hits: Vec<_> = file::read(&words).unwrap().geometry.voxels().take(1000).map(|voxel| voxel.0).collect();
    let (faces, directions) = (vec![5u8; hits.len()], [0.1, 0.2, -1.0f64].repeat(hits.len()));
    let mut normals = vec![0.0f32; 3 * hits.len()];
    std::thread::scope(|scope| {
        let (lent, hits, faces, directions, normals) = (Lent(scene.0), &hits, &faces, &directions, &mut normals);
        let call = move || {
            for kind in 0..8 {
                let (hits, faces) = (hits.as_ptr(), faces.as_ptr());
                call!(voxdag_normals(lent.scene(), kind, 1000, hits, faces, directions.as_ptr(), normals.as_mut_ptr()));
            }
        };
        let thread = std::thread::Builder::new().stack_size((30 + 8) << 10).spawn_scoped(scope, call);
        thread.unwrap().join().unwrap();
    });
    assert!(normals.chunks(3).all(|normal| normal != [0.0; 3]));
}

#[test]
fn voxels_have_places() {
    let mut rng = Rng::new(SEED);
    for _ in 0..100 {
        let place = [(); 3].map(|()| rng.below(1 << 21) as u32);
        let [x, y, z] = place;
        let voxel = voxdag_voxel_at(x, y, z);
        assert_eq!(voxel, Morton::encode(place).unwrap().0);
        let mut back = [0; 3];
        call!(voxdag_voxel_position(voxel, back.as_mut_ptr()));
        assert_eq!(back, place);
    }
    assert_eq!(voxdag_voxel_at(1 << 21, 0, 0), VOXDAG_NONE);
}

#[test]
fn pictures_are_the_cores() {
    let settings = Settings { width: 61, height: 43, ..Settings::default() };
    let cases = [
        settings,
        Settings { samples: Samples::Sixteen, supersample: Supersample::Adaptive { degrees: 5.0 }, ..settings },
        Settings {
            samples: Samples::Five,
            supersample: Supersample::Region { from: [10, 5], to: [40, 30] },
            normals: NormalKind::Face,
            arithmetic: Arithmetic::F64,
            effects: Effects::PHONG.union(Effects::SHADOWS),
            lift: 0.0,
            ..settings
        },
    ];
    for kind in KINDS {
        let words = scenes::words(kind, 90);
        let scene = file::read(&words).unwrap();
        let camera = Camera::framing(&scene.bounds, scene.up);
        let sun = Light { kind: LightKind::Directional([1.0, 2.0, 3.0]), color: [0.5, 0.4, 0.3], shadow: true };
        let lights = [camera.headlight(scene.bounds.radius()), sun];
        let palette: Vec<Material> = (0..2).map(|id| scene.material(id)).collect();
        for case in cases {
            let Settings { width, height, .. } = case;
            let mut expected = vec![0; (width * height) as usize];
            let view = View {
                tracer: Tracer::new(scene.geometry),
                materials: scene.looks(),
                palette: &palette,
                grid: scene.grid,
                camera,
                lights: &lights,
            };
            let counted = render_rows(&view, &case, 0..height, &mut expected).unwrap();

            for open in all_ways(&words) {
                let mut eye = core::mem::MaybeUninit::<VoxdagCamera>::uninit();
                let mut head = core::mem::MaybeUninit::<VoxdagLight>::uninit();
                call!(voxdag_camera_default(open.0, eye.as_mut_ptr(), head.as_mut_ptr()));
                call!(voxdag_camera_default(open.0, eye.as_mut_ptr(), null_mut()));
                // SAFETY: written where the status is OK.
                let (eye, head) = unsafe { (eye.assume_init(), head.assume_init()) };
                let sun = VoxdagLight {
                    kind: VoxdagLightKind::Directional as u32,
                    shadow: 1,
                    position: [1.0, 2.0, 3.0],
                    color: [0.5, 0.4, 0.3],
                };
                let lights = [head, sun];
                let (supersample, region, degrees) = match case.supersample {
                    Supersample::All => (VoxdagSupersample::All, [0; 4], f32::NAN),
                    Supersample::Region { from, to } => {
                        (VoxdagSupersample::Region, [from[0], from[1], to[0], to[1]], f32::NAN)
                    }
                    Supersample::Adaptive { degrees } => (VoxdagSupersample::Adaptive, [0; 4], degrees),
                    Supersample::Slab { .. } => unreachable!(),
                };
                let settings = VoxdagSettings {
                    width,
                    height,
                    samples: case.samples.count(),
                    supersample: supersample as u32,
                    region,
                    degrees,
                    normals: NormalKind::ALL.iter().position(|kind| *kind == case.normals).unwrap() as u32,
                    arithmetic: u32::from(case.arithmetic == Arithmetic::F64),
                    effects: if case.effects == Effects::ALL { 127 } else { 3 },
                    lift: case.lift,
                    ..voxdag_settings_default()
                };
                let mut pixels = vec![7; expected.len() + 1];
                let mut counters = VoxdagCounters { primary: 0, shadow: 0, secondary: 0, hits: 0 };
                call!(voxdag_render_rows(
                    open.0,
                    &eye,
                    lights.as_ptr(),
                    2,
                    &settings,
                    0,
                    height,
                    pixels.as_mut_ptr(),
                    pixels.len(),
                    &mut counters
                ));
                assert!(pixels[..expected.len()] == expected, "{kind:?} {case:?}");
                assert_eq!(pixels[expected.len()], 7);
                assert_eq!((counters.primary, counters.hits), (counted.primary, counted.hits));
                assert_eq!((counters.shadow, counters.secondary), (counted.shadow, counted.secondary));
                // Some rows, without counters.
                let some = 5 * width as usize;
                call!(voxdag_render_rows(
                    open.0,
                    &eye,
                    lights.as_ptr(),
                    2,
                    &settings,
                    13,
                    18,
                    pixels.as_mut_ptr(),
                    some,
                    null_mut()
                ));
                assert!(pixels[..some] == expected[13 * width as usize..][..some]);
            }
        }
    }
}

/// Numbers that stand for effects are in the core's order.
#[test]
fn effects_have_the_cores_bits() {
    let names = ["specular", "shadows", "mirror", "transparency", "refraction", "emission", "textures"];
    assert!(Effects::ALL.names().eq(names));
    use VoxdagEffects as E;
    let bits = [E::Specular, E::Shadows, E::Mirror, E::Transparency, E::Refraction, E::Emission, E::Textures];
    assert!(bits.into_iter().enumerate().all(|(bit, effect)| effect as u32 == 1 << bit));
}

#[test]
fn what_is_built_is_what_the_core_builds() {
    let (shape, ids) = scenes::shape();
    let materials = scenes::materials();
    let texts = scenes::NAMES.map(|name| CString::new(name).unwrap());
    let names = [texts[0].as_ptr(), null()];
    let given = materials.map(|material| {
        let mut scene_material = voxdag_material_default();
        scene_material.ambient = material.ambient;
        scene_material.diffuse = material.diffuse;
        scene_material.specular = material.specular;
        scene_material.emission = material.emission;
        scene_material.transmission = material.transmission;
        scene_material.opacity = material.opacity;
        scene_material.refraction = material.refraction;
        scene_material.shininess = material.shininess;
        scene_material.illum = material.illum.into();
        scene_material
    });
    let modes = [MaterialMode::Tree, MaterialMode::Table, MaterialMode::TableNormals, MaterialMode::None];
    let covers = [Cover::Exact, Cover::Thin, Cover::Inflated];
    for (keep, mode) in modes.into_iter().enumerate() {
        for (number, cover) in covers.into_iter().enumerate() {
            let own = number == 2;
            // What the core makes of it.
            let mesh = Mesh { materials: &ids, ..shape.mesh() };
            let bounds = mesh.validate().unwrap();
            let grid = if own {
                Grid { origin: bounds.min.map(|x| x - 0.01), voxel_size: 0.011, resolution: 100 }
            } else {
                Grid::fit(&bounds, 75).unwrap()
            };
            let options = Options { cover, materials: mode, ..Options::default() };
            let built = Build::new(&mesh, &grid, &options).unwrap().run().unwrap();
            let parts = Parts {
                grid,
                bounds,
                up: UpAxis::Z,
                metres_per_unit: 0.5,
                geometry: built.dag.dag().into(),
                voxel_materials: built.materials.as_materials(None).unwrap(),
                colors: None,
                materials: &materials,
                names: &[scenes::NAMES[0], ""],
            };
            let expected = parts.to_vec().unwrap();

            // The same through the ABI: asked, then built.
            let mesh = VoxdagMesh {
                vertex_count: shape.positions.len(),
                triangle_count: shape.triangles.len(),
                positions: shape.positions.as_ptr().cast(),
                indices: shape.triangles.as_ptr().cast(),
                triangle_materials: ids.as_ptr(),
                material_count: 2,
                materials: given.as_ptr(),
                names: names.as_ptr(),
                uvs: null(),
                textures: null(),
                cutouts: null(),
            };
            let build = VoxdagBuild {
                resolution: grid.resolution,
                cover: number as u32,
                keep: keep as u32,
                colors: VoxdagColors::Blocks as u32,
                up: VoxdagUp::Z as u32,
                voxel_size: if own { 0.011 } else { 0.0 },
                origin: if own { grid.origin } else { [f64::NAN; 3] },
                metres_per_unit: 0.5,
                memory_limit: u64::MAX,
            };
            let mut count = 0;
            // SAFETY: pointers to what lives here; no room at all is fine.
            let asked = unsafe { voxdag_build(&mesh, &build, null_mut(), 0, &mut count, null_mut()) };
            assert_eq!((asked, count), (VoxdagStatus::TooSmall, expected.len()));
            let mut words = vec![7; count + 3];
            call!(voxdag_build(&mesh, &build, words.as_mut_ptr(), words.len(), &mut count));
            assert_eq!(count, expected.len());
            assert!(words[..count] == expected, "{mode:?} {cover:?}");
            assert_eq!(words[count..], [7; 3]);
            drop(Open::words(&words[..count], 0));
        }
    }
    // Without materials there is one.
    let mesh = VoxdagMesh {
        vertex_count: shape.positions.len(),
        triangle_count: shape.triangles.len(),
        positions: shape.positions.as_ptr().cast(),
        indices: shape.triangles.as_ptr().cast(),
        triangle_materials: null(),
        material_count: 0,
        materials: null(),
        names: null(),
        uvs: null(),
        textures: null(),
        cutouts: null(),
    };
    let (mut words, mut count) = (vec![0; 200_000], 0);
    let build = VoxdagBuild { resolution: 50, ..voxdag_build_default() };
    call!(voxdag_build(&mesh, &build, words.as_mut_ptr(), words.len(), &mut count));
    let scene = file::read(&words[..count]).unwrap();
    assert_eq!((scene.material_count(), scene.material(0)), (1, Material::GREY));
}

#[test]
fn textures_are_the_cores() {
    let (shape, ids) = scenes::shape();
    let mut rng = Rng::new(SEED);
    println!("seed {SEED}");
    let (width, height) = (9u32, 5u32);
    let pixels: Vec<u8> = (0..4 * width * height).map(|_| rng.below(256) as u8).collect();
    let uvs: Vec<[[f32; 2]; 3]> =
        shape.triangles.iter().map(|_| [0; 3].map(|_| [0; 2].map(|_| rng.uniform(-2.0, 2.0) as f32))).collect();

    // One material is coloured, the other cut out, by the same picture laid differently.
    let words = pixels.chunks_exact(4).map(|pixel| u32::from_le_bytes(pixel.try_into().unwrap())).collect();
    let image = Arc::new(Image::new(width, height, words).unwrap());
    let laid = Placement { scale: [2.0, -0.5, 1.0], offset: [0.25, 0.75, 0.0], clamp: true, base: 0.125, gain: 0.5 };
    let lay = |placement| Some(Texture::new(image.clone(), placement));
    let maps = [Maps::new(lay(laid), None).unwrap(), Maps::new(None, lay(Placement::default())).unwrap()];
    let mut materials = scenes::materials();
    materials[0].textured = true;
    let plain = VoxdagTexture { pixels: pixels.as_ptr(), width, height, ..voxdag_texture_default() };
    let turned = VoxdagTexture { scale: [2.0, -0.5], offset: [0.25, 0.75], clamp: 1, base: 0.125, gain: 0.5, ..plain };
    let (textures, cutouts) = ([turned, voxdag_texture_default()], [voxdag_texture_default(), plain]);
    let given = scenes::materials().map(|material| VoxdagMaterial {
        ambient: material.ambient,
        diffuse: material.diffuse,
        specular: material.specular,
        emission: material.emission,
        transmission: material.transmission,
        opacity: material.opacity,
        refraction: material.refraction,
        shininess: material.shininess,
        illum: material.illum.into(),
        textured: 0,
    });
    for (number, colors) in [ColorMode::Blocks, ColorMode::Raw].into_iter().enumerate() {
        for (keep, mode) in [(0, MaterialMode::Tree), (1, MaterialMode::Table), (3, MaterialMode::None)] {
            let mesh = Mesh { materials: &ids, uvs: &uvs, ..shape.mesh() };
            let bounds = mesh.validate().unwrap();
            let grid = Grid::fit(&bounds, 75).unwrap();
            let options = Options { materials: mode, colors, ..Options::default() };
            let built = Build::new(&mesh, &grid, &options).unwrap().with_textures(&maps).run().unwrap();
            let looks = built.looks().unwrap();
            assert_eq!(looks.colors.is_some(), mode != MaterialMode::None);
            let expected = Parts {
                grid,
                bounds,
                up: UpAxis::Y,
                metres_per_unit: 0.0,
                geometry: built.dag.dag().into(),
                voxel_materials: looks.materials,
                colors: looks.colors,
                materials: if mode == MaterialMode::None { &scenes::materials() } else { &materials },
                names: &["", ""],
            };
            let expected = expected.to_vec().unwrap();
            let mesh = VoxdagMesh {
                vertex_count: shape.positions.len(),
                triangle_count: shape.triangles.len(),
                positions: shape.positions.as_ptr().cast(),
                indices: shape.triangles.as_ptr().cast(),
                triangle_materials: ids.as_ptr(),
                material_count: 2,
                materials: given.as_ptr(),
                names: null(),
                uvs: uvs.as_ptr().cast(),
                textures: textures.as_ptr(),
                cutouts: cutouts.as_ptr(),
            };
            let build = VoxdagBuild { resolution: 75, keep, colors: number as u32, ..voxdag_build_default() };
            let (mut words, mut count) = (vec![0; expected.len()], 0);
            call!(voxdag_build(&mesh, &build, words.as_mut_ptr(), words.len(), &mut count));
            assert!(words[..count] == expected, "{mode:?} {colors:?}");
            let scene = file::read(&words).unwrap();
            assert_eq!(scene.colors.is_some(), mode != MaterialMode::None);
        }
    }
}
