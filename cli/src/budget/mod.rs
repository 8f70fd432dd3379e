//! Which quality a picture gets for a time, or for an error: `render --budget` and `--target-error`.
//!
//! In: what measures a quality's time and error on this machine, and the goal. Out: the most accurate quality that fits,
//! or the cheapest that is good enough. Qualities stand on ladders, from cheap to dear in small steps, so that a few
//! measurements by halves find the place of a goal, and the best place of all ladders is taken: what is left of the
//! Pareto front once everything far from the goal is passed over unmeasured.
//!
//! ```text
//! coarse   1 sample: --lod 4, 3, 2, 1, 0
//! fine     1 sample | 4 in more and more of the middle | 4 | 5 | 16 or 64 where not smooth within 90 .. 0 degrees
//! ```
//! Time is that of drawing the rows. Error is the RMSE in linear light against 64 samples in all pixels, of the same
//! voxels, with the same normals and arithmetic.

mod calibration;

pub use calibration::Calibration;

use voxdag::render::Samples;

use crate::error::Result;
use crate::options::SupersampleArg;
use crate::quality::Quality;
use crate::report::time;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub enum Goal {
    /// At most so many seconds.
    Seconds(f64),
    /// At most this error.
    Error(f64),
}

/// What was chosen, and what it is expected to give.
#[derive(Debug)]
pub struct Choice {
    pub quality: Quality,
    pub seconds: f64,
    pub error: f64,
    /// Why it is not closer to the goal.
    pub note: Option<String>,
}

/// Measures qualities of one picture; `effort` is how much of a picture may be drawn for it: a share, or several ones.
pub trait Ruler {
    /// Seconds that the rows take.
    fn seconds(&mut self, quality: Quality, effort: f64) -> Result<f64>;
    /// The error.
    fn error(&mut self, quality: Quality, effort: f64) -> Result<f64>;
}

/// The part of a budget that is aimed at: the rest is for what no calibration can foresee.
const AIM: f64 = 0.97;
/// Times nearer to the aim than this part of it are near enough.
const NEAR: f64 = 0.04;
/// Errors that rounding to 8 bits has anyway: less than that is nothing to pay for.
const NEGLIGIBLE: f64 = 0.001;
/// Degrees of `--supersample adaptive`, from cheap to dear.
const DEGREES: [f32; 25] = [
    90.0, 72.0, 58.0, 46.0, 37.0, 29.0, 24.0, 19.0, 15.0, 12.0, 9.7, 7.7, 6.2, 4.9, 4.0, 3.2, 2.5, 2.0, 1.6, 1.3, 1.0,
    0.8, 0.6, 0.3, 0.0,
];
/// Parts of the picture, from its middle, that take four samples before all of it does.
const REGIONS: u32 = 40;
/// The coarsest level of detail that is still a picture.
const COARSEST: u8 = 4;
/// The part of the time without it that a level of detail must stay below, to be worth its error.
const WORTH: f64 = 0.9;

/// What there is to choose from.
#[derive(Clone, Copy)]
pub struct Range {
    /// Its normals and arithmetic are kept.
    pub usual: Quality,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Octree levels of the scene.
    pub depth: u8,
}

impl Range {
    /// Other samples, at full resolution.
    fn sampled(self, samples: Samples, supersample: SupersampleArg) -> Quality {
        Quality { samples, supersample, lod: 0, ..self.usual }
    }

    fn all(self, samples: Samples) -> Quality {
        self.sampled(samples, SupersampleArg::All)
    }

    /// One sample, coarser and coarser towards the beginning.
    fn coarse(self) -> Vec<Quality> {
        (0..=COARSEST.min(self.depth)).rev().map(|lod| Quality { lod, ..self.all(Samples::One) }).collect()
    }

    /// One sample and more, up to `most` where surfaces are not smooth.
    fn fine(self, most: Samples) -> Vec<Quality> {
        let mut ladder = vec![self.all(Samples::One)];
        ladder.extend((1..REGIONS).filter_map(|part| {
            let side = (f64::from(part) / f64::from(REGIONS)).sqrt();
            let margin = self.size.map(|side_of_all| ((1.0 - side) / 2.0 * f64::from(side_of_all)).round() as u32);
            let [x, y] = margin;
            let [end_x, end_y] = [self.size[0] - x, self.size[1] - y];
            let region = SupersampleArg::Region([x, y, end_x, end_y]);
            (x < end_x && y < end_y).then(|| self.sampled(Samples::Four, region))
        }));
        ladder.extend([self.all(Samples::Four), self.all(Samples::Five)]);
        ladder.extend(DEGREES.map(|degrees| self.sampled(most, SupersampleArg::Adaptive(degrees))));
        ladder
    }
}

/// Chooses.
pub fn choose(ruler: &mut impl Ruler, goal: Goal, range: Range) -> Result<Choice> {
    let one = range.all(Samples::One);
    // The first rays find their data in no cache.
    ruler.seconds(one, 0.0)?;
    let rough = ruler.seconds(one, 0.0)?;
    match goal {
        Goal::Seconds(budget) => {
            let allowed = allowed(goal);
            let unit = budget.max(rough);
            let search = Search {
                ruler,
                effort: allowed / (32.0 * unit),
                careful: allowed / (8.0 * unit),
                error_effort: allowed / (320.0 * rough),
                seconds: Vec::new(),
                errors: Vec::new(),
            };
            search.within(budget, range)
        }
        Goal::Error(most) => {
            let effort = allowed(goal) / (250.0 * rough);
            let search = Search {
                ruler,
                effort,
                careful: effort,
                error_effort: effort,
                seconds: Vec::new(),
                errors: Vec::new(),
            };
            search.reaching(most, range)
        }
    }
}

/// Seconds that choosing may take, about.
fn allowed(goal: Goal) -> f64 {
    match goal {
        Goal::Seconds(budget) => (2.0 * budget).max(1.0),
        Goal::Error(_) => 1.0,
    }
}

/// What was measured so far, and how thoroughly.
struct Search<'r, R> {
    ruler: &'r mut R,
    effort: f64,
    /// The effort for what is to be drawn.
    careful: f64,
    error_effort: f64,
    seconds: Vec<(Quality, f64)>,
    errors: Vec<(Quality, f64)>,
}

impl<R: Ruler> Search<'_, R> {
    fn seconds(&mut self, quality: Quality) -> Result<f64> {
        if let Some(known) = self.seconds.iter().find(|known| known.0 == quality) {
            return Ok(known.1);
        }
        let seconds = self.ruler.seconds(quality, self.effort)?;
        self.seconds.push((quality, seconds));
        Ok(seconds)
    }

    fn error(&mut self, quality: Quality) -> Result<f64> {
        if let Some(known) = self.errors.iter().find(|known| known.0 == quality) {
            return Ok(known.1);
        }
        let error = self.ruler.error(quality, self.error_effort)?;
        self.errors.push((quality, error));
        Ok(error)
    }

    /// One sample, with the levels of detail that are worth it.
    fn coarse(&mut self, range: Range) -> Result<Vec<Quality>> {
        let one = self.seconds(range.all(Samples::One))?;
        let mut ladder = Vec::new();
        for quality in range.coarse() {
            if quality.lod == 0 || self.seconds(quality)? < WORTH * one {
                ladder.push(quality);
            }
        }
        Ok(ladder)
    }

    /// The highest rung that takes at most so many seconds; the lowest one if none does.
    fn climb(&mut self, ladder: &[Quality], most: f64) -> Result<usize> {
        Ok(first(ladder.len(), |rung| Ok(self.seconds(ladder[rung])? > most))?.saturating_sub(1))
    }

    /// The most accurate quality within a budget.
    fn within(mut self, budget: f64, range: Range) -> Result<Choice> {
        let aim = AIM * budget;
        let one = range.all(Samples::One);
        // That even one sample takes too long is worth asking twice.
        if self.seconds(one)? > aim {
            let again = self.ruler.seconds(one, self.careful)?;
            self.seconds.iter_mut().filter(|known| known.0 == one).for_each(|known| known.1 = known.1.min(again));
        }
        let ladders = match self.seconds(one)? > aim {
            true => vec![self.coarse(range)?],
            false => vec![range.fine(Samples::Sixteen), range.fine(Samples::SixtyFour)],
        };
        // The best ladder.
        let mut best = (f64::INFINITY, 0);
        for (i, ladder) in ladders.iter().enumerate() {
            let rung = self.climb(ladder, aim)?;
            let error = self.error(ladder[rung])?;
            if error < best.0 {
                best = (error, i);
            }
        }
        let mut ladder = ladders[best.1].clone();
        // The ruler itself, where there is time for it and something to gain.
        let exact = range.all(Samples::SixtyFour);
        let top = *ladder.last().expect("a ladder has rungs");
        if self.seconds(one)? <= aim && self.seconds(top)? <= aim && self.error(top)? > NEGLIGIBLE {
            ladder.push(exact);
        }
        let (rung, seconds) = self.settle(&ladder, aim)?;
        let quality = ladder[rung];
        let error = self.error(quality)?;
        let note = if rung == 0 && seconds > budget {
            Some(format!("the cheapest setting takes {}", time(1000.0 * seconds)))
        } else if seconds >= 0.8 * budget {
            None
        } else if rung + 1 == ladder.len() {
            Some(format!("the most accurate setting takes only {}", time(1000.0 * seconds)))
        } else {
            let next = ladder[rung + 1];
            let seconds = self.seconds(next)?;
            Some(format!("the next setting takes {}: {}", time(1000.0 * seconds), next.flags()))
        };
        Ok(Choice { quality, seconds, error, note })
    }

    /// The rung whose time, measured carefully, is nearest to `aim`, and that time.
    fn settle(&mut self, ladder: &[Quality], aim: f64) -> Result<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let mut search_for = aim;
        for _ in 0..4 {
            let rung = self.climb(ladder, search_for)?;
            let seconds = self.ruler.seconds(ladder[rung], self.careful)?;
            let off = |seconds: f64| (seconds / aim - 1.0).abs();
            let known = best.is_some_and(|best| best.0 == rung);
            if best.is_none_or(|best| off(seconds) < off(best.1)) {
                best = Some((rung, seconds));
            }
            if known || off(seconds) < NEAR {
                break;
            }
            // What quick measurements of this quality get wrong they get wrong for its neighbours, too.
            search_for = aim * self.seconds(ladder[rung])? / seconds;
        }
        Ok(best.expect("something was measured"))
    }

    /// The cheapest quality of at most an error.
    fn reaching(mut self, most: f64, range: Range) -> Result<Choice> {
        let one = range.all(Samples::One);
        let exact = range.all(Samples::SixtyFour);
        let ladders = match self.error(one)? <= most {
            true => vec![self.coarse(range)?],
            false => vec![range.fine(Samples::Sixteen), range.fine(Samples::SixtyFour), vec![exact]],
        };
        let mut best: Option<Choice> = None;
        for ladder in &ladders {
            let rung = first(ladder.len(), |rung| Ok(self.error(ladder[rung])? <= most))?;
            let Some(&quality) = ladder.get(rung) else { continue };
            // 64 samples everywhere are there for where nothing else will do.
            if quality == exact && best.is_some() {
                continue;
            }
            let (seconds, error) = (self.seconds(quality)?, self.error(quality)?);
            if best.as_ref().is_none_or(|best| seconds < best.seconds) {
                best = Some(Choice { quality, seconds, error, note: None });
            }
        }
        Ok(best.expect("64 samples have no error against themselves"))
    }
}

/// The first of `0..count` for which `is` says yes, given that it does for all after it; `count` if for none. By halves.
fn first(count: usize, mut is: impl FnMut(usize) -> Result<bool>) -> Result<usize> {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = (low + high) / 2;
        if is(middle)? { high = middle } else { low = middle + 1 }
    }
    Ok(low)
}

#[cfg(test)]
mod tests;
