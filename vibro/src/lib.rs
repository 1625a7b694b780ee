//! What the command line shows: tables, figures and the report of the studies.

pub mod figures;
pub mod report;
pub mod studies;
pub mod table;
pub mod words;
pub mod work;
