//! `voxdag`: meshes to voxel DAGs to pictures, on the command line.
//!
//! One file per subcommand in `cmd/`; around them a shared rim: `input` and `output` (files), `options` and `quality` (flags),
//! `view` (view files), `frames`, `memory` (the limit), `scene`, `layout`, `detail`, `picture` and `show` (the core's stages on all cores),
//! `overlap`, `truth` and `metrics` (what to compare with, and how), `rays` and `formats` (other programs' files), `measure`,
//! `machine`, `progress`, `report`, `stats` and `error`. No algorithm of the field lives here.

mod budget;
mod cmd;
mod detail;
mod error;
mod formats;
mod frames;
mod hexfloat;
mod input;
mod layout;
mod machine;
mod measure;
mod memory;
mod metrics;
mod options;
mod ordered;
mod output;
mod overlap;
mod picture;
mod progress;
mod quality;
mod rays;
mod report;
mod scene;
mod show;
mod source;
mod stats;
mod truth;
mod view;
mod voxelize;

use clap::{Parser, Subcommand};

/// Turn triangle meshes into compressed voxel scenes and ray trace them
#[derive(Parser)]
#[command(
    name = "voxdag",
    version,
    arg_required_else_help = true,
    after_help = "\
Start here:
  voxdag demo                              a picture of the scene that comes along
  voxdag render bunny.obj -o bunny.png     a mesh to a picture in one step

Exit codes: 0 done, 1 failure, 2 wrong usage, 3 bad input, 4 limit exceeded, 130 interrupted"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(cmd::demo::Args),
    Build(cmd::build::Args),
    Render(cmd::render::Args),
    Info(cmd::info::Args),
    Verify(cmd::verify::Args),
    View(cmd::view::Args),
    Cast(cmd::cast::Args),
    Export(cmd::export::Args),
    Accuracy(cmd::accuracy::Args),
    Compare(cmd::compare::Args),
    Bench(cmd::bench::Args),
    Thesis(cmd::thesis::Args),
    Selftest(cmd::selftest::Args),
    Completions(cmd::completions::Args),
}

fn main() {
    let cli = Cli::parse();
    output::clean_up_when_interrupted();
    let result = match cli.command {
        Command::Demo(args) => cmd::demo::run(&args),
        Command::Build(args) => cmd::build::run(&args),
        Command::Render(args) => cmd::render::run(&args),
        Command::Info(args) => cmd::info::run(&args),
        Command::Verify(args) => cmd::verify::run(&args),
        Command::View(args) => cmd::view::run(&args),
        Command::Cast(args) => cmd::cast::run(&args),
        Command::Export(args) => cmd::export::run(&args),
        Command::Accuracy(args) => cmd::accuracy::run(&args),
        Command::Compare(args) => cmd::compare::run(&args),
        Command::Bench(args) => cmd::bench::run(args),
        Command::Thesis(args) => cmd::thesis::run(&args),
        Command::Selftest(args) => cmd::selftest::run(&args),
        Command::Completions(args) => cmd::completions::run(&args),
    };
    if let Err(error) = result {
        output::wait_if_interrupted();
        std::process::exit(error.report());
    }
}
