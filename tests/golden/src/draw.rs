//! Rays and pixels of a scene, hashed as they come: no heap, and a row of pixels is all that is kept.

use voxdag::camera::Camera;
use voxdag::file::Scene;
use voxdag::material::Material;
use voxdag::math;
use voxdag::morton::Morton;
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{RenderError, Settings, View, each_pixel, render_rows};
use voxdag::shade::{Light, LightKind, Surface, shade};
use voxdag::trace::{Arithmetic, Hit, Query, Top, Tracer};

use crate::Hash;
use crate::hashes::Case;

/// Room for the materials of a scene.
const PALETTE: usize = 32;
/// Room for a row of pixels; pictures are not higher either.
const WIDTH: usize = 128;
/// The picture is traced with a top grid of 2^TOP cells a side, the rays without.
const TOP: u8 = 2;

/// What the picture needs besides voxels.
struct Stage {
    camera: Camera,
    lights: [Light; 2],
    palette: [Material; PALETTE],
}

impl Stage {
    fn of(scene: &Scene<'_>, case: &Case) -> Stage {
        let mut camera = Camera::framing(&scene.bounds, scene.up);
        if let Some([eye, target]) = case.view {
            camera = Camera { eye, target, ..camera };
        }
        // From above, so that its way to the surface is not the ray's; and a coloured one without a place.
        let above = Light { color: [0.7, 0.65, 0.6], ..camera.headlight(scene.bounds.radius()) };
        let beside = LightKind::Directional(scene.up.turn([-0.3, 0.7, 0.2]));
        let lights = [above, Light { kind: beside, color: [0.2, 0.3, 0.45], shadow: false }];
        Stage { camera, lights, palette: core::array::from_fn(|id| scene.material(id as u16)) }
    }
}

/// The hash of everything that one ray per four pixels of the picture meets.
pub fn rays(scene: &Scene<'_>, case: &Case) -> Result<u64, RenderError> {
    let stage = Stage::of(scene, case);
    let (mut hash, tracer) = (Hash::default(), Tracer::new(scene.geometry));
    let size = case.size.map(|side| side / 2);
    // Nothing is kept, and a list of that takes no memory.
    let mut nothing = [(); WIDTH * WIDTH];
    let nothing = &mut nothing[..(size[0] * size[1]) as usize];
    each_pixel(&stage.camera, &scene.grid, size, 0..size[1], nothing, |pixel| {
        let query = pixel.query([0.5; 2]);
        for arithmetic in [Arithmetic::Exact, Arithmetic::F64] {
            for min_level in [3, 1, 0] {
                let query = Query { min_level, ..query };
                add_hit(&mut hash, tracer.trace(arithmetic, &query));
            }
        }
        if let Some(hit) = tracer.trace(Arithmetic::Exact, &query) {
            add_surface(&mut hash, scene, &stage, &query, &hit);
        }
    })?;
    Ok(hash.0)
}

fn add_voxel(hash: &mut Hash, voxel: Option<Morton>) {
    hash.add_u64(voxel.map_or(u64::MAX, |voxel| voxel.0));
}

fn add_hit(hash: &mut Hash, hit: Option<Hit>) {
    add_voxel(hash, hit.map(|hit| hit.voxel));
    if let Some(hit) = hit {
        add_voxel(hash, hit.from);
        hash.add_u64(hit.t.to_bits());
        hash.add_f32s(hit.face.normal());
        hash.add(u32::from(hit.level));
    }
}

/// Every kind of normal, the colour by it, and whether the first light is seen.
fn add_surface(hash: &mut Hash, scene: &Scene<'_>, stage: &Stage, query: &Query, hit: &Hit) {
    let id = voxdag::Materials::id(&scene.materials, hit.voxel);
    let place = math::add_scaled(query.origin, query.dir, hit.t);
    let point = scene.grid.to_world(place);
    let view = math::normalize(query.dir.map(|x| -x)).unwrap_or([0.0; 3]).map(|x| x as f32);
    hash.add(u32::from(id));
    for kind in [
        NormalKind::Face,
        NormalKind::Stored,
        NormalKind::Gradient,
        NormalKind::Plane1,
        NormalKind::Plane2,
        NormalKind::Plane3,
    ] {
        let normal = normal(&Tracer::new(scene.geometry), scene.materials, hit, query.dir, kind).direction;
        let color = shade(&scene.material(id), &Surface { point, normal, view }, [0.1; 3], &stage.lights);
        hash.add_f32s(normal);
        hash.add_f32s(color);
    }
    if let Some(light) = stage.lights[0].direction_from(point) {
        let shadow = Query { start: hit.from, ..Query::new(place, light) };
        hash.add(u32::from(Tracer::new(scene.geometry).occluded(Arithmetic::Exact, &shadow)));
    }
}

/// The hash of the picture.
pub fn image(scene: &Scene<'_>, case: &Case) -> Result<u64, RenderError> {
    let stage = Stage::of(scene, case);
    let (mut words, mut scratch) = ([0; Top::words_for(TOP)], [0; Top::scratch_for(TOP)]);
    let top = Top::build_into(&scene.geometry, TOP, &mut words, &mut scratch);
    let view = View {
        tracer: top.and_then(|top| Tracer::with_top(scene.geometry, top)).unwrap_or(Tracer::new(scene.geometry)),
        materials: scene.materials,
        palette: &stage.palette,
        grid: scene.grid,
        camera: stage.camera,
        lights: &stage.lights,
    };
    let [width, height] = case.size;
    let settings = Settings {
        width,
        height,
        samples: case.samples,
        normals: case.normals,
        ambient: [0.1; 3],
        ..Settings::default()
    };
    let mut hash = Hash::default();
    let mut row = [0; WIDTH];
    let row = &mut row[..(width as usize).min(WIDTH)];
    for y in 0..height {
        render_rows(&view, &settings, y..y + 1, row)?;
        row.iter().for_each(|&pixel| hash.add(pixel));
    }
    Ok(hash.0)
}
