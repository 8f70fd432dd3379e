//! Metamorphic laws: what is turned, mirrored, cut apart or built in another order gives the same, turned and mirrored.
//!
//! The 48 symmetries of the cube, for voxels, hits and normals of every kind. Half-open voxels `[k, k + 1)` become
//! `(k, k + 1]` in a mirror: permutations of the axes are exact for all input, mirrors where nothing lies in a plane
//! between voxels, and for the inflated cover, whose voxels are closed, always. The other laws stand with their rows:
//! vertex rotation and triangle shuffle (v12), translation (v17), scaling (v09), directions (r09), threads (cli/tests).

use std::collections::BTreeSet;

use voxdag::materials::{AnyMaterials, MaterialsBuf};
use voxdag::normal::{Confidence, NormalKind, normal};
use voxdag::scene::{Build, Built, MaterialMode, Options};
use voxdag::trace::{Arithmetic, Hit, Query, TopBuf, Tracer};
use voxdag::voxelize::Cover;
use voxdag::{Dag, Grid, Materials, Mesh, Morton};
use voxdag_oracle::clip::{self, Aabb, Cell};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::{self, Shape};
use voxdag_oracle::subject::{self, unit_grid};

/// A symmetry of the cube `[0, n]^3`: axis i of the image is axis `order[i]`, from the other end if `flip[i]`.
#[derive(Clone, Copy, Debug)]
struct Symmetry {
    order: [usize; 3],
    flip: [bool; 3],
    n: u32,
}

impl Symmetry {
    fn all(n: u32) -> impl Iterator<Item = Symmetry> {
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        (0..48).map(move |i| Symmetry { order: ORDERS[i / 8], flip: [1, 2, 4].map(|bit| i & bit != 0), n })
    }

    fn mirrors(&self) -> bool {
        self.flip != [false; 3]
    }

    fn point(&self, p: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| if self.flip[i] { f64::from(self.n) - p[self.order[i]] } else { p[self.order[i]] })
    }

    fn vector(&self, v: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| if self.flip[i] { 0.0 - v[self.order[i]] } else { v[self.order[i]] })
    }

    fn voxel(&self, v: [u32; 3]) -> [u32; 3] {
        core::array::from_fn(|i| if self.flip[i] { self.n - 1 - v[self.order[i]] } else { v[self.order[i]] })
    }

    fn code(&self, voxel: Morton) -> Morton {
        Morton::encode(self.voxel(voxel.decode())).unwrap()
    }
}

/// Vertices on 1/256 voxel, so that snapping, which rounds half to even, has nothing to do.
fn snapped(shape: &Shape) -> Shape {
    shape.map(|p| p.map(|x| (x * 256.0).round() / 256.0))
}

/// Whether no triangle touches a voxel without going into it by 1/2^18 voxel: then it does not matter which ends are open.
fn without_ties(shape: &Shape, depth: u8) -> bool {
    const FINER: i64 = 1024;
    shape.snapped([0.0; 3], 1.0, 1 << depth).iter().all(|triangle| {
        let fine = triangle.map(|p| p.map(|x| x * FINER));
        clip::cover(&[*triangle], depth, Cell::Closed).iter().all(|voxel| {
            let lo = voxel.map(|k| i64::from(k) * clip::SUB * FINER + 1);
            let hi = voxel.map(|k| (i64::from(k) + 1) * clip::SUB * FINER - 1);
            clip::meets(&fine, &Aabb { lo, hi, open: [false; 3] })
        })
    })
}

#[test]
fn voxels_follow_the_48_symmetries() {
    let (mut tied, mut free) = (0, 0);
    for seed in 0..120 {
        // In a cube of side 16, two voxels from its border, then somewhere in cubes of any depth.
        let shape = snapped(&scenes::soup(seed, 2, 12, 3.0).map(|p| p.map(|x| x + 2.0)));
        // A third of the soup's coordinates lies in planes between voxels; for some seeds, none.
        let shape = if seed % 2 == 0 { shape.map(|p| p.map(|x| x + 3.0 / 256.0)) } else { shape };
        let ties = !without_ties(&shape, 4);
        *if ties { &mut tied } else { &mut free } += 1;
        for depth in [4u32, 10, 16, 21] {
            let n = 1u32 << depth;
            let mut rng = Rng::new(seed);
            let by = [(); 3].map(|()| rng.below(u64::from(n) - 15) as f64);
            let shape = shape.map(|p| core::array::from_fn(|i| p[i] + by[i]));
            for cover in [Cover::Exact, Cover::Thin, Cover::Inflated] {
                let plain = subject::cover(&shape, &unit_grid(n), cover);
                for symmetry in Symmetry::all(n) {
                    if ties && symmetry.mirrors() && cover != Cover::Inflated {
                        continue;
                    }
                    let image = subject::cover(&shape.map(|p| symmetry.point(p)), &unit_grid(n), cover);
                    let expected: BTreeSet<_> = plain.iter().map(|v| symmetry.voxel(*v)).collect();
                    assert_eq!(image, expected, "seed {seed}, depth {depth}, {cover:?}, {symmetry:?}");
                }
            }
        }
    }
    assert!(tied > 30 && free > 30, "{tied} shapes with ties and {free} without");
}

#[test]
fn hits_follow_the_48_symmetries() {
    // Mirrored numbers are exact: origins are multiples of 2^-20, and so is the side of the cube less them.
    let fine = |x: f64| (x * f64::from(1 << 20)).round() / f64::from(1 << 20);
    let mut hits = 0;
    for seed in 0..120 {
        let mut rng = Rng::new(seed);
        let depth = [4, 10, 16, 21][seed as usize % 4];
        let n = 1u32 << depth;
        let first = [(); 3].map(|()| rng.below(u64::from(n) - 15) as u32);
        let within = |rng: &mut Rng| core::array::from_fn(|i| first[i] + rng.below(16) as u32);
        let voxels: Vec<[u32; 3]> = (0..80).map(|_| within(&mut rng)).collect();
        let rays: Vec<([f64; 3], [f64; 3])> = (0..8)
            .map(|_| {
                let origin = core::array::from_fn(|i| fine(f64::from(first[i]) + rng.uniform(-12.0, 28.0)));
                let at = rng.pick(&voxels).map(|k| f64::from(k) + rng.uniform(0.1, 0.9));
                (origin, core::array::from_fn(|i| at[i] - origin[i]))
            })
            .collect();
        let ask = |symmetry: Option<Symmetry>| -> Vec<Option<Hit>> {
            let voxels = voxels.iter().map(|v| symmetry.map_or(*v, |s| s.voxel(*v)));
            let words = VoxelSet::new(voxels).words(depth);
            let dag = Dag::new(&words).unwrap();
            let top = TopBuf::new(&dag, 3).unwrap();
            let tracer = Tracer::with_top(dag, top.as_top()).unwrap();
            let one = |&(origin, dir): &([f64; 3], [f64; 3])| {
                let query = match symmetry {
                    None => Query::new(origin, dir),
                    Some(s) => Query::new(s.point(origin), s.vector(dir)),
                };
                let hit = tracer.trace(Arithmetic::Exact, &query);
                assert_eq!(hit, dag.trace(&query));
                hit
            };
            rays.iter().map(one).collect()
        };
        let plain = ask(None);
        hits += plain.iter().flatten().count();
        for symmetry in Symmetry::all(n) {
            for (hit, image) in plain.iter().zip(ask(Some(symmetry))) {
                let Some(hit) = hit else {
                    assert_eq!(image, None, "seed {seed}, {symmetry:?}");
                    continue;
                };
                let image = image.unwrap_or_else(|| panic!("seed {seed}, {symmetry:?}: {hit:?} is lost"));
                // The same time, to the bit.
                let expected = Hit {
                    voxel: symmetry.code(hit.voxel),
                    from: hit.from.map(|v| symmetry.code(v)),
                    face: image.face,
                    ..*hit
                };
                assert_eq!(image, expected, "seed {seed}, {symmetry:?}");
                let face = symmetry.vector(hit.face.normal().map(f64::from));
                assert_eq!(image.face.normal().map(f64::from), face, "seed {seed}, {symmetry:?}");
            }
        }
    }
    assert!(hits > 900, "{hits} hits are too few to say anything");
}

/// A scene with stored normals and two materials.
fn build(shape: &Shape, grid: &Grid) -> Built {
    let materials: Vec<u16> = (0..shape.triangles.len() as u16).map(|i| i % 2).collect();
    let mesh = Mesh { materials: &materials, ..shape.mesh() };
    let options = Options { materials: MaterialMode::TableNormals, ..Options::default() };
    Build::new(&mesh, grid, &options).unwrap().run().unwrap()
}

#[test]
fn normals_of_every_kind_follow_the_48_symmetries() {
    const KINDS: [NormalKind; 6] = [
        NormalKind::Face,
        NormalKind::Stored,
        NormalKind::Gradient,
        NormalKind::Plane1,
        NormalKind::Plane2,
        NormalKind::Plane3,
    ];
    let mut branches = std::collections::HashSet::new();
    for (seed, depth) in [(1, 5u32), (2, 10), (3, 21)] {
        let n = 1u32 << depth;
        let mut rng = Rng::new(seed);
        // No two triangles alike, so that every voxel has one owner, whichever way it is turned.
        let middle = [(); 3].map(|()| 12.0 + (rng.below(u64::from(n) - 23) as f64) + rng.unit());
        let mut bumps = rng.clone();
        let shape = snapped(&scenes::globe(middle, 9.7, 7, |_| bumps.uniform(0.7, 1.0)));
        let rays: Vec<([f64; 3], [f64; 3])> = (0..150)
            .map(|_| {
                let d = rng.direction();
                let origin = core::array::from_fn(|i| middle[i] - 30.0 * d[i]);
                (origin, core::array::from_fn(|i| middle[i] + rng.uniform(-7.0, 7.0) - origin[i]))
            })
            .collect();
        let plain = build(&shape, &unit_grid(n));
        let AnyMaterials::Table(plain_table) = plain.materials.as_materials(None).unwrap() else { panic!("no table") };
        for symmetry in Symmetry::all(n) {
            let image = build(&shape.map(|p| symmetry.point(p)), &unit_grid(n));
            let AnyMaterials::Table(image_table) = image.materials.as_materials(None).unwrap() else {
                panic!("no table")
            };
            assert_eq!(image_table.len(), plain_table.len(), "seed {seed}: a tie");
            for &(origin, dir) in &rays {
                let hit = plain.dag.dag().trace(&Query::new(origin, dir));
                let there = image.dag.dag().trace(&Query::new(symmetry.point(origin), symmetry.vector(dir)));
                let (Some(hit), Some(there)) = (hit, there) else {
                    assert!(hit.is_none() && there.is_none(), "seed {seed}, {symmetry:?}");
                    continue;
                };
                assert_eq!(there.voxel, symmetry.code(hit.voxel), "seed {seed}, {symmetry:?}");
                assert_eq!(image_table.id(there.voxel), plain_table.id(hit.voxel), "owner: seed {seed}, {symmetry:?}");
                for kind in KINDS {
                    let a = normal(&Tracer::new(plain.dag.dag()), plain_table, &hit, dir, kind);
                    let b = normal(&Tracer::new(image.dag.dag()), image_table, &there, symmetry.vector(dir), kind);
                    branches.insert(std::mem::discriminant(&a.confidence));
                    let context = format!("seed {seed}, {symmetry:?}, {kind:?}: {a:?} became {b:?}");
                    assert_eq!(
                        std::mem::discriminant(&a.confidence),
                        std::mem::discriminant(&b.confidence),
                        "{context}"
                    );
                    // Stored normals are rounded to steps on an octahedron unfolded along z: 7e-5 each.
                    let tolerance = if a.confidence == Confidence::Stored { 2e-4 } else { 1e-6 };
                    let expected = symmetry.vector(a.direction.map(f64::from));
                    let off = (0..3).map(|i| (f64::from(b.direction[i]) - expected[i]).abs()).fold(0.0, f64::max);
                    assert!(off <= tolerance, "{context}: off by {off}");
                }
            }
        }
    }
    assert!(branches.len() >= 4, "faces, stored normals, gradients and planes");
}

#[test]
fn any_order_and_scale_of_the_mesh_gives_the_same_materials() {
    // The words of the DAG, and of the table with materials and normals or of the tree. The soup's triangles overlap, so that many voxels
    // have several candidates for their owner, some of them equally near.
    for (depth, seed) in [(3u32, 1), (6, 2), (10, 3), (16, 4), (21, 5)] {
        let n = 1u32 << depth;
        let side = n.min(64);
        let mut shape = scenes::soup(seed, 60, side, 3.0);
        shape.add(&scenes::degenerate_fan(seed, 5, side));
        // The same triangles again, in another material.
        let twins: Vec<_> = shape.triangles.iter().step_by(3).copied().collect();
        shape.triangles.extend(twins);
        let shape = shape.map(|p| p.map(|x| x + f64::from(n - side)));
        let materials: Vec<u16> = (0..shape.triangles.len() as u16).map(|i| i * 7 % 5).collect();
        let words = |triangles: &[[u32; 3]], materials: &[u16], exponent: i32| {
            let positions: Vec<[f64; 3]> =
                shape.positions.iter().map(|p| p.map(|x| libm::scalbn(x, exponent))).collect();
            let mesh = Mesh { positions: &positions, triangles, materials, ..Mesh::default() };
            let grid = Grid { origin: [0.0; 3], voxel_size: libm::scalbn(1.0, exponent), resolution: n };
            [MaterialMode::TableNormals, MaterialMode::Tree].map(|mode| {
                let options = Options { materials: mode, ..Options::default() };
                let built = Build::new(&mesh, &grid, &options).unwrap().run().unwrap();
                (built.dag.words().to_vec(), built.materials.as_materials(None).unwrap().words().to_vec())
            })
        };
        let expected = words(&shape.triangles, &materials, 0);
        for exponent in [-120, -1, 1, 100] {
            assert!(words(&shape.triangles, &materials, exponent) == expected, "depth {depth}, by 2^{exponent}");
        }
        for seed in 0..6 {
            let mut rng = Rng::new(seed);
            let mut both: Vec<_> = shape.triangles.iter().copied().zip(materials.iter().copied()).collect();
            // Corners rotated, then triangles shuffled, too, then corners in any order.
            match seed {
                0 | 1 => both.iter_mut().for_each(|t| t.0.rotate_left(1 + seed as usize)),
                2 | 3 => rng.shuffle(&mut both),
                _ => {
                    rng.shuffle(&mut both);
                    both.iter_mut().for_each(|t| rng.shuffle(&mut t.0));
                }
            }
            let (triangles, materials): (Vec<_>, Vec<_>) = both.into_iter().unzip();
            assert!(words(&triangles, &materials, 0) == expected, "depth {depth}, order {seed}");
        }
    }
}

#[test]
fn parts_built_in_any_order_join_to_the_same_bytes() {
    for (depth, size) in [(3u32, 8.0), (10, 400.0), (16, 60.0), (21, 60.0)] {
        let n = 1u32 << depth;
        let at = f64::from(n) / 2.0;
        let mut shape = scenes::globe([at; 3], 0.49 * size, 11, |i| 1.0 - 0.1 * (i % 4) as f64);
        shape.add(&scenes::slivers(1, 3, size, 0.1).map(|p| p.map(|x| x + at - size / 2.0)));
        let materials: Vec<u16> = (0..shape.triangles.len() as u16).map(|i| i % 7).collect();
        let mesh = Mesh { materials: &materials, ..shape.mesh() };
        for mode in [MaterialMode::None, MaterialMode::Tree, MaterialMode::Table, MaterialMode::TableNormals] {
            let options = Options { materials: mode, ..Options::default() };
            let build = Build::new(&mesh, &unit_grid(n), &options).unwrap();
            let whole = build.run().unwrap();
            for seed in 0..3 {
                let mut order: Vec<usize> = (0..build.parts()).collect();
                Rng::new(seed).shuffle(&mut order);
                let mut parts: Vec<_> = order.iter().map(|&part| (part, build.part(part).unwrap())).collect();
                parts.sort_by_key(|part| part.0);
                let mut join = build.join().unwrap();
                parts.into_iter().for_each(|(_, part)| join.add(part).unwrap());
                let (dag, owners) = join.finish().unwrap();
                assert!(dag == whole.dag, "2^{depth}, {mode:?}, seed {seed}");
                let materials = owners.materials(&dag.dag(), mode).unwrap();
                let words = |materials: &MaterialsBuf| materials.as_materials(None).unwrap().words().to_vec();
                assert!(words(&materials) == words(&whole.materials), "2^{depth}, {mode:?}, seed {seed}");
            }
        }
    }
}
