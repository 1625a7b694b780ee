//! A progress bar on the terminal for work that takes longer than a second.

use indicatif::{ProgressBar, ProgressStyle};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Shorter work shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Counts steps; shows them after [`PATIENCE`].
pub struct Progress {
    begin: Instant,
    total: u64,
    unit: &'static str,
    done: AtomicU64,
    bar: OnceLock<ProgressBar>,
}

impl Progress {
    /// Over so many steps.
    pub fn new(total: usize, unit: &'static str) -> Self {
        let done = AtomicU64::new(0);
        Self { begin: Instant::now(), total: total as u64, unit, done, bar: OnceLock::new() }
    }

    /// One more is done.
    pub fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if self.begin.elapsed() > PATIENCE {
            self.bar.get_or_init(|| self.bar()).set_position(done);
        }
    }

    fn bar(&self) -> ProgressBar {
        // Hidden by itself where standard error is no terminal.
        let bar = ProgressBar::new(self.total);
        let form = format!("{{bar:40}} {{pos}}/{{len}} {}, {{eta}} left", self.unit);
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
