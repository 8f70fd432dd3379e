//! Key families for hash tables, and the twin that the core's table is compared with.
//!
//! In: a number of keys. Out: distinct 63-bit Morton codes that break one usual hash or another (hard-cases, section 7):
//! identity and mask on planes and on shifted keys, Fibonacci, and splitmix itself, whose finaliser can be inverted.

use std::collections::HashMap;

use crate::octree::interleave;
use crate::rng::Rng;

/// The finaliser of splitmix64 (Steele, Lea and Flood 2014): a bijection of 64-bit words.
pub fn splitmix(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// The key whose finaliser is `h`.
pub fn unsplitmix(h: u64) -> u64 {
    let z = unshift(h, 31).wrapping_mul(inverse(0x94d0_49bb_1331_11eb));
    let z = unshift(z, 27).wrapping_mul(inverse(0xbf58_476d_1ce4_e5b9));
    unshift(z, 30)
}

/// The z with `z ^ z >> shift == h`.
fn unshift(h: u64, shift: u32) -> u64 {
    let mut z = h;
    for _ in 0..64 / shift {
        z = h ^ z >> shift;
    }
    z
}

/// The inverse of an odd number modulo 2^64, by Newton's iteration: each step doubles the number of right bits.
fn inverse(odd: u64) -> u64 {
    let mut x = odd;
    for _ in 0..6 {
        x = x.wrapping_mul(2u64.wrapping_sub(odd.wrapping_mul(x)));
    }
    x
}

/// All families by name, each of distinct keys below 2^63.
pub fn families() -> Vec<(&'static str, Vec<u64>)> {
    let shell = || {
        let mut keys = Vec::new();
        for z in 0..256i64 {
            for y in 0..256i64 {
                for x in 0..256i64 {
                    let r2 = (x - 128) * (x - 128) + (y - 128) * (y - 128) + (z - 128) * (z - 128);
                    if (119 * 119..120 * 120).contains(&r2) {
                        keys.push(interleave([x as u32, y as u32, z as u32]));
                    }
                }
            }
        }
        keys
    };
    let plane = || (0..256).flat_map(|y| (0..256).map(move |x| interleave([x, y, 777]))).collect();
    let random = || {
        let mut rng = Rng::new(7);
        let mut keys: Vec<u64> = (0..65536).map(|_| rng.bits() >> 1).collect();
        keys.sort_unstable();
        keys.dedup();
        rng.shuffle(&mut keys);
        keys
    };
    vec![
        ("dense block", (0..65536).collect()),
        ("dense block, backwards", (0..65536).rev().collect()),
        ("multiples of 8", (0..65536).map(|i| 8 * i).collect()),
        ("plane z = 777", plane()),
        ("sphere shell R = 120", shell()),
        ("keys << 40", (0..65536).map(|i| i << 40).collect()),
        ("random", random()),
        ("zero and the last", vec![0, (1 << 63) - 1]),
        ("against Fibonacci", (0..20_000).map(against_fibonacci).filter(|k| k >> 63 == 0).collect()),
        ("against splitmix, high bits", (0..40_000).map(unsplitmix).filter(|k| k >> 63 == 0).collect()),
        ("against splitmix, low bits", (0..40_000).map(|i| unsplitmix(i << 40)).filter(|k| k >> 63 == 0).collect()),
    ]
}

/// A key whose product with 2^64 over the golden ratio is `i`: all of them share their top bits.
fn against_fibonacci(i: u64) -> u64 {
    i.wrapping_mul(inverse(0x9e37_79b9_7f4a_7c15))
}

/// The average and the greatest number of probes that linear probing needs to find each key again, where key k starts
/// at slot `home(k)` of `slots` slots; what hard-cases, section 7, tabulates.
pub fn probes(keys: &[u64], slots: usize, home: impl Fn(u64) -> usize) -> (f64, usize) {
    let mut taken = vec![false; slots];
    let (mut sum, mut most) = (0, 0);
    for &key in keys {
        let mut at = home(key) % slots;
        let mut count = 1;
        while taken[at] {
            at = (at + 1) % slots;
            count += 1;
        }
        taken[at] = true;
        sum += count;
        most = most.max(count);
    }
    (sum as f64 / keys.len() as f64, most)
}

/// What a table of `entries`, put in one by one, must hold in the end: a later entry replaces an earlier one.
pub fn twin<V: Copy>(entries: impl IntoIterator<Item = (u64, V)>) -> HashMap<u64, V> {
    entries.into_iter().collect()
}
