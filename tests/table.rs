//! Laws of the material table: it is a map, look-ups stay short on every family of keys, nothing spins, and the words
//! depend on the set of entries alone. Names begin with the row of the catalogue of hard cases that they cover; H5 has
//! none, as nothing is ever deleted.

use std::collections::HashMap;
use voxdag::Morton;
use voxdag::table::{Entry, InsertError, MAX_PROBES, Table, TableBuf, TableError, TableMut};

/// Numbers from a 64-bit linear congruential generator, high half only.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        let mut half = || {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            self.0 >> 32
        };
        half() << 32 | half()
    }

    fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, (self.next() % (i as u64 + 1)) as usize);
        }
    }
}

fn entry(material: u16) -> Entry {
    Entry { material, normal: None }
}

fn code(p: [u32; 3]) -> u64 {
    Morton::encode(p).unwrap().0
}

/// Sets of keys that break weaker hashes, most of them what surfaces look like.
fn families() -> Vec<(&'static str, Vec<u64>)> {
    const N: u64 = 65_536;
    let plane = |f: fn(u32, u32) -> [u32; 3]| (0..N as u32).map(|i| code(f(i & 255, i >> 8))).collect::<Vec<_>>();
    let shell = (0..250u32.pow(3)).map(|i| [i % 250, i / 250 % 250, i / 62_500]).filter(|p| {
        let r2: i64 = p.iter().map(|&c| (i64::from(c) - 125).pow(2)).sum();
        (119 * 119..=120 * 120).contains(&r2)
    });
    // The inverse of the golden ratio's multiplier: keys that multiplicative hashing sends to one place.
    let phi = 0x9e37_79b9_7f4a_7c15;
    let inverse = invert(phi);
    let mut random = Random(7);
    vec![
        ("dense block", (0..N).collect()),
        ("multiples of 8", (0..N).map(|i| 8 * i).collect()),
        ("plane z = 777", plane(|x, y| [x, y, 777])),
        ("plane x = 2^21 - 1", plane(|y, z| [(1 << 21) - 1, y << 13, z << 13])),
        ("diagonal plane", plane(|x, y| [x, y, x + y])),
        ("line", (0..N as u32).map(|i| code([5, 9, 31 * i])).collect()),
        ("sphere shell", shell.map(code).collect()),
        ("shifted by 40", (0..N).map(|i| i << 40).collect()),
        ("last codes", (0..N).map(|i| (1 << 63) - 1 - i).collect()),
        (
            "against Fibonacci",
            (1..).map(|i: u64| i.wrapping_mul(inverse)).filter(|k| k >> 63 == 0).take(20_000).collect(),
        ),
        ("random", (0..N).map(|_| random.next() >> 1).collect()),
    ]
}

/// The inverse of an odd number modulo 2^64, by Newton's method.
fn invert(odd: u64) -> u64 {
    (0..6).fold(odd, |x, _| x.wrapping_mul(2u64.wrapping_sub(odd.wrapping_mul(x))))
}

/// The code whose key has a hash: the finaliser undone, step by step.
fn unhash(hash: u64) -> Option<u64> {
    let unshift = |z: u64, by: u32| (0..64 / by).fold(z, |x, _| z ^ x >> by);
    let z = unshift(hash, 31).wrapping_mul(invert(0x94d0_49bb_1331_11eb));
    let z = unshift(z, 27).wrapping_mul(invert(0xbf58_476d_1ce4_e5b9));
    unshift(z, 30).checked_sub(1).filter(|code| code >> 63 == 0)
}

/// Codes whose home is `slot` of `slots`, by ascending hash.
fn homed_at(slot: u64, slots: u64) -> impl Iterator<Item = u64> {
    let first = (u128::from(slot) << 64).div_ceil(u128::from(slots)) as u64;
    (first..).filter_map(unhash)
}

#[test]
fn h03_look_ups_are_short_on_every_family() {
    for (name, keys) in families() {
        let mut table = TableBuf::new(keys.len() as u64, false).unwrap();
        table.insert_all(keys.iter().map(|&k| (Morton(k), entry(k as u16)))).unwrap();
        let table = table.as_table();
        assert_eq!(table.len(), keys.len() as u64, "{name}");
        let probes: u64 = keys.iter().map(|&k| u64::from(table.probes(Morton(k)))).sum();
        let mean = probes as f64 / keys.len() as f64;
        assert!(mean <= 1.6 && table.longest_probe() <= 20, "{name}: mean {mean}, longest {}", table.longest_probe());
        for &k in &keys {
            assert_eq!(table.get(Morton(k)), Some(entry(k as u16)), "{name}");
        }
        let mut random = Random(11);
        for _ in 0..1000 {
            assert!(table.probes(Morton(random.next())) <= table.longest_probe(), "{name}");
        }
    }
}

#[test]
fn it_is_the_map_that_std_has() {
    for seed in 0..20 {
        let mut random = Random(seed);
        let mut buf = TableBuf::new(seed * 3, true).unwrap();
        let mut map = HashMap::new();
        for _ in 0..random.next() % 3000 {
            let key = random.next() % 2000 + [0, (1 << 63) - 2000][(random.next() & 1) as usize];
            let axis = (random.next() % 4) as usize;
            let normal = (axis < 3).then(|| std::array::from_fn(|i| if i == axis { -1.0 } else { 0.0 }));
            let value = Entry { material: random.next() as u16, normal };
            buf.insert(Morton(key), value).unwrap();
            map.insert(key, value);
        }
        let words = buf.into_words();
        let table = Table::new(&words).unwrap();
        assert_eq!(table.len(), map.len() as u64, "seed {seed}");
        for key in (0..2000).chain((1 << 63) - 2000..1 << 63) {
            assert_eq!(table.get(Morton(key)), map.get(&key).copied(), "seed {seed}, key {key}");
        }
        let greatest = map.values().map(|e| e.material).max().unwrap_or(0);
        assert_eq!(table.max_material(), greatest, "seed {seed}");
    }
}

#[test]
fn h08_words_depend_on_the_set_alone() {
    let mut random = Random(3);
    for (name, keys) in families() {
        for (count, slots) in [(100, 115), (2000, 2300), (2000, 4000)] {
            let mut entries: Vec<_> = keys[..count].iter().map(|&k| (Morton(k), entry(k as u16))).collect();
            let fill = |entries: &[(Morton, Entry)], batched: bool| {
                let mut words = vec![0xdead_beef; Table::words_for(slots, false) as usize];
                let mut table = TableMut::new(&mut words, false).unwrap();
                assert_eq!(table.slots(), slots);
                if batched {
                    table.insert_all(entries.iter().copied()).unwrap();
                } else {
                    entries.iter().for_each(|&(k, e)| table.insert(k, e).unwrap());
                }
                assert_eq!(Table::new(table.finish().words()).map(|t| t.len()), Ok(count as u64), "{name}");
                words
            };
            let once = fill(&entries, true);
            random.shuffle(&mut entries);
            assert_eq!(fill(&entries, false), once, "{name}, {count} in {slots}");
            entries.reverse();
            assert_eq!(fill(&entries, true), once, "{name}, {count} in {slots}");
        }
    }
}

/// Fills a table with as many threads as there are parts.
fn fill_apart(table: &mut TableMut<'_>, entries: &[(Morton, Entry)], parts: u32) -> Result<(), InsertError> {
    let filled: Result<Vec<_>, _> = std::thread::scope(|scope| {
        let threads = table
            .split(parts)
            .map(|mut part| scope.spawn(move || part.insert_all(entries.iter().copied()).map(|()| part.finish())));
        threads.collect::<Vec<_>>().into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    table.join(filled?)
}

#[test]
fn h08_threads_write_the_words_that_one_writes() {
    let mut random = Random(9);
    for (count, slots) in [(0, 0), (1, 2), (7, 8), (50, 58), (300, 343), (5000, 5800), (5000, 10_000)] {
        for parts in [1, 2, 3, 8, 61] {
            let mut entries: Vec<_> = (0..count)
                .map(|k| (Morton(k * k), Entry { material: k as u16, normal: Some([0.6, 0.0, -0.8]) }))
                .collect();
            let mut expected = vec![0; Table::words_for(slots, true) as usize];
            TableMut::new(&mut expected, true).unwrap().insert_all(entries.iter().copied()).unwrap();
            random.shuffle(&mut entries);
            // A key that comes twice keeps its last value.
            let twice: Vec<_> = entries.iter().map(|&(k, _)| (k, entry(0))).chain(entries.iter().copied()).collect();
            let mut words = vec![0; expected.len()];
            fill_apart(&mut TableMut::new(&mut words, true).unwrap(), &twice, parts).unwrap();
            assert!(words == expected, "{count} in {slots}, {parts} parts");
        }
    }
    let too_many: Vec<_> = (0..8).map(|k| (Morton(k), entry(1))).collect();
    let mut words = vec![0; Table::words_for(8, true) as usize];
    let mut table = TableMut::new(&mut words, true).unwrap();
    assert_eq!(fill_apart(&mut table, &too_many, 3), Err(InsertError::Full { missing: 2 }));
    // A table on the heap is filled the same way, beyond half if need be, and still grows after that.
    let mut buf = TableBuf::new(4, false).unwrap();
    buf.fill(|table| fill_apart(table, &too_many[..7], 2)).unwrap();
    assert_eq!((buf.as_table().slots(), buf.as_table().max_material()), (8, 1));
    buf.insert_all(too_many).unwrap();
    assert_eq!((buf.as_table().slots(), Table::new(buf.as_table().words()).map(|t| t.len())), (16, Ok(8)));
    // Entries that were there before stay.
    let mut table = TableMut::new(&mut words, true).unwrap();
    table.insert(Morton(1000), entry(5)).unwrap();
    let part = table.split(1).next().map(|mut part| part.insert_all([(Morton(1), entry(2))]).map(|()| part.finish()));
    table.join(part.unwrap()).unwrap();
    let table = Table::new(table.finish().words()).unwrap();
    assert_eq!((table.len(), table.get(Morton(1)), table.get(Morton(1000))), (2, Some(entry(2)), Some(entry(5))));
}

#[test]
fn growing_does_not_depend_on_the_order() {
    let mut entries: Vec<_> = (0..5000).map(|i| (Morton(i * 77), entry(i as u16))).collect();
    let mut grown = |batched: bool| {
        let mut table = TableBuf::new(10, false).unwrap();
        if batched {
            table.insert_all(entries.iter().chain(&entries).copied()).unwrap();
        } else {
            Random(5).shuffle(&mut entries);
            entries.iter().for_each(|&(k, e)| table.insert(k, e).unwrap());
        }
        table.into_words()
    };
    let words = grown(true);
    assert_eq!(words, grown(false));
    assert_eq!(Table::new(&words).unwrap().slots(), 20 << 9);
    // A key that is there needs no room.
    let mut table = TableBuf::new(1, false).unwrap();
    (0..9).for_each(|i| table.insert(Morton(4), entry(i)).unwrap());
    assert_eq!((table.as_table().slots(), table.as_table().get(Morton(4))), (2, Some(entry(8))));
}

#[test]
fn h04_a_full_table_says_so_and_stays_as_it_was() {
    for slots in [0, 1, 2, 7, 8, 9, 64, 500, 1000] {
        let mut words = vec![0; Table::words_for(slots, false) as usize];
        let mut table = TableMut::new(&mut words, false).unwrap();
        let most = slots * 7 / 8;
        table.insert_all((0..most).map(|k| (Morton(k), entry(1)))).unwrap();
        let before = table.as_table().words().to_vec();
        let Err(InsertError::Full { missing }) = table.insert(Morton(most), entry(1)) else { panic!("{slots} slots") };
        assert!((slots + missing) * 7 / 8 == most + 1 && (slots + missing - 1) * 7 / 8 == most, "{slots} + {missing}");
        assert!(table.insert_all([(Morton(most), entry(1))]).is_err());
        assert_eq!(table.as_table().words(), before);
        // What is there can still be replaced, and what is not is not found.
        if most > 0 {
            table.insert(Morton(0), entry(9)).unwrap();
            assert_eq!(table.as_table().get(Morton(0)), Some(entry(9)));
        }
        let table = table.finish();
        assert!(Table::new(table.words()).is_ok());
        for key in most..most + 1000 {
            assert_eq!(table.get(Morton(key)), None);
            assert!(table.probes(Morton(key)) <= table.longest_probe());
        }
    }
}

#[test]
fn h06_sizes_beyond_memory_and_short_words_are_errors() {
    for len in 0..8 {
        let mut words = vec![0; len];
        assert_eq!(TableMut::new(&mut words, false).unwrap_err(), InsertError::Full { missing: 1 });
        assert!(matches!(Table::new(&words), Err(TableError::Truncated { expected: 8, .. })));
    }
    let huge = TableBuf::new(1 << 60, true).unwrap_err();
    assert!(matches!(huge, InsertError::Memory { bytes } if bytes > 1 << 62));
}

#[test]
fn h03_keys_made_to_collide_are_refused_after_a_bounded_search() {
    for slot in [0, 1000, 4095] {
        let mut words = vec![0; Table::words_for(4096, false) as usize];
        let mut table = TableMut::new(&mut words, false).unwrap();
        let keys: Vec<_> = homed_at(slot, 4096).take(MAX_PROBES as usize + 1).collect();
        let (last, keys) = keys.split_last().unwrap();
        // Backwards, so that every insertion moves the whole run.
        keys.iter().rev().for_each(|&k| table.insert(Morton(k), entry(3)).unwrap());
        assert_eq!(table.insert(Morton(*last), entry(3)), Err(InsertError::Crowded { voxel: Morton(*last) }));
        let table = table.finish();
        assert_eq!(Table::new(table.words()).unwrap().longest_probe(), MAX_PROBES);
        assert!(keys.iter().enumerate().all(|(i, &k)| table.probes(Morton(k)) == i as u32 + 1));
        assert_eq!((table.get(Morton(*last)), table.probes(Morton(*last))), (None, MAX_PROBES));
    }
}

#[test]
fn h02_key_0_and_the_last_are_stored_and_no_code_is_refused() {
    let mut table = TableBuf::new(10, false).unwrap();
    for voxel in [Morton(u64::MAX), Morton(1 << 63)] {
        assert_eq!(table.insert(voxel, entry(0)), Err(InsertError::NotACode { voxel }));
        assert_eq!(table.insert_all([(Morton(1), entry(2)), (voxel, entry(0))]), Err(InsertError::NotACode { voxel }));
        assert_eq!(table.as_table().get(voxel), None);
    }
    assert_eq!(table.as_table().get(Morton(1)), Some(entry(2)), "entries before the refused one are in");
    for voxel in [Morton(0), Morton((1 << 63) - 1)] {
        assert_eq!(table.as_table().get(voxel), None);
        table.insert(voxel, entry(7)).unwrap();
        assert_eq!(table.as_table().get(voxel), Some(entry(7)));
    }
}

/// The words of a table without normals whose slots hold these keys, in the places they are given; its header is right.
fn by_hand(slots: u64, longest: u32, keys: &[(u64, u64)]) -> Vec<u32> {
    let mut words = vec![0; Table::words_for(slots, false) as usize];
    (words[0], words[1], words[2], words[4]) = (3, longest, slots as u32, keys.len() as u32);
    for &(place, key) in keys {
        words[8 + 3 * place as usize..][..2].copy_from_slice(&[key as u32, (key >> 32) as u32]);
    }
    words
}

#[test]
fn h1_h3_h4_layouts_that_no_writer_makes_are_refused() {
    // Three codes of one home, in the order of their hashes, are a table; in any other order, or doubled, they are none.
    let [a, b, c]: [u64; 3] = core::array::from_fn(|i| homed_at(5, 64).nth(i).unwrap() + 1);
    assert!(Table::new(&by_hand(64, 3, &[(5, a), (6, b), (7, c)])).is_ok());
    for [x, y, z] in [[a, c, b], [b, a, c], [c, b, a], [a, a, b], [a, b, b]] {
        let words = by_hand(64, 3, &[(5, x), (6, y), (7, z)]);
        let result = Table::new(&words);
        assert!(matches!(result, Err(TableError::Order { .. })), "{result:?}");
    }
    for places in [[4, 5, 6], [6, 7, 8], [5, 6, 8], [5, 7, 8]] {
        let words = by_hand(64, 4, &[(places[0], a), (places[1], b), (places[2], c)]);
        let result = Table::new(&words);
        assert!(matches!(result, Err(TableError::Order { .. })), "{places:?}: {result:?}");
    }
    // As far from home as an entry may be, and one further.
    let run =
        |count: u64| -> Vec<_> { homed_at(5, 4096).take(count as usize).zip(5..).map(|(k, at)| (at, k + 1)).collect() };
    assert!(Table::new(&by_hand(4096, 256, &run(256))).is_ok());
    assert_eq!(Table::new(&by_hand(4096, 257, &run(257))).err(), Some(TableError::Order { word: 8 + 3 * 261 }));
    // More than 7/8 full.
    let full: Vec<_> = (0..8).map(|home| (home, homed_at(home, 8).next().unwrap() + 1)).collect();
    assert!(Table::new(&by_hand(8, 1, &full[..7])).is_ok());
    assert_eq!(Table::new(&by_hand(8, 1, &full)).err(), Some(TableError::Header { word: 4 }));
    // A key that is no code plus 1.
    let last = |key: u64| {
        let home = ((u128::from(voxdag_oracle::table::splitmix(key)) * 8) >> 64) as u64;
        Table::new(&by_hand(8, 1, &[(home, key)])).map(|table| table.len())
    };
    assert_eq!(last(1 << 63), Ok(1));
    for key in [(1 << 63) + 1, u64::MAX] {
        assert!(matches!(last(key), Err(TableError::Slot { .. })));
    }
}

/// A change is refused, or makes another table: every entry that its slots hold is found.
#[test]
fn every_flipped_bit_is_refused_or_harmless() {
    for normals in [false, true] {
        let mut buf = TableBuf::new(12, normals).unwrap();
        let full = Entry { material: 5, normal: Some([0.0, 1.0, 0.0]) };
        buf.insert_all((0..12).map(|k| (Morton(k * k * k), full))).unwrap();
        let words = buf.into_words();
        let stride = words[0] as usize;
        let (mut values, mut keys) = (0, 0);
        for bit in 0..32 * words.len() {
            let mut bad = words.clone();
            bad[bit / 32] ^= 1 << (bit % 32);
            let Ok(table) = Table::new(&bad) else { continue };
            let slots = bad[8..].chunks_exact(stride).filter(|slot| slot[0] | slot[1] != 0);
            for slot in slots.clone() {
                let key = (u64::from(slot[0]) | u64::from(slot[1]) << 32) - 1;
                assert_eq!(table.get(Morton(key)).map(|e| u32::from(e.material)), Some(slot[2]), "bit {bit}");
            }
            assert_eq!(slots.count(), 12, "bit {bit}");
            *if (bit / 32 - 8) % stride < 2 { &mut keys } else { &mut values } += 1;
        }
        // 16 bits of material each, and all bits of a normal but the one that makes its half 0. One changed key in about
        // as many as there are slots still has the same place.
        assert_eq!(values, 12 * if normals { 16 + 31 } else { 16 });
        assert!(keys < 12 * 64 / 6, "{keys}");
        for len in 0..words.len() {
            assert!(matches!(Table::new(&words[..len]), Err(TableError::Truncated { .. })), "{len}");
        }
        let long: Vec<_> = words.iter().copied().chain([0]).collect();
        assert!(matches!(Table::new(&long), Err(TableError::Trailing { .. })));
    }
}
