//! Many rays at once: tiles and streams in lanes against rays one by one, at every level that the machine has.
//!
//! Each ray of the catalogue is traced by packets, too, alone: tests/rays.rs. Here they go together.

use voxdag::build::DagBuilder;
use voxdag::simd::Level;
use voxdag::trace::{Arithmetic, Columns, Hit, Query, Tile, Top, TopBuf, Tracer};
use voxdag::wide::WideBuf;
use voxdag::{Dag, Geometry, Morton};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;

/// Voxels in clumps, so that rays meet empty space of all sizes.
fn clumps(depth: u8, rng: &mut Rng) -> VoxelSet {
    let n = 1u64 << depth;
    let mut voxels = Vec::new();
    for _ in 0..rng.between(1, 12) {
        let (corner, side) = ([(); 3].map(|()| rng.below(n)), 1 + rng.below((n / 3).clamp(1, 40)));
        let density = 1 + rng.below(4);
        for _ in 0..(side * side * density).min(3000) {
            voxels.push(corner.map(|c| (c + rng.below(side)).min(n - 1) as u32));
        }
    }
    VoxelSet::new(voxels)
}

/// Rays of all kinds, some with ends, starts, and coarser levels.
fn rays(depth: u8, targets: &[u64], rng: &mut Rng) -> Vec<Query> {
    let n = f64::from(1u32 << depth);
    let ray = |rng: &mut Rng| {
        let target = Morton(rng.pick(targets)).decode().map(f64::from);
        let at: [f64; 3] = target.map(|k| {
            let inside = rng.unit();
            k + rng.pick(&[0.0, 0.5, 1.0, inside, inside])
        });
        let origin = match rng.below(4) {
            0 => at.map(|x| x + rng.uniform(-3.0, 3.0)),
            1 => at.map(|x| x + rng.between(-9, 9) as f64),
            2 => [(); 3].map(|()| rng.uniform(-n, 2.0 * n)),
            _ => at.map(|x| x + n * rng.pick(&[1e3, -1e6]) * rng.unit()),
        };
        let mut dir: [f64; 3] = core::array::from_fn(|i| at[i] - origin[i]);
        match rng.below(6) {
            0 => dir[rng.below(3) as usize] = 0.0,
            1 => dir = rng.direction(),
            2 => {
                let length = rng.spread(-30, 30);
                dir = dir.map(|x| x * length);
            }
            _ => {}
        }
        let mut query = Query::new(origin, dir);
        // Ends that are none, starts off the line, in what is filled, outside the cube, and with more bits than a code has.
        let odd = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -5e-324, -1e300];
        match rng.below(14) {
            8 => query.t_min = rng.pick(&odd),
            9 => query.t_max = rng.pick(&odd),
            10 => query.start = Some(Morton(rng.pick(targets))),
            11 => query.start = Some(Morton(rng.pick(targets) ^ rng.below(8) | rng.below(2) << 63)),
            12 => query.start = Some(Morton(rng.below(1 << 63))),
            13 => {
                let axis = rng.below(3) as usize;
                (query.origin[axis], query.dir[axis]) = (rng.pick(&odd), 0.0);
                query.start = (rng.below(2) == 0).then(|| Morton(rng.pick(targets)));
            }
            0 => query.t_max = rng.unit(),
            1 => (query.t_min, query.t_max) = (rng.uniform(-2.0, 1.0), rng.uniform(0.5, 3.0)),
            2 => query.min_level = rng.below(30) as u8,
            3 => query.dir[0] = rng.pick(&[f64::NAN, f64::INFINITY, 1e-300, 1e300, 5e-324]),
            _ => {}
        }
        query
    };
    (0..700).map(|_| ray(rng)).collect()
}

/// Rays that leave the hits of others, from the voxels before them: along the wall, out of it, and into it.
fn leaving(queries: &[Query], hits: &[Option<Hit>], rng: &mut Rng) -> Vec<Query> {
    let left = queries.iter().zip(hits).filter_map(|(query, hit)| {
        let hit = hit.filter(|hit| hit.from.is_some() && hit.level == 0)?;
        let origin: [f64; 3] = core::array::from_fn(|i| query.origin[i] + query.dir[i] * hit.t);
        let mut dir = rng.direction();
        if rng.below(4) == 0 {
            dir = [(); 3].map(|()| rng.between(-1, 1) as f64);
        }
        let t_max = rng.pick(&[f64::INFINITY, 1.0, 50.0]);
        Some(Query { start: hit.from, t_max, ..Query::new(origin, dir) })
    });
    left.collect()
}

/// Packets of all levels answer these rays as the tracer does that takes them one by one.
fn check<G: Geometry>(tracer: &Tracer<'_, G>, queries: &[Query], what: &str) -> Vec<Option<Hit>> {
    let one_by_one: Vec<_> = queries.iter().map(|query| tracer.trace(Arithmetic::Exact, query)).collect();
    let mut by_f32 = None;
    for level in Level::all() {
        let packets = tracer.with_level(Some(level));
        assert_eq!(packets.packet_level().map(Level::name), Some(level.name()), "{what}: no packets");
        let mut hits = vec![None; queries.len()];
        packets.trace_many(Arithmetic::Exact, queries, &mut hits);
        let mut blocked = vec![false; queries.len()];
        packets.occluded_many(Arithmetic::Exact, queries, &mut blocked);
        for (i, query) in queries.iter().enumerate() {
            assert_eq!(hits[i], one_by_one[i], "{what}, {}, ray {i}: {query:?}", level.name());
            let bits = |hit: Option<Hit>| hit.map(|hit| hit.t.to_bits());
            assert_eq!(bits(hits[i]), bits(one_by_one[i]), "{what}, {}, ray {i}: {query:?}", level.name());
            assert_eq!(blocked[i], one_by_one[i].is_some(), "{what}, {}, ray {i}: {query:?}", level.name());
        }
        // By f32 alone they end, find mostly the same, and at every level alike.
        packets.trace_many(Arithmetic::F32, queries, &mut hits);
        assert_eq!(*by_f32.get_or_insert_with(|| hits.clone()), hits, "{what}, {}", level.name());
        let wrong = hits.iter().zip(&one_by_one).filter(|(a, b)| a != b).count();
        assert!(wrong * 5 <= queries.len(), "{what}, {}: {wrong} of {} wrong", level.name(), queries.len());
    }
    one_by_one
}

#[test]
fn streams_answer_as_rays_one_by_one() {
    let mut hits = 0;
    for seed in 0..24u64 {
        let mut rng = Rng::new(seed);
        let depth = 2 + (seed % 9) as u8;
        let set = clumps(depth, &mut rng);
        let words = set.words(depth);
        let dag = Dag::new(&words).unwrap();
        let wide = WideBuf::new(&dag, usize::MAX).unwrap();
        let queries = rays(depth, set.codes(), &mut rng);
        for bits in 0..=Top::most_bits(&dag).min(6) {
            if !(depth - bits).is_multiple_of(2) {
                continue;
            }
            let what = format!("seed {seed}, depth {depth}, {bits} bits");
            let top = TopBuf::new(&wide.as_wide(), bits).unwrap();
            let tracer = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap();
            let found = check(&tracer, &queries, &what);
            // From a start off the line rays drift back by ways that may depend on the grid.
            for (query, found) in queries.iter().zip(&found).filter(|(query, _)| query.start.is_none()) {
                assert_eq!(*found, dag.trace(query), "{what}: the wide tree's own answer to {query:?}");
            }
            hits += found.iter().flatten().count();
            check(&tracer, &leaving(&queries, &found, &mut rng), &format!("{what}, leaving"));
        }
    }
    assert!(hits > 10_000, "{hits} hits are too few to say anything");
}

#[test]
fn columns_answer_as_the_same_rays_in_a_list() {
    for seed in 0..12u64 {
        let mut rng = Rng::new(200 + seed);
        let depth = 3 + (seed % 6) as u8;
        let set = clumps(depth, &mut rng);
        let words = set.words(depth);
        let dag = Dag::new(&words).unwrap();
        let wide = WideBuf::new(&dag, usize::MAX).unwrap();
        let top = TopBuf::new(&wide.as_wide(), Top::bits_for_packets(&wide.as_wide(), 4)).unwrap();
        let bounded = seed % 2 == 0;
        let plain = |query: Query| Query { t_max: query.t_max, ..Query::new(query.origin, query.dir) };
        let mut queries: Vec<_> = rays(depth, set.codes(), &mut rng).into_iter().map(plain).collect();
        if !bounded {
            queries.iter_mut().for_each(|query| query.t_max = f64::INFINITY);
        }
        let column = |of: &dyn Fn(&Query) -> f64| queries.iter().map(of).collect::<Vec<_>>();
        let origin: [_; 3] = core::array::from_fn(|i| column(&|query| query.origin[i]));
        let dir: [_; 3] = core::array::from_fn(|i| column(&|query| query.dir[i]));
        let t_max = column(&|query| query.t_max);
        let mut all = Columns {
            origin: origin.each_ref().map(|column| &column[..]),
            dir: dir.each_ref().map(|column| &column[..]),
            t_max: bounded.then_some(&t_max),
        };
        // The shortest column says how many rays there are; what lies behind it is left alone.
        let short = queries.len() - 1 - seed as usize;
        all.dir[seed as usize % 3] = &dir[seed as usize % 3][..short];
        assert_eq!(all.len(), short);
        let one_by_one = Tracer::new(dag);
        let packets = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap();
        let expected: Vec<_> = queries.iter().map(|query| one_by_one.trace(Arithmetic::Exact, query)).collect();
        let check = |what: &str, hits: &[Option<Hit>], blocked: &[bool]| {
            for i in 0..short {
                assert_eq!(hits[i], expected[i], "seed {seed}, {what}, ray {i}: {:?}", queries[i]);
                assert_eq!(blocked[i], expected[i].is_some(), "seed {seed}, {what}, ray {i}: {:?}", queries[i]);
            }
            assert!(
                hits[short..].iter().all(Option::is_none) && !blocked[short..].contains(&true),
                "seed {seed}, {what}"
            );
        };
        let (mut hits, mut blocked) = (vec![None; queries.len()], vec![false; queries.len()]);
        one_by_one.trace_columns(Arithmetic::Exact, &all, &mut hits);
        one_by_one.occluded_columns(Arithmetic::Exact, &all, &mut blocked);
        check("alone", &hits, &blocked);
        for level in Level::all() {
            let (mut hits, mut blocked) = (vec![None; queries.len()], vec![false; queries.len()]);
            let packets = packets.with_level(Some(level));
            packets.trace_columns(Arithmetic::Exact, &all, &mut hits);
            packets.occluded_columns(Arithmetic::Exact, &all, &mut blocked);
            check(level.name(), &hits, &blocked);
        }
    }
}

#[test]
fn tiles_answer_as_rays_one_by_one() {
    for seed in 0..12u64 {
        let mut rng = Rng::new(100 + seed);
        let depth = 4 + (seed % 5) as u8;
        let set = clumps(depth, &mut rng);
        let words = set.words(depth);
        let wide = WideBuf::new(&Dag::new(&words).unwrap(), usize::MAX).unwrap();
        let top = TopBuf::new(&wide.as_wide(), Top::bits_for_packets(&wide.as_wide(), 4)).unwrap();
        let n = f64::from(1u32 << depth);
        // Looking along an axis, also: the middle columns run within planes and through edges.
        let origin = match seed % 3 {
            0 => [n / 2.0, n / 2.0, -n],
            1 => [n / 2.0 + 0.25, n / 3.0, n / 2.0],
            _ => [(); 3].map(|()| rng.uniform(-n, 2.0 * n)),
        };
        let places: Vec<[f64; 2]> = (0..600).map(|i| [f64::from(i % 25), f64::from(i / 25)]).collect();
        let (dx, dy) = ([0.0625, 0.0, 0.0], [0.0, 0.0625, 0.0]);
        let tile = Tile { origin, corner: [-0.75, -0.75, 1.0], dx, dy, places: &places };
        let queries: Vec<_> = places.iter().map(|place| Query::new(origin, tile.direction(*place))).collect();
        let tracer = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap();
        let expected = check(&tracer, &queries, &format!("seed {seed}"));
        for level in Level::all() {
            let mut hits = vec![None; places.len()];
            tracer.with_level(Some(level)).trace_tile(Arithmetic::Exact, &tile, &mut hits);
            assert_eq!(hits, expected, "seed {seed}, {}", level.name());
        }
    }
}

#[test]
fn slices_of_any_length_are_filled_as_far_as_both_reach() {
    let mut builder = DagBuilder::new(4).unwrap();
    builder.push(Morton(0), 1).unwrap();
    let built = builder.finish().unwrap();
    let wide = WideBuf::new(&built.dag(), usize::MAX).unwrap();
    let top = TopBuf::new(&wide.as_wide(), 2).unwrap();
    let query = Query::new([0.5, 0.5, 9.0], [0.0, 0.0, -1.0]);
    for level in Level::all() {
        let tracer = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap().with_level(Some(level));
        let found = tracer.trace(Arithmetic::Exact, &query);
        assert!(found.is_some());
        for (rays, room) in [(0, 3), (3, 0), (1, 2), (2, 1), (255, 255), (256, 300), (257, 256), (513, 600)] {
            let queries = vec![query; rays];
            let (mut hits, mut blocked) = (vec![None; room], vec![false; room]);
            tracer.trace_many(Arithmetic::Exact, &queries, &mut hits);
            tracer.occluded_many(Arithmetic::Exact, &queries, &mut blocked);
            let filled = rays.min(room);
            assert!(hits[..filled].iter().all(|hit| *hit == found) && hits[filled..].iter().all(Option::is_none));
            assert!(blocked[..filled].iter().all(|b| *b) && !blocked[filled..].contains(&true));
        }
    }
}

#[test]
fn without_a_wide_tree_or_an_even_grid_rays_go_one_by_one() {
    let words = VoxelSet::new([[1, 2, 3], [40, 50, 60]]).words(6);
    let dag = Dag::new(&words).unwrap();
    let wide = WideBuf::new(&dag, usize::MAX).unwrap();
    let best = Level::best();
    assert!(Tracer::new(dag).with_level(best).packet_level().is_none());
    assert!(Tracer::new(wide.as_wide()).with_level(best).packet_level().is_none());
    for bits in 0..=4 {
        let top = TopBuf::new(&wide.as_wide(), bits).unwrap();
        let tracer = Tracer::with_top(wide.as_wide(), top.as_top()).unwrap().with_level(best);
        assert_eq!(tracer.packet_level().is_some(), best.is_some() && bits % 2 == 0, "{bits} bits");
        let queries = [Query::new([1.5, 2.5, -4.0], [0.0, 0.0, 1.0])];
        let mut hits = [None];
        tracer.trace_many(Arithmetic::Exact, &queries, &mut hits);
        assert_eq!(hits[0], dag.trace(&queries[0]));
    }
    // The grid of another scene with as many nodes passes, and leads to wrong answers, but to nothing worse.
    let [one, other] = [[1, 2, 3], [40, 50, 60]].map(|voxel| {
        let words = VoxelSet::new([voxel]).words(6);
        WideBuf::new(&Dag::new(&words).unwrap(), usize::MAX).unwrap()
    });
    let top = TopBuf::new(&other.as_wide(), 2).unwrap();
    let tracer = Tracer::with_top(one.as_wide(), top.as_top()).expect("as many nodes");
    let queries = rays(6, &[0, 77, 4096], &mut Rng::new(5));
    let (mut hits, mut blocked) = (vec![None; queries.len()], vec![false; queries.len()]);
    for level in Level::all() {
        for arithmetic in [Arithmetic::Exact, Arithmetic::F32] {
            tracer.with_level(Some(level)).trace_many(arithmetic, &queries, &mut hits);
            tracer.with_level(Some(level)).occluded_many(arithmetic, &queries, &mut blocked);
        }
    }
}

#[test]
fn a_wide_tree_holds_the_same_voxels_and_says_what_it_needs() {
    for seed in 0..20u64 {
        let mut rng = Rng::new(200 + seed);
        let depth = (seed % 10) as u8;
        let set = if seed == 10 { VoxelSet::new([]) } else { clumps(depth, &mut rng) };
        let words = set.words(depth);
        let dag = Dag::new(&words).unwrap();
        let wide = WideBuf::new(&dag, usize::MAX).unwrap();
        let view = wide.as_wide();
        assert!(view.voxels().map(|voxel| voxel.0).eq(set.codes().iter().copied()), "seed {seed}");
        let beside = set.codes().iter().flat_map(|code| [*code, code ^ 1, code ^ 0o70, code + 1, code ^ 0o700]);
        for voxel in beside.chain([0, u64::MAX, 1 << (3 * depth)]).map(Morton) {
            assert_eq!(view.contains(voxel), dag.contains(voxel), "seed {seed}: {voxel:?}");
            assert_eq!(view.empty_level(voxel), dag.empty_level(voxel), "seed {seed}: {voxel:?}");
        }
        // One byte less is too little, and it says how much it takes at least.
        let bytes = view.bytes();
        assert!(WideBuf::new(&dag, bytes).is_ok());
        if bytes > 0 {
            let needed = WideBuf::new(&dag, bytes - 1).unwrap_err();
            assert!(needed <= bytes && needed > 0, "{needed} of {bytes}");
            assert!(WideBuf::new(&dag, needed - 1).is_err());
        }
    }
}
