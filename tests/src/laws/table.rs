//! The material table against a map, and against the layout that its documentation describes.

use std::collections::BTreeMap;

use voxdag::Morton;
use voxdag::octahedral;
use voxdag::table::{Entry, InsertError, MAX_PROBES, Table, TableBuf, TableMut};

use super::Bytes;
use crate::table::{splitmix, unsplitmix};

/// A table that grows or one in lent memory holds what a map holds, refuses only what its limits refuse, and has the words
/// that the documentation derives from its entries.
///
/// Byte 0: bit 0 says with normals, bit 1 that it lies in lent memory; a u16 is the number of slots (modulo 700), or of
/// voxels. Then operations: a byte (modulo 4) for 0 an insertion, 1 a batch, 2 a batch of neighbours in hash order, 3 a
/// batch that several parts take; for 1 to 3 a byte with the number of keys, for 3 one with the number of parts (modulo 9).
/// A key takes a byte, by which (modulo 5) it is 0 a byte, 1 the last code less a byte, 2 any u64, 3 the code whose hash
/// is that of a byte's home slot and an offset byte, 4 the same for home slot 7.
pub fn table(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (flags, size) = (bytes.u8(), u64::from(bytes.u16()) % 700);
    let normals = flags & 1 != 0;
    let mut twin = Twin { entries: BTreeMap::new(), stride: if normals { 4 } else { 3 }, max_material: 0 };
    if flags & 2 == 0 {
        let mut table = TableBuf::new(size, normals).unwrap();
        while !bytes.is_empty() {
            if !grow_and_fill(&mut table, &mut twin, &mut bytes) {
                return;
            }
        }
        twin.check(&table.as_table());
        twin.check(&Table::new(table.as_table().words()).expect("a table's words are a table"));
    } else {
        let mut words = vec![0xdead_beef; Table::words_for(size, normals) as usize];
        let mut table = TableMut::new(&mut words, normals).unwrap();
        while !bytes.is_empty() {
            if !fill(&mut table, &mut twin, &mut bytes) {
                return;
            }
        }
        twin.check(&table.as_table());
        twin.check(&Table::new(table.finish().words()).expect("a table's words are a table"));
    }
}

/// One operation on a table that grows; false at its end.
fn grow_and_fill(table: &mut TableBuf, twin: &mut Twin, bytes: &mut Bytes<'_>) -> bool {
    let slots = table.as_table().slots();
    let operation = bytes.u8() % 4;
    if operation == 3 {
        return table.fill(|table| fill_apart(table, twin, bytes));
    }
    let entries = batch(operation, slots, bytes);
    let result = match entries[..] {
        [(voxel, entry)] if operation == 0 => table.insert(voxel, entry),
        _ => table.insert_all(entries.iter().copied()),
    };
    let grown = table.as_table().slots();
    // It doubles, and only to be half full at the most. (Growing comes before the refusal.)
    assert!(grown == slots || grown.is_multiple_of(slots) && (grown / slots).is_power_of_two(), "{slots} to {grown}");
    let taken = twin.insert_all(&entries, grown, u64::MAX);
    assert_eq!(result, taken);
    assert!(grown == slots || table.as_table().len() >= grown / 4, "grown without need");
    assert!(result.is_err() || grown == slots || table.as_table().len() <= grown / 2, "more than half full");
    true
}

/// One operation on a table of a fixed size; false at its end.
fn fill(table: &mut TableMut<'_>, twin: &mut Twin, bytes: &mut Bytes<'_>) -> bool {
    let operation = bytes.u8() % 4;
    if operation == 3 {
        return fill_apart(table, twin, bytes);
    }
    let slots = table.slots();
    let entries = batch(operation, slots, bytes);
    let result = match entries[..] {
        [(voxel, entry)] if operation == 0 => table.insert(voxel, entry),
        _ => table.insert_all(entries.iter().copied()),
    };
    assert_eq!(result, twin.insert_all(&entries, slots, slots - slots.div_ceil(8)));
    true
}

/// Lets parts take a batch; false if it was refused, which ends a table.
fn fill_apart(table: &mut TableMut<'_>, twin: &mut Twin, bytes: &mut Bytes<'_>) -> bool {
    let slots = table.slots();
    let entries = batch(1, slots, bytes);
    let parts = u32::from(bytes.u8() % 9);
    if parts == 0 {
        return true;
    }
    let filled: Result<Vec<_>, _> =
        table.split(parts).map(|mut part| part.insert_all(entries.iter().copied()).map(|()| part.finish())).collect();
    let result = filled.and_then(|parts| table.join(parts));
    let expected = twin.insert_all(&entries, slots, slots - slots.div_ceil(8));
    assert_eq!(result.is_ok(), expected.is_ok(), "{result:?} by parts, {expected:?} by one");
    result.is_ok()
}

/// The entries of one operation.
fn batch(operation: u8, slots: u64, bytes: &mut Bytes<'_>) -> Vec<(Morton, Entry)> {
    let count = if operation == 0 { 1 } else { bytes.u8() };
    let neighbours = (operation == 2).then(|| hash_at(u64::from(bytes.u8()), slots));
    (0..u64::from(count))
        .map(|i| {
            let key = match neighbours {
                // Every second hash is that of a code.
                Some(first) => unsplitmix(first.wrapping_add(i)).wrapping_sub(1) & !(1 << 63),
                None => key(slots, bytes),
            };
            let value = bytes.u8();
            let normal = match value % 4 {
                0 => None,
                axis => Some(core::array::from_fn(|k| if k + 1 == usize::from(axis) { -1.0 } else { 0.0 })),
            };
            (Morton(key), Entry { material: u16::from(value) << (value % 9), normal })
        })
        .collect()
}

fn key(slots: u64, bytes: &mut Bytes<'_>) -> u64 {
    match bytes.u8() % 5 {
        0 => u64::from(bytes.u8()),
        1 => (1 << 63) - 1 - u64::from(bytes.u8()),
        2 => bytes.u64(),
        kind => {
            let slot = if kind == 3 { u64::from(bytes.u8()) } else { 7 };
            unsplitmix(hash_at(slot, slots).wrapping_add(u64::from(bytes.u8()))).wrapping_sub(1)
        }
    }
}

/// The first hash whose home is a slot.
fn hash_at(slot: u64, slots: u64) -> u64 {
    let slots = slots.max(1);
    (u128::from(slot % slots) << 64).div_ceil(u128::from(slots)) as u64
}

/// What the table must hold: by the hash of the code, its code, material and normal.
struct Twin {
    entries: BTreeMap<u64, (u64, u16, u32)>,
    stride: usize,
    /// Of all that was ever inserted.
    max_material: u16,
}

impl Twin {
    /// Inserts in turn up to the first entry that a table with so many slots and at most so many entries refuses.
    fn insert_all(&mut self, entries: &[(Morton, Entry)], slots: u64, most: u64) -> Result<(), InsertError> {
        entries.iter().try_for_each(|&(voxel, entry)| {
            if voxel.0 >> 63 != 0 {
                return Err(InsertError::NotACode { voxel });
            }
            let hash = splitmix(voxel.0 + 1);
            let normal = entry.normal.filter(|_| self.stride == 4).map_or(0, octahedral::encode);
            let len = self.entries.len() as u64;
            let old = self.entries.insert(hash, (voxel.0, entry.material, normal));
            let refused = if old.is_none() && len >= most {
                Some(InsertError::Full { missing: (8 * (len + 1)).div_ceil(7) - slots })
            } else if self.layout(slots).is_none() {
                Some(InsertError::Crowded { voxel })
            } else {
                None
            };
            match refused {
                Some(error) => {
                    self.entries.remove(&hash);
                    Err(error)
                }
                None => {
                    self.max_material = self.max_material.max(entry.material);
                    Ok(())
                }
            }
        })
    }

    /// Where the entries stand: in order of their hashes, at home or right behind the one before. `None` if one would be
    /// too far from home.
    fn layout(&self, slots: u64) -> Option<Vec<u64>> {
        let mut free = 0;
        self.entries
            .keys()
            .map(|&hash| {
                let home = ((u128::from(hash) * u128::from(slots)) >> 64) as u64;
                let place = home.max(free);
                free = place + 1;
                (place - home < u64::from(MAX_PROBES)).then_some(place)
            })
            .collect()
    }

    /// The words, the look-ups and the counts.
    fn check(&self, table: &Table<'_>) {
        let slots = table.slots();
        let mut words = vec![0; Table::words_for(slots, self.stride == 4) as usize];
        (words[0], words[2], words[4]) = (self.stride as u32, slots as u32, self.entries.len() as u32);
        let layout = self.layout(slots).expect("nothing is too far from home");
        for (place, (&hash, &(code, material, normal))) in layout.into_iter().zip(&self.entries) {
            let home = ((u128::from(hash) * u128::from(slots)) >> 64) as u64;
            words[1] = words[1].max((place - home) as u32 + 1);
            let slot = [(code + 1) as u32, ((code + 1) >> 32) as u32, u32::from(material), normal];
            words[8 + place as usize * self.stride..][..self.stride].copy_from_slice(&slot[..self.stride]);

            let expected = Entry { material, normal: octahedral::decode(normal) };
            assert_eq!(table.get(Morton(code)), Some(expected), "code {code}");
            assert_eq!(table.probes(Morton(code)), (place - home) as u32 + 1, "probes of code {code}");
        }
        assert!(table.words() == words, "the words are not those of the documentation");
        assert_eq!(table.len(), self.entries.len() as u64);
        // Materials that were replaced may count, as nobody looks for the next greatest.
        let greatest = self.entries.values().map(|entry| entry.1).max().unwrap_or(0);
        assert!((greatest..=self.max_material).contains(&table.max_material()));
        for code in (0..256).chain((1 << 63) - 256..(1 << 63) + 3).chain([u64::MAX]) {
            let hash = splitmix(code.wrapping_add(1));
            let known = self.entries.get(&hash).filter(|entry| entry.0 == code);
            assert_eq!(table.get(Morton(code)).map(|e| e.material), known.map(|e| e.1), "code {code}");
            assert!(table.probes(Morton(code)) <= table.longest_probe());
        }
    }
}
