//! Pictures of the surfaces themselves, by the camera, the light, the places of samples, the means and the rounding of
//! [`voxdag::render`]: what differs from a picture of voxels is the surface, not how it is drawn.
//!
//! Shadow rays start above the surface by 2^-26 of the whole's extent: far below a voxel, far above f64's rounding.
//! Light from behind a triangle does not reach it, also where its interpolated normal says otherwise.

use std::ops::Range;

use voxdag::Material;
use voxdag::camera::{Camera, Rays};
use voxdag::color::{Mean, quantize};
use voxdag::math;
use voxdag::render::{Counters, Samples};
use voxdag::shade::{Light, LightKind, Surface, glow, reflect};

use super::{Met, Truth};
use crate::error::{Error, Result};
use crate::memory::Memory;
use crate::picture::{in_bands, room};

/// How far above their surface shadow rays start, as a part of the extent of all surfaces.
const LIFT: f64 = 1.0 / (1 << 26) as f64;

/// What surfaces are seen with.
#[derive(Clone, Copy)]
pub struct Lit<'a> {
    /// The materials by id; an id beyond them is drawn in [`Material::GREY`].
    pub palette: &'a [Material],
    pub camera: Camera,
    pub lights: &'a [Light],
    /// Linear colour of the light that comes from everywhere.
    pub ambient: [f32; 3],
    /// Linear colour where there is nothing.
    pub background: [f32; 3],
}

/// A picture of `[width, height]` pixels on the threads of the current pool: row by row from the top left, red in the
/// lowest byte.
pub fn draw(
    truth: &(impl Truth + ?Sized),
    lit: &Lit<'_>,
    size: [u32; 2],
    samples: Samples,
    memory: &Memory,
) -> Result<Vec<u32>> {
    let background = lit.background.map(quantize);
    let mut pixels = room(size, 4, memory)?;
    each(&lit.camera, size, &mut pixels, |rays, [x, y]| {
        let mut mean = Mean::default();
        for place in (0..samples.count()).map(|i| samples.position(i)) {
            let dir = rays.direction(x + place[0], y + place[1]);
            let met = truth.nearest(lit.camera.eye, dir);
            mean.add(met.map_or(background, |met| lit.color(truth, &met, dir).map(quantize)));
        }
        let [red, green, blue] = mean.srgb8();
        u32::from_le_bytes([red, green, blue, 255])
    })?;
    Ok(pixels)
}

/// What one ray through each pixel's centre meets, row by row from the top left. Times are in units of the camera's
/// directions, which are not of unit length: see [`Rays::direction`].
pub fn look(
    truth: &(impl Truth + ?Sized),
    camera: &Camera,
    size: [u32; 2],
    memory: &Memory,
) -> Result<Vec<Option<Met>>> {
    let mut out = room(size, size_of::<Option<Met>>() as u64, memory)?;
    each(camera, size, &mut out, |rays, [x, y]| truth.nearest(camera.eye, rays.direction(x + 0.5, y + 0.5)))?;
    Ok(out)
}

/// Fills `out` with what `see` makes of the rays and each pixel's upper left corner.
fn each<T: Send>(
    camera: &Camera,
    size: [u32; 2],
    out: &mut [T],
    see: impl Fn(&Rays, [f64; 2]) -> T + Sync,
) -> Result<()> {
    let rays = camera.rays(size[0], size[1]).map_err(Error::usage)?;
    in_bands("truth", size, out, |rows: Range<u32>, out| {
        for (y, row) in rows.zip(out.chunks_exact_mut(size[0] as usize)) {
            for (x, pixel) in (0..).zip(row) {
                *pixel = see(&rays, [x, y].map(f64::from));
            }
        }
        Ok(Counters::default())
    })?;
    Ok(())
}

impl Lit<'_> {
    /// The light that a surface sends back along the ray that met it.
    fn color(&self, truth: &(impl Truth + ?Sized), met: &Met, dir: [f64; 3]) -> [f32; 3] {
        let material = self.palette.get(usize::from(met.material)).unwrap_or(&Material::GREY);
        let back = math::normalize(dir.map(|x| -x)).unwrap_or([0.0; 3]);
        let surface = Surface {
            point: math::add_scaled(self.camera.eye, dir, met.t),
            normal: met.normal.map(|x| x as f32),
            view: back.map(|x| x as f32),
        };
        self.lights.iter().fold(glow(material, self.ambient), |color, light| match light.falls_on(&surface) {
            Some(incidence) if !(light.shadow && shaded(truth, met, surface.point, light)) => {
                reflect(color, material, &surface, light, incidence)
            }
            _ => color,
        })
    }
}

/// Whether something stands between a point of a surface and a light.
fn shaded(truth: &(impl Truth + ?Sized), met: &Met, point: [f64; 3], light: &Light) -> bool {
    let start = math::add_scaled(point, met.side, LIFT * truth.extent());
    let (way, t_max) = match light.kind {
        LightKind::Point(position) => (math::sub(position, start), 1.0),
        LightKind::Directional(direction) => (direction, f64::INFINITY),
    };
    math::dot(way, met.side) <= 0.0 || truth.occluded(start, way, t_max)
}

#[cfg(test)]
mod tests {
    use super::super::shapes::Closed;
    use super::super::{Known, MeshTruth};
    use super::*;
    use crate::options::{BuildArgs, PictureArgs};
    use crate::scene;
    use clap::Parser;
    use voxdag::color::linear_to_srgb8;
    use voxdag::render::Settings;
    use voxdag_oracle::scenes;

    const SIZE: [u32; 2] = [33, 21];

    /// A camera on the z axis that looks down on it.
    fn above(height: f64) -> Camera {
        Camera { eye: [0.0, 0.0, height], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 45.0 }
    }

    fn lamp(position: [f64; 3], shadow: bool) -> Light {
        Light { kind: LightKind::Point(position), color: [1.0; 3], shadow }
    }

    #[test]
    fn a_plane_is_as_far_and_as_bright_as_the_formula_says() {
        let memory = Memory::new(None);
        let plane = Closed::Sheet { center: [0.0; 3], edges: [[1e3, 0.0, 0.0], [0.0, 1e3, 0.0]] };
        let material = Material { specular: [0.1; 3], diffuse: [0.25; 3], shininess: 20, illum: 2, ..Material::GREY };
        let (camera, lights) = (above(2.0), [lamp([0.0, 0.0, 2.0], true)]);
        let lit = Lit { palette: &[material], camera, lights: &lights, ambient: [0.2; 3], background: [1.0; 3] };
        let pixels = draw(&plane, &lit, SIZE, Samples::One, &memory).unwrap();
        let met = look(&plane, &camera, SIZE, &memory).unwrap();

        // Directions are 1 long along the view. In the middle 0.2 * 0.5 + 0.25 + 0.1 = 0.45, which is sRGB 178.86.
        assert_eq!(pixels[pixels.len() / 2], u32::from_le_bytes([179, 179, 179, 255]));
        let rays = camera.rays(SIZE[0], SIZE[1]).unwrap();
        for (i, (pixel, met)) in pixels.iter().zip(met).enumerate() {
            let met = met.unwrap();
            assert!((met.t - 2.0).abs() < 1e-12 && met.normal == [0.0, 0.0, 1.0], "{met:?}");
            // Viewer and lamp are at one place, so the mirrored light is twice as far from it as the normal.
            let [x, y, _] = rays.direction(f64::from(i as u32 % SIZE[0]) + 0.5, f64::from(i as u32 / SIZE[0]) + 0.5);
            let cosine = 1.0 / math::sqrt(1.0 + x * x + y * y);
            let mirrored = 2.0 * cosine * cosine - 1.0;
            let highlight = (0..20).fold(0.1, |product, _| product * mirrored);
            let linear = 0.1 + 0.25 * cosine + highlight;
            let byte = f64::from(linear_to_srgb8((linear * 65_535.0) as u32));
            assert!((f64::from(pixel & 0xff) - byte).abs() <= 1.0, "pixel {i}");
        }
    }

    #[test]
    fn shadows_fall_where_something_is_in_the_way() {
        let memory = Memory::new(None);
        // A floor, and a small roof over its middle.
        let mut shape = scenes::tilted_plane(8.0, 0.0, 0.0).map(|[x, y, z]| [x - 4.0, y - 4.0, z]);
        shape.add(&scenes::tilted_plane(0.5, 0.0, 1.0).map(|[x, y, z]| [x - 0.25, y - 0.25, z]));
        let truth = MeshTruth::new(shape.mesh(), &memory).unwrap();
        let color = |aim: [f64; 3], light: Light| {
            let lit =
                Lit { palette: &[], camera: above(4.0), lights: &[light], ambient: [0.2; 3], background: [0.0; 3] };
            let dir = math::sub(aim, lit.camera.eye);
            lit.color(&truth, &truth.nearest(lit.camera.eye, dir).unwrap(), dir)[0]
        };
        let side = [3.0, 0.0, 2.0];
        let sun = Light { kind: LightKind::Directional([3.0, 0.0, 1.0]), ..lamp(side, true) };
        // The roof's shadow lies at -3 for both.
        for light in [lamp(side, true), sun] {
            assert_eq!(color([-3.0, 0.0, 0.0], light), 0.1);
            assert!(color([-3.0, 0.0, 0.0], Light { shadow: false, ..light }) > 0.11);
            for lit in [[3.0, 1.0, 0.0], [-3.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                assert_eq!(color(lit, light), color(lit, Light { shadow: false, ..light }));
                assert!(color(lit, light) > 0.11);
            }
        }
        // A lamp under the roof, and one below the floor.
        assert!(color([1.0, 0.0, 0.0], lamp([0.0, 0.0, 0.5], true)) > 0.11);
        assert_eq!(color([0.0, 0.0, 1.0], lamp([0.0, 0.0, 0.5], true)), 0.1);
        assert_eq!(color([1.0, 0.0, 0.0], lamp([0.0, 0.0, -0.5], true)), 0.1);
    }

    /// No surface shades itself where all of it sees the lamp; and threads are no matter.
    #[test]
    fn a_ball_is_not_shaded_by_itself() {
        let memory = Memory::new(None);
        let shape = scenes::sphere([0.0; 3], 1.0, 4);
        let mesh = MeshTruth::new(shape.mesh(), &memory).unwrap();
        let picture = |truth: &dyn Truth, shadow, threads| {
            let lights = [lamp([0.0, 0.0, 3.0], shadow)];
            let lit =
                Lit { palette: &[], camera: above(3.0), lights: &lights, ambient: [0.2; 3], background: [1.0; 3] };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| draw(truth, &lit, [50, 40], Samples::Four, &memory)).unwrap()
        };
        let closed = Known::Sphere.closed();
        let truths: [&dyn Truth; 2] = [&mesh, &closed];
        for truth in truths {
            assert_eq!(picture(truth, true, 1), picture(truth, false, 3));
        }
    }

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        picture: PictureArgs,
    }

    #[test]
    fn voxels_look_like_what_they_stand_for() {
        let mut memory = Memory::new(None);
        let source = Known::Torus.source();
        let built =
            scene::build(&source, &BuildArgs { resolution: Some(512), ..BuildArgs::default() }, &mut memory).unwrap();
        let (shown, args) = (built.shown(), Flags::parse_from(["", "--size", "96x54", "--samples", "16"]).picture);
        let drawn = crate::picture::draw(&shown, &args, crate::picture::Extras::default(), &memory).unwrap().pixels;

        let camera = crate::picture::camera(&shown, &args.camera).unwrap();
        let lights = [camera.headlight(shown.bounds.radius())];
        let background = Settings::default().background;
        let lit =
            Lit { palette: &shown.palette, camera, lights: &lights, ambient: args.lighting.ambient(), background };
        let truth = draw(&Known::Torus.closed(), &lit, args.size, Samples::Sixteen, &memory).unwrap();
        let squares: Vec<_> = truth
            .iter()
            .zip(&drawn)
            .flat_map(|(a, b)| {
                a.to_le_bytes()
                    .into_iter()
                    .zip(b.to_le_bytes())
                    .map(|(a, b)| (f64::from(a) - f64::from(b)) * (f64::from(a) - f64::from(b)))
            })
            .collect();
        let rmse = math::sqrt(squares.iter().sum::<f64>() / squares.len() as f64);
        assert!(rmse > 0.0 && rmse < 4.0, "{rmse} of 255");
        assert!(truth.iter().filter(|&&pixel| pixel != truth[0]).count() > truth.len() / 5);
    }
}
