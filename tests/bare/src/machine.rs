//! What the emulator offers: a console, and a way out.

// Brings the critical sections of a single core.
use cortex_m as _;
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hio::{self, HostStream};

/// Standard output of the emulator's process.
pub fn console() -> HostStream {
    hio::hstdout().expect("the emulator has a console")
}

/// Ends the emulator: well if nothing failed.
pub fn exit(failed: usize) -> ! {
    loop {
        debug::exit(if failed == 0 { EXIT_SUCCESS } else { EXIT_FAILURE });
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    if let Ok(mut console) = hio::hstdout() {
        let _ = core::fmt::Write::write_fmt(&mut console, format_args!("{info}\n"));
    }
    exit(1)
}
