//! Samples that are traced and shaded together, stage by stage.
//!
//! In: places in the picture, each of a pixel of a tile. Out: of those that are to be shaded the colour, and which surface
//! it is of. First all rays, then all materials, all normals, where shadow rays start, and light by light the shadow rays
//! of the surfaces that face it, and its light: the tracer and the normals get all they need at once, whatever pixels it is
//! for. Entry `i` of every array is of one sample; what is not shaded leaves no gap. Rays that go on from a surface
//! ([`super::follow`]) are samples, too.

use glam::Vec3;

use super::frame::Frame;
use super::kernel::{self, Chosen, Kernel};
use super::sampling::Seen;
use super::{Counters, View, bend, follow, shadow};
use crate::color;
use crate::effects::{self, Effects};
use crate::geometry::Geometry;
use crate::material::{Material, MaterialId};
use crate::materials::Materials;
use crate::math;
use crate::morton::Morton;
use crate::normal::{self, Confidence, Normal, NormalKind};
use crate::shade::{self, Incidence, Light, LightKind};
use crate::trace::{Arithmetic, Face, Hit, Query, Tracer};

/// Most samples of a batch.
pub(super) const SAMPLES: usize = 256;

/// Room for samples, and for what becomes of them.
#[repr(align(64))] // wherever it lies, what is copied lies alike in the lines of the cache
pub(super) struct Batch {
    count: usize,
    /// Whose samples they are: pixels of a tile, or whatever rays were given for.
    owners: [u8; SAMPLES],
    /// In the picture, and what the rays through them met.
    places: [[f64; 2]; SAMPLES],
    met: [Option<Hit>; SAMPLES],
    /// Which of them are shaded.
    kept: [u8; SAMPLES],
    // What is shaded.
    hits: [Hit; SAMPLES],
    dirs: [[f64; 3]; SAMPLES],
    /// Where the ray met the voxel, in grid coordinates.
    points: [[f64; 3]; SAMPLES],
    materials: [MaterialId; SAMPLES],
    normals: [Normal; SAMPLES],
    /// The colours of their textures.
    tints: [[u8; 3]; SAMPLES],
    colors: [[f32; 3]; SAMPLES],
    /// Whether shadow rays start above the point.
    above: [bool; SAMPLES],
    /// Shadow rays, and whether they met something; and the samples that wait for that, and for which light.
    rays: [Query; SAMPLES],
    blocked: [bool; SAMPLES],
    waiting: [(u8, Incidence); SAMPLES],
}

/// What sends rays back; refraction does so where nothing gets through.
const LEAVING: Effects = Effects::MIRROR.union(Effects::REFRACTION);

const NO_RAY: Query = Query { origin: [0.0; 3], dir: [0.0; 3], t_min: 0.0, t_max: 0.0, min_level: 0, start: None };
const NO_HIT: Hit = Hit { voxel: Morton(0), from: None, t: 0.0, level: 0, face: Face::Inside };
const NO_NORMAL: Normal = Normal { direction: [0.0; 3], confidence: Confidence::Face };
const NO_LIGHT: Incidence = Incidence { direction: [0.0; 3], cosine: 0.0 };

impl Batch {
    pub fn new() -> Batch {
        Batch {
            count: 0,
            owners: [0; SAMPLES],
            places: [[0.0; 2]; SAMPLES],
            met: [None; SAMPLES],
            kept: [0; SAMPLES],
            hits: [NO_HIT; SAMPLES],
            dirs: [[0.0; 3]; SAMPLES],
            points: [[0.0; 3]; SAMPLES],
            materials: [0; SAMPLES],
            normals: [NO_NORMAL; SAMPLES],
            tints: [[255; 3]; SAMPLES],
            colors: [[0.0; 3]; SAMPLES],
            above: [false; SAMPLES],
            rays: [NO_RAY; SAMPLES],
            blocked: [false; SAMPLES],
            waiting: [(0, NO_LIGHT); SAMPLES],
        }
    }

    /// Adds a sample at a place of the picture; the batch must not be full.
    #[inline]
    pub fn push(&mut self, pixel: u8, place: [f64; 2]) {
        self.owners[self.count] = pixel;
        self.places[self.count] = place;
        self.count += 1;
    }

    /// Adds a ray, its direction of unit length; the batch must not be full, nor hold places.
    #[inline]
    pub fn push_ray(&mut self, owner: u8, ray: Query) {
        self.owners[self.count] = owner;
        self.rays[self.count] = ray;
        self.count += 1;
    }

    pub fn len(&self) -> usize {
        self.count
    }

    pub fn is_full(&self) -> bool {
        self.count == SAMPLES
    }

    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Follows the rays through all places and leaves the samples that are to be shaded: hits that `keep` wants, which is
    /// asked of every sample by its pixel and what it met.
    pub fn trace<G: Geometry>(
        &mut self,
        tracer: &Tracer<'_, G>,
        arithmetic: Arithmetic,
        frame: &Frame,
        keep: impl FnMut(u8, Option<&Hit>) -> bool,
    ) {
        let rays = frame.rays(&self.places[..self.count]);
        tracer.trace_tile(arithmetic, &rays, &mut self.met);
        let origin = rays.origin;
        self.keep(keep);
        let rays = frame.rays(&self.places);
        for (k, i) in self.kept[..self.count].iter().enumerate() {
            let dir = rays.direction(self.places[usize::from(*i)]);
            self.dirs[k] = dir;
            self.points[k] = math::add_scaled(origin, dir, self.hits[k].t);
        }
    }

    /// The same with the rays that were given; one that begins in a filled voxel goes on from there.
    pub fn trace_rays<G: Geometry>(
        &mut self,
        tracer: &Tracer<'_, G>,
        arithmetic: Arithmetic,
        keep: impl FnMut(u8, Option<&Hit>) -> bool,
    ) {
        bend::trace_many(tracer, arithmetic, &self.rays[..self.count], &mut self.met);
        self.keep(keep);
        for (k, i) in self.kept[..self.count].iter().enumerate() {
            let Query { origin, dir, .. } = self.rays[usize::from(*i)];
            self.dirs[k] = dir;
            self.points[k] = math::add_scaled(origin, dir, self.hits[k].t);
        }
    }

    /// Leaves the samples whose hits are kept, but for their directions and points.
    #[inline]
    fn keep(&mut self, mut keep: impl FnMut(u8, Option<&Hit>) -> bool) {
        let mut kept = 0;
        for i in 0..self.count {
            let (owner, met) = (self.owners[i], self.met[i]);
            if let (true, Some(hit)) = (keep(owner, met.as_ref()), met) {
                self.owners[kept] = owner;
                self.hits[kept] = hit;
                self.kept[kept] = i as u8;
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// Works out what all samples send back along their rays, but what comes from other surfaces.
    pub fn shade<K: Kernel, M: Materials, G: Geometry>(
        &mut self,
        view: &View<'_, M, G>,
        settings: &Chosen<K>,
        counters: &mut Counters,
    ) {
        if self.count == 0 {
            return;
        }
        let hits = &self.hits[..self.count];
        for (id, hit) in self.materials.iter_mut().zip(hits) {
            *id = view.materials.id(hit.voxel);
        }
        let level = view.tracer.level();
        normal::normals(level, &view.tracer, view.materials, hits, &self.dirs, settings.normals, &mut self.normals);
        let normals = &self.normals[..self.count];
        counters.normals += match settings.normals {
            NormalKind::Face => 0,
            NormalKind::Stored => {
                normals.iter().filter(|normal| normal.confidence != Confidence::Stored).count() as u64
            }
            _ => normals.len() as u64,
        };
        if settings.effects().contains(Effects::TEXTURES) {
            self.tint(view, counters);
        }
        let glows = settings.effects().contains(Effects::EMISSION);
        for i in 0..self.count {
            self.colors[i] = self.looking(i, view.palette, settings.effects(), |material| {
                let color = shade::glow(material, settings.ambient);
                if glows { (Vec3::from(color) + Vec3::from(material.emission)).to_array() } else { color }
            });
        }
        let shadows = settings.effects().contains(Effects::SHADOWS) && view.lights.iter().any(|light| light.shadow);
        if shadows || settings.effects().intersects(LEAVING) {
            let start = K::now();
            self.rise(view, settings, shadows);
            *(if shadows { &mut counters.shadow_time } else { &mut counters.secondary_time }) +=
                kernel::since::<K>(start);
        }
        for light in view.lights {
            self.light(view, settings, light, counters);
        }
    }

    /// Looks up the colours of the samples' textures.
    #[inline(never)]
    fn tint<M: Materials, G: Geometry>(&mut self, view: &View<'_, M, G>, counters: &mut Counters) {
        for i in 0..self.count {
            if material(view.palette, self.materials[i]).textured {
                counters.textures += 1;
                self.tints[i] = view.materials.color(self.hits[i].voxel).unwrap_or([255; 3]);
            }
        }
    }

    /// What `shade` makes of a sample's material: under its texture, and of what is left of it where one sees through it.
    #[inline]
    fn looking(
        &self,
        i: usize,
        palette: &[Material],
        effects: Effects,
        shade: impl FnOnce(&Material) -> [f32; 3],
    ) -> [f32; 3] {
        let material = material(palette, self.materials[i]);
        let is_textured = effects.contains(Effects::TEXTURES) && material.textured;
        let is_clear = effects.contains(Effects::TRANSPARENCY) && Effects::of(material).contains(Effects::TRANSPARENCY);
        if !is_textured && !is_clear {
            return shade(material);
        }
        let mut own = *material;
        if is_textured {
            let linear = self.tints[i].map(|byte| f32::from(color::LINEAR[usize::from(byte)]) / color::WHITE as f32);
            for color in [&mut own.ambient, &mut own.diffuse] {
                *color = (Vec3::from(*color) * Vec3::from(linear)).to_array();
            }
        }
        if is_clear { shade(&effects::faded(&own)) } else { shade(&own) }
    }

    /// Finds out from where rays leave the samples' surfaces: of all, or only of those that may send rays back.
    fn rise<K: Kernel, M: Materials, G: Geometry>(&mut self, view: &View<'_, M, G>, settings: &Chosen<K>, all: bool) {
        let mut waiting = 0;
        for i in 0..self.count {
            if !(all || Effects::of(material(view.palette, self.materials[i])).intersects(LEAVING)) {
                continue;
            }
            let (hit, point) = (&self.hits[i], self.points[i]);
            let above = shadow::above(hit, point, &self.normals[i], settings.lift);
            let way = above.and_then(|above| shadow::from_hit(hit, point, &LightKind::Point(above)));
            // Without a ray nothing is in the way.
            self.above[i] = above.is_some();
            if let Some(ray) = way {
                self.rays[waiting] = ray;
                self.waiting[waiting].0 = i as u8;
                waiting += 1;
            }
        }
        if waiting == 0 {
            return;
        }
        K::follows(&self.rays[..waiting], false);
        view.tracer.occluded_many(settings.arithmetic, &self.rays[..waiting], &mut self.blocked);
        for ray in 0..waiting {
            self.above[usize::from(self.waiting[ray].0)] = !self.blocked[ray];
        }
    }

    /// The shadow ray of a sample to a light in grid coordinates; `None` if nothing is in its way.
    #[inline]
    fn shadow(&self, i: usize, light: &LightKind, lift: f32) -> Option<Query> {
        let (hit, point) = (&self.hits[i], self.points[i]);
        match shadow::above(hit, point, &self.normals[i], lift) {
            Some(above) if self.above[i] => Some(shadow::from(above, light)),
            _ => shadow::from_hit(hit, point, light),
        }
    }

    /// Adds a light to the colour of the samples that it reaches.
    fn light<K: Kernel, M: Materials, G: Geometry>(
        &mut self,
        view: &View<'_, M, G>,
        settings: &Chosen<K>,
        light: &Light,
        counters: &mut Counters,
    ) {
        let in_grid = match light.kind {
            LightKind::Point(position) => LightKind::Point(view.grid.to_grid(position)),
            sun => sun,
        };
        let casts_shadows = light.shadow && settings.effects().contains(Effects::SHADOWS);
        let mut waiting = 0;
        for i in 0..self.count {
            let point = view.grid.to_world(self.points[i]);
            let Some(incidence) = light.falls_at(point, self.normals[i].direction) else { continue };
            if casts_shadows && let Some(ray) = self.shadow(i, &in_grid, settings.lift) {
                self.rays[waiting] = ray;
                self.waiting[waiting] = (i as u8, incidence);
                waiting += 1;
            } else {
                self.reflect(i, view.palette, settings.effects(), (light, incidence), counters);
            }
        }

        if waiting == 0 {
            return;
        }
        counters.shadow += waiting as u64;
        K::follows(&self.rays[..waiting], true);
        let start = K::now();
        view.tracer.occluded_many(settings.arithmetic, &self.rays[..waiting], &mut self.blocked);
        counters.shadow_time += kernel::since::<K>(start);
        let may_pass = settings.effects().contains(Effects::TRANSPARENCY);
        for ray in 0..waiting {
            let mut light = *light;
            if self.blocked[ray] {
                if !may_pass {
                    continue;
                }
                let start = K::now();
                let share = follow::transmitted(view, settings, self.rays[ray]);
                counters.shadow_time += kernel::since::<K>(start);
                let Some(share) = share else { continue };
                light.color = [0, 1, 2].map(|i| light.color[i] * share[i]);
            }
            let (i, incidence) = self.waiting[ray];
            self.reflect(i.into(), view.palette, settings.effects(), (&light, incidence), counters);
        }
    }

    /// Adds to a sample's colour what it sends back of a light that reaches it.
    #[inline]
    fn reflect(
        &mut self,
        i: usize,
        palette: &[Material],
        effects: Effects,
        (light, incidence): (&Light, Incidence),
        counters: &mut Counters,
    ) {
        let color = self.colors[i];
        self.colors[i] = self.looking(i, palette, effects, |material| {
            let color = shade::matte(color, material, light, incidence);
            if !(effects.contains(Effects::SPECULAR) && shade::has_highlight(material)) {
                return color;
            }
            let back = math::normalize(self.dirs[i].map(|x| -x)).unwrap_or([0.0; 3]);
            let facing = (self.normals[i].direction, back.map(|x| x as f32));
            match shade::highlight(color, material, facing, light, incidence) {
                Some(brighter) => {
                    counters.highlights += 1;
                    brighter
                }
                None => color,
            }
        });
    }

    /// The samples that were shaded, in the order in which they came: owner, linear colour, surface.
    pub fn shaded(&self) -> impl Iterator<Item = (u8, [f32; 3], Seen)> {
        (0..self.count).map(|i| {
            let (material, normal) = (self.materials[i], self.normals[i].direction);
            (self.owners[i], self.colors[i], Seen { voxel: self.hits[i].voxel, material, normal })
        })
    }

    /// A sample that was shaded, as rays go on from it.
    #[inline]
    pub fn met<'a>(&self, i: usize, palette: &'a [Material]) -> Met<'a> {
        Met {
            hit: self.hits[i],
            point: self.points[i],
            dir: self.dirs[i],
            normal: self.normals[i],
            above: self.above[i],
            id: self.materials[i],
            material: material(palette, self.materials[i]),
        }
    }
}

/// A surface that a ray met.
pub(super) struct Met<'a> {
    pub hit: Hit,
    /// In grid coordinates.
    pub point: [f64; 3],
    /// Of the ray.
    pub dir: [f64; 3],
    pub normal: Normal,
    /// Whether rays that leave the surface start above its steps; of mirrors, and of what is lit by a light with shadows.
    pub above: bool,
    pub id: MaterialId,
    pub material: &'a Material,
}

/// A material of a palette; beyond its end grey.
#[inline]
pub(super) fn material(palette: &[Material], id: MaterialId) -> &Material {
    palette.get(usize::from(id)).unwrap_or(&Material::GREY)
}
