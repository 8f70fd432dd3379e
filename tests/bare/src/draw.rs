//! Without a heap: scenes lie in flash as `.vxd` files, and are loaded, traced and drawn on the stack.
//!
//! No allocator is linked, so nothing can ask one. Exit code 0 under QEMU means that all hashes are those of the table.
#![no_std]
#![no_main]

mod machine;

use cortex_m_rt::entry;
use voxdag_golden::{check, hashes::CASES};

/// A file's bytes where words may lie.
#[repr(C, align(4))]
struct Aligned<T: ?Sized>(T);

/// The files, in the order of [`CASES`].
static SCENES: &[&Aligned<[u8]>; CASES.len()] = include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

#[entry]
fn main() -> ! {
    let mut console = machine::console();
    let mut failed = 0;
    for (case, file) in CASES.iter().zip(SCENES) {
        failed += check(case, bytemuck::cast_slice(&file.0), &mut console).unwrap_or(1);
    }
    machine::exit(failed)
}
