//! What it takes to embed voxdag: a scene in flash, checked, traced, fitted with normals, shaded. No heap, no std.
//!
//! On ARM it runs under QEMU: exit code 0 means that the picture is the same as everywhere, and that memory beside the
//! scene was enough (`tight.x`). Elsewhere it is linked, to prove that nothing is missing.
#![no_std]
#![no_main]

use voxdag_golden::plain;

/// A file's bytes where words may lie.
#[repr(C, align(4))]
struct Aligned<T: ?Sized>(T);

/// The scene of the golden picture [`plain`].
static SCENE: &Aligned<[u8]> = include!(concat!(env!("OUT_DIR"), "/picture.rs"));

/// The picture's hash; of no picture, 0.
fn draw() -> u64 {
    plain::hash(bytemuck::cast_slice(&SCENE.0)).unwrap_or(0)
}

#[cfg(target_arch = "arm")]
mod arm {
    use core::panic::PanicInfo;

    use cortex_m as _;
    use cortex_m_rt::{STACK_PAINT_VALUE, entry};
    use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;
    use voxdag_golden::hashes::PLAIN;

    unsafe extern "C" {
        /// Where static memory ends, and the stack may grow to.
        static _stack_end: u32;
        /// Where the stack begins.
        static _stack_start: u32;
    }

    #[entry]
    fn main() -> ! {
        let hash = super::draw();
        hprintln!("arm bare picture: {} bytes of stack", stack());
        if hash == PLAIN {
            debug::exit(EXIT_SUCCESS);
        } else {
            hprintln!("arm bare picture: expected {:#018x}, found {:#018x}", PLAIN, hash);
        }
        fail()
    }

    /// How many bytes of the stack have been used: start-up code has painted all of it.
    fn stack() -> usize {
        let (end, start) = (&raw const _stack_end, &raw const _stack_start);
        // SAFETY: the linker keeps all words between the two for the stack; they are aligned, and lost on no one.
        let painted = (0..).take_while(|&i| unsafe { end.add(i).read_volatile() } == STACK_PAINT_VALUE).count();
        start as usize - end as usize - 4 * painted
    }

    fn fail() -> ! {
        loop {
            debug::exit(EXIT_FAILURE);
        }
    }

    /// Says nothing: texts for people are what a small program leaves out.
    #[panic_handler]
    fn panic(_: &PanicInfo) -> ! {
        fail()
    }
}

#[cfg(not(target_arch = "arm"))]
mod linked {
    use core::panic::PanicInfo;

    // SAFETY: no other function has this name; the linker begins here.
    #[unsafe(no_mangle)]
    extern "C" fn _start() -> ! {
        core::hint::black_box(super::draw());
        rest()
    }

    fn rest() -> ! {
        loop {
            core::hint::spin_loop();
        }
    }

    #[panic_handler]
    fn panic(_: &PanicInfo) -> ! {
        rest()
    }
}
