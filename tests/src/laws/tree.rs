//! The material tree against a map, and any words as a tree.

use std::collections::BTreeMap;

use voxdag::Morton;
use voxdag::tree::{Tree, TreeBuilder};

use super::{Bytes, bricks};

/// The tree says what the map says, of empty voxels a material of the smallest cube around them, and words that are not
/// its own are refused or answer within the materials that they name.
///
/// Byte 0 is the depth (modulo 8), byte 1 the number of changed words (modulo 4); a change takes a u16 for the place and a u32
/// for the word. Then cubes of one material: a byte whose low four bits give the side (2^(modulo 5)) and whose bit 4 says
/// that every second voxel is left out, three bytes for the corner, and a byte for the material.
pub fn tree(data: &[u8]) {
    let mut bytes = Bytes(data);
    let depth = bytes.u8() % 8;
    let changes: Vec<(u16, u32)> = (0..bytes.u8() % 4).map(|_| (bytes.u16(), bytes.u32())).collect();
    let mut map = BTreeMap::new();
    while !bytes.is_empty() && map.len() < 20_000 {
        let (shape, corner, id) = (bytes.u8(), bytes.array::<3>(), u16::from(bytes.u8()));
        let side = 1u32 << (shape % 16 % 5);
        for i in 0..side.pow(3) {
            let v = [i % side, i / side % side, i / side / side];
            let v: [u32; 3] = std::array::from_fn(|k| (u32::from(corner[k]) + v[k]) % (1 << depth));
            if shape & 16 == 0 || (v[0] + v[1] + v[2]).is_multiple_of(2) {
                map.insert(Morton::encode(v).unwrap().0, id);
            }
        }
    }

    let mut builder = TreeBuilder::new(depth).unwrap();
    for (code, mask, ids) in bricks(&map) {
        builder.push(code, mask, &ids).unwrap();
    }
    let built = builder.finish().unwrap();
    let tree = built.tree();
    for (&code, &id) in &map {
        assert_eq!(tree.get(Morton(code)), id, "voxel {code}");
    }
    assert_eq!(tree.max_material(), map.values().copied().max().unwrap_or(0), "the largest id");
    for code in (0..1u64 << (3 * depth)).step_by(7).take(500) {
        let around = (2..=depth.max(2)).find_map(|level| {
            let first = code >> (3 * level) << (3 * level);
            let ids: Vec<u16> = map.range(first..first + (1 << (3 * level))).map(|(_, id)| *id).collect();
            (!ids.is_empty()).then_some(ids)
        });
        let id = tree.get(Morton(code));
        assert!(around.map_or(id == 0, |ids| ids.contains(&id)), "voxel {code} of no filled one around: {id}");
    }

    let mut words = built.words().to_vec();
    for (at, word) in changes {
        let at = usize::from(at) % words.len();
        words[at] = word;
    }
    if let Ok(tree) = Tree::new(&words) {
        for code in (0..1 << 12).chain([u64::MAX, 1 << 62]) {
            assert!(tree.get(Morton(code)) <= tree.max_material());
        }
    }
}
