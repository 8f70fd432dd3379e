//! Ranks are what counting gives, whatever the scheme, the depth and the shape; words that are no counts are refused.

use voxdag::build::DagBuilder;
use voxdag::rank::{MoxelDagBuf, OffsetsBuf, Prefix, RankError};
use voxdag::{Dag, Morton, Rank};
use voxdag_oracle::octree::{Recursive, VoxelSet, words_of};
use voxdag_oracle::rng::Rng;
use voxdag_oracle::scenes::Implicit;

/// Everything filled but the cube's first voxel, or that too.
struct Full;

impl Recursive for Full {
    /// Whether the first voxel is missing.
    type State = bool;

    fn split(&self, level: u8, hole: &bool) -> [Option<bool>; 8] {
        core::array::from_fn(|octant| {
            let hole = *hole && octant == 0;
            (level > 1 || !hole).then_some(hole)
        })
    }
}

/// Calls `check` with every scheme's answers for a DAG.
fn each_scheme(words: &[u32], check: impl Fn(&str, u64, &dyn Fn(u64) -> Option<u64>)) {
    let dag = Dag::new(words).unwrap();
    let counts = Prefix::build(&dag).unwrap();
    let prefix = Prefix::new(dag, &counts).unwrap();
    check("prefix", prefix.count(), &|code| prefix.rank(Morton(code)));
    let offsets = OffsetsBuf::build(&dag).unwrap();
    check("offsets", offsets.as_offsets().count(), &|code| offsets.as_offsets().rank(Morton(code)));
    let moxels = MoxelDagBuf::build(&dag).unwrap();
    check("moxel DAG", moxels.as_moxel_dag().count(), &|code| moxels.as_moxel_dag().rank(Morton(code)));
}

/// A DAG of the voxels by the library's builder.
fn built(depth: u8, set: &VoxelSet) -> Vec<u32> {
    let mut builder = DagBuilder::new(depth).unwrap();
    for (code, mask) in set.bricks() {
        builder.push(Morton(code), mask).unwrap();
    }
    builder.finish().unwrap().into_words()
}

#[test]
fn they_number_random_voxels_in_order() {
    for seed in 0..120 {
        let mut random = Rng::new(seed);
        let depth = (seed % 8) as u8;
        let most = [1, 3, 40, 2000][random.below(4) as usize];
        let voxels = random.below(most);
        let set = VoxelSet::new((0..voxels).map(|_| core::array::from_fn(|_| random.below(1 << depth) as u32)));
        each_scheme(&built(depth, &set), |scheme, voxels, rank| {
            assert_eq!(voxels, set.codes().len() as u64, "seed {seed}, {scheme}");
            if voxels == 0 {
                assert_eq!([0, 1, 64, u64::MAX].map(rank), [None; 4], "seed {seed}, {scheme}: nothing is filled");
            }
            for (i, &code) in set.codes().iter().enumerate() {
                assert_eq!(rank(code), Some(i as u64), "seed {seed}, {scheme}, voxel {code}");
                for empty in [code ^ 1, code ^ 8, code ^ 64, code ^ 1 << 40, code | 1 << 63, u64::MAX - code] {
                    if set.codes().binary_search(&empty).is_err() {
                        assert_eq!(rank(empty), None, "seed {seed}, {scheme}, no voxel at {empty}");
                    }
                }
            }
        });
    }
}

#[test]
fn full_cubes_of_every_depth_have_their_codes_as_ranks() {
    let mut random = Rng::new(1);
    for depth in 0..=21 {
        let last = (1 << (3 * depth)) - 1;
        let mut codes: Vec<u64> = (0..200).map(|_| random.bits() >> random.below(63) & last).collect();
        codes.extend([0, last, last / 2, last / 7 * 6]);
        for hole in [false, true] {
            if depth == 0 && hole {
                continue;
            }
            each_scheme(&words_of(&Full, depth, Some(&hole)), |scheme, voxels, rank| {
                assert_eq!(voxels, last + u64::from(!hole), "{scheme}, depth {depth}");
                for &code in &codes {
                    let expected = if hole { code.checked_sub(1) } else { Some(code) };
                    assert_eq!(rank(code), expected, "{scheme}, depth {depth}, code {code}");
                }
                assert_eq!(rank(last + 1), None, "{scheme}, depth {depth}: outside");
            });
        }
    }
}

#[test]
fn walls_in_the_largest_cube_are_counted_by_arithmetic() {
    // Voxels of x < h in the order of the curve: every bit of x that is set says how many come before.
    let mut random = Rng::new(2);
    for height in [1u64, 5, 64, 1 << 20, (1 << 21) - 1] {
        let words = Implicit::Wall { axis: 0, lo: 0, hi: height as i64 }.words(21);
        let below = |code: u64| -> u64 {
            // Of the 8^l cubes that the path passes by, those whose x lies under the height, voxel column by column.
            let mut count = 0u128;
            for level in (0..21u32).rev() {
                let corner = code >> (3 * level + 3) << (3 * level + 3);
                for octant in 0..code >> (3 * level) & 7 {
                    let x = u64::from(Morton(corner | octant << (3 * level)).decode()[0]);
                    count += u128::from(height.saturating_sub(x).min(1 << level)) << (2 * level);
                }
            }
            count as u64
        };
        let inside: Vec<[u32; 3]> = (0..300)
            .map(|_| [random.below(height), random.below(1 << 21), random.below(1 << 21)].map(|x| x as u32))
            .collect();
        each_scheme(&words, |scheme, voxels, rank| {
            assert_eq!(voxels, height << 42, "{scheme}, height {height}");
            for voxel in &inside {
                let code = Morton::encode(*voxel).unwrap().0;
                assert_eq!(rank(code), Some(below(code)), "{scheme}, height {height}, voxel {voxel:?}");
            }
        });
    }
}

#[test]
fn words_that_are_not_the_counts_are_refused() {
    let mut random = Rng::new(3);
    let shapes = [
        Implicit::Dust { at: [1, 2, 3] }.words(13),
        Implicit::Diagonal { lo: 900, hi: 1500 }.words(10),
        words_of(&Full, 21, Some(&true)),
        words_of(&Full, 2, Some(&false)),
    ];
    for words in &shapes {
        let dag = Dag::new(words).unwrap();
        let counts = Prefix::build(&dag).unwrap();
        assert_eq!(counts.len(), Prefix::words_for(&dag));
        // Lent memory gives the same words, and asks for as many as they are.
        let mut lent = vec![7; counts.len()];
        assert_eq!(Prefix::build_into(dag, &mut lent).unwrap().words(), counts);
        for len in [counts.len() + 1, counts.len().saturating_sub(1)] {
            if len != counts.len() {
                let expected = RankError::Length { expected: counts.len() as u64, found: len as u64 };
                assert_eq!(Prefix::build_into(dag, &mut vec![0; len]).unwrap_err(), expected);
                assert_eq!(Prefix::new(dag, &vec![0; len]).unwrap_err(), expected);
            }
        }
        // Every word is checked: no other value passes.
        for at in 0..counts.len() {
            let mut wrong = counts.clone();
            wrong[at] ^= 1 << random.below(32);
            let error = Prefix::new(dag, &wrong).unwrap_err();
            assert!(matches!(error, RankError::Count { .. }) && error.to_string().contains("count"), "word {at}");
        }
    }
}
