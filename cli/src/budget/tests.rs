//! The choice, on machines whose times and errors are known.

use super::*;
use crate::options::{ArithmeticArg, NormalsArg};

const RANGE: Range = Range { usual: USUAL, size: [400, 300], depth: 9 };
const USUAL: Quality = Quality {
    samples: Samples::Four,
    supersample: SupersampleArg::All,
    normals: NormalsArg::Face,
    arithmetic: ArithmeticArg::F64,
    lod: 0,
};

/// The part of the picture that a region is.
fn part([x0, y0, x1, y1]: [u32; 4]) -> f64 {
    f64::from((x1 - x0) * (y1 - y0)) / 120_000.0
}

/// One sample takes a second, others what they cost beside it; `scale` times that.
struct Known {
    scale: f64,
    /// What a careful measurement finds beside a quick one.
    bias: f64,
    asked: Vec<Quality>,
}

impl Known {
    fn cost(quality: Quality) -> f64 {
        let count = f64::from(quality.samples.count());
        match quality.supersample {
            SupersampleArg::Region(corners) => 1.0 + 3.0 * part(corners),
            SupersampleArg::Adaptive(degrees) => 4.0 + (count - 4.0) * (0.1 + 0.4 / (1.0 + f64::from(degrees) / 9.0)),
            _ => count * libm::pow(0.8, quality.lod.into()),
        }
    }

    fn error_of(quality: Quality) -> f64 {
        match quality.supersample {
            SupersampleArg::Region(corners) => 0.02 - 0.015 * part(corners),
            SupersampleArg::Adaptive(degrees) => {
                let best = if quality.samples == Samples::Sixteen { 0.002 } else { 0.0005 };
                best + 0.003 * f64::from(degrees) / 90.0
            }
            _ if quality.samples == Samples::SixtyFour => 0.0,
            _ => 0.02 * (1.0 + f64::from(quality.lod)) / f64::from(quality.samples.count()),
        }
    }
}

impl Ruler for Known {
    fn seconds(&mut self, quality: Quality, effort: f64) -> Result<f64> {
        self.asked.push(quality);
        let bias = if effort > 0.1 { self.bias } else { 1.0 };
        Ok(self.scale * bias * Known::cost(quality))
    }

    fn error(&mut self, quality: Quality, _: f64) -> Result<f64> {
        Ok(Known::error_of(quality))
    }
}

fn chosen(goal: Goal, scale: f64, bias: f64) -> (Choice, usize) {
    let mut known = Known { scale, bias, asked: Vec::new() };
    let choice = choose(&mut known, goal, RANGE).unwrap();
    (choice, known.asked.len())
}

#[test]
fn budgets_are_met_by_what_is_most_accurate() {
    let mut last = f64::INFINITY;
    // From the cheapest to the dearest setting, but for where the ladders have no rung: see below.
    for step in 0..200 {
        let budget = 1.1 * libm::pow(1.02, step.into());
        let (choice, asked) = chosen(Goal::Seconds(budget), 1.0, 1.0);
        let exact = Known::cost(choice.quality);
        assert_eq!((choice.seconds, choice.error), (exact, Known::error_of(choice.quality)));
        assert!(exact <= budget, "{budget}: {choice:?}");
        assert!(choice.note.is_some() == (exact < 0.8 * budget), "{budget}: {choice:?}");
        assert!(choice.error <= last * 1.000_001, "{budget}: more time, and less accurate: {choice:?}");
        assert!(asked <= 40, "{asked} measurements");
        last = choice.error;
        // No rung of any ladder that fits would have been better by more than a little.
        for quality in [Samples::Sixteen, Samples::SixtyFour].into_iter().flat_map(|s| RANGE.fine(s)) {
            if Known::cost(quality) <= 0.9 * budget {
                assert!(Known::error_of(quality) >= choice.error - 1e-9, "{budget}: {choice:?}, not {quality:?}");
            }
        }
    }
}

#[test]
fn what_quick_measurements_get_wrong_is_made_good() {
    for bias in [0.7, 0.85, 1.2, 1.4] {
        for budget in [1.9, 2.5, 3.5, 20.0, 25.0] {
            let (choice, _) = chosen(Goal::Seconds(budget), 1.0, bias);
            let off = choice.seconds / budget;
            assert!((0.79..=1.0).contains(&off), "{bias}, {budget}: {off}, {choice:?}");
        }
    }
}

#[test]
fn coarser_voxels_where_one_sample_takes_too_long() {
    let (choice, _) = chosen(Goal::Seconds(0.7), 1.0, 1.0);
    let Quality { samples, lod, normals, arithmetic, .. } = choice.quality;
    assert_eq!((lod, samples, normals, arithmetic), (2, Samples::One, USUAL.normals, USUAL.arithmetic));
    let (choice, _) = chosen(Goal::Seconds(0.1), 1.0, 1.0);
    assert_eq!(choice.quality.lod, COARSEST);
    assert!(choice.note.unwrap().contains("the cheapest setting takes 410 ms"));
}

#[test]
fn more_time_than_can_be_used_is_said() {
    let (choice, _) = chosen(Goal::Seconds(1000.0), 1.0, 1.0);
    assert_eq!(choice.quality.supersample, SupersampleArg::Adaptive(0.0));
    assert_eq!(choice.quality.samples, Samples::SixtyFour);
    assert!(choice.note.unwrap().contains("the most accurate setting takes only 34.0 s"));
}

#[test]
fn errors_are_reached_by_what_is_cheapest() {
    let mut last = 0.0;
    for most in [1.0, 0.07, 0.03, 0.02, 0.018, 0.014, 0.006, 0.005, 0.0045, 0.003, 0.0021, 0.002, 0.001] {
        let (choice, _) = chosen(Goal::Error(most), 0.01, 1.0);
        assert!(choice.error <= most, "{most}: {choice:?}");
        assert!(choice.seconds >= last, "{most}: cheaper, and more accurate: {choice:?}");
        last = choice.seconds;
        let ladders = [Samples::Sixteen, Samples::SixtyFour].into_iter().flat_map(|s| RANGE.fine(s));
        for quality in ladders.chain(RANGE.coarse()) {
            if Known::error_of(quality) <= most {
                assert!(0.01 * Known::cost(quality) >= choice.seconds - 1e-9, "{most}: {choice:?}, not {quality:?}");
            }
        }
    }
}

#[test]
fn ladders_climb_on_pictures_of_any_size() {
    for size in [[1, 1], [1, 2], [3, 1], [2, 7], [32768, 32768]] {
        let range = Range { size, depth: 1, ..RANGE };
        assert_eq!(range.coarse().len(), 2);
        let mut last = 0.0;
        for quality in range.fine(Samples::Sixteen) {
            let SupersampleArg::Region([x0, y0, x1, y1]) = quality.supersample else { continue };
            assert!(x0 < x1 && y0 < y1 && x1 <= size[0] && y1 <= size[1], "{size:?}: {quality:?}");
            let area = f64::from(x1 - x0) * f64::from(y1 - y0);
            assert!(area >= last, "{size:?}: {quality:?}");
            last = area;
        }
    }
}
