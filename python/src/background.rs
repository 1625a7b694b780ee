//! Computations in a worker thread, while the calling thread handles signals and shows progress.

use crate::failure::Failure;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Interval between checks for signals, short enough that the delay after Ctrl-C is not noticed.
const POLL: Duration = Duration::from_millis(30);

/// Longest wait for the best result so far after a signal: a search ends after its running
/// simulations, which take a second for long records.
const PATIENCE: Duration = Duration::from_secs(10);

/// State shared by the computing and the waiting thread.
#[derive(Debug, Default)]
pub struct Control {
    cancelled: AtomicBool,
    done: AtomicUsize,
    /// Number of parts; 0 if the caller knows the number.
    total: AtomicUsize,
    /// Words for the current part; empty if parts are only counted.
    words: Mutex<String>,
}

impl Control {
    /// Ends a computation whose caller has stopped waiting.
    ///
    /// # Errors
    /// [`Failure::Cancelled`] if the caller has stopped waiting.
    pub fn check(&self) -> Result<(), Failure> {
        if self.is_cancelled() { Err(Failure::Cancelled) } else { Ok(()) }
    }

    /// Whether the caller has stopped waiting.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Sets the number of parts if the caller cannot know it.
    pub fn expect(&self, parts: usize) {
        self.total.store(parts, Ordering::Relaxed);
    }

    /// Sets the number of finished parts, the number of all parts, and words for the current part;
    /// returns whether the caller still waits.
    pub fn at(&self, done: usize, total: usize, words: String) -> bool {
        self.done.store(done, Ordering::Relaxed);
        self.expect(total);
        *self.words.lock().unwrap_or_else(PoisonError::into_inner) = words;
        !self.is_cancelled()
    }

    /// Counts a finished part; returns whether the caller still waits.
    pub fn goes_on(&self) -> bool {
        self.add(1);
        !self.is_cancelled()
    }

    /// Counts finished parts.
    pub fn add(&self, parts: usize) {
        self.done.fetch_add(parts, Ordering::Relaxed);
    }
}

/// Computes in another thread without Python's lock and waits for the result. `progress` is called
/// with the number of finished parts and the total (0 if the caller knows the total), and also
/// with words for the present part if there are any. An exception from a signal or from `progress`
/// ends the wait at once. The thread ends when it next checks its [`Control`], and its result is
/// dropped.
pub fn compute<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let control = Arc::new(Control::default());
    let (sender, mut receiver) = channel();
    let theirs = Arc::clone(&control);
    let work = move || {
        // After a signal the receiver is gone.
        let _ = sender.send(work(&theirs));
    };
    let thread = std::thread::Builder::new().name("vibro_impact".into()).spawn(work);
    thread.map_err(|error| Failure::Threads(error.to_string()))?;
    let report = || {
        let (done, total) = (control.done.load(Ordering::Relaxed), control.total.load(Ordering::Relaxed));
        let words = control.words.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let Some(f) = progress else { return Ok(()) };
        if words.is_empty() { f.call1((done, total)) } else { f.call1((done, total, words)) }.map(|_| ())
    };
    loop {
        let outcome;
        (outcome, receiver) = py.detach(move || (receiver.recv_timeout(POLL), receiver));
        match outcome {
            Ok(result) => {
                let result = result?;
                report()?;
                return Ok(result);
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(exception) = py.check_signals().and_then(|()| report()) {
                    control.cancelled.store(true, Ordering::Relaxed);
                    return Err(exception);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                const WORDS: &str =
                    "the computation failed because of a bug in the library; please report the lines above";
                return Err(pyo3::exceptions::PyRuntimeError::new_err(WORDS));
            }
        }
    }
}

/// Results of `each` for `count` motions by index, on all threads. The attribute `partial` of a
/// signal's exception is the list of results, with `None` for unfinished motions.
pub fn each_of<T>(
    py: Python<'_>,
    count: usize,
    progress: Option<&Bound<'_, PyAny>>,
    each: impl Fn(&Control, usize) -> Result<T, Failure> + Send + Sync + 'static,
) -> PyResult<Vec<T>>
where
    T: Clone + Send + Sync + 'static + for<'py> IntoPyObject<'py>,
{
    let slots: Arc<Vec<OnceLock<T>>> = Arc::new((0..count).map(|_| OnceLock::new()).collect());
    let theirs = Arc::clone(&slots);
    let ended = compute(py, progress, move |control| {
        let one = |index: usize| {
            let found = control.check().and_then(|()| each(control, index));
            control.add(1);
            let of_one = |failure: Failure| if count > 1 { failure.of_motion(index) } else { failure };
            let _ = theirs[index].set(found.map_err(of_one)?); // each index occurs once
            Ok(())
        };
        pool()?.install(|| (0..count).into_par_iter().try_for_each(one))
    });
    let found = || slots.iter().map(|slot| slot.get().cloned());
    ended.map_err(|error| with_partial(py, error, found().collect()))?;
    Ok(found().flatten().collect())
}

/// An error; the exception of a signal carries the results so far of each motion.
pub fn with_partial<T: for<'py> IntoPyObject<'py>>(
    py: Python<'_>,
    error: PyErr,
    found: Vec<Option<T>>,
) -> PyErr {
    if !error.is_instance_of::<PyKeyboardInterrupt>(py) {
        return error;
    }
    match error.value(py).setattr("partial", found) {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// The threads of this process for work in parallel. A process made by fork does not have its
/// parent's threads and would wait for them forever, so it gets new threads.
pub fn pool() -> Result<Arc<ThreadPool>, Failure> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, threads)) = &*pool
        && *owner == process
    {
        return Ok(Arc::clone(threads));
    }
    let made = ThreadPoolBuilder::new().build().map_err(|error| Failure::Threads(error.to_string()))?;
    let made = Arc::new(made);
    // This process cannot end its parent's threads.
    std::mem::forget(pool.replace((process, Arc::clone(&made))));
    Ok(made)
}

/// Like [`compute`], for a search that can end early: after a signal, the exception has the best
/// result so far, as parts for Python, as its attribute `partial`.
pub fn search_with_best<'py, T: Clone + Send + 'static, P: IntoPyObject<'py>>(
    py: Python<'py>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> Result<T, Failure> + Send + 'static,
    parts: impl Fn(T) -> PyResult<P>,
) -> PyResult<P> {
    let (sender, partial) = channel();
    let found = compute(py, progress, move |control| {
        let found = work(control);
        if control.is_cancelled()
            && let Ok(found) = &found
        {
            // The caller may have stopped waiting for this result too.
            let _ = sender.send(found.clone());
        }
        control.check()?;
        found
    });
    match found {
        Ok(found) => parts(found),
        Err(error) => Err(with_best(py, error, partial, parts)),
    }
}

/// An error; the exception of a signal has the best result so far as its attribute `partial`,
/// `None` if the work cannot end within [`PATIENCE`]. A second signal does not wait.
fn with_best<'py, T: Send, P: IntoPyObject<'py>>(
    py: Python<'py>,
    error: PyErr,
    mut partial: Receiver<T>,
    parts: impl Fn(T) -> PyResult<P>,
) -> PyErr {
    if !error.is_instance_of::<PyKeyboardInterrupt>(py) {
        return error;
    }
    let begin = Instant::now();
    let mut best = None;
    while begin.elapsed() < PATIENCE {
        let found;
        (found, partial) = py.detach(move || (partial.recv_timeout(POLL), partial));
        match found {
            Ok(found) => best = parts(found).ok(),
            Err(RecvTimeoutError::Timeout) if py.check_signals().is_ok() => continue,
            Err(_) => {}
        }
        break;
    }
    match error.value(py).setattr("partial", best) {
        Ok(()) => error,
        Err(other) => other,
    }
}
