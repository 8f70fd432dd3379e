//! Samples that are traced and shaded together, stage by stage.
//!
//! In: places in the picture, each of a pixel of a tile. Out: of those that are to be shaded the colour, and which surface
//! it is of. First all rays, then all materials, all normals, where shadow rays start, and light by light the shadow rays
//! of the surfaces that face it, and its light: the tracer and the normals get all they need at once, whatever pixels it is
//! for. Entry `i` of every array is of one sample; what is not shaded leaves no gap.

use super::frame::Frame;
use super::sampling::Seen;
use super::{Settings, View, shadow};
use crate::geometry::Geometry;
use crate::grid::Grid;
use crate::material::{Material, MaterialId};
use crate::materials::Materials;
use crate::math;
use crate::morton::Morton;
use crate::normal::{self, Confidence, Normal};
use crate::shade::{self, Incidence, Light, LightKind, Surface};
use crate::trace::{Arithmetic, Face, Hit, Query, Tracer};

/// Most samples of a batch.
pub(super) const SAMPLES: usize = 256;

/// Room for samples, and for what becomes of them.
pub(super) struct Batch {
    count: usize,
    pixels: [u8; SAMPLES],
    /// In the picture, and what the rays through them met.
    places: [[f64; 2]; SAMPLES],
    met: [Option<Hit>; SAMPLES],
    // What is shaded.
    hits: [Hit; SAMPLES],
    dirs: [[f64; 3]; SAMPLES],
    /// Where the ray met the voxel, in grid coordinates.
    points: [[f64; 3]; SAMPLES],
    materials: [MaterialId; SAMPLES],
    normals: [Normal; SAMPLES],
    colors: [[f32; 3]; SAMPLES],
    /// Whether shadow rays start above the point.
    above: [bool; SAMPLES],
    /// Shadow rays, and whether they met something; and the samples that wait for that, and for which light.
    rays: [Query; SAMPLES],
    blocked: [bool; SAMPLES],
    waiting: [(u8, Incidence); SAMPLES],
}

const NO_RAY: Query = Query { origin: [0.0; 3], dir: [0.0; 3], t_min: 0.0, t_max: 0.0, min_level: 0, start: None };
const NO_HIT: Hit = Hit { voxel: Morton(0), from: None, t: 0.0, level: 0, face: Face::Inside };
const NO_NORMAL: Normal = Normal { direction: [0.0; 3], confidence: Confidence::Face };
const NO_LIGHT: Incidence = Incidence { direction: [0.0; 3], cosine: 0.0 };

impl Batch {
    pub fn new() -> Batch {
        Batch {
            count: 0,
            pixels: [0; SAMPLES],
            places: [[0.0; 2]; SAMPLES],
            met: [None; SAMPLES],
            hits: [NO_HIT; SAMPLES],
            dirs: [[0.0; 3]; SAMPLES],
            points: [[0.0; 3]; SAMPLES],
            materials: [0; SAMPLES],
            normals: [NO_NORMAL; SAMPLES],
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
        self.pixels[self.count] = pixel;
        self.places[self.count] = place;
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

    /// Follows all rays and leaves the samples that are to be shaded: hits that `keep` wants, which is asked of every sample
    /// by its pixel and what it met.
    pub fn trace<G: Geometry>(
        &mut self,
        tracer: &Tracer<'_, G>,
        arithmetic: Arithmetic,
        frame: &Frame,
        mut keep: impl FnMut(u8, Option<&Hit>) -> bool,
    ) {
        let rays = frame.rays(&self.places[..self.count]);
        tracer.trace_tile(arithmetic, &rays, &mut self.met);
        let mut kept = 0;
        for i in 0..self.count {
            let (pixel, met) = (self.pixels[i], self.met[i]);
            if let (true, Some(hit)) = (keep(pixel, met.as_ref()), met) {
                let dir = rays.direction(self.places[i]);
                self.pixels[kept] = pixel;
                self.hits[kept] = hit;
                self.dirs[kept] = dir;
                self.points[kept] = math::add_scaled(rays.origin, dir, hit.t);
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// Works out what all samples send back along their rays. Returns how many shadow rays that took.
    pub fn shade<M: Materials, G: Geometry>(&mut self, view: &View<'_, M, G>, settings: &Settings) -> u64 {
        let hits = &self.hits[..self.count];
        for (id, hit) in self.materials.iter_mut().zip(hits) {
            *id = view.materials.id(hit.voxel);
        }
        let level = view.tracer.level();
        normal::normals(level, &view.tracer, view.materials, hits, &self.dirs, settings.normals, &mut self.normals);
        for (color, id) in self.colors.iter_mut().zip(&self.materials[..self.count]) {
            *color = shade::glow(material(view.palette, *id), settings.ambient);
        }
        if view.lights.iter().any(|light| light.shadow) {
            self.rise(&view.tracer, settings.arithmetic);
        }
        view.lights.iter().map(|light| self.light(view, settings.arithmetic, light)).sum()
    }

    /// Finds out from where the samples' shadow rays start.
    fn rise<G: Geometry>(&mut self, tracer: &Tracer<'_, G>, arithmetic: Arithmetic) {
        let mut waiting = 0;
        for i in 0..self.count {
            let (hit, point) = (&self.hits[i], self.points[i]);
            let above = shadow::above(hit, point, &self.normals[i]);
            let way = above.and_then(|above| shadow::from_hit(hit, point, &LightKind::Point(above)));
            // Without a ray nothing is in the way.
            self.above[i] = above.is_some();
            if let Some(ray) = way {
                self.rays[waiting] = ray;
                self.waiting[waiting].0 = i as u8;
                waiting += 1;
            }
        }
        tracer.occluded_many(arithmetic, &self.rays[..waiting], &mut self.blocked);
        for ray in 0..waiting {
            self.above[usize::from(self.waiting[ray].0)] = !self.blocked[ray];
        }
    }

    /// The shadow ray of a sample to a light in grid coordinates; `None` if nothing is in its way.
    #[inline]
    fn shadow(&self, i: usize, light: &LightKind) -> Option<Query> {
        let (hit, point) = (&self.hits[i], self.points[i]);
        match shadow::above(hit, point, &self.normals[i]) {
            Some(above) if self.above[i] => Some(shadow::from(above, light)),
            _ => shadow::from_hit(hit, point, light),
        }
    }

    /// Adds a light to the colour of the samples that it reaches. Returns the number of its shadow rays.
    fn light<M: Materials, G: Geometry>(
        &mut self,
        view: &View<'_, M, G>,
        arithmetic: Arithmetic,
        light: &Light,
    ) -> u64 {
        let in_grid = match light.kind {
            LightKind::Point(position) => LightKind::Point(view.grid.to_grid(position)),
            sun => sun,
        };
        let mut waiting = 0;
        for i in 0..self.count {
            let surface = self.surface(i, &view.grid);
            let Some(incidence) = light.falls_on(&surface) else { continue };
            if light.shadow
                && let Some(ray) = self.shadow(i, &in_grid)
            {
                self.rays[waiting] = ray;
                self.waiting[waiting] = (i as u8, incidence);
                waiting += 1;
            } else {
                self.reflect(i, view.palette, &surface, light, incidence);
            }
        }

        view.tracer.occluded_many(arithmetic, &self.rays[..waiting], &mut self.blocked);
        for ray in 0..waiting {
            if !self.blocked[ray] {
                let (i, incidence) = self.waiting[ray];
                let i = usize::from(i);
                self.reflect(i, view.palette, &self.surface(i, &view.grid), light, incidence);
            }
        }
        waiting as u64
    }

    /// What is lit of a sample.
    #[inline]
    fn surface(&self, i: usize, grid: &Grid) -> Surface {
        let back = math::normalize(self.dirs[i].map(|x| -x)).unwrap_or([0.0; 3]);
        Surface {
            point: grid.to_world(self.points[i]),
            normal: self.normals[i].direction,
            view: back.map(|x| x as f32),
        }
    }

    /// Adds to a sample's colour what it sends back of a light that reaches it.
    #[inline]
    fn reflect(&mut self, i: usize, palette: &[Material], surface: &Surface, light: &Light, incidence: Incidence) {
        let material = material(palette, self.materials[i]);
        self.colors[i] = shade::reflect(self.colors[i], material, surface, light, incidence);
    }

    /// The samples that were shaded, in the order in which they came: pixel, linear colour, surface.
    pub fn shaded(&self) -> impl Iterator<Item = (u8, [f32; 3], Seen)> {
        (0..self.count).map(|i| {
            let (material, normal) = (self.materials[i], self.normals[i].direction);
            (self.pixels[i], self.colors[i], Seen { voxel: self.hits[i].voxel, material, normal })
        })
    }
}

/// A material of a palette; beyond its end grey.
#[inline]
fn material(palette: &[Material], id: MaterialId) -> &Material {
    palette.get(usize::from(id)).unwrap_or(&Material::GREY)
}
