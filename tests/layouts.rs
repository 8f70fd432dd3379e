//! Every layout of the same voxels answers rays, normals and walks alike, bit for bit, with its own top grid and
//! without.

use voxdag::build::{BuildError, DagBuilder};
use voxdag::layout::AnyGeometry;
use voxdag::materials::Single;
use voxdag::normal::{NormalKind, normal};
use voxdag::rank::{MoxelDagBuf, OffsetsBuf};
use voxdag::ssvdag::SsvdagBuf;
use voxdag::svo::{Svo, SvoBuf};
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::{Dag, Geometry, Morton};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::Implicit;

/// Compares a layout with the DAG that it was made from.
fn same(what: &str, dag: Dag<'_>, other: impl Geometry, queries: &[Query]) {
    assert_eq!((other.depth(), other.is_empty()), (dag.depth(), dag.is_empty()), "{what}");
    let plain = Tracer::new(dag);
    let mut tracers = vec![(Tracer::new(other), "alone")];
    let tops: Vec<TopBuf> = (0..3).map(|bits| TopBuf::new(&other, bits).unwrap()).collect();
    for top in &tops {
        let tracer = Tracer::with_top(other, top.as_top()).expect("the grid is this geometry's");
        tracers.push((tracer, "with a top grid"));
    }
    let mut hits = 0;
    for query in queries {
        let truth = plain.trace_counted(Arithmetic::Exact, query);
        for (tracer, how) in &tracers {
            let found = tracer.trace(Arithmetic::Exact, query);
            assert_eq!(found, truth.0, "{what}, {how}: {query:?}");
        }
        assert_eq!(tracers[0].0.trace_counted(Arithmetic::Exact, query), truth, "{what}: {query:?}");
        let Some(hit) = truth.0 else { continue };
        hits += 1;
        for kind in [NormalKind::Gradient, NormalKind::Plane2] {
            let expected = normal(&plain, Single(0), &hit, query.dir, kind);
            assert_eq!(normal(&tracers[0].0, Single(0), &hit, query.dir, kind), expected, "{what}: {query:?}");
        }
    }
    assert!(dag.is_empty() || hits > 0 || queries.is_empty(), "{what}: no ray hit anything");
}

/// Rays that aim at voxels, from everywhere around.
fn queries(dag: Dag<'_>, random: &mut Rng) -> Vec<Query> {
    let size = f64::from(1u32 << dag.depth());
    let targets: Vec<Morton> = dag.voxels().take(5000).collect();
    let aim = |random: &mut Rng| match targets.len() {
        0 => [(); 3].map(|()| random.uniform(0.0, size)),
        n => targets[random.below(n as u64) as usize].decode().map(|k| f64::from(k) + random.unit()),
    };
    (0..60)
        .map(|i| {
            let origin = [(); 3].map(|()| random.uniform(-0.5 * size, 1.5 * size));
            let target = aim(random);
            let dir = core::array::from_fn(|k| target[k] - origin[k]);
            Query { min_level: (i % 5) as u8 / 2, ..Query::new(origin, dir) }
        })
        .collect()
}

/// Whatever is asked for, a node is one if and only if a walk can meet it.
#[test]
fn no_question_for_a_node_can_panic() {
    for depth in [0, 1, 3, 4] {
        let words = VoxelSet::new([[0; 3], [(1 << depth) - 1; 3]]).words(depth);
        let dag = Dag::new(&words).unwrap();
        let (offsets, moxels) = (OffsetsBuf::build(&dag).unwrap(), MoxelDagBuf::build(&dag).unwrap());
        let (svo, ssvdag) = (SvoBuf::build(&dag, 1000).unwrap(), SsvdagBuf::build(&dag).unwrap());
        let all: [AnyGeometry<'_>; 5] = [
            AnyGeometry::Dag(dag),
            AnyGeometry::Offsets(offsets.as_offsets()),
            AnyGeometry::MoxelDag(moxels.as_moxel_dag()),
            AnyGeometry::Svo(svo.as_svo()),
            AnyGeometry::Ssvdag(ssvdag.ssvdag()),
        ];
        for geometry in all {
            let top = depth.max(2);
            assert!(geometry.is_node(geometry.root(), top), "{geometry:?}");
            for level in (0..2).chain(top + 1..=u8::MAX) {
                let numbers = (0..200).chain([1 << 31, u32::MAX]);
                assert!(!numbers.into_iter().any(|n| geometry.is_node(n, level)), "{level}: {geometry:?}");
            }
        }
    }
}

fn all_layouts(what: &str, words: &[u32], random: &mut Rng, octree: bool) {
    let dag = Dag::new(words).unwrap();
    let queries = queries(dag, random);
    let offsets = OffsetsBuf::build(&dag).unwrap();
    same(&format!("{what}: offsets"), dag, offsets.as_offsets(), &queries);
    let moxels = MoxelDagBuf::build(&dag).unwrap();
    same(&format!("{what}: moxel DAG"), dag, moxels.as_moxel_dag(), &queries);
    if octree {
        let svo = SvoBuf::build(&dag, 1 << 22).unwrap();
        same(&format!("{what}: octree"), dag, svo.as_svo(), &queries);
        assert!(svo.as_svo().bricks().eq(dag.bricks()), "{what}: bricks of the octree");
        assert_eq!(svo.as_svo().words().len() as u64, Svo::words_for(&dag.stats().unwrap()), "{what}");
        assert!(offsets.as_offsets().bricks().eq(dag.bricks()), "{what}: bricks with offsets");
        assert!(moxels.as_moxel_dag().bricks().eq(dag.bricks()), "{what}: bricks of the moxel DAG");
    }
}

#[test]
fn random_voxels_of_small_depths() {
    for seed in 0..60 {
        let mut random = Rng::new(seed);
        let depth = (seed % 9) as u8;
        let most = [0, 1, 60, 3000][(seed / 9 % 4) as usize];
        let voxels = (0..most).map(|_| core::array::from_fn(|_| random.below(1 << depth) as u32));
        let set = VoxelSet::new(voxels.collect::<Vec<[u32; 3]>>());
        let mut builder = DagBuilder::new(depth).unwrap();
        for (code, mask) in set.bricks() {
            builder.push(Morton(code), mask).unwrap();
        }
        let built = builder.finish().unwrap();
        all_layouts(&format!("seed {seed}"), built.words(), &mut random, true);
    }
}

#[test]
fn walls_and_dust_of_large_depths() {
    let mut random = Rng::new(1);
    for (name, shape) in [
        ("wall", Implicit::Wall { axis: 1, lo: 700_000, hi: 700_003 }),
        ("thick wall", Implicit::Wall { axis: 0, lo: 5, hi: (1 << 21) - 3 }),
        ("diagonal", Implicit::Diagonal { lo: (1 << 21) + 1, hi: (1 << 21) + 3 }),
        ("dust", Implicit::Dust { at: [3, 0, 2] }),
    ] {
        for depth in [21, 20, 12] {
            let words = shape.words(depth);
            if words.len() > 24 {
                all_layouts(&format!("{name}, depth {depth}"), &words, &mut random, false);
            }
        }
    }
}

#[test]
fn octrees_over_the_limit_are_refused_before_memory_is_taken() {
    // 2^42 voxels and more: nothing could hold the octree, the DAG is small.
    for shape in [Implicit::Wall { axis: 2, lo: 9, hi: 10 }, Implicit::Dust { at: [0, 1, 2] }] {
        let words = shape.words(21);
        let needed = Svo::words_for(&Dag::new(&words).unwrap().stats().unwrap());
        assert!(needed > 1 << 38);
        let error = SvoBuf::build(&Dag::new(&words).unwrap(), u32::MAX).unwrap_err();
        assert_eq!(error, BuildError::Words { needed });
    }
    let words = Implicit::Wall { axis: 2, lo: 9, hi: 10 }.words(6);
    let dag = Dag::new(&words).unwrap();
    // 16^2 bricks, 8^2 and 4^2 nodes and so on, two words each.
    let needed = 24 + 2 * (256 + 64 + 16 + 4 + 1);
    assert_eq!(SvoBuf::build(&dag, needed).unwrap().as_svo().words().len(), needed as usize);
    assert_eq!(SvoBuf::build(&dag, needed - 1).unwrap_err(), BuildError::Words { needed: needed.into() });
}

#[test]
fn the_top_grid_of_another_layout_leads_to_nothing_worse_than_wrong_answers() {
    let words = Implicit::Diagonal { lo: 60, hi: 70 }.words(6);
    let dag = Dag::new(&words).unwrap();
    let (offsets, moxels) = (OffsetsBuf::build(&dag).unwrap(), MoxelDagBuf::build(&dag).unwrap());
    let svo = SvoBuf::build(&dag, 1 << 20).unwrap();
    let tops = [
        TopBuf::new(&dag, 2).unwrap(),
        TopBuf::new(&offsets.as_offsets(), 2).unwrap(),
        TopBuf::new(&moxels.as_moxel_dag(), 2).unwrap(),
        TopBuf::new(&svo.as_svo(), 2).unwrap(),
    ];
    let queries = queries(dag, &mut Rng::new(5));
    // Each takes its own grid, and no other's: their numbers of nodes are not the same ones.
    assert_eq!(traces(dag, &tops, &queries), [true, false, false, false]);
    assert_eq!(traces(offsets.as_offsets(), &tops, &queries), [false, true, false, false]);
    assert_eq!(traces(moxels.as_moxel_dag(), &tops, &queries), [false, false, true, false]);
    assert_eq!(traces(svo.as_svo(), &tops, &queries), [false, false, false, true]);
}

/// Which top grids a geometry takes; rays through them end, whatever they hit.
fn traces(geometry: impl Geometry, tops: &[TopBuf; 4], queries: &[Query]) -> [bool; 4] {
    tops.each_ref().map(|top| {
        let Some(tracer) = Tracer::with_top(geometry, top.as_top()) else { return false };
        queries
            .iter()
            .for_each(|query| assert!(tracer.trace(Arithmetic::Exact, query).is_none_or(|hit| hit.level <= 6)));
        true
    })
}
