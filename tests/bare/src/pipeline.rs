//! With a heap: the small scenes are built here, too, from their meshes to the words of their files.
#![no_std]
#![no_main]

mod machine;

use cortex_m_rt::entry;
use embedded_alloc::LlffHeap;

#[global_allocator]
static HEAP: LlffHeap = LlffHeap::empty();

/// The board's second memory, which nothing else uses.
const MEMORY: (usize, usize) = (0x2100_0000, 16 << 20);

#[entry]
fn main() -> ! {
    // SAFETY: called once, before the first allocation; the range is memory, and `memory.x` leaves it to us.
    unsafe { HEAP.init(MEMORY.0, MEMORY.1) }
    let mut console = machine::console();
    machine::exit(voxdag_golden::check_all(&mut console).unwrap_or(1))
}
