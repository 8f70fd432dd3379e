//! Picture files: whatever the bytes, a picture or the reason why there is none, within the memory that is allowed.
//!
//! Bytes: the name (u8: even `a.png`, odd `a.tga`, which is told by its name); then the file.

use voxdag::texture::{DecodeError, decode};

/// Most bytes that a picture may take.
const LIMIT: u64 = 16 << 20;

/// See the head of the file.
pub fn pictures(data: &[u8]) {
    let Some((first, file)) = data.split_first() else { return };
    match decode(if first % 2 == 0 { "a.png" } else { "a.tga" }, file, LIMIT) {
        Ok(image) => assert!((4..LIMIT).contains(&image.bytes())),
        Err(DecodeError::Picture(why)) => assert!(!why.is_empty()),
        Err(DecodeError::Limit { needed }) => assert!(needed > LIMIT),
    }
}
