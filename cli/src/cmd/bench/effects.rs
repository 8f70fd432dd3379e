//! `voxdag bench effects`: what effects cost a picture, kernel by kernel and effect by effect, and what its shadow rays cost
//! alone.
//!
//! One ray per pixel. Kernels draw the scene as it is lit; then every light casts shadows, and each effect that is called for
//! is drawn and left out. Shadow rays are taken from the renderer, batch by batch, and traced again without it.

use std::cell::RefCell;
use std::ops::Range;

use serde::Serialize;
use voxdag::Material;
use voxdag::effects::Effects;
use voxdag::render::{
    Counters, Full, Kernel, Phong, RenderError, Samples, Settings, Shadows, View, render_rows, render_rows_by,
};
use voxdag::shade::Light;
use voxdag::trace::{Arithmetic, Query};
use voxdag::trees;
use voxdag::wide::Wide;

use super::{Cost, Run, rays};
use crate::detail::Looks;
use crate::error::{Error, Kind, Result};
use crate::measure::{Arm, Spread, Times, measure};
use crate::memory::Memory;
use crate::options::LightingArgs;
use crate::picture::{self, Rays, Shown};
use crate::report::{self, Lines, grouped, time};

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub run: Run,
    #[command(flatten)]
    pub lighting: LightingArgs,
}

/// What `bench effects --json` prints.
#[derive(Serialize)]
struct Report {
    resolution: u32,
    size: [u32; 2],
    repeat: u32,
    threads: u16,
    /// What the scene calls for.
    effects: Vec<&'static str>,
    /// The smallest kernel that draws them.
    kernel: &'static str,
    /// Of a picture by the kernel that is chosen for it.
    auto: Cost,
    /// By the kernel named above, called by its name.
    named_to_auto: f64,
    /// By the kernel for everything.
    full_to_auto: f64,
    /// By that, with a material that no voxel has and that calls for all effects of materials.
    all_to_auto: f64,
    /// As auto, measured twice: how far from 1 a ratio is by chance.
    noise: f64,
    /// Whether all of these pictures are the same.
    same_bytes: bool,
    /// Where all lights cast shadows.
    by_effect: Vec<ByEffect>,
    shadows: ShadowRays,
}

/// An effect, and the picture without it.
#[derive(Serialize)]
struct ByEffect {
    effect: &'static str,
    /// Time with all by time without it.
    with_to_without: f64,
    rays: Rays,
    rays_without: Rays,
}

/// Shadow rays within a picture without mirrored ones, and alone.
#[derive(Serialize)]
struct ShadowRays {
    /// To lights.
    rays: usize,
    /// To where those start.
    short_rays: usize,
    /// Time that shadows add to the picture.
    added_ms: f64,
    /// Time of the rays to lights alone.
    any_hit_ms: f64,
    /// Of the short ones.
    short_ms: f64,
    added_to_any_hit: f64,
    /// The short rays counted, too.
    added_to_all_any_hit: f64,
}

/// Rays of the band that is drawn, by whether they go to a light.
type Followed = Vec<(bool, Vec<Query>)>;

thread_local! {
    static FOLLOWED: RefCell<Followed> = const { RefCell::new(Vec::new()) };
}

/// Draws what needs no rays that go on, and keeps the rays that it follows.
struct Keeping;

impl Kernel for Keeping {
    const EFFECTS: Effects = Shadows::EFFECTS;

    fn follows(rays: &[Query], to_light: bool) {
        FOLLOWED.with_borrow_mut(|followed| followed.push((to_light, rays.to_vec())));
    }
}

/// Rows of a band.
const BAND: u32 = 4;
/// Most shadow rays that are kept.
const MOST_RAYS: u64 = 1 << 21;

type Scene<'a> = View<'a, Looks<'a>, Wide<'a>>;

/// Runs the command.
pub fn run(args: &Args, scene: &Shown<'_>, lighting: &LightingArgs) -> Result<()> {
    let run = &args.run;
    let tree =
        trees::wide(&scene.geometry, None).ok_or_else(|| Error::new(Kind::Limit, "no wide tree of the scene"))?;
    let top = trees::top_within(&tree.as_wide(), rays::TOP_BITS, None);
    let tracer = trees::tracer(tree.as_wide(), top.as_ref()).with_level(voxdag::simd::Level::best());

    let camera = picture::camera(scene, &run.camera)?;
    let lights = picture::lights(scene, &camera, lighting);
    let palette = &scene.palette[..];
    let view = View { tracer, materials: scene.looks(), palette, grid: scene.grid, camera, lights: &lights };
    let settings = Settings {
        width: run.size[0],
        height: run.size[1],
        samples: Samples::One,
        ambient: lighting.ambient(),
        background: lighting.background(),
        ..Settings::default()
    };
    let casting: Vec<_> = lights.iter().map(|light| Light { shadow: true, ..*light }).collect();
    compare(run, &view, &settings, &View { lights: &casting, ..view })
}

/// Measures pictures of the scene as it is lit, and where all lights cast shadows.
fn compare(run: &Run, view: &Scene<'_>, settings: &Settings, casting: &Scene<'_>) -> Result<()> {
    let needed = Effects::needed(view.palette, view.lights);
    let (kernel, named): (_, Draw<'_>) = if Phong::EFFECTS.contains(needed) {
        ("phong", render_rows_by::<Phong, _, _>)
    } else if Shadows::EFFECTS.contains(needed) {
        ("shadows", render_rows_by::<Shadows, _, _>)
    } else {
        ("full", render_rows_by::<Full, _, _>)
    };
    let unseen =
        Material { specular: [1.0; 3], emission: [1.0; 3], opacity: 0.5, refraction: 2.0, illum: 7, ..Material::GREY };
    let more: Vec<_> = view.palette.iter().copied().chain([unseen]).collect();
    let all = View { palette: &more, ..*view };
    let full: Draw<'_> = render_rows_by::<Full, _, _>;

    let called_for: Vec<_> = Effects::needed(casting.palette, casting.lights).iter().collect();
    let without = |i: usize| {
        let effects = called_for.get(i).map_or(Effects::NONE, |effect| Effects::ALL.difference(*effect));
        Settings { effects, ..*settings }
    };
    let off: [Settings; 6] = std::array::from_fn(without);
    let left_out = |i: usize| match called_for.get(i) {
        Some(_) => picture(casting, &off[i], render_rows, 1),
        None => Arm::pieces(0, |_| 0),
    };

    // Shadows apart from what else rays are for.
    let [lit, unlit] = [Shadows::EFFECTS, Shadows::EFFECTS.difference(Effects::SHADOWS)]
        .map(|effects| Settings { effects, ..*settings });
    let (every, followed) = keep(casting, &lit)?;
    let [to_lights, short]: [Vec<&[Query]>; 2] = [true, false]
        .map(|kind| followed.iter().filter(|(to_light, _)| *to_light == kind).map(|(_, rays)| &rays[..]).collect());

    let [
        auto,
        again,
        by_name,
        by_full,
        by_all,
        with_all,
        o0,
        o1,
        o2,
        o3,
        o4,
        o5,
        with_shadows,
        without_shadows,
        long,
        up,
    ] = measure(
        run.repeat,
        [
            picture(view, settings, render_rows, 1),
            picture(view, settings, render_rows, 1),
            picture(view, settings, named, 1),
            picture(view, settings, full, 1),
            picture(&all, settings, full, 1),
            picture(casting, settings, render_rows, 1),
            left_out(0),
            left_out(1),
            left_out(2),
            left_out(3),
            left_out(4),
            left_out(5),
            picture(casting, &lit, full, every),
            picture(casting, &unlit, full, every),
            any_hit(casting, &to_lights),
            any_hit(casting, &short),
        ],
    )?;

    let rays = |settings: &Settings| count(casting, settings).map(|counters| Rays::of(&counters));
    let all_rays = rays(settings)?;
    let mut by_effect = Vec::new();
    for ((effect, times), settings) in called_for.iter().zip([&o0, &o1, &o2, &o3, &o4, &o5]).zip(&off) {
        by_effect.push(ByEffect {
            effect: effect.names().next().unwrap_or_default(),
            with_to_without: with_all.ratio(times),
            rays: all_rays,
            rays_without: rays(settings)?,
        });
    }
    let report = Report {
        resolution: view.grid.resolution,
        size: run.size,
        repeat: run.repeat,
        threads: run.threads,
        effects: needed.names().collect(),
        kernel,
        named_to_auto: by_name.ratio(&auto),
        full_to_auto: by_full.ratio(&auto),
        all_to_auto: by_all.ratio(&auto),
        noise: again.ratio(&auto),
        same_bytes: [&again, &by_name, &by_full, &by_all].iter().all(|times| times.checksum == auto.checksum),
        auto: Cost::of(&auto, 1),
        by_effect,
        shadows: ShadowRays::of([&with_shadows, &without_shadows, &long, &up], [&to_lights, &short]),
    };
    report::result(run.report.json, &report, &lines(&report))
}

/// Draws rows.
type Draw<'a> = fn(&Scene<'a>, &Settings, Range<u32>, &mut [u32]) -> std::result::Result<Counters, RenderError>;

/// A picture, or of its bands of rows each so manieth; the checksum is of its pixels.
fn picture<'a>(view: &'a Scene<'a>, settings: &'a Settings, draw: Draw<'a>, every: u32) -> Arm<'a> {
    let bands = settings.height.div_ceil(BAND * every) as usize;
    Arm::pieces(bands, move |i| {
        let first = i as u32 * BAND * every;
        let rows = first..settings.height.min(first + BAND);
        let mut pixels = vec![0; (settings.width * rows.len() as u32) as usize];
        let drawn = draw(view, settings, rows, &mut pixels);
        assert!(drawn.is_ok(), "{drawn:?}");
        // Where a pixel stands counts, too.
        let at = i as u64 * u64::from(settings.width * BAND);
        (at..).zip(pixels).fold(0, |sum: u64, (at, pixel)| sum.wrapping_add((2 * at + 1).wrapping_mul(pixel.into())))
    })
}

/// What the whole picture takes.
fn count(view: &Scene<'_>, settings: &Settings) -> Result<Counters> {
    let mut pixels = picture::room([settings.width, settings.height], 4, &Memory::new(None))?;
    picture::in_bands("counting", [settings.width, settings.height], &mut pixels, |rows, out| {
        render_rows(view, settings, rows, out)
    })
}

/// The rays of each so manieth band, as many bands as there is room for.
fn keep(view: &Scene<'_>, settings: &Settings) -> Result<(u32, Followed)> {
    let all = count(view, settings)?.shadow;
    let every = all.div_ceil(MOST_RAYS).max(1) as u32;
    let mut pixels = vec![0; (settings.width * BAND) as usize];
    for first in (0..settings.height).step_by((BAND * every) as usize) {
        let rows = first..settings.height.min(first + BAND);
        let out = &mut pixels[..(settings.width * rows.len() as u32) as usize];
        render_rows_by::<Keeping, _, _>(view, settings, rows, out).map_err(|error| Error::new(Kind::Failure, error))?;
    }
    Ok((every, FOLLOWED.take()))
}

/// Whether the rays of batches meet something; the checksum is the number of those that do.
fn any_hit<'a>(view: &'a Scene<'a>, batches: &'a [&'a [Query]]) -> Arm<'a> {
    Arm::batches(batches, 64, move |rays| {
        let mut blocked = [false; 256];
        view.tracer.occluded_many(Arithmetic::Exact, rays, &mut blocked);
        blocked[..rays.len()].iter().map(|blocked| u64::from(*blocked)).sum()
    })
}

impl ShadowRays {
    fn of([with, without, long, short]: [&Times; 4], [to_lights, up]: [&[&[Query]]; 2]) -> ShadowRays {
        let median = |of: &dyn Fn(usize) -> f64| Spread::of((0..with.seconds.len()).map(of)).median;
        let added = |i: usize| with.seconds[i] - without.seconds[i];
        let count = |batches: &[&[Query]]| batches.iter().map(|rays| rays.len()).sum();
        ShadowRays {
            rays: count(to_lights),
            short_rays: count(up),
            added_ms: 1e3 * median(&added),
            any_hit_ms: 1e3 * median(&|i| long.seconds[i]),
            short_ms: 1e3 * median(&|i| short.seconds[i]),
            added_to_any_hit: median(&|i| added(i) / long.seconds[i]),
            added_to_all_any_hit: median(&|i| added(i) / (long.seconds[i] + short.seconds[i])),
        }
    }
}

/// The report for people.
fn lines(report: &Report) -> Lines {
    let mut lines = Lines::default();
    let effects = if report.effects.is_empty() { "none".to_owned() } else { report.effects.join(", ") };
    lines
        .row("resolution", format!("{} voxels along the longest axis", grouped(report.resolution.into())))
        .row("effects", effects)
        .row("auto", format!("{} of CPU", time(report.auto.ns / 1e6)))
        .row(format!("  by name, {}", report.kernel), format!("{:6.3} of the time", report.named_to_auto))
        .row("  full", format!("{:6.3} of the time", report.full_to_auto))
        .row("  all called for", format!("{:6.3} of the time", report.all_to_auto))
        .row("  noise", format!("{:6.3}: auto, measured twice", report.noise))
        .row("  same bytes", if report.same_bytes { "yes" } else { "NO" });
    for ByEffect { effect, with_to_without, rays, rays_without } in &report.by_effect {
        let rays = format!("{}; without {}", rays.text(), rays_without.text());
        lines.row(*effect, format!("{with_to_without:6.3} of the time without it: {rays}"));
    }
    let ShadowRays { rays, short_rays, added_ms, any_hit_ms, short_ms, .. } = report.shadows;
    let shadows = &report.shadows;
    lines
        .row("shadows add", time(added_ms))
        .row("  any hit", format!("{} for {} rays", time(any_hit_ms), grouped(rays as u64)))
        .row("  to their start", format!("{} for {} short rays", time(short_ms), grouped(short_rays as u64)))
        .row(
            "  added to any hit",
            format!("{:6.3}, short rays counted {:.3}", shadows.added_to_any_hit, shadows.added_to_all_any_hit),
        );
    lines
}
