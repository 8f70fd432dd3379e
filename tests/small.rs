//! Every stage against its oracle at a size that an interpreter can do: these are the tests that Miri runs, also for a
//! machine with 32-bit words and for one that stores the high byte first (`./ci.sh miri`).

use std::collections::BTreeMap;

use voxdag::Geometry;
use voxdag::dag::BRICK_LEVEL;
use voxdag::file::{self, Parts};
use voxdag::grid::UpAxis;
use voxdag::materials::{AnyMaterials, MaterialsBuf};
use voxdag::normal::{Confidence, NormalKind, normal};
use voxdag::scene::{Build, MaterialMode, Options};
use voxdag::table::{Entry, TableBuf};
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::voxelize::Cover;
use voxdag::{Dag, Grid, Material, Materials, Mesh, Morton};
use voxdag_oracle::ray::{self, Ray};
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::{self, Implicit};
use voxdag_oracle::{laws, octree, subject};

#[test]
fn covers() {
    // The rational oracle is slow: one triangle in 2^3 voxels.
    let shape = scenes::soup(3, 1, 2, 1.0);
    for cover in [Cover::Exact, Cover::Inflated, Cover::Thin] {
        let grid = subject::unit_grid(2);
        let truth = subject::true_cover(&shape, &grid, cover);
        assert!(!truth.is_empty());
        assert_eq!(subject::cover(&shape, &grid, cover), truth, "{cover:?}");
    }
}

#[test]
fn builders() {
    for seed in 0..2 {
        let mut rng = Rng::new(seed);
        let data: Vec<u8> = (0..15).map(|_| rng.bits() as u8).collect();
        laws::dag_builder(&data);
    }
}

#[test]
fn mirrors() {
    for seed in 0..2 {
        let mut rng = Rng::new(seed);
        let data: Vec<u8> = [3, 0, 0].into_iter().chain((0..12).map(|_| rng.bits() as u8 & !3)).collect();
        laws::ssvdag(&data);
    }
}

#[test]
fn rays() {
    for (depth, shape) in [
        (3, Implicit::Diagonal { lo: 8, hi: 10 }),
        (21, Implicit::Wall { axis: 1, lo: 700_000, hi: 700_001 }),
        (21, Implicit::Diagonal { lo: (1 << 21) + 1, hi: (1 << 21) + 2 }),
    ] {
        let words = shape.words(depth);
        let dag = Dag::new(&words).unwrap();
        let top = TopBuf::new(&dag, 1).unwrap();
        let (mut rng, n) = (Rng::new(u64::from(depth)), f64::from(1u32 << depth));
        let mut hits = 0;
        for k in 0..4 {
            let mut origin = [(); 3].map(|()| rng.uniform(0.0, n).floor());
            // Half of them run through edges and corners, the others anywhere; one of each along an axis.
            let mut dir = [(); 3].map(|()| if rng.below(2) == 0 { 1.0 } else { -1.0 });
            if k % 2 == 0 {
                (origin, dir) = (origin.map(|x| x + rng.unit()), rng.direction());
            }
            if k > 2 {
                (dir[0], dir[2]) = (0.0, -0.0);
            }
            // Far from the origin the oracle has too many voxels to look at.
            let ray = Ray { t_max: 30.0, ..Ray::new(origin, dir) };
            let query = Query { t_max: ray.t_max, ..Query::new(origin, dir) };
            let truth = ray::first(&ray, depth, 0, &|level, corner| shape.any(level, corner));
            for tracer in [Tracer::new(dag), Tracer::with_top(dag, top.as_top()).unwrap()] {
                let found = tracer.trace(Arithmetic::Exact, &query);
                let voxels = (found.map(|hit| hit.voxel.decode()), truth.as_ref().map(|truth| truth.voxel));
                assert_eq!(voxels.0, voxels.1, "depth {depth}, {ray:?}");
                assert_eq!(found.map(|hit| hit.face), truth.as_ref().map(|truth| truth.face), "depth {depth}, {ray:?}");
            }
            hits += usize::from(truth.is_some());
        }
        assert!(depth == 21 || hits > 1, "{hits} hits at depth {depth}");
    }
}

#[test]
fn tables() {
    for normals in [false, true] {
        let mut rng = Rng::new(7);
        let mut twin = BTreeMap::new();
        for _ in 0..30 {
            twin.insert(
                rng.bits() >> 1,
                Entry { material: rng.bits() as u16, normal: normals.then_some([0.0, 0.0, 1.0]) },
            );
        }
        let mut table = TableBuf::new(twin.len() as u64, normals).unwrap();
        table.insert_all(twin.iter().map(|(&key, &entry)| (Morton(key), entry))).unwrap();
        for &key in twin.keys() {
            assert_eq!(table.as_table().get(Morton(key)), twin.get(&key).copied());
            assert_eq!(table.as_table().get(Morton(key ^ 1)), twin.get(&(key ^ 1)).copied());
        }
    }
}

#[test]
fn materials() {
    // Two cubes and a row of different materials in 8^3 voxels; and one changed word of each kind.
    let cubes = [[1, 0, 0, 0, 5, 0], [1, 4, 4, 0, 6, 0], [32 | 1, 2, 5, 3, 255, 0]];
    laws::materials(
        &[&[3, 3, 0, 4, 0, 1, 0, 0, 0, 1, 5, 0, 2, 0, 0, 0, 2, 4, 0, 0, 0, 1, 0], cubes.as_flattened()].concat(),
    );
}

#[test]
fn ranks() {
    // One cube that holds itself in six of its octants, of depth 21, and one of depth 4.
    for depth in [21, 4] {
        laws::ranks(
            &[&[depth, 0, 0, 0xb7, 0, 0, 0, 0][..], &[0xc3, 0x35, 7, 0x5a, 0xa5, 0x11, 9, 0x20].repeat(4)].concat(),
        );
    }
}

#[test]
fn normals() {
    // A floor of two layers: every fitted normal is up, whatever the words' order in memory.
    let words = Implicit::Wall { axis: 1, lo: 5, hi: 7 }.words(4);
    let dag = Dag::new(&words).unwrap();
    assert_eq!(BRICK_LEVEL, 2);
    let query = Query::new([8.3, 15.0, 7.6], [0.1, -1.0, 0.05]);
    let hit = dag.trace(&query).unwrap();
    for kind in [NormalKind::Gradient, NormalKind::Plane1, NormalKind::Plane2, NormalKind::Plane3] {
        let found = normal(&Tracer::new(dag), voxdag::materials::Single(0), &hit, query.dir, kind);
        assert_eq!(found.direction, [0.0, 1.0, 0.0], "{kind:?}");
        assert_eq!(matches!(found.confidence, Confidence::Gradient), kind == NormalKind::Gradient);
    }
}

/// From a mesh to bytes and back: the bytes are little-endian on every machine, and the scene in them is the one that was
/// written.
#[test]
fn files() {
    let fixture = include_bytes!("fixtures/v1.vxd");
    let words = file::words_from_bytes(fixture).unwrap();
    assert_eq!(words[0].to_le_bytes(), *b"VXD\x1a");
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    assert_eq!(bytes, fixture);
    let scene = file::read(&words).unwrap();
    assert_eq!((scene.grid.origin, scene.grid.voxel_size), ([-1.0, 0.0, 2.5], 0.5));
    assert_eq!(scene.name(1).to_string(), "w\u{00e4}nde");

    let positions = [[0.25, 0.5, 0.0], [3.5, 0.5, 0.25], [1.0, 3.75, 3.0]];
    let mesh = Mesh { positions: &positions, triangles: &[[0, 1, 2]], ..Mesh::default() };
    let bounds = mesh.validate().unwrap();
    let grid = Grid::fit(&bounds, 6).unwrap();
    let options = Options { materials: MaterialMode::TableNormals, ..Options::default() };
    let built = Build::new(&mesh, &grid, &options).unwrap().run().unwrap();
    let MaterialsBuf::Table(table) = &built.materials else { panic!("a table was asked for") };
    let words = Parts {
        grid,
        bounds,
        up: UpAxis::Z,
        metres_per_unit: 0.0,
        geometry: built.dag.dag().into(),
        voxel_materials: AnyMaterials::Table(table.as_table()),
        colors: None,
        materials: &[Material::GREY],
        names: &["grey"],
    }
    .to_vec()
    .unwrap();
    let scene = file::read(&words).unwrap();
    assert_eq!(scene.geometry.words(), built.dag.words());
    let voxels: Vec<Morton> = scene.geometry.voxels().collect();
    assert_eq!(octree::count_voxels(scene.geometry.words()), voxels.len().into());
    for &voxel in &voxels {
        let normal = scene.materials.normal(voxel).unwrap();
        let length: f32 = normal.iter().map(|x| x * x).sum();
        assert!((length - 1.0).abs() < 1e-6, "{normal:?}");
    }
    // Any one bit is missed by no checksum.
    for at in [0, 40, words.len() / 2, words.len() - 1] {
        let mut damaged = words.clone();
        damaged[at] ^= 1 << (at % 32);
        assert!(file::read(&damaged).is_err(), "word {at}");
    }
}
