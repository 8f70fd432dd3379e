//! Laws of levels of detail: a coarser scene is `{v >> k}` of the voxels v, its rays hit what `Query::min_level` hits in
//! the finer one, and its materials are those of each cube's first voxel.

use voxdag::file::{self, Parts};
use voxdag::grid::{Bounds, GridError, UpAxis};
use voxdag::layout::AnyGeometry;
use voxdag::lod::Lod;
use voxdag::materials::{AnyMaterials, Single};
use voxdag::ssvdag::SsvdagBuf;
use voxdag::svo::SvoBuf;
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::wide::WideBuf;
use voxdag::{Dag, Grid, Materials, Morton};
use voxdag_oracle::octree::{VoxelSet, interleave};
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::Implicit;

/// A material and a normal that depend on the voxel alone.
#[derive(Clone, Copy)]
struct ByCode;

impl Materials for ByCode {
    fn id(&self, voxel: Morton) -> u16 {
        (voxel.0.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 48) as u16
    }

    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        Some(voxel.decode().map(|x| x as f32))
    }
}

/// Voxels of a cube of `2^depth`: none, one, some or many, half of them in a corner of their own.
fn scattered(random: &mut Rng, depth: u8) -> Vec<[u32; 3]> {
    let most = [0, 1, 40, 600][random.below(4) as usize];
    let side = 1u64 << depth;
    (0..most)
        .map(|_| {
            let side = if random.below(2) == 0 { side } else { side.div_ceil(4) };
            [(); 3].map(|()| random.below(side) as u32)
        })
        .collect()
}

#[test]
fn its_voxels_are_those_of_the_finer_one_shifted() {
    for seed in 0..120 {
        let mut random = Rng::new(seed);
        let depth = (seed % 10) as u8;
        let voxels = scattered(&mut random, depth);
        let words = VoxelSet::new(voxels.iter().copied()).words(depth);
        let dag = Dag::new(&words).unwrap();
        let (ssvdag, svo) = (SsvdagBuf::build(&dag).unwrap(), SvoBuf::build(&dag, 1 << 24).unwrap());
        let wide = WideBuf::new(&dag, usize::MAX).unwrap();
        for level in 0..=depth {
            // The twin knows how words are laid out, and is asked for the voxels that the law names.
            let coarse = VoxelSet::new(voxels.iter().map(|v| v.map(|x| x >> level)));
            let expected = coarse.words(depth - level);
            let built = |what, found: voxdag::build::DagBuf| {
                assert_eq!(found.words(), expected, "seed {seed}, level {level} of {depth}, {what}");
            };
            let lod = Lod::new(dag, level).unwrap();
            built("DAG", lod.build(u32::MAX).unwrap());
            built("SSVDAG", Lod::new(ssvdag.ssvdag(), level).unwrap().build(u32::MAX).unwrap());
            built("octree", Lod::new(svo.as_svo(), level).unwrap().build(u32::MAX).unwrap());
            built("wide tree", Lod::new(wide.as_wide(), level).unwrap().build(u32::MAX).unwrap());
            assert!(
                coarse.codes().is_empty() || lod.build(expected.len() as u32 - 1).is_err(),
                "seed {seed}: more words than the limit"
            );

            // First voxels: of all cubes that hold one, and of random places, some of them outside.
            let side = 1u64 << (depth - level);
            let places = (0..100).map(|_| [(); 3].map(|()| random.below(side + 1) as u32)).map(interleave);
            for cube in coarse.codes().iter().copied().chain(places).map(Morton) {
                let first = voxels.iter().map(|&v| interleave(v)).filter(|code| code >> (3 * level) == cube.0).min();
                let what = format!("seed {seed}, level {level} of {depth}, {cube:?}");
                assert_eq!(lod.first(cube), first.map(Morton), "{what}");
                let materials = lod.materials(ByCode);
                assert_eq!(materials.id(cube), first.map_or(0, |first| ByCode.id(Morton(first))), "{what}");
                assert_eq!(materials.normal(cube), first.and_then(|first| ByCode.normal(Morton(first))), "{what}");
            }
        }
        assert!((depth + 1..=u8::MAX).all(|level| Lod::new(dag, level).is_none()), "{depth}");
    }
}

#[test]
fn the_largest_cubes_have_every_level() {
    for shape in
        [Implicit::Wall { axis: 1, lo: 1_234_567, hi: 1_234_570 }, Implicit::Diagonal { lo: 999_999, hi: 1_000_001 }]
    {
        let words = shape.words(21);
        let dag = Dag::new(&words).unwrap();
        let mut random = Rng::new(21);
        for level in [1, 2, 3, 10, 18, 19, 20, 21] {
            let lod = Lod::new(dag, level).unwrap();
            // The octree has too many cubes of the lower levels to walk over all of them.
            let coarse = (level >= 10).then(|| lod.build(u32::MAX).unwrap());
            let mut filled = 0;
            for _ in 0..500 {
                let mut voxel = [(); 3].map(|()| random.below(1 << 21) as u32);
                match shape {
                    Implicit::Wall { .. } => voxel[1] = 1_234_560 + random.below(20) as u32,
                    _ => voxel[2] = 1_000_000u32.saturating_sub(voxel[0] + voxel[1]),
                }
                let cube = voxel.map(|x| x >> level);
                let any = shape.any(level, cube.map(|x| x << level));
                let first = lod.first(Morton::encode(cube).unwrap());
                assert_eq!(first.is_some(), any, "level {level}: {voxel:?}");
                if let Some(first) = first.map(Morton::decode) {
                    assert!(shape.filled(first) && first.map(|x| x >> level) == cube, "level {level}: {first:?}");
                    filled += 1;
                }
                if let Some(coarse) = &coarse {
                    assert_eq!(coarse.dag().contains(Morton::encode(cube).unwrap()), any, "level {level}: {voxel:?}");
                }
            }
            assert!(filled > 10, "{shape:?}, level {level}: {filled} cubes are too few to say anything");
        }
    }
}

#[test]
fn its_rays_hit_what_coarser_queries_hit() {
    let mut hits = 0;
    for seed in 0..200 {
        let mut random = Rng::new(seed);
        let depth = 1 + (seed % 9) as u8;
        let voxels = scattered(&mut random, depth);
        let words = VoxelSet::new(voxels.iter().copied()).words(depth);
        let dag = Dag::new(&words).unwrap();
        let top = TopBuf::new(&dag, 3).unwrap();
        let fine = Tracer::with_top(dag, top.as_top()).unwrap();
        let level = random.below(u64::from(depth) + 1) as u8;
        let lod = Lod::new(dag, level).unwrap();
        let (coarse, materials) = (lod.build(u32::MAX).unwrap(), lod.materials(ByCode));
        let tracer = Tracer::new(coarse.dag());

        // Rays from the world, so that both grids have a part in it.
        let grid =
            Grid { origin: [(); 3].map(|()| random.uniform(-9.0, 9.0)), voxel_size: 0.3, resolution: 1 << depth };
        let coarse_grid = lod.grid(&grid).unwrap();
        for _ in 0..60 {
            let size = f64::from(1u32 << depth);
            let eye = grid.to_world([(); 3].map(|()| random.uniform(-0.5 * size, 1.5 * size)));
            let target = match voxels.len() {
                0 => [(); 3].map(|()| random.uniform(0.0, size)),
                n => voxels[random.below(n as u64) as usize].map(|k| f64::from(k) + random.unit()),
            };
            let target = grid.to_world(target);
            // Directions are the world's; t is in units of them.
            let dir: [f64; 3] = core::array::from_fn(|i| target[i] - eye[i]);
            let query = |grid: &Grid| Query::new(grid.to_grid(eye), dir.map(|x| x / grid.voxel_size));
            let found = tracer.trace(Arithmetic::Exact, &query(&coarse_grid));
            let truth = fine.trace(Arithmetic::Exact, &Query { min_level: level, ..query(&grid) });
            let what = format!("seed {seed}, level {level} of {depth}\n{found:?}\n{truth:?}");
            assert_eq!(found.is_some(), truth.is_some(), "{what}");
            let (Some(found), Some(truth)) = (found, truth) else { continue };
            hits += 1;
            let shifted = |voxel: Morton| Morton(voxel.0 >> (3 * level));
            assert_eq!((found.voxel, found.face), (shifted(truth.voxel), truth.face), "{what}");
            assert_eq!(found.from, truth.from.map(shifted), "{what}");
            // Sizes differ by a power of two: the same digits.
            assert_eq!(found.t.to_bits(), truth.t.to_bits(), "{what}");
            let first = voxels.iter().map(|&v| interleave(v)).filter(|&v| shifted(Morton(v)) == found.voxel).min();
            assert_eq!(materials.id(found.voxel), ByCode.id(Morton(first.unwrap())), "{what}");
        }
    }
    assert!(hits > 3000, "{hits} hits are too few to say anything");
}

#[test]
fn grids_have_as_many_voxels_as_cover_the_finer_one() {
    let words = VoxelSet::new([[999; 3]]).words(10);
    let dag = Dag::new(&words).unwrap();
    let grid = Grid { origin: [1.0, -2.0, 3.0], voxel_size: 0.75, resolution: 1000 };
    for (level, resolution) in [(0, 1000), (1, 500), (3, 125), (4, 63), (9, 2), (10, 1)] {
        let lod = Lod::new(dag, level).unwrap();
        let coarse = lod.grid(&grid).unwrap();
        assert_eq!(coarse, Grid { voxel_size: 0.75 * f64::from(1u32 << level), resolution, ..grid });
        assert_eq!(coarse.depth(), lod.build(u32::MAX).unwrap().dag().depth(), "level {level}");
    }
    let huge = Grid { voxel_size: 1e307, ..grid };
    assert!(matches!(Lod::new(dag, 10).unwrap().grid(&huge), Err(GridError::VoxelSize { .. })));
}

/// What is derived is as good as what was built: a file of it loads.
#[test]
fn a_coarser_scene_is_a_scene() {
    let words = Implicit::Shell { centre: [100; 3], inner: 60, outer: 64 }.words(7);
    let dag = Dag::new(&words).unwrap();
    let lod = Lod::new(dag, 2).unwrap();
    let coarse = lod.build(u32::MAX).unwrap();
    let grid = lod.grid(&Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 100 }).unwrap();
    let parts = Parts {
        grid,
        bounds: Bounds { min: [0.0; 3], max: [100.0; 3] },
        up: UpAxis::Y,
        metres_per_unit: 0.0,
        geometry: AnyGeometry::Dag(coarse.dag()),
        voxel_materials: AnyMaterials::Single(Single(0)),
        colors: None,
        materials: &[voxdag::Material::GREY],
        names: &["grey"],
    };
    let mut file = vec![0; parts.head_len() as usize];
    parts.write_head(&mut file).unwrap();
    parts.body().into_iter().for_each(|words| file.extend(words));
    assert!(file::read(&file).is_ok_and(|scene| scene.grid.resolution == 25));
}
