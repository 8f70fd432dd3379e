//! Every representation of materials against a map, and any words as one.

use std::collections::BTreeMap;

use voxdag::build::DagBuilder;
use voxdag::materials::Single;
use voxdag::rank::{MoxelDagBuf, OffsetsBuf, Prefix};
use voxdag::ranked::{Moxels, MoxelsBuf, Packed, PackedBuf, Palettes, PalettesBuf, Ranked, Values};
use voxdag::table::{Entry, TableBuf};
use voxdag::tree::TreeBuilder;
use voxdag::{Materials, Morton, Rank, octahedral};

use super::{Bytes, bricks};

/// All representations say of every filled voxel what the map says; those by rank say material 0 of all others; words
/// that were changed are refused or answer within the materials that they name.
///
/// Byte 0 is the depth (modulo 8), byte 1 the number of changed words (modulo 4); a change takes a byte for which
/// words, a u16 for the place and a u32 that is xored in. Then cubes of voxels: a byte whose low four bits give the
/// side (2^(modulo 5)), whose bit 4 says that every second voxel is left out and whose bit 5 that each voxel's material
/// is one higher than that of the last; three bytes for the corner, and a u16 for the material.
pub fn materials(data: &[u8]) {
    let mut bytes = Bytes(data);
    let depth = bytes.u8() % 8;
    let changes: Vec<(u8, u16, u32)> = (0..bytes.u8() % 4).map(|_| (bytes.u8(), bytes.u16(), bytes.u32())).collect();
    let mut map = BTreeMap::new();
    while !bytes.is_empty() && map.len() < 20_000 {
        let (shape, corner, id) = (bytes.u8(), bytes.array::<3>(), bytes.u16());
        let side = 1u32 << (shape % 16 % 5);
        for i in 0..side.pow(3) {
            let v = [i % side, i / side % side, i / side / side];
            let v: [u32; 3] = std::array::from_fn(|k| (u32::from(corner[k]) + v[k]) % (1 << depth));
            let id = if shape & 32 == 0 { id } else { id.wrapping_add(i as u16) };
            if shape & 16 == 0 || (v[0] + v[1] + v[2]).is_multiple_of(2) {
                map.insert(Morton::encode(v).unwrap().0, id);
            }
        }
    }
    agree(depth, &map, &changes);
}

/// The entry of a voxel: its normal is as good as random, and one in eight has none.
fn entry(code: u64, id: u16) -> Entry {
    let bits = crate::table::splitmix(code);
    let part = |shift: u32| (bits >> shift & 0xff) as f32 - 127.5;
    Entry { material: id, normal: (bits >> 61 != 0).then(|| [part(0), part(8), part(16)]) }
}

fn agree(depth: u8, map: &BTreeMap<u64, u16>, changes: &[(u8, u16, u32)]) {
    let entries = || map.iter().map(|(&code, &id)| (Morton(code), entry(code, id)));
    // The DAG and the tree, brick by brick.
    let (mut dag, mut tree) = (DagBuilder::new(depth).unwrap(), TreeBuilder::new(depth).unwrap());
    for (code, mask, ids) in bricks(map) {
        dag.push(code, mask).unwrap();
        tree.push(code, mask, &ids).unwrap();
    }
    let (dag, tree) = (dag.finish().unwrap(), tree.finish().unwrap());
    let dag = dag.dag();
    let counts = Prefix::build(&dag).unwrap();
    let prefix = Prefix::new(dag, &counts).unwrap();
    let (offsets, moxel_dag) = (OffsetsBuf::build(&dag).unwrap(), MoxelDagBuf::build(&dag).unwrap());

    let tables = [true, false].map(|normals| {
        let mut table = TableBuf::new(map.len() as u64, normals).unwrap();
        table.insert_all(entries()).unwrap();
        table
    });
    let packed = PackedBuf::from_entries(entries()).unwrap();
    let palettes = PalettesBuf::from_entries(entries()).unwrap();
    let moxels = [true, false].map(|normals| MoxelsBuf::from_entries(entries(), normals).unwrap());
    let largest = map.values().copied().max().unwrap_or(0);
    let most = [
        packed.as_packed().max_material(),
        palettes.as_palettes().max_material(),
        moxels[0].as_moxels().max_material(),
    ];
    assert_eq!(most, [largest; 3], "the largest id");

    // Their words are views, too, and the same ones.
    let words = [packed.as_packed().words(), palettes.as_palettes().words(), moxels[0].as_moxels().words()];
    let packed_again = Packed::new(words[0]).expect("packed ids");
    let palettes_again = Palettes::new(words[1]).expect("palettes");
    let moxels_again = Moxels::new(words[2]).expect("a moxel table");

    ids(map, "table with normals", tables[0].as_table(), false);
    ids(map, "table", tables[1].as_table(), false);
    ids(map, "tree", tree.tree(), false);
    ids(map, "packed", ranked(prefix, packed.as_packed()), true);
    ids(map, "packed, by offsets", ranked(offsets.as_offsets(), packed_again), true);
    ids(map, "palettes", ranked(prefix, palettes.as_palettes()), true);
    ids(map, "palettes, by moxel index", ranked(moxel_dag.as_moxel_dag(), palettes_again), true);
    ids(map, "moxel table with normals", ranked(moxel_dag.as_moxel_dag(), moxels_again), true);
    ids(map, "moxel table", ranked(prefix, moxels[1].as_moxels()), true);
    if map.values().all(|id| *id == largest) {
        ids(map, "single", Single(largest), false);
    }
    let (with, without) = (ranked(prefix, moxels[0].as_moxels()), ranked(prefix, moxels[1].as_moxels()));
    for (voxel, entry) in entries() {
        let normal = entry.normal.and_then(|n| octahedral::decode(octahedral::encode(n)));
        assert_eq!(tables[0].as_table().normal(voxel), normal, "normal in the table, voxel {voxel:?}");
        assert_eq!((with.normal(voxel), without.normal(voxel)), (normal, None), "normal, voxel {voxel:?}");
    }

    // Any words are refused or harmless.
    let mut changed = words.map(<[u32]>::to_vec);
    for &(which, at, bits) in changes {
        let words = &mut changed[usize::from(which) % 3];
        let at = usize::from(at) % words.len();
        words[at] ^= bits;
    }
    harmless(Packed::new(&changed[0]));
    harmless(Palettes::new(&changed[1]));
    harmless(Moxels::new(&changed[2]));
}

fn ranked<R: Rank, V: Values>(rank: R, values: V) -> Ranked<R, V> {
    Ranked::new(rank, values).expect("a value for each voxel")
}

/// The ids of all filled voxels, and of some that may be empty; these have material 0 if `sure`.
fn ids(map: &BTreeMap<u64, u16>, name: &str, materials: impl Materials, sure: bool) {
    for (&code, &id) in map {
        assert_eq!(materials.id(Morton(code)), id, "{name}: voxel {code}");
        for other in [code ^ 1, code + 64, code | 1 << 63] {
            let found = materials.id(Morton(other));
            assert!(!sure || map.contains_key(&other) || found == 0, "{name}: material {found} of empty voxel {other}");
        }
    }
}

fn harmless<V: Values, E: core::error::Error>(values: Result<V, E>) {
    match values {
        Ok(values) => {
            for rank in (0..values.count().min(3000)).chain([values.count(), u64::MAX]) {
                assert!(values.id(rank) <= values.max_material(), "id of rank {rank}");
                assert!(rank < values.count() || values.normal(rank).is_none(), "normal of rank {rank}");
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
