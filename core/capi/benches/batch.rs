//! What the C ABI costs: batches of 1024 rays through `voxdag_trace_many` and through the core's `trace_many`, in turns.
//!
//! `cargo bench -p voxdag-capi` draws the demo's rays; `cargo bench -p voxdag-capi -- FILE.vxd` those of another scene. Prints
//! medians over rounds of the times and of their ratios, for rays of a camera in tiles of 32 x 32 and for rays without any
//! order. The two take turns batch by batch, the first one changing, so that whatever else the machine does slows both.

use std::hint::black_box;
use std::ops::Range;
use std::ptr::{null, null_mut};
use std::time::Instant;

use voxdag::camera::Camera;
use voxdag::file::{self, Parts};
use voxdag::grid::UpAxis;
use voxdag::layout::AnyGeometry;
use voxdag::scene::{Build, Options};
use voxdag::trace::{Arithmetic, Hit, Query, Tracer};
use voxdag::trees::Trees;
use voxdag::{Geometry, Grid, with_tracer};
use voxdag_capi::*;
use voxdag_oracle::rng::Rng;

const BATCH: usize = 1024;
const ROUNDS: usize = 61;
/// Width and height of the picture.
const SIDE: u32 = 512;

fn main() {
    let path = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let words = match &path {
        Some(path) => file::words_from_bytes(&std::fs::read(path).expect("the file can be read")).expect("a .vxd file"),
        None => demo(),
    };
    let scene = file::read(&words).expect("a scene");
    println!("{}, resolution {}", path.as_deref().unwrap_or("the demo"), scene.grid.resolution);

    let camera = Camera::framing(&scene.bounds, scene.up);
    let (rays, eye) = (camera.rays(SIDE, SIDE).unwrap(), scene.grid.to_grid(camera.eye));
    let tiles = (0..SIDE).step_by(32).flat_map(|y| (0..SIDE).step_by(32).map(move |x| [x, y]));
    let pixels = tiles.flat_map(|[x, y]| (0..1024).map(move |i| [x + i % 32, y + i / 32]));
    let ordered: Vec<_> = pixels
        .map(|pixel| pixel.map(|k| f64::from(k) + 0.5))
        .map(|[x, y]| Query::new(eye, rays.direction(x, y)))
        .collect();
    let (mut rng, side) = (Rng::new(1), f64::from(scene.grid.resolution));
    let point = |rng: &mut Rng| std::array::from_fn(|_| rng.uniform(0.0, side));
    let scattered: Vec<_> = (0..SIDE * SIDE / 4)
        .map(|_| {
            let direction = rng.direction();
            Query::new(point(&mut rng), direction)
        })
        .collect();

    for (trees, limit) in [("trees", None), ("no trees", Some(0))] {
        let derived = Trees::new(scene.geometry, limit);
        let mut handle = null_mut();
        // SAFETY: the words are there until the end.
        let opened = unsafe {
            voxdag_scene_open(words.as_ptr(), words.len(), limit.unwrap_or(u64::MAX), &mut handle, null_mut())
        };
        assert_eq!(opened, VoxdagStatus::Ok);
        for (name, queries) in [("camera", &ordered), ("scattered", &scattered)] {
            let columns = Columns::new(queries);
            let mut hits = vec![None; BATCH];
            let mut out =
                Out { voxels: vec![0; BATCH], from: vec![0; BATCH], t: vec![0.0; BATCH], faces: vec![0; BATCH] };
            let (mut core, mut c, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
            with_tracer!(scene.geometry, &derived, tracer => for _ in 0..ROUNDS {
                let mut times = [0.0; 2];
                for (number, batch) in queries.chunks(BATCH).enumerate() {
                    let range = number * BATCH..number * BATCH + batch.len();
                    for turn in [number % 2, (number + 1) % 2] {
                        times[turn] += match turn {
                            0 => timed(|| through_core(&tracer, batch, &mut hits)),
                            _ => timed(|| through_c(handle, &columns, range.clone(), &mut out)),
                        };
                    }
                }
                core.push(times[0]);
                c.push(times[1]);
                ratios.push(times[1] / times[0]);
            });
            let per_ray = |times| 1e9 * median(times) / queries.len() as f64;
            println!(
                "{trees:8} {name:9}  Rust {:6.1} ns a ray, C {:6.1} ns, ratio {:.3}",
                per_ray(core),
                per_ray(c),
                median(ratios)
            );
        }
        // SAFETY: opened above.
        unsafe { voxdag_scene_close(handle) };
    }
}

/// Rays as C has them.
struct Columns {
    origins: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
}

/// Hits as C has them.
struct Out {
    voxels: Vec<u64>,
    from: Vec<u64>,
    t: Vec<f64>,
    faces: Vec<u8>,
}

impl Columns {
    fn new(queries: &[Query]) -> Columns {
        Columns {
            origins: queries.iter().map(|query| query.origin).collect(),
            directions: queries.iter().map(|query| query.dir).collect(),
        }
    }
}

#[inline(never)]
fn through_core<G: Geometry>(tracer: &Tracer<'_, G>, batch: &[Query], hits: &mut [Option<Hit>]) {
    tracer.trace_many(Arithmetic::Exact, batch, hits);
    black_box(hits);
}

#[inline(never)]
fn through_c(scene: *const VoxdagScene, columns: &Columns, range: Range<usize>, out: &mut Out) {
    let rays = VoxdagRays {
        count: range.len(),
        origins: columns.origins[range.clone()].as_ptr().cast(),
        directions: columns.directions[range].as_ptr().cast(),
        t_min: null(),
        t_max: null(),
        starts: null(),
        min_level: 0,
        arithmetic: 0,
    };
    let hits = VoxdagHits {
        voxels: out.voxels.as_mut_ptr(),
        from: out.from.as_mut_ptr(),
        t: out.t.as_mut_ptr(),
        faces: out.faces.as_mut_ptr(),
    };
    // SAFETY: a scene that is open, and arrays of as many items as the count says, or more.
    let status = unsafe { voxdag_trace_many(scene, &rays, &hits, null_mut()) };
    assert_eq!(status, VoxdagStatus::Ok);
    black_box(out);
}

fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The words of the demo's hall.
fn demo() -> Vec<u32> {
    let (obj, mtl) = (voxdag::demo::obj(), voxdag::demo::mtl());
    let model = voxdag::obj::import(obj.as_bytes(), |_| Some(mtl.clone().into_bytes())).expect("the demo is a mesh");
    let mesh = model.mesh();
    let bounds = mesh.validate().unwrap();
    let grid = Grid::fit(&bounds, voxdag::demo::RESOLUTION).unwrap();
    let built = Build::new(&mesh, &grid, &Options::default()).unwrap().run().unwrap();
    let names: Vec<&str> = model.materials.iter().map(|named| &named.name[..]).collect();
    let materials: Vec<_> = model.materials.iter().map(|named| named.material).collect();
    let parts = Parts {
        grid,
        bounds,
        up: UpAxis::Y,
        metres_per_unit: 1.0,
        geometry: AnyGeometry::Dag(built.dag.dag()),
        voxel_materials: built.materials.as_materials(None).unwrap(),
        colors: None,
        materials: &materials,
        names: &names,
    };
    parts.to_vec().unwrap()
}
