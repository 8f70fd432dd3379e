//! From a scene to pixels, rows on all cores, and from pixels to a PNG.

use std::io::Write;
use std::ops::Range;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use serde::Serialize;
use voxdag::camera::Camera;
use voxdag::colors::{Colored, Painted};
use voxdag::effects::Effects;
use voxdag::file::Scene;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::layout::AnyGeometry;
use voxdag::lod::Lod;
use voxdag::material::MaterialId;
use voxdag::materials::AnyMaterials;
use voxdag::render::{Counters, Kernel, RenderError, Settings, View, render_rows, render_rows_by};
use voxdag::shade::Light;
use voxdag::trace::Query;
use voxdag::trees::Trees;
use voxdag::{Grid, Material, with_tracer};

use crate::detail::{Detail, Looks};
use crate::error::{Error, Kind, Result};
use crate::memory::Memory;
use crate::options::{CameraArgs, LightArg, LightingArgs, PictureArgs};
use crate::progress::Progress;
use crate::report::grouped;
use crate::stats;

/// A finished picture and what it took.
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Per pixel.
    pub samples: u32,
    /// Row by row from the top left; red in the lowest byte.
    pub pixels: Vec<u32>,
    pub rays: Rays,
    /// Primary rays that hit a voxel.
    pub hits: u64,
    /// Share of the pixels that took all samples, where these are more than one.
    pub supersampled: f64,
    /// What the scene called for and the flags allow.
    pub effects: Effects,
    /// Making what rays go through: the level of detail, trees.
    pub derive: Duration,
    /// Following rays and shading.
    pub trace: Duration,
    /// What of it was for effects, of all threads; 0 without a clock.
    pub cost: CostMs,
}

/// Time by effect, as far as it can be told apart, in ms of all threads.
#[derive(Clone, Copy, Default, Serialize)]
pub struct CostMs {
    /// Rays to lights, and finding out where they start; what comes through what is transparent.
    pub shadows: f64,
    /// Rays that mirrors and transparent surfaces send on, and the shading of what they meet without its shadows.
    pub secondary: f64,
}

/// What is drawn besides, and measured.
#[derive(Clone, Copy, Default)]
pub struct Extras {
    /// Red on the pixels that take all samples.
    pub mark_supersampled: bool,
    /// Whether effects are timed.
    pub timed: bool,
}

/// Draws everything and has a clock, in ns.
struct Timed;

impl Kernel for Timed {
    const EFFECTS: Effects = Effects::ALL;

    fn now() -> u64 {
        static START: LazyLock<Instant> = LazyLock::new(Instant::now);
        START.elapsed().as_nanos() as u64
    }
}

/// Rays by their purpose.
#[derive(Clone, Copy, Serialize)]
pub struct Rays {
    pub primary: u64,
    pub shadow: u64,
    pub secondary: u64,
}

/// What is drawn.
#[derive(Clone)]
pub struct Shown<'a> {
    pub grid: Grid,
    /// The mesh's box.
    pub bounds: Bounds,
    pub up: UpAxis,
    pub geometry: AnyGeometry<'a>,
    pub materials: AnyMaterials<'a>,
    /// The colours of textures.
    pub colors: Option<Colored<'a>>,
    pub palette: Vec<Material>,
    /// Where the geometry is derived from a finer one, whose voxels are those that have materials.
    pub lod: Option<Lod<AnyGeometry<'a>>>,
}

/// Draws rows.
type Rows<'a> = dyn Fn(Range<u32>, &mut [u32]) -> Result<Counters, RenderError> + Sync + 'a;

/// Rows that a thread draws at a time: few enough to share the work well and to show that it moves.
const BAND: usize = 4;

/// Rows of a band, and how many whole bands a picture has.
pub fn bands([_, height]: [u32; 2]) -> (u32, u32) {
    let band = height.min(BAND as u32);
    (band, height / band)
}

/// Draws on the threads of the current pool.
pub fn draw(scene: &Shown<'_>, args: &PictureArgs, extras: Extras, memory: &Memory) -> Result<Picture> {
    Prepared::new(scene, args.lod, memory)?.draw(scene, args, extras, memory)
}

/// What is derived from a scene to draw it at a level of detail; any number of pictures can be drawn with it.
pub struct Prepared {
    detail: Detail,
    trees: Trees,
    /// What deriving it took.
    time: Duration,
}

impl Prepared {
    /// Derives it.
    pub fn new(scene: &Shown<'_>, lod: u8, memory: &Memory) -> Result<Prepared> {
        let start = Instant::now();
        let detail = Detail::new(scene, lod, memory)?;
        let trees = Trees::new(detail.of(scene).geometry, memory.with(detail.bytes()).left());
        Ok(Prepared { detail, trees, time: start.elapsed() })
    }

    /// Derives the level of detail alone, for rays one by one.
    pub fn without_trees(scene: &Shown<'_>, lod: u8, memory: &Memory) -> Result<Prepared> {
        let start = Instant::now();
        let detail = Detail::new(scene, lod, memory)?;
        Ok(Prepared { detail, trees: Trees::default(), time: start.elapsed() })
    }

    /// What deriving it took.
    pub fn time(&self) -> Duration {
        self.time
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> u64 {
        self.detail.bytes() + self.trees.bytes()
    }

    /// The scene that it was derived from, at its level of detail, and what makes rays through it faster.
    pub fn parts<'s>(&'s self, scene: &Shown<'s>) -> (Shown<'s>, &'s Trees) {
        (self.detail.of(scene), &self.trees)
    }

    /// [`draw`]s the scene that it was derived from.
    pub fn draw(&self, scene: &Shown<'_>, args: &PictureArgs, extras: Extras, memory: &Memory) -> Result<Picture> {
        let [width, height] = args.size;
        // Once as pixels and once as bytes for the encoder.
        let mut pixels = room(args.size, 8, &memory.with(self.bytes()))?;
        let begin = Instant::now();
        let (counters, samples, effects, lights, start) =
            self.with_rows(scene, args, extras, |rows, settings, lights| {
                let start = Instant::now();
                let counters = in_bands("drawing", args.size, &mut pixels, rows)?;
                Ok((counters, settings.samples.count(), settings.effects, lights.to_vec(), start))
            })?;
        let trace = start.elapsed();
        let effects = effects.intersection(Effects::needed(&scene.palette, &lights));
        Ok(Picture {
            width,
            height,
            samples,
            pixels,
            rays: Rays::of(&counters),
            hits: counters.hits,
            supersampled: counters.supersampled as f64 / (f64::from(width) * f64::from(height)),
            effects,
            derive: self.time + (start - begin),
            trace,
            cost: CostMs {
                shadows: counters.shadow_time as f64 / 1e6,
                secondary: counters.secondary_time as f64 / 1e6,
            },
        })
    }

    /// Draws some [`bands`] of the picture: their pixels below each other, and what it took a thread to draw them.
    pub fn draw_bands(
        &self,
        scene: &Shown<'_>,
        args: &PictureArgs,
        numbers: &[u32],
        memory: &Memory,
    ) -> Result<(Vec<u32>, Duration)> {
        let (band, _) = bands(args.size);
        let mut pixels = room([args.size[0], band * numbers.len() as u32], 4, &memory.with(self.bytes()))?;
        let times = self.with_rows(scene, args, Extras::default(), |rows, _, _| {
            let bands = pixels.par_chunks_mut((band * args.size[0]) as usize).zip(numbers);
            let timed = bands.map(|(pixels, number)| {
                let (drawn, time) = stats::timed(|| rows(number * band..(number + 1) * band, pixels));
                drawn.map(|_| time)
            });
            timed.try_reduce(Duration::default, |a, b| Ok(a + b)).map_err(|error| Error::new(Kind::Failure, error))
        })?;
        Ok((pixels, times))
    }

    /// Gives `draw` what draws rows, and by which settings and lights it does.
    fn with_rows<T>(
        &self,
        scene: &Shown<'_>,
        args: &PictureArgs,
        Extras { mark_supersampled, timed }: Extras,
        draw: impl FnOnce(&Rows<'_>, &Settings, &[Light]) -> Result<T>,
    ) -> Result<T> {
        let scene = &self.detail.of(scene);
        let camera = camera(scene, &args.camera)?;
        let lights = lights(scene, &camera, &args.lighting);
        let settings = Settings { mark_supersampled, ..settings(scene, &camera, args)? };
        // Materials are matched at each hit, which costs nothing measurable.
        with_tracer!(scene.geometry, &self.trees, tracer => {
            let (palette, materials) = (&scene.palette[..], scene.looks());
            let view = View { tracer, materials, palette, grid: scene.grid, camera, lights: &lights };
            let rows = |rows, pixels: &mut [u32]| match timed {
                true => render_rows_by::<Timed, _, _>(&view, &settings, rows, pixels),
                false => render_rows(&view, &settings, rows, pixels),
            };
            draw(&rows, &settings, &lights)
        })
    }
}

/// Room for a number per pixel; each pixel will need `bytes` in all.
pub fn room<T: Copy + Default>([width, height]: [u32; 2], bytes: u64, memory: &Memory) -> Result<Vec<T>> {
    let needed = bytes * u64::from(width) * u64::from(height);
    memory.afford(needed, &format!("a picture of {width}x{height}"), "make --size smaller or --memory-limit larger")?;
    let (pixels, mut room) = (width as usize * height as usize, Vec::new());
    room.try_reserve_exact(pixels).map_err(|_| {
        Error::new(Kind::Failure, format_args!("no memory for a picture of {width}x{height}: {needed} bytes"))
            .hint("make --size smaller")
    })?;
    room.resize(pixels, T::default());
    Ok(room)
}

/// Lets `band` fill rows of `out` on the threads of the current pool, and adds up what it counts.
pub fn in_bands<T: Send>(
    stage: &'static str,
    [width, height]: [u32; 2],
    out: &mut [T],
    band: impl Fn(Range<u32>, &mut [T]) -> Result<Counters, RenderError> + Sync,
) -> Result<Counters> {
    let progress = Progress::stage(stage, u64::from(height.div_ceil(BAND as u32)));
    out.par_chunks_mut(BAND * width as usize)
        .enumerate()
        .map(|(i, out)| {
            let first = (i * BAND) as u32;
            let counters = band(first..(first + BAND as u32).min(height), out);
            progress.step();
            counters
        })
        .try_reduce(Counters::default, |mut sum, more| {
            sum += more;
            Ok(sum)
        })
        .map_err(|error| Error::new(Kind::Failure, error))
}

/// The camera that the flags describe; what they leave out frames the mesh's box.
pub fn camera(scene: &Shown<'_>, args: &CameraArgs) -> Result<Camera> {
    let framing = Camera::framing(&scene.bounds, scene.up);
    let target = args.target.unwrap_or(framing.target);
    // The default eye keeps its distance and direction from wherever the target is.
    let eye = std::array::from_fn(|i| target[i] + (framing.eye[i] - framing.target[i]));
    let camera = Camera {
        eye: args.eye.unwrap_or(eye),
        target,
        up: args.view_up.unwrap_or(framing.up),
        fov_y: args.fov.unwrap_or(framing.fov_y),
    };
    camera.checked().map_err(|error| Error::usage(error).hint("see --eye, --target and --fov"))
}

/// One ray through the centre of every pixel, row by row.
pub fn primary(scene: &Shown<'_>, camera: &CameraArgs, [width, height]: [u32; 2]) -> Result<Vec<Query>> {
    let camera = self::camera(scene, camera)?;
    let rays = camera.rays(width, height).map_err(Error::usage)?;
    let eye = scene.grid.to_grid(camera.eye);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    Ok(pixels.map(|p| p.map(|k| f64::from(k) + 0.5)).map(|[x, y]| Query::new(eye, rays.direction(x, y))).collect())
}

/// The lights that the flags describe, or the default one.
pub fn lights(scene: &Shown<'_>, camera: &Camera, args: &LightingArgs) -> Vec<Light> {
    let shadow = args.shadows;
    if args.is_without_lights() {
        return vec![Light { shadow, ..camera.headlight(scene.bounds.radius()) }];
    }
    let lights = args.lights.iter().chain(&args.suns);
    lights.map(|&LightArg { kind, color, shadow: own }| Light { kind, color, shadow: shadow || own }).collect()
}

fn settings(scene: &Shown<'_>, camera: &Camera, args: &PictureArgs) -> Result<Settings> {
    Ok(Settings {
        width: args.size[0],
        height: args.size[1],
        samples: args.samples()?,
        supersample: args.supersample(scene.geometry, camera),
        normals: args.normals.kind(scene.has_normals())?,
        arithmetic: args.arithmetic.kind(),
        ambient: args.lighting.ambient(),
        background: args.lighting.background(),
        effects: args.effects(),
        lift: args.lift.unwrap_or(Settings::default().lift),
        ..Settings::default()
    })
}

impl<'a> Shown<'a> {
    /// What a file holds.
    pub fn of(scene: &Scene<'a>) -> Shown<'a> {
        let Scene { grid, bounds, up, geometry, materials, colors, .. } = *scene;
        let palette = (0..scene.material_count()).map(|id| scene.material(id as MaterialId)).collect();
        Shown { grid, bounds, up, geometry, materials, colors, palette, lod: None }
    }

    /// The voxels' materials.
    pub fn looks(&self) -> Looks<'a> {
        Looks { fine: Painted { materials: self.materials, colors: self.colors }, lod: self.lod }
    }

    /// Whether voxels have normals of their own.
    pub fn has_normals(&self) -> bool {
        self.materials.has_normals()
    }
}

impl Rays {
    /// As a renderer counted them.
    pub fn of(counters: &Counters) -> Rays {
        Rays { primary: counters.primary, shadow: counters.shadow, secondary: counters.secondary }
    }

    /// All of them.
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.secondary
    }

    /// For people; kinds that did not occur are left out.
    pub fn text(&self) -> String {
        let kinds = [("primary", self.primary), ("shadow", self.shadow), ("secondary", self.secondary)];
        let parts: Vec<_> =
            kinds.iter().filter(|k| k.1 > 0).map(|(name, n)| format!("{} {name}", grouped(*n))).collect();
        parts.join(", ")
    }
}

impl Picture {
    /// Encodes the picture as PNG.
    pub fn write_png(&self, file: impl Write) -> std::io::Result<()> {
        png([self.width, self.height], self.pixels.iter(), file)
    }

    /// Encodes the middle of it, half as wide and high.
    pub fn write_middle_png(&self, file: impl Write) -> std::io::Result<()> {
        let [width, height] = [self.width.div_ceil(2), self.height.div_ceil(2)];
        let [x, y] = [(self.width - width) / 2, (self.height - height) / 2];
        let row = |y: u32| &self.pixels[(y * self.width + x) as usize..][..width as usize];
        png([width, height], (y..y + height).flat_map(row), file)
    }
}

/// Encodes pixels, row by row from the top, as PNG.
pub fn png<'a>(
    [width, height]: [u32; 2],
    pixels: impl Iterator<Item = &'a u32>,
    file: impl Write,
) -> std::io::Result<()> {
    let bytes: Vec<u8> = pixels.flat_map(|p| p.to_le_bytes()).collect();
    image::codecs::png::PngEncoder::new(file)
        .write_image(&bytes, width, height, ExtendedColorType::Rgba8)
        .map_err(std::io::Error::other)
}
