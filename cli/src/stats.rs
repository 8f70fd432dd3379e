//! What a run cost: time per stage and the peak of memory.

use std::time::{Duration, Instant};

/// Runs `work` and gives its result and how long it took.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}

/// Milliseconds to the microsecond, as reports have them.
pub fn ms(time: Duration) -> f64 {
    time.as_micros() as f64 / 1000.0
}

/// The most memory this process ever held, in bytes; `None` where the system has no `/proc/self/status`.
pub fn peak_rss_bytes() -> Option<u64> {
    status("VmHWM:")
}

/// Runs `work` and gives its result and the most memory that it took beside what was held before; `None` where the system
/// does not tell. What [`peak_rss_bytes`] says later begins with this work.
pub fn peak_of<T>(work: impl FnOnce() -> T) -> (T, Option<u64>) {
    // Linux forgets the peak so far when it is told 5 (proc_pid_clear_refs(5)).
    let before = std::fs::write("/proc/self/clear_refs", "5").ok().and_then(|()| status("VmRSS:"));
    let result = work();
    (result, before.and_then(|before| peak_rss_bytes()?.checked_sub(before)))
}

/// A line of `/proc/self/status` in bytes.
fn status(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}
