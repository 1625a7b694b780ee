//! Ctrl-C in the course of a long study: says what is kept and how to go on.

use crate::invocation::as_typed;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::sync::{Mutex, Once};
use vibro::part_folder::{PartFolder, parts_in_words, stop_saving};

/// Exit code of a program that Ctrl-C has ended, as shells have it: 128 + SIGINT.
pub const INTERRUPTED: i32 = 130;

/// The long work that is going on.
struct InterruptedStudy {
    name: String,
    home: PathBuf,
    folders: Vec<PathBuf>,
    count: usize,
}

static WORK: Mutex<Option<InterruptedStudy>> = Mutex::new(None);
static HANDLER: Once = Once::new();

/// From now on Ctrl-C ends the program with the number of parts that are kept of `count`, which is
/// 0 where it is not known. They are in `folders`, which are `home` or are in it. Finished parts
/// are whole files already, so nothing has to be saved then.
pub fn announce(name: &str, home: PathBuf, folders: Vec<PathBuf>, count: usize) {
    if let Ok(mut work) = WORK.lock() {
        *work = Some(InterruptedStudy { name: name.into(), home, folders, count });
    }
    // Without a handler Ctrl-C ends the program as well, but without words.
    HANDLER.call_once(|| drop(ctrlc::set_handler(end)));
}

fn end() {
    let _held = stop_saving();
    let words = WORK.lock().ok().and_then(|work| work.as_ref().map(words)).unwrap_or_default();
    let mut errors = std::io::stderr();
    // The line of the progress bar ends here.
    let line = if errors.is_terminal() { "\n" } else { "" };
    // There is nobody to tell where standard error is closed.
    let _ = errors.write_all(format!("{line}{words}\n").as_bytes());
    std::process::exit(INTERRUPTED);
}

fn words(work: &InterruptedStudy) -> String {
    let kept: usize = work.folders.iter().map(|f| PartFolder::kept(f)).sum();
    format!(
        "interrupted: {} of `{}` are kept in {}; the same command line goes on from there:\n  {}",
        parts_in_words(kept, work.count, "parts"),
        work.name,
        work.home.display(),
        as_typed()
    )
}
