//! Laying a material tree out in words.
//!
//! Bricks of two that agree wherever both have voxels become one pattern, also if one has to be swapped: from the fullest
//! to the emptiest each joins the first that suits (first fit, among the first [`CANDIDATES`]; full ones differ and are not
//! compared). Then cubes are numbered anew from the bricks upwards, and what has become equal is kept once.

use alloc::vec::Vec;

use super::grow::{Cubes, INSIDE, NOTHING, ONES, TreeBuf, VACANT, ZEROS};
use super::{HEADER, ID, INNER, MOST, NARROW, PAIR, SHIFT};
use crate::build::{BuildError, Interned};
use crate::dag::BRICK_LEVEL;
use crate::material::MaterialId;

/// Patterns that a brick is compared with at most: bounds the time, which would be quadratic, to some 0.2 us a brick. The
/// thesis's scenes at 1024^3 have 99 to 1035 patterns, and the fullest ones take nearly all bricks.
const CANDIDATES: usize = 1024;

pub(super) fn pack(depth: u8, top: u8, cubes: Cubes) -> Result<TreeBuf, BuildError> {
    let root = depth.max(BRICK_LEVEL);
    let (patterns, merged) = merge(&cubes.patterns.list)?;

    // Number the nodes of bits anew, level by level, and find where each will stand.
    let mut halves = Vec::new();
    let mut ends = [0; 19];
    let mut wide = patterns.len() > NARROW as usize;
    // Places of the cubes of each level from 2, by their old numbers: swap << 31 | offset or number.
    let mut places: [Vec<u32>; 20] = [const { Vec::new() }; 20];
    places[0] = merged;
    for (i, level) in cubes.bits.iter().enumerate() {
        let below = &places[i];
        let start = halves.len();
        let mut different: Interned<8> = Interned::new();
        let mut at = Vec::new();
        let mut renamed = list(level.list.len())?;
        for octants in &level.list {
            let octants = octants.map(|octant| match octant {
                NOTHING => ZEROS,
                ZEROS | ONES => octant,
                inside => {
                    let place = below[((inside - INSIDE) / 2) as usize];
                    INSIDE + (place.rotate_left(1) ^ (inside & 1))
                }
            });
            let known = different.list.len();
            let number = different.number(octants)? as usize;
            if number == known {
                push(&mut at, (halves.len() - start) as u32)?;
                write_bits(&mut halves, &octants, wide)?;
            }
            renamed.push(at[number]);
        }
        let size = halves.len() - start;
        if size as u64 >= (1 << 31) - 8 || halves.len() as u64 > u64::from(u32::MAX) {
            return Err(BuildError::Words { needed: halves.len() as u64 / 2 });
        }
        ends[i] = halves.len() as u32;
        wide = size > NARROW as usize;
        places[i + 1] = renamed;
    }

    // Pairs, then nodes, then the table name them by their new places.
    let mut pairs: Interned<2> = Interned::new();
    let mut new_pairs = list(cubes.pairs.list.len())?;
    for [ids, level, at] in cubes.pairs.list {
        let place = places[level as usize - 2][(at / 2) as usize] ^ (at & 1) << 31;
        new_pairs.push(pairs.number([ids, place])?);
    }
    let mut nodes: Interned<8> = Interned::new();
    let mut new_nodes: Vec<u32> = list(cubes.nodes.list.len())?;
    let renamed = |entry: u32, nodes: &[u32]| {
        let value = (entry & (MOST - 1)) as usize;
        match entry >> SHIFT {
            PAIR => PAIR << SHIFT | new_pairs[value],
            INNER => INNER << SHIFT | nodes[value],
            _ => entry,
        }
    };
    for entries in cubes.nodes.list {
        let number = nodes.number(entries.map(|entry| renamed(entry, &new_nodes)))?;
        new_nodes.push(number);
    }
    let mut table = cubes.table;
    for entry in table.iter_mut().filter(|entry| **entry != VACANT) {
        *entry = renamed(*entry, &new_nodes);
    }

    fill_vacant(&mut table, cubes.firsts, u32::from(root - top));

    // Write the header and the parts behind it.
    let (few, some, many) = (cubes.few.list, cubes.some.list, cubes.many.list);
    let words = HEADER
        + table.len()
        + 8 * nodes.list.len()
        + 2 * pairs.list.len()
        + 6 * few.len()
        + 16 * some.len()
        + 32 * many.len()
        + 2 * patterns.len()
        + halves.len().div_ceil(2);
    let mut out: Vec<u32> = list(words)?;
    let counts = [nodes.list.len(), pairs.list.len(), few.len(), some.len(), many.len(), patterns.len()];
    out.extend([depth.into(), u32::from(root - top)]);
    out.extend(counts.map(|n| n as u32));
    out.extend(ends);
    out.push(0);
    out.extend_from_slice(&table);
    out.extend(nodes.list.iter().flatten());
    out.extend(pairs.list.iter().flatten());
    out.extend(few.iter().flatten());
    out.extend(some.iter().flatten());
    out.extend(many.iter().flatten());
    out.extend(patterns.iter().flat_map(|bits| [*bits as u32, (*bits >> 32) as u32]));
    out.extend(halves.chunks(2).map(|two| u32::from(two[0]) | u32::from(two.get(1).copied().unwrap_or(0)) << 16));
    Ok(TreeBuf { words: out })
}

/// An empty list with room for so many.
fn list<T>(len: usize) -> Result<Vec<T>, BuildError> {
    let mut list = Vec::new();
    list.try_reserve_exact(len).map_err(|_| BuildError::Memory { bytes: (len * size_of::<T>()) as u64 })?;
    Ok(list)
}

fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), BuildError> {
    list.try_reserve(1).map_err(|_| BuildError::Memory { bytes: ((list.len() + 1) * size_of::<T>()) as u64 })?;
    list.push(item);
    Ok(())
}

/// The patterns that bricks are left with, and each brick's: swap << 31 | number.
fn merge(bricks: &[[u32; 4]]) -> Result<(Vec<u64>, Vec<u32>), BuildError> {
    let wide = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
    let mut order: Vec<u32> = list(bricks.len())?;
    order.extend(0..bricks.len() as u32);
    // Equal ones do not occur, so the order is one only.
    order.sort_unstable_by_key(|&i| {
        let [low, high, a, b] = bricks[i as usize];
        (core::cmp::Reverse(wide(low, high).count_ones()), wide(low, high), wide(a, b))
    });
    // Filled voxels so far, and their bits.
    let mut patterns: Vec<(u64, u64)> = Vec::new();
    let mut of_brick = list(bricks.len())?;
    of_brick.resize(bricks.len(), 0);
    for i in order {
        let [low, high, a, b] = bricks[i as usize];
        let (mask, bits) = (wide(low, high), wide(a, b));
        let suits = |(filled, has): &(u64, u64)| {
            let apart = (has ^ bits) & filled & mask;
            apart == 0 || apart == filled & mask
        };
        let found = match mask {
            u64::MAX => None,
            _ => patterns.iter().take(CANDIDATES).position(suits),
        };
        let number = match found {
            Some(number) => number,
            None => {
                push(&mut patterns, (0, 0))?;
                patterns.len() - 1
            }
        };
        let (filled, has) = &mut patterns[number];
        let swap = (*has ^ bits) & *filled & mask != 0;
        *has |= if swap { mask & !bits } else { bits };
        *filled |= mask;
        of_brick[i as usize] = u32::from(swap) << 31 | number as u32;
    }
    let mut kept = list(patterns.len())?;
    kept.extend(patterns.iter().map(|(_, bits)| bits));
    Ok((kept, of_brick))
}

/// Writes a node of bits.
fn write_bits(halves: &mut Vec<u16>, octants: &[u32; 8], wide: bool) -> Result<(), BuildError> {
    let mut node = 0;
    for (octant, &what) in octants.iter().enumerate() {
        node |= u16::from(what >= INSIDE) << octant | u16::from(what == ONES) << (8 + octant);
    }
    push(halves, node)?;
    for inside in octants.iter().filter(|&&what| what >= INSIDE) {
        let place = (inside - INSIDE).rotate_right(1);
        if wide {
            push(halves, place as u16)?;
            push(halves, (place >> 16) as u16)?;
        } else {
            push(halves, (place >> 31 << 15 | place) as u16)?;
        }
    }
    Ok(())
}

/// Cells without voxels get the material of a voxel in the smallest cube around them that holds any.
fn fill_vacant(table: &mut [u32], mut firsts: Vec<MaterialId>, bits: u32) {
    let at = |[x, y, z]: [usize; 3]| ((z << bits | y) << bits) | x;
    for k in 1..=bits {
        let (blocks, side) = (1usize << (bits - k), 1usize << k);
        for block in 0..blocks.pow(3) {
            let corner = [block % blocks, block / blocks % blocks, block / blocks / blocks].map(|b| b * side);
            let cell = |i: usize| at([corner[0] + i % side, corner[1] + i / side % side, corner[2] + i / side / side]);
            let cells = side.pow(3);
            let Some(first) = (0..cells).map(cell).find(|&c| table[c] != VACANT) else { continue };
            let id = firsts[first];
            for c in (0..cells).map(cell) {
                if table[c] == VACANT {
                    table[c] = ID << SHIFT | u32::from(id);
                    firsts[c] = id;
                }
            }
        }
    }
    table.iter_mut().filter(|entry| **entry == VACANT).for_each(|entry| *entry = ID << SHIFT);
}
