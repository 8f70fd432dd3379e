//! Many rays at once, as a program traces them: a picture tile by tile, other rays batch by batch.
//!
//! In: a tracer, and a picture's camera or rays that lie ready in memory. Out: arms to be measured. The rays of a tile
//! are made while the clock runs, and the few hits of a batch are read before the next ones take their place.

use std::ops::Range;

use voxdag::trace::{Arithmetic, Hit, Query, Tile, Tracer};
use voxdag::{Geometry, camera};

use crate::error::{Error, Result};
use crate::measure::{Arm, BLOCK};
use crate::options::CameraArgs;
use crate::picture::{self, Shown};

/// Rays that are traced at a time.
const BATCH: usize = 1024;
/// Pixels along an edge of a tile.
const EDGE: u32 = 16;
/// Pixels of a tile.
const TILE: usize = (EDGE * EDGE) as usize;

/// A picture whose rays, one through the centre of every pixel, are traced tile by tile.
pub struct Tiles {
    rays: camera::Rays,
    /// In grid coordinates.
    eye: [f64; 3],
    size: [u32; 2],
}

impl Tiles {
    /// The picture that the flags describe.
    pub fn new(scene: &Shown<'_>, args: &CameraArgs, size: [u32; 2]) -> Result<Tiles> {
        let camera = picture::camera(scene, args)?;
        let rays = camera.rays(size[0], size[1]).map_err(Error::usage)?;
        Ok(Tiles { rays, eye: scene.grid.to_grid(camera.eye), size })
    }

    /// How many there are.
    fn count(&self) -> usize {
        self.size.map(|pixels| pixels.div_ceil(EDGE) as usize).iter().product()
    }

    /// Writes down the pixels' centres of a tile, less of them at the right and at the bottom of the picture, from place
    /// `count` on; returns where they end.
    fn places(&self, tile: usize, places: &mut [[f64; 2]; BATCH], mut count: usize) -> usize {
        let [width, height] = self.size;
        let columns = width.div_ceil(EDGE);
        let (left, top) = (EDGE * (tile as u32 % columns), EDGE * (tile as u32 / columns));
        for y in top..height.min(top + EDGE) {
            for x in left..width.min(left + EDGE) {
                places[count] = [x, y].map(|k| f64::from(k) + 0.5);
                count += 1;
            }
        }
        count
    }

    /// Traces some tiles; `each` gets the rays of a batch and what they hit.
    fn trace<G: Geometry>(
        &self,
        tracer: &Tracer<'_, G>,
        arithmetic: Arithmetic,
        tiles: Range<usize>,
        mut each: impl FnMut(&Tile<'_>, &[Option<Hit>]),
    ) {
        let (mut places, mut hits) = ([[0.0; 2]; BATCH], [None; BATCH]);
        for first in tiles.clone().step_by(BATCH / TILE) {
            let mut count = 0;
            for tile in first..tiles.end.min(first + BATCH / TILE) {
                count = self.places(tile, &mut places, count);
            }
            let rays = self.rays.tile(self.eye, &places[..count]);
            tracer.trace_tile(arithmetic, &rays, &mut hits[..count]);
            each(&rays, &hits[..count]);
        }
    }

    /// The nearest hits of all rays; `of` gives what each adds to the checksum.
    pub fn nearest<'a, G: Geometry>(
        &'a self,
        tracer: &'a Tracer<'a, G>,
        arithmetic: Arithmetic,
        of: fn(Option<Hit>) -> u64,
    ) -> Arm<'a> {
        Arm::ranges(self.count(), BLOCK / TILE, move |tiles| {
            let mut sum = 0u64;
            self.trace(tracer, arithmetic, tiles, |_, hits| {
                sum = hits.iter().fold(sum, |sum, hit| sum.wrapping_add(of(*hit)))
            });
            sum
        })
    }

    /// How many rays meet another voxel by this arithmetic than by the exact one, or only by one of them any.
    pub fn differing<G: Geometry>(&self, tracer: &Tracer<'_, G>, arithmetic: Arithmetic) -> usize {
        let mut differing = 0;
        self.trace(tracer, arithmetic, 0..self.count(), |rays, hits| {
            let exact = rays.places.iter().map(|place| Query::new(rays.origin, rays.direction(*place)));
            let exact = exact.map(|query| tracer.trace(Arithmetic::Exact, &query));
            let voxel = |hit: Option<Hit>| hit.map(|hit| hit.voxel);
            differing += exact.zip(hits).filter(|(exact, hit)| voxel(*exact) != voxel(**hit)).count();
        });
        differing
    }
}

/// The nearest hits of rays; `of` gives what each adds to the checksum.
pub fn nearest<'a, G: Geometry>(tracer: &'a Tracer<'a, G>, rays: &'a [Query], of: fn(Option<Hit>) -> u64) -> Arm<'a> {
    Arm::ranges(rays.len(), BLOCK, move |range| {
        let (mut sum, mut hits) = (0u64, [None; BATCH]);
        for rays in rays[range].chunks(BATCH) {
            tracer.trace_many(Arithmetic::Exact, rays, &mut hits);
            sum = hits[..rays.len()].iter().fold(sum, |sum, hit| sum.wrapping_add(of(*hit)));
        }
        sum
    })
}

/// Whether rays hit; the checksum is the number of those that do.
pub fn any<'a, G: Geometry>(tracer: &'a Tracer<'a, G>, rays: &'a [Query]) -> Arm<'a> {
    Arm::ranges(rays.len(), BLOCK, move |range| {
        let (mut sum, mut blocked) = (0u64, [false; BATCH]);
        for rays in rays[range].chunks(BATCH) {
            tracer.occluded_many(Arithmetic::Exact, rays, &mut blocked);
            sum += blocked[..rays.len()].iter().map(|&blocked| u64::from(blocked)).sum::<u64>();
        }
        sum
    })
}
