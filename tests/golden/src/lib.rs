//! Determinism as a law: the words of a file, the answers to rays and the pixels of a picture are the same bits everywhere.
//!
//! In: scenes, either built here from their meshes (feature `build`) or as the words of a `.vxd`. Out: one line per scene
//! and one per hash that is not the table's. The hashes stand in [`hashes`] and nowhere else; the same function compares
//! them on every target: natively, in wasm, and on a machine without heap or operating system (`tests/bare`).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "build")]
extern crate alloc;

#[cfg(feature = "build")]
pub mod build;
mod draw;
pub mod hashes;
pub mod plain;
#[cfg(feature = "build")]
mod shapes;

use core::fmt::{self, Write};

use hashes::{Case, STAGES};
use voxdag::file;

/// The machine code that this is.
pub struct Target;

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = [
            (cfg!(target_arch = "x86_64"), "x86-64"),
            (cfg!(target_arch = "aarch64"), "aarch64"),
            (cfg!(target_arch = "wasm32"), "wasm32"),
            (cfg!(target_arch = "arm"), "arm"),
        ];
        f.write_str(names.iter().find(|name| name.0).map_or("another", |name| name.1))?;
        f.write_str(if cfg!(debug_assertions) { " debug" } else { " release" })?;
        let extras = [
            (cfg!(target_endian = "big"), " big-endian"),
            (cfg!(target_os = "none"), " bare"),
            (cfg!(target_feature = "fma"), " +fma"),
            (cfg!(target_feature = "avx2"), " +avx2"),
            (cfg!(target_feature = "avx512f"), " +avx512f"),
            (cfg!(target_feature = "simd128"), " +simd128"),
            (cfg!(not(feature = "build")), " (no heap)"),
        ];
        extras.iter().filter(|extra| extra.0).try_for_each(|extra| f.write_str(extra.1))
    }
}

/// Hashes a scene's words, its rays and its picture, writes a line about it, and says how many hashes were not those of
/// the table.
pub fn check(case: &Case, words: &[u32], out: &mut dyn Write) -> Result<usize, fmt::Error> {
    let name = case.name;
    let found = match file::read(words) {
        Ok(scene) => draw::rays(&scene, case).and_then(|rays| Ok([hash(words), rays, draw::image(&scene, case)?])),
        Err(error) => {
            writeln!(out, "{Target}: {name}: {error}")?;
            return Ok(1);
        }
    };
    let found = match found {
        Ok(found) => found,
        Err(error) => {
            writeln!(out, "{Target}: {name}: {error}")?;
            return Ok(1);
        }
    };
    let mut failed = 0;
    for ((stage, expected), found) in STAGES.iter().zip(case.hashes).zip(found) {
        if expected != found {
            writeln!(out, "{Target}: {name}, stage {stage}: expected {expected:#018x}, found {found:#018x}")?;
            failed += 1;
        }
    }
    if failed == 0 {
        writeln!(out, "{Target}: {name}: file, rays and image as everywhere")?;
    }
    Ok(failed)
}

/// Builds and checks every scene that can be built here.
#[cfg(feature = "build")]
pub fn check_all(out: &mut dyn Write) -> Result<usize, fmt::Error> {
    let mut failed = 0;
    for case in &hashes::CASES {
        match build::words(case.name) {
            Some(Ok(words)) => failed += check(case, &words, out)?,
            Some(Err(error)) => {
                writeln!(out, "{Target}: {}: {error}", case.name)?;
                failed += 1;
            }
            None => {}
        }
    }
    Ok(failed)
}

/// The hash of words.
fn hash(words: &[u32]) -> u64 {
    let mut hash = Hash::default();
    words.iter().for_each(|&word| hash.add(word));
    hash.0
}

/// FNV-1a with 64 bits (Fowler, Noll and Vo 1991) over the bytes of words, lowest first.
struct Hash(u64);

impl Default for Hash {
    fn default() -> Hash {
        Hash(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    fn add(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn add_u64(&mut self, word: u64) {
        self.add(word as u32);
        self.add((word >> 32) as u32);
    }

    fn add_f32s(&mut self, numbers: [f32; 3]) {
        numbers.into_iter().for_each(|x| self.add(x.to_bits()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FNV-1a as it is published, byte by byte, for bytes without a rest.
    #[test]
    fn the_hash_is_fnv_1a() {
        let bytes = *b"The same bits everywhere";
        let (words, _) = bytes.as_chunks::<4>();
        let expected = bytes
            .iter()
            .fold(14_695_981_039_346_656_037u64, |h, &byte| (h ^ u64::from(byte)).wrapping_mul(1_099_511_628_211));
        let mut hash = Hash::default();
        words.iter().for_each(|&word| hash.add(u32::from_le_bytes(word)));
        assert_eq!(hash.0, expected);
    }

    /// Under an interpreter the first scene must do.
    #[test]
    #[cfg(feature = "hall")]
    fn every_scene_has_its_hashes() {
        let mut report = alloc::string::String::new();
        for case in &hashes::CASES[..if cfg!(miri) { 1 } else { hashes::CASES.len() }] {
            let words = build::words(case.name).expect("all features are there").expect("the scene is built");
            assert_eq!(check(case, &words, &mut report), Ok(0), "{report}");
        }
    }

    /// The picture that `tests/bare` draws in a few KiB.
    #[test]
    #[cfg(feature = "build")]
    #[cfg_attr(miri, ignore)]
    fn the_plain_picture_has_its_hash() {
        let words = build::words(hashes::PLAIN_SCENE).expect("all features are there").expect("the scene is built");
        let found = plain::hash(&words).expect("the scene is a DAG");
        assert_eq!(found, hashes::PLAIN, "found {found:#018x}");
    }

    #[test]
    #[cfg(feature = "build")]
    fn a_difference_is_named_with_scene_stage_and_both_hashes() {
        let [case, ..] = hashes::CASES;
        let words = build::words(case.name).expect("all features are there").expect("the scene is built");
        let [file, rays, image] = case.hashes;
        let mut report = alloc::string::String::new();
        assert_eq!(check(&Case { hashes: [file, rays ^ 1, image], ..case }, &words, &mut report), Ok(1));
        let expected = alloc::format!(": tiny, stage rays: expected {:#018x}, found {rays:#018x}\n", rays ^ 1);
        assert!(report.ends_with(&expected), "{report}");
    }
}
