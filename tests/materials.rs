//! Materials by rank: known sizes and answers, what is refused, and the thesis's accounting; that all representations
//! agree is the law `materials`.

use voxdag::build::{BuildError, DagBuf, DagBuilder};
use voxdag::rank::Prefix;
use voxdag::ranked::{Moxels, MoxelsBuf, Packed, PackedBuf, Palettes, PalettesBuf, Ranked, RankedError, Values};
use voxdag::table::Entry;
use voxdag::{Materials, Morton, thesis};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;

fn built(depth: u8, set: &VoxelSet) -> DagBuf {
    let mut builder = DagBuilder::new(depth).unwrap();
    for (code, mask) in set.bricks() {
        builder.push(Morton(code), mask).unwrap();
    }
    builder.finish().unwrap()
}

/// Entries of the voxels 0, 1, 2, ... of the curve.
fn entries(ids: &[u16]) -> impl Iterator<Item = (Morton, Entry)> {
    (0..).zip(ids).map(|(code, &id)| (Morton(code), Entry { material: id, normal: None }))
}

#[test]
fn ids_take_as_many_bits_as_the_largest() {
    for (largest, bits) in [(0, 0), (1, 1), (2, 2), (3, 2), (4, 3), (31, 5), (32, 6), (65535, 16)] {
        for count in [1, 7, 32, 33, 1000] {
            let mut ids = vec![largest / 2; count];
            ids[count - 1] = largest;
            let packed = PackedBuf::from_entries(entries(&ids)).unwrap();
            let view = packed.as_packed();
            assert_eq!((view.bits(), view.max_material(), view.count()), (bits, largest, count as u64));
            assert_eq!(view.words().len(), 4 + (count * bits as usize).div_ceil(32));
            assert!(ids.iter().zip(0..).all(|(id, rank)| view.id(rank) == *id), "{count} ids to {largest}");
            assert_eq!(Packed::new(view.words()).unwrap().words(), view.words());
        }
    }
}

#[test]
fn words_depend_on_the_ids_alone() {
    // However late the widest id comes, and whatever was packed before it.
    let mut random = Rng::new(1);
    for _ in 0..50 {
        let ids: Vec<u16> = (0..random.below(300)).map(|_| (random.bits() >> (48 + random.below(16))) as u16).collect();
        let all = PackedBuf::from_entries(entries(&ids)).unwrap();
        let mut expected = vec![all.as_packed().bits(), 0, ids.len() as u32, 0];
        let mut bits = 0u128;
        let mut held = 0;
        for id in ids {
            bits |= u128::from(id) << held;
            held += expected[0];
            while held >= 32 {
                expected.push(bits as u32);
                (bits, held) = (bits >> 32, held - 32);
            }
        }
        if held > 0 {
            expected.push(bits as u32);
        }
        assert_eq!(all.into_words(), expected);
    }
}

#[test]
fn blocks_pay_for_the_materials_they_have() {
    // Of one material: an entry. Of two: a bit a voxel, and a word for both ids. Of 256: a byte a voxel.
    let words = |ids: &[u16]| PalettesBuf::from_entries(entries(ids)).unwrap().into_words().len();
    assert_eq!(words(&[]), 4);
    assert_eq!(words(&[65535; 256]), 4 + 1);
    assert_eq!(words(&[7; 2560]), 4 + 10);
    let mut two = [7; 512];
    two[500] = 65535;
    assert_eq!(words(&two), 4 + 2 + 256 / 32 + 1);
    let many: Vec<u16> = (0..256).map(|i| i * 251).collect();
    assert_eq!(words(&many), 4 + 1 + 256 / 4 + 128);
    let palettes = PalettesBuf::from_entries(entries(&many)).unwrap();
    assert!(many.iter().zip(0..).all(|(id, rank)| palettes.as_palettes().id(rank) == *id));
}

#[test]
fn entries_must_ascend() {
    let entry = Entry { material: 3, normal: None };
    for codes in [[5, 5], [6, 5], [u64::MAX, 0]] {
        let list = || codes.map(|code| (Morton(code), entry));
        let order = BuildError::Order { code: codes[1] };
        assert_eq!(PackedBuf::from_entries(list()).unwrap_err(), order);
        assert_eq!(PalettesBuf::from_entries(list()).unwrap_err(), order);
        assert_eq!(MoxelsBuf::from_entries(list(), true).unwrap_err(), order);
    }
}

#[test]
fn an_array_fits_as_many_voxels_as_it_has() {
    let set = VoxelSet::new((0..50).map(|i| [i, 63 - i, 7]));
    let dag = built(6, &set);
    let counts = Prefix::build(&dag.dag()).unwrap();
    let prefix = Prefix::new(dag.dag(), &counts).unwrap();
    for count in [0, 49, 51] {
        let packed = PackedBuf::from_entries(entries(&vec![1; count])).unwrap();
        let error = Ranked::new(prefix, packed.as_packed()).unwrap_err();
        assert_eq!(error, RankedError::Voxels { expected: 50, found: count as u64 });
    }
    let ids: Vec<u16> = (0..50).map(|i| 1 + i % 7).collect();
    let packed = PackedBuf::from_entries(entries(&ids)).unwrap();
    let ranked = Ranked::new(prefix, packed.as_packed()).unwrap();
    for (i, &code) in set.codes().iter().enumerate() {
        assert_eq!((ranked.id(Morton(code)), ranked.id(Morton(code ^ 1 << 6))), (ids[i], 0), "voxel {code}");
    }
    assert_eq!(ranked.values().words(), packed.as_packed().words());
    assert_eq!(ranked.rank().words(), counts);
}

#[test]
fn packed_words_that_mean_nothing_are_refused() {
    let words = PackedBuf::from_entries(entries(&[5, 1, 4])).unwrap().into_words();
    assert_eq!(words, [3, 0, 3, 0, 5 | 1 << 3 | 4 << 6]);
    let with = |at: usize, word: u32| {
        let mut words = words.clone();
        words[at] = word;
        Packed::new(&words).map(|packed| packed.count()).unwrap_err()
    };
    assert_eq!(with(0, 17), RankedError::Header { word: 0 });
    assert_eq!(with(0, 6), RankedError::Header { word: 0 }); // 4 bits would do for what that says
    assert_eq!(with(1, 1), RankedError::Header { word: 1 });
    assert_eq!(with(3, 0x8000_0001), RankedError::Header { word: 3 });
    assert_eq!(with(2, 11), RankedError::Length { expected: 6, found: 5 });
    assert_eq!(with(2, 0), RankedError::Length { expected: 4, found: 5 });
    assert_eq!(with(3, 0x2000_0000), RankedError::Length { expected: 0x0300_0000_0000_0005, found: 5 });
    assert_eq!(with(3, 0x7fff_ffff), RankedError::Length { expected: u64::MAX, found: 5 });
    assert_eq!(with(4, words[4] | 1 << 9), RankedError::Value { word: 4 });
    assert_eq!(Packed::new(&words[..3]).unwrap_err(), RankedError::Length { expected: 4, found: 3 });
    // Ids that take no room may be as many as the largest cube has.
    let (none, full) = ([0, 0, 0, 0], [0, 0, 0, 0x8000_0000]);
    assert_eq!(Packed::new(&none).map(|p| (p.count(), p.id(0))), Ok((0, 0)));
    assert_eq!(Packed::new(&full).map(|p| (p.count(), p.id(1 << 62))), Ok((1 << 63, 0)));
}

#[test]
fn palette_words_that_mean_nothing_are_refused() {
    // Three ids in one block, one in another that is not full.
    let ids: Vec<u16> = (0..300).map(|i| if i < 256 { [9, 4, 8][i % 3] } else { 2 }).collect();
    let words = PalettesBuf::from_entries(entries(&ids)).unwrap().into_words();
    assert_eq!((words.len(), &words[..6]), (4 + 2 + 16 + 2, &[300, 0, 9, 0, 2 << 28, 2][..]));
    assert_eq!(words[22..], [9 | 4 << 16, 8]);
    let with = |at: usize, word: u32| {
        let mut words = words.clone();
        words[at] = word;
        Palettes::new(&words).map(|palettes| palettes.count()).unwrap_err()
    };
    assert_eq!(with(0, 600), RankedError::Value { word: 7 }); // the block's first word became an entry
    assert_eq!(with(0, 256), RankedError::Value { word: 5 }); // the second entry became its first word
    assert_eq!(with(1, 1), RankedError::Length { expected: 4 + (300 + (1u64 << 32)).div_ceil(256), found: 24 });
    assert_eq!(with(1, 0x8000_0000), RankedError::Header { word: 1 });
    assert_eq!(with(2, 10), RankedError::Header { word: 2 });
    assert_eq!(with(3, 1), RankedError::Header { word: 3 });
    assert_eq!(with(4, 9 << 28), RankedError::Value { word: 4 });
    assert_eq!(with(4, 2 << 28 | 1), RankedError::Value { word: 4 });
    assert_eq!(with(4, 7), RankedError::Length { expected: 6, found: 24 });
    assert_eq!(with(5, 10), RankedError::Header { word: 2 });
    assert_eq!(with(5, 1 << 16), RankedError::Header { word: 2 });
    assert_eq!(with(6, words[6] | 3), RankedError::Value { word: 6 }); // index 3 of three
    assert_eq!(with(23, 8 | 1 << 16), RankedError::Value { word: 23 });
    // 65536 is no id, whatever the header says.
    let single = |id: u32| Palettes::new(&[1, 0, id, 0, id]).map(|palettes| palettes.max_material());
    assert_eq!((single(65535), single(65536)), (Ok(65535), Err(RankedError::Header { word: 2 })));
    // Two voxels of two ids: an index behind them, and more bits than two ids ask for.
    let two = |indices: &[u32]| {
        let width = indices.len() as u32 / 8;
        Palettes::new(&[&[2, 0, 5, 0, width << 28], indices, &[3 | 5 << 16]].concat()).map(|palettes| palettes.id(1))
    };
    assert_eq!(two(&[2, 0, 0, 0, 0, 0, 0, 0]), Ok(5));
    assert_eq!(two(&[2 | 1 << 31, 0, 0, 0, 0, 0, 0, 0]), Err(RankedError::Value { word: 5 }));
    assert_eq!(two(&[2, 0, 0, 0, 0, 0, 1, 0]), Err(RankedError::Value { word: 11 }));
    assert_eq!(two(&[&[1 << 2][..], &[0; 15]].concat()), Err(RankedError::Value { word: 4 }));
    assert_eq!(Palettes::new(&words[..22]).unwrap_err(), RankedError::Length { expected: 24, found: 22 });
    assert_eq!(Palettes::new(&words[..10]).unwrap_err(), RankedError::Length { expected: 22, found: 10 });
}

#[test]
fn moxel_tables_have_the_stated_entries() {
    let axis = Entry { material: 7, normal: Some([0.0, 0.0, 2.0]) };
    let none = Entry { material: 9, normal: None };
    let list = || [(Morton(4), axis), (Morton(9), none)];
    let with = MoxelsBuf::from_entries(list(), true).unwrap();
    let without = MoxelsBuf::from_entries(list(), false).unwrap();
    let up = voxdag::octahedral::encode([0.0, 0.0, 1.0]);
    assert_eq!(with.as_moxels().words(), [2, 9, 2, 0, 7, up, 9, 0]);
    assert_eq!(without.as_moxels().words(), [1, 9, 2, 0, 7, 9]);
    assert_eq!([with.as_moxels().has_normals(), without.as_moxels().has_normals()], [true, false]);
    assert_eq!((with.as_moxels().normal(0), with.as_moxels().normal(1)), (Some([0.0, 0.0, 1.0]), None));
    assert_eq!(without.as_moxels().normal(0), None);
    let words = with.into_words();
    for (at, word, error) in [
        (0, 3, RankedError::Header { word: 0 }),
        (0, 1, RankedError::Length { expected: 6, found: 8 }),
        (1, 8, RankedError::Header { word: 1 }),
        (2, 3, RankedError::Length { expected: 10, found: 8 }),
        (3, u32::MAX, RankedError::Length { expected: u64::MAX, found: 8 }),
        (4, 65536, RankedError::Value { word: 4 }),
        (7, 5, RankedError::Value { word: 6 }),
    ] {
        let mut words = words.clone();
        words[at] = word;
        assert_eq!(Moxels::new(&words).map(|moxels| moxels.count()).unwrap_err(), error, "word {at}: {word}");
    }
}

/// Table 5.2 and 5.6 from Williams's counts of the bunny's voxels.
#[test]
fn the_thesis_counts_entries_of_4_12_16_and_24_bytes() {
    let mb = |bytes: u64| (bytes as f64 / 1048576.0).round() as u32;
    let of = |voxels| {
        [
            thesis::hash_table_bytes(voxels, true),
            thesis::moxel_table_bytes(voxels, true),
            thesis::hash_table_bytes(voxels, false),
        ]
    };
    assert_eq!(
        [512_257, 2_052_473, 8_219_159].map(|voxels| of(voxels).map(mb)),
        [[12, 8, 6], [47, 31, 23], [188, 125, 94]]
    );
    assert_eq!(thesis::moxel_table_bytes(1000, false), 4000);
}

#[test]
fn the_thesis_counts_nodes_masks_and_pointers_of_8_bytes() {
    for seed in 0..40 {
        let mut random = Rng::new(seed);
        let depth = 2 + (seed % 5) as u8;
        let set = VoxelSet::new((0..1 + random.below(400)).map(|_| {
            let side = 1u64 << depth;
            core::array::from_fn(|_| random.below(side) as u32)
        }));
        let dag = built(depth, &set);
        // From the voxels: unique cubes and, level by level, the different children of different cubes.
        let unique = |level: u8| set.level_counts(level).0 as u64;
        let mut expected = 8 * unique(2);
        let mut with_counts = expected;
        for level in 3..=depth {
            let pointers: u64 = set.unique_octants(level);
            expected += 8 * (unique(level) + pointers);
            // Seven counts of 6, 9, 12, 15 bits and a mask of 8.
            let words = [1, 2, 2, 2][usize::from(level) - 3];
            with_counts += 8 * (words * unique(level) + pointers);
        }
        assert_eq!(thesis::svdag_bytes(&dag.dag()), expected, "seed {seed}");
        assert_eq!(thesis::moxel_dag_bytes(&dag.dag()), with_counts, "seed {seed}");
        let octree: u64 = (1..=depth).map(|level| set.level_counts(level).1 as u64).sum();
        assert_eq!(thesis::svo_bytes_without_pointers(&dag.dag()), octree, "seed {seed}");
    }
    // One node a level: seven counts of 6 to 27 bits beside the mask, two words more at most, from either end.
    let path = |depth| built(depth, &VoxelSet::new([[0; 3]]));
    for (depth, right) in [(3, 0), (4, 1), (6, 3), (7, 5), (10, 11)] {
        let dag = path(depth);
        let [plain, counts, quoted] = [thesis::svdag_bytes, thesis::moxel_dag_bytes, thesis::moxel_dag_bytes_quoted]
            .map(|bytes| bytes(&dag.dag()));
        assert_eq!(plain, 8 + 16 * (u64::from(depth) - 2));
        assert_eq!((counts - plain, quoted - plain), (8 * right, 8 * right), "depth {depth}");
    }
    // Many low nodes and one root: the quoted sum charges the low ones for the root.
    let many = built(5, &VoxelSet::new((0..64).map(|i| [i % 32, i / 2, (i * 7) % 32])));
    let low = many.dag().stats().unwrap().levels[3].unique;
    let middle = many.dag().stats().unwrap().levels[4].unique;
    assert_eq!(thesis::moxel_dag_bytes(&many.dag()) - thesis::svdag_bytes(&many.dag()), 8 * (middle + 1));
    assert_eq!(thesis::moxel_dag_bytes_quoted(&many.dag()) - thesis::svdag_bytes(&many.dag()), 8 * (low + middle));
}
