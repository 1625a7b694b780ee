//! FMU archives of machines that a text file describes, without a compiler: one compiled library
//! serves all machines, and all else in an archive follows from the machine's file.
//!
//! ```text
//! description ─▶ content (modelDescription.xml, page, terminals, pictures, file) ─┐
//!                         kit (the compiled library and its licences, kept) ──────┴─▶ archive
//! ```
//!
//! The packager `fmu-build` makes kits; the Python package holds one.
#![forbid(unsafe_code)]

pub mod archive;
mod around;
mod binaries;
mod content;
mod error;
mod kit;
mod page;
pub mod reference;
mod terminals;

pub use archive::Content;
pub use around::{around, platforms_of};
pub use binaries::{
    Binaries, PACKED_PLATFORMS, PLATFORM, PLATFORM_TUPLE, PackedPlatform, SHARED_LIBRARY, binary_path,
};
pub use content::{MODEL_DESCRIPTION, content, file_name, suffix, write};
pub use error::{Error, Result};
pub use kit::{KIT_FILE, Kit, LICENCE_LIST};
