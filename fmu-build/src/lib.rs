//! Packs the vibro-impact library into `VibroImpact3DOF.fmu`, runs it and draws what happened.
//!
//! ```text
//! table (vibro_fmi::fmi2) ─▶ describe ─▶ check ─┐
//!             page (recipes), icon, sketch ────────┼─▶ package ─▶ archive ─▶ .fmu
//!                    platforms (compile), licences ─┘                          │
//!                 table ◀─ run (host: the packaged binary; native library) ◀──┘
//!               picture ◀──┘
//! ```

pub mod archive;
pub mod check;
pub mod compile;
pub mod describe;
mod error;
pub mod host;
pub mod icon;
pub mod licences;
pub mod package;
pub mod page;
pub mod picture;
pub mod platforms;
pub mod recipes;
pub mod run;
pub mod schema;
pub mod sketch;
pub mod table;

pub use error::{Error, Result};
