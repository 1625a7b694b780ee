//! Writes the files that hosts need in addition to the library of the bouncing ball:
//! `modelDescription.xml` of both versions, in folders with the layout of the archives. After the
//! library has been added to `binaries/`, each zipped folder is an FMU.
//!
//! `cargo run --example describe FOLDER`

#[path = "bouncing_ball/ball.rs"]
mod ball;

use fmi_doors::Version;
use fmi_doors::tabular::FromTable;
use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".to_owned());
    for (name, version) in [("fmi2", Version::Fmi2), ("fmi3", Version::Fmi3)] {
        let folder = Path::new(&folder).join(name);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(
            folder.join("modelDescription.xml"),
            FromTable::<ball::Ball>::description().xml(version),
        )?;
    }
    Ok(())
}
