//! Numbered pieces of work on all threads, handed over in order, with few of them in memory at a time.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc;

/// Does `work(0)`, `work(1)`, .. `work(count - 1)` on the threads of the current rayon pool and lends `consume` an iterator
/// over the results in that order. At most two pieces a thread are begun or wait at any time; the consumer's thread works
/// too while it waits.
pub fn in_order<T: Send, R: Send>(
    count: usize,
    work: impl Fn(usize) -> T + Sync,
    consume: impl FnOnce(&mut dyn Iterator<Item = T>) -> R + Send,
) -> R {
    let threads = rayon::current_num_threads();
    if threads == 1 {
        return consume(&mut (0..count).map(work));
    }
    let work = &work;
    rayon::scope_fifo(|scope| {
        let (send, receive) = mpsc::channel();
        let (mut begun, mut wanted) = (0, 0);
        let mut early = BTreeMap::new();
        let mut results = std::iter::from_fn(|| {
            if wanted == count {
                return None;
            }
            // Begin new pieces, but never run far ahead of the consumer.
            while begun < count.min(wanted + 2 * threads) {
                let (send, index) = (send.clone(), begun);
                scope.spawn_fifo(move |_| {
                    // A panic travels to the consumer, which would otherwise wait for ever.
                    let result = catch_unwind(AssertUnwindSafe(|| work(index)));
                    // The consumer may have given up; then nobody wants the result.
                    let _ = send.send((index, result));
                });
                begun += 1;
            }
            // Take what is done, work along while there is work, and otherwise wait for another thread.
            loop {
                early.extend(receive.try_iter());
                if let Some(result) = early.remove(&wanted) {
                    wanted += 1;
                    return Some(result.unwrap_or_else(|panic| resume_unwind(panic)));
                }
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    early.extend(receive.recv());
                }
            }
        });
        consume(&mut results)
    })
}

#[cfg(test)]
mod tests {
    use super::in_order;

    #[test]
    #[should_panic = "piece 3"]
    fn a_panic_reaches_the_consumer() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let work = |i: usize| assert!(i != 3, "piece {i}");
        pool.install(|| in_order(9, work, |results| results.count()));
    }

    #[test]
    fn results_come_in_order_on_any_number_of_threads_and_may_be_left() {
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let slow_when_even = |i: usize| {
                if i.is_multiple_of(2) {
                    std::thread::sleep(std::time::Duration::from_micros(300));
                }
                i * i
            };
            let all: Vec<_> = pool.install(|| in_order(50, slow_when_even, |it| it.collect()));
            assert_eq!(all, (0..50).map(|i| i * i).collect::<Vec<_>>());
            let some: Vec<_> = pool.install(|| in_order(50, slow_when_even, |it| it.take(3).collect()));
            assert_eq!(some, [0, 1, 4]);
        }
    }
}
