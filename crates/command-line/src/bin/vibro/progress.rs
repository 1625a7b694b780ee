//! Progress on the terminal for work of more than a second: a bar if steps are counted, otherwise
//! the elapsed time.

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender};
use std::sync::{Mutex, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time before a bar is shown.
const PATIENCE: Duration = Duration::from_secs(1);
/// Unit of work that is a length of time.
pub const TIME: &str = "s";
/// Steps of a bar over a length of time.
const PARTS: f64 = 1e6;
/// Interval at which a clock is drawn, and shortest interval between two shown fractions.
const TICK: Duration = Duration::from_millis(250);

/// Value of [`Progress::told`] before a fraction is shown.
const NEVER: u64 = u64::MAX;

/// The clock of the command, while it is on the terminal, and the number of bars there.
static TERMINAL: Mutex<Terminal> = Mutex::new(Terminal { clock: None, bars: 0 });

struct Terminal {
    clock: Option<ProgressBar>,
    bars: usize,
}

/// Shows the elapsed time of a command after [`PATIENCE`], until it is dropped. It is hidden while
/// bars are shown, so that no command is silent before, between or after bars.
pub struct Clock {
    over: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Clock {
    /// The clock of a command that begins now.
    pub fn start() -> Self {
        // It is hidden if standard error is not a terminal.
        Self::onto(ProgressDrawTarget::stderr, PATIENCE)
    }

    fn onto(target: impl Fn() -> ProgressDrawTarget + Send + 'static, patience: Duration) -> Self {
        let (begin, (over, ended)) = (Instant::now(), std::sync::mpsc::channel::<()>());
        let thread = std::thread::spawn(move || {
            let mut wait = patience;
            while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                wait = TICK;
                let Ok(mut terminal) = TERMINAL.lock() else { return };
                if terminal.bars == 0 {
                    let clock =
                        || ProgressBar::with_draw_target(None, target()).with_style(style("{msg} elapsed"));
                    let gone = Duration::from_secs(begin.elapsed().as_secs());
                    terminal.clock.get_or_insert_with(clock).set_message(HumanDuration(gone).to_string());
                }
            }
        });
        Self { over: Some(over), thread: Some(thread) }
    }
}

impl Drop for Clock {
    fn drop(&mut self) {
        drop(self.over.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        clear();
    }
}

/// Takes the clock off the terminal before something is printed. The clock reappears at its next
/// tick.
pub fn clear() {
    if let Ok(mut terminal) = TERMINAL.lock() {
        terminal.clock.take().into_iter().for_each(|clock| clock.finish_and_clear());
    }
}

fn style(form: &str) -> ProgressStyle {
    ProgressStyle::with_template(form).unwrap_or_else(|_| ProgressStyle::default_spinner())
}

/// Counts steps, and shows a bar after [`PATIENCE`].
pub struct Progress {
    begin: Instant,
    patience: Duration,
    total: u64,
    unit: &'static str,
    done: AtomicU64,
    /// When a fraction was last shown, ms after the beginning.
    told: AtomicU64,
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
            told: AtomicU64::new(NEVER),
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

    /// Sets the completed fraction, from 0 to 1, of work that is a length of time. It may be
    /// called at every event of a motion.
    pub fn part(&self, part: f64) {
        self.described(part, &|| format!("{part:.3e} of all"), "left");
    }

    /// Sets the completed fraction, from 0 to 1, with words for it. `left` names the remaining
    /// time, such as "left at most".
    pub fn described(&self, part: f64, words: &dyn Fn() -> String, left: &str) {
        let gone = self.begin.elapsed();
        let since = (gone.as_millis() as u64).saturating_sub(self.told.load(Ordering::Relaxed));
        let is_due = self.told.load(Ordering::Relaxed) == NEVER || since >= TICK.as_millis() as u64;
        if gone > self.patience && is_due {
            // The first estimate of the time left is shown at once.
            if part > 0.0 {
                self.told.store(gone.as_millis() as u64, Ordering::Relaxed);
            }
            let bar = self.bar.get_or_init(|| self.bar());
            bar.set_length(PARTS as u64);
            bar.set_position((part * PARTS) as u64);
            let rest = gone.as_secs_f64() * (1.0 - part) / part;
            let rest = match Duration::try_from_secs_f64(rest) {
                Ok(rest) => format!(", {} {left}", HumanDuration(rest)),
                // Nothing is completed yet.
                Err(_) => String::new(),
            };
            bar.set_message(words() + &rest);
        }
    }

    fn bar(&self) -> ProgressBar {
        let target = self.target.lock().ok().and_then(|mut t| t.take());
        clear();
        if let Ok(mut terminal) = TERMINAL.lock() {
            terminal.bars += 1;
        }
        let bar =
            ProgressBar::with_draw_target(Some(self.total), target.unwrap_or(ProgressDrawTarget::hidden()));
        bar.set_style(style(&match self.unit {
            TIME => "{bar:40} {elapsed} elapsed, {msg}".into(),
            unit => format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{eta}} left"),
        }));
        // The elapsed time of the bar is redrawn even while no step ends.
        bar.enable_steady_tick(TICK);
        bar
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
            if let Ok(mut terminal) = TERMINAL.lock() {
                terminal.bars -= 1;
            }
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

    /// Waits until the terminal shows the expected text: a bar is drawn by its own thread.
    fn wait(terminal: &InMemoryTerm, is_met: impl Fn(&str) -> bool) {
        /// Longest wait, a few hundred ticks: other tests use the processor.
        const LONGEST: Duration = Duration::from_secs(60);
        let begin = Instant::now();
        while !is_met(&terminal.contents()) {
            assert!(begin.elapsed() < LONGEST, "{}", terminal.contents());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    #[test]
    fn a_terminal_shows_count_and_time_left_and_is_left_clean() {
        let (terminal, progress) = after(3, Duration::ZERO);
        // Steps are drawn a few times a second at most.
        wait(&terminal, |shown| shown.contains("3/8 parts") && shown.ends_with("left"));
        drop(progress);
        assert_eq!(terminal.contents(), "");
    }

    #[test]
    fn a_command_without_steps_shows_the_time_gone_and_gives_way_to_a_bar() {
        let terminal = InMemoryTerm::new(10, 100);
        let own = terminal.clone();
        let onto = move || ProgressDrawTarget::term_like(Box::new(own.clone()));
        let clock = Clock::onto(onto, Duration::ZERO);
        wait(&terminal, |shown| shown.contains("seconds elapsed"));
        let (other, progress) = after(3, Duration::ZERO);
        wait(&terminal, str::is_empty);
        wait(&other, |shown| shown.contains("3/8 parts"));
        drop(progress);
        wait(&terminal, |shown| shown.contains("elapsed"));
        drop(clock);
        assert_eq!(terminal.contents(), "");
    }

    #[test]
    fn a_length_of_time_shows_how_much_is_left() {
        let terminal = InMemoryTerm::new(10, 120);
        let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
        let progress = Progress::onto(target, Duration::ZERO, 0, TIME);
        // Like a study of many samples: most calls only read the time.
        (0..1_000_000).for_each(|k| progress.part(f64::from(k) * 1e-6));
        wait(&terminal, |shown| shown.contains("of all") && shown.contains("left"));
    }

    #[test]
    fn described_work_shows_its_words_and_a_time_left_once_some_is_completed() {
        let terminal = InMemoryTerm::new(10, 120);
        let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
        let progress = Progress::onto(target, Duration::ZERO, 0, TIME);
        progress.described(0.0, &|| "attempt 1".into(), "left at most");
        wait(&terminal, |shown| shown.ends_with("attempt 1"));
        // The next fraction is shown a tick later.
        std::thread::sleep(TICK);
        progress.described(0.5, &|| "attempt 2".into(), "left at most");
        wait(&terminal, |shown| shown.contains("attempt 2") && shown.ends_with("left at most"));
    }

    #[test]
    fn a_total_may_grow() {
        let (terminal, progress) = after(0, Duration::ZERO);
        progress.at(2, 5);
        progress.at(3, 40);
        wait(&terminal, |shown| shown.contains("3/40 parts"));
    }

    #[test]
    fn short_work_shows_nothing() {
        let (terminal, _progress) = after(8, Duration::from_secs(3600));
        assert_eq!(terminal.contents(), "");
    }
}
