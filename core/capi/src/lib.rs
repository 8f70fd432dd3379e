//! voxdag for C and C++: the functions of `voxdag.h`, which is made from these sources.
//!
//! In: plain numbers, structures of them, and memory that the caller lends. Out: a status, and what was asked for in the
//! caller's memory. The core does all the work; here are only conversions. This is the only crate with unsafe code, in
//! the module `border` alone: every function states once that its caller keeps the header's promise, and goes on in safe code.
//!
//! A scene is a handle that the library makes and the caller closes, not storage that the caller lends: the trees that make
//! rays fast need the heap in any case, a structure's size would be part of the ABI, and a handle can only be null or right.
//! The file's words stay the caller's; they are neither copied nor changed. A handle never changes, so any number of threads
//! may use one at the same time.
#![deny(unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks)]
// The header states the promise once for all functions.
#![allow(clippy::missing_safety_doc)]

#[cfg(not(panic = "unwind"))]
compile_error!("panics must unwind, so that none crosses into C: build with panic = \"unwind\"");

mod border;
mod error;
mod mesh;
mod pictures;
mod ray;
mod render;
mod scene;
mod surface;

pub use error::{VoxdagError, VoxdagStatus};
pub use mesh::*;
pub use ray::*;
pub use render::*;
pub use scene::*;
pub use surface::*;

use core::ffi::{CStr, c_char};

/// The version of this header. A program may compare it with `voxdag_abi_version()`.
pub const VOXDAG_ABI_VERSION: u32 = 1;

/// No voxel, and no position.
pub const VOXDAG_NONE: u64 = u64::MAX;

/// The ABI of the library that was linked or loaded: `VOXDAG_ABI_VERSION` of its header. The same number means that a
/// program may go on; the number changes where a function, a structure or a meaning does, and not where one is added.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_abi_version() -> u32 {
    VOXDAG_ABI_VERSION
}

const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
    Ok(version) => version,
    Err(_) => panic!("a version has no zero byte"),
};

/// The version of the library, such as "0.1.0": a text that lives for ever.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_version() -> *const c_char {
    VERSION.as_ptr()
}

/// A status (`VOXDAG_STATUS_*`) in words, without places and numbers, which a `VoxdagError` has: a text that lives for ever.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_error_message(status: i32) -> *const c_char {
    let known = VoxdagStatus::TEXTS.iter().find(|(known, _)| *known as i32 == status);
    known.map_or(c"no status of this version", |(_, text)| text).as_ptr()
}
