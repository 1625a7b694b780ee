//! Pictures as data, and their drawing as SVG and PNG. This crate does not depend on any machine.
//!
//! | module | content |
//! |---|---|
//! | [`chart`] | figures of panels with axes, curves, cells and legends |
//! | [`canvas`] | lines, areas and letters, written as SVG and PNG |
//! | [`mod@print`] | figures of a width in print |
//! | [`html`] | text in HTML |

pub mod canvas;
pub mod chart;
mod draw;
pub mod html;
mod labels;
mod panel;
pub mod print;
mod scale;
mod symbols;

/// Error for a picture that cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("making {what}: {problem}")]
pub struct Error {
    /// The picture or file that was being made.
    what: &'static str,
    /// The cause.
    problem: String,
}

/// Result with this error.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Converts an error of a drawing library, for `map_err`.
    fn making<E: std::fmt::Display>(what: &'static str) -> impl Fn(E) -> Self {
        move |e| Self { what, problem: e.to_string() }
    }
}
