//! `voxdag bench accuracy`: the textbook methods beside the exact ones, what they cost and where they err.
//!
//! - Overlap: the textbook's test ([`overlap`]) against the exact cover. All are given per voxel and triangle that come
//!   near each other. To the textbook's advantage the way down to bricks is not in its time; in that of the exact cover it
//!   is.
//! - Tracing: a DDA in f32 (Amanatides and Woo 1987), voxel by voxel, and f64 without a bound on errors.
//! - Normals: of a sphere, planes and a torus, whose true ones are known.

use serde::Serialize;
use voxdag::Geometry;
use voxdag::build::DagBuf;
use voxdag::camera::Camera;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::match_geometry;
use voxdag::materials::Single;
use voxdag::math::{cross, dot, sqrt, sub};
use voxdag::normal::{NormalKind, normal};
use voxdag::trace::{Arithmetic, Query, Tracer};
use voxdag::voxelize::{Cover, Voxelizer};
use voxdag::{Dag, Grid, Morton};
use voxdag_oracle::scenes::{self, Shape};
use voxdag_oracle::subject;
use voxdag_oracle::textbook::dda_f32;

use super::build::voxelized;
use super::rays::{self, Found};
use super::{Cost, Run};
use crate::error::{Error, Kind, Result};
use crate::measure::{Arm, measure};
use crate::overlap::{self, Near};
use crate::picture::{self, Shown};
use crate::report::{self, Lines, grouped};
use crate::source::Source;

/// What `bench accuracy --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    repeat: u32,
    threads: u16,
    /// Where the input is a mesh.
    overlap: Option<Overlap>,
    tracing: Tracing,
    normals: Normals,
}

#[derive(Serialize)]
struct Overlap {
    /// Voxels beside triangles: what the times are divided by.
    tests: usize,
    /// Of the exact cover.
    voxels: u64,
    f32: Covered,
    f64: Covered,
    exact: Covered,
}

/// A cover beside the exact one.
#[derive(Serialize)]
struct Covered {
    #[serde(flatten)]
    cost: Cost,
    /// Missing and extra ones.
    wrong: u64,
    /// Holes.
    missing: u64,
    extra: u64,
}

#[derive(Serialize)]
struct Tracing {
    rays: usize,
    f32: Traced,
    f64: Traced,
    exact: Traced,
}

/// A tracer beside the exact one.
#[derive(Serialize)]
struct Traced {
    #[serde(flatten)]
    cost: Cost,
    /// Rays that end in another voxel, or in none.
    wrong: usize,
}

#[derive(Serialize)]
struct Normals {
    hits: usize,
    face: Degrees,
    gradient: Degrees,
    plane1: Degrees,
    plane2: Degrees,
    plane3: Degrees,
    ernerfeldt1: Degrees,
    ernerfeldt2: Degrees,
}

/// How far normals of a kind are off, on average.
#[derive(Serialize)]
struct Degrees {
    #[serde(flatten)]
    cost: Cost,
    sphere: f64,
    plane: f64,
    torus: f64,
}

/// Rays that the tracers are compared on, at most: the textbook's takes microseconds each.
const RAYS: usize = 1 << 16;

/// Runs the command.
pub fn run(run: &Run, scene: &Shown<'_>, source: Option<&Source>) -> Result<()> {
    let report = Report {
        resolution: scene.grid.resolution,
        repeat: run.repeat,
        threads: run.threads,
        overlap: source.map(|source| overlap(run, source, &scene.grid)).transpose()?,
        tracing: match_geometry!(scene.geometry, geometry => tracing(run, scene, geometry))?,
        normals: normals(run)?,
    };
    report::result(run.report.json, &report, &lines(&report))
}

fn defect(error: impl std::fmt::Display) -> Error {
    Error::new(Kind::Failure, error)
}

fn overlap(run: &Run, source: &Source, grid: &Grid) -> Result<Overlap> {
    let mesh = source.model.mesh();
    let voxelizer = Voxelizer::new(&mesh, grid, Cover::Exact).map_err(defect)?;
    let near = overlap::near(&mesh, grid);
    let [f32, f64, exact] = measure(
        run.repeat,
        [
            Arm::each(&near, |near: &Near| near.f32().count_ones().into()),
            Arm::each(&near, |near: &Near| near.f64().count_ones().into()),
            Arm::pieces(voxelizer.subtrees(), |part| voxelized(&voxelizer, part)),
        ],
    )?;

    let truth = overlap::exact(&mesh, grid).map_err(defect)?;
    let tests = 64 * near.len();
    let covered = |times, found: &[overlap::Brick]| {
        let [missing, extra] = overlap::differing(&truth, found);
        Covered { cost: Cost::of(times, tests), wrong: missing + extra, missing, extra }
    };
    Ok(Overlap {
        tests,
        voxels: truth.iter().map(|brick| u64::from(brick.1.count_ones())).sum(),
        f32: covered(&f32, &overlap::bricks(&near, Near::f32)),
        f64: covered(&f64, &overlap::bricks(&near, Near::f64)),
        exact: covered(&exact, &truth),
    })
}

fn tracing<G: Geometry>(run: &Run, scene: &Shown<'_>, geometry: G) -> Result<Tracing> {
    let all = picture::primary(scene, &run.camera, run.size)?;
    let some: Vec<Query> = all.iter().step_by(all.len().div_ceil(RAYS)).copied().collect();
    let top = rays::top_grid(geometry)?;
    let tracer = rays::tracer(geometry, &top)?;
    let by = |arithmetic| move |q: &Query| tracer.trace(arithmetic, q).map(|hit| hit.voxel);
    let (exact, f64) = (by(Arithmetic::Exact), by(Arithmetic::F64));
    let f32 = |q: &Query| textbook(geometry, q);
    let fold = |voxel: Option<Morton>| voxel.map_or(1, |v| v.0);
    let times = measure(
        run.repeat,
        [
            Arm::each(&some, move |q| fold(f32(q))),
            Arm::each(&some, move |q| fold(f64(q))),
            Arm::each(&some, move |q| fold(exact(q))),
        ],
    )?;
    let traced = |method: usize, wrong| Traced { cost: Cost::of(&times[method], some.len()), wrong };
    let differing = |f: &dyn Fn(&Query) -> Option<Morton>| some.iter().filter(|q| f(q) != exact(q)).count();
    Ok(Tracing {
        rays: some.len(),
        f32: traced(0, differing(&f32)),
        f64: traced(1, differing(&f64)),
        exact: traced(2, 0),
    })
}

fn textbook(geometry: impl Geometry, query: &Query) -> Option<Morton> {
    let [origin, dir] = [query.origin, query.dir].map(|v| v.map(|x| x as f32));
    let filled = |v| Morton::encode(v).is_some_and(|v| geometry.contains(v));
    dda_f32(origin, dir, geometry.depth(), filled).and_then(Morton::encode)
}

/// A shape in a grid of side [`SIDE`], and the normal of its surface nearest to a point.
struct Known {
    dag: DagBuf,
    normal: Box<dyn Fn([f64; 3]) -> [f64; 3]>,
}

const SIDE: u32 = 128;
/// Slopes of the planes.
const RISES: [f64; 8] = [0.07, 0.19, 0.31, 0.43, 0.55, 0.67, 0.79, 0.91];

impl Known {
    fn new(shape: &Shape, normal: impl Fn([f64; 3]) -> [f64; 3] + 'static) -> Result<Known> {
        let built = subject::build(&shape.mesh(), &subject::unit_grid(SIDE), Cover::Exact);
        let dag = built.map_err(|_| defect("a shape of known normals cannot be built: this is a defect of voxdag"))?;
        Ok(Known { dag, normal: Box::new(normal) })
    }

    /// What a picture of 256 x 256 pixels shows of the surface. Where a plane ends at the border of the cube, the voxels
    /// around are not those of a plane.
    fn seen(&self) -> Result<Vec<Found>> {
        let camera = Camera::framing(&Bounds { min: [0.0; 3], max: [f64::from(SIDE); 3] }, UpAxis::Z);
        let rays = camera.rays(256, 256).map_err(defect)?;
        let pixels = (0..256).flat_map(|y| (0..256).map(move |x| [x, y].map(|k| f64::from(k) + 0.5)));
        let queries: Vec<_> = pixels.map(|[x, y]| Query::new(camera.eye, rays.direction(x, y))).collect();
        let mut found = rays::hits(&Tracer::new(self.dag.dag()), &queries)?;
        found.retain(|f| f.hit.voxel.decode().iter().all(|k| (4..SIDE - 4).contains(k)));
        Ok(found)
    }

    /// Degrees by which normals of a kind are off, on average.
    fn degrees(&self, kind: NormalKind, found: &[Found]) -> f64 {
        let off = |f: &Found| {
            let truth = (self.normal)(f.hit.voxel.decode().map(|k| f64::from(k) + 0.5));
            let n = normal(&Tracer::new(self.dag.dag()), Single(0), &f.hit, f.dir, kind).direction.map(f64::from);
            let sine = cross(n, truth);
            libm::atan2(sqrt(dot(sine, sine)), dot(n, truth)).to_degrees()
        };
        found.iter().map(off).sum::<f64>() / found.len() as f64
    }
}

fn normals(run: &Run) -> Result<Normals> {
    let middle = [f64::from(SIDE) / 2.0; 3];
    let sphere = Known::new(&scenes::sphere(middle, 50.0, 5), move |p| sub(p, middle))?;
    let (major, minor) = (40.0, 18.0);
    let torus = Known::new(&scenes::torus(middle, major, minor, 256, 128), move |p| {
        let [x, y, z] = sub(p, middle);
        let out = sqrt(x * x + y * y);
        [x - x * major / out, y - y * major / out, z]
    })?;
    let plane =
        |rise| Known::new(&scenes::tilted_plane(f64::from(SIDE), rise, 5.0), move |_| [-rise / 2.0, -rise / 2.0, 1.0]);
    let planes: Vec<_> = RISES.into_iter().map(plane).collect::<Result<_>>()?;
    let known: Vec<_> = [sphere, torus].into_iter().chain(planes).collect();
    let found: Vec<_> = known.iter().map(Known::seen).collect::<Result<_>>()?;

    let all: Vec<_> = known.iter().zip(&found).flat_map(|(k, f)| f.iter().map(|f| (k.dag.dag(), f))).collect();
    let arm = |kind| {
        Arm::each(&all, move |(dag, f): &(Dag<'_>, &Found)| {
            let n = normal(&Tracer::new(*dag), Single(0), &f.hit, f.dir, kind).direction;
            n.iter().fold(0, |sum: u64, x| sum.rotate_left(21) ^ u64::from(x.to_bits()))
        })
    };
    let kinds = [
        NormalKind::Face,
        NormalKind::Gradient,
        NormalKind::Plane1,
        NormalKind::Plane2,
        NormalKind::Plane3,
        NormalKind::Ernerfeldt1,
        NormalKind::Ernerfeldt2,
    ];
    let times = measure(run.repeat, kinds.map(arm))?;
    let degrees = |i: usize| {
        let of = |shape: usize| known[shape].degrees(kinds[i], &found[shape]);
        let planes = 2..known.len();
        Degrees {
            cost: Cost::of(&times[i], all.len()),
            sphere: of(0),
            plane: planes.clone().map(of).sum::<f64>() / planes.len() as f64,
            torus: of(1),
        }
    };
    Ok(Normals {
        hits: all.len(),
        face: degrees(0),
        gradient: degrees(1),
        plane1: degrees(2),
        plane2: degrees(3),
        plane3: degrees(4),
        ernerfeldt1: degrees(5),
        ernerfeldt2: degrees(6),
    })
}

/// The table for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    match &report.overlap {
        None => {
            lines.row("overlap", "needs the mesh");
        }
        Some(o) => {
            lines.row("overlap", format!("{} voxels, ns per voxel and triangle near it", grouped(o.voxels)));
            for (name, c) in [("f32", &o.f32), ("f64", &o.f64), ("exact", &o.exact)] {
                let wrong = format!("{} missing, {} extra", grouped(c.missing), grouped(c.extra));
                lines.row(format!("  {name}"), format!("{:8.2} ns, {wrong}", c.cost.ns));
            }
        }
    }
    let t = &report.tracing;
    lines.row("tracing", format!("{} rays", grouped(t.rays as u64)));
    for (name, r) in [("f32, voxel by voxel", &t.f32), ("f64", &t.f64), ("exact", &t.exact)] {
        lines.row(format!("  {name}"), format!("{:8.1} ns, {} wrong", r.cost.ns, grouped(r.wrong as u64)));
    }
    let n = &report.normals;
    lines.row("normals", "degrees off on a sphere, planes and a torus");
    let kinds = [
        ("face", &n.face),
        ("gradient", &n.gradient),
        ("plane1", &n.plane1),
        ("plane2", &n.plane2),
        ("plane3", &n.plane3),
        ("ernerfeldt1", &n.ernerfeldt1),
        ("ernerfeldt2", &n.ernerfeldt2),
    ];
    for (name, d) in kinds {
        lines.row(
            format!("  {name}"),
            format!("{:8.1} ns, {:6.2} {:6.2} {:6.2}", d.cost.ns, d.sphere, d.plane, d.torus),
        );
    }
    lines
}
