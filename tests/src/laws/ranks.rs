//! Ranks in self-similar cubes of any depth against counting by the rules, and any words as prefix counts.

use voxdag::rank::{MoxelDagBuf, OffsetsBuf, Prefix};
use voxdag::svo::SvoBuf;
use voxdag::{Dag, Geometry, Morton, Rank};

use super::Bytes;
use super::traversal::{Rule, SelfSimilar};

/// Every scheme gives a voxel the number of filled voxels before it; the geometries with counts in them and the octree
/// have the DAG's bricks; words that are not the DAG's counts are refused.
///
/// Byte 0 is the depth (modulo 22), byte 1 the number of rules less one (modulo 8), byte 2 that of changed words
/// (modulo 4). Each rule takes five bytes as in the law of traversal, each change a u16 for the place and a u32 that is
/// xored in. Then come codes, eight bytes each, of which the bits above the cube are cleared in every second one.
pub fn ranks(data: &[u8]) {
    let mut bytes = Bytes(data);
    let depth = bytes.u8() % 22;
    let (rules, changes) = (1 + bytes.u8() % 8, bytes.u8() % 4);
    let rules: Vec<Rule> = (0..rules).map(|_| Rule { mask: bytes.u8().max(1), octants: bytes.u32() }).collect();
    let changes: Vec<(u16, u32)> = (0..changes).map(|_| (bytes.u16(), bytes.u32())).collect();
    let shape = SelfSimilar { rules, depth };
    let words = shape.words();
    let dag = Dag::new(&words).expect("the twin's words are a DAG");
    let counts = shape.counts();

    let prefix_words = Prefix::build(&dag).unwrap();
    let prefix = Prefix::new(dag, &prefix_words).expect("the DAG's counts");
    let (offsets, moxels) = (OffsetsBuf::build(&dag).unwrap(), MoxelDagBuf::build(&dag).unwrap());
    let (offsets, moxels) = (offsets.as_offsets(), moxels.as_moxel_dag());
    let svo = SvoBuf::build(&dag, 1 << 16).ok();
    let voxels = counts[usize::from(depth)][0];
    assert_eq!([prefix.count(), offsets.count(), moxels.count()], [voxels; 3], "voxels of all");
    for i in 0..64 {
        if bytes.is_empty() {
            break;
        }
        let code = if i % 2 == 0 { bytes.u64() & ((1 << (3 * depth)) - 1) } else { bytes.u64() };
        let voxel = Morton(code);
        let truth = shape.rank(&counts, code);
        assert_eq!([prefix.rank(voxel), offsets.rank(voxel), moxels.rank(voxel)], [truth; 3], "rank of {code}");
        let brick = dag.brick(voxel);
        assert_eq!([offsets.brick(voxel), moxels.brick(voxel)], [brick; 2], "brick around {code}");
        let level = dag.empty_level(voxel);
        assert_eq!([offsets.empty_level(voxel), moxels.empty_level(voxel)], [level; 2], "emptiness at {code}");
        if let Some(svo) = &svo {
            assert_eq!(
                (svo.as_svo().brick(voxel), svo.as_svo().empty_level(voxel)),
                (brick, level),
                "octree at {code}"
            );
        }
    }

    let mut changed = prefix_words.clone();
    for (at, bits) in changes {
        let at = usize::from(at) % changed.len().max(1);
        if let Some(word) = changed.get_mut(at) {
            *word ^= bits;
        }
    }
    assert_eq!(Prefix::new(dag, &changed).is_ok(), changed == prefix_words, "other counts");
}

impl SelfSimilar {
    /// By level and rule: the filled voxels of a cube.
    fn counts(&self) -> Vec<Vec<u64>> {
        let mut counts = vec![vec![1; self.rules.len()]];
        for level in 1..=usize::from(self.depth) {
            let below = &counts[level - 1];
            let of =
                |rule: u8| (0..8).filter_map(|octant| self.octant(rule, octant)).map(|r| below[usize::from(r)]).sum();
            counts.push((0..self.rules.len() as u8).map(of).collect());
        }
        counts
    }

    /// The filled voxels before the one at `code`, if that is filled.
    fn rank(&self, counts: &[Vec<u64>], code: u64) -> Option<u64> {
        if code >> (3 * self.depth) != 0 {
            return None;
        }
        let (mut rule, mut before) = (0, 0);
        for level in (0..self.depth).rev() {
            let octant = (code >> (3 * level)) as u32 & 7;
            let earlier = (0..octant).filter_map(|octant| self.octant(rule, octant));
            before += earlier.map(|r| counts[usize::from(level)][usize::from(r)]).sum::<u64>();
            rule = self.octant(rule, octant)?;
        }
        Some(before)
    }
}
