//! Pictures of what a renderer sees instead of what it draws: one ray through the middle of each pixel, one number or
//! colour of each ray. Colours are those of the file, no light; black is a ray that met nothing.

use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use serde::Serialize;
use voxdag::effects::Effects;
use voxdag::geometry::Geometry;
use voxdag::layout::AnyGeometry;
use voxdag::material::MaterialId;
use voxdag::materials::Materials;
use voxdag::math;
use voxdag::normal;
use voxdag::render::{Counters, each_pixel};
use voxdag::trace::{Face, Hit, Query, Tracer};

use crate::error::{Error, Result};
use crate::memory::Memory;
use crate::options::PictureArgs;
use crate::picture::{self, CostMs, Picture, Rays, Shown};
use crate::scene;

/// What a picture shows.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Show {
    /// The scene in its light
    #[default]
    Shaded,
    /// The surface's direction: red, green, blue are half of x, y, z plus a half
    Normals,
    /// Distance from the eye: white is the nearest, dark grey the farthest
    Depth,
    /// The empty octree cube before the hit: the brighter, the larger
    Level,
    /// Rounds of the walk of each ray, hit or not: dark is 0, then red, yellow, white
    Iterations,
    /// A colour per material
    Material,
    /// The scene in its light, with red on the pixels that --supersample chooses
    Samples,
}

/// The numbers behind a picture's colours.
#[derive(Clone, Copy, Serialize)]
pub struct Spread {
    pub min: f64,
    pub mean: f64,
    pub max: f64,
}

/// Draws what is not shaded, whatever `args.lod`, on the threads of the current pool; the numbers, where there are some.
pub fn draw(shown: &Shown<'_>, args: &PictureArgs, show: Show, memory: &Memory) -> Result<(Picture, Option<Spread>)> {
    for (given, flag) in [(args.samples.is_some(), "--samples"), (args.supersample.is_some(), "--supersample")] {
        if given {
            return Err(Error::usage(format_args!("{flag}: a picture that is not shaded has one ray per pixel"))
                .hint(format!("leave {flag} or --show away")));
        }
    }
    let start = Instant::now();
    let (geometry, normals) = (shown.geometry, args.normals.kind(shown.has_normals())?);
    // Pixels, the encoder's bytes, and the numbers.
    let mut pixels = picture::room(args.size, 12, memory)?;
    let mut values = Vec::new();
    let counters = match show {
        Show::Normals => look(shown, args, &mut pixels, |tracer, query, hit, _| match hit {
            Some(hit) => {
                rgba(normal::normal(tracer, shown.looks(), hit, query.dir, normals).direction.map(|n| n * 0.5 + 0.5))
            }
            None => BLACK,
        })?,
        Show::Material => look(shown, args, &mut pixels, |_, _, hit, _| {
            hit.map_or(BLACK, |hit| material_colour(shown.looks().id(hit.voxel)))
        })?,
        _ => {
            values = picture::room(args.size, 12, memory)?;
            look(shown, args, &mut values, |_, query, hit, rounds| match show {
                Show::Level => hit.map_or(f32::INFINITY, |hit| level(shown, hit).into()),
                Show::Iterations => rounds as f32,
                _ => distance(shown, query, hit),
            })?
        }
    };

    // Numbers become colours when all of them are known.
    let spread = Spread::of(&values);
    if let Some(spread) = spread {
        let colour: &dyn Fn(f32) -> [f32; 3] = match show {
            Show::Level => &|level| heat(part(level, 0.0..=f32::from(geometry.depth()))),
            Show::Iterations => &|rounds| heat(part(rounds, 0.0..=spread.max as f32)),
            _ => &|depth| [1.0 - 0.85 * part(depth, spread.min as f32..=spread.max as f32); 3],
        };
        for (pixel, &value) in pixels.iter_mut().zip(&values) {
            *pixel = if value.is_finite() { rgba(colour(value)) } else { BLACK };
        }
    }
    let [width, height] = args.size;
    let rays = Rays { primary: counters.primary, shadow: 0, secondary: 0 };
    let (hits, trace) = (counters.hits, start.elapsed());
    let picture = Picture {
        width,
        height,
        samples: 1,
        pixels,
        rays,
        hits,
        supersampled: 0.0,
        effects: Effects::NONE,
        cost: CostMs::default(),
        derive: Duration::ZERO,
        trace,
    };
    Ok((picture, spread))
}

/// Distances from the eye to what each pixel's middle shows, in world units, top row first; infinite where there is
/// nothing.
pub fn depths(shown: &Shown<'_>, args: &PictureArgs, memory: &Memory) -> Result<Vec<f32>> {
    // The picture is there as well.
    let mut depths = picture::room(args.size, 12, memory)?;
    look(shown, args, &mut depths, |_, query, hit, _| distance(shown, query, hit))?;
    Ok(depths)
}

/// Fills `out` with what `see` makes of each pixel's ray, its hit and the rounds of its walk.
fn look<T: Send>(
    shown: &Shown<'_>,
    args: &PictureArgs,
    out: &mut [T],
    see: impl Fn(&Tracer<'_, AnyGeometry<'_>>, &Query, Option<&Hit>, u32) -> T + Sync,
) -> Result<Counters> {
    let camera = picture::camera(shown, &args.camera)?;
    let arithmetic = args.arithmetic.kind();
    let top = scene::top_grid(shown.geometry)?;
    let tracer = scene::tracer(shown.geometry, &top);
    picture::in_bands("drawing", args.size, out, |rows, out| {
        let mut counters = Counters::default();
        each_pixel(&camera, &shown.grid, args.size, rows, out, |pixel| {
            let query = pixel.query([0.5; 2]);
            let (hit, steps) = tracer.trace_counted(arithmetic, &query);
            counters.primary += 1;
            counters.hits += u64::from(hit.is_some());
            see(&tracer, &query, hit.as_ref(), steps.rounds)
        })?;
        Ok(counters)
    })
}

/// Along the ray, in world units.
fn distance(shown: &Shown<'_>, query: &Query, hit: Option<&Hit>) -> f32 {
    let unit = math::sqrt(math::dot(query.dir, query.dir)) * shown.grid.voxel_size;
    hit.map_or(f32::INFINITY, |hit| (hit.t * unit) as f32)
}

/// Level of the largest empty octree cube around the voxel before the hit; the root's where the ray comes from outside,
/// and 0 for an eye inside a voxel.
fn level(shown: &Shown<'_>, hit: &Hit) -> u8 {
    match hit.from {
        Some(voxel) => shown.geometry.empty_level(voxel).unwrap_or(0),
        None if hit.face == Face::Inside => 0,
        None => shown.geometry.depth(),
    }
}

impl Spread {
    /// Of the finite ones among some values; `None` if there are none.
    fn of(values: &[f32]) -> Option<Spread> {
        let (mut spread, mut count) = (Spread { min: f64::INFINITY, mean: 0.0, max: f64::NEG_INFINITY }, 0u64);
        for value in values.iter().filter(|value| value.is_finite()).map(|&value| f64::from(value)) {
            spread.min = spread.min.min(value);
            spread.max = spread.max.max(value);
            spread.mean += value;
            count += 1;
        }
        spread.mean /= count as f64;
        (count > 0).then_some(spread)
    }
}

const BLACK: u32 = 0xff00_0000;

fn rgba(colour: [f32; 3]) -> u32 {
    let [red, green, blue] = colour.map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
    u32::from_le_bytes([red, green, blue, 255])
}

/// Where a value lies in a range, 0 to 1.
fn part(value: f32, range: RangeInclusive<f32>) -> f32 {
    let (from, to) = range.into_inner();
    if to > from { (value - from) / (to - from) } else { 0.0 }
}

/// Dark red, red, yellow, white.
fn heat(part: f32) -> [f32; 3] {
    let x = 0.3 + 2.7 * part;
    [x, x - 1.0, x - 2.0].map(|channel| channel.clamp(0.0, 1.0))
}

/// The colour map of the PASCAL VOC segmentation data: the bits of the number, lowest first, go to the highest bits of
/// red, green and blue in turn. So no two materials look the same. Its entry 0 is black, so materials start at 1.
fn material_colour(id: MaterialId) -> u32 {
    let number = u32::from(id) + 1;
    let mut colour = [0u8; 3];
    for bit in 0..17 {
        colour[bit % 3] |= (number >> bit & 1) as u8 * (0x80 >> (bit / 3));
    }
    u32::from_le_bytes([colour[0], colour[1], colour[2], 255])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_material_has_a_colour_of_its_own() {
        let colours: std::collections::BTreeSet<_> = (0..=MaterialId::MAX).map(material_colour).collect();
        assert_eq!(colours.len(), 1 << 16);
        assert!(!colours.contains(&BLACK));
        assert_eq!(material_colour(0).to_le_bytes(), [128, 0, 0, 255]);
        assert_eq!(material_colour(2).to_le_bytes(), [128, 128, 0, 255]);
    }

    #[test]
    fn heat_grows_brighter() {
        let brightness = |x: f32| heat(x).iter().sum::<f32>();
        assert!((1..=100).all(|i| brightness(i as f32 / 100.0) > brightness((i - 1) as f32 / 100.0)));
        assert_eq!(rgba(heat(1.0)), 0xffff_ffff);
    }
}
