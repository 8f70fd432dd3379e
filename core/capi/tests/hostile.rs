//! Nulls, pointers that are not aligned, wrong counts, numbers that mean nothing, damaged words: a status, and a message.

mod scenes;

use core::ffi::CStr;
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use scenes::Kind;
use voxdag::file;
use voxdag_capi::VoxdagStatus as S;
use voxdag_capi::*;
use voxdag_oracle::rng::Rng;

const SEED: u64 = 0xbad;

/// The status of a call that is to fail, where the error is, and its message.
macro_rules! fails {
    ($function:ident($($argument:expr),* $(,)?)) => {{
        let mut error = MaybeUninit::<VoxdagError>::uninit();
        // SAFETY: what is wrong with the arguments can be noticed.
        let status = unsafe { $function($($argument,)* error.as_mut_ptr()) };
        assert_ne!(status, S::Ok);
        // SAFETY: as above; errors may be left out.
        assert_eq!(unsafe { $function($($argument,)* null_mut()) }, status);
        // SAFETY: written where the status is not OK.
        let error = unsafe { error.assume_init() };
        assert_eq!(error.status, status);
        // SAFETY: a message ends with a zero byte.
        let message = unsafe { CStr::from_ptr(error.message.as_ptr()) }.to_str().unwrap().to_owned();
        assert_eq!(message.len(), error.length as usize);
        assert!(message.len() > 10 && message.len() < 255, "{message}");
        (status, error.position, error.needed, message)
    }};
}

fn open(words: &[u32]) -> *mut VoxdagScene {
    let mut scene = null_mut();
    // SAFETY: the words outlive the scene.
    assert_eq!(unsafe { voxdag_scene_open(words.as_ptr(), words.len(), u64::MAX, &mut scene, null_mut()) }, S::Ok);
    scene
}

#[test]
fn pointers() {
    let words = scenes::words(Kind::Normals, 40);
    let scene = open(&words);
    let mut out = null_mut();
    let odd = words.as_ptr().cast::<u8>().wrapping_add(1).cast::<u32>();
    assert_eq!(fails!(voxdag_scene_open(null(), 9, 0, &mut out)).0, S::Null);
    assert_eq!(fails!(voxdag_scene_open(odd, 9, 0, &mut out)).0, S::Misaligned);
    assert_eq!(fails!(voxdag_scene_open(words.as_ptr(), usize::MAX / 2, 0, &mut out)).0, S::Count);
    assert_eq!(fails!(voxdag_scene_open(words.as_ptr(), usize::MAX, 0, &mut out)).0, S::Count);
    assert_eq!(fails!(voxdag_scene_open(words.as_ptr(), words.len(), 0, null_mut())).0, S::Null);
    assert_eq!(fails!(voxdag_scene_open(null(), 0, 0, &mut out)).0, S::FileLength);
    assert_eq!(fails!(voxdag_scene_open_bytes(null(), 4, 0, &mut out)).0, S::Null);
    assert_eq!(fails!(voxdag_scene_open_bytes(words.as_ptr().cast(), 7, 0, &mut out)).0, S::FileLength);
    assert!(out.is_null());
    // SAFETY: null is nothing.
    unsafe { voxdag_scene_close(null_mut()) };

    let mut info = MaybeUninit::uninit();
    assert_eq!(fails!(voxdag_scene_info(null(), info.as_mut_ptr())).0, S::Null);
    let (status, _, _, message) = fails!(voxdag_scene_info(scene, null_mut()));
    assert_eq!((status, &message[..]), (S::Null, "`info` is a null pointer"));
    assert_eq!(
        fails!(voxdag_scene_info(scene.cast::<u8>().wrapping_add(1).cast(), info.as_mut_ptr())).0,
        S::Misaligned
    );

    let (ray, mut hit, mut byte) = (voxdag_ray_default(), MaybeUninit::uninit(), 0);
    assert_eq!(fails!(voxdag_trace(null(), &ray, hit.as_mut_ptr())).0, S::Null);
    assert_eq!(fails!(voxdag_trace(scene, null(), hit.as_mut_ptr())).0, S::Null);
    assert_eq!(fails!(voxdag_trace(scene, &ray, null_mut())).0, S::Null);
    assert_eq!(fails!(voxdag_occluded(scene, null(), &mut byte)).0, S::Null);
    assert_eq!(fails!(voxdag_occluded(scene, &ray, null_mut())).0, S::Null);

    let numbers = [1.0f64; 12];
    let mut voxels = [0; 4];
    let rays = VoxdagRays {
        count: 4,
        origins: numbers.as_ptr(),
        directions: numbers.as_ptr(),
        t_min: null(),
        t_max: null(),
        starts: null(),
        min_level: 0,
        arithmetic: 0,
    };
    let hits = VoxdagHits { voxels: voxels.as_mut_ptr(), from: null_mut(), t: null_mut(), faces: null_mut() };
    let odd = numbers.as_ptr().cast::<u8>().wrapping_add(4).cast::<f64>();
    for (rays, status) in [
        (VoxdagRays { origins: null(), ..rays }, S::Null),
        (VoxdagRays { directions: null(), ..rays }, S::Null),
        (VoxdagRays { origins: odd, ..rays }, S::Misaligned),
        (VoxdagRays { t_max: odd, ..rays }, S::Misaligned),
        (VoxdagRays { count: usize::MAX, ..rays }, S::Count),
        (VoxdagRays { count: usize::MAX / 24, ..rays }, S::Count),
        (VoxdagRays { min_level: 22, ..rays }, S::Argument),
        (VoxdagRays { min_level: 256, ..rays }, S::Argument),
        (VoxdagRays { arithmetic: 3, ..rays }, S::Argument),
    ] {
        assert_eq!(fails!(voxdag_trace_many(scene, &rays, &hits)).0, status, "{rays:?}");
        assert_eq!(fails!(voxdag_occluded_many(scene, &rays, &mut byte)).0, status, "{rays:?}");
    }
    assert_eq!(fails!(voxdag_trace_many(scene, null(), &hits)).0, S::Null);
    assert_eq!(fails!(voxdag_trace_many(scene, &rays, null())).0, S::Null);
    assert_eq!(fails!(voxdag_trace_many(scene, &rays, &VoxdagHits { voxels: null_mut(), ..hits })).0, S::Null);
    assert_eq!(fails!(voxdag_occluded_many(scene, &rays, null_mut())).0, S::Null);
    // No rays need no memory.
    let none = VoxdagRays { count: 0, origins: null(), directions: null(), ..rays };
    let nowhere = VoxdagHits { voxels: null_mut(), ..hits };
    // SAFETY: none of the pointers is read.
    assert_eq!(unsafe { voxdag_trace_many(scene, &none, &nowhere, null_mut()) }, S::Ok);
    // SAFETY: as above.
    assert_eq!(unsafe { voxdag_occluded_many(scene, &none, null_mut(), null_mut()) }, S::Ok);

    let (faces, mut floats, mut ids) = ([0u8, 6, 7, 0], [0.0f32; 12], [0u32; 4]);
    let (v, f, d, n) = (voxels.as_ptr(), faces.as_ptr(), numbers.as_ptr(), floats.as_mut_ptr());
    let (status, position, _, message) = fails!(voxdag_normals(scene, 4, 4, v, f, d, n));
    assert_eq!((status, position), (S::Argument, 2), "{message}");
    assert_eq!(fails!(voxdag_normals(scene, 8, 4, v, f, d, n)).0, S::Argument);
    for (v, f, d, n) in [(null(), f, d, n), (v, null(), d, n), (v, f, null(), n), (v, f, d, null_mut())] {
        assert_eq!(fails!(voxdag_normals(scene, 4, 4, v, f, d, n)).0, S::Null);
    }
    let at = VoxdagHit { voxel: 0, from: VOXDAG_NONE, t: 0.0, level: 0, face: 9 };
    assert_eq!(fails!(voxdag_normal(scene, 4, &at, d, n)).0, S::Argument);
    assert_eq!(fails!(voxdag_normal(scene, 4, null(), d, n)).0, S::Null);
    assert_eq!(fails!(voxdag_materials(scene, 4, null(), ids.as_mut_ptr())).0, S::Null);
    assert_eq!(fails!(voxdag_materials(scene, 4, v, null_mut())).0, S::Null);
    assert_eq!(fails!(voxdag_colors(scene, usize::MAX, v, n.cast())).0, S::Count);
    assert_eq!(fails!(voxdag_voxel_position(1 << 63, ids.as_mut_ptr())).0, S::Argument);
    assert_eq!(fails!(voxdag_voxel_position(0, null_mut())).0, S::Null);

    let mut name = [0; 99];
    let (status, _, needed, _) = fails!(voxdag_scene_material_name(scene, 1, name.as_mut_ptr(), 5));
    assert_eq!((status, needed), (S::TooSmall, 6));
    assert_eq!(fails!(voxdag_scene_material_name(scene, 2, name.as_mut_ptr(), 99)).0, S::Argument);
    assert_eq!(fails!(voxdag_scene_material(scene, 1 << 20, &mut voxdag_material_default())).0, S::Argument);
    // SAFETY: opened above.
    unsafe { voxdag_scene_close(scene) };
}

/// Voxels and starts that are none are safe to ask about, and so are rays of any bits.
#[test]
fn garbage_rays_and_voxels_are_answered() {
    println!("seed {SEED}");
    let mut rng = Rng::new(SEED);
    for (kind, tree_bytes) in
        [(Kind::Normals, u64::MAX), (Kind::Colors, 0), (Kind::Mirrors, 0), (Kind::Colors, u64::MAX)]
    {
        let words = scenes::words(kind, 40);
        let mut scene = null_mut();
        // SAFETY: the words outlive the scene.
        assert_eq!(
            unsafe { voxdag_scene_open(words.as_ptr(), words.len(), tree_bytes, &mut scene, null_mut()) },
            S::Ok
        );
        let count = 2000;
        let mut number = || match rng.below(6) {
            0 => f64::from_bits(rng.bits()),
            1 => rng.pick(&[f64::NAN, f64::INFINITY, -f64::INFINITY, 0.0, -0.0, 5e-324, f64::MAX]),
            _ => rng.uniform(-40.0, 80.0),
        };
        let numbers: Vec<f64> = (0..8 * count).map(|_| number()).collect();
        let codes: Vec<u64> = (0..count).map(|_| rng.bits() >> rng.below(64)).collect();
        let (mut voxels, mut faces) = (vec![0; count], vec![0u8; count]);
        let rays = VoxdagRays {
            count,
            origins: numbers.as_ptr(),
            directions: numbers[3 * count..].as_ptr(),
            t_min: numbers[6 * count..].as_ptr(),
            t_max: numbers[7 * count..].as_ptr(),
            starts: codes.as_ptr(),
            min_level: 0,
            arithmetic: 0,
        };
        let hits =
            VoxdagHits { voxels: voxels.as_mut_ptr(), from: null_mut(), t: null_mut(), faces: faces.as_mut_ptr() };
        let (mut blocked, mut ids, mut floats) = (vec![0u8; count], vec![0u32; count], vec![0.0f32; 3 * count]);
        let mut colors = vec![0u8; 4 * count];
        // SAFETY: arrays of so many items.
        unsafe {
            for starts in [null(), codes.as_ptr()] {
                let rays = VoxdagRays { starts, ..rays };
                assert_eq!(voxdag_trace_many(scene, &rays, &hits, null_mut()), S::Ok);
                assert_eq!(voxdag_occluded_many(scene, &rays, blocked.as_mut_ptr(), null_mut()), S::Ok);
            }
            // Now voxels that nothing hit, with sides from 0 to 6.
            let sides: Vec<u8> = codes.iter().map(|code| (code % 7) as u8).collect();
            for kind in 0..8 {
                let (v, f, d, n) = (codes.as_ptr(), sides.as_ptr(), rays.directions, floats.as_mut_ptr());
                assert_eq!(voxdag_normals(scene, kind, count, v, f, d, n, null_mut()), S::Ok);
                let unit = |n: &[f32]| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3;
                assert!(floats.chunks(3).all(unit), "a normal is a unit vector");
            }
            assert_eq!(voxdag_materials(scene, count, codes.as_ptr(), ids.as_mut_ptr(), null_mut()), S::Ok);
            assert_eq!(voxdag_colors(scene, count, codes.as_ptr(), colors.as_mut_ptr(), null_mut()), S::Ok);
            voxdag_scene_close(scene);
        }
    }
}

#[test]
fn damaged_words() {
    println!("seed {SEED}");
    let mut rng = Rng::new(SEED);
    for kind in [Kind::Normals, Kind::Colors, Kind::Mirrors] {
        let whole = scenes::words(kind, 40);
        let mut out = null_mut();
        for count in [0, 1, 31, 32, 50, whole.len() / 2, whole.len() - 1] {
            assert_eq!(fails!(voxdag_scene_open(whole.as_ptr(), count, 0, &mut out)).0, S::FileLength);
        }
        for _ in 0..200 {
            let mut words = whole.clone();
            for _ in 0..rng.between(1, 3) {
                let at = rng.below(words.len() as u64) as usize;
                words[at] ^= 1 << rng.below(32);
            }
            if words == whole {
                continue;
            }
            let (status, _, _, message) = fails!(voxdag_scene_open(words.as_ptr(), words.len(), 0, &mut out));
            // The message is the core's.
            let error = file::read(&words).unwrap_err();
            assert_eq!(message, error.to_string());
            assert!((16..=24).contains(&(status as i32)), "{status:?}: {message}");
        }
        let swapped: Vec<u32> = whole.iter().map(|word| word.swap_bytes()).collect();
        assert_eq!(fails!(voxdag_scene_open(swapped.as_ptr(), swapped.len(), 0, &mut out)).0, S::FileEndianness);
        let mut text = whole.clone();
        text[0] = u32::from_le_bytes(*b"v 0 ");
        assert_eq!(fails!(voxdag_scene_open(text.as_ptr(), text.len(), 0, &mut out)).0, S::FileMagic);
        assert!(out.is_null());
    }
}

#[test]
fn meshes() {
    let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f64];
    let (indices, ids) = ([0, 1, 2, 2, 1, 0u32], [0, 1u16]);
    let materials = [voxdag_material_default(); 2];
    let names = [c"a".as_ptr(), c"\xff".as_ptr()];
    let mesh = VoxdagMesh {
        vertex_count: 3,
        triangle_count: 2,
        positions: positions.as_ptr(),
        indices: indices.as_ptr(),
        triangle_materials: ids.as_ptr(),
        material_count: 2,
        materials: materials.as_ptr(),
        names: null(),
        uvs: null(),
        textures: null(),
        cutouts: null(),
    };
    let build = VoxdagBuild { resolution: 16, ..voxdag_build_default() };
    let (mut words, mut count) = (vec![0; 4096], 0usize);
    let room = words.len();
    // SAFETY: pointers to what lives here.
    assert_eq!(unsafe { voxdag_build(&mesh, &build, words.as_mut_ptr(), room, &mut count, null_mut()) }, S::Ok);

    let nan = [0.0, 0.0, 0.0, 1.0, f64::NAN, 0.0, 0.0, 1.0, 0.0];
    let dark = [materials[0], VoxdagMaterial { diffuse: [0.0, -1.0, 0.0], ..materials[0] }];
    let odd = [materials[0], VoxdagMaterial { illum: 11, ..materials[0] }];
    let (beyond, third) = ([0, 1, 2, 2, 1, 3u32], [0, 2u16]);
    for (mesh, status, position) in [
        (VoxdagMesh { positions: null(), ..mesh }, S::Null, VOXDAG_NONE),
        (VoxdagMesh { indices: null(), ..mesh }, S::Null, VOXDAG_NONE),
        (VoxdagMesh { materials: null(), ..mesh }, S::Null, VOXDAG_NONE),
        (VoxdagMesh { vertex_count: usize::MAX / 16, ..mesh }, S::Count, VOXDAG_NONE),
        (VoxdagMesh { triangle_count: usize::MAX / 4, ..mesh }, S::Count, VOXDAG_NONE),
        (VoxdagMesh { material_count: usize::MAX / 4, ..mesh }, S::Count, VOXDAG_NONE),
        (VoxdagMesh { triangle_count: 0, indices: null(), ..mesh }, S::MeshSize, VOXDAG_NONE),
        (VoxdagMesh { positions: nan.as_ptr(), ..mesh }, S::MeshNotFinite, 1),
        (VoxdagMesh { indices: beyond.as_ptr(), ..mesh }, S::MeshIndex, 1),
        (VoxdagMesh { triangle_materials: third.as_ptr(), ..mesh }, S::MeshMaterial, 1),
        (VoxdagMesh { material_count: 0, ..mesh }, S::MeshMaterial, 1),
        (VoxdagMesh { materials: dark.as_ptr(), ..mesh }, S::Material, 1),
        (VoxdagMesh { materials: odd.as_ptr(), ..mesh }, S::Material, 1),
        (VoxdagMesh { names: names.as_ptr(), ..mesh }, S::Name, 1),
    ] {
        let found = fails!(voxdag_build(&mesh, &build, words.as_mut_ptr(), room, &mut count));
        assert_eq!((found.0, found.1), (status, position), "{}", found.3);
    }
    for (build, status) in [
        (VoxdagBuild { resolution: 0, ..build }, S::Grid),
        (VoxdagBuild { resolution: 1 << 22, ..build }, S::Grid),
        (VoxdagBuild { voxel_size: f64::NAN, ..build }, S::Grid),
        (VoxdagBuild { voxel_size: -1.0, ..build }, S::Grid),
        (VoxdagBuild { voxel_size: 1.0, origin: [f64::INFINITY, 0.0, 0.0], ..build }, S::Grid),
        (VoxdagBuild { voxel_size: 0.01, ..build }, S::MeshOutside),
        (VoxdagBuild { cover: 3, ..build }, S::Argument),
        (VoxdagBuild { keep: 4, ..build }, S::Argument),
        (VoxdagBuild { colors: 2, ..build }, S::Argument),
        (VoxdagBuild { up: 2, ..build }, S::Argument),
        (VoxdagBuild { metres_per_unit: f64::NAN, ..build }, S::Argument),
        (VoxdagBuild { memory_limit: 100, ..build }, S::Memory),
    ] {
        let (found, _, needed, message) = fails!(voxdag_build(&mesh, &build, words.as_mut_ptr(), room, &mut count));
        assert_eq!(found, status, "{message}");
        assert_eq!(needed > 0, status == S::Memory);
    }
    let (status, _, needed, _) = fails!(voxdag_build(&mesh, &build, words.as_mut_ptr(), 99, &mut count));
    assert_eq!((status, needed), (S::TooSmall, count as u64));
    assert_eq!(fails!(voxdag_build(&mesh, &build, null_mut(), 99, &mut count)).0, S::Null);
    assert_eq!(fails!(voxdag_build(&mesh, &build, words.as_mut_ptr(), room, null_mut())).0, S::Null);
    assert_eq!(fails!(voxdag_build(null(), &build, words.as_mut_ptr(), room, &mut count)).0, S::Null);
    assert_eq!(fails!(voxdag_build(&mesh, null(), words.as_mut_ptr(), room, &mut count)).0, S::Null);
}

#[test]
fn textures() {
    let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f64];
    let (indices, uvs) = ([0, 1, 2u32], [0.0, 0.0, 1.0, 0.0, f32::NAN, 1.0]);
    let materials = [voxdag_material_default(); 2];
    let pixels = [200u8; 16];
    let picture = VoxdagTexture { pixels: pixels.as_ptr(), width: 2, height: 2, ..voxdag_texture_default() };
    let both = [picture; 2];
    let mesh = VoxdagMesh {
        vertex_count: 3,
        triangle_count: 1,
        positions: positions.as_ptr(),
        indices: indices.as_ptr(),
        triangle_materials: null(),
        material_count: 2,
        materials: materials.as_ptr(),
        names: null(),
        uvs: uvs.as_ptr(),
        textures: both.as_ptr(),
        cutouts: null(),
    };
    let textures = |textures: &[VoxdagTexture; 2]| VoxdagMesh { textures: textures.as_ptr(), ..mesh };
    let build = VoxdagBuild { resolution: 16, ..voxdag_build_default() };
    let (mut words, mut count) = (vec![0; 4096], 0usize);
    let room = words.len();
    let none = voxdag_texture_default();
    // What has no numbers is white; pictures without coordinates are not even read.
    let wide = VoxdagTexture { width: u32::MAX, height: u32::MAX, ..picture };
    for mesh in [textures(&both), VoxdagMesh { uvs: null(), ..textures(&[wide, none]) }] {
        // SAFETY: pointers to what lives here.
        assert_eq!(unsafe { voxdag_build(&mesh, &build, words.as_mut_ptr(), room, &mut count, null_mut()) }, S::Ok);
    }
    let odd = core::ptr::without_provenance(2);
    for (pair, status, position) in [
        ([picture, VoxdagTexture { width: 0, ..picture }], S::Material, 1),
        ([VoxdagTexture { height: 0, ..picture }, none], S::Material, 0),
        ([none, VoxdagTexture { scale: [1.0, f32::NAN], ..picture }], S::Material, 1),
        ([none, VoxdagTexture { offset: [f32::INFINITY, 0.0], ..picture }], S::Material, 1),
        ([none, VoxdagTexture { base: f32::NAN, ..picture }], S::Material, 1),
        ([none, VoxdagTexture { gain: f32::NAN, ..picture }], S::Material, 1),
        ([wide, none], S::Count, VOXDAG_NONE),
    ] {
        for by_cutout in [false, true] {
            let mesh = if by_cutout {
                VoxdagMesh { textures: null(), cutouts: pair.as_ptr(), ..mesh }
            } else {
                textures(&pair)
            };
            let found = fails!(voxdag_build(&mesh, &build, words.as_mut_ptr(), room, &mut count));
            assert_eq!((found.0, found.1), (status, position), "{}", found.3);
        }
    }
    for mesh in [VoxdagMesh { textures: odd, ..mesh }, VoxdagMesh { uvs: odd.cast(), ..mesh }] {
        assert_eq!(fails!(voxdag_build(&mesh, &build, words.as_mut_ptr(), room, &mut count)).0, S::Misaligned);
    }
    // Pictures count for the limit, before they are read and beside what is built.
    let limited = |memory_limit| VoxdagBuild { memory_limit, ..build };
    let large = VoxdagTexture { width: 1 << 12, height: 1 << 12, ..picture };
    let found =
        fails!(voxdag_build(&textures(&[large, none]), &limited(1 << 20), words.as_mut_ptr(), room, &mut count));
    assert_eq!((found.0, found.2), (S::Memory, 6 << 24));
    let mut limit = 200;
    for _ in 0..9 {
        // SAFETY: pointers to what lives here.
        let status = unsafe { voxdag_build(&mesh, &limited(limit), words.as_mut_ptr(), room, &mut count, null_mut()) };
        if status == S::Ok {
            assert!(limit > 200);
            return;
        }
        let (status, _, needed, message) =
            fails!(voxdag_build(&mesh, &limited(limit), words.as_mut_ptr(), room, &mut count));
        assert!(status == S::Memory && needed > limit, "{message}");
        limit = needed;
    }
    panic!("{limit} bytes are not enough");
}

#[test]
fn pictures() {
    let words = scenes::words(Kind::Colors, 40);
    let scene = open(&words);
    let (mut camera, mut light) = (MaybeUninit::<VoxdagCamera>::uninit(), MaybeUninit::<VoxdagLight>::uninit());
    // SAFETY: pointers to what lives here, written where the status is OK.
    let (camera, light) = unsafe {
        assert_eq!(voxdag_camera_default(scene, camera.as_mut_ptr(), light.as_mut_ptr(), null_mut()), S::Ok);
        (camera.assume_init(), light.assume_init())
    };
    let settings = VoxdagSettings { width: 16, height: 8, ..voxdag_settings_default() };
    let mut pixels = vec![0u32; 144];
    let mut fails_with = |camera: *const _, lights: &[VoxdagLight], settings: VoxdagSettings, rows: [u32; 2], room| {
        let (l, n, p) = (lights.as_ptr(), lights.len(), pixels.as_mut_ptr());
        fails!(voxdag_render_rows(scene, camera, l, n, &settings, rows[0], rows[1], p, room, null_mut()))
    };
    for settings in [
        VoxdagSettings { samples: 3, ..settings },
        VoxdagSettings { normals: 8, ..settings },
        VoxdagSettings { arithmetic: 3, ..settings },
        VoxdagSettings { supersample: 3, ..settings },
        VoxdagSettings { supersample: 2, degrees: f32::NAN, ..settings },
        VoxdagSettings { effects: 128, ..settings },
        VoxdagSettings { ambient: [f32::NAN; 3], ..settings },
        VoxdagSettings { background: [-1.0; 3], ..settings },
        VoxdagSettings { lift: f32::INFINITY, ..settings },
        VoxdagSettings { lift: 16.5, ..settings },
        VoxdagSettings { supersample: 1, region: [3, 0, 2, 8], ..settings },
        VoxdagSettings { supersample: 1, region: [0, 4, 2, 3], ..settings },
    ] {
        assert_eq!(fails_with(&camera, &[light], settings, [0, 8], 128).0, S::Argument, "{settings:?}");
    }
    for (width, height) in [(0, 8), (16, 0), (65_537, 1), (u32::MAX, u32::MAX)] {
        let settings = VoxdagSettings { width, height, ..settings };
        assert_eq!(fails_with(&camera, &[], settings, [0, 0], 128).0, S::PictureSize);
    }
    for rows in [[5, 4], [0, 9], [9, 9]] {
        assert_eq!(fails_with(&camera, &[], settings, rows, 144).0, S::PictureRows, "{rows:?}");
    }
    assert_eq!(fails_with(&camera, &[], settings, [0, 8], 127).2, 128);
    // What is wrong with the size is said first: no room would do.
    assert_eq!(fails_with(&camera, &[], settings, [0, u32::MAX], 128).0, S::PictureRows);
    let wide = VoxdagSettings { width: 70_000, ..settings };
    assert_eq!(fails_with(&camera, &[], wide, [0, 8], 128).0, S::PictureSize);
    let wrong = [
        VoxdagLight { kind: 2, ..light },
        VoxdagLight { position: [f64::NAN; 3], ..light },
        VoxdagLight { color: [f32::INFINITY; 3], ..light },
        VoxdagLight { color: [1.0, -1.0, 1.0], ..light },
        VoxdagLight { kind: 1, position: [0.0; 3], ..light },
    ];
    for wrong in wrong {
        let found = fails_with(&camera, &[light, wrong], settings, [0, 8], 128);
        assert_eq!((found.0, found.1), (S::Light, 1));
    }
    for camera in [
        VoxdagCamera { eye: [f64::NAN; 3], ..camera },
        VoxdagCamera { eye: camera.target, ..camera },
        VoxdagCamera { fov_y: 180.0, ..camera },
    ] {
        assert_eq!(fails_with(&camera, &[], settings, [0, 8], 128).0, S::Camera);
    }
    assert_eq!(fails_with(null(), &[], settings, [0, 8], 128).0, S::Null);
    let nothing = null_mut::<u32>();
    let status = fails!(voxdag_render_rows(scene, &camera, &light, 1, &settings, 0, 8, nothing, 128, null_mut())).0;
    assert_eq!(status, S::Null);
    // SAFETY: opened above.
    unsafe { voxdag_scene_close(scene) };
}
