//! What the command line shows: studies of the steady states, their tables and their pictures.
//!
//! ```text
//! settings (SI or groups, by name) → response, plane, compare (numbers) → figures (data of a picture) → draw → files
//! ```
//!
//! Every study is a function from [`Settings`] to plain data; printing and writing is the caller's.

mod error;
pub mod figures;
mod groups;
pub mod lyapunov;
pub mod maxima;
pub mod motion;
pub mod plane;
pub mod response;
mod settings;
pub mod studies;
pub mod table;
mod variation;
mod walk;
pub mod words;

pub use error::{Error, Result};
pub use groups::{GROUPS, Group, check_together};
pub use settings::{Name, Settings, find_group, number, short};
