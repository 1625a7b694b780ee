//! Library of the command line `vibro`: studies with their tables and figures, the report, and the
//! files that are read and written.
//!
//! | module | content |
//! |---|---|
//! | [`studies`] | from a parameter set to tables and a figure, one function per study |
//! | [`long_study`] | long studies as plain data, computed in parts |
//! | [`machine`] | the user's own machines, from their files |
//! | [`table`] | tables as CSV |
//! | [`manifest`] | the inputs of a result or of a folder of parts |
//! | [`report`] | all studies at once, and the paper's statements with the results |
//! | [`parameter_file`] | parameter files |
//! | [`design_file`] | designs of a sweep from a CSV file |
//! | [`special_points`] | special points of branches from their table |
//! | [`part_folder`] | finished parts of long studies on disk |
//! | [`whole_file`] | files that are complete or absent |
//! | [`wording`] | names and units in pictures, in words |

pub mod design_file;
mod error;
pub mod gallery;
mod kept_branches;
pub mod load_file;
pub mod long_study;
pub mod machine;
pub mod manifest;
pub mod parameter_file;
pub mod part_folder;
pub mod report;
pub mod special_points;
pub mod studies;
pub mod subject;
pub mod table;
pub mod whole_file;
pub mod wording;

pub use error::{Error, Result};
