//! Rays that go on from surfaces that mirror or let light through: traced and shaded in batches like a camera's rays.
//!
//! In: a batch of shaded samples. Out: their colours with all that is seen in them and behind them. Each ray carries its
//! share of a sample's colour; a surface sends on at most two rays, [`DEPTH`] in a row, and none with less than [`LEAST`].
//! What is left off at these bounds is black.
//!
//! Rays wait on a stack, those with the most surfaces behind them on top, and are taken from there, as many as the room for
//! what they send on allows. Shares are added as whole numbers: a colour does not depend on the order.

use super::batch::{Batch, Met, SAMPLES};
use super::bend::{self, Behind};
use super::kernel::{self, Chosen, Kernel};
use super::{Counters, View};
use crate::color::{self, BRIGHTEST};
use crate::effects::{self, Effects};
use crate::geometry::Geometry;
use crate::material::MaterialId;
use crate::materials::Materials;
use crate::math;
use crate::morton::Morton;
use crate::normal;
use crate::trace::{Face, Query};

/// What sends rays on.
pub(super) const GOES_ON: Effects = Effects::MIRROR.union(Effects::TRANSPARENCY);

/// Most rays in a row behind a camera's.
pub(super) const DEPTH: u8 = 8;

/// The smallest share of a sample, in its strongest channel, that is followed: less than a step of an 8-bit colour.
const LEAST: f32 = 1.0 / 512.0;

/// Rays that are taken at once when room is scarce.
const NARROW: usize = 16;

/// Room that these and what they send on, down to the last, take at most. Rays are taken from the top, so while 16 are taken
/// at a time at most 32 wait that came from any one depth: those of the last time that it was the least deep.
const RESERVE: usize = 2 * NARROW * (DEPTH as usize - 1);

/// Rays that can wait: two for each sample, and the reserve.
const ROOM: usize = 768;
const _: () = assert!(2 * SAMPLES + RESERVE <= ROOM);

/// Follows rays that go on, in room that is lent: a batch, and the rays that wait for one.
pub(super) struct Follow<'a> {
    pub batch: &'a mut Batch,
    pub waiting: &'a mut Waiting,
}

/// Rays that wait, and the samples that they are for.
pub(super) struct Waiting {
    count: usize,
    rays: [Ray; ROOM],
    /// Of the rays that are in the batch.
    taken: [Path; SAMPLES],
    /// Linear, quantised.
    colors: [[u32; 3]; SAMPLES],
}

/// A ray that waits.
#[derive(Clone, Copy)]
struct Ray {
    origin: [f64; 3],
    dir: [f64; 3],
    start: Option<Morton>,
    path: Path,
}

/// How a ray came about.
#[derive(Clone, Copy)]
struct Path {
    /// Of its sample's colour, per channel.
    share: [f32; 3],
    /// Surfaces behind it.
    depth: u8,
    sample: u8,
    /// What it has entered and not left: materials that bend rays, one at a time.
    medium: Option<MaterialId>,
}

impl Path {
    const WHOLE: Path = Path { share: [1.0; 3], depth: 0, sample: 0, medium: None };
}

impl Ray {
    const NONE: Ray = Ray { origin: [0.0; 3], dir: [0.0; 3], start: None, path: Path::WHOLE };
}

impl Follow<'_> {
    /// The colours of shaded samples, quantised, in their order.
    pub fn colors<K: Kernel, M: Materials, G: Geometry>(
        &mut self,
        samples: &Batch,
        view: &View<'_, M, G>,
        settings: &Chosen<K>,
        counters: &mut Counters,
    ) -> &[[u32; 3]] {
        let Follow { batch, waiting } = self;
        let (start, before) = (K::now(), *counters);
        for (i, (_, color, _)) in samples.shaded().enumerate() {
            waiting.colors[i] = color.map(color::quantize);
            let path = Path { sample: i as u8, ..Path::WHOLE };
            waiting.send_on(view, settings, &samples.met(i, view.palette), path);
        }
        while waiting.count > 0 {
            let most = (ROOM - RESERVE).saturating_sub(waiting.count).clamp(NARROW, SAMPLES);
            let left = waiting.count.saturating_sub(most);
            for (i, ray) in waiting.rays[left..waiting.count].iter().enumerate() {
                waiting.taken[i] = ray.path;
                batch.push_ray(i as u8, Query { start: ray.start, ..Query::new(ray.origin, ray.dir) });
            }
            waiting.count = left;

            counters.secondary += batch.len() as u64;
            batch.trace_rays(&view.tracer, settings.arithmetic, |i, hit| {
                if hit.is_none() {
                    let path = waiting.taken[usize::from(i)];
                    waiting.add(&path, settings.background);
                }
                hit.is_some()
            });
            batch.shade(view, settings, counters);
            for (i, (ray, color, _)) in batch.shaded().enumerate() {
                let path = waiting.taken[usize::from(ray)];
                waiting.add(&path, color);
                waiting.send_on(view, settings, &batch.met(i, view.palette), path);
            }
            batch.clear();
        }
        let brightest = color::quantize(BRIGHTEST);
        let colors = &mut waiting.colors[..samples.len()];
        colors.as_flattened_mut().iter_mut().for_each(|channel| *channel = brightest.min(*channel));
        let shadow_time = counters.shadow_time - before.shadow_time;
        counters.secondary_time = before.secondary_time + kernel::since::<K>(start).saturating_sub(shadow_time);
        colors
    }
}

impl Waiting {
    /// Apart, so that the room in which it is put together is free again when rays are traced.
    #[inline(never)]
    pub fn new() -> Waiting {
        Waiting { count: 0, rays: [Ray::NONE; ROOM], taken: [Path::WHOLE; SAMPLES], colors: [[0; 3]; SAMPLES] }
    }

    /// Adds a path's share of a colour to its sample.
    fn add(&mut self, path: &Path, color: [f32; 3]) {
        let sum = &mut self.colors[usize::from(path.sample)];
        for i in 0..3 {
            sum[i] = sum[i].saturating_add(color::quantize(path.share[i] * color[i]));
        }
    }

    /// Adds a ray; without one its share is of the background.
    fn push<K>(&mut self, path: Path, ray: Option<Query>, settings: &Chosen<K>) {
        let Some(ray) = ray else { return self.add(&path, settings.background) };
        debug_assert!(self.count < ROOM, "more rays than were reckoned with");
        if let (Some(dir), Some(room)) = (math::normalize(ray.dir), self.rays.get_mut(self.count)) {
            *room = Ray { origin: ray.origin, dir, start: ray.start, path };
            self.count += 1;
        }
    }

    /// Sends on the rays that a surface calls for which `path` has come to.
    fn send_on<K: Kernel, M: Materials, G: Geometry>(
        &mut self,
        view: &View<'_, M, G>,
        settings: &Chosen<K>,
        met: &Met<'_>,
        path: Path,
    ) {
        let effects = effects_of(view, settings, met.id);
        if !effects.intersects(GOES_ON) || path.depth == DEPTH {
            return;
        }
        let Some(dir) = math::normalize(met.dir) else { return };
        let n = met.normal.direction.map(f64::from);
        let next = |share: [f32; 3]| {
            let share = [0, 1, 2].map(|i| path.share[i] * share[i]);
            let path = Path { share, depth: path.depth + 1, ..path };
            share.iter().any(|x| *x >= LEAST).then_some(path)
        };

        let sees_through = effects.contains(Effects::TRANSPARENCY);
        let mut mirrored = [0.0; 3];
        if effects.contains(Effects::MIRROR) && met.hit.face != Face::Inside {
            mirrored = effects::mirrored(met.material, -math::dot(dir, n) as f32, sees_through);
            if let Some(path) = next(mirrored) {
                self.push(path, bend::back(met, bend::reflected(dir, n), settings.lift), settings);
            }
        }
        if sees_through && let Some(path) = next(effects::passed(met.material, mirrored)) {
            let refracts = effects.contains(Effects::REFRACTION);
            let (ray, medium) = through(view, (met, settings.lift), (dir, n), refracts, path.medium);
            self.push(Path { medium, ..path }, ray, settings);
        }
    }
}

/// The effects that a material calls for and that may be drawn.
#[inline]
pub(super) fn effects_of<K: Kernel, M, G>(view: &View<'_, M, G>, settings: &Chosen<K>, id: MaterialId) -> Effects {
    Effects::of(super::batch::material(view.palette, id)).intersection(settings.effects())
}

/// The ray behind a transparent surface that one along `dir` met, in front of which it is in `medium`, and in what it is then.
///
/// Rays bend where a material is met: into it if it is not what they have entered last, else out of it, from it into the air
/// and back: a surface's two sides cannot be told from voxels, but what has been entered has to be left. A filled body is left
/// in the direction in which it was entered, as a plate is.
fn through<M: Materials, G: Geometry>(
    view: &View<'_, M, G>,
    (met, lift): (&Met<'_>, f32),
    (dir, n): ([f64; 3], [f64; 3]),
    refracts: bool,
    medium: Option<MaterialId>,
) -> (Option<Query>, Option<MaterialId>) {
    let (mut bent, mut behind_it) = (dir, medium);
    if refracts {
        let density = f64::from(met.material.refraction);
        let inside = medium == Some(met.id);
        match bend::refracted(dir, n, if inside { density } else { 1.0 / density }) {
            Some(dir) => bent = dir,
            None => return (bend::back(met, bend::reflected(dir, n), lift), medium),
        }
        behind_it = if inside { None } else { Some(met.id) };
    }
    let ray = Query::new(met.point, bent);
    match bend::behind(&view.tracer, &view.materials, (&met.hit, met.id, n), &ray) {
        None => (None, behind_it),
        Some(Behind { start, is_body: true }) if refracts => {
            (Some(Query { start: Some(start), ..Query::new(bend::entry(&ray, start), dir) }), medium)
        }
        Some(Behind { start, .. }) => (Some(Query { start: Some(start), ..ray }), behind_it),
    }
}

/// The share of a light, per channel, that comes along a shadow ray through transparent surfaces, straight, whatever their
/// Ni; `None` if nothing does.
pub(super) fn transmitted<K, M: Materials, G: Geometry>(
    view: &View<'_, M, G>,
    settings: &Chosen<K>,
    mut ray: Query,
) -> Option<[f32; 3]> {
    let mut share = [1.0; 3];
    for _ in 0..DEPTH {
        let Some(hit) = bend::trace(&view.tracer, settings.arithmetic, &ray) else { return Some(share) };
        let id = view.materials.id(hit.voxel);
        let material = super::batch::material(view.palette, id);
        if !Effects::of(material).contains(Effects::TRANSPARENCY) {
            return None;
        }
        let through = effects::through(material);
        share = [0, 1, 2].map(|i| share[i] * through[i]);
        if share.iter().all(|x| *x < LEAST) {
            return None;
        }
        let n = normal::normal(&view.tracer, view.materials, &hit, ray.dir, settings.normals).direction.map(f64::from);
        let Some(Behind { start, .. }) = bend::behind(&view.tracer, &view.materials, (&hit, id, n), &ray) else {
            return Some(share);
        };
        ray.start = Some(start);
    }
    None
}
