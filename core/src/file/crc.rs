//! CRC-32 (the one of zlib, PNG and gzip) of words as little-endian bytes, the same on machines of either byte order.

use super::error::{LoadError, Section};

/// Words that are turned into bytes at a time.
const CHUNK: usize = 256;

/// The checksum of words.
pub(super) fn of(words: &[u32]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    let mut bytes = [0; 4 * CHUNK];
    for chunk in words.chunks(CHUNK) {
        let used = &mut bytes[..4 * chunk.len()];
        for (to, word) in used.chunks_exact_mut(4).zip(chunk) {
            to.copy_from_slice(&word.to_le_bytes());
        }
        hasher.update(used);
    }
    hasher.finalize()
}

/// Compares the checksum of the header (`None`), or of a section of a kind at an offset. Under a fuzzer it is always
/// right, so that the fuzzer gets past it.
pub(super) fn check(words: &[u32], expected: u32, section: Option<(u32, u64)>) -> Result<(), LoadError> {
    let found = of(words);
    if cfg!(fuzzing) || found == expected {
        return Ok(());
    }
    Err(match section {
        None => LoadError::HeaderCrc { expected, found },
        Some((kind, word)) => match Section::of(kind, super::VERSION) {
            Some(section) => LoadError::Crc { section, word, expected, found },
            None => LoadError::UnknownCrc { kind, word, expected, found },
        },
    })
}
