//! FMU archives of machines described by a text file, without a compiler: one compiled library
//! serves all machines, and the rest of an archive is generated from the machine's file.
//!
//! ```text
//! description ─▶ content (modelDescription.xml, page, terminals, pictures, file) ─┐
//!                         kit (the compiled library and its licences, kept) ──────┴─▶ archive
//! ```
//!
//! The packager `fmu-build` makes kits; the Python package contains one.
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
    Binaries, PACKED_PLATFORMS, PLATFORM, PLATFORM_TUPLE, PackedPlatform, SHARED_LIBRARY, WASM_COMPONENT,
    binary_path,
};
pub use content::{MODEL_DESCRIPTION, content, file_name, suffix, write};
pub use error::{Error, Result};
pub use kit::{KIT_FILE, Kit, LICENCE_LIST};
