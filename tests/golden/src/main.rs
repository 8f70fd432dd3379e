//! All scenes, built and checked: a program where there is a console, an exported function in wasm.

use voxdag_golden::check_all;

#[cfg(not(target_family = "wasm"))]
fn main() -> std::process::ExitCode {
    let mut report = String::new();
    let failed = check_all(&mut report).expect("a text takes all lines");
    print!("{report}");
    if failed == 0 { std::process::ExitCode::SUCCESS } else { std::process::ExitCode::FAILURE }
}

/// The report's address and length in bytes as `length << 32 | address`, the sign bit set if a hash is not the table's.
#[cfg(target_family = "wasm")]
#[unsafe(no_mangle)]
pub extern "C" fn golden() -> i64 {
    let mut report = String::new();
    let failed = check_all(&mut report).expect("a text takes all lines");
    let report = report.leak();
    let packed = (report.len() as i64) << 32 | report.as_ptr() as i64;
    if failed == 0 { packed } else { packed | i64::MIN }
}

#[cfg(target_family = "wasm")]
fn main() {}
