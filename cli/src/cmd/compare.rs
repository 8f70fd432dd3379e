//! `voxdag compare`: how far a picture is from another, in numbers and as a map.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder, ImageError, Limits};
use serde::Serialize;

use crate::error::{Error, Kind, Result};
use crate::input::unreadable;
use crate::metrics::{self, Errors, MOST_PIXELS, View};
use crate::options::ReportArgs;
use crate::output::Output;
use crate::picture::png;
use crate::report::{self, Lines, grouped, number};

/// Measure how far a picture is from another
#[derive(clap::Args)]
#[command(after_help = "\
RMSE is that of linear light, 0 to 1, and PSNR the same in dB; SSIM (Wang et al., 2004) is 1 for equal pictures;
FLIP (Andersson et al., 2020) is what people see when the two alternate, from 0 to 1. 16 bits are rounded to 8.

Examples:
  voxdag compare good.png new.png --map difference.png      and where they differ
  voxdag compare good.png new.png --max-rmse 0.001          in a test: exit code 1 if the error is larger")]
pub struct Args {
    /// The picture as it should be; PNG of 8 or 16 bits, grey or colour, alpha is ignored
    #[arg(value_name = "A.png")]
    reference: PathBuf,

    /// The picture to judge, of the same size
    #[arg(value_name = "B.png")]
    picture: PathBuf,

    /// Also write FLIP's error of each pixel as a picture: black is equal, light yellow the most
    #[arg(long, value_name = "DIFF.png")]
    map: Option<PathBuf>,

    /// Fail, after the report, if the RMSE is above this
    #[arg(long, value_name = "E", value_parser = error_bound, allow_hyphen_values = true)]
    max_rmse: Option<f64>,

    #[command(flatten)]
    report: ReportArgs,
}

/// What `compare --json` prints.
#[derive(Serialize)]
struct Report {
    width: u32,
    height: u32,
    #[serde(flatten)]
    errors: Errors,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    if args.map.is_some() && cfg!(not(feature = "flip")) {
        return Err(Error::usage("--map: this voxdag was built without FLIP")
            .hint("build it with its default features, which need a C++ compiler"));
    }
    let output = args.map.as_deref().map(|path| Output::create(path, "png")).transpose()?;
    let inputs = [args.reference.clone(), args.picture.clone()];
    output.iter().try_for_each(|output| output.must_not_replace(&inputs))?;

    // Sizes are compared before anything is decoded.
    let [a, b] = [open(&args.reference)?, open(&args.picture)?];
    let (width, height) = a.dimensions();
    if b.dimensions() != (width, height) {
        let (other_width, other_height) = b.dimensions();
        return Err(Error::input(
            &args.picture,
            format_args!("is {other_width}x{other_height}, but {} is {width}x{height}", args.reference.display()),
        )
        .hint("compare pictures of one size"));
    }
    let [a, b] = [pixels(&args.reference, a)?, pixels(&args.picture, b)?];
    let [a, b] = [&a, &b].map(|pixels| View { width, height, pixels });

    let report = Report { width, height, errors: metrics::errors(a, b) };
    if let (Some(output), Some(map)) = (output, metrics::flip_map(a, b)) {
        output.finish(|file| png([width, height], map.iter(), file))?;
    }
    report::result(args.report.json, &report, &lines(&report))?;

    let Errors { rmse, differing, .. } = report.errors;
    let show_where = args.map.is_none() && cfg!(feature = "flip");
    if let Some(most) = args.max_rmse.filter(|&most| !(rmse <= most)) {
        let message = format_args!("the RMSE of {} is above --max-rmse {}", number(rmse), number(most));
        let error = Error::new(Kind::Failure, format_args!("{}: {message}", args.picture.display()));
        return Err(if show_where { error.hint("see where with --map DIFF.png") } else { error });
    }
    if show_where && differing > 0 {
        report::next(format_args!("{} --map difference.png", report::typed()));
    }
    Ok(())
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let Report { width, height, errors: Errors { rmse, psnr, ssim, flip, differing } } = *report;
    let pixels = u64::from(width) * u64::from(height);
    let share = 100.0 * differing as f64 / pixels as f64;
    let flip_row = |flip| format!("{}, 0 is equal; 67 pixels per degree", digits(flip));
    let mut lines = Lines::default();
    lines
        .row("pictures", format!("{width}x{height}"))
        .row("RMSE", format!("{} of 1, in linear light", digits(rmse)))
        .row("PSNR", psnr.map_or("infinite: no pixel differs".to_owned(), |psnr| format!("{psnr:.2} dB")))
        .row("SSIM", format!("{ssim:.6}, 1 is equal"))
        .row("FLIP", flip.map_or("not in this build".to_owned(), flip_row))
        .row("differing", format!("{} of {} pixels ({share:.1} %)", grouped(differing), grouped(pixels)));
    lines
}

/// An error, with digits that also tell a small one from none.
fn digits(error: f64) -> String {
    if error == 0.0 || error >= 1e-3 { format!("{error:.6}") } else { format!("{error:.3e}") }
}

/// A PNG of which only the head is read.
fn open(path: &Path) -> Result<PngDecoder<BufReader<File>>> {
    let file = File::open(path).map_err(|e| unreadable(path, &e))?;
    let mut file = BufReader::new(file);
    let head = file.fill_buf().map_err(|e| unreadable(path, &e))?;
    if !head.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Err(Error::input(path, "is not a PNG: it does not start with the mark of one")
            .hint("expected a picture as `voxdag render` writes it"));
    }
    let decoder = PngDecoder::with_limits(file, Limits::default()).map_err(|e| broken(path, e))?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MOST_PIXELS as u64 {
        let message = format_args!("{}: {width}x{height} pixels, the limit is {MOST_PIXELS}", path.display());
        return Err(Error::new(Kind::Limit, message).hint("compare parts of the pictures"));
    }
    Ok(decoder)
}

/// All of it, red in the lowest byte.
fn pixels(path: &Path, decoder: PngDecoder<BufReader<File>>) -> Result<Vec<u32>> {
    let image = DynamicImage::from_decoder(decoder).map_err(|e| broken(path, e))?.into_rgba8();
    Ok(image.pixels().map(|pixel| u32::from_le_bytes(pixel.0)).collect())
}

fn broken(path: &Path, cause: ImageError) -> Error {
    match cause {
        ImageError::Limits(_) => {
            Error::new(Kind::Limit, format_args!("{}: needs too much memory: {cause}", path.display()))
        }
        _ => Error::input(path, format_args!("is a broken PNG: {cause}")).hint("copy or draw it again"),
    }
}

/// Reads the largest RMSE that is right.
fn error_bound(text: &str) -> Result<f64, String> {
    let bound = text.parse().ok().filter(|bound| (0.0..=1.0).contains(bound));
    bound.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}
