//! Pictures of the surfaces themselves, by the camera, the light, the places of samples, the means and the rounding of
//! [`voxdag::render`]: what differs from a picture of voxels is the surface, not how it is drawn.
//!
//! Shadow rays start above the surface by 2^-26 of the whole's extent: far below a voxel, far above f64's rounding. Light
//! from behind a triangle does not reach it, also where its interpolated normal says otherwise.

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
pub fn draw(truth: &impl Truth, lit: &Lit<'_>, size: [u32; 2], samples: Samples, memory: &Memory) -> Result<Vec<u32>> {
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
pub fn look(truth: &impl Truth, camera: &Camera, size: [u32; 2], memory: &Memory) -> Result<Vec<Option<Met>>> {
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
    fn color(&self, truth: &impl Truth, met: &Met, dir: [f64; 3]) -> [f32; 3] {
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
fn shaded(truth: &impl Truth, met: &Met, point: [f64; 3], light: &Light) -> bool {
    let start = math::add_scaled(point, met.side, LIFT * truth.extent());
    let (way, t_max) = match light.kind {
        LightKind::Point(position) => (math::sub(position, start), 1.0),
        LightKind::Directional(direction) => (direction, f64::INFINITY),
    };
    math::dot(way, met.side) <= 0.0 || truth.occluded(start, way, t_max)
}
