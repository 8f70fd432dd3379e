//! What the structures of the thesis take by its own accounting (Pineda 2021, tables 5.2 and 5.6), for any scene.
//!
//! In: a DAG or a number of voxels. Out: bytes; the thesis's KB are 1024 of them, its MB 1024^2. Its nodes are a child
//! mask of 8 bytes and 8 bytes a pointer, down to leaves of 4^3 voxels in 8 bytes, as our bricks. Empty counts go into
//! the 7 bytes that masks leave, and into words of 8 bytes behind them: for 7 children as many bits as the volume of a
//! child asks for.
//!
//! The bunny at 256, 512, 1024^3: SVDAG 143, 498, 1721 KB (quoted 144, 497, 1712), with empty counts 149, 518, 1799 KB
//! (3.7, 4.0, 4.5 % more). Quoted are 178, 639, 2262 KB: to within 1 % what comes out, 180, 641, 2272 KB, if the words
//! by level are read from the wrong end. It does not explain Sponza and Conference, quoted with 53 to 65 and 37 to 43 %
//! more than their SVDAGs (which are up to 1.5 times ours, on a lattice that is not known): that sum gives 26 to 32 and
//! 24 to 30 %.

use crate::dag::{BRICK_LEVEL, Dag};

/// Nodes: masks and pointers of 8 bytes, and leaves of 4^3 voxels in 8 bytes.
pub fn svdag_bytes(dag: &Dag<'_>) -> u64 {
    let nodes = dag.words().len() - dag.level_start(BRICK_LEVEL + 1);
    8 * (u64::from(dag.brick_count()) + nodes as u64)
}

/// Words of 8 bytes for a node's empty counts: seven of 3 bits a level that a child has below it, beside a mask of 8
/// bits. More than two, which only levels from 10 on would take, have no room in Williams's node.
const fn count_words(level: u8) -> u64 {
    let bits = 8 + 7 * 3 * (level as u64 - 1);
    let words = bits.div_ceil(64) - 1;
    if words > 2 { 2 } else { words }
}

/// Bytes with the empty counts of a node of a level in so many words as `of` says.
fn with_counts(dag: &Dag<'_>, of: impl Fn(u8) -> u64) -> u64 {
    let counts: u64 = (BRICK_LEVEL + 1..=dag.depth()).map(|level| dag.stored(level).count() as u64 * of(level)).sum();
    svdag_bytes(dag) + 8 * counts
}

/// The moxel DAG: as the SVDAG, and empty counts as wide as each level asks for.
pub fn moxel_dag_bytes(dag: &Dag<'_>) -> u64 {
    with_counts(dag, count_words)
}

/// The moxel DAG by the sum that the thesis quotes: the root's nodes are charged as the lowest level's, and so on.
pub fn moxel_dag_bytes_quoted(dag: &Dag<'_>) -> u64 {
    with_counts(dag, |level| count_words(dag.depth() + BRICK_LEVEL + 1 - level))
}

/// The octree without pointers: a byte a node, down to the masks of 2^3 voxels.
pub fn svo_bytes_without_pointers(dag: &Dag<'_>) -> u64 {
    let (mut nodes, mut last) = (0, None);
    for (code, mask) in dag.bricks() {
        // The masks of 2^3 voxels, and the cubes from 4^3 up to the root that this brick is the first one of.
        nodes += (0..64).step_by(8).filter(|byte| mask >> byte & 0xff != 0).count() as u64;
        let fresh = match last {
            None => u32::from(dag.depth().max(BRICK_LEVEL)),
            Some(last) => (63 - u64::leading_zeros(code.0 ^ last)) / 3,
        };
        nodes += u64::from(fresh + 1) - u64::from(BRICK_LEVEL);
        last = Some(code.0);
    }
    nodes
}

/// Bytes of a value: a material index, and with a normal three floats.
const fn value(normals: bool) -> u64 {
    if normals { 16 } else { 4 }
}

/// The hash table: a key of 64 bits and a value for each voxel, as if it had no empty slot.
pub const fn hash_table_bytes(voxels: u64, normals: bool) -> u64 {
    voxels.saturating_mul(8 + value(normals))
}

/// The moxel table: a value for each voxel.
pub const fn moxel_table_bytes(voxels: u64, normals: bool) -> u64 {
    voxels.saturating_mul(value(normals))
}
