//! `voxdag cast`: a file of rays becomes a file of hits.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::ValueEnum;
use rayon::prelude::*;
use serde::Serialize;
use voxdag::Morton;
use voxdag::file::Scene;
use voxdag::geometry::Geometry;
use voxdag::layout::AnyGeometry;
use voxdag::materials::Materials;
use voxdag::normal::{self, NormalKind};
use voxdag::trace::{Arithmetic, Face, Hit, Query, Tracer};
use voxdag::trees;
use voxdag_oracle::textbook::dda_f32_hit;

use crate::error::{Error, Kind, Result};
use crate::input;
use crate::options::{MachineArgs, NormalsArg, ReportArgs};
use crate::output::Sink;
use crate::rays::{self, Blocks, Ray};
use crate::report::{self, Lines, grouped, shell_word, time};
use crate::scene;
use crate::stats::{self, ms};

/// Follow rays from a file to the first voxel that each meets
#[derive(clap::Args)]
#[command(after_help = "\
Rays: CSV, one a line: ox,oy,oz,dx,dy,dz or ox,oy,oz,dx,dy,dz,tmin,tmax (0 and inf where left out; hits before tmin, and
at or after tmax, do not count). Numbers are decimal or C99 hexadecimal (0x1.8p3 is 12). A first line may name the
columns; blank lines are skipped.

Hits: CSV, one line a ray, in order: hit,t,x,y,z,face,material,nx,ny,nz
  hit       1, or 0 with all else empty; a ray that is none (nan, no direction) misses
  t         where the ray enters the voxel, in units of its direction, with 17 digits; tmin if it starts inside
  x,y,z     the voxel, in the grid whatever --space is
  face      the voxel's side: -x, +x, -y, +y, -z, +z, or inside for a ray that starts there
  material  its number; `voxdag info F.vxd` has the names
  nx,ny,nz  the surface's direction, out of it, of length 1

World rays are moved to the grid once, in f64: (origin - grid origin) / voxel size, direction / voxel size. The answer
is exact for the ray after that, and t is the same in both spaces.

Examples:
  voxdag cast bunny.vxd --rays rays.csv -o hits.csv
  echo 0,0,9,0,0,-1 | voxdag cast bunny.vxd --rays -")]
pub struct Args {
    /// A scene from `voxdag build`
    #[arg(value_name = "F.vxd")]
    scene: PathBuf,

    /// The rays; `-` reads them from stdin
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,

    /// Where the hits go; `-` is stdout [default: -]
    #[arg(short, long, value_name = "HITS.csv")]
    output: Option<PathBuf>,

    /// The coordinates in which the rays are given
    #[arg(long, value_enum, value_name = "SPACE", default_value_t)]
    space: Space,

    /// How rays are followed
    #[arg(long, value_enum, value_name = "KIND", default_value_t)]
    arithmetic: CastArithmetic,

    /// Where the surface's direction is taken from
    #[arg(long, value_enum, value_name = "KIND", default_value_t)]
    normals: NormalsArg,

    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// The coordinates of the rays.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Default)]
enum Space {
    /// The mesh's own
    #[default]
    World,
    /// Voxel k spans k to k + 1
    Grid,
}

/// How rays are followed.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Default)]
enum CastArithmetic {
    /// Right for every ray
    #[default]
    Exact,
    /// Rounded; may miss by a voxel where a ray runs along an edge
    F64,
    /// The textbook's walk in single precision, to compare with; t and voxels may be off
    F32,
}

/// What `cast --json` prints.
#[derive(Serialize)]
struct Report {
    rays: u64,
    hits: u64,
    ms: Ms,
    peak_rss_bytes: Option<u64>,
    threads: usize,
}

#[derive(Serialize)]
struct Ms {
    /// Reading rays, following them and writing hits.
    cast: f64,
    /// From the start of the program to the finished file.
    total: f64,
}

/// Bytes of rays that a thread takes at a time.
const PIECE: usize = 16 << 10;

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let sink = Sink::create(args.output.as_deref(), "csv", args.report.json)?;
    sink.must_not_replace(&[args.scene.clone(), args.rays.clone()])?;
    let to_file = matches!(sink, Sink::File(_));
    let pool = args.machine.pool()?;
    let words = input::read_scene_within(&args.scene, &mut args.machine.memory())?;
    let scene = scene::open(&args.scene, &words)?;
    let top = scene::top_grid(scene.geometry)?;
    let caster = Caster {
        scene: &scene,
        tracer: trees::tracer(scene.geometry, &top),
        space: args.space,
        arithmetic: args.arithmetic,
        normals: args.normals.kind(scene.materials.has_normals())?,
    };

    let begin = Instant::now();
    let from_stdin = args.rays == Path::new("-");
    let path = if from_stdin { Path::new("stdin") } else { &args.rays };
    let source: Box<dyn Read> = if from_stdin {
        Box::new(std::io::stdin().lock())
    } else {
        Box::new(File::open(path).map_err(|e| input::unreadable(path, &e))?)
    };
    let (mut cast, mut hits) = (0, 0);
    sink.finish(|out| {
        writeln!(out, "hit,t,x,y,z,face,material,nx,ny,nz")?;
        let mut blocks = Blocks::new(source);
        let (mut line, mut header) = (1, true);
        while let Some(mut block) = blocks.next().map_err(|e| input::unreadable(path, &e))? {
            if line == 1 {
                block = block.strip_prefix(b"\xef\xbb\xbf").unwrap_or(block);
            }
            // The first line that says anything may name the columns.
            while let (true, Some(first)) = (header, block.split_inclusive(|&b| b == b'\n').next()) {
                header = rays::is_blank(first);
                if header || rays::is_header(first) {
                    block = &block[first.len()..];
                    line += 1;
                }
            }
            // Follow the rays on all threads and write what they met in order.
            let pieces = rays::pieces(block, PIECE);
            let answers: Vec<_> = pool.install(|| pieces.par_iter().map(|piece| caster.answer(piece)).collect());
            for (piece, answer) in pieces.iter().zip(answers) {
                let answer = answer.map_err(|Wrong { line: after, message }| {
                    Error::new(Kind::BadInput, format_args!("{}:{}: {message}", path.display(), line + after))
                })?;
                out.write_all(answer.text.as_bytes())?;
                cast += answer.rays;
                hits += answer.hits;
                line += rays::lines(piece).count() as u64;
            }
            out.flush()?;
        }
        Ok(())
    })?;

    if to_file {
        let report = Report {
            rays: cast,
            hits,
            ms: Ms { cast: ms(begin.elapsed()), total: ms(start.elapsed()) },
            peak_rss_bytes: stats::peak_rss_bytes(),
            threads: pool.current_num_threads(),
        };
        report::result(args.report.json, &report, &lines(&report))?;
    }
    report::next(format_args!("info {}", shell_word(&args.scene)));
    Ok(())
}

/// What rays are asked of.
struct Caster<'a> {
    scene: &'a Scene<'a>,
    tracer: Tracer<'a, AnyGeometry<'a>>,
    space: Space,
    arithmetic: CastArithmetic,
    normals: NormalKind,
}

/// Lines of hits.
struct Answer {
    text: String,
    rays: u64,
    hits: u64,
}

/// A line that is no ray.
struct Wrong {
    /// Counted from 0 within the piece.
    line: u64,
    message: String,
}

impl Caster<'_> {
    /// The hits of the rays in some lines.
    fn answer(&self, lines: &[u8]) -> Result<Answer, Wrong> {
        let mut answer = Answer { text: String::new(), rays: 0, hits: 0 };
        for (i, line) in rays::lines(lines).enumerate().filter(|(_, line)| !rays::is_blank(line)) {
            let wrong = |message| Wrong { line: i as u64, message };
            let query = rays::ray(line).and_then(|ray| self.query(&ray)).map_err(wrong)?;
            let hit = self.trace(&query);
            answer.rays += 1;
            answer.hits += u64::from(hit.is_some());
            match hit {
                Some(hit) => self.write(&mut answer.text, &query, &hit),
                None => answer.text.push_str("0,,,,,,,,,\n"),
            }
        }
        Ok(answer)
    }

    /// The ray in grid coordinates.
    fn query(&self, ray: &Ray) -> Result<Query, String> {
        let Ray { origin, dir, t_min, t_max } = *ray;
        let grid = &self.scene.grid;
        let (moved, turned) = match self.space {
            Space::Grid => (origin, dir),
            Space::World => (grid.to_grid(origin), dir.map(|d| d / grid.voxel_size)),
        };
        let lost = |from: &[f64; 3], to: &[f64; 3]| from.iter().zip(to).any(|(a, b)| a.is_finite() && !b.is_finite());
        if lost(&origin, &moved) || lost(&dir, &turned) {
            return Err("the ray is too large in grid coordinates: expected less than 1.797e308".to_owned());
        }
        Ok(Query { t_min, t_max, ..Query::new(moved, turned) })
    }

    /// The first voxel that the ray meets.
    fn trace(&self, query: &Query) -> Option<Hit> {
        let geometry = self.scene.geometry;
        match self.arithmetic {
            CastArithmetic::Exact => self.tracer.trace(Arithmetic::Exact, query),
            CastArithmetic::F64 => self.tracer.trace(Arithmetic::F64, query),
            CastArithmetic::F32 => {
                let single = |v: [f64; 3]| v.map(|x| x as f32);
                let filled = |voxel| Morton::encode(voxel).is_some_and(|voxel| geometry.contains(voxel));
                let (origin, dir) = (single(query.origin), single(query.dir));
                if !origin.iter().chain(&dir).all(|x| x.is_finite()) || dir == [0.0; 3] {
                    return None;
                }
                let hit = dda_f32_hit(origin, dir, query.t_min as f32, geometry.depth(), filled)?;
                let face = hit.axis.map_or(Face::Inside, |axis| FACES[axis][usize::from(dir[axis] > 0.0)]);
                let hit = Hit { voxel: Morton::encode(hit.voxel)?, from: None, t: hit.t.into(), level: 0, face };
                (hit.t < query.t_max).then_some(hit)
            }
        }
    }

    /// The line of a hit.
    fn write(&self, text: &mut String, query: &Query, hit: &Hit) {
        use std::fmt::Write as _;
        let materials = self.scene.materials;
        let [x, y, z] = hit.voxel.decode();
        let material = materials.id(hit.voxel);
        let [nx, ny, nz] = normal::normal(&self.tracer, materials, hit, query.dir, self.normals).direction;
        let face = match hit.face {
            Face::NegX => "-x",
            Face::PosX => "+x",
            Face::NegY => "-y",
            Face::PosY => "+y",
            Face::NegZ => "-z",
            Face::PosZ => "+z",
            Face::Inside => "inside",
        };
        // Text in memory can always be written.
        let _ = writeln!(text, "1,{:.16e},{x},{y},{z},{face},{material},{nx},{ny},{nz}", hit.t);
    }
}

/// The side of entry by axis, for a direction that is negative or positive.
const FACES: [[Face; 2]; 3] = [[Face::PosX, Face::NegX], [Face::PosY, Face::NegY], [Face::PosZ, Face::NegZ]];

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    let share = 100.0 * report.hits as f64 / report.rays.max(1) as f64;
    lines
        .row("rays", grouped(report.rays))
        .row("hits", format!("{} ({share:.1} %)", grouped(report.hits)))
        .row("time", format!("{}: cast {}", time(report.ms.total), time(report.ms.cast)))
        .row("memory", report::peak(report.peak_rss_bytes))
        .row("threads", report.threads.to_string());
    lines
}
