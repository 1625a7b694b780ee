//! Packs the vibro-impact library into `VibroImpact3DOF.fmu` (FMI 2.0) and
//! `VibroImpact3DOF-FMI3.fmu`, runs them and draws what happened.
//!
//! ```text
//!         table (vibro_paper_component) ─▶ check (xml) ───────┐
//!  page (recipes), icon, terminals, reference ───┼─▶ package (version) ─▶ archive ─▶ .fmu
//!          platforms (compile), licences, date ──┘                                     │
//!         table ◀─ run (host: the packaged binaries; native library) ◀─────────────────┘
//!       picture ◀──┘
//! explorer (a nested cargo runs web-build) ─▶ the live page in package, where asked for
//! assembly: a user's own machine (vibro_pack), by a library that serves all (kit) ─▶ .fmu
//! release: all of it with the Python package (maturin), checked (inspect), in one folder
//! ```

pub mod assembly;
pub mod check;
pub mod compile;
pub mod date;
mod error;
pub mod explorer;
pub mod host;
pub mod icon;
pub mod inspect;
pub mod kit;
pub mod licences;
pub mod package;
pub mod page;
pub mod picture;
pub mod platforms;
pub mod recipes;
pub mod reference;
pub mod release;
pub mod run;
pub mod sketch;
pub mod table;
pub mod terminals;
pub mod version;
pub mod xml;

pub use error::{Error, Result};
pub use vibro_pack::archive;
