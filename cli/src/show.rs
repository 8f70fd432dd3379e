//! Pictures of what a renderer sees instead of what it draws, on the threads of the current pool; see the core's
//! [`render::show_rows`].

use std::time::{Duration, Instant};

use clap::ValueEnum;
use serde::Serialize;
use voxdag::effects::Effects;
use voxdag::geometry::Geometry;
use voxdag::render::{self, Counters, Settings, View, show_rows};
use voxdag::trees;

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

impl Show {
    /// The core's name for what is not shaded.
    fn unshaded(self) -> Option<render::Show> {
        match self {
            Show::Shaded | Show::Samples => None,
            Show::Normals => Some(render::Show::Normals),
            Show::Depth => Some(render::Show::Depth),
            Show::Level => Some(render::Show::Level),
            Show::Iterations => Some(render::Show::Iterations),
            Show::Material => Some(render::Show::Material),
        }
    }
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
    let show = show.unshaded().unwrap_or(render::Show::Normals);
    // Words, and the encoder's bytes.
    let mut pixels = picture::room(args.size, 8, memory)?;
    let counters = look(shown, args, show, &mut pixels)?;

    // Numbers become colours when all of them are known.
    let spread = show.spread(&pixels);
    let range = spread.map_or([0.0; 2], |spread| [spread.min, spread.max].map(|x| x as f32));
    show.paint(range, shown.geometry.depth(), &mut pixels);
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
    Ok((picture, spread.map(|render::Spread { min, mean, max }| Spread { min, mean, max })))
}

/// Distances from the eye to what each pixel's middle shows, in world units, top row first; infinite where there is
/// nothing.
pub fn depths(shown: &Shown<'_>, args: &PictureArgs, memory: &Memory) -> Result<Vec<f32>> {
    // The picture is there as well, and so are the bits.
    let mut bits = picture::room(args.size, 16, memory)?;
    look(shown, args, render::Show::Depth, &mut bits)?;
    Ok(bits.into_iter().map(f32::from_bits).collect())
}

/// Fills `out` with the words of a view.
fn look(shown: &Shown<'_>, args: &PictureArgs, show: render::Show, out: &mut [u32]) -> Result<Counters> {
    let camera = picture::camera(shown, &args.camera)?;
    let [width, height] = args.size;
    let normals = args.normals.kind(shown.has_normals())?;
    let settings = Settings { width, height, normals, arithmetic: args.arithmetic.kind(), ..Settings::default() };
    let top = scene::top_grid(shown.geometry)?;
    let tracer = trees::tracer(shown.geometry, &top);
    let view =
        View { tracer, materials: shown.looks(), palette: &shown.palette, grid: shown.grid, camera, lights: &[] };
    picture::in_bands("drawing", args.size, out, |rows, out| show_rows(&view, &settings, show, rows, out))
}
