//! Own shading on hits: how much of the sky each place sees, by rays of its own. The engine's work is the tracing alone.
//!
//! `cargo run --release -p voxdag --features obj --example own_shading -- sky.pgm` writes a picture, grey.

use std::error::Error;

use voxdag::camera::Camera;
use voxdag::demo;
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{Pixel, each_pixel};
use voxdag::scene::{Build, Options};
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::{Geometry, Grid, Materials, color, math, obj};

/// Rays to the sky from each place.
const RAYS: u32 = 32;
/// How far they look, in voxels.
const REACH: f64 = 160.0;

/// The share of the sky, 0 to 1, that is seen from where a pixel's ray ends; `None` where it ends nowhere.
fn sky<G: Geometry, M: Materials>(tracer: &Tracer<'_, G>, materials: M, pixel: &Pixel<'_>) -> Option<f64> {
    let ray = pixel.query([0.5; 2]);
    let hit = tracer.trace(Arithmetic::Exact, &ray)?;
    let up = normal(tracer, materials, &hit, ray.dir, NormalKind::Plane3).direction.map(f64::from);
    // Above the steps of the surface, which are as high as this along the normal.
    let steps: f64 = up.iter().map(|x| x.abs()).sum();
    let place = math::add_scaled(math::add_scaled(ray.origin, ray.dir, hit.t), up, steps);
    let open = (0..RAYS).filter(|&i| {
        // Points spread evenly over a ball, added to the normal: more rays where the sky counts more (Lambert).
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(RAYS);
        let (sin, cos) = libm::sincos(2.399_963_229_728_653 * f64::from(i));
        let r = (1.0 - z * z).sqrt();
        let dir = math::add_scaled([r * cos, r * sin, z], up, 1.0);
        let t_max = REACH / math::sqrt(math::dot(dir, dir));
        !tracer.occluded(Arithmetic::Exact, &Query { t_max, ..Query::new(place, dir) })
    });
    Some(open.count() as f64 / f64::from(RAYS))
}

/// A picture of the scene that comes along, as grey values.
fn draw(size: [u32; 2], resolution: u32) -> Result<Vec<u8>, Box<dyn Error>> {
    let model = obj::import(demo::obj().as_bytes(), |_| Some(demo::mtl().into_bytes()))?;
    let mesh = model.mesh();
    let grid = Grid::fit(&mesh.validate()?, resolution)?;
    let built = Build::new(&mesh, &grid, &Options::default())?.run()?;
    let materials = built.materials.as_materials(None)?;
    let demo::DemoView { eye, target, up, fov_y, .. } = demo::view();
    let camera = Camera { eye, target, up, fov_y };
    let (tracer, mut grey) = (Tracer::new(built.dag.dag()), vec![0; (size[0] * size[1]) as usize]);
    each_pixel(&camera, &grid, size, 0..size[1], &mut grey, |pixel| {
        let light = sky(&tracer, materials, pixel).unwrap_or(1.0);
        color::linear_to_srgb8(color::quantize(light as f32))
    })?;
    Ok(grey)
}

fn main() -> Result<(), Box<dyn Error>> {
    if let Some(path) = std::env::args().nth(1) {
        let size = [960, 540];
        let header = format!("P5 {} {} 255\n", size[0], size[1]).into_bytes();
        std::fs::write(&path, [header, draw(size, 1024)?].concat())?;
        println!("{path}");
    } else {
        println!("name a file for the picture:");
        println!("cargo run --release -p voxdag --features obj --example own_shading -- sky.pgm");
    }
    Ok(())
}

#[test]
fn niches_are_darker_than_what_lies_open() {
    let mut grey = draw([64, 36], 256).unwrap();
    grey.sort();
    let (dark, light) = (grey[grey.len() / 10], grey[grey.len() * 9 / 10]);
    assert!(0 < dark && dark < 130 && light > dark + 50, "a tenth is darker than {dark}, a tenth lighter than {light}");
}
