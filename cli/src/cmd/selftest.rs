//! `voxdag selftest`: the exact methods against the oracles on this machine, beside the textbook's in f32 and in f64.

use rayon::prelude::*;
use serde::Serialize;
use voxdag_oracle::selftest::{self, Case, Tally, Unit};

use crate::error::{Error, Kind, Result};
use crate::options::ReportArgs;
use crate::progress::Progress;
use crate::report::{self, Lines, grouped};

/// Check the exact methods on this machine, beside the textbook's in single and double precision
#[derive(clap::Args)]
#[command(after_help = "\
Overlap:  voxels beside triangles, against clipping in rational numbers
Rays:     against a ray oracle in rational numbers
Leaks:    rays from inside a closed mesh, which must meet it (Embree's test of watertightness)
Normals:  of neighbourhoods whose normals are known, or known to turn with them

Every case is drawn from fixed seeds: the numbers are the same on every machine. Ours must be 0; if it is not, the exit
code is 1 and the first wrong answer is printed. f32 and f64 are the methods of the textbook, rays in f64 those of
`--arithmetic f64`. They err by design where the table says so.")]
pub struct Args {
    /// A hundred times as much, and a million rays for leaks: minutes
    #[arg(long)]
    long: bool,

    #[command(flatten)]
    report: ReportArgs,
}

/// What `selftest --json` prints.
#[derive(Serialize)]
struct Report {
    ok: bool,
    long: bool,
    cases: Vec<Row>,
}

/// A line of the table.
#[derive(Serialize)]
struct Row {
    group: &'static str,
    case: String,
    /// What was tried: voxels beside triangles, rays or normals.
    unit: &'static str,
    tried: u64,
    wrong: Wrong,
    /// The first wrong answer of ours.
    first: Option<String>,
}

/// Wrong answers by method.
#[derive(Serialize)]
struct Wrong {
    f32: u64,
    f64: u64,
    ours: u64,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let cases = selftest::cases();
    let pieces: Vec<(usize, u64)> = cases
        .iter()
        .enumerate()
        .flat_map(|(at, case)| (0..case.pieces(args.long)).map(move |piece| (at, piece)))
        .collect();
    let progress = Progress::stage("checking", pieces.len() as u64);
    let tallies: Vec<Tally> = pieces
        .par_iter()
        .map(|&(at, piece)| {
            let tally = cases[at].piece(piece);
            progress.step();
            tally
        })
        .collect();
    drop(progress);

    let mut sums = vec![Tally::default(); cases.len()];
    for ((at, _), tally) in pieces.into_iter().zip(tallies) {
        sums[at] += tally;
    }
    let rows: Vec<Row> = cases.iter().zip(sums).map(|(case, tally)| Row::new(case, tally)).collect();
    let report = Report { ok: rows.iter().all(|row| row.wrong.ours == 0), long: args.long, cases: rows };
    report::result(args.report.json, &report, &lines(&report))?;
    verdict(&report)
}

impl Row {
    fn new(case: &Case, tally: Tally) -> Row {
        let unit = match case.unit {
            Unit::Voxels => "voxels",
            Unit::Rays => "rays",
            Unit::Normals => "normals",
        };
        let Tally { tried, f32, f64, ours, first } = tally;
        Row { group: case.group, case: case.name.clone(), unit, tried, wrong: Wrong { f32, f64, ours }, first }
    }
}

/// The table for people.
fn lines(report: &Report) -> Lines {
    let columns = |tried: &str, f32: &str, f64: &str, ours: &str| format!("{tried:>17} {f32:>9} {f64:>9} {ours:>6}");
    let mut lines = Lines::default();
    lines.row("wrong answers", columns("of", "f32", "f64", "ours"));
    let mut group = "";
    for row in &report.cases {
        if row.group != group {
            group = row.group;
            lines.row(group, "");
        }
        let Wrong { f32, f64, ours } = row.wrong;
        let tried = format!("{} {}", grouped(row.tried), row.unit);
        lines.row(format!("  {}", row.case), columns(&tried, &grouped(f32), &grouped(f64), &grouped(ours)));
    }
    lines
}

/// An error if ours was ever wrong.
fn verdict(report: &Report) -> Result<()> {
    let Some(row) = report.cases.iter().find(|row| row.wrong.ours > 0) else { return Ok(()) };
    let all: u64 = report.cases.iter().map(|row| row.wrong.ours).sum();
    let message = format!(
        "{} wrong answers; the first in {}, {}: {}",
        grouped(all),
        row.group,
        row.case,
        row.first.as_deref().unwrap_or("not kept")
    );
    Err(Error::new(Kind::Failure, message)
        .hint("this is a defect of voxdag or of the machine: please report this line"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrong_answer_of_ours_is_a_failure() {
        let row = |case: &str, ours: u64| Row {
            group: "rays",
            case: case.to_owned(),
            unit: "rays",
            tried: 100,
            wrong: Wrong { f32: 70, f64: 7, ours },
            first: (ours > 0).then(|| "this ray".to_owned()),
        };
        let report = |cases| Report { ok: true, long: false, cases };
        assert!(verdict(&report(vec![row("a", 0), row("b", 0)])).is_ok());
        let error = verdict(&report(vec![row("a", 0), row("b", 3), row("c", 2)])).unwrap_err();
        assert_eq!(error.message(), "5 wrong answers; the first in rays, b: this ray");
        assert_eq!(error.report(), 1);
    }
}
