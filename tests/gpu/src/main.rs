//! The shader on whatever adapter there is, against the exact tracer and the oracles. Exit code 1 if anything differs, or
//! if there is no adapter although `VOXDAG_GPU=required` says that there must be one. `--long`: ten times as many rays.

mod gpu;
mod looks;
mod picture;
mod rays;

use std::process::ExitCode;
use std::time::Instant;

use gpu::Gpu;

fn main() -> ExitCode {
    let source = [voxdag::wgsl::SOURCE, voxdag::wgsl::PICTURE, include_str!("probe.wgsl")].join("\n");
    let gpu = match Gpu::new(&source) {
        Ok(gpu) => gpu,
        Err(why) => {
            println!("SKIPPED: no adapter: {why}");
            return ExitCode::from(u8::from(std::env::var("VOXDAG_GPU").is_ok_and(|value| value == "required")));
        }
    };
    println!("{}\n", gpu.name);
    let start = Instant::now();
    let times = if std::env::args().any(|argument| argument == "--long") { 10 } else { 1 };
    let mut wrong = looks::check(&gpu) + picture::check(&gpu);
    wrong += rays::check_leaving(&gpu, 10, 5000 * times) + rays::check_noise(&gpu) + rays::check_garbage(&gpu);
    println!("\n{}", rays::HEAD);
    for depth in [3, 4, 8, 10, 13, 16, 21] {
        wrong += rays::check(&gpu, depth, 2000 * times, 50 * times);
    }
    println!("\n{wrong} wrong, {:.0} s", start.elapsed().as_secs_f64());
    ExitCode::from(u8::from(wrong > 0))
}
