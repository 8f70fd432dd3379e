//! The SSVDAG: what the plain DAG says, in nodes of which no two are mirror images, and safe whatever its words are.

use voxdag::build::DagBuilder;
use voxdag::ssvdag::{Ssvdag, SsvdagBuf, SsvdagError};
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::{Dag, Geometry, Morton};
use voxdag_oracle::laws::says_the_same;
use voxdag_oracle::mirrors;
use voxdag_oracle::octree::{Recursive, VoxelSet, words_of};
use voxdag_oracle::rng::Rng;

fn build(plain: &[u32]) -> SsvdagBuf {
    SsvdagBuf::build(&Dag::new(plain).unwrap()).unwrap()
}

/// Voxels here and there, and a few of them again as mirror images at other places.
fn some_set(random: &mut Rng, depth: u8) -> VoxelSet {
    let n = 1u64 << depth;
    let mut voxels = Vec::new();
    let side = 1 << random.below(u64::from(depth) + 1);
    let piece: Vec<[u32; 3]> = (0..random.below(60)).map(|_| [(); 3].map(|()| random.below(side) as u32)).collect();
    for _ in 0..random.below(12) {
        let (at, mirror) = ([(); 3].map(|()| (random.below(n / side) * side) as u32), random.below(8));
        let turned = |k: usize, x: u32| at[k] + if mirror >> k & 1 != 0 { side as u32 - 1 - x } else { x };
        voxels.extend(piece.iter().map(|v| -> [u32; 3] { std::array::from_fn(|k| turned(k, v[k])) }));
    }
    voxels.extend((0..random.below(40)).map(|_| [(); 3].map(|()| random.below(n) as u32)));
    let set = VoxelSet::new(voxels);
    mirrors::with_images(&set, depth, if random.below(3) == 0 { random.below(8) as u32 } else { 0 })
}

/// Rays from everywhere to everywhere, and those that are hard: along axes, in planes, through corners, and none.
fn rays(random: &mut Rng, depth: u8) -> Vec<Query> {
    let n = f64::from(1u32 << depth);
    let mut rays = Vec::new();
    for i in 0..24 {
        let mut origin = [(); 3].map(|()| random.uniform(-0.5 * n, 1.5 * n));
        let mut dir = random.direction();
        if i % 3 == 0 {
            origin = origin.map(f64::floor);
        }
        if i % 4 == 0 {
            dir = dir.map(|d| (2.0 * d).round());
        }
        if i % 6 == 1 {
            dir[i % 3] = 0.0;
        }
        rays.push(Query::new(origin, dir));
    }
    rays.push(Query::new([-1.0; 3], [1.0; 3]));
    rays.push(Query::new([n; 3], [-1.0; 3]));
    rays.push(Query::new([0.5; 3], [f64::NAN, 1.0, 0.0]));
    rays
}

#[test]
fn it_says_what_the_dag_says() {
    for seed in 0..300 {
        let mut random = Rng::new(seed);
        let depth = random.below(8) as u8;
        let set = some_set(&mut random, depth);
        let plain = set.words(depth);
        let built = build(&plain);
        println!("seed {seed}, depth {depth}, {} voxels", set.codes().len());
        says_the_same(&set, Dag::new(&plain).unwrap(), built.ssvdag(), &rays(&mut random, depth));
        assert_eq!(mirrors::voxels(built.words()), set, "by the documentation, seed {seed}");
    }
}

/// One brick and its image: the words, one by one.
#[test]
fn two_images_by_hand() {
    let words = |x: u32| build(&VoxelSet::new([[0, 0, 0], [x, 0, 0]]).words(3)).into_words();
    // depth; the bricks' row, level 3's row; octants 0 and 1, of which 0 is new; a pointer to brick 0 in mirror x; the brick.
    let expected = [3, 0, 0, 0, 1, 19, 0, 0, 1, 12, 18, 0, 3, 0, 1, 0, 0, 0, 1, 1, 0];
    assert_eq!(words(7), expected);
    // Not an image but the same once more: mirror 0. Another brick: both are new, there is no pointer.
    assert_eq!(words(4)[18], 0);
    let other = [3, 0, 0, 0, 2, 18, 0, 0, 1, 12, 18, 1, 3, 0, 3, 0, 0, 0, 1, 0, 2, 0];
    assert_eq!(words(5), other);
}

#[test]
fn small_cubes_are_one_brick_as_it_is() {
    for (depth, voxel) in [(0, [0, 0, 0]), (1, [1, 0, 1]), (2, [3, 1, 2])] {
        let set = VoxelSet::new([voxel]);
        let built = build(&set.words(depth));
        let mask = 1u64 << set.codes()[0];
        assert_eq!(built.words(), [depth.into(), 0, 0, 0, 1, 8, 0, 0, mask as u32, (mask >> 32) as u32]);
    }
    for depth in [0, 2, 3, 9, 21] {
        let built = build(&VoxelSet::default().words(depth));
        assert_eq!(built.words().len(), 4 * usize::from(depth.max(2)), "nothing but the header");
        assert!(built.ssvdag().is_empty() && built.ssvdag().voxels().next().is_none());
        assert_eq!((built.ssvdag().stored(), built.ssvdag().stats().unwrap().voxels), (0, 0));
    }
}

/// A cube whose octants are all images of each other has one node a level.
#[test]
fn a_symmetric_cube_has_one_node_a_level() {
    let corner = VoxelSet::new([[0, 1, 0], [2, 5, 7], [1, 1, 3]]);
    let mut set = corner.clone();
    for depth in 4..=7 {
        set = mirrors::with_images(&set, depth, 7);
    }
    let built = build(&set.words(7));
    let counts: Vec<u32> = (0..=8).map(|level| built.ssvdag().node_count(level)).collect();
    assert_eq!(counts, [0, 0, mirrors::classes(&corner, 2) as u32, 1, 1, 1, 1, 1, 0]);
}

/// Every node and brick of the octree written apart, some of them a second time without use.
fn unmerged(set: &VoxelSet, depth: u8) -> Vec<u32> {
    let mut words = vec![0; 24];
    words[0] = depth.into();
    let mut below: Vec<(u64, u32)> = Vec::new();
    for (code, mask) in set.bricks().into_iter().chain(set.bricks().into_iter().take(1)) {
        if below.last().is_none_or(|last| last.0 < code) {
            below.push((code, words.len() as u32));
        }
        words.extend([mask as u32, (mask >> 32) as u32]);
    }
    words[1] = (words.len() as u32 - 24) / 2;
    for level in 3..=21u8 {
        words[usize::from(level) - 1] = words.len() as u32;
        if level > depth {
            continue;
        }
        let shift = 3 * u32::from(level);
        let mut here = Vec::new();
        for node in below.chunk_by(|a, b| a.0 >> shift == b.0 >> shift) {
            here.push((node[0].0, words.len() as u32));
            let mask = node.iter().fold(0, |mask, (code, _)| mask | 1 << (code >> (shift - 3) & 7));
            words.push(1 << 31 | mask);
            words.extend(node.iter().map(|(_, word)| word));
        }
        if level < depth {
            let first = here[0].1 as usize..here.get(1).map_or(words.len(), |second| second.1 as usize);
            words.extend_from_within(first);
        }
        below = here;
    }
    words[21] = words.len() as u32;
    words
}

/// The words depend on the voxels alone.
#[test]
fn equal_voxels_give_equal_words() {
    for seed in 0..60 {
        let mut random = Rng::new(seed);
        let depth = 3 + random.below(5) as u8;
        let set = some_set(&mut random, depth);
        if set.codes().is_empty() {
            continue;
        }
        let built = build(&set.words(depth));
        assert_eq!(build(&unmerged(&set, depth)), built, "seed {seed}");
        let mut builder = DagBuilder::new(depth).unwrap();
        built.ssvdag().bricks().for_each(|(code, mask)| builder.push(code, mask).unwrap());
        assert_eq!(SsvdagBuf::build(&builder.finish().unwrap().dag()).unwrap(), built, "seed {seed}");
    }
}

/// A mirror image of everything has as many nodes, in as many words.
#[test]
fn images_are_as_large() {
    for seed in 0..40 {
        let mut random = Rng::new(seed);
        let depth = 3 + random.below(4) as u8;
        let set = some_set(&mut random, depth);
        let size = build(&set.words(depth)).words().len();
        for axes in 1..8 {
            let codes = set.codes().iter().map(|code| mirrors::image(*code, depth, axes));
            let image = VoxelSet::new(codes.map(voxdag_oracle::octree::deinterleave));
            assert_eq!(build(&image.words(depth)).words().len(), size, "seed {seed}, axes {axes}");
        }
    }
}

/// A shape of few states in a cube of any depth.
struct Rules([(u8, u32); 5]);

impl Recursive for Rules {
    type State = usize;

    fn split(&self, _: u8, state: &usize) -> [Option<usize>; 8] {
        let (mask, octants) = self.0[*state];
        std::array::from_fn(|c| (mask >> c & 1 != 0).then_some((octants >> (4 * c) & 15) as usize % 5))
    }
}

/// The largest cubes: the same voxels at random places, the same counts, the same hits.
#[test]
fn depths_up_to_21() {
    for seed in 0..60 {
        let mut random = Rng::new(seed);
        let depth = 8 + random.below(14) as u8;
        let rules = Rules([(); 5].map(|()| (random.bits() as u8 | 1 << random.below(8), random.bits() as u32)));
        let plain = words_of(&rules, depth, Some(&0));
        let (dag, built) = (Dag::new(&plain).unwrap(), build(&plain));
        let ssvdag = built.ssvdag();
        let (stats, expected) = (ssvdag.stats().unwrap(), dag.stats().unwrap());
        assert_eq!(stats.voxels, expected.voxels, "seed {seed}");
        assert_eq!(stats.levels.map(|level| level.octree), expected.levels.map(|level| level.octree), "seed {seed}");
        assert!(stats.levels.iter().zip(&expected.levels).all(|(merged, plain)| merged.unique <= plain.unique));
        assert!(ssvdag.bricks().take(2000).eq(dag.bricks().take(2000)), "seed {seed}");
        let mut filled = 0;
        for _ in 0..2000 {
            // A random path through filled cubes, which sometimes leaves them.
            let (mut code, mut state) = (0, 0);
            for _ in 0..depth {
                let octants = rules.split(0, &state);
                let filled: Vec<u64> = (0..8).filter(|c| octants[*c as usize].is_some()).collect();
                let octant = if random.below(40) == 0 { random.below(8) } else { random.pick(&filled) };
                code = code << 3 | octant;
                state = octants[octant as usize].unwrap_or(0);
            }
            let voxel = Morton(code);
            assert_eq!(ssvdag.contains(voxel), dag.contains(voxel), "seed {seed}, {voxel:?}");
            assert_eq!(ssvdag.empty_level(voxel), dag.empty_level(voxel), "seed {seed}, {voxel:?}");
            filled += u32::from(dag.contains(voxel));
        }
        assert!((500..2000).contains(&filled) || stats.voxels >> (3 * depth) != 0, "seed {seed}: {filled} are filled");
        let top = [TopBuf::new(&dag, 3).unwrap(), TopBuf::new(&ssvdag, 3).unwrap()];
        let tracer = Tracer::with_top(dag, top[0].as_top()).unwrap();
        let its = Tracer::with_top(ssvdag, top[1].as_top()).unwrap();
        for ray in rays(&mut random, depth) {
            let expected = tracer.trace_counted(Arithmetic::Exact, &ray);
            assert_eq!(its.trace_counted(Arithmetic::Exact, &ray), expected, "seed {seed}, {ray:?}");
        }
    }
}

/// Asks everything of words that were accepted: no panic, no endless loop.
fn exercise(words: &[u32]) -> bool {
    let Ok(ssvdag) = Ssvdag::new(words) else { return false };
    assert!(ssvdag.voxels().take(300).all(|voxel| ssvdag.contains(voxel)));
    ssvdag.stats().unwrap();
    for code in [0, 77, 1 << 20, u64::MAX] {
        ssvdag.empty_level(Morton(code));
    }
    let n = f64::from(1u32 << ssvdag.depth());
    for dir in [[1.0, 0.4, 0.3], [-1.0, 1.0, 1.0], [0.0, 0.0, -1.0]] {
        let query = Query::new(std::array::from_fn(|i| 0.4 * n - 2.0 * n * dir[i]), dir);
        let tracer = Tracer::new(ssvdag);
        assert_eq!(tracer.trace(Arithmetic::Exact, &query).is_some(), tracer.occluded(Arithmetic::Exact, &query));
    }
    true
}

/// Every word changed in many ways, and cut or lengthened at every place: refused, or safe.
#[test]
fn changed_words_are_refused_or_safe() {
    let mut random = Rng::new(7);
    let (mut refused, mut accepted) = (0, 0);
    for depth in [2, 3, 5, 6] {
        let words = build(&some_set(&mut random, depth).words(depth)).into_words();
        assert!(exercise(&words));
        for at in 0..words.len() {
            assert!(!exercise(&words[..at]), "cut at {at}");
            let bits = (0..32).map(|bit| words[at] ^ 1 << bit);
            for changed in bits.chain([0, 1, u32::MAX, words[at].wrapping_add(1), words[at].wrapping_sub(1)]) {
                let mut words = words.clone();
                words[at] = changed;
                if exercise(&words) { accepted += 1 } else { refused += 1 }
            }
        }
        assert!(!exercise(&[&words[..], &[0]].concat()), "a word too much");
    }
    // Other voxels in bricks, and pointers to other nodes: nothing that a check could know.
    assert!(refused > 1000 && accepted > 100, "{refused} refused, {accepted} accepted");
}

/// Each error, and that its text says where.
#[test]
fn errors_name_the_word() {
    // See `two_images_by_hand`.
    let words = [3, 0, 0, 0, 1, 19, 0, 0, 1, 12, 18, 0, 3, 0, 1, 0, 0, 0, 1, 1, 0];
    let error = |changes: &[(usize, u32)]| {
        let mut words = words;
        changes.iter().for_each(|&(at, word)| words[at] = word);
        Ssvdag::new(&words).unwrap_err()
    };
    let header = |word| SsvdagError::Header { word };
    assert_eq!(error(&[(0, 22)]), header(0));
    assert_eq!(error(&[(2, 1)]), header(2), "a reserved word");
    assert_eq!(error(&[(4, 0)]), header(8), "a root without bricks");
    assert_eq!(error(&[(8, 2)]), header(8), "two roots");
    assert_eq!(error(&[(8, 0)]), header(8), "no root");
    assert_eq!(error(&[(5, 20)]), header(5), "another place of the bricks");
    assert_eq!(error(&[(10, 19)]), header(9), "another place of the pointers");
    assert_eq!(error(&[(4, 2)]), header(9), "numbers of another width");
    assert_eq!(error(&[(4, 2), (11, 1)]), header(4), "a brick that nobody visits");
    for (at, word) in [(12, 0), (12, 0x103), (14, 4), (16, 1), (17, 1)] {
        assert_eq!(error(&[(at, word)]), SsvdagError::Block { word: 12 }, "word {at}");
    }
    assert_eq!(error(&[(18, 8)]), SsvdagError::Pointer { word: 18 }, "a bit behind the last pointer");
    assert_eq!(error(&[(19, 0)]), SsvdagError::Brick { word: 19 });
    for (depth, outside) in [(0, 1 << 1), (1, 1 << 8)] {
        assert!(Ssvdag::new(&[depth, 0, 0, 0, 1, 8, 0, 0, 1, 0]).is_ok());
        let error = Ssvdag::new(&[depth, 0, 0, 0, 1, 8, 0, 0, 1 | outside, 0]).unwrap_err();
        assert_eq!(error, SsvdagError::Brick { word: 8 }, "a voxel outside the cube of depth {depth}");
    }
    let length = |expected, found| SsvdagError::Length { expected, found };
    assert_eq!(Ssvdag::new(&words[..20]).unwrap_err(), length(21, 20));
    assert_eq!(Ssvdag::new(&[]).unwrap_err(), length(8, 0));
    assert_eq!(Ssvdag::new(&[21]).unwrap_err(), length(84, 1));

    // Three bricks, so that a pointer of two bits can miss: they stand in octants 0, 1 and 2, the first again in 3.
    let mut words = build(&VoxelSet::new([[0, 0, 0], [5, 0, 0], [1, 5, 0], [4, 4, 0]]).words(3)).into_words();
    assert_eq!((words[4], words[11], words[18]), (3, 2, 0));
    words[18] = 3;
    assert_eq!(Ssvdag::new(&words).unwrap_err(), SsvdagError::Pointer { word: 18 });
    let texts =
        [header(2), SsvdagError::Block { word: 2 }, SsvdagError::Pointer { word: 2 }, SsvdagError::Brick { word: 2 }];
    assert!(texts.iter().all(|error| error.to_string().contains("word 2")));
    assert!(length(84, 1).to_string().contains("84"));
}

/// Numbers of nodes are below 2^31, and numbers that are none are known.
#[test]
fn numbers_of_nodes() {
    let set = some_set(&mut Rng::new(5), 6);
    let built = build(&set.words(6));
    let ssvdag = built.ssvdag();
    let mut nodes = vec![ssvdag.root()];
    for level in (2..=6).rev() {
        assert!(nodes.iter().all(|&node| node < 1 << 31 && ssvdag.is_node(node, level)));
        assert!(!ssvdag.is_node(ssvdag.node_count(level), level) && !ssvdag.is_node(u32::MAX, level));
        let mut seen: Vec<u32> = nodes.iter().map(|&node| Ssvdag::number(node)).collect();
        seen.sort();
        seen.dedup();
        assert_eq!(seen.len(), ssvdag.node_count(level) as usize, "every stored node of level {level} is in use");
        if level > 2 {
            let children = |node| (0..8).map(move |octant| ssvdag.child(node, level, octant));
            for &node in &nodes {
                let mask =
                    children(node).zip(0..).map(|(child, octant)| u8::from(child.is_some()) << octant).sum::<u8>();
                assert_eq!(ssvdag.mask(node, level), mask);
            }
            nodes = nodes.iter().flat_map(|&node| children(node)).flatten().collect();
        }
    }
    assert!(!ssvdag.is_node(0, 7) && !ssvdag.is_node(0, 1));
}

/// Lent memory must fit.
#[test]
fn counts_take_what_they_say() {
    let set = some_set(&mut Rng::new(9), 5);
    let built = build(&set.words(5));
    let stored = built.ssvdag().stored();
    assert!(built.ssvdag().stats_into(&mut vec![0; stored + 1]).is_none());
    assert!(built.ssvdag().stats_into(&mut vec![0; stored - 1]).is_none());
    assert!(built.ssvdag().stats_into(&mut vec![7; stored]).is_some());
}
