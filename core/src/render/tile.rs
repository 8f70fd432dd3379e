//! A few neighbouring pixels, whose samples are traced and shaded together.
//!
//! In: the place of the tile in the picture. Out: its pixels. They take their samples in two turns: those that each begins
//! with, then those that some ask for after what the first ones saw ([`Plan`]). The samples of a turn fill batches to the
//! brim, one pixel after the other; a pixel may go on in the next batch, as its mean does not depend on how it is summed.

use super::batch::Batch;
use super::follow::{Follow, GOES_ON, effects_of};
use super::frame::Frame;
use super::kernel::{Chosen, Kernel};
use super::sampling::{Plan, Samples, Seen, Smooth, Supersample};
use super::{Counters, Settings, View};
use crate::color::{self, Mean};
use crate::geometry::Geometry;
use crate::materials::Materials;
use crate::trace::Hit;

/// Pixels along the rows.
pub(super) const WIDTH: u32 = 16;
/// Rows.
pub(super) const HEIGHT: u32 = 4;
/// Of the whole.
const PIXELS: usize = (WIDTH * HEIGHT) as usize;

/// A tile, and what it takes to draw one after the other.
pub(super) struct Tile<'a, K, M, G> {
    view: &'a View<'a, M, G>,
    settings: &'a Chosen<K>,
    /// Quantised.
    background: [u32; 3],
    smooth: Option<Smooth>,
    counters: Counters,
    batch: &'a mut Batch,
    /// Where rays go on from surfaces.
    follow: Option<Follow<'a>>,
    pixels: [Pixel; PIXELS],
}

/// What is known of a pixel.
#[derive(Clone, Copy, Default)]
struct Pixel {
    plan: Plan,
    mean: Mean,
    /// What its first sample saw, once that is known.
    first: Option<Option<Seen>>,
}

impl<'a, K: Kernel, M: Materials, G: Geometry> Tile<'a, K, M, G> {
    /// For any tile of a picture, in room that is lent, empty; the effects are those that the scene calls for.
    pub fn new(
        view: &'a View<'a, M, G>,
        settings: &'a Chosen<K>,
        batch: &'a mut Batch,
        follow: Option<Follow<'a>>,
    ) -> Tile<'a, K, M, G> {
        let smooth = match settings.supersample {
            Supersample::Adaptive { degrees } => Some(Smooth::within(degrees)),
            _ => None,
        };
        Tile {
            view,
            settings,
            background: settings.background.map(color::quantize),
            smooth,
            counters: Counters::default(),
            batch,
            follow,
            pixels: [Pixel::default(); PIXELS],
        }
    }

    /// What all tiles so far took.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Draws the tile whose upper left pixel is in column `left` and row `top` into `strip`, whole rows of the picture from
    /// `top` on; as much of it as there is.
    pub fn draw(&mut self, frame: &Frame, [left, top]: [u32; 2], strip: &mut [u32]) {
        let Settings { width, samples, supersample, .. } = **self.settings;
        let columns = WIDTH.min(width - left);
        let rows = HEIGHT.min(strip.len() as u32 / width);
        let places = || (0..rows * columns).map(|i| [left + i % columns, top + i / columns]);

        for (pixel, place) in self.pixels.iter_mut().zip(places()) {
            *pixel = Pixel { plan: supersample.plan(samples, place), ..Pixel::default() };
        }
        for turn in 0..2 {
            for (i, [x, y]) in places().enumerate() {
                let corner = [x, y].map(f64::from);
                for place in self.pixels[i].plan.places(turn) {
                    self.batch.push(i as u8, [corner[0] + place[0], corner[1] + place[1]]);
                    if self.batch.is_full() {
                        self.shade(frame);
                    }
                }
            }
            self.shade(frame);
        }

        let rows = strip.chunks_exact_mut(width as usize).map(|row| &mut row[left as usize..][..columns as usize]);
        for (out, pixel) in rows.flatten().zip(&self.pixels) {
            let many = pixel.plan.all && samples != Samples::One;
            self.counters.supersampled += u64::from(many);
            let mut rgb = pixel.mean.srgb8();
            if many && self.settings.mark_supersampled {
                rgb = [255, rgb[1] / 3, rgb[2] / 3];
            }
            let [red, green, blue] = rgb;
            *out = u32::from_le_bytes([red, green, blue, 255]);
        }
    }

    /// Traces and shades the samples of the batch, and gives them to their pixels.
    fn shade(&mut self, frame: &Frame) {
        let Tile { view, settings, background, smooth, counters, batch, follow, pixels } = self;
        counters.primary += batch.len() as u64;
        batch.trace(&view.tracer, settings.arithmetic, frame, |pixel, hit| {
            let pixel = &mut pixels[usize::from(pixel)];
            match hit {
                Some(hit) => {
                    counters.hits += 1;
                    pixel.shows(hit, settings)
                }
                None => {
                    pixel.add(*background, None, smooth);
                    false
                }
            }
        });
        batch.shade(view, settings, counters);
        if settings.effects().intersects(GOES_ON)
            && let Some(follow) = follow
        {
            for ((pixel, _, seen), color) in batch.shaded().zip(follow.colors(batch, view, settings, counters)) {
                let pixel = &mut pixels[usize::from(pixel)];
                pixel.add(*color, Some(seen), smooth);
                // What is seen in a mirror and through glass may have edges.
                pixel.plan.all |= smooth.is_some() && effects_of(view, settings, seen.material).intersects(GOES_ON);
            }
        } else {
            for (pixel, color, seen) in batch.shaded() {
                pixels[usize::from(pixel)].add(color.map(color::quantize), Some(seen), smooth);
            }
        }
        batch.clear();
    }
}

impl Pixel {
    /// Whether a hit is to be seen, or only told that the pixel takes all samples, of which it is none.
    fn shows(&mut self, hit: &Hit, settings: &Settings) -> bool {
        if self.plan.all || !settings.supersample.chooses(hit.voxel) {
            return true;
        }
        self.plan.all = true;
        settings.samples.center() != 0
    }

    /// Adds a sample.
    fn add(&mut self, color: [u32; 3], seen: Option<Seen>, smooth: &Option<Smooth>) {
        self.mean.add(color);
        if let Some(smooth) = smooth
            && !self.plan.all
        {
            self.plan.all = !smooth.joins(*self.first.get_or_insert(seen), seen);
        }
    }
}
