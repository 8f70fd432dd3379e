//! Shadows of steps: voxels of planes and balls at many angles, lit by suns at many heights, against what the shapes
//! themselves would show. Which pixels are dark that ought to be lit, and which are lit that ought to be dark, by how high
//! above the surface the rays to the light start. `cargo test --release -p voxdag-oracle --test lift -- --nocapture` prints
//! the table of docs/effects.md.

use voxdag::camera::Camera;
use voxdag::materials::Single;
use voxdag::math::{add_scaled, cross, dot, normalize, sub};
use voxdag::normal::NormalKind;
use voxdag::render::{Settings, View, each_pixel, render_rows};
use voxdag::shade::{Light, LightKind};
use voxdag::trace::{Query, Tracer};
use voxdag::{Dag, Grid, Material};
use voxdag_oracle::octree::VoxelSet;
use voxdag_oracle::rng::Rng;

const SIDE: u32 = 128;
const GRID: Grid = Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: SIDE };
const SIZE: [u32; 2] = [96, 96];
const CENTER: [f64; 3] = [63.7, 64.2, 64.4];
const LIFTS: [f32; 5] = [0.0, 0.5, 1.0, 1.5, 2.0];
/// Heights of the sun above the surface, in degrees.
const SUNS: [f64; 4] = [8.0, 20.0, 45.0, 80.0];
const SEED: u64 = 71;

/// What is looked at: a plane through the centre, and what stands on it, or a ball alone.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Shape {
    Plane,
    Ball,
    /// A ball that touches the plane.
    BallOnPlane,
    /// A wall across the plane, upright.
    WallOnPlane,
}

/// Half the side of the plane, and how long and high the wall is.
const HALF: f64 = 46.0;
const WALL: [f64; 2] = [30.0, 14.0];
const RADIUS: f64 = 40.0;
const SMALL: f64 = 11.0;

/// A shape, turned: up, and two directions along the plane.
struct Scene {
    shape: Shape,
    axes: [[f64; 3]; 3],
}

type Point = [f64; 3];

impl Scene {
    fn new(shape: Shape, rng: &mut Rng) -> Scene {
        let direction = |rng: &mut Rng| normalize(rng.direction()).unwrap_or([0.0, 1.0, 0.0]);
        let up = direction(rng);
        let across = loop {
            if let Some(across) = normalize(cross(up, direction(rng))) {
                break across;
            }
        };
        Scene { shape, axes: [up, across, cross(up, across)] }
    }

    /// Height above the plane, and where on it.
    fn local(&self, p: Point) -> Point {
        self.axes.map(|axis| dot(sub(p, CENTER), axis))
    }

    /// Whether a surface passes through the box of a voxel.
    fn fills(&self, voxel: [u32; 3]) -> bool {
        let low = voxel.map(f64::from);
        let corners = || (0..8).map(move |c| [0, 1, 2].map(|i| low[i] + f64::from(c >> i & 1)));
        let crosses = |axis: usize| {
            let mut sides = corners().map(|p| self.local(p)[axis] > 0.0);
            let first = sides.next();
            sides.any(|side| Some(side) != first)
        };
        let shell = |center: Point, radius: f64| {
            let far = corners().map(|p| sub(p, center)).map(|d| dot(d, d)).fold(0.0, f64::max);
            let nearest = [0, 1, 2].map(|i| center[i].clamp(low[i], low[i] + 1.0) - center[i]);
            dot(nearest, nearest) <= radius * radius && far > radius * radius
        };
        let [height, u, v] = self.local(low.map(|x| x + 0.5));
        let plane = u.abs() < HALF && v.abs() < HALF && crosses(0);
        match self.shape {
            Shape::Plane => plane,
            Shape::Ball => shell(CENTER, RADIUS),
            Shape::BallOnPlane => plane || shell(self.small(), SMALL),
            Shape::WallOnPlane => plane || v.abs() < WALL[0] && (0.0..WALL[1]).contains(&height) && crosses(1),
        }
    }

    fn small(&self) -> Point {
        add_scaled(CENTER, self.axes[0], SMALL)
    }

    /// Where a ray meets the surface that is judged, and its normal: the plane from above, or the ball alone.
    fn seen(&self, ray: &Query) -> Option<(Point, Point)> {
        if self.shape == Shape::Ball {
            let t = meets_ball(ray.origin, ray.dir, CENTER, RADIUS)?;
            let point = add_scaled(ray.origin, ray.dir, t);
            return Some((point, sub(point, CENTER).map(|x| x / RADIUS)));
        }
        let up = self.axes[0];
        let t = -self.local(ray.origin)[0] / dot(ray.dir, up);
        let point = add_scaled(ray.origin, ray.dir, t);
        // Away from the edges, where normals lean.
        let inner = self.local(point)[1..].iter().all(|x| x.abs() < HALF - 4.0);
        (t > 0.0 && inner && !self.is_hidden(ray.origin, ray.dir, t)).then_some((point, up))
    }

    /// Whether what stands on the plane is in the way before `most`.
    fn is_hidden(&self, origin: Point, dir: Point, most: f64) -> bool {
        let before = |t: f64| t > 1e-9 && t < most;
        match self.shape {
            Shape::BallOnPlane => meets_ball(origin, dir, self.small(), SMALL).is_some_and(before),
            Shape::WallOnPlane => {
                let ([h, u, v], along) = (self.local(origin), self.axes.map(|axis| dot(dir, axis)));
                let t = -u / along[1];
                before(t) && (v + t * along[2]).abs() < WALL[0] && (0.0..WALL[1]).contains(&(h + t * along[0]))
            }
            _ => false,
        }
    }
}

fn meets_ball(origin: Point, dir: Point, center: Point, radius: f64) -> Option<f64> {
    let d = sub(origin, center);
    let (a, b, c) = (dot(dir, dir), dot(d, dir), dot(d, d) - radius * radius);
    let root = b * b - a * c;
    (root >= 0.0).then(|| (-b - root.sqrt()) / a)
}

/// Pixels of one kind.
#[derive(Clone, Copy, Default)]
struct Count {
    lit: u32,
    wrongly_dark: u32,
    dark: u32,
    wrongly_lit: u32,
}

impl Count {
    fn dark_share(&self) -> f64 {
        100.0 * f64::from(self.wrongly_dark) / f64::from(self.lit.max(1))
    }

    fn lit_share(&self) -> f64 {
        100.0 * f64::from(self.wrongly_lit) / f64::from(self.dark.max(1))
    }
}

/// Adds up the pixels of a scene by height of the sun and lift.
fn judge(scene: &Scene, rng: &mut Rng, normals: NormalKind, counts: &mut [[Count; LIFTS.len()]; SUNS.len()]) {
    let places = (0..SIDE).flat_map(|z| (0..SIDE).flat_map(move |y| (0..SIDE).map(move |x| [x, y, z])));
    let words = VoxelSet::new(places.filter(|&voxel| scene.fills(voxel))).words(7);
    let dag = Dag::new(&words).unwrap();
    let [up, across, along] = scene.axes;
    // From above, at a slant.
    let slant = add_scaled(add_scaled(up, across, rng.uniform(-0.8, 0.8)), along, rng.uniform(-0.8, 0.8));
    let eye = add_scaled(CENTER, normalize(slant).unwrap(), 170.0);
    let camera = Camera { eye, target: CENTER, up: across, fov_y: 28.0 };
    let mut rays = vec![Query::new([0.0; 3], [1.0; 3]); (SIZE[0] * SIZE[1]) as usize];
    each_pixel(&camera, &GRID, SIZE, 0..SIZE[1], &mut rays, |pixel| pixel.query([0.5; 2])).unwrap();

    let turn = rng.uniform(0.0, std::f64::consts::TAU);
    let around = add_scaled(across.map(|x| x * libm::cos(turn)), along, libm::sin(turn));
    for (degrees, counts) in SUNS.iter().zip(counts) {
        let height = degrees.to_radians();
        let sun = add_scaled(around.map(|x| x * libm::cos(height)), up, libm::sin(height));
        let draw = |shadow: bool, lift: f32| {
            let lights = [Light { kind: LightKind::Directional(sun), color: [1.0; 3], shadow }];
            let palette = [Material { ambient: [0.0; 3], diffuse: [1.0; 3], ..Material::GREY }];
            let settings =
                Settings { width: SIZE[0], height: SIZE[1], ambient: [0.0; 3], normals, lift, ..Settings::default() };
            let (tracer, materials) = (Tracer::new(dag), Single(0));
            let view = View { tracer, materials, palette: &palette, grid: GRID, camera, lights: &lights };
            let mut out = vec![0; rays.len()];
            render_rows(&view, &settings, 0..SIZE[1], &mut out).unwrap();
            out
        };
        let open = draw(false, 0.0);
        for (lift, count) in LIFTS.iter().zip(counts) {
            let found = draw(true, *lift);
            for (i, ray) in rays.iter().enumerate() {
                // What faces the light, in truth and as drawn, and that no background.
                let Some((point, normal)) = scene.seen(ray) else { continue };
                let is_black = |pixel: u32| pixel & 0xFF_FFFF == 0;
                if dot(normal, sun) < 0.05 || is_black(open[i]) || dag.trace(ray).is_none() {
                    continue;
                }
                let is_dark = found[i] != open[i];
                if scene.is_hidden(point, sun, f64::INFINITY) {
                    count.dark += 1;
                    count.wrongly_lit += u32::from(!is_dark);
                } else {
                    count.lit += 1;
                    count.wrongly_dark += u32::from(is_dark);
                }
            }
        }
    }
}

#[test]
fn a_lift_takes_the_shadows_of_steps_away() {
    println!("| shape | sun | {} |", LIFTS.map(|lift| format!("{lift}")).join(" | "));
    for shape in [Shape::Plane, Shape::Ball, Shape::BallOnPlane, Shape::WallOnPlane] {
        let mut rng = Rng::new(SEED);
        let mut counts = [[Count::default(); LIFTS.len()]; SUNS.len()];
        for _ in 0..12 {
            judge(&Scene::new(shape, &mut rng), &mut rng, NormalKind::Plane2, &mut counts);
        }
        for (sun, counts) in SUNS.iter().zip(&counts) {
            let cells = counts.map(|count| format!("{:.2} / {:.2}", count.dark_share(), count.lit_share()));
            println!("| {shape:?} | {sun} | {} |", cells.join(" | "));
            assert!(counts[0].lit > 20_000, "seed {SEED}: {shape:?}");
            let [exact, _, usual, ..] = counts.map(|count| count.dark_share());
            // Nothing shades a plane or a ball but its own steps; where something does, its edges are a voxel or two off.
            let most = if matches!(shape, Shape::Plane | Shape::Ball) { 0.01 } else { 6.0 };
            assert!(usual < most && usual < exact, "seed {SEED}: {shape:?}, {sun}: {usual} of {exact} %");
            // A higher start loses the tips of shadows.
            let lost = counts.map(|count| count.wrongly_lit);
            assert!(lost.is_sorted(), "seed {SEED}: {shape:?}, {sun}: {lost:?}");
        }
    }
}
