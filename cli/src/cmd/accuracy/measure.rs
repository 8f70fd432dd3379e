//! Everything that is measured: builds, pictures, their errors, and wrong voxels.
//!
//! In: a subject and settings. Out: the numbers and the pictures. All settings draw once in every repetition, one after the
//! other, each time from another one on, so that a machine that slows down slows all of them. What makes rays faster is
//! made before and timed apart.

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;
use voxdag::camera::Camera;
use voxdag::effects::Effects;
use voxdag::render::Samples;
use voxdag::with_tracer;

use super::build::{self, Scene};
use super::cost;
use super::plan::{Setting, Voxels};
use super::wrong::{self, Wrong};
use crate::error::{Error, Kind, Result};
use crate::memory::Memory;
use crate::metrics::{self, Errors};
use crate::options::{ArithmeticArg, BuildArgs, CameraArgs, LightingArgs, NormalsArg, PictureArgs, SupersampleArg};
use crate::picture::{self, Extras, Picture, Prepared, Rays, Shown};
use crate::progress::Progress;
use crate::quality::Quality;
use crate::source::Source;
use crate::stats;
use crate::truth::{self, Lit, ShapeErrors, Truth};

/// What is measured on.
pub struct Subject<'a, T> {
    pub source: &'a Source,
    /// The mesh's file, if it has one.
    pub file: Option<&'a Path>,
    pub truth: &'a T,
    pub build: &'a BuildArgs,
    pub size: [u32; 2],
    pub camera: &'a CameraArgs,
    pub lighting: &'a LightingArgs,
    pub repeat: u32,
    /// Of what takes seconds.
    pub slow_repeat: u32,
}

/// What came of it.
pub struct Found {
    pub scenes: Vec<Scene>,
    pub camera: Camera,
    /// The truth's picture, and how long that took.
    pub truth: Vec<u32>,
    pub truth_time: Duration,
    /// One for each setting.
    pub rows: Vec<Row>,
    /// 64 samples of the same voxels: what is left of their error is that of the voxels and normals.
    pub references: Vec<Reference>,
    pub wrong: Vec<Wrong>,
}

/// A setting's numbers.
pub struct Row {
    /// The place of its scene.
    pub scene: usize,
    /// Seconds of each repetition, and of making what makes rays faster.
    pub seconds: Vec<f64>,
    pub prepare: f64,
    pub rays: Rays,
    pub pixels: Vec<u32>,
    /// The place of the picture with 64 samples.
    pub reference: usize,
    /// Against the truth.
    pub errors: Errors,
    /// RMSE against 64 samples of the same voxels.
    pub sampling: f64,
    pub shape: ShapeErrors,
}

/// A picture with 64 samples of some voxels.
pub struct Reference {
    pub pixels: Vec<u32>,
    pub errors: Errors,
}

/// What makes a picture with 64 samples.
#[derive(Clone, Copy, PartialEq)]
struct Key {
    voxels: Voxels,
    lod: u8,
    normals: NormalsArg,
}

impl Key {
    fn of(setting: &Setting) -> Key {
        let Quality { lod, normals, .. } = setting.quality;
        Key { voxels: setting.voxels, lod, normals }
    }
}

/// Each of a list once, in the order in which they come, and where each went.
fn unique<T: PartialEq + Copy>(list: impl Iterator<Item = T>) -> (Vec<T>, Vec<usize>) {
    let mut found = Vec::new();
    let places = list
        .map(|item| {
            found.iter().position(|other| *other == item).unwrap_or_else(|| {
                found.push(item);
                found.len() - 1
            })
        })
        .collect();
    (found, places)
}

/// Measures all settings, the default first, on the threads of the current pool.
pub fn run<T: Truth>(subject: &Subject<'_, T>, settings: &[Setting], memory: &mut Memory) -> Result<Found> {
    let Subject { source, truth, size, repeat, .. } = *subject;
    let (voxels, scene_of) = unique(settings.iter().map(|s| s.voxels));
    let (details, detail_of) = unique(settings.iter().map(|s| (s.voxels, s.quality.lod)));
    let (keys, reference_of) = unique(settings.iter().map(Key::of));
    let builds = subject.slow_repeat as usize;
    // All pictures stay, and FLIP needs room for one on each thread.
    let pictures =
        (settings.len() + keys.len() + 1) * size_of::<u32>() + rayon::current_num_threads() * metrics::FLIP_BYTES;
    let pictures = pictures as u64 * u64::from(size[0]) * u64::from(size[1]);
    memory.afford(pictures, "the pictures of all settings", "make --size smaller or --memory-limit larger")?;
    memory.hold(pictures);
    let progress = Progress::stage("measuring", work(settings, &voxels, keys.len(), builds, repeat));

    progress.say("builds".to_owned());
    let scenes = build::scenes(source, subject.file, subject.build, &voxels, builds, memory, &progress)?;
    let usual = scenes[0].shown();
    let camera = picture::camera(&usual, subject.camera)?;
    let lights = picture::lights(&usual, &camera, subject.lighting);

    progress.say("the truth".to_owned());
    let lit = Lit {
        palette: &usual.palette,
        camera,
        lights: &lights,
        ambient: subject.lighting.ambient(),
        background: subject.lighting.background(),
    };
    let (pixels, truth_time) = stats::timed(|| truth::draw(truth, &lit, size, Samples::SixtyFour, memory));
    let pixels = pixels?;
    let looks = truth::look(truth, &camera, size, memory)?;
    memory.hold(size_of_val(&looks[..]) as u64);
    if looks.iter().all(Option::is_none) {
        return Err(Error::usage("no ray of the picture hits the mesh: there is nothing to measure")
            .hint("see --eye, --target and --fov"));
    }
    progress.steps(cost::TRUTH);

    // Derive what draws, of each scene and level of detail.
    let place = |voxels| scenes.iter().position(|scene| scene.voxels == voxels).unwrap_or(0);
    let prepared: Result<Vec<_>> = details
        .iter()
        .map(|&(voxels, lod)| {
            let shown = scenes[place(voxels)].shown();
            let prepared = Prepared::new(&shown, lod, memory)?;
            memory.hold(prepared.bytes());
            Ok((shown, prepared))
        })
        .collect();
    let prepared = prepared?;
    let args = |quality: Quality| {
        quality.apply(&PictureArgs {
            size,
            camera: subject.camera.clone(),
            lighting: subject.lighting.clone(),
            normals: NormalsArg::default(),
            samples: None,
            supersample: None,
            arithmetic: ArithmeticArg::default(),
            // What the mesh's own picture has.
            effects: Some(Effects::PHONG.union(Effects::SHADOWS)),
            lift: None,
            lod: 0,
        })
    };
    let draw = |(shown, prepared): &(Shown<'_>, Prepared), quality| {
        prepared.draw(shown, &args(quality), Extras::default(), memory)
    };

    progress.say("pictures".to_owned());
    let mut drawn: Vec<(Vec<f64>, Picture)> = Vec::new();
    for repetition in 0..repeat as usize {
        for i in 0..settings.len() {
            let i = (i + repetition) % settings.len();
            let picture = draw(&prepared[detail_of[i]], settings[i].quality)?;
            let seconds = picture.trace.as_secs_f64();
            match drawn.get_mut(i) {
                // The first repetition goes from the first setting to the last.
                None => drawn.push((vec![seconds], picture)),
                Some((times, before)) if before.pixels == picture.pixels => times.push(seconds),
                Some(_) => {
                    return Err(Error::new(Kind::Failure, "the same picture came out twice in different pixels")
                        .hint("this is a defect of voxdag"));
                }
            }
            progress.steps(cost::draw(&settings[i].quality));
        }
    }

    progress.say("64 samples".to_owned());
    let true_view = metrics::View { width: size[0], height: size[1], pixels: &pixels };
    let errors = |pixels: &[u32]| metrics::errors(true_view, metrics::View { pixels, ..true_view });
    let references: Result<Vec<_>> = keys
        .iter()
        .map(|&Key { voxels, lod, normals }| {
            let supersample = SupersampleArg::All;
            let quality = Quality { samples: Samples::SixtyFour, supersample, normals, lod, ..Quality::default() };
            let of = details.iter().position(|&detail| detail == (voxels, lod)).unwrap_or(0);
            let pixels = draw(&prepared[of], quality)?.pixels;
            progress.steps(cost::REFERENCE);
            Ok(pixels)
        })
        .collect();
    let references: Vec<_> = references?
        .into_par_iter()
        .map(|pixels| {
            let errors = errors(&pixels);
            Reference { pixels, errors }
        })
        .collect();

    progress.say("errors".to_owned());
    let mut rows = Vec::new();
    for (i, (seconds, picture)) in drawn.into_iter().enumerate() {
        let (shown, prepared) = &prepared[detail_of[i]];
        let Quality { normals, arithmetic, .. } = settings[i].quality;
        let (detail, trees) = prepared.parts(shown);
        let how = (normals.kind(shown.has_normals())?, arithmetic.kind());
        let Picture { pixels, rays, derive, .. } = picture;
        rows.push(Row {
            scene: scene_of[i],
            seconds,
            prepare: derive.as_secs_f64(),
            rays,
            reference: reference_of[i],
            errors: errors(&pixels),
            sampling: metrics::rmse(
                metrics::View { pixels: &references[reference_of[i]].pixels, ..true_view },
                metrics::View { pixels: &pixels, ..true_view },
            ),
            shape: truth::shape_errors(&looks, (&detail, trees), &camera, size, how, memory)?,
            pixels,
        });
        progress.steps(cost::ERRORS);
    }

    progress.say("wrong voxels".to_owned());
    let mut wrong =
        wrong::voxelizing(&source.model.mesh(), &scenes[0].built.grid, subject.slow_repeat, memory)?.to_vec();
    let (shown, usual) = &prepared[detail_of[0]];
    let (shown, trees) = usual.parts(shown);
    wrong.extend(with_tracer!(shown.geometry, trees, tracer => {
        wrong::tracing(&tracer, &shown.grid, &camera, size, repeat, memory)?
    }));
    drop(progress);
    drop(prepared);
    Ok(Found { scenes, camera, truth: pixels, truth_time, rows, references, wrong })
}

/// How much there is to do, as [`cost`] counts it.
fn work(settings: &[Setting], voxels: &[Voxels], references: usize, builds: usize, repeat: u32) -> u64 {
    let build = voxels.iter().map(|v| builds as u64 * cost::build(v.resolution)).sum::<u64>();
    let draw = settings.iter().map(|s| u64::from(repeat) * cost::draw(&s.quality) + cost::ERRORS).sum::<u64>();
    build + draw + cost::TRUTH + references as u64 * cost::REFERENCE + cost::WRONG
}
