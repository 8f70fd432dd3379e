//! What reports say of the machine that they were made on.

use serde::Serialize;

use crate::report::visible;

/// The machine, and the program.
#[derive(Serialize)]
pub struct Machine {
    os: &'static str,
    architecture: &'static str,
    /// Its name, where the system says it.
    processor: Option<String>,
    threads: usize,
    version: &'static str,
}

impl Machine {
    /// This one, of which so many threads are used.
    pub fn with(threads: usize) -> Machine {
        Machine {
            os: std::env::consts::OS,
            architecture: std::env::consts::ARCH,
            processor: processor(),
            threads,
            version: env!("CARGO_PKG_VERSION"),
        }
    }

    /// For people.
    pub fn text(&self) -> String {
        let Machine { os, architecture, processor, threads, version } = self;
        let processor = processor.as_deref().map(|name| visible(name) + ", ").unwrap_or_default();
        let threads = if *threads == 1 { "one thread".to_owned() } else { format!("{threads} threads") };
        format!("voxdag {version} on {processor}{threads} ({os}, {architecture})")
    }
}

/// The processor's name, where the system has `/proc/cpuinfo`.
fn processor() -> Option<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = info.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
