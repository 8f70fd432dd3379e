//! A ray query: what a ray meets in a `.vxd` file, where, of which material, and which way it faces.
//!
//! `cargo run --release -p voxdag --features obj --example ray_query -- SCENE.vxd`; without a file on one of this repository.

use std::error::Error;

use voxdag::camera::Camera;
use voxdag::file::{self, Scene};
use voxdag::normal::{NormalKind, normal};
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::{Geometry, Materials, math};

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
    let path = std::env::args().nth(1).unwrap_or(EXAMPLE.into());
    let bytes = std::fs::read(&path).map_err(|error| format!("{path}: {error}"))?;
    let words = file::words_from_bytes(&bytes).map_err(|error| format!("{path}: {error}"))?;
    let scene = file::read(&words).map_err(|error| format!("{path}: {error}"))?;
    // From the default view's eye to the middle of the first filled voxel: whatever comes first on the way.
    let from = Camera::framing(&scene.bounds, scene.up).eye;
    let first = scene.geometry.voxels().next().ok_or("the scene is empty")?;
    let to = scene.grid.to_world(first.decode().map(|x| f64::from(x) + 0.5));
    println!("{}", look(&scene, from, to).as_deref().unwrap_or("nothing"));
    Ok(())
}

/// A scene of this repository.
const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/v4.vxd");

#[test]
fn the_example_is_seen() {
    let words = file::words_from_bytes(&std::fs::read(EXAMPLE).unwrap()).unwrap();
    let scene = file::read(&words).unwrap();
    let from = Camera::framing(&scene.bounds, scene.up).eye;
    let seen = look(&scene, from, scene.grid.to_world([0.5; 3]));
    assert_eq!(
        seen.as_deref(),
        Some("voxel [0, 0, 1] of wände at [0.896, 0.000, 1.569], facing [-0.00, -1.00, -0.00]")
    );
    assert_eq!(look(&scene, [1e6; 3], [2e6; 3]), None);
}
