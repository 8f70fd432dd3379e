//! The core's stages on a small scene of its own: a torus over a bumpy floor, 256^3.
//!
//! `cargo bench -p voxdag` gives times. Each benchmark does [`RAYS`] rays (or what they hit, or all voxels) in one
//! function out of line, `kernel::*`, so that callgrind can count the instructions of nothing but the work; see
//! docs/performance.md for the command.

use std::sync::LazyLock;

use divan::Bencher;
use divan::counter::ItemsCount;
use voxdag::build::DagBuf;
use voxdag::camera::Camera;
use voxdag::materials::{AnyMaterials, Materials, MaterialsBuf};
use voxdag::scene::{Build, Built, MaterialMode, Options};
use voxdag::simd::Level;
use voxdag::ssvdag::SsvdagBuf;
use voxdag::trace::{Arithmetic, Hit, Query, TopBuf, Tracer};
use voxdag::voxelize::{Cover, VoxelizeError, Voxelizer};
use voxdag::wide::WideBuf;
use voxdag::{Geometry, Grid, Mesh, Morton};

fn main() {
    println!("{} rays, {} hits, {} voxels", RAYS, SCENE.hits.len(), SCENE.dag.dag().voxels().count());
    divan::main();
}

/// Width and height of the picture whose rays are traced.
const SIDE: u32 = 64;
const RAYS: u64 = (SIDE * SIDE) as u64;

/// What the benchmarks work on.
struct Scene {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u16>,
    grid: Grid,
    dag: DagBuf,
    table: voxdag::table::TableBuf,
    tree: MaterialsBuf,
    top: TopBuf,
    rays: Vec<Query>,
    hits: Vec<(Hit, [f64; 3])>,
    shadow: Vec<Query>,
    /// Voxels of the whole scene in an order without any.
    scattered: Vec<Morton>,
    bricks: Vec<(Morton, u64)>,
}

impl Scene {
    fn mesh(&self) -> Mesh<'_> {
        Mesh { positions: &self.positions, triangles: &self.triangles, materials: &self.materials, ..Mesh::default() }
    }

    fn tracer(&self) -> Tracer<'_> {
        Tracer::with_top(self.dag.dag(), self.top.as_top()).unwrap()
    }
}

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let (mut positions, mut triangles, mut materials) = (Vec::new(), Vec::new(), Vec::new());
    let mut sheet = |n: u32, material: u16, at: &dyn Fn(f64, f64) -> [f64; 3]| {
        let first = positions.len() as u32;
        let cells = || (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let f = |k: u32| f64::from(k) / f64::from(n);
        positions.extend((0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| at(f(i), f(j))));
        for (i, j) in cells() {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| first + j * (n + 1) + i);
            triangles.extend([[a, b, c], [a, c, d]]);
            materials.extend([material; 2]);
        }
    };
    let turn = |x: f64| libm::sincos(core::f64::consts::TAU * x);
    sheet(96, 0, &|s, t| {
        let ((sin, cos), (up, out)) = (turn(s), turn(t));
        let r = 3.0 + 1.2 * out;
        [r * cos, 1.2 * up + 0.4 * sin, r * sin]
    });
    sheet(64, 1, &|s, t| [10.0 * s - 5.0, -2.0 + 0.3 * turn(2.0 * s).0 * turn(3.0 * t).1, 10.0 * t - 5.0]);

    let mesh = Mesh { positions: &positions, triangles: &triangles, materials: &materials, ..Mesh::default() };
    let bounds = mesh.validate().unwrap();
    let grid = Grid::fit(&bounds, 256).unwrap();
    let built = |materials| {
        let options = Options { materials, ..Options::default() };
        Build::new(&mesh, &grid, &options).unwrap().run().unwrap()
    };
    let (dag, table) = match built(MaterialMode::Table) {
        Built { dag, materials: MaterialsBuf::Table(table), .. } => (dag, table),
        _ => panic!("a table was asked for"),
    };
    let tree = built(MaterialMode::Tree).materials;
    let top = TopBuf::new(&dag.dag(), 6).unwrap();

    let camera = Camera::framing(&bounds, voxdag::grid::UpAxis::Y);
    let (view, eye) = (camera.rays(SIDE, SIDE).unwrap(), grid.to_grid(camera.eye));
    let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| [x, y].map(|k| f64::from(k) + 0.5)));
    let rays: Vec<_> = pixels.map(|[x, y]| Query::new(eye, view.direction(x, y))).collect();
    let hits: Vec<_> = rays.iter().filter_map(|q| Some((dag.dag().trace(q)?, q.dir))).collect();
    let light = grid.to_grid([6.0, 20.0, 8.0]);
    let shadow = hits.iter().map(|(hit, _)| {
        let origin = hit.from.unwrap_or(hit.voxel).decode().map(|k| f64::from(k) + 0.5);
        let dir = std::array::from_fn(|i| light[i] - origin[i]);
        Query { start: hit.from, t_max: 1.0, ..Query::new(origin, dir) }
    });
    let shadow = shadow.collect();
    let mut scattered: Vec<_> = dag.dag().voxels().step_by(7).collect();
    scattered.sort_by_key(|v| v.0.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    scattered.truncate(RAYS as usize);
    let bricks = dag.dag().bricks().collect();
    Scene { grid, dag, table, tree, top, rays, hits, shadow, scattered, bricks, positions, triangles, materials }
});

/// The work itself; each function gives a checksum.
mod kernel {
    use super::*;
    use voxdag::materials::Single;
    use voxdag::normal::{NormalKind, normal};

    #[inline(never)]
    pub fn trace<G: Geometry>(tracer: &Tracer<'_, G>, arithmetic: Arithmetic, rays: &[Query]) -> u64 {
        rays.iter().map(|q| tracer.trace(arithmetic, q).map_or(1, |hit| hit.voxel.0)).fold(0, u64::wrapping_add)
    }

    #[inline(never)]
    pub fn trace_many<G: Geometry>(tracer: &Tracer<'_, G>, rays: &[Query], len: usize) -> u64 {
        let (mut hits, mut sum) = (vec![None; len], 0u64);
        for rays in rays.chunks(len) {
            tracer.trace_many(Arithmetic::Exact, rays, &mut hits);
            sum = hits[..rays.len()].iter().map(|hit| hit.map_or(1, |hit| hit.voxel.0)).fold(sum, u64::wrapping_add);
        }
        sum
    }

    #[inline(never)]
    pub fn occluded(tracer: &Tracer<'_>, rays: &[Query]) -> u64 {
        rays.iter().map(|q| u64::from(tracer.occluded(Arithmetic::Exact, q))).sum()
    }

    #[inline(never)]
    pub fn normals(tracer: &Tracer<'_>, kind: NormalKind, hits: &[(Hit, [f64; 3])]) -> u64 {
        hits.iter().map(|(hit, dir)| u64::from(normal(tracer, Single(0), hit, *dir, kind).direction[1].to_bits())).sum()
    }

    #[inline(never)]
    pub fn look_up<M: Materials>(materials: M, voxels: &[Morton]) -> u64 {
        voxels.iter().map(|v| u64::from(materials.id(*v))).sum()
    }

    #[inline(never)]
    pub fn voxelize(voxelizer: &Voxelizer<'_>) -> u64 {
        let mut sum = 0;
        for subtree in 0..voxelizer.subtrees() {
            let count = voxelizer.voxelize::<VoxelizeError>(subtree, |brick| {
                sum += u64::from(brick.mask.count_ones());
                Ok(())
            });
            count.unwrap();
        }
        sum
    }

    #[inline(never)]
    pub fn reduce(depth: u8, bricks: &[(Morton, u64)]) -> DagBuf {
        let mut builder = voxdag::build::DagBuilder::new(depth).unwrap();
        bricks.iter().for_each(|&(code, mask)| builder.push(code, mask).unwrap());
        builder.finish().unwrap()
    }

    #[inline(never)]
    pub fn build(mesh: &Mesh<'_>, grid: &Grid, materials: MaterialMode) -> DagBuf {
        let options = Options { materials, ..Options::default() };
        Build::new(mesh, grid, &options).unwrap().run().unwrap().dag
    }
}

#[divan::bench(args = [Arithmetic::Exact, Arithmetic::F64])]
fn primary(bencher: Bencher<'_, '_>, arithmetic: Arithmetic) {
    let (tracer, rays) = (SCENE.tracer(), &SCENE.rays);
    bencher.counter(ItemsCount::new(rays.len())).bench(|| kernel::trace(&tracer, arithmetic, rays));
}

/// The same rays by a wide tree, and vectors with `--features std`, in lists of so many; 0: one by one.
#[divan::bench(args = [0, 1, 4, 8, 15, 16, 64, 1024])]
fn primary_in_lists(bencher: Bencher<'_, '_>, len: usize) {
    let wide = WideBuf::new(&SCENE.dag.dag(), usize::MAX).unwrap();
    let top = TopBuf::new(&wide.as_wide(), 4).unwrap();
    let tracer = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap().with_level(Level::best());
    let rays = &SCENE.rays;
    bencher.counter(ItemsCount::new(rays.len())).bench(|| match len {
        0 => kernel::trace(&tracer, Arithmetic::Exact, rays),
        _ => kernel::trace_many(&tracer, rays, len),
    });
}

#[divan::bench]
fn primary_without_top(bencher: Bencher<'_, '_>) {
    let (tracer, rays) = (Tracer::new(SCENE.dag.dag()), &SCENE.rays);
    bencher.counter(ItemsCount::new(rays.len())).bench(|| kernel::trace(&tracer, Arithmetic::Exact, rays));
}

#[divan::bench]
fn primary_ssvdag(bencher: Bencher<'_, '_>) {
    let built = SsvdagBuf::build(&SCENE.dag.dag()).unwrap();
    let top = TopBuf::new(&built.ssvdag(), 6).unwrap();
    let (tracer, rays) = (Tracer::with_top(built.ssvdag(), top.as_top()).unwrap(), &SCENE.rays);
    bencher.counter(ItemsCount::new(rays.len())).bench(|| kernel::trace(&tracer, Arithmetic::Exact, rays));
}

#[divan::bench]
fn merge_mirrors(bencher: Bencher<'_, '_>) {
    bencher.counter(voxels()).bench(|| SsvdagBuf::build(&SCENE.dag.dag()));
}

#[divan::bench]
fn shadow(bencher: Bencher<'_, '_>) {
    let (tracer, rays) = (SCENE.tracer(), &SCENE.shadow);
    bencher.counter(ItemsCount::new(rays.len())).bench(|| kernel::occluded(&tracer, rays));
}

#[divan::bench(args = NORMALS)]
fn normals(bencher: Bencher<'_, '_>, kind: voxdag::normal::NormalKind) {
    let (tracer, hits) = (SCENE.tracer(), &SCENE.hits);
    bencher.counter(ItemsCount::new(hits.len())).bench(|| kernel::normals(&tracer, kind, hits));
}

const NORMALS: [voxdag::normal::NormalKind; 5] = {
    use voxdag::normal::NormalKind::*;
    [Face, Gradient, Plane1, Plane2, Plane3]
};

#[divan::bench]
fn look_up(bencher: Bencher<'_, '_>) {
    let (table, voxels) = (SCENE.table.as_table(), &SCENE.scattered);
    bencher.counter(ItemsCount::new(voxels.len())).bench(|| kernel::look_up(table, voxels));
}

#[divan::bench]
fn look_up_tree(bencher: Bencher<'_, '_>) {
    let voxels = &SCENE.scattered;
    let AnyMaterials::Tree(tree) = SCENE.tree.as_materials(None).unwrap() else { panic!("a tree was asked for") };
    bencher.counter(ItemsCount::new(voxels.len())).bench(|| kernel::look_up(tree, voxels));
}

/// Voxels of the scene.
fn voxels() -> ItemsCount {
    ItemsCount::new(SCENE.dag.dag().voxels().count())
}

#[divan::bench]
fn voxelize(bencher: Bencher<'_, '_>) {
    let voxelizer = Voxelizer::new(&SCENE.mesh(), &SCENE.grid, Cover::Exact).unwrap();
    bencher.counter(voxels()).bench(|| kernel::voxelize(&voxelizer));
}

#[divan::bench]
fn reduce(bencher: Bencher<'_, '_>) {
    let depth = SCENE.grid.depth();
    bencher.counter(voxels()).bench(|| kernel::reduce(depth, &SCENE.bricks));
}

#[divan::bench(args = [MaterialMode::None, MaterialMode::Tree, MaterialMode::Table])]
fn build(bencher: Bencher<'_, '_>, materials: MaterialMode) {
    let (mesh, grid) = (SCENE.mesh(), SCENE.grid);
    bencher.counter(voxels()).bench(|| kernel::build(&mesh, &grid, materials));
}

#[divan::bench]
fn top_grid(bencher: Bencher<'_, '_>) {
    bencher.bench(|| TopBuf::new(&SCENE.dag.dag(), 6));
}
