//! Timing for `bench`: several pieces of work, one after the other, again and again.
//!
//! In: arms, each a function over numbered items. Out: their CPU times by repetition. All arms run once in every
//! repetition, each time from another one on, so that a machine that slows down slows all of them; the median of
//! the repetitions is the result and the fastest and slowest its spread. Only the CPU time of the thread that does
//! the work counts. Work gives a checksum, which keeps the compiler from leaving it out and must not change.

use std::ops::Range;
use std::time::Duration;

use cpu_time::ThreadTime;
use rayon::prelude::*;

use crate::error::{Error, Kind, Result};
use crate::progress::Progress;

/// One piece of work.
pub struct Arm<'a> {
    items: usize,
    /// Items that a thread takes at a time.
    block: usize,
    work: Box<dyn Fn(Range<usize>) -> u64 + Sync + 'a>,
}

/// Items that a thread takes at a time where one takes nanoseconds: reading the clock twice is nothing beside them.
pub const BLOCK: usize = 1 << 14;

impl<'a> Arm<'a> {
    /// Over each of `inputs`; `work` gives what is added to the checksum.
    pub fn each<T: Sync>(inputs: &'a [T], work: impl Fn(&T) -> u64 + Sync + 'a) -> Arm<'a> {
        let sum = move |range: Range<usize>| inputs[range].iter().fold(0, |sum: u64, x| sum.wrapping_add(work(x)));
        Arm { items: inputs.len(), block: BLOCK, work: Box::new(sum) }
    }

    /// Over each of `batches`, which stand for `length` items each, the last one maybe for less.
    pub fn batches<T: Sync>(batches: &'a [T], length: usize, work: impl Fn(&T) -> u64 + Sync + 'a) -> Arm<'a> {
        Arm { block: BLOCK / length, ..Arm::each(batches, work) }
    }

    /// Over `0..items`, where each item is work enough to be timed alone.
    pub fn pieces(items: usize, work: impl Fn(usize) -> u64 + Sync + 'a) -> Arm<'a> {
        let sum = move |range: Range<usize>| range.fold(0, |sum: u64, i| sum.wrapping_add(work(i)));
        Arm { items, block: 1, work: Box::new(sum) }
    }

    /// Over `0..items`, of which a thread takes `block` at a time; `work` does a range of them as it likes.
    pub fn ranges(items: usize, block: usize, work: impl Fn(Range<usize>) -> u64 + Sync + 'a) -> Arm<'a> {
        Arm { items, block, work: Box::new(work) }
    }

    /// How many there are.
    pub fn items(&self) -> usize {
        self.items
    }

    /// The checksum of everything once.
    pub fn sum(&self) -> u64 {
        self.pass().1
    }

    /// Everything once, on the threads of the current pool: the sum of their CPU times, and the checksum.
    fn pass(&self) -> (Duration, u64) {
        let blocks = (0..self.items.div_ceil(self.block)).into_par_iter().map(|i| {
            let range = i * self.block..self.items.min((i + 1) * self.block);
            let start = ThreadTime::now();
            let sum = (self.work)(range);
            (start.elapsed(), sum)
        });
        blocks.reduce(Default::default, |a, b| (a.0 + b.0, a.1.wrapping_add(b.1)))
    }
}

/// What came of one arm.
pub struct Times {
    /// CPU seconds of each repetition.
    pub seconds: Vec<f64>,
    /// Sum over all items, the same in every repetition.
    pub checksum: u64,
}

/// The median of repetitions, and their extremes.
#[derive(Clone, Copy)]
pub struct Spread {
    pub median: f64,
    pub min: f64,
    pub max: f64,
}

impl Spread {
    /// Of at least one number.
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Spread {
        let mut sorted: Vec<_> = numbers.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (middle, last) = (sorted.len() / 2, sorted.len() - 1);
        let median = if last % 2 == 0 { sorted[middle] } else { (sorted[middle - 1] + sorted[middle]) / 2.0 };
        Spread { median, min: sorted[0], max: sorted[last] }
    }
}

impl Times {
    /// Nanoseconds per item.
    pub fn ns(&self, items: usize) -> Spread {
        Spread::of(self.seconds.iter().map(|s| 1e9 * s / items as f64))
    }

    /// Million items per second.
    pub fn millions_per_second(&self, items: u64) -> Spread {
        Spread::of(self.seconds.iter().map(|s| items as f64 / 1e6 / s))
    }

    /// How many times as long this took as `other`: the median over the repetitions.
    pub fn ratio(&self, other: &Times) -> f64 {
        Spread::of(self.seconds.iter().zip(&other.seconds).map(|(a, b)| a / b)).median
    }
}

/// Runs all arms `repeat` times.
pub fn measure<const N: usize>(repeat: u32, arms: [Arm<'_>; N]) -> Result<[Times; N]> {
    let progress = Progress::stage("measuring", u64::from(repeat) * N as u64);
    let mut times = [(); N].map(|()| Times { seconds: Vec::new(), checksum: 0 });
    for repetition in 0..repeat as usize {
        for i in 0..N {
            let arm = (repetition + i) % N;
            let (time, checksum) = arms[arm].pass();
            let found = &mut times[arm];
            if repetition > 0 && found.checksum != checksum {
                return Err(Error::new(Kind::Failure, "the same work gave another result: this is a defect of voxdag"));
            }
            found.checksum = checksum;
            // A clock too coarse for the work must not lead to a division by zero.
            found.seconds.push(time.as_secs_f64().max(1e-9));
            progress.step();
        }
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn medians_and_extremes() {
        let Spread { median, min, max } = Spread::of([3.0, 1.0, 10.0]);
        assert_eq!((median, min, max), (3.0, 1.0, 10.0));
        assert_eq!(Spread::of([4.0, 1.0, 2.0, 3.0]).median, 2.5);
        assert_eq!(Spread::of([7.0]).median, 7.0);
    }

    #[test]
    fn every_item_is_done_once_in_every_repetition() {
        let inputs: Vec<u64> = (0..40_000).collect();
        let (done, calls) = (AtomicU64::new(0), AtomicU64::new(0));
        let each = Arm::each(&inputs, |x| {
            done.fetch_add(1, Ordering::Relaxed);
            *x
        });
        let pieces = Arm::pieces(7, |i| {
            calls.fetch_add(1, Ordering::Relaxed);
            1 << i
        });
        let ranges = Arm::ranges(40_000, 64, |range| range.map(|i| inputs[i]).sum());
        assert_eq!(ranges.sum(), 40_000 * 39_999 / 2);
        let [a, b, c] = measure(3, [each, pieces, ranges]).unwrap();
        assert_eq!((a.checksum, a.seconds.len()), (40_000 * 39_999 / 2, 3));
        assert_eq!((b.checksum, b.seconds.len()), (127, 3));
        assert_eq!((c.checksum, c.seconds.len()), (a.checksum, 3));
        assert_eq!((done.into_inner(), calls.into_inner()), (120_000, 21));
    }

    #[test]
    fn work_that_changes_its_result_is_noticed() {
        let calls = AtomicU64::new(0);
        assert!(measure(2, [Arm::pieces(1, |_| calls.fetch_add(1, Ordering::Relaxed))]).is_err());
    }

    #[test]
    fn waiting_is_not_work() {
        // A thread that sleeps uses no CPU time.
        let [slept] = measure(
            1,
            [Arm::pieces(1, |_| {
                std::thread::sleep(Duration::from_millis(200));
                0
            })],
        )
        .unwrap();
        assert!(slept.seconds[0] < 0.1, "{}", slept.seconds[0]);
    }
}
