//! What a run cost: time per stage and the peak of memory.

use std::time::Instant;

/// Milliseconds since `start`, to the microsecond.
pub fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_micros() as f64 / 1000.0
}

/// Runs `work` and gives its result and its milliseconds.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, ms_since(start))
}

/// The most memory this process ever held, in bytes; `None` where the system has no `/proc/self/status`.
pub fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}
