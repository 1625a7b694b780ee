//! Progress bar on the terminal for work of more than a second.

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time before a bar is shown.
const PATIENCE: Duration = Duration::from_secs(1);
/// Unit of work that is a length of time.
pub const TIME: &str = "s";
/// Steps of a bar over a length of time.
const PARTS: f64 = 1e6;
/// Interval at which the clock is drawn.
const TICK: Duration = Duration::from_millis(250);

/// Counts steps, and shows a bar after [`PATIENCE`].
pub struct Progress {
    begin: Instant,
    patience: Duration,
    total: u64,
    unit: &'static str,
    done: AtomicU64,
    bar: OnceLock<ProgressBar>,
    target: Mutex<Option<ProgressDrawTarget>>,
}

impl Progress {
    /// A bar over `total` steps.
    pub fn new(total: usize, unit: &'static str) -> Self {
        // The bar is hidden if standard error is not a terminal.
        Self::onto(ProgressDrawTarget::stderr(), PATIENCE, total, unit)
    }

    fn onto(target: ProgressDrawTarget, patience: Duration, total: usize, unit: &'static str) -> Self {
        Self {
            begin: Instant::now(),
            patience,
            total: total as u64,
            unit,
            done: AtomicU64::new(0),
            bar: OnceLock::new(),
            target: Mutex::new(Some(target)),
        }
    }

    /// Counts one more step.
    pub fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if self.begin.elapsed() > self.patience {
            self.bar.get_or_init(|| self.bar()).set_position(done);
        }
    }

    /// Sets the steps done and their total, which may grow.
    pub fn at(&self, done: usize, total: usize) {
        if self.begin.elapsed() > self.patience {
            let bar = self.bar.get_or_init(|| self.bar());
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        }
    }

    /// Sets the completed fraction, from 0 to 1, of work that is a length of time.
    pub fn part(&self, part: f64) {
        if self.begin.elapsed() > self.patience {
            let bar = self.bar.get_or_init(|| self.bar());
            bar.set_length(PARTS as u64);
            bar.set_position((part * PARTS) as u64);
            let left = self.begin.elapsed().as_secs_f64() * (1.0 - part) / part;
            let left = Duration::try_from_secs_f64(left).map_or(Duration::MAX, |time| time);
            bar.set_message(format!("{:.3e} of all, {} left", part, HumanDuration(left)));
        }
    }

    /// Keeps the clock running while no step ends.
    pub fn ticking(self) -> Ticking {
        let progress = Arc::new(self);
        let (over, ended) = std::sync::mpsc::channel::<()>();
        let shown = progress.clone();
        let thread = std::thread::spawn(move || {
            if ended.recv_timeout(shown.patience) == Err(RecvTimeoutError::Timeout) {
                shown.bar.get_or_init(|| shown.bar()).enable_steady_tick(TICK);
            }
        });
        Ticking { progress, over: Some(over), thread: Some(thread) }
    }

    fn bar(&self) -> ProgressBar {
        let target = self.target.lock().ok().and_then(|mut t| t.take());
        let bar =
            ProgressBar::with_draw_target(Some(self.total), target.unwrap_or(ProgressDrawTarget::hidden()));
        let form = match self.unit {
            TIME => "{bar:40} {elapsed} gone {msg}".into(),
            unit => format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{eta}} left"),
        };
        if let Ok(style) = ProgressStyle::with_template(&form) {
            bar.set_style(style);
        }
        bar
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

/// A [`Progress`] whose clock runs on the terminal.
pub struct Ticking {
    progress: Arc<Progress>,
    over: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl std::ops::Deref for Ticking {
    type Target = Progress;

    fn deref(&self) -> &Progress {
        &self.progress
    }
}

impl Drop for Ticking {
    fn drop(&mut self) {
        drop(self.over.take());
        // The bar is removed with the last of the two.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::InMemoryTerm;

    fn after(steps: usize, patience: Duration) -> (InMemoryTerm, Progress) {
        let terminal = InMemoryTerm::new(10, 100);
        let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
        let progress = Progress::onto(target, patience, 8, "parts");
        (0..steps).for_each(|_| progress.step());
        (terminal, progress)
    }

    #[test]
    fn a_terminal_shows_count_and_time_left_and_is_left_clean() {
        let (terminal, progress) = after(3, Duration::ZERO);
        // The first step is drawn at once; later ones a few times a second at most.
        progress.bar.get().expect("a bar").tick();
        let shown = terminal.contents();
        assert!(shown.contains("3/8 parts") && shown.ends_with("left"), "{shown}");
        drop(progress);
        assert_eq!(terminal.contents(), "");
    }

    #[test]
    fn a_step_that_does_not_end_shows_its_clock() {
        let terminal = InMemoryTerm::new(10, 100);
        let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
        let progress = Progress::onto(target, Duration::ZERO, 0, TIME).ticking();
        let begin = Instant::now();
        while progress.bar.get().is_none() || !terminal.contents().contains("0s gone") {
            assert!(begin.elapsed() < Duration::from_secs(60), "{}", terminal.contents());
            std::thread::sleep(Duration::from_millis(10));
        }
        drop(progress);
        assert_eq!(terminal.contents(), "");
    }

    #[test]
    fn a_total_may_grow() {
        let (terminal, progress) = after(0, Duration::ZERO);
        progress.at(2, 5);
        progress.at(3, 40);
        progress.bar.get().expect("a bar").tick();
        assert!(terminal.contents().contains("3/40 parts"), "{}", terminal.contents());
    }

    #[test]
    fn short_work_shows_nothing() {
        let (terminal, _progress) = after(8, Duration::from_secs(3600));
        assert_eq!(terminal.contents(), "");
    }
}
