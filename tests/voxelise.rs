//! The voxeliser against the clipping oracle, row by row of the catalogue (hard-cases, section 3).
//!
//! Rows whose meshes are small are tried in the far corner of cubes of depth 3, 10, 16 and 21. The symmetries of the cube
//! have a file of their own (tests/symmetry.rs).

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use voxdag::grid::{Bounds, GridError};
use voxdag::mesh::MeshError;
use voxdag::voxelize::{Cover, Owner, VoxelizeError, Voxelizer};
use voxdag::{Grid, Mesh, Morton};
use voxdag_oracle::clip::{self, Aabb, Cell};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::{self, Shape};
use voxdag_oracle::subject::{self, Refused, build, build_apart, fitted, true_cover, unit_grid};

const COVERS: [Cover; 3] = [Cover::Exact, Cover::Thin, Cover::Inflated];

/// A shape of the triangles with these corners.
fn of(triangles: &[[[f64; 3]; 3]]) -> Shape {
    Shape {
        positions: triangles.concat(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    }
}

/// The core and the oracle mark the same voxels, in every cover.
fn check(shape: &Shape, grid: &Grid, what: &str) {
    for cover in COVERS {
        let (found, truth) = (subject::cover(shape, grid, cover), true_cover(shape, grid, cover));
        let missing: Vec<_> = truth.difference(&found).take(3).collect();
        let extra: Vec<_> = found.difference(&truth).take(3).collect();
        assert!(
            missing.is_empty() && extra.is_empty(),
            "{what}, {cover:?}: missing {missing:?}, extra {extra:?} (first three)"
        );
    }
}

/// The core and the oracle agree in the cube of 2 * `reach` voxels around a point (a voxel), where the whole is too large.
fn check_window(shape: &Shape, built: &voxdag::build::DagBuf, grid: &Grid, around: [i64; 3], reach: i64, what: &str) {
    let n = i64::from(grid.resolution);
    let lo = around.map(|k| (k - reach).max(0));
    let hi = around.map(|k| (k + reach).min(n));
    let triangles = shape.snapped(grid.origin, grid.voxel_size, grid.resolution);
    let truth = clip::cover_in(&triangles, grid.depth(), Cell::HalfOpen, lo, hi);
    let dag = built.dag();
    for z in lo[2]..hi[2] {
        for y in lo[1]..hi[1] {
            for x in lo[0]..hi[0] {
                let v = [x, y, z].map(|k| k as u32);
                let found = dag.contains(Morton::encode(v).unwrap());
                assert_eq!(found, truth.contains(&v), "{what}: voxel {v:?}");
            }
        }
    }
}

/// N^3 - (N - 2)^3: the voxels of a cube's surface.
fn shell(n: u64) -> u64 {
    n * n * n - n.saturating_sub(2) * n.saturating_sub(2) * n.saturating_sub(2)
}

#[test]
fn v00_random_triangles_at_every_small_resolution() {
    for seed in 0..120 {
        let mut rng = Rng::new(seed);
        let n = rng.between(1, 16) as u32;
        let size = rng.pick(&[0.3, 2.0, 20.0]);
        check(&scenes::soup(seed, 6, n, size), &unit_grid(n), &format!("seed {seed}, N = {n}"));
    }
}

#[test]
fn v00_one_random_triangle_at_a_time() {
    // One triangle alone: nothing can hide behind another.
    for seed in 0..1500 {
        let mut rng = Rng::new(seed);
        let n = rng.pick(&[4, 5, 8]);
        check(&scenes::soup(seed, 1, n, 6.0), &unit_grid(n), &format!("seed {seed}, N = {n}"));
    }
}

#[test]
fn v00_marks_name_the_triangles_that_made_them() {
    // Owners are chosen among these lists: each triangle's part must be its own cover.
    for seed in 0..20 {
        let shape = scenes::soup(seed, 12, 16, 3.0);
        let grid = unit_grid(16);
        let mesh = shape.mesh();
        let voxelizer = Voxelizer::new(&mesh, &grid, Cover::Exact).unwrap();
        let mut marked: Vec<BTreeSet<[u32; 3]>> = vec![BTreeSet::new(); shape.triangles.len()];
        for subtree in 0..voxelizer.subtrees() {
            let base = voxelizer.subtree_code(subtree).0;
            let each = |brick: &voxdag::voxelize::Marked<'_>| -> Result<(), VoxelizeError> {
                assert!(brick.triangles.is_sorted_by_key(|t| t.0), "seed {seed}: not in the mesh's order");
                assert_eq!(brick.triangles.iter().fold(0, |m, t| m | t.1), brick.mask, "seed {seed}");
                for &(triangle, mask) in brick.triangles {
                    let bits = (0..64).filter(|bit| mask >> bit & 1 == 1);
                    marked[triangle as usize].extend(bits.map(|bit| Morton(base | brick.code.0 | bit).decode()));
                }
                Ok(())
            };
            voxelizer.voxelize(subtree, each).unwrap();
        }
        let triangles = shape.snapped([0.0; 3], 1.0, 16);
        for (i, triangle) in triangles.iter().enumerate() {
            assert_eq!(marked[i], clip::cover(&[*triangle], 4, Cell::HalfOpen), "seed {seed}, triangle {i}");
        }
    }
}

#[test]
fn v00_one_brick_of_one_triangle_is_what_the_whole_says() {
    for (n, seed) in [(5u32, 0), (64, 1), (1 << 10, 2), (1 << 21, 3)] {
        let shape = scenes::soup(seed, 12, 64.min(n), 6.0).map(|p| p.map(|x| x + f64::from(n.max(64) - 64)));
        for cover in COVERS {
            let (mesh, grid) = (shape.mesh(), unit_grid(n));
            let voxelizer = Voxelizer::new(&mesh, &grid, cover).unwrap();
            let mut marked = std::collections::BTreeMap::new();
            for subtree in 0..voxelizer.subtrees() {
                let base = voxelizer.subtree_code(subtree).0;
                let whole = voxelizer.voxelize::<VoxelizeError>(subtree, |brick| {
                    for &(triangle, mask) in brick.triangles {
                        marked.insert((triangle, base | brick.code.0), mask);
                    }
                    Ok(())
                });
                whole.unwrap();
            }
            assert!(marked.len() > 10);
            // Each of these bricks for every triangle, and the ones beside it.
            let bricks: BTreeSet<u64> = marked.keys().map(|key| key.1).collect();
            let beside = bricks.iter().flat_map(|&code| [Some(Morton(code)), Morton(code).neighbour([4, 0, -4])]);
            for code in beside.flatten() {
                for triangle in 0..12 {
                    let expected = marked.get(&(triangle, code.0)).copied().unwrap_or(0);
                    assert_eq!(voxelizer.brick(triangle, code), expected, "N = {n}, {cover:?}, {triangle} at {code:?}");
                }
            }
            assert_eq!(voxelizer.brick(0, Morton(!63)), 0);
        }
    }
}

#[test]
fn v01_three_equal_vertices_are_one_voxel() {
    for n in [8u32, 1 << 10, 1 << 16, 1 << 21] {
        for seed in 0..50 {
            let mut rng = Rng::new(seed);
            // Anywhere, and on a corner, an edge or a face of a voxel.
            let p = [(); 3].map(|()| {
                let k = rng.below(u64::from(n)) as f64;
                k + rng.pick(&[0.0, 0.5, 255.0 / 256.0])
            });
            let voxels = subject::cover(&of(&[[p; 3]]), &unit_grid(n), Cover::Exact);
            assert_eq!(voxels, BTreeSet::from([p.map(|x| x as u32)]), "seed {seed}, N = {n}");
        }
    }
}

#[test]
fn v02_segments_are_the_voxels_along_them() {
    for seed in 0..150 {
        check(&scenes::degenerate_fan(seed, 2, 8), &unit_grid(8), &format!("seed {seed}"));
    }
    // Collinear vertices in any order, at any depth, along a random direction of short steps.
    for (n, seed) in [(1u32 << 10, 1), (1 << 16, 2), (1 << 21, 3)] {
        let mut rng = Rng::new(seed);
        for _ in 0..20 {
            let a = [(); 3].map(|()| rng.below(u64::from(n) - 200) as f64 + 100.0);
            let step = [(); 3].map(|()| rng.between(-12, 12) as f64 / 4.0);
            let at = |k: f64| core::array::from_fn(|i| a[i] + k * step[i]);
            let mut corners = [at(0.0), at(8.0), at(3.0)];
            rng.shuffle(&mut corners);
            check(&of(&[corners]), &unit_grid(n), &format!("seed {seed}, N = {n}: {corners:?}"));
        }
    }
}

#[test]
fn v03_slivers_have_no_holes() {
    // Scene-long, at most 1/64 voxel wide, so that snapping leaves a segment or a width of a few units.
    for seed in 0..8 {
        let shape = scenes::slivers(seed, 1, 256.0, 1.0 / 64.0);
        let grid = unit_grid(256);
        let (found, truth) = (subject::cover(&shape, &grid, Cover::Exact), true_cover(&shape, &grid, Cover::Exact));
        assert_eq!(found, truth, "seed {seed}");
    }
    // Where the whole is too long for the oracle: every point in a marked voxel, and all voxels around some points.
    for (n, seed) in [(1u32 << 10, 11), (1 << 16, 12), (1 << 21, 13), (1 << 21, 14)] {
        let shape = scenes::slivers(seed, 1, f64::from(n), 1.0 / 64.0);
        let grid = unit_grid(n);
        let built = build(&shape.mesh(), &grid, Cover::Exact).unwrap();
        let dag = built.dag();
        let triangle = shape.snapped([0.0; 3], 1.0, n)[0];
        let mut rng = Rng::new(seed);
        for i in 0..20_000 {
            let [u, v] = [(); 2].map(|()| rng.between(0, 1 << 30));
            let [u, v] = if u + v > 1 << 30 { [(1 << 30) - u, (1 << 30) - v] } else { [u, v] };
            let w = (1 << 30) - u - v;
            let voxel: [u32; 3] =
                core::array::from_fn(|i| ((u * triangle[0][i] + v * triangle[1][i] + w * triangle[2][i]) >> 38) as u32);
            assert!(dag.contains(Morton::encode(voxel).unwrap()), "hole at {voxel:?}, N = {n}, seed {seed}");
            if i < 20 {
                check_window(&shape, &built, &grid, voxel.map(i64::from), 6, &format!("N = {n}, seed {seed}"));
            }
        }
    }
}

#[test]
fn v04_triangle_in_a_face_plane_marks_the_upper_layer_only() {
    for axis in 0..3 {
        for k in 0..8 {
            let at = |a: f64, b: f64| {
                let mut p = [f64::from(k); 3];
                p[(axis + 1) % 3] = a;
                p[(axis + 2) % 3] = b;
                p
            };
            let square = of(&[[at(0.0, 0.0), at(8.0, 0.0), at(8.0, 8.0)], [at(0.0, 0.0), at(8.0, 8.0), at(0.0, 8.0)]]);
            let voxels = subject::cover(&square, &unit_grid(8), Cover::Exact);
            assert_eq!(voxels.len(), 64, "axis {axis}, plane {k}");
            assert!(voxels.iter().all(|v| v[axis] == k), "axis {axis}, plane {k}");
        }
    }
}

#[test]
fn v04_a_cube_with_faces_on_voxel_planes() {
    // From plane a to plane b: layers a and b, since a plane belongs to the voxels above it.
    for (depth, a, b) in [(3u32, 1u64, 6u64), (10, 256, 300), (16, 40_000, 40_031), (21, (1 << 21) - 40, (1 << 21) - 2)]
    {
        let cube = scenes::cuboid([a as f64; 3], [b as f64; 3]);
        let built = build(&cube.mesh(), &unit_grid(1 << depth), Cover::Exact).unwrap();
        assert_eq!(built.dag().stats().unwrap().voxels, shell(b - a + 1), "depth {depth}");
    }
}

#[test]
fn v05_planes_through_voxel_corners() {
    // The plane x + y + z = c over a corner p has (3 c^2 + 3 c + 2) / 2 voxels, wherever p lies.
    for (depth, c) in [(3u32, 7u64), (10, 1000), (16, 500), (21, 700)] {
        let n = 1u64 << depth;
        for p in [0, (n - c - 1) / 2, n - c - 1] {
            let corner = |axis: usize| {
                let mut q = [p as f64; 3];
                q[axis] += c as f64;
                q
            };
            let plane = of(&[[corner(0), corner(1), corner(2)]]);
            let built = build(&plane.mesh(), &unit_grid(n as u32), Cover::Exact).unwrap();
            let expected = (3 * c * c + 3 * c + 2) / 2;
            assert_eq!(built.dag().stats().unwrap().voxels, expected, "depth {depth}, p = {p}");
            let thin = build(&plane.mesh(), &unit_grid(n as u32), Cover::Thin).unwrap();
            assert_eq!(thin.dag().stats().unwrap().voxels, c * (c + 1) / 2, "thin, depth {depth}, p = {p}");
        }
    }
}

#[test]
fn v06_the_far_border_belongs_to_the_last_voxel() {
    // The unit cube is a full shell at every resolution, also where N / (extent / N) is not N.
    let small = 1..=96;
    let others = [100, 127, 128, 129, 200, 255, 256, 257, 333, 500, 511, 512, 513, 1000, 1023, 1024, 1025];
    for n in small.chain(others) {
        for cube in [scenes::unit_cube(), scenes::cuboid([0.1, 0.7, -0.3], [0.4, 1.0, 0.0])] {
            if n > 100 && cube.positions[0] != [0.0; 3] {
                continue;
            }
            let grid = fitted(&cube, n);
            let built = build(&cube.mesh(), &grid, Cover::Exact).unwrap();
            let truth = true_cover_size_of_box(&cube, &grid);
            assert_eq!(built.dag().stats().unwrap().voxels, truth, "N = {n}");
            if cube.positions[0] == [0.0; 3] {
                assert_eq!(truth, shell(u64::from(n)), "N = {n}");
            }
        }
    }
}

/// The shell of the box of voxels that an axis-parallel box's snapped corners lie in.
fn true_cover_size_of_box(shape: &Shape, grid: &Grid) -> u64 {
    let corners: Vec<[i64; 3]> =
        shape.snapped(grid.origin, grid.voxel_size, grid.resolution).concat().into_iter().collect();
    let cells = |f: fn(i64, i64) -> i64| -> [i64; 3] {
        core::array::from_fn(|i| corners.iter().map(|p| p[i] >> 8).reduce(f).unwrap())
    };
    let (lo, hi) = (cells(i64::min), cells(i64::max));
    let product = |less: i64| -> i64 { (0..3).map(|i| (hi[i] - lo[i] + 1 - less).max(0)).product() };
    (product(0) - product(2)) as u64
}

#[test]
fn v06_the_grid_is_full_to_the_last_voxel_at_2049() {
    let cube = scenes::unit_cube();
    let built = build(&cube.mesh(), &fitted(&cube, 2049), Cover::Exact).unwrap();
    assert_eq!(built.dag().stats().unwrap().voxels, shell(2049));
}

#[test]
fn v06_long_bars_end_with_the_last_voxel() {
    // 2^16 and 2^21 voxels long, three high and two wide: the shell of a box of whole voxels is all of it.
    for depth in [10u32, 16, 21] {
        let n = 1u64 << depth;
        for axis in 0..3 {
            let mut far = [0.0; 3];
            far[axis] = 1.0;
            far[(axis + 1) % 3] = 2.5 / n as f64;
            far[(axis + 2) % 3] = 1.5 / n as f64;
            let bar = scenes::cuboid([0.0; 3], far);
            let built = build(&bar.mesh(), &fitted(&bar, n as u32), Cover::Exact).unwrap();
            assert_eq!(built.dag().stats().unwrap().voxels, 6 * n, "axis {axis}, depth {depth}");
            let mut last = [1; 3];
            last[axis] = n as u32 - 1;
            assert!(built.dag().contains(Morton::encode(last).unwrap()), "axis {axis}, depth {depth}");
            if depth == 21 {
                break;
            }
        }
    }
}

#[test]
fn v06_published_boxes() {
    // cuda_voxelizer issue 64: a box that came out as 8 x 8 x 7; issue 61: this cube, of decimals that are no floats.
    let cube = scenes::cuboid([150.100006, 400.100006, 150.100006], [550.099976, 800.099976, 550.099976]);
    for n in [8, 31, 32, 64, 256] {
        let grid = fitted(&cube, n);
        let built = build(&cube.mesh(), &grid, Cover::Exact).unwrap();
        let voxels = subject::voxels(&built);
        assert_eq!(voxels.len() as u64, shell(u64::from(n)), "N = {n}");
        for axis in 0..3 {
            assert_eq!(voxels.iter().map(|v| v[axis]).max(), Some(n - 1), "N = {n}");
        }
    }
    let box_8_8_7 = scenes::cuboid([0.0; 3], [8.0, 8.0, 7.0]);
    let voxels = subject::cover(&box_8_8_7, &fitted(&box_8_8_7, 8), Cover::Exact);
    // The upper face lies in the plane z = 7, which belongs to layer 7.
    assert_eq!(voxels.len(), 8 * 8 * 8 - 6 * 6 * 6);
}

#[test]
fn v06_a_staircase_on_voxel_planes() {
    // Eight steps, each tread in a voxel plane: each is one layer, none is lost and none is doubled.
    let treads: Vec<[[f64; 3]; 3]> = (0..8)
        .flat_map(|k| {
            let k = f64::from(k);
            let at = |x: f64, y: f64| [k + x, y, k];
            let (x, y) = (0.75, 7.75);
            [[at(0.25, 0.25), at(x, 0.25), at(x, y)], [at(0.25, 0.25), at(x, y), at(0.25, y)]]
        })
        .collect();
    let voxels = subject::cover(&of(&treads), &unit_grid(8), Cover::Exact);
    let expected: BTreeSet<[u32; 3]> = (0..8).flat_map(|k| (0..8).map(move |y| [k, y, k])).collect();
    assert_eq!(voxels, expected);
}

#[test]
fn v07_flat_and_thin_and_single_scenes() {
    for n in [1, 2, 3, 8, 100] {
        for axis in 0..3 {
            // A sheet: no extent along one axis.
            let mut hi = [3.0; 3];
            hi[axis] = 0.0;
            let mut sheet = scenes::cuboid([0.0; 3], hi).map(|p| core::array::from_fn(|i| p[i] - 7.5));
            sheet.triangles.reverse();
            let voxels = subject::cover(&sheet, &fitted(&sheet, n), Cover::Exact);
            assert_eq!(voxels.len() as u32, n * n, "sheet, axis {axis}, N = {n}");
            assert!(voxels.iter().all(|v| v[axis] == 0));
            // A line: extent along one axis only.
            let mut end = [2.0; 3];
            end[axis] = 5.0;
            let line = of(&[[[2.0; 3], end, end]]);
            for n in [n, 1 << 10, 1 << 16] {
                let built = build(&line.mesh(), &fitted(&line, n), Cover::Exact).unwrap();
                assert_eq!(built.dag().stats().unwrap().voxels, u64::from(n), "line, axis {axis}, N = {n}");
            }
        }
        let point = of(&[[[1e9, -3.0, 0.1]; 3]]);
        for n in [n, 1 << 16, 1 << 21] {
            assert_eq!(subject::cover(&point, &fitted(&point, n), Cover::Exact), BTreeSet::from([[0; 3]]), "N = {n}");
        }
    }
}

#[test]
fn v08_survey_coordinates_keep_their_detail() {
    // The same mesh at a dyadic offset of half a million and five million: identical words.
    let near = scenes::soup(3, 60, 64, 4.0).map(|p| p.map(|x| (x * 1024.0).round() / 1024.0));
    let offset = [524_288.0 + 0.5, 4_980_736.25, -786_432.125];
    let far = near.map(|p| core::array::from_fn(|i| p[i] + offset[i]));
    for n in [7, 64, 1000] {
        let words = |shape: &Shape| build(&shape.mesh(), &fitted(shape, n), Cover::Exact).unwrap().into_words();
        assert_eq!(words(&near), words(&far), "N = {n}");
    }
    // Millimetres over kilometres: small triangles, some of them in the far corner of the largest grids.
    let small = scenes::soup(3, 20, 64, 1.0).map(|p| p.map(|x| (x * 1024.0).round() / 1024.0));
    for depth in [16, 21] {
        let scale = f64::from(1u32 << depth) / 64.0;
        let mut near = small.map(|p| p.map(|x| x / scale));
        near.add(&small.map(|p| p.map(|x| 64.0 - x / scale)));
        let far = near.map(|p| core::array::from_fn(|i| p[i] + offset[i]));
        let words =
            |shape: &Shape| build(&shape.mesh(), &fitted(shape, 1 << depth), Cover::Exact).unwrap().into_words();
        assert_eq!(words(&near), words(&far), "2^{depth}");
    }
}

#[test]
fn v09_scaling_by_powers_of_two_changes_nothing() {
    let shape = scenes::soup(4, 40, 32, 4.0);
    let words = |shape: &Shape| build(&shape.mesh(), &fitted(shape, 100), Cover::Exact).unwrap().into_words();
    let expected = words(&shape);
    for exponent in (-120..=100).chain([-900, 900]) {
        let scaled = shape.map(|p| p.map(|x| libm::scalbn(x, exponent)));
        assert_eq!(words(&scaled), expected, "scaled by 2^{exponent}");
    }
    // In large grids: small triangles, and a segment that spans the grid.
    for depth in [10, 16, 21] {
        let n = f64::from(1u32 << depth);
        let mut shape = scenes::soup(4, 20, 32, 4.0).map(|p| p.map(|x| x + n - 32.0));
        shape.add(&of(&[[[0.0; 3], [n, 1.0, 1.0], [n, 1.0, 1.0]]]));
        let words =
            |shape: &Shape| build(&shape.mesh(), &fitted(shape, 1 << depth), Cover::Exact).unwrap().into_words();
        let expected = words(&shape);
        for exponent in if depth == 21 { [-120, 100] } else { [-119, 77] } {
            let scaled = shape.map(|p| p.map(|x| libm::scalbn(x, exponent)));
            assert_eq!(words(&scaled), expected, "2^{depth}, scaled by 2^{exponent}");
        }
    }
}

#[test]
fn v10_what_is_not_finite_is_refused_and_named() {
    let good = scenes::unit_cube();
    let grid = unit_grid(8);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for vertex in 0..8 {
            for axis in 0..3 {
                let mut shape = good.clone();
                shape.positions[vertex][axis] = bad;
                let expected = MeshError::NonFinite { vertex: vertex as u32 };
                assert_eq!(
                    build(&shape.mesh(), &grid, Cover::Exact).err(),
                    Some(Refused::Voxelize(VoxelizeError::Mesh(expected)))
                );
                assert_eq!(shape.mesh().validate(), Err(expected));
            }
        }
    }
    // Also refused, not clamped: a vertex outside the grid. A vertex that no triangle uses is nobody's business.
    let mut shape = good.clone();
    shape.positions[5] = [1.0, 8.5, 1.0];
    let expected = VoxelizeError::Grid(GridError::Outside { vertex: 5 });
    assert_eq!(build(&shape.mesh(), &grid, Cover::Exact).err(), Some(Refused::Voxelize(expected)));
    let mut shape = good;
    shape.positions.push([f64::NAN; 3]);
    assert!(build(&shape.mesh(), &grid, Cover::Exact).is_ok());
}

#[test]
fn v10_any_mesh_of_bits_is_an_answer_or_an_error() {
    for seed in 0..400 {
        let mut rng = Rng::new(seed);
        let wild = |rng: &mut Rng| match rng.below(4) {
            0 => f64::from_bits(rng.bits()),
            1 => rng.spread(-1070, 1020),
            2 => rng.spread(-3, 3),
            _ => 0.0,
        };
        let positions: Vec<[f64; 3]> = (0..6).map(|_| [(); 3].map(|()| wild(&mut rng))).collect();
        let triangles: Vec<[u32; 3]> = (0..4).map(|_| [(); 3].map(|()| rng.below(7) as u32)).collect();
        let mesh = Mesh { positions: &positions, triangles: &triangles, ..Mesh::default() };
        let Ok(bounds) = mesh.validate() else { continue };
        let Ok(grid) = Grid::fit(&bounds, rng.between(1, 64) as u32) else { continue };
        let built = build(&mesh, &grid, Cover::Exact).unwrap_or_else(|e| panic!("seed {seed}: {e:?}"));
        assert!(!built.dag().is_empty(), "seed {seed}");
    }
}

#[test]
fn v11_the_work_is_in_proportion_to_the_area() {
    // A sliver across 2^21 voxels: its box has 2^63 voxels. Time is generous: a box loop would take centuries.
    let n = f64::from(1u32 << 21);
    let start = Instant::now();
    let shape = of(&[[[0.0; 3], [n; 3], [n, n, n - 1.0]]]);
    let grid = unit_grid(1 << 21);
    let built = build(&shape.mesh(), &grid, Cover::Exact).unwrap();
    let voxels = built.dag().stats().unwrap().voxels;
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
    // At least one voxel per layer, at most a few.
    assert!((1 << 21..7 << 21).contains(&voxels), "{voxels}");
    for k in [0, 5, 1 << 10, (1 << 20) + 3, (1 << 21) - 4] {
        check_window(&shape, &built, &grid, [k; 3], 6, &format!("around {k}"));
    }
}

#[test]
fn v11_a_triangle_as_large_as_the_scene() {
    // Only windows of it at depth 21 would be affordable; at depth 10 the whole is.
    for seed in 0..3 {
        let shape = scenes::soup(seed, 1, 1024, 1e6);
        let grid = unit_grid(1024);
        let built = build(&shape.mesh(), &grid, Cover::Exact).unwrap();
        let [a, b, c] = shape.snapped([0.0; 3], 1.0, 1024)[0];
        let middle: [i64; 3] = core::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3 / 256);
        for around in [middle, a.map(|x| x >> 8), b.map(|x| x >> 8), c.map(|x| x >> 8)] {
            check_window(&shape, &built, &grid, around, 12, &format!("seed {seed}"));
        }
    }
}

#[test]
fn v12_the_order_of_triangles_and_of_their_vertices_does_not_matter() {
    let mut shape = scenes::torus([32.0; 3], 20.0, 9.0, 40, 20);
    shape.add(&scenes::soup(5, 100, 64, 2.0));
    shape.add(&scenes::degenerate_fan(5, 10, 64));
    for (cover, n) in COVERS.into_iter().flat_map(|cover| [64u32, 1 << 10, 1 << 16, 1 << 21].map(|n| (cover, n))) {
        let shape = shape.map(|p| p.map(|x| x + f64::from(n - 64)));
        let expected = build(&shape.mesh(), &unit_grid(n), cover).unwrap().into_words();
        let rotated = |by: usize| {
            let mut rotated = shape.clone();
            rotated.triangles.iter_mut().for_each(|t| t.rotate_left(by));
            rotated
        };
        let shuffled = |seed: u64| {
            let mut rng = Rng::new(seed);
            let mut shuffled = shape.clone();
            rng.shuffle(&mut shuffled.triangles);
            shuffled.triangles.iter_mut().for_each(|t| rng.shuffle(t));
            shuffled
        };
        for (i, other) in [rotated(1), rotated(2), shuffled(0), shuffled(1), shuffled(2)].iter().enumerate() {
            let words = build(&other.mesh(), &unit_grid(n), cover).unwrap().into_words();
            assert!(words == expected, "order {i}, N = {n}, {cover:?}");
        }
    }
}

#[test]
fn v13_every_separating_axis_is_needed() {
    // One case per axis of the 13: a triangle that only this axis separates from a voxel it is close to. Found by
    // search: random triangles that miss the voxel, judged by a textbook test that leaves one axis out.
    let mut seen = [0; 13];
    for seed in 0..200_000 {
        let mut rng = Rng::new(seed);
        let t: [[i64; 3]; 3] = [(); 3].map(|()| [(); 3].map(|()| rng.between(0, 15) * 64));
        let separating = separating_axes(t, [1, 1, 1]);
        let [only] = separating[..] else { continue };
        if seen[only] >= 10 {
            continue;
        }
        seen[only] += 1;
        let shape = of(&[t.map(|p| p.map(|x| x as f64 / 256.0))]);
        let voxels = subject::cover(&shape, &unit_grid(4), Cover::Exact);
        assert!(!voxels.contains(&[1, 1, 1]), "seed {seed}: {t:?} is apart from voxel (1, 1, 1) by axis {only} alone");
        assert_eq!(voxels, true_cover(&shape, &unit_grid(4), Cover::Exact), "seed {seed}: {t:?}");
        for n in [1u32 << 10, 1 << 16, 1 << 21] {
            let by = n - 4;
            let moved = shape.map(|p| p.map(|x| x + f64::from(by)));
            let there = subject::cover(&moved, &unit_grid(n), Cover::Exact);
            // But for what the far border pulls in.
            if t.iter().flatten().all(|x| *x < 4 * 256) {
                assert!(there.into_iter().eq(voxels.iter().map(|v| v.map(|k| k + by))), "seed {seed}, N = {n}: {t:?}");
            }
        }
    }
    assert!(seen.iter().all(|&n| n == 10), "cases per axis: {seen:?}");
}

/// The axes (3 of the box, 9 of edges, the normal) that separate the closed triangle from the half-open voxel.
fn separating_axes(t: [[i64; 3]; 3], voxel: [i64; 3]) -> Vec<usize> {
    let sub = |a: [i64; 3], b: [i64; 3]| -> [i64; 3] { core::array::from_fn(|i| a[i] - b[i]) };
    let cross =
        |a: [i64; 3], b: [i64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let units = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let edges = [sub(t[1], t[0]), sub(t[2], t[1]), sub(t[0], t[2])];
    let nine = edges.iter().flat_map(|&e| units.map(|u| cross(u, e)));
    let axes: Vec<[i64; 3]> = units.into_iter().chain(nine).chain([cross(edges[0], edges[1])]).collect();
    let separates = |a: &[i64; 3]| {
        let values = t.map(|p| (0..3).map(|i| a[i] * p[i]).sum::<i64>());
        let (min, max) = (values.into_iter().min().unwrap(), values.into_iter().max().unwrap());
        let corner: i64 = (0..3).map(|i| a[i] * voxel[i] * 256).sum();
        let up: i64 = a.iter().map(|x| x.max(&0) * 256).sum();
        let down: i64 = a.iter().map(|x| x.min(&0) * 256).sum();
        // The extreme value is not reached where it lies on an upper face.
        let (top, bottom) = (corner + up - i64::from(up > 0), corner + down + i64::from(down < 0));
        min > top || max < bottom
    };
    (0..13).filter(|&i| separates(&axes[i])).collect()
}

#[test]
fn v13_published_triangles() {
    // Open3D issue 6111: the interior of a face, far from its edges; MathGeoLib issue 51: parallel to the axes.
    let face = of(&[[[0.5, 0.5, 2.0], [31.5, 0.5, 2.0], [0.5, 31.5, 2.0]]]);
    check(&face, &unit_grid(32), "a face's interior");
    assert!(subject::cover(&face, &unit_grid(32), Cover::Exact).contains(&[10, 10, 2]));
    check(&of(&[[[2.0, 2.0, 2.0], [3.0, 2.0, 2.0], [2.0, 3.0, 2.0]]]), &unit_grid(4), "parallel to the axes");
    // CGAL issue 6808, moved into the grid: its box is no voxel, but the triangle is all edges and thin.
    let cgal = of(&[[[-34.1128, -4.00842, 39.5061], [-36.0938, -3.6615, 36.87], [-34.5781, -3.61804, 39.9716]]]);
    for n in [3, 14, 64] {
        check(&cgal, &fitted(&cgal, n), "CGAL 6808");
    }
}

/// Grids are cubic: there is no second scale that could be paired with the wrong axis. Whoever wants voxels of other
/// shapes scales the mesh instead, and the exact cover follows.
#[test]
fn v14_voxels_that_are_no_cubes_are_scaled_meshes() {
    for seed in 0..60 {
        let mut rng = Rng::new(seed);
        // Sides of a voxel in units of 1/256 cube.
        let mut sides = [256i64, 512, 1024];
        rng.shuffle(&mut sides);
        for depth in [3u8, 10, 16, 21] {
            let first = (1i64 << depth) - 8;
            // Corners on 1/256 of the sides, many of them on the planes between voxels.
            let cell = [(); 3].map(|()| {
                [(); 3].map(|()| {
                    let x = rng.below(7 * 256) as i64;
                    256 * first + if rng.below(3) == 0 { x & !255 } else { x }
                })
            });
            let triangle = cell.map(|p| core::array::from_fn(|i| p[i] * (sides[i] / 256)));
            let scaled = of(&[triangle.map(|p| core::array::from_fn(|i| p[i] as f64 / sides[i] as f64))]);
            let found = subject::cover(&scaled, &unit_grid(1 << depth), Cover::Exact);
            let mut truth = BTreeSet::new();
            for k in 0..512 {
                let voxel = [k & 7, k >> 3 & 7, k >> 6].map(|k| first + k);
                let lo = core::array::from_fn(|i| voxel[i] * sides[i]);
                let hi = core::array::from_fn(|i| (voxel[i] + 1) * sides[i]);
                if clip::meets(&triangle, &Aabb { lo, hi, open: [true; 3] }) {
                    truth.insert(voxel.map(|k| k as u32));
                }
            }
            assert_eq!(found, truth, "seed {seed}, depth {depth}, sides {sides:?}: {triangle:?}");
        }
    }
}

/// How many triangles lie below a point that is on none of them, by exact signs. Edges that the line below the point
/// meets count for one of their two triangles: the point is moved by (e, e^2) for an e that is small enough.
fn triangles_below(triangles: &[clip::Triangle], point: [i64; 3]) -> usize {
    let p = point.map(i128::from);
    let below = |t: &&clip::Triangle| {
        let t = t.map(|q| q.map(i128::from));
        // On which side of each edge, seen along z; 0 is decided by the edge's direction.
        let side = |a: [i128; 3], b: [i128; 3]| {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let e = dx * (p[1] - a[1]) - dy * (p[0] - a[0]);
            [e, -dy, dx].into_iter().find(|x| *x != 0).map_or(0, i128::signum)
        };
        let sides = [side(t[0], t[1]), side(t[1], t[2]), side(t[2], t[0])];
        let within = sides[0] != 0 && sides.iter().all(|s| *s == sides[0]);
        let [u, v, w] = [0, 1, 2].map(|i| [t[1][i] - t[0][i], t[2][i] - t[0][i], p[i] - t[0][i]]);
        let volume = u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0])
            + u[2] * (v[0] * w[1] - v[1] * w[0]);
        within && volume.signum() == sides[0]
    };
    triangles.iter().filter(below).count()
}

#[test]
fn v15_parity_and_separation_agree_on_every_column() {
    // A closed mesh: outside an even number of triangles lies below, inside an odd one. The voxels that the exact or the
    // thin cover leaves free are outside exactly if a walk over faces of free voxels leads to the border.
    const SIDE: i64 = 16;
    for depth in [4u8, 10, 16, 21] {
        let first = ((1i64 << depth) - SIDE) as f64;
        let at = [first + 8.0; 3];
        for (name, shape) in [
            ("sphere", scenes::sphere(at, 6.3, 2)),
            ("globe", scenes::globe(at, 7.0, 9, |i| 1.0 - 0.3 * (i % 3) as f64)),
            ("torus", scenes::torus(at, 4.8, 2.2, 9, 7)),
            ("box on planes", scenes::divided_box(at.map(|x| x - 4.0), at.map(|x| x + 3.0), 3)),
        ] {
            let grid = unit_grid(1 << depth);
            let triangles = shape.snapped([0.0; 3], 1.0, grid.resolution);
            for cover in [Cover::Exact, Cover::Thin, Cover::Inflated] {
                let marked = subject::cover(&shape, &grid, cover);
                let free = |v: [i64; 3]| !marked.contains(&v.map(|k| (k + first as i64) as u32));
                let all = || (0..SIDE * SIDE * SIDE).map(|i| [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)]);
                let mut open: Vec<[i64; 3]> =
                    all().filter(|v| v.iter().any(|&k| k == 0 || k == SIDE - 1) && free(*v)).collect();
                let mut outside: BTreeSet<[i64; 3]> = open.iter().copied().collect();
                while let Some(v) = open.pop() {
                    for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                        let mut w = v;
                        w[axis] += step;
                        if (0..SIDE).contains(&w[axis]) && free(w) && outside.insert(w) {
                            open.push(w);
                        }
                    }
                }
                let mut inside = 0;
                for v in all().filter(|v| free(*v)) {
                    let centre = v.map(|k| (k + first as i64) * 256 + 128);
                    let odd = triangles_below(&triangles, centre) % 2 == 1;
                    assert_eq!(odd, !outside.contains(&v), "{name}, {cover:?}, depth {depth}: voxel {v:?}");
                    inside += u32::from(odd);
                }
                assert!(inside > 30, "{name}, {cover:?}, depth {depth}: {inside} voxels inside are too few");
                // And above everything the count is even.
                for i in 0..SIDE * SIDE {
                    let top = [i % SIDE, i / SIDE, 2 * SIDE].map(|k| (k + first as i64) * 256 + 128);
                    assert_eq!(triangles_below(&triangles, top) % 2, 0, "{name}, depth {depth}: column {i}");
                }
            }
        }
    }
}

#[test]
fn v15_closed_meshes_are_what_the_oracle_says() {
    check(&scenes::sphere([8.0; 3], 7.3, 2), &unit_grid(16), "sphere");
    check(&scenes::torus([8.0; 3], 5.0, 2.0, 9, 7), &unit_grid(16), "torus");
    check(&scenes::tilted_plane(16.0, 0.7, 1.0), &unit_grid(16), "tilted plane");
    check(&scenes::diagonals(16.0), &unit_grid(16), "diagonals");
}

#[test]
fn v16_any_partition_gives_the_same_words() {
    let mut shape = scenes::sphere([500.0; 3], 480.0, 4);
    shape.add(&scenes::slivers(1, 5, 1000.0, 0.1));
    for (n, cover) in [(1000, Cover::Exact), (1000, Cover::Thin), (1000, Cover::Inflated)] {
        let grid = unit_grid(n);
        let whole = build(&shape.mesh(), &grid, cover).unwrap();
        let count = Voxelizer::new(&shape.mesh(), &grid, cover).unwrap().subtrees();
        let mut order: Vec<usize> = (0..count).collect();
        for seed in 0..2 {
            Rng::new(seed).shuffle(&mut order);
            let apart = build_apart(&shape.mesh(), &grid, cover, &order).unwrap();
            assert!(apart.words() == whole.words(), "{cover:?}, seed {seed}");
        }
    }
    // In larger grids: small triangles here and there.
    for n in [1u32 << 16, 1 << 21] {
        let mut shape = scenes::soup(16, 30, 64, 8.0);
        shape.add(&shape.map(|p| core::array::from_fn(|i| p[i] + f64::from((n / 2) >> i) - 32.0)));
        shape.add(&shape.map(|p| p.map(|x| f64::from(n) - x)));
        let count = Voxelizer::new(&shape.mesh(), &unit_grid(n), Cover::Exact).unwrap().subtrees();
        let mut order: Vec<usize> = (0..count).collect();
        Rng::new(16).shuffle(&mut order);
        let apart = build_apart(&shape.mesh(), &unit_grid(n), Cover::Exact, &order).unwrap();
        assert!(count > 3 && apart == build(&shape.mesh(), &unit_grid(n), Cover::Exact).unwrap(), "N = {n}");
    }
    // And they are the words of the naive builder.
    for n in [1u32, 2, 3, 4, 5, 8, 30, 64] {
        let shape = scenes::sphere([f64::from(n) / 2.0; 3], f64::from(n) * 0.49, 2);
        let grid = unit_grid(n);
        let built = build(&shape.mesh(), &grid, Cover::Exact).unwrap();
        assert_eq!(built.words(), VoxelSet::new(subject::voxels(&built)).words(grid.depth()), "N = {n}");
        let count = Voxelizer::new(&shape.mesh(), &grid, Cover::Exact).unwrap().subtrees();
        let order: Vec<usize> = (0..count).collect();
        let apart = build_apart(&shape.mesh(), &grid, Cover::Exact, &order).unwrap();
        assert_eq!(apart.words(), built.words(), "N = {n}");
    }
}

#[test]
fn v17_moving_by_whole_voxels_moves_the_voxels() {
    let shape = scenes::soup(9, 40, 32, 3.0);
    for n in [1u32 << 7, 1 << 10, 1 << 16, 1 << 21] {
        for cover in COVERS {
            // Away from the far border, which is pulled in by one unit.
            let here = subject::cover(&shape.map(|p| p.map(|x| x + 8.0)), &unit_grid(n), cover);
            let mut rng = Rng::new(u64::from(n));
            let by = [(); 3].map(|()| rng.below(u64::from(n) - 48) as u32);
            let moved = shape.map(|p| core::array::from_fn(|i| p[i] + 8.0 + f64::from(by[i])));
            let there = subject::cover(&moved, &unit_grid(n), cover);
            let expected = here.iter().map(|v| core::array::from_fn(|i| v[i] + by[i])).collect();
            assert_eq!(there, expected, "{cover:?}, N = {n}, by {by:?}");
        }
    }
}

#[test]
fn v17_moving_the_grid_by_whole_voxels_moves_the_voxels() {
    // The mesh stays where it is, off the origin and in voxels of 1/8: grids that differ by whole voxels share a lattice.
    let shape = scenes::soup(17, 40, 4, 0.5).map(|p| [p[0] - 700.3, p[1] + 20.7, p[2] - 0.01]);
    let size = 0.125;
    for n in [1u32 << 6, 1 << 10, 1 << 16, 1 << 21] {
        let mut rng = Rng::new(u64::from(n));
        let base = Grid { origin: [-701.0, 20.0, -1.0], voxel_size: size, resolution: 64 };
        let by = [(); 3].map(|()| rng.below(u64::from(n - 63)) as u32);
        let origin = core::array::from_fn(|i| base.origin[i] - size * f64::from(by[i]));
        let moved = Grid { origin, resolution: n, ..base };
        for cover in COVERS {
            let here = subject::cover(&shape, &base, cover);
            let expected = here.iter().map(|v| core::array::from_fn(|i| v[i] + by[i])).collect();
            assert_eq!(subject::cover(&shape, &moved, cover), expected, "{cover:?}, N = {n}, by {by:?}");
        }
    }
}

#[test]
fn v18_the_inflated_cover_holds_the_original_floats() {
    // Vertices on 1/65536 voxel: the exact cover of the unsnapped triangle is part of the inflated one.
    const FINE: i64 = 65536;
    for seed in 0..600 {
        let mut rng = Rng::new(seed);
        let n = rng.pick(&[4i64, 5, 8]);
        let fine: [[i64; 3]; 3] = [(); 3].map(|()| {
            [(); 3].map(|()| match rng.below(4) {
                // The borders are where snapping does something special.
                0 => rng.pick(&[0, n * FINE]),
                _ => rng.between(0, n * FINE),
            })
        });
        // In the far corner of a larger grid, too: its f64 hold 1/65536 of a voxel.
        let larger = [n, 1 << 10, 1 << 16, 1 << 21][seed as usize % 4];
        let first = (larger - n) as u32;
        let shape = of(&[fine.map(|p| p.map(|x| f64::from(first) + x as f64 / FINE as f64))]);
        let inflated = subject::cover(&shape, &unit_grid(larger as u32), Cover::Inflated);
        for z in 0..n {
            for y in 0..n {
                for x in 0..n {
                    let voxel = [x, y, z];
                    let aabb = Aabb {
                        lo: voxel.map(|k| k * FINE),
                        hi: voxel.map(|k| (k + 1) * FINE),
                        // The far border belongs to the last voxel.
                        open: voxel.map(|k| k + 1 < n),
                    };
                    let met = clip::meets(&fine, &aabb);
                    let marked = inflated.contains(&voxel.map(|k| first + k as u32));
                    assert!(marked || !met, "seed {seed}, N = {n}: voxel {voxel:?} is missing for {fine:?}");
                }
            }
        }
    }
}

#[test]
fn v18_the_inflated_cover_at_the_far_border() {
    // A steep segment into the far border. Pulling its end in by a whole unit, as the exact cover does, moves the points
    // near x = 63 by three quarters of a unit, past a voxel that inflation by half a unit does not bring back: on x = 63
    // the segment is at y = 37 - 1/256, so it meets voxel (63, 36, 0), and at once leaves it through y = 37.
    let end = [64.0, 49.328125, 0.5];
    let segment = of(&[[[60.0, 0.0, 0.5], end, end]]);
    assert!(subject::cover(&segment, &unit_grid(64), Cover::Inflated).contains(&[63, 36, 0]));
}

#[test]
fn v16_the_sign_of_a_zero_leaves_no_trace() {
    let corners = [[-0.0, 0.0, 0.0], [0.0, -0.0, -0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let orders: [&[[u32; 3]]; 3] = [&[[0, 2, 3], [1, 4, 3]], &[[1, 4, 3], [0, 2, 3]], &[[2, 3, 1], [4, 3, 0]]];
    for triangles in orders {
        let bounds = Mesh { positions: &corners, triangles, ..Mesh::default() }.validate().unwrap();
        assert!(bounds.min.iter().all(|x| x.to_bits() == 0), "{bounds:?}");
    }
    let grid = Grid { origin: [-0.0; 3], voxel_size: 1.0, resolution: 4 }.checked().unwrap();
    assert!(grid.origin.iter().all(|x| x.to_bits() == 0));
}

#[test]
fn boxes_of_any_size_have_a_radius() {
    for scale in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
        let bounds = Bounds { min: [0.0; 3], max: [3.0 * scale, 4.0 * scale, 0.0] };
        assert!((bounds.radius() / scale - 2.5).abs() < 1e-12, "{scale}: {}", bounds.radius());
    }
}

/// The bricks that one triangle marks, by the code of their place less `offset` voxels on every axis.
fn bricks_of(triangle: [[f64; 3]; 3], resolution: u32, offset: u32, cover: Cover) -> Vec<([u32; 3], u64)> {
    let positions = triangle.map(|p| p.map(|x| x + f64::from(offset)));
    let mesh = Mesh { positions: &positions, triangles: &[[0, 1, 2]], ..Mesh::default() };
    let voxelizer = Voxelizer::new(&mesh, &unit_grid(resolution), cover).unwrap();
    let mut bricks = Vec::new();
    for subtree in 0..voxelizer.subtrees() {
        let first = voxelizer.subtree_code(subtree).0;
        let marks = voxelizer.voxelize::<VoxelizeError>(subtree, |brick| {
            bricks.push((Morton(first | brick.code.0).decode().map(|x| x - offset), brick.mask));
            Ok(())
        });
        marks.unwrap();
    }
    bricks.sort_unstable();
    bricks
}

/// A plane that needs i128 in the middle of the largest grid marks what it marks in a small one.
#[test]
fn v17_wide_planes_are_translated_too() {
    let offset = (1 << 20) - 2000;
    for [a, b, c] in [[30.125, 2000.5, 1500.25], [3830.125, 2.5, 1500.25]] {
        let triangle = [[10.25, 20.5, a], [3900.0, 1000.0, b], [300.75, 3800.0, c]];
        for cover in [Cover::Exact, Cover::Inflated, Cover::Thin] {
            let near = bricks_of(triangle, 1 << 12, 0, cover);
            assert!(near.len() > 100_000);
            assert!(near == bricks_of(triangle, 1 << 21, offset, cover), "{cover:?}");
        }
    }
}

/// Triangles across the largest grid, whose planes are beyond i64: they are sorted into the subtrees that they meet.
#[test]
fn v03_huge_triangles_reach_the_subtrees_that_they_meet() {
    const N: i64 = 1 << 21;
    for seed in 0..40 {
        let mut rng = Rng::new(seed);
        let triangle = [(); 3].map(|()| [(); 3].map(|()| rng.between(0, 256 * N - 1)));
        let shape = of(&[triangle.map(|p| p.map(|x| x as f64 / 256.0))]);
        for (cover, cell) in [(Cover::Exact, Cell::HalfOpen), (Cover::Inflated, Cell::Inflated)] {
            let mesh = shape.mesh();
            let voxelizer = Voxelizer::new(&mesh, &unit_grid(N as u32), cover).unwrap();
            let side = 1i64 << voxelizer.subtree_depth();
            let found: BTreeSet<_> =
                (0..voxelizer.subtrees()).map(|i| voxelizer.subtree_code(i).decode().map(i64::from)).collect();
            let corners = (0..(N / side).pow(3)).map(|i| {
                let n = N / side;
                [i % n * side, i / n % n * side, i / n / n * side]
            });
            let truth: BTreeSet<_> = corners.filter(|&k| clip::meets_cube(&triangle, k, side, cell)).collect();
            assert!(truth.len() >= 4 && found == truth, "seed {seed}, {cover:?}: {found:?} is not {truth:?}");
        }
    }
}

/// The tie of two triangles of one material, equally far from a voxel's centre, goes by the normal, not by their order.
#[test]
fn v12_ties_of_one_material_go_by_the_normal() {
    let across_x = [[1.25, 0.0, 0.0], [1.25, 4.0, 0.0], [1.25, 0.0, 4.0]];
    let across_y = [[0.0, 1.25, 0.0], [0.0, 1.25, 4.0], [4.0, 1.25, 0.0]];
    for triangles in [[across_x, across_y], [across_y, across_x]] {
        let shape = of(&triangles);
        let mesh = shape.mesh();
        let voxelizer = Voxelizer::new(&mesh, &unit_grid(4), Cover::Exact).unwrap();
        let mut shared = 0;
        let marks = voxelizer.voxelize::<VoxelizeError>(0, |brick| {
            voxelizer.owners(0, brick, |bit, Owner { normal, .. }| {
                if brick.triangles.iter().all(|t| t.1 >> bit & 1 == 1) {
                    shared += 1;
                    assert_eq!(normal, [0, 1, 0]);
                }
            });
            Ok(())
        });
        marks.unwrap();
        assert!(shared > 0);
    }
}

/// The owner of every voxel: its place in the grid, material and normal, of triangles with a material each.
fn owners_of(triangles: &[[[f64; 3]; 3]], resolution: u32) -> Vec<([u32; 3], u16, [i64; 3])> {
    let shape = of(triangles);
    let materials: Vec<u16> = (0..triangles.len() as u16).collect();
    let mesh = Mesh { materials: &materials, ..shape.mesh() };
    let voxelizer = Voxelizer::new(&mesh, &unit_grid(resolution), Cover::Exact).unwrap();
    let mut owners = Vec::new();
    for subtree in 0..voxelizer.subtrees() {
        let first = voxelizer.subtree_code(subtree).0;
        let marks = voxelizer.voxelize::<VoxelizeError>(subtree, |brick| {
            voxelizer.owners(subtree, brick, |bit, Owner { material, normal, .. }| {
                owners.push((Morton(first | brick.code.0 | u64::from(bit)).decode(), material, normal));
            });
            Ok(())
        });
        marks.unwrap();
    }
    owners
}

/// A triangle without area owns a voxel only where no other marks it, though its name comes first and it is near.
#[test]
fn v12_triangles_without_area_come_last() {
    let segment = [[0.5, 0.5, 0.5], [6.5, 0.5, 0.5], [3.5, 0.5, 0.5]];
    let far = [[0.0, 0.0, 0.9], [3.75, 0.0, 0.9], [0.0, 3.75, 0.9]];
    let owners = owners_of(&[segment, far], 8);
    for (voxel, material, normal) in &owners {
        let shared = voxel[1] == 0 && voxel[0] < 4;
        assert_eq!(
            (*material, *normal),
            if shared || voxel[1] > 0 { (1, [0, 0, 1]) } else { (0, [0; 3]) },
            "{voxel:?}"
        );
    }
    assert!(owners.iter().filter(|owner| owner.1 == 0).count() == 3 && owners.len() == 13);
}

/// The normal that is kept does not depend on the winding: its first component that is not 0 is positive.
#[test]
fn v12_normals_have_a_canonical_sign() {
    for seed in 0..200 {
        let mut rng = Rng::new(seed);
        let [a, b, c] = [(); 3].map(|()| [(); 3].map(|()| f64::from(rng.below(17) as u32) / 2.0));
        let owners = owners_of(&[[a, b, c]], 8);
        assert_eq!(owners, owners_of(&[[a, c, b]], 8), "seed {seed}");
        let first = owners[0].2.iter().find(|x| **x != 0).copied();
        assert!(first.is_none_or(|x| x > 0), "seed {seed}: {:?}", owners[0]);
    }
}

/// A triangle that comes to a grown voxel's edge and no further meets it: the inflated box is closed.
#[test]
fn v18_inflated_voxels_are_closed() {
    for seed in 0..200 {
        let mut rng = Rng::new(seed);
        // In the plane x + y = 4 + 1/256, which touches the edges that are 1/512 beyond x = 1, 2, 3 and y = 3, 2, 1; seen
        // along any axis.
        let turns = rng.below(3) as usize;
        let triangle = [(); 3].map(|()| {
            let (x, z) = (rng.between(0, 1024), rng.between(0, 1024));
            let mut p = [x, 1025 - x, z].map(|x| x as f64 / 256.0);
            p.rotate_left(turns);
            p
        });
        if triangle.iter().flatten().all(|x| (0.0..=4.0).contains(x)) {
            check(&of(&[triangle]), &unit_grid(8), &format!("seed {seed}"));
        }
    }
}

/// Two triangles of one plane are equally far from every voxel: the name decides, whatever their size.
#[test]
fn v12_owners_of_coplanar_triangles_go_by_name() {
    let mut rng = Rng::new(5);
    let mut both = 0;
    for _ in 0..40 {
        let u = [(); 3].map(|()| rng.between(1, 9));
        let v = [rng.between(1, 9), -rng.between(1, 9), rng.between(1, 9)];
        let at = |a: i64, b: i64| -> [f64; 3] { core::array::from_fn(|i| (30 + a * u[i] + b * v[i]) as f64) };
        let positions = [at(-1, -1), at(2, 0), at(0, 2), at(-1, 0), at(2, -1), at(1, 1)];
        if positions.iter().flatten().any(|x| !(0.0..=64.0).contains(x)) {
            continue;
        }
        let mesh =
            Mesh { positions: &positions, triangles: &[[0, 1, 2], [3, 4, 5]], materials: &[1, 0], ..Mesh::default() };
        let voxelizer = Voxelizer::new(&mesh, &unit_grid(64), Cover::Exact).unwrap();
        for subtree in 0..voxelizer.subtrees() {
            let marks = voxelizer.voxelize::<VoxelizeError>(subtree, |brick| {
                voxelizer.owners(subtree, brick, |bit, Owner { material, .. }| {
                    if brick.triangles.iter().filter(|t| t.1 >> bit & 1 == 1).count() == 2 {
                        both += 1;
                        assert_eq!(material, 0, "{positions:?}");
                    }
                });
                Ok(())
            });
            marks.unwrap();
        }
    }
    assert!(both > 1000, "{both} shared voxels are too few to say anything");
}
