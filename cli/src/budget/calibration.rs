//! Measures what a quality costs and how good it is, by drawing a part of the picture: bands of rows, spread over it, with
//! the threads and the trees that will draw the whole.
//!
//! The time of the whole is the sum of what the bands took, by the share of bands, divided by the threads: how few bands
//! are shared out among many threads does not matter, and what else runs on the machine counts as it will then.

use std::time::{Duration, Instant};

use voxdag::render::Samples;

use super::Ruler;
use crate::error::Result;
use crate::memory::Memory;
use crate::metrics::{View, rmse};
use crate::options::{PictureArgs, SupersampleArg};
use crate::picture::{Prepared, Shown, bands};
use crate::quality::Quality;

/// A ruler for one picture.
pub struct Calibration<'a> {
    scene: &'a Shown<'a>,
    args: &'a PictureArgs,
    memory: Memory,
    /// What was derived so far, by level of detail.
    prepared: Vec<(u8, Prepared)>,
    /// What that took.
    derive: Duration,
    start: Instant,
    /// 64 samples of some bands.
    reference: Option<(Vec<u32>, Vec<u32>)>,
}

/// Bands for each thread, at least: less says too little.
const PER_THREAD: usize = 2;
/// Times that a whole picture is drawn, at most.
const REPEAT: f64 = 3.0;

impl<'a> Calibration<'a> {
    /// Of the picture that `args` describe, but for the quality.
    pub fn new(scene: &'a Shown<'a>, args: &'a PictureArgs, memory: &Memory) -> Calibration<'a> {
        let (prepared, derive, start) = (Vec::new(), Duration::ZERO, Instant::now());
        Calibration { scene, args, memory: memory.with(0), prepared, derive, start, reference: None }
    }

    /// What the picture in a quality is to be drawn with, and how long calibrating took without the deriving.
    pub fn finish(mut self, quality: Quality) -> Result<(Prepared, Duration)> {
        let at = self.prepare(quality.lod)?;
        let time = self.start.elapsed().saturating_sub(self.derive);
        Ok((self.prepared.swap_remove(at).1, time))
    }

    /// Where what is derived for a level of detail is.
    fn prepare(&mut self, lod: u8) -> Result<usize> {
        if let Some(at) = self.prepared.iter().position(|known| known.0 == lod) {
            return Ok(at);
        }
        let start = Instant::now();
        let prepared = Prepared::new(self.scene, lod, &self.memory)?;
        self.derive += start.elapsed();
        self.memory.hold(prepared.bytes());
        self.prepared.push((lod, prepared));
        Ok(self.prepared.len() - 1)
    }

    /// So many bands, at least, spread evenly.
    fn spread(&self, effort: f64) -> Vec<u32> {
        let (_, count) = bands(self.args.size);
        let least = PER_THREAD * rayon::current_num_threads();
        let most = ((f64::from(count) * effort) as usize).max(least).max(4).min(count as usize);
        let step = f64::from(count) / most as f64;
        (0..most).map(|i| ((i as f64 + 0.5) * step) as u32).collect()
    }

    fn draw(&mut self, quality: Quality, bands: &[u32]) -> Result<(Vec<u32>, Duration)> {
        let at = self.prepare(quality.lod)?;
        self.prepared[at].1.draw_bands(self.scene, &quality.apply(self.args), bands, &self.memory)
    }
}

impl Ruler for Calibration<'_> {
    fn seconds(&mut self, quality: Quality, effort: f64) -> Result<f64> {
        let numbers = self.spread(effort);
        let times = effort.clamp(1.0, REPEAT) as u32;
        let mut sum = Duration::ZERO;
        for _ in 0..times {
            sum += self.draw(quality, &numbers)?.1;
        }
        let drawn = f64::from(times) * numbers.len() as f64 / f64::from(bands(self.args.size).1);
        Ok(sum.as_secs_f64() / drawn / rayon::current_num_threads() as f64)
    }

    fn error(&mut self, quality: Quality, effort: f64) -> Result<f64> {
        let (numbers, reference) = match self.reference.take() {
            Some(known) => known,
            None => {
                let (samples, supersample) = (Samples::SixtyFour, SupersampleArg::All);
                let numbers = self.spread(effort);
                let drawn = self.draw(Quality { samples, supersample, lod: 0, ..quality }, &numbers)?.0;
                (numbers, drawn)
            }
        };
        let drawn = self.draw(quality, &numbers)?.0;
        let width = self.args.size[0];
        let view = |pixels| View { width, height: bands(self.args.size).0 * numbers.len() as u32, pixels };
        let error = rmse(view(&reference), view(&drawn));
        self.reference = Some((numbers, reference));
        Ok(error)
    }
}
