//! Loading, tracing, normals, materials and drawing allocate nothing: the allocator ends the program if they do.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use voxdag::camera::Camera;
use voxdag::file::{self, Parts};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{Samples, Settings, Supersample, View, render_rows};
use voxdag::scene::{Build, MaterialMode, Options};
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::{Grid, Material, Materials, Mesh};
use voxdag_oracle::scenes;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn queries_and_pictures_take_no_heap() {
    // Everything that may take memory comes first: the words of a file, a top grid, room for pixels.
    let sphere = scenes::sphere([0.0; 3], 1.0, 3);
    let mesh = sphere.mesh();
    let bounds = mesh.validate().unwrap();
    let grid = Grid::fit(&bounds, 100).unwrap();
    for materials in [MaterialMode::TableNormals, MaterialMode::Tree] {
        take_no_heap(&mesh, bounds, grid, materials);
    }
}

fn take_no_heap(mesh: &Mesh<'_>, bounds: Bounds, grid: Grid, materials: MaterialMode) {
    let options = Options { materials, ..Options::default() };
    let built = Build::new(mesh, &grid, &options).unwrap().run().unwrap();
    let parts = Parts {
        grid,
        bounds,
        up: UpAxis::Y,
        metres_per_unit: 0.0,
        geometry: built.dag.dag().into(),
        voxel_materials: built.materials.as_materials(None).unwrap(),
        materials: &[Material::GREY],
        names: &["grey"],
    };
    let words = parts.to_vec().unwrap();
    let top = TopBuf::new(&built.dag.dag(), 3).unwrap();
    let mut pixels = vec![0; 64 * 48];
    let mut hits = 0;

    assert_no_alloc(|| {
        let scene = file::read(&words).unwrap();
        let camera = Camera::framing(&scene.bounds, scene.up);
        let lights = [camera.headlight(scene.bounds.radius())];
        for tracer in [Tracer::new(scene.geometry), Tracer::with_top(scene.geometry, top.as_top()).unwrap()] {
            let view =
                View { tracer, materials: scene.materials, palette: &[Material::GREY], grid, camera, lights: &lights };
            for normals in [NormalKind::Stored, NormalKind::Plane2] {
                let near = Supersample::near(scene.geometry, &camera, 0.5);
                for supersample in [Supersample::All, near, Supersample::Adaptive { degrees: 2.0 }] {
                    let samples = if supersample == near { Samples::Five } else { Samples::Sixteen };
                    let size = Settings { width: 64, height: 48, ..Settings::default() };
                    let settings = Settings { samples, supersample, normals, ..size };
                    hits += render_rows(&view, &settings, 0..48, &mut pixels).unwrap().hits;
                }
            }
            let eye = grid.to_grid(camera.eye);
            for i in 0..100 {
                let aim = f64::from(i);
                let query = Query::new(eye, core::array::from_fn(|k| aim - eye[k]));
                assert_eq!(tracer.occluded(Arithmetic::Exact, &query), tracer.trace(Arithmetic::F64, &query).is_some());
                hits += tracer.hits(&query).count() as u64 + query.voxels(7).count() as u64;
                if let Some(hit) = tracer.trace(Arithmetic::Exact, &query) {
                    assert_eq!(scene.materials.id(hit.voxel), 0);
                    for kind in [
                        NormalKind::Face,
                        NormalKind::Gradient,
                        NormalKind::Plane1,
                        NormalKind::Plane3,
                        NormalKind::Ernerfeldt2,
                    ] {
                        normal(&Tracer::new(scene.geometry), scene.materials, &hit, query.dir, kind);
                    }
                }
            }
        }
    });
    assert!(hits > 10_000, "{hits} hits are too few to say anything");
}
