//! `voxdag export`: the voxels of a scene for other programs.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Instant;

use clap::ValueEnum;
use serde::Serialize;

use crate::error::{Error, Kind, Result};
use crate::formats;
use crate::input;
use crate::options::ReportArgs;
use crate::output::{Sink, Stop};
use crate::report::{self, Lines, grouped, shell_word, time};
use crate::scene;
use crate::stats::{self, ms};

/// Write the voxels of a scene for other programs
#[derive(clap::Args)]
#[command(after_help = "\
Coordinates are those of the grid: world = origin + voxel size * grid (see `voxdag info`). Materials are numbers;
`info` has their names.

Examples:
  voxdag export bunny.vxd --to binvox -o bunny.binvox
  voxdag export bunny.vxd --to xyz | head")]
pub struct Args {
    /// A scene from `voxdag build`
    #[arg(value_name = "F.vxd")]
    scene: PathBuf,

    /// The format
    #[arg(long, value_enum, value_name = "FORMAT")]
    to: Format,

    /// The file to write; `-` is stdout [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    #[command(flatten)]
    report: ReportArgs,
}

/// The formats.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Format {
    /// Filled or empty for every voxel of the cube, in runs; up to 4096 voxels a side
    Binvox,
    /// Text: a line `x y z material` per filled voxel, in Morton order
    Xyz,
    /// NumPy: an array [voxels, 4] of uint32 x, y, z, material, in Morton order
    Npy,
}

/// Most voxels that a list of them may have: 64 GiB of NumPy rows. A file of one kilobyte can stand for 2^63.
const MOST_LISTED: u64 = 1 << 32;

/// What `export --json` prints.
#[derive(Serialize)]
struct Report {
    voxels: u64,
    bytes: u64,
    ms: Ms,
    peak_rss_bytes: Option<u64>,
}

#[derive(Serialize)]
struct Ms {
    /// From the start of the program to the finished file.
    total: f64,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let extension = match args.to {
        Format::Binvox => "binvox",
        Format::Xyz => "xyz",
        Format::Npy => "npy",
    };
    let sink = Sink::create(args.output.as_deref(), extension, args.report.json)?;
    sink.must_not_replace(std::slice::from_ref(&args.scene))?;
    let to_file = matches!(sink, Sink::File(_));
    if !to_file && args.to != Format::Xyz && std::io::stdout().is_terminal() {
        return Err(Error::usage(format_args!("{extension} is not for the eye, and stdout is a terminal"))
            .hint(format_args!("name a file with -o {}", shell_word(&args.scene.with_extension(extension)))));
    }
    let words = input::read_scene(&args.scene)?;
    let scene = scene::open(&args.scene, &words)?;
    let n = scene.grid.resolution;
    if args.to == Format::Binvox && n > formats::MAX_BINVOX {
        let most = formats::MAX_BINVOX;
        let message = format_args!("{}: {n} voxels a side, binvox ends at {most}", args.scene.display());
        return Err(Error::new(Kind::Limit, message)
            .hint(format_args!("export to xyz or npy, or build the scene again with -r {most}")));
    }
    let voxels = scene::count(scene.geometry)?.voxels;
    // Who reads lines can stop; a file, or an array with its length in front, is wanted whole.
    let whole = args.to == Format::Npy || args.to == Format::Xyz && to_file;
    if whole && voxels > MOST_LISTED {
        let message = format_args!(
            "{}: {} voxels, a list ends at {}",
            args.scene.display(),
            grouped(voxels),
            grouped(MOST_LISTED)
        );
        return Err(Error::new(Kind::Limit, message)
            .hint("build the scene again with a smaller -r, or read as many lines as you need from --to xyz"));
    }

    let mut bytes = 0;
    sink.finish(|out| {
        let mut out = Counted { out, bytes: &mut bytes };
        match args.to {
            Format::Binvox => formats::binvox(scene.geometry, &scene.grid, &mut out),
            Format::Xyz => formats::xyz(&scene, &mut out),
            Format::Npy => formats::npy(&scene, voxels, &mut out),
        }
        .map_err(Stop::Write)
    })?;

    if to_file {
        let total = ms(start.elapsed());
        let report = Report { voxels, bytes, ms: Ms { total }, peak_rss_bytes: stats::peak_rss_bytes() };
        let mut lines = Lines::default();
        lines
            .row("voxels", grouped(voxels))
            .row("bytes", format!("{} ({})", grouped(bytes), report::size(bytes)))
            .row("time", time(total))
            .row("memory", report::peak(report.peak_rss_bytes));
        report::result(args.report.json, &report, &lines)?;
    }
    report::next(format_args!("info {}", shell_word(&args.scene)));
    Ok(())
}

/// Counts what passes.
struct Counted<'a> {
    out: &'a mut dyn std::io::Write,
    bytes: &'a mut u64,
}

impl std::io::Write for Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.out.write(bytes)?;
        *self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}
