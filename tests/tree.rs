//! Laws of the material tree: it says what a map of all voxels says, whatever the words, and says it in little room.

use std::collections::BTreeMap;

use voxdag::build::BuildError;
use voxdag::tree::{HEADER, Tree, TreeBuf, TreeBuilder};
use voxdag::{Morton, file};
use voxdag_oracle::rng::Rng;

/// Materials of filled voxels, by Morton code.
type Map = BTreeMap<u64, u16>;

/// The map's bricks in order: code, mask, ids.
fn bricks(map: &Map) -> Vec<(u64, u64, Vec<u16>)> {
    let mut bricks: Vec<(u64, u64, Vec<u16>)> = Vec::new();
    for (&code, &id) in map {
        if bricks.last().is_none_or(|last| last.0 != code & !63) {
            bricks.push((code & !63, 0, Vec::new()));
        }
        let last = bricks.last_mut().unwrap();
        last.1 |= 1 << (code & 63);
        last.2.push(id);
    }
    bricks
}

fn build(depth: u8, map: &Map) -> TreeBuf {
    let mut builder = TreeBuilder::new(depth).unwrap();
    for (code, mask, ids) in bricks(map) {
        builder.push(Morton(code), mask, &ids).unwrap();
    }
    builder.finish().unwrap()
}

/// `voxels` voxels at random places of a cube of `2^depth`, their materials by a function of the place.
fn scattered(random: &mut Rng, depth: u8, voxels: usize, id: impl Fn(&mut Rng, [u32; 3]) -> u16) -> Map {
    let mut map = Map::new();
    for _ in 0..voxels {
        let v = std::array::from_fn(|_| random.below(1 << depth) as u32);
        let id = id(random, v);
        map.insert(Morton::encode(v).unwrap().0, id);
    }
    map
}

#[test]
fn it_says_what_the_map_says() {
    for seed in 0..200 {
        let mut random = Rng::new(seed);
        let depth = random.below(8) as u8;
        let (voxels, ids) = (random.below(3000) as usize, [1, 2, 3, 5, 20, 70, 65536][random.below(7) as usize]);
        let noise = random.below(2) == 0;
        let map = scattered(&mut random, depth, voxels, |random, v| match noise {
            true => random.below(ids) as u16,
            false => ((v[0] + 2 * v[1]) / 8 * 12347 % ids as u32) as u16,
        });
        let built = build(depth, &map);
        let tree = built.tree();
        for (&code, &id) in &map {
            assert_eq!(tree.get(Morton(code)), id, "seed {seed}, depth {depth}, code {code}");
        }
        assert_eq!(tree.depth(), depth, "seed {seed}");
        assert!(map.values().all(|id| *id <= tree.max_material()), "seed {seed}");
        assert_eq!(tree.get(Morton(1 << (3 * depth.max(2)))), 0, "seed {seed}: outside");
    }
}

#[test]
fn empty_voxels_answer_with_a_material_of_the_smallest_cube_around() {
    for seed in 0..60 {
        let mut random = Rng::new(seed);
        let depth = 2 + random.below(5) as u8;
        let voxels = 1 + random.below(200) as usize;
        let map = scattered(&mut random, depth, voxels, |random, v| match seed % 3 {
            0 => random.below(9) as u16,
            1 => u16::from(v[0] > v[1]),
            _ => (v[2] / 5) as u16,
        });
        let built = build(depth, &map);
        for _ in 0..2000 {
            let code = random.below(1 << (3 * u32::from(depth)));
            let cube = (0..=depth).map(|level| {
                let size = 1u64 << (3 * level);
                map.range(code / size * size..code / size * size + size).map(|(_, id)| *id).collect::<Vec<_>>()
            });
            let around = cube.into_iter().find(|ids| !ids.is_empty()).unwrap();
            let id = built.tree().get(Morton(code));
            // A brick is looked at as a whole: of two materials in it either may be the answer.
            let brick: Vec<_> = map.range(code & !63..(code & !63) + 64).map(|(_, id)| *id).collect();
            assert!(around.contains(&id) || brick.contains(&id), "seed {seed}, code {code}: {id} of {around:?}");
        }
    }
}

#[test]
fn words_depend_on_the_voxels_alone() {
    let mut random = Rng::new(7);
    let map = scattered(&mut random, 6, 3000, |_, v| (v[0] / 20) as u16);
    let built = build(6, &map);
    assert_eq!(built.words(), build(6, &map).words());
    // Bricks of one material may be given as such.
    let mut builder = TreeBuilder::new(6).unwrap();
    for (code, mask, ids) in bricks(&map) {
        if ids.iter().all(|id| *id == ids[0]) {
            builder.push_uniform(Morton(code), ids[0]).unwrap();
        } else {
            builder.push(Morton(code), mask, &ids).unwrap();
        }
    }
    assert_eq!(builder.finish().unwrap().words(), built.words());
}

#[test]
fn uniform_cubes_are_one_entry_and_borders_are_shared() {
    // One material, however many voxels: the header and the top table.
    let mut builder = TreeBuilder::new(10).unwrap();
    for code in 0..1000 {
        builder.push_uniform(Morton(64 * code * 31), 9).unwrap();
    }
    assert_eq!(builder.finish().unwrap().words().len(), HEADER + 512);

    // A floor of two materials whose border runs along a voxel plane: the same bits everywhere along it, whatever the two
    // materials are and on which side each is.
    let floor = |first: u16, second: u16| {
        (0..256u32).flat_map(move |x| (0..256u32).map(move |y| ([x, y, 5], if x < 101 { first } else { second })))
    };
    let map = |voxels: &mut dyn Iterator<Item = ([u32; 3], u16)>| -> Map {
        voxels.map(|(v, id)| (Morton::encode(v).unwrap().0, id)).collect()
    };
    let one = build(8, &map(&mut floor(1, 2)));
    let swapped = build(8, &map(&mut floor(2, 1)));
    let others = build(8, &map(&mut floor(700, 3)));
    assert!(one.words().len() < HEADER + 64 + 40, "{} words", one.words().len());
    assert_eq!(one.words().len(), swapped.words().len());
    assert_eq!(one.words().len(), others.words().len());
}

#[test]
fn many_patterns_need_wide_places() {
    let mut random = Rng::new(11);
    let mut builder = TreeBuilder::new(8).unwrap();
    let mut map = Vec::new();
    for brick in 0..40_000u64 {
        // Full bricks whose bits differ cannot be merged.
        let bits = random.bits() | 1 << 63;
        let ids: Vec<u16> = (0..64).map(|bit| 3 + (bits >> bit & 1) as u16).collect();
        builder.push(Morton(64 * brick), u64::MAX, &ids).unwrap();
        map.push(ids);
    }
    let built = builder.finish().unwrap();
    for (brick, ids) in map.iter().enumerate() {
        for (bit, id) in ids.iter().enumerate() {
            assert_eq!(built.tree().get(Morton(64 * brick as u64 + bit as u64)), *id, "brick {brick}, voxel {bit}");
        }
    }
}

#[test]
fn any_words_are_refused_or_harmless() {
    let mut random = Rng::new(13);
    let (mut refused, mut taken) = (0, 0);
    for _ in 0..3000 {
        let ids = 2 + random.below(40);
        let map = scattered(&mut random, 5, 600, |random, v| match v[0] < 9 {
            true => random.below(ids) as u16,
            false => (v[1] / 3) as u16,
        });
        let mut words = build(5, &map).words().to_vec();
        for _ in 0..1 + random.below(3) {
            let at = random.below(words.len() as u64) as usize;
            match random.below(4) {
                0 => words[at] ^= 1 << random.below(32),
                1 => words[at] = random.bits() as u32,
                2 => words[at] = words[random.below(words.len() as u64) as usize],
                _ => words.truncate(at),
            }
            if words.is_empty() {
                break;
            }
        }
        match Tree::new(&words) {
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
            Ok(tree) => {
                taken += 1;
                for _ in 0..200 {
                    assert!(tree.get(Morton(random.below(1 << 17))) <= tree.max_material());
                }
                assert_eq!(tree.get(Morton(u64::MAX)), 0);
            }
        }
    }
    assert!(refused > 500 && taken > 500, "{refused} refused, {taken} taken");
}

#[test]
fn what_is_out_of_place_is_refused() {
    assert_eq!(TreeBuilder::new(22).err(), Some(BuildError::Depth { found: 22 }));
    let mut builder = TreeBuilder::new(3).unwrap();
    builder.push_uniform(Morton(128), 1).unwrap();
    for code in [64, 128] {
        assert_eq!(builder.push_uniform(Morton(code), 1), Err(BuildError::Order { code }));
    }
    for code in [65, 512] {
        assert_eq!(builder.push(Morton(code), 1, &[1]), Err(BuildError::Outside { code }));
    }
    // What was refused left no trace.
    let built = builder.finish().unwrap();
    assert_eq!(built.tree().max_material(), 1);
}

#[test]
fn bricks_without_voxels_are_passed_over() {
    let map = Map::from([(0, 5), (64, 7), (512, 6), (513, 5)]);
    let mut builder = TreeBuilder::new(4).unwrap();
    for (code, mask, ids) in bricks(&map) {
        // With and without ids, also with voxels that have none and ids that have no voxel.
        builder.push(Morton(code), 0, &[]).unwrap();
        builder.push(Morton(code), 0, &[4]).unwrap();
        builder.push(Morton(code), 0, &[4, 9]).unwrap();
        builder.push(Morton(code), mask, &[]).unwrap();
        builder.push(Morton(code), mask | 1 << 63, &[&ids[..], &[]].concat()).unwrap();
    }
    for code in [1024, 4032] {
        builder.push(Morton(code), 0, &[8]).unwrap();
    }
    let built = builder.finish().unwrap();
    assert_eq!(built.words(), build(4, &map).words());
    let mut builder = TreeBuilder::new(2).unwrap();
    builder.push(Morton(0), 1, &[4, 7]).unwrap();
    assert_eq!(builder.finish().unwrap().words(), build(2, &Map::from([(0, 4)])).words());
}

#[test]
fn bits_without_meaning_are_refused() {
    // An odd number of halves leaves half a word.
    let odd = (1..40u16).find_map(|n| {
        let map: Map = (0..64 * u64::from(n)).map(|code| (code, u16::from(code % 64 < u64::from(n)))).collect();
        let words = build(5, &map).words().to_vec();
        (words[26] % 2 == 1).then_some(words)
    });
    let mut junk = odd.expect("some tree has an odd number of halves");
    assert!(Tree::new(&junk).is_ok());
    *junk.last_mut().unwrap() |= 0x8000_0000;
    assert!(Tree::new(&junk).is_err());
    // Halves in a level above the root.
    let mut above = build(4, &Map::from([(0, 1)])).words().to_vec();
    above[8 + 5..27].fill(2);
    above.push(0);
    assert!(matches!(Tree::new(&above), Err(voxdag::tree::TreeError::Header { word: 13 })));
}

#[test]
fn a_file_keeps_it_from_version_2_on() {
    use voxdag::file::{LoadError, Parts};
    use voxdag::grid::{Bounds, UpAxis};
    use voxdag::materials::AnyMaterials;
    use voxdag::{Grid, Material};

    let mut dag = voxdag::build::DagBuilder::new(3).unwrap();
    dag.push(Morton(64), 0b101).unwrap();
    let dag = dag.finish().unwrap();
    let tree = build(3, &Map::from([(64, 1), (66, 0)]));
    let parts = |tree: &TreeBuf| {
        let parts = Parts {
            grid: Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 8 },
            bounds: Bounds { min: [0.0; 3], max: [8.0; 3] },
            up: UpAxis::Y,
            metres_per_unit: 0.0,
            geometry: dag.dag().into(),
            voxel_materials: AnyMaterials::Tree(tree.tree()),
            colors: None,
            materials: &[Material::GREY; 2],
            names: &["a", "b"],
        };
        parts.to_vec()
    };
    let words = parts(&tree).unwrap();
    let AnyMaterials::Tree(read) = file::read(&words).unwrap().materials else { panic!("no tree came back") };
    assert_eq!(read.words(), tree.words());
    assert_eq!((words[1], read.get(Morton(64)), read.get(Morton(66))), (2, 1, 0));
    // The tree of another cube, or one that names a material that does not exist.
    let deeper = build(4, &Map::from([(64, 1)]));
    assert!(matches!(parts(&deeper), Err(file::WriteError::Invalid(LoadError::TreeDepth { expected: 3, found: 4 }))));
    let unknown = build(3, &Map::from([(64, 2)]));
    assert!(matches!(parts(&unknown), Err(file::WriteError::Invalid(LoadError::MaterialId { count: 2, found: 2 }))));
}
