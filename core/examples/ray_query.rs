//! A ray query: what a ray meets in a `.vxd` file, where, of which material, and which way it faces.
//!
//! `cargo run --release --example ray_query -- SCENE.vxd`

use std::error::Error;

use voxdag::camera::Camera;
use voxdag::file::{self, Scene};
use voxdag::normal::{NormalKind, normal};
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::{Materials, math};

/// What is seen from one place of the world towards another.
fn look(scene: &Scene<'_>, from: [f64; 3], to: [f64; 3]) -> Option<String> {
    let [origin, target] = [from, to].map(|place| scene.grid.to_grid(place));
    let (tracer, dir) = (Tracer::new(scene.geometry), math::sub(target, origin));
    let hit = tracer.trace(Arithmetic::Exact, &Query::new(origin, dir))?;
    let place = scene.grid.to_world(math::add_scaled(origin, dir, hit.t));
    let normal = normal(&tracer, scene.materials, &hit, dir, NormalKind::Plane2).direction;
    let material = scene.name(scene.materials.id(hit.voxel));
    Some(format!("voxel {:?} of {material} at {place:.3?}, facing {normal:.2?}", hit.voxel.decode()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().find(|arg| arg.ends_with(".vxd")).unwrap_or(EXAMPLE.into());
    let words = file::words_from_bytes(&std::fs::read(path)?)?;
    let scene = file::read(&words)?;
    let from = Camera::framing(&scene.bounds, scene.up).eye;
    println!("{}", look(&scene, from, scene.bounds.center()).as_deref().unwrap_or("nothing"));
    Ok(())
}

/// A scene of this repository.
const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/v4.vxd");

#[test]
fn the_example_is_seen() {
    let words = file::words_from_bytes(&std::fs::read(EXAMPLE).unwrap()).unwrap();
    let scene = file::read(&words).unwrap();
    let center = scene.bounds.center();
    let seen = look(&scene, Camera::framing(&scene.bounds, scene.up).eye, center);
    assert_eq!(seen.as_deref(), Some(""));
    assert_eq!(look(&scene, [1e6; 3], [2e6; 3]), None);
}
