//! Failures as Python's exceptions: ValueError for refused arguments, RuntimeError for
//! computations without a result.

use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyMemoryError, PyRuntimeError, PyValueError};
use vibro_studies::Error;
use vibro_studies::paper::physical_parameters;

/// Reason why a computation has no result.
#[derive(Debug)]
pub enum Failure {
    /// The library refuses.
    Library(Error),
    /// One of several motions is refused.
    Motion(usize, Error),
    /// The result does not fit into memory.
    Memory,
    /// The caller has stopped waiting.
    Cancelled,
    /// The operating system refused a thread.
    Threads(String),
    /// A file could not be written or read.
    File(std::io::ErrorKind, String),
    /// A defect of the library.
    Ours(String),
}

impl Failure {
    /// Reason why one motion has no result, if the motion is the cause; otherwise the failure of
    /// the whole call.
    ///
    /// # Errors
    /// The failure of the whole call.
    pub fn reason(self) -> Result<String, Self> {
        match self {
            Self::Library(error) => Ok(words(&error)),
            other => Err(other),
        }
    }

    /// The failure of one of several motions, with the motion's index.
    pub fn of_motion(self, index: usize) -> Self {
        match self {
            Self::Library(error) => Self::Motion(index, error),
            other => other,
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Library(error)
    }
}

impl From<vibro_impact::Error> for Failure {
    fn from(error: vibro_impact::Error) -> Self {
        Self::Library(Error::Model(error))
    }
}

impl From<vibro_machine::Error> for Failure {
    fn from(error: vibro_machine::Error) -> Self {
        Self::Library(Error::Assembly(error))
    }
}

impl From<vibro_machine::Refusal> for Failure {
    fn from(refusal: vibro_machine::Refusal) -> Self {
        Self::Library(Error::Refusal(refusal))
    }
}

impl From<vibro_pack::Error> for Failure {
    fn from(error: vibro_pack::Error) -> Self {
        match &error {
            vibro_pack::Error::File { source, .. } => Self::File(source.kind(), error.to_string()),
            // The machine was checked when it was made, and the library lies in the package.
            _ => Self::Ours(error.to_string()),
        }
    }
}

impl From<vibro_figures::Error> for Failure {
    fn from(error: vibro_figures::Error) -> Self {
        Self::Ours(error.to_string())
    }
}

impl From<std::collections::TryReserveError> for Failure {
    fn from(_: std::collections::TryReserveError) -> Self {
        Self::Memory
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Library(error) => exception(has_no_answer(&error), &words(&error)),
            Failure::Motion(index, error) => {
                let message = format!("motion {index}: {}", words(&error));
                exception(has_no_answer(&error), &message)
            }
            Failure::Memory => PyMemoryError::new_err("the result does not fit into memory"),
            Failure::Cancelled => PyKeyboardInterrupt::new_err(()),
            // The kind decides which of Python's exceptions it is, such as PermissionError.
            Failure::File(kind, message) => std::io::Error::new(kind, message).into(),
            Failure::Ours(message) => PyRuntimeError::new_err(message),
            Failure::Threads(reason) => PyRuntimeError::new_err(format!("cannot start a thread: {reason}")),
        }
    }
}

/// Whether the arguments were valid and the computation found no result.
fn has_no_answer(error: &Error) -> bool {
    use vibro_impact::Error::{NoConvergence, WorkLimit};
    match error {
        Error::Model(error) => matches!(error, NoConvergence { .. } | WorkLimit { .. }),
        Error::Assembly(error) => {
            use vibro_machine::Error::{Jammed, Stuck, Violated};
            matches!(error, Jammed { .. } | Stuck { .. } | Violated { .. })
        }
        Error::NoOrbit { .. } | Error::NoPeriodicMotion { .. } | Error::Store(_) => true,
        _ => false,
    }
}

/// Message of an error; names of a described machine are not changed.
fn words(error: &Error) -> String {
    let text = error.to_string();
    match error {
        Error::Assembly(_) | Error::Refusal(_) | Error::Described { .. } => text,
        _ => in_python(&text),
    }
}

fn exception(no_answer: bool, message: &str) -> PyErr {
    if no_answer {
        PyRuntimeError::new_err(message.to_owned())
    } else {
        PyValueError::new_err(message.to_owned())
    }
}

/// Translates names of parameters, coordinates and loads in a message to Python's argument names:
/// `box_m` for `box.m`.
pub fn in_python(message: &str) -> String {
    const OTHERS: [&str; 9] = [
        "box.s",
        "block.s",
        "secondary.s",
        "box.v",
        "block.v",
        "secondary.v",
        "box.f",
        "block.f",
        "secondary.f",
    ];
    // The longest names are replaced first, so that a name that begins with a shorter name is not
    // replaced in part.
    let mut names: Vec<&str> = physical_parameters().map(|f| f.name).chain(OTHERS).collect();
    names.sort_by_key(|name| std::cmp::Reverse(name.len()));
    names.iter().fold(message.to_owned(), |text, name| text.replace(name, &name.replace('.', "_")))
}
