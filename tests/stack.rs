//! How much stack calls take, as their documentation says: each runs in a thread that has no more.
//!
//! A thread without enough ends its whole process, so every call has a process of its own: this test again, told by the
//! environment which one it is.

use std::hint::black_box;
use std::process::Command;

use voxdag::camera::Camera;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::normal::{Confidence, Normal, NormalKind, normal, normals};
use voxdag::render::{Counters, Full, Phong, Samples, Settings, Shadows, View, render_rows, render_rows_by};
use voxdag::shade::{Light, LightKind};
use voxdag::simd::Level;
use voxdag::trace::{Arithmetic, Hit, Query, Tile, TopBuf, Tracer};
use voxdag::wide::WideBuf;
use voxdag::{Dag, Grid, Material, Materials, Morton};
use voxdag_oracle::octree::VoxelSet;

const CASE: &str = "VOXDAG_STACK";

/// KiB that a thread takes by itself, its guard page aside.
const THREAD: usize = 4;

/// KiB that are used up before a call, as threads of a few pages are made larger than was asked for.
const BURNT: usize = 64;

/// Calls, and the KiB that they are said to take at most.
const CASES: [(&str, usize); 9] = [
    ("one ray", 8),
    ("rays in blocks", 10),
    ("many rays", 100),
    ("a tile", 100),
    ("many normals", 20),
    ("phong", 200),
    ("shadows", 200),
    ("full", 350),
    ("render_rows", 350),
];

#[test]
fn calls_take_no_more_stack_than_is_said() {
    if let Ok(case) = std::env::var(CASE) {
        let (name, size) = case.split_once('=').expect("NAME=KIB");
        return run(name, size.parse().expect("a size in KiB"));
    }
    let this = std::env::current_exe().unwrap();
    for (name, size) in CASES {
        let run = Command::new(&this).env(CASE, format!("{name}={}", size + THREAD)).output().unwrap();
        assert!(run.status.success(), "{name} in {size} KiB: {}", String::from_utf8_lossy(&run.stderr));
    }
    // The threads really have no more: these cannot do with so little.
    for (name, size) in [("one ray", 2), ("many rays", 40), ("full", 64)] {
        let run = Command::new(&this).env(CASE, format!("{name}={}", size + THREAD)).output().unwrap();
        assert!(!run.status.success(), "{name} in {size} KiB");
    }
}

/// All voxels of one material.
#[derive(Clone, Copy)]
struct Alike;

impl Materials for Alike {
    fn id(&self, _: Morton) -> u16 {
        0
    }

    fn normal(&self, _: Morton) -> Option<[f32; 3]> {
        None
    }
}

/// Calls with [`BURNT`] KiB of the stack used up.
#[inline(never)]
fn burn(call: Box<dyn FnOnce() + Send + '_>) {
    let mut block = [0u8; BURNT << 10];
    black_box(&mut block);
    call();
    black_box(&mut block);
}

fn run(name: &str, size: usize) {
    const SIDE: u32 = 64;
    let shell = |v: [u32; 3]| (400..700).contains(&v.map(|c| c.abs_diff(32).pow(2)).iter().sum::<u32>());
    let voxels = (0..SIDE.pow(3)).map(|i| [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE]);
    let words = VoxelSet::new(voxels.filter(|v| shell(*v))).words(6);
    let dag = Dag::new(&words).unwrap();
    let wide = WideBuf::new(&dag, usize::MAX).unwrap();
    let top = TopBuf::new(&wide.as_wide(), 2).unwrap();
    let tracer = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap().with_level(Level::best());
    let lights = [Light { kind: LightKind::Directional([1.0, 2.0, 3.0]), color: [1.0; 3], shadow: true }];
    let glass = Material { specular: [0.5; 3], opacity: 0.5, refraction: 1.5, illum: 7, ..Material::GREY };
    let grid = Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: SIDE };
    let camera = Camera::framing(&Bounds { min: [0.0; 3], max: [SIDE.into(); 3] }, UpAxis::Y);
    let view = View { tracer, materials: Alike, palette: &[glass], grid, camera, lights: &lights };

    let query = |i: usize| Query::new([32.5, 32.5, 90.0], [i as f64 / 5000.0, 0.0, -1.0]);
    let settings = Settings { width: 64, height: 48, samples: Samples::Sixteen, ..Settings::default() };
    let drawn = |counters: Result<Counters, _>| assert!(counters.unwrap().hits > 100);
    let dirs: Vec<_> = (0..1000).map(|i| query(i).dir).collect();
    let hits: Vec<_> = (0..300).map(|i| tracer.trace(Arithmetic::Exact, &query(i)).unwrap()).collect();
    let mut fitted = vec![Normal { direction: [0.0; 3], confidence: Confidence::Face }; hits.len()];
    let mut pixels = vec![0; 64 * 48];
    let places: Vec<_> = (0..1000).map(|i| [f64::from(i % 32), f64::from(i / 32)]).collect();
    let mut met = vec![None; places.len()];
    // Behind a pointer, so that no call's room becomes another's.
    let call: Box<dyn FnOnce() + Send> = match name {
        "one ray" => Box::new(|| {
            let tracer = Tracer::new(dag);
            let hit = tracer.trace(Arithmetic::Exact, &query(0)).unwrap();
            black_box(normal(&tracer, Alike, &hit, query(0).dir, NormalKind::Plane2));
        }),
        "many rays" => Box::new(|| {
            let mut met = 0;
            let put = |_, hit: Option<Hit>| met += usize::from(hit.is_some());
            tracer.trace_each(Arithmetic::Exact, 1000, query, put);
            assert!(met > 500);
        }),
        "rays in blocks" => Box::new(|| {
            let tracer = Tracer::new(dag);
            let mut met = 0;
            tracer.trace_each(Arithmetic::Exact, 100, query, |_, hit: Option<Hit>| met += usize::from(hit.is_some()));
            tracer.occluded_each(Arithmetic::Exact, 100, query, |_, blocked| met += usize::from(blocked));
            assert!(met > 100);
        }),
        "a tile" => Box::new(|| {
            let (corner, dx, dy) = ([-0.1, -0.1, -1.0], [0.002, 0.0, 0.0], [0.0, 0.002, 0.0]);
            let tile = Tile { origin: [32.5, 32.5, 90.0], corner, dx, dy, places: &places };
            tracer.trace_tile(Arithmetic::Exact, &tile, &mut met);
            assert!(met.iter().flatten().count() > 100);
        }),
        "many normals" => Box::new(|| {
            for (kind, level) in NormalKind::ALL.into_iter().flat_map(|kind| [(kind, None), (kind, Level::best())]) {
                normals(level, &tracer, Alike, &hits, &dirs, kind, &mut fitted);
                assert!(fitted.iter().any(|normal| normal.direction[2] > 0.9), "{kind:?}");
            }
        }),
        "phong" => Box::new(|| drawn(render_rows_by::<Phong, _, _>(&view, &settings, 0..48, &mut pixels))),
        "shadows" => Box::new(|| drawn(render_rows_by::<Shadows, _, _>(&view, &settings, 0..48, &mut pixels))),
        "full" => Box::new(|| drawn(render_rows_by::<Full, _, _>(&view, &settings, 0..48, &mut pixels))),
        "render_rows" => Box::new(|| drawn(render_rows(&view, &settings, 0..48, &mut pixels))),
        _ => panic!("{name}"),
    };
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size((BURNT + size) << 10).spawn_scoped(scope, || burn(call));
        thread.unwrap().join().unwrap();
    });
}
