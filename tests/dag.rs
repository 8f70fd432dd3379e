//! The DAG's builders and its checked view, row by row of the catalogue (hard-cases, sections 7 and 8).
//!
//! Not here: H2 to H4 and H6 (the table's own tests), H5 (nothing is ever deleted, hence no tombstones: docs/numerics.md).

use std::hash::{BuildHasher, Hasher};

use num_bigint::BigUint;
use voxdag::build::{BuildError, DagBuf, DagBuilder, Mix, build_into, scratch_words, words_bound};
use voxdag::dag::DagError;
use voxdag::trace::Query;
use voxdag::{Dag, Morton};
use voxdag_oracle::octree::{self, VoxelSet};
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::Implicit;

const HEADER: usize = voxdag::dag::HEADER;

/// A set of voxels with shared and unshared parts.
fn some_set(seed: u64, depth: u8, count: usize) -> VoxelSet {
    let mut rng = Rng::new(seed);
    let n = 1u64 << depth;
    let mut voxels: Vec<[u32; 3]> = (0..count).map(|_| [(); 3].map(|()| rng.below(n) as u32)).collect();
    // A block, repeated at some places.
    let size = n.min(8);
    let block: Vec<[u32; 3]> = (0..20).map(|_| [(); 3].map(|()| rng.below(size) as u32)).collect();
    for _ in 0..5 {
        let at = [(); 3].map(|()| (rng.below(n / size) * size) as u32);
        voxels.extend(block.iter().map(|v| -> [u32; 3] { core::array::from_fn(|i| v[i] + at[i]) }));
    }
    VoxelSet::new(voxels)
}

fn bricks(set: &VoxelSet) -> impl Iterator<Item = (Morton, u64)> {
    set.bricks().into_iter().map(|(code, mask)| (Morton(code), mask))
}

fn build(set: &VoxelSet, depth: u8) -> DagBuf {
    build_with(Mix(0), set, depth)
}

fn build_with<H: BuildHasher>(hasher: H, set: &VoxelSet, depth: u8) -> DagBuf {
    let mut builder = DagBuilder::with_hasher(depth, hasher).unwrap();
    for (code, mask) in bricks(set) {
        builder.push(code, mask).unwrap();
    }
    builder.finish().unwrap()
}

/// The full cube, by joining eight copies of the cube half its size.
fn full_cube(depth: u8) -> DagBuf {
    if depth <= 2 {
        let mut builder = DagBuilder::new(depth).unwrap();
        builder.push(Morton(0), u64::MAX >> (64 - (1u32 << (3 * depth)))).unwrap();
        return builder.finish().unwrap();
    }
    let half = full_cube(depth - 1);
    let mut builder = DagBuilder::new(depth).unwrap();
    for octant in 0..8u64 {
        builder.append(Morton(octant << (3 * (depth - 1))), &half.dag()).unwrap();
    }
    builder.finish().unwrap()
}

/// Asks everything of words that were accepted: no panic, no endless loop.
fn exercise(words: &[u32]) {
    let Ok(dag) = Dag::new(words) else { return };
    let top = 1u64 << (3 * u32::from(dag.depth()));
    for code in [0, 1, top / 2, top - 1, top, u64::MAX] {
        dag.contains(Morton(code));
    }
    assert!(dag.voxels().take(200).all(|v| dag.contains(v)));
    assert!(dag.bricks().take(100).all(|(_, mask)| mask != 0));
    dag.stats().unwrap();
    let n = f64::from(1u32 << dag.depth());
    for dir in [[1.0, 0.4, 0.3], [-1.0, 1.0, 1.0], [0.0, 0.0, -1.0]] {
        for p in [0.3, 0.5] {
            let q = Query::new(core::array::from_fn(|i| p * n - 2.0 * n * dir[i]), dir);
            assert_eq!(dag.trace(&q).is_some(), dag.occluded(&q));
        }
    }
}

#[test]
fn d00_builders_write_what_the_documentation_says() {
    for depth in 0..=21u8 {
        for seed in 0..4 {
            let set = some_set(seed, depth, [0, 1, 30, 400][seed as usize]);
            let words = set.words(depth);
            assert_eq!(build(&set, depth).words(), words, "depth {depth}, seed {seed}");
            let count = set.bricks().len();
            let mut room = vec![0xdead_beef; words_bound(count, depth)];
            let used = build_into(bricks(&set), depth, &mut room, &mut vec![0; scratch_words(count, depth)]);
            assert_eq!(used, Ok(words.len()), "depth {depth}, seed {seed}");
            assert_eq!(room[..words.len()], words, "depth {depth}, seed {seed}");
            assert!(room[words.len()..].iter().all(|&w| w == 0xdead_beef), "the rest is not its own");
        }
    }
}

#[test]
fn d00_any_mixture_of_bricks_and_subtrees_gives_the_same_words() {
    for seed in 0..60 {
        let mut rng = Rng::new(seed);
        let depth = rng.between(3, 21) as u8;
        let set = some_set(seed, depth, 300);
        let mut builder = DagBuilder::new(depth).unwrap();
        // Cut the list at random: a subtree of a random level as a whole, or one brick.
        let all: Vec<(Morton, u64)> = bricks(&set).collect();
        let mut at = 0;
        while at < all.len() {
            let code = all[at].0.0;
            let level = rng.between(2, i64::from(depth)) as u8;
            let corner = code >> (3 * level) << (3 * level);
            let first = at == 0 || all[at - 1].0.0 < corner;
            if !first || rng.below(3) == 0 {
                builder.push(all[at].0, all[at].1).unwrap();
                at += 1;
                continue;
            }
            let end = all.partition_point(|b| b.0.0 < corner + (1 << (3 * level)));
            let mut part = DagBuilder::new(level).unwrap();
            for &(code, mask) in &all[at..end] {
                part.push(Morton(code.0 - corner), mask).unwrap();
            }
            builder.append(Morton(corner), &part.finish().unwrap().dag()).unwrap();
            at = end;
        }
        assert_eq!(builder.finish().unwrap().words(), set.words(depth), "seed {seed}");
    }
}

#[test]
fn d00_self_similar_shapes_at_depth_21() {
    // Words by recursion over states, words by joining: 2^21 voxels a side and no list of them.
    let n = 1i64 << 21;
    let full = Implicit::Wall { axis: 0, lo: 0, hi: n };
    assert_eq!(full_cube(21).words(), full.words(21));
    for shape in [Implicit::Diagonal { lo: n, hi: n + 3 }, Implicit::Wall { axis: 1, lo: n / 3, hi: n / 3 + 5 }] {
        let words = shape.words(21);
        let dag = Dag::new(&words).unwrap();
        assert_eq!(BigUint::from(dag.stats().unwrap().voxels), octree::count_voxels(&words), "{shape:?}");
        for seed in 0..5000 {
            let mut rng = Rng::new(seed);
            let mut v = [(); 3].map(|()| rng.below(n as u64) as u32);
            // Half of them where the shape is.
            if seed % 2 == 0 {
                v[1] = (n / 3 + rng.between(-3, 7)) as u32;
                v[2] = (n - i64::from(v[0]) - i64::from(v[1]) + rng.between(-3, 5)).clamp(0, n - 1) as u32;
            }
            assert_eq!(dag.contains(Morton::encode(v).unwrap()), shape.filled(v), "{shape:?}, {v:?}");
        }
    }
}

#[test]
fn d01_too_many_words_are_an_error() {
    // The limit stands in for 2^31 words, which no test can fill: it is the same comparison.
    for (depth, count) in [(3, 90), (8, 300), (10, 20), (16, 20), (21, 20)] {
        too_many_words(depth, &some_set(1, depth, count));
    }
}

fn too_many_words(depth: u8, set: &VoxelSet) {
    let words = set.words(depth);
    for limit in 0..=words.len() as u32 + 2 {
        let mut builder = DagBuilder::new(depth).unwrap();
        builder.limit(limit);
        let pushed = bricks(set).try_for_each(|(code, mask)| builder.push(code, mask));
        let built = pushed.and_then(|()| builder.finish());
        if limit as usize >= words.len() {
            assert_eq!(built.map(DagBuf::into_words), Ok(words.clone()), "limit {limit}");
        } else {
            let Err(BuildError::Words { needed }) = built else { panic!("limit {limit}: {built:?}") };
            assert!(needed > u64::from(limit) && needed <= words.len() as u64, "limit {limit}, needed {needed}");
        }
    }
}

#[test]
fn d01_lent_memory_that_is_too_small_is_an_error() {
    let depth = 6;
    let set = some_set(2, depth, 60);
    let words = set.words(depth);
    let enough = scratch_words(set.bricks().len(), depth);
    for size in 0..enough + 3 {
        let mut room = vec![0; words.len()];
        match build_into(bricks(&set), depth, &mut room, &mut vec![7; size]) {
            Ok(used) => assert_eq!(room[..used], words, "{size} words of scratch"),
            Err(BuildError::Scratch { needed }) => assert!(needed > size as u64 && size < enough, "{size} of {enough}"),
            Err(other) => panic!("{size} words of scratch: {other:?}"),
        }
    }
    for size in 0..words.len() {
        let built = build_into(bricks(&set), depth, &mut vec![0; size], &mut vec![0; enough]);
        assert_eq!(built, Err(BuildError::Words { needed: words.len() as u64 }));
    }
}

#[test]
fn d02_children_that_are_not_below_are_refused() {
    // Every child word pointed at every node, brick, header word and into the middle of things.
    let refused: usize =
        [(3, 60), (6, 60), (10, 4), (16, 3), (21, 2)].map(|(depth, count)| misled(depth, count)).iter().sum();
    assert!(refused > 40_000, "{refused}");
}

/// Points each child word everywhere and counts what is refused.
fn misled(depth: u8, count: usize) -> usize {
    let words = VoxelSet::new(some_set(3, depth, count).codes().iter().step_by(7).map(|c| octree::deinterleave(*c)))
        .words(depth);
    let starts: Vec<usize> = (2..=21).map(|i| words[i] as usize).collect();
    let level_of = |word: usize| 2 + starts.iter().filter(|&&s| s <= word).count();
    let mut refused = 0;
    for at in starts[0]..words.len() {
        if words[at] >> 31 == 1 {
            continue;
        }
        for target in 0..words.len() + 2 {
            let mut bad = words.clone();
            bad[at] = target as u32;
            let starts_something = match target {
                t if t < HEADER || t >= words.len() => false,
                t if t < starts[0] => t % 2 == 0,
                t => words[t] >> 31 == 1,
            };
            let good = starts_something && level_of(target) + 1 == level_of(at);
            let result = Dag::new(&bad);
            assert_eq!(result.is_ok(), good, "word {at} -> {target}: {result:?}");
            if !good {
                assert_eq!(result.err(), Some(DagError::Child { word: at as u32, target: target as u32 }));
                refused += 1;
            }
        }
    }
    refused
}

#[test]
fn d03_any_flipped_bit_is_refused_or_harmless() {
    for (depth, count) in [(0u8, 40), (1, 40), (2, 40), (3, 40), (5, 40), (10, 5), (16, 5), (21, 5)] {
        let words = some_set(4, depth, count).words(depth);
        for word in 0..words.len() {
            for bit in 0..32 {
                let mut bad = words.clone();
                bad[word] ^= 1 << bit;
                exercise(&bad);
            }
        }
    }
}

#[test]
fn d03_any_words_are_refused_or_harmless() {
    for seed in 0..20_000 {
        let mut rng = Rng::new(seed);
        let depth = rng.between(0, 8) as u8;
        let mut words = some_set(seed % 7, depth, 20).words(depth);
        for _ in 0..rng.between(1, 6) {
            let at = rng.below(words.len() as u64) as usize;
            words[at] = match rng.below(4) {
                0 => rng.bits() as u32,
                1 => rng.below(words.len() as u64 + 1) as u32,
                2 => 1 << 31 | rng.below(256) as u32,
                _ => words[rng.below(words.len() as u64) as usize],
            };
        }
        exercise(&words);
    }
}

#[test]
fn d03_nodes_that_are_none_are_refused() {
    let words = some_set(11, 6, 40).words(6);
    let refused = |bad: &[u32], word: usize| {
        assert_eq!(Dag::new(bad).err(), Some(DagError::Node { word: word as u32 }), "word {word}: {:#x}", bad[word]);
    };
    let mut word = words[2] as usize;
    while word < words.len() {
        // A bit that means nothing, no mark of a node, and no child.
        for bit in 8..32 {
            let mut bad = words.clone();
            bad[word] ^= 1 << bit;
            refused(&bad, word);
        }
        let mut bad = words.clone();
        bad[word] &= !0xff;
        refused(&bad, word);
        word += 1 + (words[word] & 0xff).count_ones() as usize;
    }
    // The last node of each level with more children than the level has words.
    for level in 3..=6 {
        let (start, end) = (words[level - 1] as usize, words[level] as usize);
        let last = (start..end).rfind(|&word| words[word] >> 31 == 1).unwrap();
        let mut bad = words.clone();
        bad[last] |= 0xff;
        if bad[last] != words[last] {
            refused(&bad, last);
        }
    }
}

#[test]
fn d03_there_is_one_root() {
    // A second root behind the first, a copy of it.
    let mut words = some_set(12, 5, 40).words(5);
    let root = words[4] as usize;
    words.extend_from_within(root..);
    let end = words.len() as u32;
    words[5..22].fill(end);
    assert_eq!(Dag::new(&words).err(), Some(DagError::Root));
    // A node above the root.
    let mut words = some_set(12, 5, 40).words(5);
    words.extend([1 << 31 | 1, words[4]]);
    let end = words.len() as u32;
    words[6..22].fill(end);
    assert_eq!(Dag::new(&words).err(), Some(DagError::Root));
    words[0] = 6;
    assert!(Dag::new(&words).is_ok());
    // Two bricks where one is all there can be; none where there is a node.
    let mut words = some_set(13, 2, 20).words(2);
    words.extend([1, 0]);
    (words[1], words[2]) = (2, words[2] + 2);
    let end = words[2];
    words[3..22].fill(end);
    assert_eq!(Dag::new(&words).err(), Some(DagError::Root));
    let mut empty = VoxelSet::default().words(5);
    assert!(Dag::new(&empty).is_ok());
    empty.extend([7, 0]);
    empty[1] = 1;
    empty[2..22].fill(HEADER as u32 + 2);
    assert_eq!(Dag::new(&empty).err(), Some(DagError::Root));
}

#[test]
fn d04_another_depth_is_refused() {
    for depth in (3..=10u8).chain([16, 21]) {
        let words = some_set(5, depth, 50).words(depth);
        for other in 0..=255 {
            let mut bad = words.clone();
            bad[0] = other;
            assert_eq!(Dag::new(&bad).is_ok(), other == u32::from(depth), "depth {depth} as {other}");
            if other > 21 {
                assert_eq!(Dag::new(&bad).err(), Some(DagError::Depth { found: other }));
            }
        }
    }
}

#[test]
fn d05_the_fullest_cube_is_counted_exactly() {
    for depth in 0..=21u8 {
        let full = full_cube(depth);
        let dag = full.dag();
        let stats = dag.stats().unwrap();
        let expected = 1u64 << (3 * depth);
        assert_eq!(stats.voxels, expected);
        assert_eq!(octree::count_voxels(full.words()), BigUint::from(expected));
        // 2^63 fits u64 and not i64; the file that says so has less than 1 KB.
        assert!(full.words().len() < 256);
        for level in 3..=depth {
            let counts = stats.levels[usize::from(level)];
            assert_eq!((counts.unique, counts.octree), (1, 1 << (3 * (depth - level))), "level {level} of {depth}");
        }
        // Readers of voxels can stop whenever they like.
        assert_eq!(dag.voxels().take(1000).count() as u64, expected.min(1000));
        assert!(dag.contains(Morton(expected - 1)) && !dag.contains(Morton(expected)));
    }
    assert_eq!(DagBuilder::new(22).err(), Some(BuildError::Depth { found: 22 }));
    assert_eq!(build_into([], 22, &mut [0; 99], &mut [0; 99]), Err(BuildError::Depth { found: 22 }));
}

#[test]
fn d06_full_and_empty_cubes_of_every_depth() {
    for depth in 0..=21u8 {
        let empty = DagBuilder::new(depth).unwrap().finish().unwrap();
        assert_eq!(empty.words(), VoxelSet::default().words(depth));
        assert!(empty.dag().is_empty() && empty.dag().voxels().next().is_none() && !empty.dag().contains(Morton(0)));
        assert_eq!(empty.dag().stats().unwrap().voxels, 0);
        assert_eq!(empty.words().len(), HEADER);
        // An empty brick and an empty subtree leave it empty.
        let mut builder = DagBuilder::new(depth).unwrap();
        builder.push(Morton(0), 0).unwrap();
        builder.append(Morton(0), &empty.dag()).unwrap();
        assert_eq!(builder.finish().unwrap(), empty);
        // One node per level.
        let full = full_cube(depth);
        assert_eq!(full.words().len(), HEADER + 2 + 9 * usize::from(depth.saturating_sub(2)));
    }
}

#[test]
fn d06_bricks_outside_the_cube_are_refused() {
    for (depth, inside, outside) in [(0, 1u64, 2), (0, 1, 1 << 63), (1, 0xff, 1 << 8), (1, 1, 1 << 32), (1, 3, 1 << 63)]
    {
        let mut words = VoxelSet::new([[0; 3]]).words(depth);
        let mut found = |mask: u64| {
            (words[HEADER], words[HEADER + 1]) = (mask as u32, (mask >> 32) as u32);
            Dag::new(&words).map(|dag| dag.voxels().count())
        };
        assert_eq!(found(inside), Ok(inside.count_ones() as usize));
        assert_eq!(
            found(inside | outside),
            Err(DagError::Brick { word: HEADER as u32 }),
            "depth {depth}: {outside:#x}"
        );
    }
}

#[test]
fn d06_what_reaches_outside_the_cube_is_refused() {
    for depth in 0..=5u8 {
        let outside = |code: u64, mask: u64| DagBuilder::new(depth).unwrap().push(Morton(code), mask);
        let end = 1u64 << (3 * depth.max(2));
        assert_eq!(outside(end, 1), Err(BuildError::Outside { code: end }));
        assert_eq!(outside(1, 1), Err(BuildError::Outside { code: 1 }), "a brick's code is a multiple of 64");
        assert_eq!(outside(u64::MAX << 6, 1), Err(BuildError::Outside { code: u64::MAX << 6 }));
        // In small cubes the brick itself is larger than the cube.
        let first_outside = 1u64 << (3 * depth);
        if depth < 2 {
            assert_eq!(outside(0, 1 << first_outside), Err(BuildError::Outside { code: 0 }));
        }
        // Subtrees likewise, whole or in part.
        for level in 0..=6u8 {
            let mut corner = DagBuilder::new(level).unwrap();
            corner.push(Morton(0), 1).unwrap();
            let corner = corner.finish().unwrap();
            let full = full_cube(level);
            for (part, last) in [(&corner, 0), (&full, (1u64 << (3 * level)) - 1)] {
                let mut builder = DagBuilder::new(depth).unwrap();
                let taken = builder.append(Morton(0), &part.dag());
                match builder.finish() {
                    Ok(built) => {
                        let dag = Dag::new(built.words()).unwrap_or_else(|e| panic!("{level} in {depth}: {e:?}"));
                        assert!(taken.is_err() || dag.contains(Morton(last)), "level {level} in depth {depth}");
                    }
                    Err(e) => panic!("level {level} in depth {depth}: {e:?}"),
                }
                if last >> (3 * depth) != 0 {
                    assert_eq!(taken, Err(BuildError::Outside { code: 0 }), "level {level} in depth {depth}");
                }
            }
        }
    }
}

#[test]
fn d06_order_is_kept_or_refused() {
    let mut builder = DagBuilder::new(6).unwrap();
    let block = full_cube(4);
    builder.push(Morton(64), 1).unwrap();
    assert_eq!(builder.push(Morton(64), 1), Err(BuildError::Order { code: 64 }));
    assert_eq!(builder.push(Morton(0), 1), Err(BuildError::Order { code: 0 }));
    // A subtree that holds what came before.
    assert_eq!(builder.append(Morton(0), &block.dag()), Err(BuildError::Order { code: 0 }));
    builder.append(Morton(4096), &block.dag()).unwrap();
    // A brick within the subtree that came before; then one right after it.
    assert_eq!(builder.push(Morton(8192 - 64), 1), Err(BuildError::Order { code: 8192 - 64 }));
    assert_eq!(builder.append(Morton(8192 + 64), &block.dag()), Err(BuildError::Outside { code: 8192 + 64 }));
    builder.push(Morton(8192), 1).unwrap();
    // What was refused left no trace.
    let built = builder.finish().unwrap();
    let codes: Vec<u64> = built.dag().voxels().map(|v| v.0).collect();
    let expected: Vec<u64> = [64].into_iter().chain(4096..8192).chain([8192]).collect();
    assert_eq!(codes, expected);
    assert_eq!(built.words(), VoxelSet::new(codes.iter().map(|c| octree::deinterleave(*c))).words(6));
}

#[test]
fn d07_every_truncation_is_refused() {
    for depth in [0u8, 2, 3, 6, 10, 16, 21] {
        let words = some_set(6, depth, 50).words(depth);
        for len in 0..words.len() {
            let result = Dag::new(&words[..len]);
            let Err(DagError::Truncated { expected, found }) = result else { panic!("{len} words: {result:?}") };
            assert_eq!(found, len as u64);
            assert_eq!(expected, if len < HEADER { HEADER } else { words.len() } as u64);
        }
    }
}

#[test]
fn d08_sizes_that_overflow_are_refused() {
    // As opengametools issue 87: a product of sizes that is 0 in 32 bits. Here 2^31 bricks of two words.
    for depth in [3, 5, 10, 16, 21] {
        let mut words = some_set(7, depth, 30).words(depth);
        for bricks in [1 << 31, u32::MAX, (1 << 31) + words[1], 1 << 30] {
            words[1] = bricks;
            let refused = matches!(Dag::new(&words), Err(DagError::Header { word: 2 } | DagError::Truncated { .. }));
            assert!(refused, "{bricks} bricks at depth {depth}");
        }
    }
    let mut header = vec![0u32; HEADER];
    header[0] = 21;
    header[1] = 1 << 31;
    header[2..22].fill(HEADER as u32);
    assert!(Dag::new(&header).is_err());
    header[1] = 0;
    assert!(Dag::new(&header).is_ok());
    header[21] = u32::MAX;
    assert!(matches!(Dag::new(&header), Err(DagError::Truncated { expected: 0xffff_ffff, .. })));
}

#[test]
fn d10_words_to_spare_are_refused() {
    for depth in [0u8, 2, 3, 6, 10, 16, 21] {
        let words = some_set(8, depth, 50).words(depth);
        for more in [1, 2, 3, 100] {
            let mut longer = words.clone();
            longer.resize(words.len() + more, 0);
            let expected = DagError::Trailing { expected: words.len() as u64, found: longer.len() as u64 };
            assert_eq!(Dag::new(&longer).err(), Some(expected));
        }
    }
}

/// A hash function that says the same of everything, or nearly so.
#[derive(Clone, Copy)]
struct Poor(u64, u64);

impl BuildHasher for Poor {
    type Hasher = Poor;
    fn build_hasher(&self) -> Poor {
        *self
    }
}

impl Hasher for Poor {
    fn finish(&self) -> u64 {
        self.0 & self.1
    }
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = self.0.wrapping_mul(31).wrapping_add(u64::from(byte));
        }
    }
}

#[test]
fn h07_colliding_hashes_change_nothing() {
    // All hashes equal; only two different ones; only the bits that choose a slot equal; only the others.
    for mask in [0, 1, 0xffff_ffff_0000_0000, 0x0000_0000_ffff_ffff] {
        for depth in [3, 8, 10, 16, 21] {
            let set = some_set(9, depth, 500);
            assert_eq!(
                build_with(Poor(7, mask), &set, depth).words(),
                set.words(depth),
                "mask {mask:x}, depth {depth}"
            );
        }
    }
}

#[test]
fn h08_the_order_of_any_table_is_not_observable() {
    for depth in [3, 9, 10, 16, 21] {
        let set = some_set(10, depth, 1000);
        let expected = set.words(depth);
        for seed in 0..8 {
            let seed = Rng::new(seed).bits();
            assert!(build_with(Mix(seed), &set, depth).words() == expected, "hash seed {seed}, depth {depth}");
        }
        assert!(build_with(std::hash::RandomState::new(), &set, depth).words() == expected);
    }
}

#[test]
fn h01_coordinates_of_two_to_the_21_are_refused() {
    let last = (1u32 << 21) - 1;
    assert_eq!(Morton::encode([last; 3]), Some(Morton((1 << 63) - 1)));
    for axis in 0..3 {
        for k in [1 << 21, (1 << 21) + 1, 1 << 22, u32::MAX] {
            let mut v = [5; 3];
            v[axis] = k;
            assert_eq!(Morton::encode(v), None);
        }
    }
}

#[test]
fn d09_a_builder_that_failed_says_so_to_the_end() {
    for more in [Morton(512), Morton(1024)] {
        let mut builder = DagBuilder::new(6).unwrap();
        builder.push(Morton(0), 1).unwrap();
        builder.limit(builder.words() as u32);
        let error = builder.push(more, 1).unwrap_err();
        assert!(matches!(error, BuildError::Words { .. }), "{error:?}");
        builder.limit(1 << 20);
        assert_eq!(builder.push(Morton(2048), 1), Err(error));
        assert_eq!(builder.finish().err(), Some(error));
    }
    // What is refused for its place changes nothing.
    let mut builder = DagBuilder::new(6).unwrap();
    builder.push(Morton(64), 1).unwrap();
    assert_eq!(builder.push(Morton(0), 1), Err(BuildError::Order { code: 0 }));
    assert!(matches!(builder.push(Morton(1 << 18), 1), Err(BuildError::Outside { .. })));
    builder.push(Morton(128), 1).unwrap();
    assert!(builder.finish().unwrap().dag().voxels().eq([Morton(64), Morton(128)]));
}
