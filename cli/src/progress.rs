//! How far the work is: a line on stderr, only on a terminal, only for work of more than a second; after ten seconds
//! also how long it will still take.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

const SHOW_AFTER: Duration = Duration::from_secs(1);
const ESTIMATE_AFTER: Duration = Duration::from_secs(10);
const TICK: Duration = Duration::from_millis(100);

/// Whether a stage is under way: those that begin within it stay silent.
static UNDER_WAY: AtomicBool = AtomicBool::new(false);

/// One stage of the work. The line disappears when it is dropped.
pub struct Progress {
    bar: ProgressBar,
    outermost: bool,
    done: Arc<AtomicBool>,
    ticker: Option<JoinHandle<()>>,
}

impl Progress {
    /// Starts a stage of `total` steps; 0 where nobody can count them.
    pub fn stage(name: &'static str, total: u64) -> Progress {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let done = Arc::new(AtomicBool::new(false));
        let outermost = !UNDER_WAY.swap(true, Ordering::AcqRel);
        let ticker = (outermost && std::io::stderr().is_terminal()).then(|| {
            let (bar, done) = (bar.clone(), done.clone());
            std::thread::spawn(move || tick(name, total, &bar, &done))
        });
        Progress { bar, outermost, done, ticker }
    }

    /// Says what the work is about right now.
    pub fn say(&self, what: String) {
        self.bar.set_message(what);
    }

    /// Counts several steps.
    pub fn steps(&self, count: u64) {
        self.bar.inc(count);
    }

    /// Counts one step; any thread may call it.
    pub fn step(&self) {
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Release);
        if let Some(ticker) = self.ticker.take() {
            ticker.thread().unpark();
            let _ = ticker.join();
        }
        self.bar.finish_and_clear();
        if self.outermost {
            UNDER_WAY.store(false, Ordering::Release);
        }
    }
}

/// Shows the line when its time has come and keeps it moving until the stage is over.
fn tick(name: &str, total: u64, bar: &ProgressBar, done: &AtomicBool) {
    let start = Instant::now();
    let (mut shown, mut estimated) = (false, false);
    while !done.load(Ordering::Acquire) {
        if !shown && start.elapsed() >= SHOW_AFTER {
            bar.set_style(style(name, total, ""));
            bar.set_draw_target(ProgressDrawTarget::stderr());
            shown = true;
        }
        if !estimated && total > 0 && start.elapsed() >= ESTIMATE_AFTER {
            bar.set_style(style(name, total, ", about {eta} left"));
            estimated = true;
        }
        if shown {
            bar.tick();
        }
        std::thread::park_timeout(TICK);
    }
}

fn style(name: &str, total: u64, estimate: &str) -> ProgressStyle {
    let template = if total == 0 {
        format!("{name} {{msg}} {{spinner}} {{elapsed}}")
    } else {
        format!("{name} {{msg}} [{{bar:30}}] {{percent}} %, {{elapsed}}{estimate}")
    };
    // A template that indicatif cannot read would only cost the progress line its looks.
    ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ")
}
