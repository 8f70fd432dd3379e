//! A small picture by what a program without an operating system calls: one ray at a time, a few KiB of stack.
//!
//! In: the words of a file. Out: RGBA8 pixels, row by row: exact rays, normals of kind `Plane2`, Phong shading by a headlight.
//! Nothing here is for tests alone: `tests/bare` links it as its own, and measures what that takes.

use voxdag::camera::Camera;
use voxdag::color::{linear_to_srgb8, quantize};
use voxdag::file::{self, LoadError, Scene};
use voxdag::layout::AnyGeometry;
use voxdag::math;
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{RenderError, each_pixel};
use voxdag::shade::{Light, Surface, shade};
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::{Dag, Materials};

use crate::Hash;

/// Width and height in pixels.
pub const SIZE: [u32; 2] = [64, 48];

/// Why there is no picture.
#[derive(Debug)]
pub enum Refused {
    /// The words are not those of a file.
    File(LoadError),
    /// The scene is no DAG, but another geometry.
    Geometry,
    /// The scene cannot be looked at.
    Picture(RenderError),
}

/// The hash of the picture.
pub fn hash(words: &[u32]) -> Result<u64, Refused> {
    let mut hash = Hash::default();
    draw(words, |pixel| hash.add(pixel))?;
    Ok(hash.0)
}

/// Draws the picture of a file with a DAG, and gives `put` every pixel as it is done.
pub fn draw(words: &[u32], mut put: impl FnMut(u32)) -> Result<(), Refused> {
    let scene = file::read(words).map_err(Refused::File)?;
    let AnyGeometry::Dag(dag) = scene.geometry else { return Err(Refused::Geometry) };
    let tracer: Tracer<'_, Dag<'_>> = Tracer::new(dag);
    let camera = Camera::framing(&scene.bounds, scene.up);
    let lights = [camera.headlight(scene.bounds.radius())];
    let mut row = [(); SIZE[0] as usize];
    for y in 0..SIZE[1] {
        each_pixel(&camera, &scene.grid, SIZE, y..y + 1, &mut row, |pixel| {
            let color = look(&tracer, &scene, &lights, &pixel.query([0.5; 2]));
            let [red, green, blue] = color.map(|linear| linear_to_srgb8(quantize(linear)));
            put(u32::from_le_bytes([red, green, blue, 255]));
        })
        .map_err(Refused::Picture)?;
    }
    Ok(())
}

/// What is seen along a ray in grid coordinates: linear red, green, blue.
fn look(tracer: &Tracer<'_, Dag<'_>>, scene: &Scene<'_>, lights: &[Light], ray: &Query) -> [f32; 3] {
    let Some(hit) = tracer.trace(Arithmetic::Exact, ray) else { return [0.75; 3] };
    let surface = Surface {
        point: scene.grid.to_world(math::add_scaled(ray.origin, ray.dir, hit.t)),
        normal: normal(tracer, scene.materials, &hit, ray.dir, NormalKind::Plane2).direction,
        view: math::normalize(ray.dir.map(|x| -x)).unwrap_or([0.0; 3]).map(|x| x as f32),
    };
    shade(&scene.material(scene.materials.id(hit.voxel)), &surface, [0.2; 3], lights)
}
