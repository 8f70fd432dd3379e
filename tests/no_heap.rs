//! Loading, tracing, normals, materials and drawing allocate nothing: the allocator ends the program if they do.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use voxdag::camera::Camera;
use voxdag::file::{self, Parts};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::normal::{NormalKind, normal};
use voxdag::rank::{MoxelDagBuf, OffsetsBuf, Prefix};
use voxdag::ranked::{Moxels, MoxelsBuf, Packed, PackedBuf, Palettes, PalettesBuf, Ranked};
use voxdag::render::{Samples, Settings, Supersample, View, render_rows};
use voxdag::scene::{Build, MaterialMode, Options};
use voxdag::shade::Light;
use voxdag::simd::Level;
use voxdag::ssvdag::SsvdagBuf;
use voxdag::table::Entry;
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::wide::WideBuf;
use voxdag::{Dag, Geometry, Grid, Material, Materials, Mesh, Morton, Ssvdag};
use voxdag_oracle::scenes::{self, Implicit};

/// Calls for every effect.
const GLASS: Material =
    Material { specular: [0.05; 3], emission: [0.1; 3], opacity: 0.7, refraction: 1.5, illum: 6, ..Material::GREY };

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

#[test]
fn ranks_and_materials_by_rank_take_no_heap() {
    let words = Implicit::Diagonal { lo: 100, hi: 102 }.words(7);
    let dag = Dag::new(&words).unwrap();
    let entries = || dag.voxels().map(|v| (v, Entry { material: (v.0 % 5) as u16, normal: None }));
    let mut lent = vec![0; Prefix::words_for(&dag)];
    let (offsets, moxels) = (OffsetsBuf::build(&dag).unwrap(), MoxelDagBuf::build(&dag).unwrap());
    let packed = PackedBuf::from_entries(entries()).unwrap().into_words();
    let palettes = PalettesBuf::from_entries(entries()).unwrap().into_words();
    let table = MoxelsBuf::from_entries(entries(), true).unwrap().into_words();
    let mut voxels = 0;
    assert_no_alloc(|| {
        let counts = Prefix::build_into(dag, &mut lent).unwrap().words();
        let prefix = Prefix::new(dag, counts).unwrap();
        let ids = Ranked::new(prefix, Packed::new(&packed).unwrap()).unwrap();
        let blocks = Ranked::new(offsets.as_offsets(), Palettes::new(&palettes).unwrap()).unwrap();
        let table = Ranked::new(moxels.as_moxel_dag(), Moxels::new(&table).unwrap()).unwrap();
        for voxel in dag.voxels() {
            assert_eq!([ids.id(voxel), blocks.id(voxel), table.id(voxel)], [(voxel.0 % 5) as u16; 3]);
            assert_eq!(table.normal(voxel), None);
            voxels += 1;
        }
    });
    assert!(voxels > 1000, "{voxels} voxels are too few to say anything");
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
        colors: None,
        materials: &[Material::GREY],
        names: &["grey"],
    };
    let words = parts.to_vec().unwrap();
    let top = TopBuf::new(&built.dag.dag(), 3).unwrap();
    let wide = WideBuf::new(&built.dag.dag(), usize::MAX).unwrap();
    let wide_top = TopBuf::new(&wide.as_wide(), 3).unwrap();
    let mut pixels = vec![0; 64 * 48];
    let mut expected = pixels.clone();
    let mut hits = 0;

    assert_no_alloc(|| {
        let scene = file::read(&words).unwrap();
        let camera = Camera::framing(&scene.bounds, scene.up);
        let lights = [Light { shadow: true, ..camera.headlight(scene.bounds.radius()) }];
        let with_top = Tracer::with_top(scene.geometry, top.as_top()).unwrap();
        for (tracer, palette) in [(Tracer::new(scene.geometry), [Material::GREY]), (with_top, [GLASS])] {
            let view = View { tracer, materials: scene.materials, palette: &palette, grid, camera, lights: &lights };
            for normals in [NormalKind::Stored, NormalKind::Plane2] {
                let near = Supersample::near(scene.geometry, &camera, 0.5);
                for supersample in [Supersample::All, near, Supersample::Adaptive { degrees: 2.0 }] {
                    let samples = if supersample == near { Samples::Five } else { Samples::Sixteen };
                    let size = Settings { width: 64, height: 48, ..Settings::default() };
                    let settings = Settings { samples, supersample, normals, ..size };
                    hits += render_rows(&view, &settings, 0..48, &mut expected).unwrap().hits;
                    // Many rays at once draw the same.
                    let packets = Tracer::with_top(wide.as_wide(), wide_top.as_top()).unwrap();
                    for level in Level::all() {
                        let View { materials, palette, grid, camera, lights, .. } = view;
                        let tracer = packets.with_level(Some(level));
                        assert!(tracer.packet_level().is_some());
                        let view = View { tracer, materials, palette, grid, camera, lights };
                        render_rows(&view, &settings, 0..48, &mut pixels).unwrap();
                        assert!(pixels == expected, "other pixels at {}", level.name());
                    }
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

#[test]
fn mirrored_nodes_take_no_heap() {
    let sphere = scenes::sphere([0.0; 3], 1.0, 3);
    let mesh = sphere.mesh();
    let grid = Grid::fit(&mesh.validate().unwrap(), 100).unwrap();
    let built = Build::new(&mesh, &grid, &Options::default()).unwrap().run().unwrap();
    let words = SsvdagBuf::build(&built.dag.dag()).unwrap().into_words();
    let top = TopBuf::new(&Ssvdag::new(&words).unwrap(), 3).unwrap();
    let mut counts = vec![0; Ssvdag::new(&words).unwrap().stored()];
    let mut hits = 0;

    assert_no_alloc(|| {
        let ssvdag = Ssvdag::new(&words).unwrap();
        assert_eq!(ssvdag.stats_into(&mut counts).unwrap().voxels, ssvdag.voxels().count() as u64);
        assert!(ssvdag.empty_level(Morton(0)).is_some());
        let tracer = Tracer::with_top(ssvdag, top.as_top()).unwrap();
        for i in 0..100 {
            let aim = f64::from(i);
            let query = Query::new([-80.0, -60.0, -50.0], [aim + 80.0, aim + 60.0, 110.0 - aim]);
            hits += u32::from(tracer.trace(Arithmetic::Exact, &query).is_some());
            assert_eq!(tracer.occluded(Arithmetic::Exact, &query), tracer.hits(&query).next().is_some());
        }
    });
    assert!(hits > 30, "{hits} hits are too few to say anything");
}
