//! The shader on whatever adapter there is, against the exact tracer and the oracles. Exit code 1 if anything differs, or if
//! there is no adapter although `VOXDAG_GPU=required` says that there must be one.

mod gpu;
mod looks;
mod picture;
mod rays;

use std::process::ExitCode;

use gpu::Gpu;

fn source() -> String {
    if let Ok(dir) = std::env::var("DEV_WGSL") {
        let read = |name: &str| std::fs::read_to_string(format!("{dir}/{name}.wgsl")).unwrap();
        let all: Vec<String> = ["scene", "trace", "normal", "material", "picture"].map(read).into();
        return format!("{}\n{}", all.join("\n"), std::fs::read_to_string(format!("{}/src/probe.wgsl", env!("CARGO_MANIFEST_DIR"))).unwrap());
    }
    [voxdag::wgsl::SOURCE, voxdag::wgsl::PICTURE, include_str!("probe.wgsl")].join("\n")
}

fn main() -> ExitCode {
    let gpu = match Gpu::new(&source()) {
        Ok(gpu) => gpu,
        Err(why) => {
            println!("SKIPPED: no adapter: {why}");
            let required = std::env::var("VOXDAG_GPU").is_ok_and(|value| value == "required");
            return ExitCode::from(u8::from(required));
        }
    };
    println!("{}", gpu.name);
    let start = std::time::Instant::now();
    let count = |name: &str, default: usize| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    let mut wrong = looks::check(&gpu) + picture::check(&gpu);
    println!("{}", rays::HEAD);
    for depth in std::env::var("DEPTHS").map_or(vec![3, 4, 8, 10, 13, 16, 21], |d| d.split(',').map(|d| d.parse().unwrap()).collect()) {
        wrong += rays::check(&gpu, depth, count("RAYS", 1000), count("JUDGED", 50));
    }
    println!("{:.1} s", start.elapsed().as_secs_f64());
    ExitCode::from(u8::from(wrong > 0))
}
