//! Several DAGs in one scene, each turned and moved as a rigid body: a ray goes into each object's own grid.
//!
//! `cargo run --release -p voxdag --features obj --example instances -- bodies.pgm` writes a picture, grey.

use std::error::Error;

use voxdag::build::{DagBuf, DagBuilder};
use voxdag::camera::Camera;
use voxdag::materials::Single;
use voxdag::normal::{NormalKind, normal};
use voxdag::render::each_pixel;
use voxdag::trace::{Arithmetic, Hit, Query, Tracer};
use voxdag::{Dag, Grid, Morton, color, math};

/// A DAG, the grid that it fills in its body's own coordinates, and where the body is in the world.
struct Body<'a> {
    tracer: Tracer<'a, Dag<'a>>,
    grid: Grid,
    /// The body's axes in the world: unit vectors at right angles.
    axes: [[f64; 3]; 3],
    place: [f64; 3],
}

impl Body<'_> {
    /// A direction of the world in the body.
    fn turned_in(&self, v: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| math::dot(axis, v))
    }

    /// A direction of the body in the world.
    fn turned_out(&self, v: [f64; 3]) -> [f64; 3] {
        (0..3).fold([0.0; 3], |sum, i| math::add_scaled(sum, self.axes[i], v[i]))
    }

    /// What a ray of the world meets. Lengths along it stay what they are: t is the world's.
    fn trace(&self, origin: [f64; 3], dir: [f64; 3]) -> Option<(Query, Hit)> {
        let origin = self.grid.to_grid(self.turned_in(math::sub(origin, self.place)));
        let query = Query::new(origin, self.turned_in(dir).map(|x| x / self.grid.voxel_size));
        Some((query, self.tracer.trace(Arithmetic::Exact, &query)?))
    }
}

/// The nearest hit of all bodies: t, and the normal in the world.
fn trace(bodies: &[Body<'_>], origin: [f64; 3], dir: [f64; 3]) -> Option<(f64, [f64; 3])> {
    let hits = bodies.iter().filter_map(|body| Some((body, body.trace(origin, dir)?)));
    let (body, (query, hit)) = hits.min_by(|(_, (_, a)), (_, (_, b))| a.t.total_cmp(&b.t))?;
    let normal = normal(&body.tracer, Single(0), &hit, query.dir, NormalKind::Plane2).direction;
    Some((hit.t, body.turned_out(normal.map(f64::from))))
}

/// A cube of 64 voxels a side, filled where `inside` says so; coordinates from -1 to 1.
fn solid(inside: impl Fn([f64; 3]) -> bool) -> Result<DagBuf, Box<dyn Error>> {
    let mut builder = DagBuilder::new(6)?;
    for brick in 0..16u64.pow(3) {
        let filled = (0..64).filter(|bit| {
            let voxel = Morton(64 * brick + bit).decode();
            inside(voxel.map(|x| (f64::from(x) + 0.5) / 32.0 - 1.0))
        });
        let mask = filled.fold(0, |mask, bit| mask | 1 << bit);
        if mask != 0 {
            builder.push(Morton(64 * brick), mask)?;
        }
    }
    Ok(builder.finish()?)
}

/// The grid of [`solid`].
const GRID: Grid = Grid { origin: [-1.0; 3], voxel_size: 1.0 / 32.0, resolution: 64 };

/// A frame of beams, and a ball.
fn shapes() -> Result<[DagBuf; 2], Box<dyn Error>> {
    let frame = solid(|p| p.iter().filter(|x| x.abs() > 0.7).count() >= 2)?;
    let ball = solid(|p| math::dot(p, p) < 0.95)?;
    Ok([frame, ball])
}

/// The frame stands on a corner, the ball lies in it.
fn bodies([frame, ball]: &[DagBuf; 2]) -> [Body<'_>; 2] {
    let unit = |v: [f64; 3]| math::normalize(v).expect("not zero");
    let up = unit([1.0, 1.0, 1.0]);
    let right = unit([1.0, -1.0, 0.0]);
    // Columns of the turn that takes the cube's diagonal to y.
    let rows = [right, up, math::cross(right, up)];
    let axes = [0, 1, 2].map(|i| [rows[0][i], rows[1][i], rows[2][i]]);
    let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    [
        Body { tracer: Tracer::new(frame.dag()), grid: GRID, axes, place: [0.0; 3] },
        Body { tracer: Tracer::new(ball.dag()), grid: GRID, axes: still, place: [0.2, 0.0, 0.3] },
    ]
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(path) = std::env::args().nth(1) else {
        println!("name a file for the picture:");
        println!("cargo run --release -p voxdag --features obj --example instances -- bodies.pgm");
        return Ok(());
    };
    let shapes = shapes()?;
    let bodies = bodies(&shapes);
    let camera = Camera { eye: [1.5, 1.8, 5.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 40.0 };
    // Rays of the world itself: a grid of unit voxels from its origin.
    let world = Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 1 };
    let (size, mut grey) = ([640, 480], vec![0; 640 * 480]);
    each_pixel(&camera, &world, size, 0..size[1], &mut grey, |pixel| {
        let ray = pixel.query([0.5; 2]);
        let light =
            trace(&bodies, ray.origin, ray.dir).map_or(0.75, |(_, normal)| 0.35 + 0.3 * normal[1] + 0.15 * normal[0]);
        color::linear_to_srgb8(color::quantize(light as f32))
    })?;
    let header = format!("P5 {} {} 255\n", size[0], size[1]).into_bytes();
    std::fs::write(&path, [header, grey].concat())?;
    println!("{path}");
    Ok(())
}

#[test]
fn distances_are_the_worlds_and_the_nearest_body_is_seen() {
    let shapes = shapes().unwrap();
    let bodies = bodies(&shapes);
    // From the side: the ball, whose surface is 0.97 from its middle. Slowly: t is in units of the direction.
    let (t, normal) = trace(&bodies, [0.2, 0.0, 9.0], [0.0, 0.0, -0.5]).unwrap();
    assert!((0.5 * t - (9.0 - 0.3 - 0.95f64.sqrt())).abs() < 0.05, "{t}");
    assert!(normal[2] > 0.99, "{normal:?}");
    // From above: the frame's corner, half the cube's diagonal high.
    let (t, _) = trace(&bodies, [0.0, 9.0, 0.0], [0.0, -1.0, 0.0]).unwrap();
    assert!((9.0 - t - 3f64.sqrt()).abs() < 0.05, "{t}");
    // Turned out again, directions are what they were.
    let v = [0.3, -0.4, 0.5];
    let there_and_back = math::sub(bodies[0].turned_out(bodies[0].turned_in(v)), v);
    assert!(there_and_back.iter().all(|x| x.abs() < 1e-12));
    assert_eq!(trace(&bodies, [0.0, 9.0, 0.0], [0.0, 1.0, 0.0]), None);
}
