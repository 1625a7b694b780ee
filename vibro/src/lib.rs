//! What the command line shows: tables, figures and the report of the studies.

mod error;
pub mod figures;
pub mod html;
pub mod long_study;
pub mod parameter_file;
pub mod part_folder;
pub mod report;
pub mod studies;
pub mod table;

pub use error::{Error, Result};
