//! Embree's watertightness test (verify.cpp, WatertightTest) with no failure allowed: rays from inside a closed mesh, near
//! the origin and at (148376, 1234, -223423), to its vertices, to the middles of its edges, along axes and diagonals, and
//! anywhere. A ray that meets nothing has leaked.
//!
//! The textbook in f32 moves rays to the grid in f32, too.

use std::sync::OnceLock;

use voxdag::build::DagBuf;
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::voxelize::Cover;
use voxdag::{Grid, Morton};

use super::{Case, Tally, Unit};
use crate::rng::Rng;
use crate::scenes::{self, Shape};
use crate::subject;
use crate::textbook::esvo_f32;

/// Where Embree puts its meshes.
const FAR: [f64; 3] = [148_376.0, 1234.0, -223_423.0];
/// Rays of a piece.
const RAYS: u64 = 32;

/// A closed mesh in voxels, and the box of points from which rays start.
struct Mesh {
    /// What it is.
    name: String,
    shape: Shape,
    grid: Grid,
    centre: [f64; 3],
    /// Half the side of the box around the centre that is free of the mesh.
    free: f64,
    dag: DagBuf,
    top: TopBuf,
}

/// The kinds of closed meshes.
const KINDS: [&str; 4] = ["globe", "divided box", "bumpy globe", "torus"];

/// The meshes of a kind: three at `centre` in fitted grids, and one in the largest grid there is.
fn meshes(kind: usize, centre: [f64; 3]) -> Vec<Mesh> {
    let make = |divisions: u32, radius: f64, centre: [f64; 3]| {
        let mut rng = Rng::new(u64::from(divisions));
        let corner = |sign: f64| [0, 1, 2].map(|i| centre[i] + sign * radius * [1.0, 0.8, 0.6][i]);
        match kind {
            0 => scenes::globe(centre, radius, divisions, |_| 1.0),
            1 => scenes::divided_box(corner(-1.0), corner(1.0), divisions),
            2 => scenes::globe(centre, radius, divisions, |_| rng.uniform(0.75, 1.0)),
            // Its hole is outside: rays start within the ring.
            _ => scenes::torus(
                [centre[0] - 0.7 * radius, centre[1], centre[2]],
                0.7 * radius,
                0.3 * radius,
                divisions,
                19,
            ),
        }
    };
    let mut all = Vec::new();
    // Bumps make many times the surface.
    let finest = if kind == 2 { 200 } else { 1024 };
    for (divisions, resolution) in [(50, 64), (100, 150), (200, finest)] {
        let shape = make(divisions, 10.0, centre);
        let grid = subject::fitted(&shape, resolution);
        all.push(Mesh::new(kind, divisions, shape, grid, centre, 1.0));
    }
    // At depth 21 in voxel units, near the far corner.
    let centre = [1_483_760.3, 2_096_000.7, 2_000_000.1];
    all.push(Mesh::new(kind, 50, make(50, 150.0, centre), subject::unit_grid(1 << 21), centre, 15.0));
    all
}

impl Mesh {
    fn new(kind: usize, divisions: u32, shape: Shape, grid: Grid, centre: [f64; 3], free: f64) -> Mesh {
        let dag = subject::build(&shape.mesh(), &grid, Cover::Exact).expect("a good mesh in its grid");
        let top = TopBuf::new(&dag.dag(), 4).expect("room for a small grid");
        let name = format!("{} of {divisions} divisions, 2^{}", KINDS[kind], grid.depth());
        Mesh { name, shape, grid, centre, free, dag, top }
    }

    /// A ray from inside, in world coordinates.
    fn draw(&self, rng: &mut Rng) -> ([f64; 3], [f64; 3]) {
        let mut origin = self.centre.map(|c| c + rng.uniform(-self.free, self.free));
        // On planes, edges and corners of voxels, too.
        match rng.below(4) {
            0 => origin = self.grid.to_world(self.grid.to_grid(origin).map(f64::round)),
            1 => origin = self.grid.to_world(self.grid.to_grid(origin).map(|x| x.floor() + 0.5)),
            2 => origin = self.centre,
            _ => {}
        }
        let toward = |p: [f64; 3]| core::array::from_fn(|i| p[i] - origin[i]);
        let [a, b, c] = rng.pick(&self.shape.triangles).map(|v| self.shape.positions[v as usize]);
        let dir = match rng.below(6) {
            0 => toward(a),
            1 => toward(core::array::from_fn(|i| (a[i] + b[i]) / 2.0)),
            2 => {
                let (u, v) = (rng.unit(), rng.unit());
                toward(core::array::from_fn(|i| a[i] + u * (b[i] - a[i]) + (1.0 - u) * v * (c[i] - a[i])))
            }
            // Where snapping put the vertex.
            3 => toward(self.grid.to_world(self.grid.to_grid(a).map(|x| (x * 256.0).round() / 256.0))),
            4 => loop {
                let d = [(); 3].map(|()| rng.between(-1, 1) as f64);
                if d != [0.0; 3] {
                    break d;
                }
            },
            _ => rng.direction(),
        };
        (origin, dir)
    }

    /// Shoots the ray of a seed.
    fn shoot(&self, rng: &mut Rng, tally: &mut Tally) {
        let (origin, dir) = self.draw(rng);
        let query = Query::new(self.grid.to_grid(origin), dir.map(|d| d / self.grid.voxel_size));
        let dag = self.dag.dag();
        let tracer = Tracer::with_top(dag, self.top.as_top()).expect("the grid is this DAG's");
        // The hit lies on the mesh: behind an empty voxel, and no farther than the mesh reaches.
        let met = |hit: Option<voxdag::trace::Hit>| hit.is_some_and(|hit| hit.from.is_some() && hit.t > 0.0);
        let exact = dag.trace(&query);
        let ours = met(exact)
            && tracer.trace(Arithmetic::Exact, &query) == exact
            && dag.occluded(&query)
            && tracer.occluded(Arithmetic::Exact, &query);
        let f64 = met(dag.trace_with(Arithmetic::F64, &query)) && met(tracer.trace(Arithmetic::F64, &query));

        let single = |v: [f64; 3]| v.map(|x| x as f32);
        let (from, corner, size) = (single(origin), single(self.grid.origin), self.grid.voxel_size as f32);
        let from = core::array::from_fn(|i| (from[i] - corner[i]) / size);
        let any = |level: u8, voxel: [u32; 3]| {
            let code = Morton::encode(voxel).expect("the voxel lies in the cube");
            dag.empty_level(code).is_none_or(|empty| empty < level)
        };
        let f32 = esvo_f32(from, single(dir), f32::INFINITY, dag.depth(), any).is_some();
        tally.count(f32, f64, ours, || format!("{}: {query:?}", self.name));
    }
}

pub(super) fn cases() -> Vec<Case> {
    let all = (0..KINDS.len())
        .flat_map(|kind| [("the origin", [0.0; 3]), ("(148376, 1234, -223423)", FAR)].map(|at| (kind, at)));
    all.map(|(kind, (place, centre))| {
        let made = OnceLock::new();
        let ask = move |piece: u64| {
            let meshes = made.get_or_init(|| meshes(kind, centre));
            let mut tally = Tally::default();
            let mut rng = Rng::new(piece << 4 | kind as u64);
            for ray in 0..RAYS {
                meshes[(ray % meshes.len() as u64) as usize].shoot(&mut rng, &mut tally);
            }
            tally
        };
        // A thousand rays in all, a million in all.
        Case::new("leaks", format!("{} at {place}", KINDS[kind]), Unit::Rays, [4, 4000], Box::new(ask))
    })
    .collect()
}
