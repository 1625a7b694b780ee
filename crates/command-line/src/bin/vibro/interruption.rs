//! Ctrl-C during a computation: a long study reports the finished parts and how to continue; a
//! search ends with the best result so far.

use crate::invocation::as_typed;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once};
use vibro::part_folder::{PartFolder, parts_in_words, stop_saving};

/// Exit code of a program ended by Ctrl-C, by the convention of shells: 128 + SIGINT.
pub const INTERRUPTED: i32 = 130;

/// The long study in progress.
struct InterruptedStudy {
    name: String,
    home: PathBuf,
    folders: Vec<PathBuf>,
    count: usize,
}

static WORK: Mutex<Option<InterruptedStudy>> = Mutex::new(None);
static HANDLER: Once = Once::new();

/// Effect of a second Ctrl-C while the program still waits for unfinished work after the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Second {
    /// It has no effect.
    Waits,
    /// It ends the program, and nothing is written.
    Ends,
}

/// From now on Ctrl-C sets the returned flag; a computation then ends early with its results.
pub fn flag(second: Second) -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let asked = flag.clone();
    // Without a handler Ctrl-C ends the program too, but nothing is written.
    drop(ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) && second == Second::Ends {
            std::process::exit(INTERRUPTED);
        }
    }));
    flag
}

/// From now on Ctrl-C ends the program and prints how many of `count` parts are finished; 0 means
/// an unknown count. `folders` contain the parts; each folder is `home` or lies in it. Finished
/// parts are complete files, so nothing has to be saved at that time.
pub fn announce(name: &str, home: PathBuf, folders: Vec<PathBuf>, count: usize) {
    if let Ok(mut work) = WORK.lock() {
        *work = Some(InterruptedStudy { name: name.into(), home, folders, count });
    }
    // Without a handler Ctrl-C ends the program too, but prints nothing.
    HANDLER.call_once(|| drop(ctrlc::set_handler(end)));
}

fn end() {
    let _held = stop_saving();
    let words = WORK.lock().ok().and_then(|work| work.as_ref().map(words)).unwrap_or_default();
    let mut errors = std::io::stderr();
    // Ends the line of the progress bar.
    let line = if errors.is_terminal() { "\n" } else { "" };
    // Standard error may be closed.
    let _ = errors.write_all(format!("{line}{words}\n").as_bytes());
    std::process::exit(INTERRUPTED);
}

fn words(work: &InterruptedStudy) -> String {
    let kept: usize = work.folders.iter().map(|f| PartFolder::kept(f)).sum();
    format!(
        "interrupted: {} of `{}` are kept in {}; the same command line continues from there:\n  {}",
        parts_in_words(kept, work.count, "parts"),
        work.name,
        work.home.display(),
        as_typed()
    )
}
