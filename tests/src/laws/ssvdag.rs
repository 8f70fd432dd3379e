//! The SSVDAG against the plain DAG and its naive twin, and any words as an SSVDAG.

use voxdag::build::DagBuilder;
use voxdag::ssvdag::{Ssvdag, SsvdagBuf};
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::{Dag, Geometry, Morton};

use super::Bytes;
use crate::mirrors;
use crate::octree::VoxelSet;

/// The SSVDAG holds the same voxels as the plain DAG, no two nodes are mirror images, counts and rays are the same; and
/// words that are not its own are refused, or safe.
///
/// Byte 0 is the depth (modulo 8), byte 1 the number of changed words (modulo 4); a change takes a u16 for the place and a
/// u32 that is xored to the word. Byte 2 is a number of rays (modulo 4), each with origin and direction (see
/// `Bytes::float`). Then cubes: a byte whose low two bits give the side (1 to 8) and whose bits 2 to 4 name axes on which the
/// cube appears mirrored, too; and three bytes for the corner.
pub fn ssvdag(data: &[u8]) {
    let mut bytes = Bytes(data);
    let depth = bytes.u8() % 8;
    let changes: Vec<(u16, u32)> = (0..bytes.u8() % 4).map(|_| (bytes.u16(), bytes.u32())).collect();
    let size = f64::from(1u32 << depth);
    let rays = (0..bytes.u8() % 4).map(|_| Query::new(bytes.floats(size), bytes.floats(size))).collect::<Vec<_>>();
    let mut set = VoxelSet::default();
    while !bytes.is_empty() && set.codes().len() < 500 {
        let (shape, corner) = (bytes.u8(), bytes.array::<3>().map(|x| u32::from(x) % (1 << depth)));
        let side = 1u32 << (shape & 3);
        let cube =
            (0..side.pow(3)).map(|i| [corner[0] + i % side, corner[1] + i / side % side, corner[2] + i / side / side]);
        let cube = VoxelSet::new(cube.filter(|voxel| voxel.iter().all(|x| x >> depth == 0)));
        let cube = mirrors::with_images(&cube, depth, u32::from(shape >> 2 & 7));
        let both = set.codes().iter().chain(cube.codes());
        set = VoxelSet::new(both.map(|code| crate::octree::deinterleave(*code)));
    }

    let plain = set.words(depth);
    let dag = Dag::new(&plain).unwrap();
    let built = SsvdagBuf::build(&dag).unwrap();
    says_the_same(&set, dag, built.ssvdag(), &rays);
    assert_eq!(mirrors::voxels(built.words()), set, "the words mean other voxels by the documentation");
    let mut builder = DagBuilder::new(depth).unwrap();
    built.ssvdag().bricks().for_each(|(code, mask)| builder.push(code, mask).unwrap());
    assert_eq!(builder.finish().unwrap().words(), plain, "the way back to the plain DAG");

    let mut words = built.into_words();
    for (at, change) in changes {
        let at = usize::from(at) % words.len();
        words[at] ^= change;
    }
    if let Ok(other) = Ssvdag::new(&words) {
        assert!(other.voxels().take(5000).all(|voxel| other.contains(voxel)), "a voxel that it does not contain");
        assert!(other.empty_level(Morton(u64::MAX)).is_none());
        other.stats().unwrap();
        let top = TopBuf::new(&other, 2).unwrap();
        let tracers = [Tracer::new(other), Tracer::with_top(other, top.as_top()).unwrap()];
        for ray in &rays {
            let [a, b] = tracers.map(|tracer| tracer.trace(Arithmetic::Exact, ray));
            assert_eq!(a, b, "{ray:?}");
        }
    }
}

/// All that can be asked of both is answered alike.
pub fn says_the_same(set: &VoxelSet, dag: Dag<'_>, ssvdag: Ssvdag<'_>, rays: &[Query]) {
    let depth = dag.depth();
    assert_eq!((ssvdag.depth(), ssvdag.is_empty()), (depth, set.codes().is_empty()));
    assert!(ssvdag.bricks().eq(dag.bricks()), "other bricks");
    assert!(ssvdag.voxels().map(|voxel| voxel.0).eq(set.codes().iter().copied()), "other voxels");
    let beside = set.codes().iter().flat_map(|code| [*code, code ^ 1, code ^ 0o70, code + 1]);
    for voxel in beside.chain([0, u64::MAX, 1 << (3 * depth)]).map(Morton) {
        assert_eq!(ssvdag.contains(voxel), dag.contains(voxel), "{voxel:?}");
        assert_eq!(ssvdag.empty_level(voxel), dag.empty_level(voxel), "{voxel:?}");
    }

    // As many nodes as there are classes, and the octree's counts as ever.
    let stats = ssvdag.stats().unwrap();
    let expected = dag.stats().unwrap();
    assert_eq!(stats.voxels, expected.voxels);
    for level in 0..22u8 {
        let found = stats.levels[usize::from(level)];
        assert_eq!(found.octree, expected.levels[usize::from(level)].octree, "octree, level {level}");
        let stored = (2..=depth.max(2)).contains(&level);
        let classes = if stored { mirrors::classes(set, level) } else { 0 };
        assert_eq!(found.unique, classes as u64, "level {level}: not all mirror images are one, or too much is");
        assert_eq!(u64::from(ssvdag.node_count(level)), found.unique);
    }

    let (top, its_top) = (TopBuf::new(&dag, 2).unwrap(), TopBuf::new(&ssvdag, 2).unwrap());
    let tracer = Tracer::with_top(dag, top.as_top()).unwrap();
    let its = [Tracer::new(ssvdag), Tracer::with_top(ssvdag, its_top.as_top()).unwrap()];
    for ray in rays {
        for min_level in [0, 1, 2, 4] {
            let ray = Query { min_level, ..*ray };
            let expected = tracer.trace_counted(Arithmetic::Exact, &ray);
            assert_eq!(its[1].trace_counted(Arithmetic::Exact, &ray), expected, "{ray:?}");
            assert_eq!(its[0].trace(Arithmetic::Exact, &ray), expected.0, "{ray:?}");
            assert_eq!(its[1].occluded(Arithmetic::Exact, &ray), expected.0.is_some(), "{ray:?}");
        }
    }
}
