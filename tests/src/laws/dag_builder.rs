//! The DAG builders: streaming, in lent memory, and by joining subtrees, against a set of voxels.

use crate::octree::{VoxelSet, deinterleave};
use voxdag::build::{BuildError, DagBuilder, build_into, scratch_words, words_bound};
use voxdag::{Dag, Morton};

/// The DAG builder against a set of voxels.
///
/// Byte 0 is the depth (0 to 7), byte 1 the level at which subtrees are cut, byte 2 says which of them are appended whole;
/// every four bytes after that fill a cube: its side (1, 2 or 4) and its corner. The streaming builder, the builder in
/// lent memory, and subtrees joined must all give the words that the twin writes by the documentation alone.
pub fn dag_builder(data: &[u8]) {
    let [depth, cut, whole, cubes @ ..] = data else { return };
    let depth = depth % 8;
    let set = VoxelSet::new(cubes.chunks_exact(4).flat_map(|cube| filled(depth, cube)));
    let bricks: Vec<(Morton, u64)> = set.bricks().into_iter().map(|(code, mask)| (Morton(code), mask)).collect();

    let words = stream(depth, &bricks);
    assert_eq!(words, set.words(depth), "streamed bricks give other words than the documentation");
    assert_eq!(joined(depth, *cut, *whole, &bricks), words, "joined subtrees give other words");
    in_lent_memory(depth, &bricks, &words);
    limits(depth, &bricks, &words);
    queries(depth, &set, &words);
}

/// The voxels of the cube that four bytes describe, as far as they lie within `2^depth`.
fn filled(depth: u8, cube: &[u8]) -> impl Iterator<Item = [u32; 3]> {
    let (side, size) = (1u32 << (cube[0] % 3), 1u32 << depth);
    let corner = [cube[1], cube[2], cube[3]].map(|x| u32::from(x) & (size - 1));
    (0..side * side * side)
        .map(move |i| [corner[0] + i % side, corner[1] + i / side % side, corner[2] + i / (side * side)])
        .filter(move |voxel| voxel.iter().all(|&x| x < size))
}

fn stream(depth: u8, bricks: &[(Morton, u64)]) -> Vec<u32> {
    let mut builder = DagBuilder::new(depth).unwrap();
    for &(code, mask) in bricks {
        builder.push(code, mask).unwrap();
    }
    // What was given cannot be given again, and an empty brick is no brick.
    if let Some(&(code, mask)) = bricks.last() {
        assert_eq!(builder.push(code, mask), Err(BuildError::Order { code: code.0 }));
        assert_eq!(builder.push(code, 0), Ok(()));
    }
    builder.finish().unwrap().into_words()
}

/// Cuts the bricks into the subtrees of a level; appends some whole, and pushes the bricks of the others.
fn joined(depth: u8, cut: u8, whole: u8, bricks: &[(Morton, u64)]) -> Vec<u32> {
    let level = if depth <= 2 { depth } else { 2 + cut % (depth - 1) };
    let corner = |code: Morton| code.0 >> (3 * level.max(2)) << (3 * level.max(2));
    let mut builder = DagBuilder::new(depth).unwrap();
    for (i, subtree) in bricks.chunk_by(|a, b| corner(a.0) == corner(b.0)).enumerate() {
        let corner = corner(subtree[0].0);
        if whole >> (i % 8) & 1 == 0 {
            for &(code, mask) in subtree {
                builder.push(code, mask).unwrap();
            }
            continue;
        }
        let moved: Vec<_> = subtree.iter().map(|&(code, mask)| (Morton(code.0 - corner), mask)).collect();
        let words = stream(level, &moved);
        builder.append(Morton(corner), &Dag::new(&words).unwrap()).unwrap();
    }
    builder.finish().unwrap().into_words()
}

/// As much memory as the bounds say is enough; less is an error or, if it is enough all the same, the same words.
fn in_lent_memory(depth: u8, bricks: &[(Morton, u64)], expected: &[u32]) {
    const UNTOUCHED: u32 = 0xdead_beef;
    let mut words = vec![UNTOUCHED; words_bound(bricks.len(), depth)];
    let mut scratch = vec![UNTOUCHED; scratch_words(bricks.len(), depth)];
    let used = build_into(bricks.iter().copied(), depth, &mut words, &mut scratch).unwrap();
    assert_eq!(words[..used], *expected, "lent memory gives other words");
    assert!(words[used..].iter().all(|&word| word == UNTOUCHED), "words after the DAG were written");

    let needed = used as u64;
    assert_eq!(
        build_into(bricks.iter().copied(), depth, &mut words[..used - 1], &mut scratch),
        Err(BuildError::Words { needed })
    );
    let less = scratch.len() / 4;
    match build_into(bricks.iter().copied(), depth, &mut words, &mut scratch[..less]) {
        Ok(used) => assert_eq!(words[..used], *expected, "scarce scratch memory gives other words"),
        Err(BuildError::Scratch { needed }) => assert!(needed > less as u64, "{needed} words of scratch would do"),
        Err(other) => panic!("scarce scratch memory is reported as: {other}"),
    }
}

/// A limit of exactly the DAG's words is kept, one less is broken.
fn limits(depth: u8, bricks: &[(Morton, u64)], words: &[u32]) {
    if bricks.is_empty() {
        return;
    }
    for (spare, fits) in [(0, true), (1, false)] {
        let mut builder = DagBuilder::new(depth).unwrap();
        builder.limit(words.len() as u32 - spare);
        let built =
            bricks.iter().try_for_each(|&(code, mask)| builder.push(code, mask)).and_then(|()| builder.finish());
        match built {
            Ok(built) => assert!(fits && built.words() == words, "a limit was passed over"),
            Err(error) => assert!(!fits && matches!(error, BuildError::Words { .. }), "a limit led to: {error}"),
        }
    }
}

/// The view over the words answers for the set.
fn queries(depth: u8, set: &VoxelSet, words: &[u32]) {
    let dag = Dag::new(words).unwrap();
    assert_eq!((dag.depth(), dag.is_empty()), (depth, set.codes().is_empty()));
    assert!(dag.voxels().map(|voxel| voxel.0).eq(set.codes().iter().copied()), "voxels() is not the set in order");
    assert!(dag.bricks().map(|(code, mask)| (code.0, mask)).eq(set.bricks()), "bricks() are not the set's");

    // Every voxel and its neighbours, also those beyond the cube.
    for &code in set.codes() {
        assert!(dag.contains(Morton(code)), "a voxel is missing: {code}");
        for (axis, step) in (0..3).flat_map(|axis| [(axis, -1), (axis, 1)]) {
            let mut voxel = deinterleave(code);
            voxel[axis] = voxel[axis].wrapping_add_signed(step);
            if let Some(neighbour) = Morton::encode(voxel) {
                assert_eq!(dag.contains(neighbour), set.contains(voxel), "neighbour {voxel:?}");
            }
        }
    }

    // Counts, level by level; a DAG of depth 2 or less is one brick.
    let stats = dag.stats().unwrap();
    assert_eq!(stats.voxels, set.codes().len() as u64);
    for level in 0..22 {
        let (unique, octree) = if (2..=depth.max(2)).contains(&level) { set.level_counts(level) } else { (0, 0) };
        let found = stats.levels[usize::from(level)];
        assert_eq!((found.unique, found.octree), (unique as u64, octree as u64), "counts of level {level}");
    }
}
